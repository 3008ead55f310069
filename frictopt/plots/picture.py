"""One function that draws any result; each kind of result registers its own picture."""

from functools import singledispatch
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

    from .style import AxesArray


@singledispatch
def picture(result: object, ax: "Axes | AxesArray | None" = None) -> "Axes | AxesArray":
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")
