"""Transients, by the exact path or in increments: the states over a number of load cycles, and that under the mean load alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import (
    RESIDUAL,
    ROUNDING,
    Array,
    Booleans,
    bar_of,
    choice,
    flag,
    frozen,
    warns_of_odd_values,
    whole_number,
)
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_system,
    checked_uncapped,
    parted,
)
from ..errors import ModelError, NoContinuation, SolverError
from .begin import OPEN
from .exact import ExactPath
from .stepped import ENGINES, SteppedPath, doubts
from .trajectory import Trajectory


@warns_of_odd_values
def march(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    cycles: int = 5,
    engine: Literal["path", "newton", "qp", "milp"] | None = None,
    steps: int | None = None,
    progress: bool = True,
) -> Trajectory:
    """Follow a transient from an initial slip, or from an earlier state, through a number of load cycles.

    The load path starts at an artificial load that carries the initial slip with q = 0 and, at
    every node, p equal to the mean of `abs(p^w)` under the mean load. It goes in a straight line to
    the mean load, and then visits the corners in their order, again and again. Theory, eq. (13).

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
        trajectory. Its nodes may be open. The load goes straight from that of the state to the
        corner that comes next, and to the end of that cycle.
    cycles
        Number of whole cycles.
    engine
        "path": exactly, from event to event, for plane contacts: in space the friction circle is
        curved, and no path is made of straight lines. In increments: "newton", each by Newton's
        method; "qp", by convex programs with a frozen friction bound; "milp", by complementarity
        conditions with booleans, for plane contacts. None: "path" in the plane without `steps`,
        else "newton".
    steps
        Number of increments from corner to corner; None: 20. The transient is followed with a half
        and a quarter of them, too, which gives `step_error`. The exact path has none.
    progress
        Whether to show after two seconds how far the increments are.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The exact path ends, or a load is beyond friction.
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
    asked = system, cycle, friction, load_factor, initial_slip, initial_state
    path = path_of(*asked, steps=steps, engine=engine)
    begun = path.visited
    if isinstance(path, ExactPath):
        path, error, legs = path.recorded(), 0.0, path.begun + path.legs * cycles
        loads = np.array([path.bonded, *(load for load, _ in legs)])
        path.follow(legs)
        time, u, r, status, work = path.states()
        bonded = np.array(
            [np.interp(time, begun + np.arange(len(loads)), values) for values in loads.T]
        ).T
    else:
        with bar_of(progress, "march", "cycle", total=(1 + len(path.coarser)) * cycles) as bar:
            coarse = [
                SteppedPath("newton", count, *asked) for count in path.coarser
            ]  # the quickest way
            (bonded, u, r, status, work), error = _in_increments(path, coarse, cycles, bar.update)
        time, work = begun + np.arange(len(u)) / path.steps, np.cumsum(work, axis=0)
    (bonded_q, bonded_p), (slip, gap), (q, p) = (
        parted(values, system.tangents + 1) for values in (bonded, u, r)
    )
    amplitudes, kinds = (
        amplitudes_at(system, cycle, path.load_factor, time, {}),
        status.astype(np.int8, copy=False),
    )
    state = (
        slip,
        gap + system.gap,
        q,
        p,
        kinds,
        work,
        path.engine,
        error,
        perf_counter() - path.started,
    )
    trajectory = Trajectory(
        system, frozen(path.friction), cycle, time, amplitudes, bonded_q, bonded_p, *state
    )
    if not trajectory.residual <= RESIDUAL:
        raise SolverError(
            f"march: the states violate the contact law or the balance of energy by {trajectory.residual:.1e} (tolerance {RESIDUAL:g}; "
            f"{trajectory.verdict}); {path.cause_of_rounding}"
        )
    return trajectory


def _in_increments(
    path: SteppedPath, coarser: Sequence[SteppedPath], cycles: int, tell: Callable[[], object]
) -> tuple[list[Array], float]:
    """Loads, `u`, reactions, status and work of the states of a transient that has not begun, and their `step_error`; errors of increments."""

    def followed(path: SteppedPath) -> list[Array]:
        points = [path.state, *path.follow(path.begun)]
        for _ in range(cycles):
            points += path.follow(path.legs)
            tell()
        return [np.array(values) for values in zip(*points, strict=True)]

    def at_stops(path: SteppedPath, u: Array) -> Array:
        return u[:: path.steps, : -path.nodes]

    *states, _ = followed(path)
    _, u, r, *_ = states
    error = 0.0 if coarser else np.inf
    for other in coarser:
        try:
            error = max(
                error, float(np.abs(at_stops(path, u) - at_stops(other, followed(other)[1])).max())
            )
        except (NoContinuation, SolverError):
            error = np.inf
    doubt = doubts(path.system, path.friction, u, r)
    ways = [
        float((one / np.where(doubt.bound > 0, doubt.bound, np.inf)).sum(axis=0).max())
        for one in (doubt.lacking, doubt.change)
    ]
    missed = (
        float(np.sqrt(np.prod(ways))),
        float(doubt.late.max(initial=0.0)),
    )  # slip within the increments
    return states, max(error, *missed) / path.length


def amplitudes_at(
    system: ContactSystem,
    cycle: LoadCycle,
    load_factor: float,
    time: Array,
    first: Mapping[str, float],
) -> Array:
    """(T, cases) amplitudes of the load cases at times from the first state on, which has the amplitudes `first`; not known: NaN."""
    begin, end = int(time[0]), int(np.ceil(time[-1]))
    loads, cyclic = [first] + ([cycle.mean] if begin < 0 else []), cycle.at(load_factor)
    loads += [cyclic[number % len(cyclic)] for number in range(max(begin, 0), end)]
    none = 0.0 if first else np.nan
    stops = [
        [load.get(case, 0.0 if number else none) for case in system.bonded]
        for number, load in enumerate(loads)
    ]
    return np.array(
        [np.interp(time, begin + np.arange(len(stops)), column) for column in np.transpose(stops)]
    ).T


def path_of(
    system: ContactSystem, *asked: Any, steps: int | None = None, engine: object = None
) -> ExactPath | SteppedPath:
    """A `Transient` that has not begun, of a system and what else `Transient` asks for; `steps` and `engine` as in `march`."""
    plane = checked_system(system).tangents == 1
    way = "path" if plane and steps is None and not system.capped else "newton"
    way = way if engine is None else str(choice("engine", engine, ("path", *ENGINES)))
    if way in ("path", "milp") and not plane:
        raise ModelError(
            f"engine: {way!r}; it needs a law of straight lines, and the friction circle is curved: choose 'newton' or 'qp', and see `step_error` "
            "for what the increments leave"
        )
    if way in ("path", "milp"):
        checked_uncapped(system, f"engine {way!r}")
    if way == "path" and steps is not None:
        raise ModelError(
            f"steps: {steps}; the exact path has none, leave it out or choose an engine of increments: {', '.join(ENGINES)}"
        )
    return (
        ExactPath(system, *asked)
        if way == "path"
        else SteppedPath(way, steps, system, *asked).checked()
    )


def mean_state(
    system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, steps: int | None = None
) -> ContactState:
    """Slip and gap once the mean load has come, from no slip: followed exactly in the plane, by Newton's increments in space; errors of `march`."""
    path = path_of(system, cycle, friction, 0.0, steps=steps).start()
    slip, _ = parted(path.state.u, system.tangents + 1)
    return ContactState(
        slip, _gap(path), *system.reaction(cycle.mean), next_loads=cycle.corner_names[0]
    )


def open_at_rest(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> Booleans:
    """(N,) nodes that are open once the mean load has come, from no slip; increments go beyond jumps, at which the exact path ends."""
    try:
        path = path_of(system, cycle, friction, 0.0).start()
    except NoContinuation as end:
        try:
            path = path_of(system, cycle, friction, 0.0, engine="newton").start()
        except SolverError:
            raise end from None
    return _gap(path) > 0


def _gap(path: ExactPath | SteppedPath) -> NDArray[np.float64]:
    """(N,) gaps of the present state."""
    _, opened = parted(path.state.u, path.system.tangents + 1)
    gap = np.where(path.state.status == OPEN, (opened + path.system.gap).clip(0.0), 0.0)
    return np.where(gap > ROUNDING * gap.max(), gap, 0.0)
