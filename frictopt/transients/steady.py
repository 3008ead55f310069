"""The steady state of a transient: whether slip stops, and the work of friction per cycle."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from time import perf_counter
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    REPEATED,
    RESIDUAL,
    ROUNDING,
    Array,
    Outcome,
    PerNode,
    SolveRecord,
    finite_number,
    flag,
    number_of,
    progress_bar,
    warns_of_odd_values,
    whole_number,
)
from ..contact import ContactState, ContactSystem, LoadCycle, off_law, parted
from ..errors import NoContinuation, SolverError
from .classify import Settled, distance_left, returns_after
from .cycles import Run
from .march import path_of
from .outcome import SteadyState
from .stepped import SteppedPath, doubts
from .transient import FollowedCycle, Transient

MOST_CYCLES = 2000
"""Default number of cycles after which the search for a steady state gives up."""


# The numbers of the estimate of `step_error`.

# Least number of cycles followed in finer increments from the beginning of the transient.
_FIRST_CYCLES = 3
# Largest number of cycles followed in finer increments from the beginning of the transient,
# and again from the steady state.
_FINER_CYCLES = 8
# These cycles end if the later changes are below this share of the change so far.
_CONVERGED = 0.1
# Largest estimate of the later changes, relative to the last change.
_LONGEST = 300.0
# Factor on the estimated error.
_SAFETY = 2.0
# Share of the work in doubt that is added to the error, since errors may cancel in a difference.
_CANCELLED = 0.01


@warns_of_odd_values
def steady_state(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    overload: float | None = None,
    most_cycles: int = MOST_CYCLES,
    steps: int | None = None,
    progress: bool = True,
) -> SteadyState:
    """Follow a transient until its steady state is proven.

    Plane contacts are followed exactly, contacts in space in increments by Newton's method.

    The load cycle maps the slip at its beginning to the slip at its end. The map is affine as long
    as the events in each segment stay the same, in any order. Its fixed point is extrapolated from
    the last cycles (reduced-rank extrapolation, Sidi 2017). The fixed point is accepted if a cycle
    from it returns to it, and if cycles from states between it and the last state show that the map
    is affine for all states to come. The transient then goes on from the fixed point.

    In increments the directions of slip change, the map is not affine, and extrapolations are
    repeated. The fixed point is accepted if (1) a cycle from it returns to it, (2) cycles from the
    last state and from two states in between approach it, and (3) a later extrapolation gives the
    same work to a relative 3e-8. The remaining error of the work that `work_error` estimates is
    then at most 1e-5; the estimate is no bound.

    The state may repeat after two cycles (`period`), or its slip may drift by the same amount in
    each period. Shakedown needs a slip that is safe at every corner. If nodes lift off or have no
    friction, a periodic state with negligible work of friction also counts as shakedown. The work
    of a node is negligible if it is at most the work of a slip of 1e-9 slip scales under the node's
    largest pressure. A slip scale is the slip that the largest nodal force of the loads causes.
    Theory, eq. (14).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip, initial_state
        Residual slip from assembly, (N,) in the plane, (N, 2) in space, length, or an earlier
        state, see `march`; None: no slip.
    overload
        Load factor of one extra cycle before all others, >= 0; None: no such cycle.
    most_cycles
        Number of cycles after which to give up.
    steps
        Number of increments from corner to corner; finer increments give `step_error`. For a large
        contact in space, begin with 2, and double the number until `step_error` is small enough.
        None: the exact path in the plane, 20 increments in space.
    progress
        Whether to show the progress after two seconds. Ctrl-C raises KeyboardInterrupt. The
        attribute `work` of this error, (cycles,), has the work of each cycle so far; NoContinuation
        has this attribute, too.

    Returns
    -------
    SteadyState
        The steady cycle with its outcome, its work, and the proof that it repeats.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, friction cannot hold a load, or no steady state of period one or two is
        proven within `most_cycles`. The attributes of the error hold what is known.
    SolverError
        An increment has no valid answer, or the states violate the contact law or the balance of
        energy by more than the tolerance.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> steady.outcome.name, round(steady.dissipation, 6)
    ('CYCLIC_SLIP', 1.0)
    >>> fo.reference.rod_dissipation(F0=1.0, EA=1.0, tau=0.5, h=1.0)
    1.0
    """
    whole_number("most_cycles", most_cycles, least=1)
    flag("progress", progress)
    overload_factor = None if overload is None else finite_number("overload", overload, least=0.0)
    problem = system, cycle, friction, load_factor, initial_slip, initial_state
    path = path_of(*problem, steps=steps)
    run = Run(path, most_cycles)
    first_states: list[Array] = []
    with progress_bar(progress, "steady state", "cycle") as bar:

        def count() -> None:
            if run.works:
                cycles = number_of(len(run.works), "cycle")
                note = f"the attribute `work` has the work of friction in each of {cycles}"
                bar.keep("work", np.array(run.works), note, best=run.progress)
            bar.update()
            # The transient itself does not move while copies of it are followed for a proof.
            is_new = not first_states or path.state.u is not first_states[-1]
            if is_new and len(first_states) < _FINER_CYCLES:
                first_states.append(path.state.u)

        run.report = count
        # The copy shares the solver of increments with the transient; this solver remembers which
        # nodes were open.
        begin = copy(path)
        path.start(overload_factor)
        settled = run.settled()
        error = 0.0
        if isinstance(begin, SteppedPath):
            bar.best = "steady"
            with progress_bar(progress, "error of its increments", "cycle") as finer_bar:
                run.report = finer_bar.update
                try:
                    finer, parts = begin.finer()
                    error = _step_error(
                        run, settled, first_states, finer.start(overload_factor), parts
                    )
                except (NoContinuation, SolverError):
                    error = np.inf
        return reported(run, settled, error)


def settled_from(path: Transient, step_error: float) -> SteadyState:
    """The steady state of a transient that has begun; in increments with a given `step_error`.

    The step error is given, because its estimate takes more than half of the time that a steady
    state takes.
    """
    run = Run(path, MOST_CYCLES)
    with progress_bar(True, "steady state", "cycle") as bar:
        bar.best = run.progress
        run.report = bar.update
        return reported(run, run.settled(), step_error if path.steps else 0.0)


def _step_error(
    run: Run, settled: Settled, first_states: Sequence[Array], finer: SteppedPath, parts: int
) -> float:
    """Estimated relative error of the work in a steady state due to the size of its increments.

    `finer` is the same transient from the same start in finer increments: at least four for each
    increment and 32 from corner to corner, with ever smaller ones before the corner. Some nodes
    slip only in the first cycles, and keep this slip. So the finer increments start from the slips
    of the steady state plus a correction, see `_later_difference`.
    """
    path = cast(SteppedPath, settled.path)
    slips = path.state.u[: -path.nodes] + _later_difference(run, first_states, finer)
    refined = path.finer()[0].at(slips / path.unit)
    if refined is None:
        return np.inf
    finer_run = Run(refined, run.most_cycles, run.report, run.period)
    lacking, missed = _work_in_doubt(path, settled.cycle)
    total = float(settled.cycle.work.sum())
    if not total:
        return np.inf if missed or finer_run.settled().cycle.work.any() else 0.0
    change = _change_of_work(finer_run, settled.cycle)
    error = _SAFETY * parts / (parts - 1) * change + _CANCELLED * lacking
    return float(max(error, missed)) / total


def _later_difference(run: Run, first_states: Sequence[Array], finer: SteppedPath) -> Array:
    """Difference that finer increments make in the slips after many cycles, length.

    `first_states` are the states after the first cycles in the original increments. Near a limit
    the difference grows over many cycles, by less and less. This growth is extrapolated.
    """
    unit = finer.unit
    difference = growth = np.zeros_like(unit)
    growths = list[float]()
    later = 0.0
    for state in first_states:
        finer.cycle_on(1)
        run.report()
        before = difference
        difference = (finer.state.u - state)[: -finer.nodes]
        growth = difference - before
        growths.append(float(np.linalg.norm(growth / unit)))
        if len(growths) >= _FIRST_CYCLES:
            later = _later(growths, REPEATED)
            if later <= _CONVERGED * np.linalg.norm(difference / unit):
                break
    return difference + (growth * (later / growths[-1]) if later else 0.0)


def _later(changes: Sequence[float], rounding: float) -> float:
    """Estimated sum of all later changes, at most `_LONGEST` times the last change."""
    return min(distance_left(changes[-3:], rounding), _LONGEST * changes[-1])


def _work_in_doubt(path: SteppedPath, cycle: FollowedCycle) -> tuple[float, float]:
    """Work that increments may lack, and work of nodes before they open, see `doubts`."""
    if cycle.previous is None:
        return 0.0, 0.0
    # The reactions at the beginning of the cycle equal the reactions at its end.
    u = np.concatenate([cycle.previous[:1], cycle.u])
    r = np.concatenate([cycle.r[-1:], cycle.r])
    doubt = doubts(path.system, path.friction, u, r)
    lacking = float(np.sqrt(doubt.lacking.sum() * doubt.change.sum()))
    missed = float(doubt.missed.sum())
    rounding = ROUNDING * path.largest * path.length
    return lacking if lacking > rounding else 0.0, missed if missed > rounding else 0.0


def _change_of_work(again: Run, cycle: FollowedCycle) -> float:
    """Change of the work of a cycle in finer increments, extrapolated to all later cycles."""
    work = cycle.work
    changes = list[float]()
    while True:
        before = work
        work = again.follow(again.path).work
        changes.append(float(np.abs(work - before).sum()))
        change = float(np.abs(work - cycle.work).sum())
        later = _later(changes, REPEATED * float(cycle.work.sum()))
        converged = len(changes) > 1 and later <= _CONVERGED * change
        if converged or len(changes) == _FINER_CYCLES:
            return change + later


def reported(run: Run, settled: Settled, step_error: float) -> SteadyState:
    """The steady state in the units of the caller; SolverError if its residual is too large."""
    residual = _residual(run, settled)
    path = settled.path
    system = path.system
    cycle = settled.cycle
    n = path.nodes
    slips = settled.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETING)
    work = cycle.work / run.period
    slip, opening = parted(cycle.u[-1], system.tangents + 1)
    gap = opening + system.gap
    load = parted(path.corners[-1], system.tangents + 1)
    far = float(np.abs(cycle.after).max())
    least_slide = max(ROUNDING * max(1.0, far), cycle.change) * path.scales.length
    left_out = len(path.corners) - len(path.turns)
    sentences: tuple[str, ...] = ()
    if left_out:
        sentences = (
            f"corners: {left_out} of {len(path.corners)} are on the straight segment between "
            "others, and are ignored",
        )
    return SteadyState(
        outcome=settled.outcome,
        dissipation=float(work.sum()),
        dissipation_per_node=work,
        sliding_distance=cycle.slid / run.period if slips else np.zeros(n),
        work_error=settled.work_error,
        step_error=step_error,
        period=returns_after(path, cycle) if run.period == 2 and slips else 1,
        system=system,
        cycle=path.cycle,
        friction=np.array(path.friction),
        load_factor=path.load_factor,
        slip=np.array(slip),
        gap=gap,
        state=ContactState(
            slip, np.maximum(gap, 0.0), *load, next_loads=path.cycle.corner_names[0]
        ),
        open=np.asarray((cycle.u[:, -n:] + system.gap > 0).any(axis=0)),
        slipping=slips & (path.friction > 0) & (cycle.slid > least_slide),
        first_cycle=run.works[0],
        cycles=run.cycles,
        events=path.events,
        extrapolated=run.extrapolated,
        unproven=path.unproven,
        steps=path.steps,
        record=SolveRecord(
            "NEWTON" if path.steps else "path",
            (),
            residual,
            sentences,
            perf_counter() - path.started,
        ),
        drift=_drift(path, cycle) / run.period if settled.outcome is Outcome.RATCHETING else 0.0,
    )


def _drift(path: Transient, cycle: FollowedCycle) -> float:
    """Largest slip that a node gains in a return of the transient, length."""
    t = path.system.tangents
    moved = ((cycle.after - cycle.before) * path.unit)[: t * path.nodes].reshape(t, path.nodes)
    true_slip = moved / path.system.stretch.reshape(path.nodes, t).T
    return float(np.linalg.norm(true_slip, axis=0).max())


def _residual(run: Run, settled: Settled) -> float:
    """Residual of a steady state, see `SteadyState.record`; SolverError if it is too large."""
    path = settled.path
    cycle = settled.cycle
    errors = []
    for checked in settled.checked_cycles:
        states = checked.bonded, checked.u, checked.r
        errors.append(off_law(path.system, path.law, *states, path.largest, checked.previous).max())
    residual = float(np.max([cycle.change, cycle.lost, run.lost, *errors]))
    if not residual <= RESIDUAL:
        raise SolverError(
            "steady state: its states violate the contact law or the balance of energy, or do not "
            f"return to the first state, by {residual:.1e} (tolerance {RESIDUAL:g}); "
            f"{path.cause_of_rounding}"
        )
    return residual
