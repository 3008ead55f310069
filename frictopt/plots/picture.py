"""One function that draws any result; each kind of result registers its own picture."""

from dataclasses import dataclass
from functools import singledispatch
from typing import Any

__all__ = ["Runs", "picture"]


@dataclass(frozen=True, eq=False)
class Runs:
    """The table of a study, so that it has a kind of its own."""

    table: Any


@singledispatch
def picture(result: Any, ax: Any = None) -> Any:
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")
