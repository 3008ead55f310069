"""The limit of the last cycles of a transient, and the proof that the transient approaches it.

The load cycle maps the slips at its beginning to the slips at its end. A fixed point of this map is
extrapolated from the last cycles (`fixed_point`). This fixed point need not be the limit of the
transient: other events may follow. Two kinds of proof exclude such events.

- `AffineLimit`, on the exact path. As long as the events are the same, the map is affine. All later
  states are weighted means of a few states, which `extrapolate` computes. One cycle from each of
  these few states shows whether the map is still affine there.
- `CurvedLimit`, in increments. The directions of slip change, so the map is nonlinear, and
  extrapolation is repeated. One cycle from the last state, and from two states between it and the
  fixed point, must come closer to the fixed point. A later extrapolation must give the same work.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import NamedTuple, TypeAlias

import numpy as np

from ..base import PERIODIC, REPEATED, RESIDUAL, ROUNDING, Array
from .classify import work_to_come
from .transient import FollowedCycle, Transient

Follow: TypeAlias = Callable[[Transient | None], FollowedCycle]
"""Function that follows one return of a transient; NoContinuation if it ends, or if it is None."""

Moves: TypeAlias = list[tuple[Array, Array]]
"""Distances (m,) of states from a limit, before and after a cycle, in slip scales."""


# The numbers of the search for a limit. Lengths are in slip scales.

# Least number of cycles with the same events before the first extrapolation.
_LEAST_CYCLES = 4
# Accepted deviation of a state from the linear map fitted to all states, relative to its distance
# from the limit. This deviation exceeds rounding, because the fit divides by small differences.
_FIT = 1e3 * RESIDUAL
# Accepted deviation of a cycle from the affine map, relative to the change of the state. Other
# events would cause a larger deviation.
_AFFINE = 1e-3
# Largest change of the state in tests close to the limit, where other events may begin.
_NEAR = 100 * PERIODIC

# Largest distance of a fixed point of the increments from the last state.
_FAR = 1e-2
# Ratio by which the change must fall from one extrapolation to the next.
_GAIN = 4.0
# The change must fall within a number of extrapolations: one, plus one for each such number of load
# cycles that the transient has followed.
_CYCLES_PER_TURN = 60
# Largest number of extrapolations within which the change must fall.
_MOST_TURNS = 6
# Positions of the tested states between the fixed point (0) and the last state (1).
_SHARES = (0.5, 0.1)
# Largest relative difference of the works at two fixed points that count as the same.
_SAME_WORK = 3e-8
# Estimated error of the work at the limit while nodes are yet to stop, as a share of the distance
# between the last work and the work at the limit. In random contacts it was at most 0.4 %.
_LATER_EVENTS = 1e-2
# Largest accepted relative error of the work.
_ACCEPTED = 1e-5


class Limit(NamedTuple):
    """A transient at the limit of the last returns, and a return from there."""

    path: Transient
    cycle: FollowedCycle


@dataclass
class LimitSearch(ABC):
    """A search for the limit of a transient, which is tried again as more returns follow.

    `attempts` counts the failures since the search began, or since the events changed. `wait` is
    the number of returns until the next attempt.
    """

    attempts: int = 0
    wait: int = 0

    @abstractmethod
    def find(
        self, path: Transient, last: Sequence[FollowedCycle], follow: Follow, cycles: int
    ) -> Limit | None:
        """The limit of the last returns, if the transient is proven to approach it.

        `cycles` is the number of load cycles of the transient so far.
        """

    def restart(self) -> None:
        """Forget the failures."""
        self.attempts = 0
        self.wait = 0

    def work_error(self) -> float:
        """Estimated relative error of the work at the limit; 0 on the exact path."""
        return 0.0


@dataclass
class AffineLimit(LimitSearch):
    """The search on the exact path. After its k-th failure it waits for k returns."""

    def find(
        self, path: Transient, last: Sequence[FollowedCycle], follow: Follow, cycles: int
    ) -> Limit | None:
        """See `LimitSearch`. A return from the limit must end there, and the map must be affine."""
        latest = last[-_LEAST_CYCLES:]
        same_events = len({cycle.events for cycle in latest}) == 1
        if not same_events or len(latest) < _LEAST_CYCLES:
            self.restart()
            return None
        if self.wait:
            self.wait -= 1
            return None
        self.attempts += 1
        self.wait = self.attempts
        for limit, moves in extrapolate(last):
            at_limit = path.at(limit)
            if at_limit is None:
                continue
            cycle = follow(at_limit)
            if cycle.change > PERIODIC or not _is_affine(path, limit, moves, follow):
                return None
            return Limit(at_limit, cycle)
        return None


def _is_affine(path: Transient, limit: Array, moves: Moves, follow: Follow) -> bool:
    """Whether cycles move states around a limit as the affine map does."""
    for before, after in moves:
        end = follow(path.at(limit + before)).after
        deviation = np.abs(end - limit - after).max()
        if deviation > PERIODIC + _AFFINE * np.abs(before - after).max():
            return False
    return True


@dataclass
class CurvedLimit(LimitSearch):
    """The search in increments.

    `fixed` is a return from the last fixed point, and `distance` the distance of the transient from
    it. `rates` are relative changes of the work from one fixed point to the next, divided by the
    way of the transient in between: the last two, because one change may be small by chance.
    `events_error` is the estimated relative error of its work due to nodes that are yet to stop.

    If some nodes stick in the last returns, there are other fixed points nearby. Later events of
    the transient shift the fixed point; the shift decreases as the transient approaches it. So a
    fixed point counts only if a fixed point extrapolated from a later state has the same work.
    """

    fixed: FollowedCycle | None = None
    distance: float = 0.0
    rates: tuple[float, float] = (0.0, 0.0)
    events_error: float = 0.0

    def find(
        self, path: Transient, last: Sequence[FollowedCycle], follow: Follow, cycles: int
    ) -> Limit | None:
        """See `LimitSearch`."""
        self.wait = max(self.wait - 1, 0)
        if self.wait or len(last) < _LEAST_CYCLES:
            return None
        self.attempts += 1
        latest = last[-1]
        sticks = np.abs(latest.after - latest.before) <= REPEATED
        start = np.where(sticks, latest.after, fixed_point(_ends(last)))
        if np.abs(start - latest.after).max() > _FAR:
            return None

        patience = min(1 + cycles // _CYCLES_PER_TURN, _MOST_TURNS)
        self.wait = _LEAST_CYCLES * patience
        iterated = _iterated(path, start, latest.change, patience, follow)
        if iterated is None:
            return None
        limit, turns = iterated
        approached = _is_approached(path, latest, limit.cycle, follow)
        earlier, self.fixed = self.fixed, limit.cycle
        farther, self.distance = self.distance, np.abs(latest.after - limit.cycle.after).max()
        if earlier is None or not approached:
            return None

        # The work (N,) of a negligible slip.
        no_work = RESIDUAL * path.scales.mean * path.scales.length
        distance = work_to_come(last[-_LEAST_CYCLES:], limit.cycle, no_work)
        self.events_error = turns * _LATER_EVENTS * distance
        self.wait = _LEAST_CYCLES * turns
        if self.events_error > _ACCEPTED:
            self.wait = max(self.wait, cycles // 4)
        total = limit.cycle.work.sum()
        change = np.abs(limit.cycle.work - earlier.work)
        shift = float(change.sum() / (total or 1.0))
        self.rates = self.rates[1], shift / max(farther - self.distance, RESIDUAL)
        is_same = (change <= _SAME_WORK * total + no_work).all()
        return limit if is_same and self.work_error() <= _ACCEPTED else None

    def work_error(self) -> float:
        """See `LimitSearch`. The fixed point shifts in proportion to the way that is left."""
        return max(self.distance * max(self.rates), self.events_error)


def _iterated(
    path: Transient, start: Array, change: float, patience: int, follow: Follow
) -> tuple[Limit, int] | None:
    """A fixed point of increments near a start, and a factor on its error; None if none is found.

    `change` is the change of the last return. Each extrapolation uses returns that start at the
    points found before. The change must fall to a quarter within `patience` extrapolations: the
    smallest of the last `patience` changes must be less than a quarter of each earlier change. The
    factor is 1 if the change falls to a quarter in each extrapolation, else `patience`.
    """
    changes = [change]
    returns: list[FollowedCycle] = []
    turns = 1
    point = start
    while True:
        at_point = path.at(point)
        if at_point is None:
            return None
        first = follow(at_point)
        if first.change <= PERIODIC:
            return Limit(at_point, first), turns
        changes.append(first.change)
        if not changes[-1] < changes[-2] / _GAIN:
            turns = patience
        earlier = min(changes[:-patience], default=np.inf)
        if not min(changes[-patience:]) < earlier / _GAIN:
            return None
        further = [follow(at_point) for _ in range(_LEAST_CYCLES)]
        returns = [first, *further, *returns][: (_LEAST_CYCLES + 1) * patience]
        point = fixed_point(_ends(returns))


def _is_approached(
    path: Transient, latest: FollowedCycle, at_limit: FollowedCycle, follow: Follow
) -> bool:
    """Whether the latest return comes closer to a fixed point, and other returns do so, too.

    The other returns begin at states between the end of the latest return and the fixed point.
    """
    limit = at_limit.after
    starts = [limit + share * (latest.after - limit) for share in _SHARES]
    cycles = [latest, *(follow(path.at(start)) for start in starts)]
    return all(
        np.linalg.norm(cycle.after - limit) < np.linalg.norm(cycle.before - limit)
        for cycle in cycles
    )


def _ends(cycles: Sequence[FollowedCycle]) -> Array:
    """(k, 2, m) the states before and after some cycles."""
    return np.array([(cycle.before, cycle.after) for cycle in cycles])


def extrapolate(last: Sequence[FollowedCycle]) -> Iterator[tuple[Array, Moves]]:
    """The limits of the affine map of the last cycles with the same events, and tests of the map.

    All later states are weighted means of the limit, of the last state, and of the states at the
    tested distances. The same distances, scaled to be close to the limit, are tested first. The
    first result uses all these cycles. Later results use fewer of these cycles, because the first
    cycles may have another map, if they have the same events in another order.
    """
    latest = list(takewhile(lambda cycle: cycle.events == last[-1].events, reversed(last)))
    for count in range(len(latest), _LEAST_CYCLES - 1, -2):
        states = [last[-count].before, *(cycle.after for cycle in last[-count:])]
        affine = limit_of(np.array(states))
        if affine is None:
            continue
        limit, modes = affine
        moves = [(last[-1].before - limit, last[-1].after - limit), *modes]
        close_moves = []
        for before, after in moves:
            share = _NEAR / max(_NEAR, np.abs(before - after).max())
            close_moves.append((share * before, share * after))
        yield limit, [*close_moves, *modes]


def limit_of(iterates: Array) -> tuple[Array, Moves] | None:
    """The limit of an affine map from some of its iterates (rows), and states around the limit.

    All later iterates are weighted means of these states, of the last state and of the limit. Each
    state is returned as its distances from the limit before and after a cycle. The limit follows
    from reduced-rank extrapolation.

    The k-th later distance from the limit is `sum of rate_i^k mode_i` with 1 > rate_1 > ... >
    rate_m >= 0. This distance is `rate_m^k` times the last distance, plus `rate_i^k - rate_(i +
    1)^k` times the sum of the first i modes, for all i < m. The states are these sums. No factor is
    negative, and all factors add up to `rate_1^k`, which is below 1.

    Returns None if no single linear map fits all distances, or if they do not decay monotonically:
    a rate is complex, negative or not below 1.
    """
    limit = fixed_point(np.stack([iterates[:-1], iterates[1:]], axis=1))
    distances = iterates - limit
    left, sizes, right = np.linalg.svd(distances[:-1].T, full_matrices=False)
    significant = sizes > PERIODIC
    basis = left[:, significant]
    step = basis.T @ distances[1:].T @ right[significant].T / sizes[significant]
    fitted = basis @ step @ basis.T @ distances[:-1].T
    deviation = np.abs(distances[1:].T - fitted).max(axis=0)
    if np.any(deviation > PERIODIC + _FIT * np.abs(distances[:-1]).max(axis=1)):
        return None

    rates, vectors = np.linalg.eig(step)
    modes = basis @ vectors * np.linalg.solve(vectors, basis.T @ distances[-2])
    counted = np.abs(modes).max(axis=0, initial=0.0) > PERIODIC
    rates = rates[counted]
    modes = modes[:, counted]
    is_real = not np.any(np.abs(rates.imag) > 0)
    decays = not np.any(rates.real < 0) and not np.any(rates.real >= 1)
    if not len(rates) or not is_real or not decays:
        return None

    order = np.argsort(-rates.real)
    rates = rates.real[order]
    modes = modes.real[:, order]
    before = np.cumsum(modes, axis=1)[:, :-1]
    after = np.cumsum(modes * rates, axis=1)[:, :-1]
    return limit, list(zip(before.T, after.T, strict=True))


def fixed_point(returns: Array) -> Array:
    """The fixed point of a map, extrapolated from states and their images, (k, 2, m).

    The method is reduced-rank extrapolation. If some state does not move, the first state is
    returned.
    """
    before = returns[:, 0]
    steps = returns[:, 1] - before
    if not np.linalg.norm(steps, axis=1).min() > 0:
        return np.asarray(before[0])
    weights = np.linalg.lstsq(np.diff(steps, axis=0).T, -steps[0], rcond=ROUNDING)[0]
    return np.asarray(before[0] + weights @ np.diff(before, axis=0))
