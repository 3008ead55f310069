"""The steady state of a transient: whether it stops slipping, and if not, how much it dissipates per cycle."""

from __future__ import annotations

from collections.abc import Sequence
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
    SolveRecord,
    bar_of,
    finite_number,
    flag,
    warns_of_odd_values,
    whole_number,
)
from ..contact import ContactState, ContactSystem, LoadCycle, off_law, parted
from ..errors import NoContinuation, SolverError
from .classify import Settled, distance_left, returns_after
from .cycles import Run
from .increment_doubts import doubts
from .march import path_of
from .outcome import SteadyState
from .stepped import SteppedPath

MOST_CYCLES = 2000
"""Number of cycles after which the search for a steady state gives up, unless another one is asked for."""

_EARLY, _AGAIN = (
    3,
    8,
)  # cycles in finer increments: the first ones, and those from the steady state at most
_SETTLED, _LONGEST = (
    0.1,
    50,
    # what their work has yet to change, over what it has, from which on they end; and over the last
    # change, at most
)
_SAFETY, _CANCELLED = (
    2,
    0.01,
    # times the estimated error; and share of the work in doubt that is added, since errors may cancel
    # in a difference
)


@warns_of_odd_values
def steady_state(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    initial_slip: ArrayLike | None = None,
    initial_state: ContactState | None = None,
    overload: float | None = None,
    most_cycles: int = MOST_CYCLES,
    steps: int | None = None,
    progress: bool = True,
) -> SteadyState:
    """Follow a transient until its steady state is proven: exactly in the plane, in increments by Newton's method in space.

    The load cycle maps the slip at its beginning to the slip at its end. As long as the events stay
    the same, in any order within a segment, this map is affine, and its fixed point is extrapolated
    from the last cycles (reduced-rank extrapolation, Sidi 2017). The extrapolated state is accepted
    if a cycle from it returns to it, and if cycles from states between it and the last state show
    that the map is affine for all states to come. The transient then goes on from it. In increments
    slips turn, and the map is not affine: one extrapolation follows the other. The state is
    accepted if (1) a cycle from it returns to it, (2) cycles from the last state and from two
    states in between approach it, and (3) a later extrapolation gives the same work to a relative
    3e-8; `work_error` estimates what is left of that in all later cycles and is no bound. The state
    may come back after two cycles (`period`), or its slip may drift by the same amount in each
    return.

    Shakedown needs a slip that is safe at every corner. If nodes lift off or have no friction, a
    periodic state without work of friction also counts (at each node at most the work of a slip of
    1e-9 slip scales under its own largest pressure). Theory, eq. (14).

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
        Number of increments from corner to corner; finer ones tell `step_error`. Begin with 2 in a
        large contact in space, and double them until `step_error` is small enough. None: the exact
        path in the plane, 20 in space.
    progress
        Whether to show after two seconds how far it is. Ctrl-C stays a KeyboardInterrupt with an
        attribute `work`, (cycles,), as of a NoContinuation.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends, a load is beyond friction, or no steady state, of period one or two, is
        proven within `most_cycles`: its attributes then say what is known.
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
    extra = None if overload is None else finite_number("overload", overload, least=0.0)
    asked = system, cycle, friction, load_factor, initial_slip, initial_state
    path = path_of(*asked, steps=steps)
    early: list[Array] = []
    run: Run | None = None

    def kept(_: object) -> tuple[str, object, str] | None:
        works = np.array(run.works if run else [])
        return (
            (
                "work",
                works,
                f"the work of friction in each of {len(works)} cycles is in the attribute `work`",
            )
            if len(works)
            else None
        )

    with bar_of(progress, "steady state", "cycle", keeps=kept) as bar:

        def tell() -> None:
            bar.update()
            if len(early) < _EARLY:
                early.append(path.state.u)

        run = Run(path.start(extra), most_cycles, tell)
        found, error = run.settled(), 0.0
        if path.steps:
            try:
                begun, parts = SteppedPath("newton", path.steps, *asked).finer()
                error = _step_error(run, found, early, begun.start(extra), parts)
            except (NoContinuation, SolverError):
                error = np.inf
        return reported(run, found, error)


def _step_error(
    run: Run, found: Settled, early: Sequence[Array], begun: SteppedPath, parts: int
) -> float:
    """Estimated error in time of the work in a steady state, over itself, from a transient `begun` at the same start in finer increments.

    Nodes that slip in the first cycles alone keep that slip. So finer increments follow the steady
    state from slips that differ from its own as those after the first cycles do, `early` in all
    increments. They part each increment into four, or more up to 32 from corner to corner, and the
    last one into ever smaller ones. What their work has yet to change when they end is
    extrapolated.
    """
    path, cycle, changes = cast(SteppedPath, found.path), found.cycle, list[float]()
    for _ in early:
        Run(begun, run.most, run.tell).follow(begun)
    finer = path.finer()[0].at(
        (path.state.u + begun.state.u - early[-1])[: -path.nodes] / path.unit
    )
    if finer is None:
        return np.inf
    again, work, total = (
        Run(finer, run.most, run.tell, run.period),
        cycle.work,
        float(cycle.work.sum()),
    )
    lacking = missed = 0.0
    if cycle.previous is not None:
        u, r = (
            np.concatenate([cycle.previous[:1], cycle.u]),
            np.concatenate([cycle.r[-1:], cycle.r]),
        )  # the reactions come back
        doubt, none = (
            doubts(path.system, path.friction, u, r),
            ROUNDING * path.largest * path.length,
        )
        lacking, missed = (
            lost if lost > none else 0.0
            for lost in (np.sqrt(doubt.lacking.sum() * doubt.change.sum()), doubt.missed.sum())
        )
    if not total:
        return np.inf if missed or again.settled().cycle.work.any() else 0.0
    while len(changes) < _AGAIN:
        before, work = work, again.follow(finer).work
        changes.append(float(np.abs(work - before).sum()))
        apart = float(np.abs(work - cycle.work).sum())
        left = min(distance_left(changes[-3:], REPEATED * total), _LONGEST * changes[-1])
        if len(changes) > 1 and left <= _SETTLED * apart:
            break
    return (
        float(max(_SAFETY * parts / (parts - 1) * (apart + left) + _CANCELLED * lacking, missed))
        / total
    )


def reported(run: Run, found: Settled, step_error: float) -> SteadyState:
    """The steady state in words and units of the caller; SolverError if its states violate the law or the balance of energy."""
    path, cycle, n, slips = (
        found.path,
        found.cycle,
        found.path.nodes,
        found.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETING),
    )
    axes, gap, work = path.system.tangents + 1, path.system.gap, cycle.work / run.period
    errors = [
        off_law(
            path.system, path.friction, one.bonded, one.u, one.r, path.largest, one.previous
        ).max()
        for one in found.judged
    ]
    residual = float(np.max([cycle.change, cycle.lost, run.lost, *errors]))
    if not residual <= RESIDUAL:
        raise SolverError(
            f"steady state: its states violate the contact law or the balance of energy, or do not come back, by {residual:.1e} (tolerance "
            f"{RESIDUAL:g}); {path.cause_of_rounding}"
        )
    far = float(np.abs(cycle.after).max())
    (slip, opening), load, left_out = (
        parted(cycle.u[-1], axes),
        parted(path.corners[-1], axes),
        len(path.corners) - len(path.turns),
    )
    sentence = f"corners: {left_out} of {len(path.corners)} are on the straight segment between others, and no stops"
    return SteadyState(
        outcome=found.outcome,
        dissipation=float(work.sum()),
        dissipation_per_node=work,
        sliding_distance=cycle.slid / run.period if slips else np.zeros(n),
        work_error=found.work_error,
        step_error=step_error,
        period=returns_after(path, cycle) if run.period == 2 and slips else 1,
        system=path.system,
        cycle=path.cycle,
        friction=np.array(path.friction),
        load_factor=path.load_factor,
        slip=np.array(slip),
        gap=opening + gap,
        state=ContactState(
            slip, np.maximum(opening + gap, 0.0), *load, next_loads=path.cycle.corner_names[0]
        ),
        open=np.asarray((cycle.u[:, -n:] + gap > 0).any(axis=0)),
        slipping=slips
        & (path.friction > 0)
        & (cycle.slid > max(ROUNDING * max(1.0, far), cycle.change) * path.scales.length),
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
            (sentence,) * (left_out > 0),
            perf_counter() - path.started,
        ),
    )
