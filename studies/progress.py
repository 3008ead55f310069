"""Progress of the studies: what is computed, and how far it is."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from frictopt.base import progress_bar

T = TypeVar("T")


def each(things: Iterable[T], what: str) -> Iterator[T]:
    """Each of these things, while a bar or lines say how many are done."""
    known = list(things)
    with progress_bar(True, what, total=len(known)) as bar:
        for thing in known:
            yield thing
            bar.update()
