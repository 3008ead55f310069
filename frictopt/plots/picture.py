"""One function that draws any result; each kind of result registers its own picture."""

from dataclasses import dataclass
from functools import singledispatch
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

    from ..contact.show import Table
    from .style import AxesArray

__all__ = ["Runs", "picture"]


@dataclass(frozen=True, eq=False)
class Runs:
    """The table of a study, so that it has a kind of its own."""

    table: "Table"


@singledispatch
def picture(result: object, ax: "Axes | AxesArray | None" = None) -> "Axes | AxesArray":
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")
