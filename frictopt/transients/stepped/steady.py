"""The steady state of a transient in increments, by cycles with extrapolation."""

from time import perf_counter

import numpy as np

from ...contact import ContactState
from ...contact.answers import Outcome
from ...contact.checks import frozen
from ...contact.parts import parted
from ...contact.progress import bar_of
from ...contact.record import SolveRecord
from ...contact.tolerances import RESIDUAL, ROUNDING
from ...errors import NoContinuation, SolverError
from ..begin import OPEN
from ..outcome import SteadyState
from .cycles import Run, Settled
from .path import SteppedPath, doubts

__all__ = ["settled_in_increments"]


def settled_in_increments(paths: list[SteppedPath], overload: float | None, most_cycles: int, progress: bool) -> SteadyState:
    """The steady state of the first path; the others, of fewer increments, tell its error.

    Raises
    ------
    NoContinuation
        No cycle comes back within `most_cycles`; its attributes say what is known by then.
    SolverError
        An increment has no valid answer, or the states violate the contact law by more than the tolerance.
    """
    with bar_of(progress, "steady state", "cycle", delay=2) as bar:
        fine, *coarse = [Run(path, overload, most_cycles, bar.update) for path in paths]
        found = fine.settled()
        work = float(found.dissipation.sum())
        error = max(_in_doubt(fine, found), max((_difference(work, run) for run in coarse), default=np.inf))
    residual = max(found.change, *(fine.violation(one) for one in found.returning))
    if not residual <= RESIDUAL:
        raise SolverError(
            f"steady state: the states violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g}); bring the loads of the cycle, or the "
            "initial slip and the loads, closer together in size"
        )
    path, end = fine.path, found.returning[-1].points[-1]
    (slip, gap), load = parted(end.u, path.system.tangents + 1), parted(end.bonded, path.system.tangents + 1)
    gap = gap + path.system.gap
    way = np.sum([one.way for one in found.returning], axis=0)
    slides = max(ROUNDING * max(path.length, float(np.abs(slip).max())), found.change * path.length)
    return SteadyState(
        outcome=found.outcome,
        dissipation=work,
        dissipation_per_node=frozen(found.dissipation),
        work_error=found.work_error,
        step_error=error,
        period=len(found.returning),
        system=path.system,
        cycle=path.cycle,
        friction=frozen(path.friction),
        load_factor=path.load_factor,
        slip=frozen(slip),
        gap=frozen(gap),
        state=ContactState(slip, np.maximum(gap, 0.0), *load),
        open=np.any([one.statuses == OPEN for one in found.returning], axis=(0, 1)),
        slipping=(way > slides) & (found.dissipation > 0),
        first_cycle=fine.works[0],
        cycles=fine.cycles,
        events=path.events,
        extrapolated=fine.extrapolated,
        unproven=path.events,
        steps=path.steps,
        record=SolveRecord("NEWTON", (), residual, (), perf_counter() - path.started),
    )


def _difference(work: float, coarse: Run) -> float:
    """Relative difference of the work from that of fewer increments."""
    try:
        other = float(coarse.settled().dissipation.sum())
    except (NoContinuation, SolverError):
        return np.inf
    return abs(work - other) / max(work, other) if max(work, other) > 0 else 0.0


def _in_doubt(run: Run, found: Settled) -> float:
    """Share of the work that is in doubt within the increments of one return."""
    if found.outcome is Outcome.SHAKEDOWN:
        return 0.0
    first, *points = [point for one in found.returning for point in one.points[one is not found.returning[0] :]]
    lacking, change, _ = doubts(run.path.friction, [first._replace(r=points[-1].r), *points])  # the reactions come back
    return float(np.sqrt(lacking.sum() * change.sum()) / np.sum([one.work for one in found.returning]))
