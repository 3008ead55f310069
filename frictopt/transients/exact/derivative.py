"""A cycle of a path: how its end and its work change with the state at its beginning.

Between two events some motions a move: the slips of slipping nodes, where `q + sense f p = 0`, and
the slips and gaps of open nodes, where q = p = 0. All other motions b rest. So the end of a cycle
is piecewise linear in the state at its beginning.

On each stretch between two events the rows b of the derivative D stay as they are. The rows a solve
`K_aa D_a = -K_ab D_b`, where K has the rows of the equations above. As long as nodes only begin to
move, the rows b are those from before the first node began (the base). A motion that stops within a
segment stops at an event, and the time of the event changes with the state.

The work of friction of a cycle is the work of the loads less the elastic energy gained. Integrate
it by parts: if the state `u = [v, w - g0]` changes by du, the work changes in first order by the
integral of `du . dr^w` over the cycle, less `r . du` at its end, plus `r . du` at its beginning.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from ...base import CONDENSATION, ROUNDING, Array, Booleans, frozen
from ...errors import NoContinuation
from .kernel import OPEN, STICK
from .path import ExactPath

_CRITICAL = (
    "derivative of a cycle: friction is critical at a node that slips, so that its rates are not "
    "unique"
)


@dataclass(frozen=True, eq=False)
class ReturnMap:
    """A cycle of a transient with its derivative, on the exact path or in increments.

    Attributes
    ----------
    before
        (M,) `u = [v, w - g0]` at its beginning, length.
    derivative
        (M, M) derivative of u at its end with respect to `before`. If several events of the exact
        path happen at once and stop a motion, the derivative may differ from direction to
        direction. Then it is the derivative by one of these events.
    work_gradient
        (M,) derivative of the work of friction with respect to `before`, force (per depth).
    status
        (E, N) statuses on each stretch between two events, or after each increment: 0 stick, +1 and
        -1 slip along +x and against it, 2 open.
    r
        (E, 2, M) reactions `[q, p]` at the beginning and at the end of each stretch, (E, 1, M)
        after each increment, force (per depth).
    motion_derivative
        Function of the number of a stretch and of rows (m, M). It returns `rows @ D` (m, M), where
        D is the derivative of u on that stretch with respect to `before`.

    Examples
    --------
    >>> import frictopt as fo
    >>> from frictopt.transients.exact import ExactPath, return_map
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> path = ExactPath(
    ...     rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    ... ).start()
    >>> path.follow(path.legs)
    []
    >>> one = return_map(path)
    >>> one.locked.tolist(), (one.derivative.diagonal()[:4].round(6) + 0.0).tolist()
    ([False, True, True, True], [0.0, 1.0, 1.0, 1.0])
    """

    before: Array
    derivative: Array
    work_gradient: Array
    status: NDArray[np.int8]
    r: Array
    motion_derivative: Callable[[int, Array], Array]

    @property
    def locked(self) -> Booleans:
        """(N,) whether each node sticks throughout the cycle, so that its slip does not change."""
        return np.asarray((self.status == STICK).all(axis=0))


def return_map(path: ExactPath) -> ReturnMap:
    """Follow one cycle of a path from its corner, and differentiate it; the path itself stays.

    Raises
    ------
    NoContinuation
        The path ends.

    Examples
    --------
    >>> import frictopt as fo
    >>> from frictopt.transients.exact import ExactPath, return_map
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> path = ExactPath(
    ...     rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    ... ).start()
    >>> return_map(path).status.shape, path.visited
    ((4, 4), 0)
    """
    path = path.recorded()
    n = path.nodes
    u_before = path.state.u.copy()
    r_before = path.state.r.copy()
    status = path.state.status.copy()

    # The gap of a closed node cannot be chosen.
    free = np.concatenate([np.ones(n), status == OPEN])
    growth = _growth(path, np.full(n, STICK), np.diag(free))
    integral = np.zeros(2 * n)
    stretches = list[_Stretch]()
    for corner, name in path.legs:
        drive = corner - path.bonded
        observed = _follow_leg(path, corner, name)

        # Slipping nodes stick at a corner. The new direction of the load says which ones slip.
        status = np.where(status == OPEN, OPEN, STICK)
        growth = _growth(path, status, growth.derivative())
        leg = list[_Stretch]()
        for length, next_status, r in observed:
            growth = _after_event(path, growth, status, next_status, drive)
            status = next_status
            leg.append(_Stretch(growth, len(growth.order), length, status, r))
        for moving, parts in groupby(leg, key=lambda stretch: stretch.growth):
            integral += moving.integral(drive, list(parts))
        stretches += leg
    derivative = growth.derivative()

    def motion_derivative(number: int, rows: Array) -> Array:
        stretch = stretches[number]
        reduced = stretch.growth.reduced(rows, stretch.begun)
        return reduced @ stretch.growth.base

    statuses = np.array([stretch.status for stretch in stretches], dtype=np.int8)
    reactions = np.array([stretch.r for stretch in stretches])
    return ReturnMap(
        before=frozen(u_before),
        derivative=frozen(derivative),
        work_gradient=frozen(integral + r_before - path.state.r @ derivative),
        status=statuses.reshape(-1, n),
        r=frozen(reactions.reshape(-1, 2, 2 * n)),
        motion_derivative=motion_derivative,
    )


def _follow_leg(
    path: ExactPath, corner: Array, name: str
) -> list[tuple[float, NDArray[np.int8], Array]]:
    """Follow a path to a corner. Return length, status (N,) and reactions (2, 2N) of stretches.

    The length is a share of the segment. Stretches between events that happen at once are left out.
    """
    begin = path.visited
    path.history.clear()
    path.follow_to(corner, name)
    time, _, r, status, _ = path.states()
    lengths = np.diff(time - begin)
    # A stretch shorter than this share of its segment lies between events that happen at once.
    instant = ROUNDING / 10
    return [
        (lengths[k], status[k].astype(np.int8), r[k : k + 2])
        for k in np.flatnonzero(lengths > instant)
    ]


@dataclass(eq=False)
class _Growth:
    """Motions that begin one after the other while none stops.

    Their equations K are factored as L U without exchange of rows. So the leading blocks of the
    inverse factors belong to the motions that begin first, and one factorisation serves all
    stretches.

    Attributes
    ----------
    S
        (2N, 2N) stiffness.
    factor
        (2N,) factor of p in the equation of each motion: the sense of slip times friction.
    base
        (2N, 2N) derivative of the state, of which the rows of motions that rest are used.
    order
        Numbers of the motions that move, in the order in which they begin. It may grow until the
        inverse factors are asked for.
    """

    S: Array
    factor: Array
    base: Array
    order: list[int]

    @cached_property
    def equations(self) -> Array:
        """(n, 2N) the equation of each motion in `order`."""
        moving = np.array(self.order, dtype=np.intp)
        is_slip = self.factor[moving] != 0
        slips = moving[is_slip]
        rows = self.S[moving]
        rows[is_slip] += self.factor[slips, None] * self.S[len(self.S) // 2 + slips]
        return rows

    @cached_property
    def inverses(self) -> tuple[Array, Array]:
        """(n, n) the inverses of L, which has a unit diagonal, and of U.

        NoContinuation if a pivot vanishes beside the stiffness of its motion: then the rates are
        not unique.
        """
        n = len(self.order)
        K = self.equations[:, self.order]
        lower = np.eye(n)
        upper = np.eye(n)
        for k in range(n):
            row = K[k, :k] @ upper[:k, :k]  # of L
            column = lower[:k, :k] @ K[:k, k]  # of U
            pivot = K[k, k] - row @ column
            stiffness = self.S[self.order[k], self.order[k]]
            if not abs(pivot) > CONDENSATION * stiffness:
                raise NoContinuation(_CRITICAL)
            lower[k, :k] = -row @ lower[:k, :k]
            upper[:k, k] = upper[:k, :k] @ column / -pivot
            upper[k, k] = 1 / pivot
        return lower, upper

    def reduced(self, rows: Array, begun: int) -> Array:
        """(m, 2N) R with `R @ base = rows @ D`, D the derivative when `begun` motions move."""
        lower, upper = self.inverses
        moving = self.order[:begun]
        weights = rows[:, moving] @ upper[:begun, :begun] @ lower[:begun, :begun]
        return rows - weights @ self.equations[:begun]

    def integral(self, row: Array, stretches: Sequence["_Stretch"]) -> Array:
        """(2N,) integral of `row @ D` over stretches, D the derivative on each of them."""
        lower, upper = self.inverses
        lengths = np.zeros(len(self.order) + 1)  # by the number of motions that have begun
        for stretch in stretches:
            lengths[stretch.begun] += stretch.length
        # By the same number: the length of all stretches on which at least so many have begun.
        lasting = lengths[::-1].cumsum()[::-1]
        weights = (row[self.order] @ upper * lasting[1:]) @ lower
        return np.asarray((lasting[0] * row - weights @ self.equations) @ self.base)

    def derivative(self) -> Array:
        """(2N, 2N) the derivative when all motions in `order` move."""
        lower, upper = self.inverses
        resting = self.equations.copy()
        resting[:, self.order] = 0.0
        derivative = self.base.copy()
        derivative[self.order] = -upper @ (lower @ (resting @ self.base))
        return derivative

    def rate(self, drive: Array) -> Array:
        """(2N,) rates of u under rates of the bonded reactions when all in `order` move."""
        lower, upper = self.inverses
        n = len(drive) // 2
        load = drive + self.factor * np.tile(drive[n:], 2)
        rate = np.zeros_like(drive)
        rate[self.order] = -upper @ (lower @ load[self.order])
        return rate


@dataclass(frozen=True, eq=False)
class _Stretch:
    """A part of a segment between two events, on which the first `begun` motions move."""

    growth: _Growth
    begun: int
    length: float  # share of the segment
    status: NDArray[np.int8]  # (N,)
    r: Array  # (2, 2N) reactions at its beginning and at its end


def _growth(path: ExactPath, status: NDArray[np.int8], base: Array) -> _Growth:
    """The motions under these statuses, which begin at once."""
    is_open = status == OPEN
    slip_factor = status * path.friction * ~is_open
    factor = np.concatenate([slip_factor, np.zeros(path.nodes)])
    moves = np.concatenate([status != STICK, is_open])
    return _Growth(path.system.S, factor, base, np.flatnonzero(moves).tolist())


def _after_event(
    path: ExactPath,
    growth: _Growth,
    before: NDArray[np.int8],
    status: NDArray[np.int8],
    drive: Array,
) -> _Growth:
    """The motions after an event that changes some statuses.

    `drive` (2N,) is the change of the bonded reactions on the segment. A motion stops when some
    node begins to slip, opens or closes: its end moves with the time of that event.
    """
    after = _growth(path, status, growth.base)
    nodes_only_begin = not np.any((before != STICK) & (status != before))
    if nodes_only_begin:
        begun = set(growth.order)
        growth.factor = after.factor
        growth.order += [motion for motion in after.order if motion not in begun]
        return growth

    after.base = growth.derivative()
    stops = np.setdiff1d(growth.order, after.order)
    if not len(stops):
        return after
    begins = (before == STICK) & (status != STICK)
    opens_or_closes = (status == OPEN) != (before == OPEN)
    causes = np.flatnonzero(opens_or_closes | begins)
    if len(causes):
        row, load_rate = _condition(path, int(causes[0]), before, status, drive)
        rate = growth.rate(drive)
        delay = -(row @ after.base) / (row @ rate + load_rate)  # (2N,) by the state before
        after.base[stops] += np.outer(rate[stops], delay)
    after.base[path.nodes :][status != OPEN] = 0.0
    return after


def _condition(
    path: ExactPath,
    node: int,
    before: NDArray[np.int8],
    status: NDArray[np.int8],
    drive: Array,
) -> tuple[Array, float]:
    """The quantity that vanishes at the event of a node: its gradient (2N,), and its rate by loads.

    A gap that closes, the pressure of a node that opens, or the distance `q + sense f p` of a node
    from the bound at which it begins to slip.
    """
    n = path.nodes
    weights = np.zeros(2 * n)
    if before[node] == OPEN:
        weights[n + node] = 1.0
        return weights, 0.0
    if status[node] == OPEN:
        weights[n + node] = 1.0
    else:
        weights[node] = 1.0
        weights[n + node] = status[node] * path.friction[node]
    return weights @ path.system.S, float(weights @ drive)
