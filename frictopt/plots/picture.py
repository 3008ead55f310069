"""One function that draws any result; each kind of result registers its own picture."""

from dataclasses import dataclass
from functools import singledispatch
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # matplotlib need not be installed
    from matplotlib.axes import Axes

    from ..contact.show import Table
    from ..fem import BodyFields
    from ..transients import Trajectory
    from .style import AxesArray


@dataclass(frozen=True, eq=False)
class Runs:
    """The table of a study, so that it has a kind of its own."""

    table: "Table"


@dataclass(frozen=True, eq=False)
class Status:
    """What each node does over a transient."""

    states: "Trajectory"

    @property
    def units(self) -> str | None:
        """The units of its system."""
        return self.states.system.units


@dataclass(frozen=True, eq=False)
class Deformed:
    """Bodies under their displacements, so many times enlarged; None: so that the largest is a tenth of the model."""

    fields: "BodyFields"
    scale: float | None

    @property
    def units(self) -> str | None:
        """The units of the fields."""
        return self.fields.units


@singledispatch
def picture(result: object, ax: "Axes | AxesArray | None" = None) -> "Axes | AxesArray":
    """Draw one kind of result in the given axes, or in those of a new figure, and return the axes."""
    raise NotImplementedError(f"a {type(result).__name__} has no picture")
