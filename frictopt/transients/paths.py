"""The way to follow a transient, exactly or in increments; and the state under the mean load alone, where every cycle begins."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.parts import parted
from ..contact.system import checked_system
from ..errors import NoContinuation, SolverError
from .begin import OPEN
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


def mean_state(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> ContactState:
    """Slip and gap once the mean load has come, from no slip: followed exactly in the plane, by Newton's increments in space.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation, SolverError
        Nothing holds the contact on the way, or an increment has no answer that passes the checks.
    """
    path = _settled(system, cycle, friction)
    slip, _ = parted(path.state.u, system.tangents + 1)
    return ContactState(slip, _gap(path), *system.reaction(cycle.mean), next_loads=cycle.corner_names[0])


def open_at_rest(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> NDArray[np.bool_]:
    """(N,) nodes that are open once the mean load has come, from no slip; and at all corners of a cycle at load factor 0, if a part of it is fixed.

    Where friction is so high that the exact path ends at a jump, increments go beyond it.

    Raises
    ------
    ModelError, NoContinuation, SolverError
        See `mean_state`.
    """
    try:
        path = _settled(system, cycle, friction)
    except NoContinuation as end:
        try:
            path = _settled(system, cycle, friction, step_counts(None)[0])
        except SolverError:
            raise end from None
    opened = _gap(path) > 0
    for leg in path.legs if cycle.fixed else []:
        path.follow_to(*leg)
        opened &= _gap(path) > 0
    return opened


def _settled(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, steps: int | None = None) -> ExactPath | SteppedPath:
    path = path_of(system, cycle, friction, 0.0, steps=steps)
    path.start()
    return path


def _gap(path: ExactPath | SteppedPath) -> NDArray[np.float64]:
    """(N,) gaps of the present state."""
    _, opened = parted(path.state.u, path.system.tangents + 1)
    return np.where(path.state.status == OPEN, (opened + path.system.gap).clip(0.0), 0.0)
