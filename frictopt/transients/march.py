"""Transients by the exact path or in increments: over load cycles, or under the mean load."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import (
    RESIDUAL,
    ROUNDING,
    Array,
    Booleans,
    Loads,
    PerNode,
    flag,
    frozen,
    progress_bar,
    warns_of_odd_values,
    whole_number,
)
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    amplitudes_of,
    checked_law,
    parted,
)
from ..errors import NoContinuation, SolverError
from .exact import ExactPath
from .stepped import SteppedPath, SteppedState, doubts
from .trajectory import Trajectory
from .transient import OPEN


@warns_of_odd_values
def march(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    cycles: int = 5,
    steps: int | None = None,
    progress: bool = True,
) -> Trajectory:
    """Follow a transient from an initial slip, or from an earlier state, through load cycles.

    The load path starts at an artificial load. Under this load the initial slip has q = 0 and the
    same p at every node: the mean of `abs(p^w)` under the mean load. The path goes in a straight
    line to the mean load, and then visits the corners in their order, again and again. The states
    before the mean load are checked, too, but they are not returned. Theory, eq. (13).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        Residual slip from assembly, (N,) in the plane, (N, 2) in space, length; None: no slip.
    initial_state
        An earlier state, instead of a slip: `state` of a steady state, or `state_at(...)` of a
        trajectory. Its nodes may be open. The load goes in a straight line from the load of the
        state to the next corner, and on to the last corner of the cycle. Whole cycles follow.
    cycles
        Number of whole cycles.
    steps
        Number of increments from corner to corner. The transient is also followed with a half and a
        quarter of this number, which gives `step_error`. None: in the plane exactly, from event to
        event; in space in 20 increments, because the friction bound is a circle and paths are not
        piecewise linear.
    progress
        Whether to show the progress of the increments after two seconds.

    Returns
    -------
    Trajectory
        The states of the transient, from the mean load or from the earlier state on.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The exact path ends, or friction cannot hold a load.
    SolverError
        An increment has no valid solution, or the residual of the states exceeds the tolerance.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=2)
    >>> path.cycle_work.sum(axis=1).round(6).tolist()
    [0.75, 1.0]
    >>> increments = fo.march(rod, cycle, friction=0.5, load_factor=1.0, cycles=1, steps=2)
    >>> bool(abs(increments.slip[-1] - path.slip[-1]).max() < 1e-6)
    True
    """
    whole_number("cycles", cycles, least=0)
    flag("progress", progress)
    parameters = system, cycle, friction, load_factor, initial_slip, initial_state
    path = path_of(*parameters, steps=steps)
    if isinstance(path, ExactPath):
        path = path.recorded()
        states, step_error = _exactly(path, cycles), 0.0
    else:
        fewer_steps = {max(1, path.steps // 2), max(1, path.steps // 4)} - {path.steps}
        coarser = [SteppedPath(count, *parameters) for count in fewer_steps]
        total = (1 + len(coarser)) * cycles
        with progress_bar(progress, "march", "cycle", total=total) as bar:
            runs = _Runs(cycles, bar.update)
            states, step_error = _in_increments(path, coarser, runs)
    axes = system.tangents + 1
    bonded_q, bonded_p = parted(states.bonded, axes)
    slip, opening = parted(states.u, axes)
    q, p = parted(states.r, axes)
    trajectory = Trajectory(
        system,
        frozen(path.friction),
        cycle,
        states.time,
        amplitudes_at(system, cycle, path.load_factor, states.time, {}),
        bonded_q,
        bonded_p,
        slip,
        opening + system.gap,
        q,
        p,
        states.status,
        states.work,
        path.engine,
        step_error,
        perf_counter() - path.started,
    )
    if not trajectory.residual <= RESIDUAL:
        raise SolverError(
            "march: the states violate the contact law or the balance of energy by "
            f"{trajectory.residual:.1e} (tolerance {RESIDUAL:g}; {trajectory.verdict}); "
            f"{path.cause_of_rounding}"
        )
    return trajectory.from_mean_load()


class _States(NamedTuple):
    """T states: times (T,), loads, `u` and reactions (T, M), status and work so far (T, N)."""

    time: Array
    bonded: Array
    u: Array
    r: Array
    status: NDArray[np.int8]
    work: Array


def _exactly(path: ExactPath, cycles: int) -> _States:
    """The states at the events of a recorded path that has not begun."""
    first_time = path.visited
    segments = path.begun + path.segments * cycles
    stops = np.array([path.bonded, *(load for load, _ in segments)])
    path.follow(segments)
    time, u, r, status, work = path.states()
    times_of_stops = first_time + np.arange(len(stops))
    bonded = np.array([np.interp(time, times_of_stops, values) for values in stops.T]).T
    return _States(time, bonded, u, r, status, work)


class _Runs(NamedTuple):
    """The number of cycles that each run in increments follows, and a report after each cycle."""

    cycles: int
    report: Callable[[], object]

    def follow(self, path: SteppedPath) -> list[SteppedState]:
        """The states of a transient that has not begun. It raises the errors of increments."""
        points = [path.state, *path.follow(path.begun)]
        for _ in range(self.cycles):
            points += path.follow(path.segments)
            self.report()
        return points


def _in_increments(
    path: SteppedPath, coarser: Sequence[SteppedPath], runs: _Runs
) -> tuple[_States, float]:
    """The states of a transient that has not begun, and their `step_error`."""
    first_time = path.visited
    bonded, u, r, status, work, _ = (
        np.array(values) for values in zip(*runs.follow(path), strict=True)
    )
    time = first_time + np.arange(len(u)) / path.steps
    states = _States(time, bonded, u, r, status, np.cumsum(work, axis=0))
    error = max(_change_by_steps(path, u, coarser, runs), _slip_in_doubt(path, u, r))
    return states, error / path.length


def _change_by_steps(
    path: SteppedPath, u: Array, coarser: Sequence[SteppedPath], runs: _Runs
) -> float:
    """Largest change of the slip at the corners if fewer steps are used; inf without such runs."""
    if not coarser:
        return np.inf
    n, error = path.nodes, 0.0
    at_corners = u[:: path.steps, :-n]
    for other in coarser:
        try:
            points = runs.follow(other)
        except (NoContinuation, SolverError):
            error = np.inf
        else:
            coarse = np.array([point.u for point in points])[:: other.steps, :-n]
            error = max(error, float(np.abs(at_corners - coarse).max()))
    return error


def _slip_in_doubt(path: SteppedPath, u: Array, r: Array) -> float:
    """Slip within increments that their ends do not show, from the `doubts` in the work."""
    doubt = doubts(path.system, path.friction, u, r)
    bound = np.where(doubt.bound > 0, doubt.bound, np.inf)
    lacking = float((doubt.lacking / bound).sum(axis=0).max())
    change = float((doubt.change / bound).sum(axis=0).max())
    return max(float(np.sqrt(lacking * change)), float(doubt.late.max(initial=0.0)))


def amplitudes_at(
    system: ContactSystem,
    cycle: LoadCycle,
    load_factor: float,
    time: Array,
    first: Loads,
) -> Array:
    """(T, cases) amplitudes of the load cases at times from the first state on.

    The first state has the amplitudes `first`. If `first` is empty, its amplitudes are unknown:
    NaN.
    """
    begin, end = int(time[0]), int(np.ceil(time[-1]))
    corners = cycle.at(load_factor)
    loads = [first]
    if begin < 0:
        loads.append(cycle.mean)
    loads += [corners[number % len(corners)] for number in range(max(begin, 0), end)]
    stops = amplitudes_of(loads, system.bonded)
    if not first:
        stops[0] = np.nan
    times_of_stops = begin + np.arange(len(stops))
    return np.array([np.interp(time, times_of_stops, column) for column in stops.T]).T


def path_of(
    system: ContactSystem,
    *parameters: Any,
    steps: int | None = None,
    retries: bool = True,
) -> ExactPath | SteppedPath:
    """A transient that has not begun: exact or in increments, as `steps` of `march` says.

    `parameters` are the other parameters of `Transient`. Without `retries`, an increment ends the
    transient if Newton's method does not find its state at once.
    """
    in_plane = checked_law(system, "march").tangents == 1
    if in_plane and steps is None and not system.capped:
        return ExactPath(system, *parameters)
    return SteppedPath(steps, system, *parameters, retries=retries).checked()


def mean_state(
    system: ContactSystem, cycle: LoadCycle, friction: PerNode, *, steps: int | None = None
) -> ContactState:
    """The state under the mean load, reached from no slip. Raises the errors of `march`.

    The transient is followed in increments if `steps` is given, if the contact is in space, or if
    its law is not Coulomb's; otherwise it is followed exactly.
    """
    path = path_of(system, cycle, friction, 0.0, steps=steps).start()
    slip, _ = parted(path.state.u, system.tangents + 1)
    return ContactState(
        slip, _gap(path), *system.reaction(cycle.mean), next_loads=cycle.corner_names[0]
    )


def open_at_rest(system: ContactSystem, cycle: LoadCycle, friction: PerNode) -> Booleans:
    """(N,) nodes that are open under the mean load, which is reached from no slip.

    If the exact path ends, as at a jump, increments follow the load instead.
    """
    try:
        path = path_of(system, cycle, friction, 0.0).start()
    except NoContinuation as end:
        try:
            path = SteppedPath(None, system, cycle, friction, 0.0).checked().start()
        except SolverError:
            raise end from None
    return _gap(path) > 0


def _gap(path: ExactPath | SteppedPath) -> NDArray[np.float64]:
    """(N,) gaps of the present state."""
    _, opening = parted(path.state.u, path.system.tangents + 1)
    gap = np.where(path.state.status == OPEN, (opening + path.system.gap).clip(0.0), 0.0)
    return np.where(gap > ROUNDING * gap.max(), gap, 0.0)
