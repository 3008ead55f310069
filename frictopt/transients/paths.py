"""The way to follow a transient, exactly or in increments; and the state under the mean load alone, where every cycle begins."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.checks import choice
from ..contact.parts import parted
from ..contact.system import checked_system
from ..errors import ModelError, NoContinuation, SolverError
from .begin import OPEN
from .exact import ExactPath
from .stepped import ENGINES, SteppedPath


def path_of(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    steps: int | None = None,
    engine: object = None,
) -> ExactPath | SteppedPath:
    """A transient that has not begun, by an engine of `march`; `steps` is the number of increments from corner to corner, None: 20.

    Without an engine it is exact in the plane where no number of increments is given, else by Newton's method.

    Raises
    ------
    ModelError
        Bad input, an engine that there is not, or not for this contact.
    """
    plane = checked_system(system).tangents == 1
    way = "path" if plane and steps is None else "newton"
    way = way if engine is None else str(choice("engine", engine, ("path", *ENGINES)))
    if way in ("path", "milp") and not plane:
        raise ModelError(
            f"engine: {way!r}; it needs a law of straight lines, and the friction circle is curved: choose 'newton' or 'qp', and see `step_error` "
            "for what the increments leave"
        )
    if way == "path" and steps is not None:
        raise ModelError(f"steps: {steps}; the exact path has none, leave it out or choose an engine of increments: {', '.join(ENGINES)}")
    asked = system, cycle, friction, load_factor, initial_slip, initial_state
    return ExactPath(*asked) if way == "path" else SteppedPath(way, steps, *asked)


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
            path = _settled(system, cycle, friction, "newton")
        except SolverError:
            raise end from None
    opened = _gap(path) > 0
    for leg in path.legs if cycle.fixed else []:
        path.follow_to(*leg)
        opened &= _gap(path) > 0
    return opened


def _settled(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, engine: str | None = None) -> ExactPath | SteppedPath:
    path = path_of(system, cycle, friction, 0.0, engine=engine)
    path.start()
    return path


def _gap(path: ExactPath | SteppedPath) -> NDArray[np.float64]:
    """(N,) gaps of the present state."""
    _, opened = parted(path.state.u, path.system.tangents + 1)
    return np.where(path.state.status == OPEN, (opened + path.system.gap).clip(0.0), 0.0)
