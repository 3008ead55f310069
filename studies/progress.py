"""Progress of the studies: the current computation, and the part that is done."""

from collections.abc import Iterable, Iterator
from typing import TypeVar

from frictopt.base import progress_bar

T = TypeVar("T")


def each(things: Iterable[T], what: str) -> Iterator[T]:
    """The things one by one, while a bar or lines show how many are done."""
    known = list(things)
    with progress_bar(True, what, total=len(known)) as bar:
        for thing in known:
            yield thing
            bar.update()
