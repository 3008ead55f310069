"""One function that draws any result; each kind of result registers its own picture."""

from functools import singledispatch
from typing import Any

__all__ = ["picture"]


@singledispatch
def picture(result: Any, ax: Any = None) -> Any:
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")
