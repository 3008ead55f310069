"""The way to follow a transient: the exact path in the plane, increments by Newton's method in space or where their number is given."""

from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.system import checked_system
from .exact import ExactPath
from .stepped import SteppedPath, step_counts


def path_of(
    system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, load_factor: float, initial_slip: ArrayLike | None = None, steps: int | None = None
) -> ExactPath | SteppedPath:
    """A transient that has not begun; `steps` is the number of increments from corner to corner, None: no increments in the plane, 20 in space.

    Raises
    ------
    ModelError
        Bad input.
    """
    if checked_system(system).tangents == 1 and steps is None:
        return ExactPath(system, cycle, friction, load_factor, initial_slip)
    return SteppedPath(system, cycle, friction, load_factor, initial_slip, None, "newton", step_counts(steps)[0])
