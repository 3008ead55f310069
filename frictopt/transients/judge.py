"""What one cycle of a transient shows: whether its slip is safe, whether a node slips in it, and how well its work is known."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..contact.tolerances import LEVEL, REPEATED, RESIDUAL, ROUNDING, SAME_STATE
from .begin import Cycle, Transient
from .extrapolation import distance_left

# A node's pressure below this share of the mean one is too little to judge its slip by: its bounds have the error of an answer.
_LITTLE = 100 * RESIDUAL
_SAFE = RESIDUAL / 10  # excess over the friction bound, in force scales, of a safe slip: a part of the same residual


def at_rest(path: Transient, cycle: Cycle) -> Cycle | None:
    """The cycle that follows, at rest: if the slip at the end keeps every node closed and within its bound at every corner, none slips any more."""
    u, loads, n = cycle.u[-1], np.array(path.corners), path.nodes
    if np.any(u[-n:] + path.system.gap > 0):
        return None
    r = loads + path.system.S @ u
    q, p = np.linalg.norm(r.reshape(len(r), -1, n)[:, :-1], axis=1), r[:, -n:]
    if not (np.minimum(path.friction * p - q, p) >= -_SAFE * path.scales.mean).all():
        return None
    none = np.zeros(n)
    return replace(cycle, change=0.0, work=none, slid=none, bonded=loads, u=np.tile(u, (len(r), 1)), r=r, previous=None)


def slips(path: Transient, cycle: Cycle, earlier: Cycle | None) -> bool | None:
    """Whether some node slips in a cycle that comes back, by its work and that of the cycle before; None where it does not tell.

    A slip of 1e-9 slip scales of the mean load is none, under the node's own pressure (that of the mean load, if too little). Work is more than
    rounding if it is the same in two cycles, and without doubt if it is that of such a slip in slip scales of the largest corner force. If all nodes
    stay closed and have friction, little work may still decay to zero: rest needs a safe slip then.
    """
    if not cycle.work.any():
        return False
    (mean, force, length), n, work = path.scales, path.nodes, cycle.work
    pressure, unit = cycle.r[:, -n:].max(axis=0), length * np.minimum(1.0, path.friction)
    pressure, far = np.where(pressure > _LITTLE * mean, pressure, mean), float(np.abs(cycle.after).max())  # slips lose digits to their own size
    if np.any(work > max(RESIDUAL, ROUNDING * far) * np.minimum(pressure, force) * unit):
        return True
    in_doubt = work > RESIDUAL * np.minimum(pressure, mean) * (mean / force) * unit
    if in_doubt.any():
        repeated = earlier is not None and (np.abs(work - earlier.work) <= LEVEL * work)
        return True if np.any(in_doubt & repeated & (work > ROUNDING * np.maximum(force, far * pressure) * unit)) else None
    lifts = cycle.u[:, -n:] + path.system.gap > 0
    return False if (path.friction == 0).any() or lifts.any() else None


def work_error(path: Transient, cycles: Sequence[Cycle], slow: float) -> float:
    """Estimated distance of the last cycle's work from its limit, over itself; inf if the cycles do not tell.

    The smaller of two estimates. One is by the change of a state that is its limit but for rounding, and whose later changes add up to `slow` times
    this one: the work changes by at most some forces times it. The other is by the works of the last cycles, which differ by rounding if they do not
    come closer.
    """
    works, last = [float(cycle.work.sum()) for cycle in cycles[-4:]], cycles[-1]
    spread = 2 * len(last.u) * path.largest * float(np.abs(last.after - last.before) @ path.unit)
    by_change = spread * slow if last.change <= REPEATED else np.inf
    steps = [abs(later - earlier) for earlier, later in pairwise(works)]
    by_works = distance_left(steps, REPEATED * works[-1]) if steps else np.inf
    by_works = max(steps) if np.isinf(by_works) and len(steps) > 1 else by_works
    return min(by_change, by_works) / works[-1]


def returns_after(path: Transient, cycle: Cycle) -> int:
    """Load cycles, 1 or 2, after which a return of two load cycles comes back, or its drift repeats."""
    middle = cycle.u[len(cycle.u) // 2 - 1, : len(path.unit)] / path.unit
    return 1 if np.abs(2 * middle - cycle.before - cycle.after).max() <= 2 * SAME_STATE else 2
