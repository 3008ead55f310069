"""Outcome of the last cycles of a transient: `classify`, and estimates of the error of their work.

All functions depend on the cycles that they are given, and on nothing else.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..base import LEVEL, PERIODIC, REPEATED, RESIDUAL, ROUNDING, SAME_STATE, Array, Outcome
from .transient import FollowedCycle, Transient

# Largest pressure of a node, relative to the mean pressure, that may be no more than the error of
# an answer. The work of a slip is not measured by such a pressure.
_SMALL_PRESSURE = 100 * RESIDUAL
# Accepted excess of a shear force over its friction bound at a safe slip, in force scales. The
# excess is a part of the residual.
_EXCESS = RESIDUAL / 10


class Settled(NamedTuple):
    """A steady state.

    It contains the outcome, the transient in the steady state, its cycle, the estimated relative
    error of its work, and the cycles whose states are checked against the contact law.
    """

    outcome: Outcome
    path: Transient
    cycle: FollowedCycle
    work_error: float
    checked_cycles: tuple[FollowedCycle, ...]


def classify(
    path: Transient, cycle: FollowedCycle, last: Sequence[FollowedCycle], extrapolated: bool
) -> Settled | None:
    """The outcome that the last cycles prove; None if they prove none.

    `last` has the last cycles and ends with `cycle`. It is empty after the first cycle of a
    transient.

    1. The slip at the end of the cycle is safe at all corners: the contact is at rest.
    2. The slip at the end of the cycle equals the slip at its beginning, and will do so in all
       later cycles (`distance_left`): cyclic slip if the work repeats, rest if it is negligible.
    3. The slip drifts by the same amount in every cycle, and the drift adds no stress and changes
       no gap: ratcheting. At least three cycles are compared.
    """
    resting = _at_rest(path, cycle)
    if resting is not None:
        return Settled(Outcome.SHAKEDOWN, path, resting, 0.0, (cycle, resting))
    if last and cycle.change <= PERIODIC:
        comes_back = _comes_back(path, cycle, last, extrapolated)
        slips = _slips(path, cycle, last[-2] if len(last) > 1 else None)
        if comes_back and slips is not None:
            if slips:
                return Settled(Outcome.CYCLIC_SLIP, path, cycle, np.inf, (cycle,))
            return without_work(path, cycle)
    if not _ratchets(path, last):
        return None
    earlier, work = (float(returned.work.sum()) for returned in last[-2:])
    error = abs(work - earlier) / (work or 1.0)
    return Settled(Outcome.RATCHETING, path, replace(cycle, change=0.0), error, (cycle,))


def without_work(path: Transient, cycle: FollowedCycle) -> Settled:
    """Rest: a cycle whose work is negligible, and set to zero."""
    return Settled(Outcome.SHAKEDOWN, path, replace(cycle, work=0 * cycle.work), 0.0, (cycle,))


def _at_rest(path: Transient, cycle: FollowedCycle) -> FollowedCycle | None:
    """The next cycle, without slip, if the slip at the end of a cycle is safe; else None."""
    u = cycle.u[-1]
    n = path.nodes
    if np.any(u[-n:] + path.system.gap > 0):
        return None
    loads = np.array(path.corners)
    r = loads + path.system.S @ u
    q = np.linalg.norm(r.reshape(len(r), -1, n)[:, :-1], axis=1)
    p = r[:, -n:]
    margin = np.minimum(path.law.bound(p) - q, p)
    if not (margin >= -_EXCESS * path.scales.mean).all():
        return None
    zeros = np.zeros(n)
    states = np.tile(u, (len(r), 1))
    return replace(
        cycle, change=0.0, work=zeros, slid=zeros, bonded=loads, u=states, r=r, previous=None
    )


def _comes_back(
    path: Transient, cycle: FollowedCycle, last: Sequence[FollowedCycle], extrapolated: bool
) -> bool:
    """Whether not only the change of this cycle, but also the sum of all later changes is small."""
    if extrapolated or not cycle.work.any():
        return True
    # The rounding of increments is proportional to the size of their slips.
    size = max(1.0, float(np.abs(cycle.after).max())) if path.steps else 1.0
    changes = [returned.change for returned in last[-3:]]
    return distance_left(changes, REPEATED * size) <= RESIDUAL


def _slips(path: Transient, cycle: FollowedCycle, earlier: FollowedCycle | None) -> bool | None:
    """Whether some node slips in a cycle that comes back; None if its work does not decide.

    A slip of 1e-9 slip scales of the mean load is negligible. Its work is computed with the
    pressure of the node, or with the mean pressure if the pressure of the node is too small. Work
    above the work of a slip of 1e-9 slip scales of the largest corner force certainly shows slip.
    Work between these two limits shows slip if it is the same in two cycles and exceeds rounding.
    If all nodes stay closed and have friction, negligible work does not prove rest, because it may
    be decaying: then only a safe slip proves rest.
    """
    work = cycle.work
    if not work.any():
        return False
    n = path.nodes
    mean, force, length = path.scales
    pressure = cycle.r[:, -n:].max(axis=0)
    pressure = np.where(pressure > _SMALL_PRESSURE * mean, pressure, mean)
    shear_ratio = path.law.bound(pressure) / pressure
    unit = length * np.minimum(1.0, shear_ratio)
    # The rounding error of slips is proportional to their size.
    size = float(np.abs(cycle.after).max())
    if np.any(work > max(RESIDUAL, ROUNDING * size) * np.minimum(pressure, force) * unit):
        return True

    in_doubt = work > RESIDUAL * np.minimum(pressure, mean) * (mean / force) * unit
    if in_doubt.any():
        if earlier is None:
            return None
        repeated = np.abs(work - earlier.work) <= LEVEL * work
        exceeds_rounding = work > ROUNDING * np.maximum(force, size * pressure) * unit
        return True if np.any(in_doubt & repeated & exceeds_rounding) else None
    lifts = cycle.u[:, -n:] + path.system.gap > 0
    return False if (path.friction == 0).any() or lifts.any() else None


def _ratchets(path: Transient, last: Sequence[FollowedCycle]) -> bool:
    """Whether the last cycles drift by the same amount, without stress or change of gaps."""
    if len(last) < 3 or len({cycle.events for cycle in last[-3:]}) > 1:
        return False
    n = path.nodes
    before, end = last[-2:]
    stress = np.abs(end.r[-1] - before.r[-1]).reshape(-1, n)
    opening = np.abs(end.u[-1] - before.u[-1])[-n:]
    if (stress > PERIODIC * path.scales.force).any():
        return False
    if (opening > PERIODIC * end.change * path.scales.length).any():
        return False
    if bend(last).max() > PERIODIC * end.change:
        return False
    if np.abs(end.work - before.work).max() > PERIODIC * end.work.sum():
        return False
    # The tolerance of the drift must exceed the rounding of the slips.
    rounding = np.finfo(float).eps * float(np.abs(end.after).max())
    return bool(PERIODIC * end.change > rounding)


def bend(last: Sequence[FollowedCycle]) -> Array:
    """(m,) size of the difference between the displacements of the last two cycles."""
    before, end = last[-2:]
    return np.abs((end.after - end.before) - (before.after - before.before))


def work_error(path: Transient, cycles: Sequence[FollowedCycle], later_changes: float) -> float:
    """Estimated relative distance of the last cycle's work from its limit; inf if unknown.

    The smaller of two estimates is returned. The first estimate follows from the change of the
    state: the sum of all later changes is `later_changes` times the last change, and forces times
    this sum bound the change of work. This estimate is used only if the state is at its limit up to
    rounding. The second estimate follows from the works of the last cycles. If the differences of
    these works do not decrease, they are rounding.
    """
    last = cycles[-1]
    works = [float(cycle.work.sum()) for cycle in cycles[-4:]]
    by_change = np.inf
    if last.change <= REPEATED:
        path_length = float(np.abs(last.after - last.before) @ path.unit)
        by_change = 2 * len(last.u) * path.largest * path_length * later_changes

    by_works = np.inf
    steps = [abs(later - earlier) for earlier, later in pairwise(works)]
    if steps:
        by_works = distance_left(steps, REPEATED * works[-1])
    if np.isinf(by_works) and len(steps) > 1:
        by_works = max(steps)
    return min(by_change, by_works) / works[-1]


def work_to_come(last: Sequence[FollowedCycle], limit: FollowedCycle, no_work: Array) -> float:
    """Relative distance of the last work from the work at the limit; 0 if no node is yet to stop.

    A node is yet to stop if it slips in the last cycles, but has at most the work `no_work` (N,) at
    the limit. The distance is also 0 if no node has more work than `no_work` at the limit, or if
    the last cycles have the same events as the limit: then all these nodes have stopped.
    """
    end = last[-1]
    slipped = (np.array([cycle.work for cycle in last]) > no_work).any(axis=0)
    stops = (limit.work <= no_work) & slipped
    if not stops.any() or (limit.work <= no_work).all():
        return 0.0
    if all(cycle.events == limit.events for cycle in last):
        return 0.0
    return float(np.abs(end.work - limit.work).sum() / limit.work.sum())


def returns_after(path: Transient, cycle: FollowedCycle) -> int:
    """True period, 1 or 2 load cycles, if state or drift repeats after a return of two cycles."""
    middle = cycle.u[len(cycle.u) // 2 - 1, : len(path.unit)] / path.unit
    difference = np.abs(2 * middle - cycle.before - cycle.after).max()
    return 1 if difference <= 2 * SAME_STATE else 2


def distance_left(changes: Sequence[float], rounding: float) -> float:
    """Estimated sum of all changes after the last one of `changes`; inf if they do not decay.

    Each later change is taken as the change before it, times the largest ratio of two successive
    changes. A last change of at most `rounding` is returned as it is.
    """
    if changes[-1] <= rounding:
        return changes[-1]
    ratios = [later / earlier if earlier > 0 else np.inf for earlier, later in pairwise(changes)]
    ratio = max(ratios, default=1.0)
    return changes[-1] * ratio / (1 - ratio) if ratio < 1 else np.inf
