"""What one cycle of a transient shows: whether it comes back, whether a node slips or opens in it, whether its slip is safe."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ...contact.checks import Array
from ...contact.extrapolation import distance_left
from ...contact.tolerances import LEVEL, LITTLE, REPEATED, RESIDUAL, ROUNDING, SAFE, SAME_STATE
from .cycle import Cycle
from .path import ExactPath

__all__ = ["Judge"]

Booleans = np.ndarray[Any, np.dtype[np.bool_]]


class Judge:
    """Judges cycles of a path. Slips are in units of the largest nodal force of the loads over the stiffness, see `scales`.

    Parameters
    ----------
    path
        The path.
    turns
        Numbers of the corners at which the load turns: a cycle stops at no others.
    """

    period = 1
    """Load cycles in one cycle of the path."""

    def __init__(self, path: ExactPath, turns: Sequence[int]) -> None:
        self.path, self.scales, self.turns, self.force, self.length = path, path.scales, turns, path.largest, path.length

    @property
    def _visited(self) -> list[int]:
        """Numbers of the corners that a cycle stops at, in order."""
        return [*self.turns] * self.period

    @property
    def _loads(self) -> list[Array]:
        """Bonded reactions (2N,) at the corners that a cycle stops at."""
        return [self.path.corners[number] for number in self._visited]

    def _distance(self, one: Array, other: Array) -> float:
        return float((np.abs(one - other) / np.resize(self.scales.length, one.shape)).max())

    def _change(self, cycle: Cycle) -> float:
        """Change of slip and gap over a cycle."""
        return self._distance(cycle.after, cycle.before)

    def _violation(self, corners: Sequence[tuple[Array, Array]]) -> float:
        """Violation of the contact law by states `u, r` at the corners of one cycle after another."""
        loads = self._loads * (len(corners) // len(self._visited))
        u, r, load = (np.array(rows) for rows in (*zip(*corners, strict=True), loads))
        return self.path.judged(u, r, load, self.force).residual

    def _safe(self, u: Array) -> bool:
        """Whether the slip keeps every node closed and within its bound at every corner."""
        path, n = self.path, self.path.nodes
        if np.any(u[n:] + path.state.gap > 0):
            return False
        q, p = np.split(np.array(path.corners) + path.stress(u), 2, axis=1)
        return bool((np.minimum(path.friction * p - np.abs(q), p) >= -SAFE * self.scales.mean).all())

    def _slips(self, cycle: Cycle, earlier: Cycle | None) -> bool | None:
        """Whether some node slips in a periodic cycle, by its work and that of the cycle before; None where it is too little to tell.

        A slip of 1e-9 slip scales of the mean load is none, under the node's own pressure (that of the mean load, if too little). Work is more
        than rounding if it is the same in two cycles, and without doubt if it is that of such a slip in slip scales of the largest corner force.
        """
        mean, force, length = self.scales
        pressure, unit = np.max([r[self.path.nodes :] for _, r in cycle.corners], axis=0), length * np.minimum(1.0, self.path.friction)
        pressure = np.where(pressure > LITTLE * mean, pressure, mean)
        far, work = self._distance(cycle.after, 0 * cycle.after), cycle.work  # slips lose digits to their own size
        if np.any(work > max(RESIDUAL, ROUNDING * far) * np.minimum(pressure, force) * unit):
            return True
        in_doubt = work > RESIDUAL * np.minimum(pressure, mean) * (mean / force) * unit
        before = np.full_like(work, np.inf) if earlier is None else earlier.work
        repeated = (np.abs(work - before) <= LEVEL * work) & (work > ROUNDING * np.maximum(force, far * pressure) * unit)
        return None if in_doubt.any() and not np.any(in_doubt & repeated) else bool(in_doubt.any())

    def _conclusive(self, cycle: Cycle, earlier: Cycle | None) -> bool:
        """Whether a periodic cycle decides: it slips; or it does not, and some node lifts off or has no friction.

        If all nodes stay closed and have friction, little work may still decay to zero: shakedown needs a safe slip.
        """
        slips = self._slips(cycle, earlier)
        return slips or (slips is False and bool((self.path.friction == 0).any() or self._open(cycle).any()))

    def _open(self, cycle: Cycle) -> Booleans:
        """(N,) whether each node is open at some corner at which the load turns."""
        return np.asarray(np.any([u[self.path.nodes :] + self.path.state.gap > 0 for u, _ in cycle.corners], axis=0))

    def _slipping(self, cycle: Cycle, change: float) -> Booleans:
        """(N,) whether each node slides against friction in a cycle, by more than rounding and than the change over it that is an error."""
        far = self._distance(cycle.after, 0 * cycle.after)
        return np.asarray((self.path.friction > 0) & (cycle.slid > max(ROUNDING * max(1.0, far), change) * self.scales.length))

    def _work_error(self, cycles: Sequence[Cycle], slow: float) -> float:
        """Estimated distance of the last cycle's work from its limit, over itself; inf if the cycles do not tell.

        The smaller of two estimates. One is by the change of a state that is its limit but for rounding, and whose later changes add up to `slow`
        times this one: the work changes by at most some forces times it. The other is by the works of the last cycles, which differ by rounding if
        they do not come closer.
        """
        works, last = [float(cycle.work.sum()) for cycle in cycles[-4:]], cycles[-1]
        spread = 2 * len(last.corners) * self.force * float(np.abs(last.after - last.before).sum())
        by_change = spread * slow if self._change(last) <= REPEATED else np.inf
        steps = [abs(later - earlier) for earlier, later in pairwise(works)]
        by_works = distance_left(steps, REPEATED * works[-1]) if steps else np.inf
        by_works = max(steps) if np.isinf(by_works) and len(steps) > 1 else by_works
        return min(by_change, by_works) / works[-1]

    def _returns_after(self, cycle: Cycle) -> int:
        """Load cycles after which a periodic state comes back, or a drift repeats."""
        if self.period == 1:
            return 1
        middle = cycle.corners[len(self.turns) - 1][0]
        return 1 if self._distance(2 * middle, cycle.before + cycle.after) <= 2 * SAME_STATE else 2
