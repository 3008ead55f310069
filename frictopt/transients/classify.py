"""What the last cycles of a transient show, as functions of them alone: `classify` says where they have come, `extrapolate` where they go."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, takewhile
from typing import NamedTuple

import numpy as np

from ..base import LEVEL, PERIODIC, REPEATED, RESIDUAL, ROUNDING, SAME_STATE, Array, Outcome
from ..contact import most_shear
from .transient import Cycle, Transient

LEAST = 4
"""Cycles with the same events before the first extrapolation, and cycles in turn that show a return after two."""

_NEAR = (
    100 * PERIODIC
    # the affine map is also tested where it moves by so little: other events may begin that near to the
    # extrapolated limit
)
_LITTLE = (
    100 * RESIDUAL
    # a pressure below this share of the mean one is too little to judge a slip by: its bounds have the
    # error of an answer
)
_AFFINE_FIT = (
    1e3 * RESIDUAL
    # deviation of a state from the linear map fitted to all states: the fit divides by small
    # differences
)
# cosine between the last slip of a node and its way to the limit, from which on it goes there
_AHEAD = 0.9
_SAFE = (
    RESIDUAL / 10
)  # excess over the friction bound, in force scales, of a safe slip: a part of the same residual


class Settled(NamedTuple):
    """A steady state: its outcome, the transient on it, its cycle, the relative error of its work, and the cycles by whose states it is judged."""

    outcome: Outcome
    path: Transient
    cycle: Cycle
    work_error: float
    judged: tuple[Cycle, ...]


def classify(
    path: Transient, cycle: Cycle, last: Sequence[Cycle], extrapolated: bool
) -> Settled | None:
    """The outcome that the latest cycle and the last ones, of which it is one unless it is the first, show; None where they do not tell.

    1. The slip at its end is safe at all corners: the contact is at rest.
    2. It comes back, and would do so after all later cycles (`distance_left`): slip repeats, or is
       none.
    3. Slip drifts by the same amount in every cycle, and the drift adds no stress and changes no
       gap.
    """
    if (resting := _at_rest(path, cycle)) is not None:
        return Settled(Outcome.SHAKEDOWN, path, resting, 0.0, (cycle, resting))
    if cycle.change <= PERIODIC and last:
        far = (
            max(1.0, float(np.abs(cycle.after).max())) if path.steps else 1.0
        )  # increments have rounding of the size of their slips
        left = (
            0.0
            if extrapolated or not cycle.work.any()
            else distance_left([one.change for one in last[-3:]], REPEATED * far)
        )
        slides = _slips(path, cycle, last[-2] if len(last) > 1 else None)
        if left <= RESIDUAL and slides is not None:
            return (
                Settled(Outcome.CYCLIC_SLIP, path, cycle, np.inf, (cycle,))
                if slides
                else without_work(path, cycle)
            )
    if not _ratchets(path, last):
        return None
    earlier, work = (float(one.work.sum()) for one in last[-2:])
    return Settled(
        Outcome.RATCHETING,
        path,
        replace(cycle, change=0.0),
        abs(work - earlier) / (work or 1.0),
        (cycle,),
    )


def without_work(path: Transient, cycle: Cycle) -> Settled:
    """Rest: a cycle whose work counts as none."""
    return Settled(Outcome.SHAKEDOWN, path, replace(cycle, work=0 * cycle.work), 0.0, (cycle,))


def _at_rest(path: Transient, cycle: Cycle) -> Cycle | None:
    """The cycle that follows, at rest: if the slip at the end keeps every node closed and within its bound at every corner, none slips any more."""
    u, loads, n = cycle.u[-1], np.array(path.corners), path.nodes
    if np.any(u[-n:] + path.system.gap > 0):
        return None
    r = loads + path.system.S @ u
    q, p = np.linalg.norm(r.reshape(len(r), -1, n)[:, :-1], axis=1), r[:, -n:]
    if not (
        np.minimum(most_shear(path.system, path.friction, p) - q, p) >= -_SAFE * path.scales.mean
    ).all():
        return None
    none = np.zeros(n)
    return replace(
        cycle,
        change=0.0,
        work=none,
        slid=none,
        bonded=loads,
        u=np.tile(u, (len(r), 1)),
        r=r,
        previous=None,
    )


def _slips(path: Transient, cycle: Cycle, earlier: Cycle | None) -> bool | None:
    """Whether some node slips in a cycle that comes back, by its work and that of the cycle before; None where it does not tell.

    A slip of 1e-9 slip scales of the mean load is none, under the node's own pressure (that of the
    mean load, if too little). Work is more than rounding if it is the same in two cycles, and
    without doubt if it is that of such a slip in slip scales of the largest corner force. If all
    nodes stay closed and have friction, little work may still decay to zero: rest needs a safe slip
    then.
    """
    if not cycle.work.any():
        return False
    (mean, force, length), n, work = path.scales, path.nodes, cycle.work
    pressure, far = (
        cycle.r[:, -n:].max(axis=0),
        float(np.abs(cycle.after).max()),
    )  # slips lose digits to their own size
    pressure = np.where(pressure > _LITTLE * mean, pressure, mean)
    unit = length * np.minimum(1.0, most_shear(path.system, path.friction, pressure) / pressure)
    if np.any(work > max(RESIDUAL, ROUNDING * far) * np.minimum(pressure, force) * unit):
        return True
    in_doubt = work > RESIDUAL * np.minimum(pressure, mean) * (mean / force) * unit
    if in_doubt.any():
        repeated = earlier is not None and (np.abs(work - earlier.work) <= LEVEL * work)
        return (
            True
            if np.any(
                in_doubt & repeated & (work > ROUNDING * np.maximum(force, far * pressure) * unit)
            )
            else None
        )
    lifts = cycle.u[:, -n:] + path.system.gap > 0
    return False if (path.friction == 0).any() or lifts.any() else None


def _ratchets(path: Transient, last: Sequence[Cycle]) -> bool:
    if len(last) < 3 or len({cycle.events for cycle in last[-3:]}) > 1:
        return False
    n, (before, end) = path.nodes, last[-2:]
    stress, opening = (
        np.abs(end.r[-1] - before.r[-1]).reshape(-1, n),
        np.abs(end.u[-1] - before.u[-1])[-n:],
    )
    held = (stress > PERIODIC * path.scales.force).any() or (
        opening > PERIODIC * end.change * path.scales.length
    ).any()
    same = (
        bend(last).max() <= PERIODIC * end.change
        and np.abs(end.work - before.work).max() <= PERIODIC * end.work.sum()
    )
    return bool(
        same
        and not held
        and PERIODIC * end.change > np.finfo(float).eps * float(np.abs(end.after).max())
    )


def bend(last: Sequence[Cycle]) -> Array:
    """(m,) by how much the last cycle moves otherwise than that before it."""
    before, end = last[-2:]
    return np.abs((end.after - end.before) - (before.after - before.before))


def work_error(path: Transient, cycles: Sequence[Cycle], slow: float) -> float:
    """Estimated distance of the last cycle's work from its limit, over itself; inf if the cycles do not tell.

    The smaller of two estimates. One is by the change of a state that is its limit up to rounding,
    and whose later changes add up to `slow` times this one: the work changes by at most some forces
    times it. The other is by the works of the last cycles, which differ by rounding if they do not
    come closer.
    """
    works, last = [float(cycle.work.sum()) for cycle in cycles[-4:]], cycles[-1]
    spread = 2 * len(last.u) * path.largest * float(np.abs(last.after - last.before) @ path.unit)
    by_change = spread * slow if last.change <= REPEATED else np.inf
    steps = [abs(later - earlier) for earlier, later in pairwise(works)]
    by_works = distance_left(steps, REPEATED * works[-1]) if steps else np.inf
    by_works = max(steps) if np.isinf(by_works) and len(steps) > 1 else by_works
    return min(by_change, by_works) / works[-1]


def work_to_come(last: Sequence[Cycle], limit: Cycle, none: Array) -> float:
    """Distance of the last cycle's work from that of the limit, over that, if a node may stop before the limit or beyond it; else 0.

    A node stops that slips in the last cycles, and in that of their limit does no more work than
    `none`. Until it does, it goes on as before: there are no other events in the last cycles, and
    its way to the limit has the direction of its last slip.
    """
    stops, end = (
        (limit.work <= none) & (np.array([cycle.work for cycle in last]) > none).any(axis=0),
        last[-1],
    )
    way, slip = (
        part.reshape(-1, len(none))[:, stops]
        for part in (limit.after - end.after, end.after - end.before)
    )
    ahead = (way * slip).sum(axis=0) >= _AHEAD * np.linalg.norm(way, axis=0) * np.linalg.norm(
        slip, axis=0
    )
    if (
        not stops.any()
        or (limit.work <= none).all()
        or (ahead.all() and all(cycle.events == limit.events for cycle in last))
    ):
        return 0.0
    return float(np.abs(end.work - limit.work).sum() / limit.work.sum())


def returns_after(path: Transient, cycle: Cycle) -> int:
    """Load cycles, 1 or 2, after which a return of two load cycles comes back, or its drift repeats."""
    middle = cycle.u[len(cycle.u) // 2 - 1, : len(path.unit)] / path.unit
    return 1 if np.abs(2 * middle - cycle.before - cycle.after).max() <= 2 * SAME_STATE else 2


Moves = list[tuple[Array, Array]]


def extrapolate(last: Sequence[Cycle]) -> Iterator[tuple[Array, Moves]]:
    """Where the last cycles with the same events go: limits of their affine map, and distances from it before and after a cycle, to test the map.

    All later states are weighted means of the limit, of the last state and of the states at these
    distances; the same distances close to the limit come first. The first limit uses all these
    cycles, later ones fewer: the first cycles may have another map, for the same events in another
    order.
    """
    same = len(list(takewhile(lambda cycle: cycle.events == last[-1].events, reversed(last))))
    for count in range(same, LEAST - 1, -2):
        if found := limit_of(
            np.array([last[-count].before, *(cycle.after for cycle in last[-count:])])
        ):
            limit, modes = found
            moves = [(last[-1].before - limit, last[-1].after - limit), *modes]
            shares = [_NEAR / max(_NEAR, np.abs(before - after).max()) for before, after in moves]
            yield (
                limit,
                [
                    *(
                        (share * before, share * after)
                        for share, (before, after) in zip(shares, moves, strict=True)
                    ),
                    *modes,
                ],
            )


def limit_of(iterates: Array) -> tuple[Array, Moves] | None:
    """The limit of an affine map from some of its iterates (rows), and states around it, before and after a cycle, of which all later ones are means.

    The limit is that of reduced-rank extrapolation. The k-th later distance from it is `sum of
    rate_i^k mode_i` with 1 > rate_1 > ... > rate_m >= 0. It is `rate_m^k` times the last distance,
    plus `rate_i^k - rate_(i + 1)^k` times the sum of the first i modes, for all i < m. The states
    are these sums, each times a number c_i. The later states are then weighted means of them, of
    the last state and of the limit, if the sum of `(rate_i^k - rate_(i + 1)^k) / c_i` is at most `1
    - rate_m^k` for all k. This always holds with c_i = 1; smaller c_i are used where they suffice.

    Returns None if no single linear map fits all distances, or if they do not decay monotonically:
    a rate is complex, negative or not below 1.
    """
    limit = fixed_point(np.stack([iterates[:-1], iterates[1:]], axis=1))
    distances = iterates - limit
    left, sizes, right = np.linalg.svd(distances[:-1].T, full_matrices=False)
    kept = sizes > PERIODIC
    basis = left[:, kept]
    step = basis.T @ distances[1:].T @ right[kept].T / sizes[kept]
    off = np.abs(distances[1:].T - basis @ step @ basis.T @ distances[:-1].T).max(axis=0)
    if np.any(off > PERIODIC + _AFFINE_FIT * np.abs(distances[:-1]).max(axis=1)):
        return None
    rates, vectors = np.linalg.eig(step)
    modes = basis @ vectors * np.linalg.solve(vectors, basis.T @ distances[-2])
    counted = np.abs(modes).max(axis=0, initial=0.0) > PERIODIC
    rates, modes = rates[counted], modes[:, counted]
    if (
        not len(rates)
        or np.any(np.abs(rates.imag) > 0)
        or np.any(rates.real < 0)
        or np.any(rates.real >= 1)
    ):
        return None
    order = np.argsort(-rates.real)
    rates, modes = rates.real[order], modes.real[:, order]
    powers = rates ** np.unique(np.geomspace(1, 1e6, 200).round())[:, None]
    shares = (-np.diff(powers, axis=1) / (1 - powers[:, -1:])).max(axis=0) * (len(rates) - 1)
    shares = shares if shares.max(initial=0.0) < 1 else np.ones_like(shares)
    before, after = (shares * np.cumsum(part, axis=1)[:, :-1] for part in (modes, modes * rates))
    return limit, list(zip(before.T, after.T, strict=True))


def fixed_point(returns: Array) -> Array:
    """The fixed point of a map by reduced-rank extrapolation from states and where it takes them, (k, 2, m); the first where one does not move."""
    before, steps = returns[:, 0], returns[:, 1] - returns[:, 0]
    if not np.linalg.norm(steps, axis=1).min() > 0:
        return np.asarray(before[0])
    return np.asarray(
        before[0]
        + np.linalg.lstsq(np.diff(steps, axis=0).T, -steps[0], rcond=ROUNDING)[0]
        @ np.diff(before, axis=0)
    )


def distance_left(changes: Sequence[float], rounding: float) -> float:
    """Estimated distance from the limit: the sum of all later changes, if they decay by the largest ratio of the last ones.

    A change up to `rounding` is the distance itself, whatever the ratio.
    """
    if changes[-1] <= rounding:
        return changes[-1]
    factor = max(
        (later / earlier if earlier > 0 else np.inf for earlier, later in pairwise(changes)),
        default=1.0,
    )
    return changes[-1] * factor / (1 - factor) if factor < 1 else np.inf
