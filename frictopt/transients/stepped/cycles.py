"""The cycles of a transient in increments, and what the last ones show of its steady state."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...contact.answers import Outcome
from ...contact.checks import Array
from ...contact.extrapolation import SLOW, distance_left, drift_text, limit_of
from ...contact.tolerances import NO_SLIP, PERIODIC, REPEATED, RESIDUAL, ROUNDING
from ...errors import NoContinuation, SolverError
from .path import Point, SteppedPath

__all__ = ["Run", "Settled", "SteppedCycle"]

_LEAST, _WINDOW = 4, 12  # least and largest number of returns with the same statuses that an extrapolation uses
_NEAR = 1e-3  # the map is also tested at this share of the distance from the extrapolated limit
_LINEAR = 1e-3  # largest deviation from a linear map, over the change, that is accepted
_APART = 1e-3  # estimated distance from two states that alternate, over the distance between them, from which on they are two


@dataclass(frozen=True, eq=False)
class SteppedCycle:
    """One cycle: work of friction and way slid per node, slip before and after, statuses of its increments, and all its states."""

    work: Array
    way: Array
    before: Array
    after: Array
    statuses: np.ndarray[Any, np.dtype[np.int8]]
    points: tuple[Point, ...]


@dataclass(frozen=True, eq=False)
class Settled:
    """A steady state: its outcome, the cycles of one return, the change of slip over them in slip scales, and the relative error of their work."""

    outcome: Outcome
    returning: Sequence[SteppedCycle]
    change: float
    work_error: float

    @property
    def dissipation(self) -> Array:
        """(N,) work of friction per cycle at each node."""
        work = np.mean([cycle.work for cycle in self.returning], axis=0)
        return np.asarray(0 * work if self.outcome is Outcome.SHAKEDOWN else work)


class Run:
    """The cycles of one transient so far."""

    def __init__(self, path: SteppedPath, overload: float | None, most: int, tell: Callable[[], Any]) -> None:
        self.path, self._overload, self._most, self._tell = path, overload, most, tell
        self.works: list[float] = []  # of all cycles that the transient itself made
        self.last: list[
            SteppedCycle
        ] = []  # the last of them; the first cycle starts at the mean load and not at the last corner, and is not among them
        self.cycles, self._tried, self._pause = 0, 0, 0
        self.extrapolated = False

    def settled(self) -> Settled:
        """The steady state."""
        path = self.path
        for load in [*path.legs(0), *(path.corners_at(self._overload) if self._overload is not None else ())]:
            for _ in path.follow_to(load):
                pass
        self.works.append(float(self._cycle().work.sum()))
        while self.cycles < self._most:
            self.last = [*self.last[-2 * _WINDOW :], self._cycle()]
            self.works.append(float(self.last[-1].work.sum()))
            for period in (1, 2):
                if (found := self._repeats(period) or self._ratchets(period)) is not None:
                    return found
            if self._pause:
                self._pause -= 1
            elif any(self._goes_on_at_limit(period) for period in (1, 2)):
                self._tried = 0
            elif len(self.last) >= _LEAST:
                self._tried += 1
                self._pause = self._tried
        raise self._given_up()

    def _cycle(self) -> SteppedCycle:
        path, points = self.path, [self.path.state]
        for corner in path.corners:
            points += path.follow_to(corner)
        self.cycles += 1
        self._tell()
        work, way = (np.sum([getattr(point, name) for point in points[1:]], axis=0) for name in ("work", "way"))
        statuses = np.array([point.status for point in points[1:]])
        return SteppedCycle(work, way, path.slip(points[0]), path.slip(points[-1]), statuses, tuple(points))

    def _distance(self, one: Array, other: Array) -> float:
        return float(np.abs(one - other).max()) / self.path.length

    def _returns(self, period: int, most: int) -> list[Array]:
        """The last slips, `period` cycles apart, at most so many and one."""
        slips = [self.last[0].before, *(cycle.after for cycle in self.last)] if self.last else []
        return slips[::-1][::period][: most + 1][::-1]

    def _slid(self, period: int) -> bool:
        """Whether some node slipped in the last cycles."""
        path, way = self.path, np.sum([cycle.way for cycle in self.last[-period:]], axis=0)
        return float(way.max()) / path.length > max(NO_SLIP * path.force / path.largest, ROUNDING)

    def _work_changes(self, period: int) -> list[float]:
        """Relative changes of the work from one to the next of the last returns."""
        works = [float(cycle.work.sum()) for cycle in self.last[::-1]]
        returns = [sum(works[k : k + period]) for k in range(0, len(works) - period + 1, period)][3::-1]
        return [abs(later - earlier) / returns[-1] for earlier, later in pairwise(returns)]

    def _repeats(self, period: int) -> Settled | None:
        """Shakedown or cyclic slip, if the slip has come back after `period` cycles."""
        slips = self._returns(period, 3)
        if len(slips) < 2:
            return None
        changes = [self._distance(*pair) for pair in pairwise(slips)]
        if changes[-1] > PERIODIC:
            return None
        if period == 1 and not self._slid(1):
            return Settled(Outcome.SHAKEDOWN, self.last[-1:], changes[-1], 0.0)
        works, rounding = self._work_changes(period), REPEATED * max(1.0, float(np.abs(slips[-1]).max()) / self.path.length)
        left = distance_left(changes, rounding)
        if not works or (period == 2 and left > _APART * self._distance(self.last[-1].after, self.last[-1].before)):
            return None
        still = max(changes[-2:]) <= rounding  # rounding may hide little work, but not where it goes
        off = works[-1] if changes[-1] <= rounding else distance_left(works, ROUNDING)
        repeats = still or max(left, off) <= RESIDUAL
        return Settled(Outcome.CYCLIC_SLIP, self.last[-period:], changes[-1], off) if repeats else None

    def _ratchets(self, period: int) -> Settled | None:
        """Ratcheting, if the slip drifts by the same amount in the last returns, and the drift changes no reaction."""
        slips = self._returns(period, 4)
        if len(slips) < 5:
            return None
        drifts = np.diff(slips, axis=0)
        size = float(np.abs(drifts[-1]).max()) / self.path.length
        force = float(np.abs(self.last[-1].points[-1].r - self.last[-1 - period].points[-1].r).max()) / self.path.largest
        if size <= PERIODIC or not self._slid(period) or force > PERIODIC:
            return None
        off = distance_left(self._work_changes(period), ROUNDING)
        left = distance_left([self._distance(*pair) / size for pair in pairwise(drifts)], ROUNDING)
        return Settled(Outcome.RATCHETING, self.last[-period:], 0.0, off) if max(left, off) <= RESIDUAL else None

    def _goes_on_at_limit(self, period: int) -> bool:
        """Go on from the limit of the last returns, if it is shown to be theirs; else the transient is where it was.

        Three things show it. A linear map fits the last returns, and its rates lie between 0 and 1. Cycles from the limit come back to it. And cycles
        from the last state, and from a few states whose weighted means are all later ones (`limit_of`), end where the linear map says, from afar
        and near the limit.
        """
        kept, unit = self.path.state, self.path.length
        signs = [cycle.statuses.tobytes() for cycle in self.last[::-1]]
        signs = [b"".join(signs[k : k + period]) for k in range(0, len(signs) - period + 1, period)]
        same = next((k for k, sign in enumerate(signs) if sign != signs[0]), len(signs))
        for count in range(min(same, _WINDOW), _LEAST - 1, -2):
            slips = np.array([slip.ravel() for slip in self._returns(period, count)])
            found = limit_of(slips / unit)
            if found is None:
                continue
            limit, modes = unit * found[0], found[1]
            tried = [(0 * limit, 0 * limit), (_NEAR * (slips[-2] - limit), _NEAR * (slips[-1] - limit))]
            tried += [(size * unit * before, size * unit * after) for before, after in modes for size in (1.0, _NEAR)]
            shown = all(
                self._leads(limit + before, limit + after, PERIODIC + _LINEAR * self._distance(before, after), period) for before, after in tried
            )
            self.path.state = kept
            if shown:
                self.path.moved_to(limit.reshape(self.path.system.slip_shape))
                self.last, self.extrapolated = [], True
            return shown
        return False

    def _leads(self, before: Array, after: Array, tolerance: float, period: int) -> bool:
        """Whether a return from one slip ends at another one."""
        shape = self.path.system.slip_shape
        try:
            self.path.moved_to(before.reshape(shape))
            if self._distance(self.path.slip(self.path.state), before.reshape(shape)) > PERIODIC:
                return False
            for _ in range(period):
                end = self._cycle().after
        except (NoContinuation, SolverError):
            return False
        return self._distance(end, after.reshape(shape)) <= tolerance

    def _given_up(self) -> NoContinuation:
        """The error that says why no steady state is reported, what to change, and what is known so far."""
        text = "give more cycles"
        if self.last:
            last, change = self.last[-1], self._distance(self.last[-1].after, self.last[-1].before)
            text = f"the slip still changes by {change:.1e} slip scales a cycle; give more cycles"
            if self._tried and len(self.last) > 1:
                earlier = self.last[-2]
                decay = self._distance(last.after - last.before, earlier.after - earlier.before) / change
                text = drift_text(change, decay) if decay < SLOW else text
        error = NoContinuation(f"steady state: no cycle comes back within most_cycles = {self._most}; {text}")
        path = self.path
        error.slip, error.gap, error.work = path.slip(path.state), path.state.u[-path.nodes :] + path.system.gap, np.array(self.works)
        return error

    def violation(self, cycle: SteppedCycle) -> float:
        """Violation of the contact law by the states of a cycle."""
        bonded, u, r = (np.array([getattr(point, name) for point in cycle.points[1:]]) for name in ("bonded", "u", "r"))
        previous = np.array([self.path.slip(point) for point in cycle.points[:-1]])
        return self.path.judged(u, r, bonded, self.path.largest, previous).residual
