"""A cycle of a path, and how its end and its work of friction change with the state at its beginning.

Between two events some motions a move: the slips of slipping nodes, where `q + sense f p = 0`, and
the slips and gaps of open ones, where q = p = 0. All others, b, rest. So the cycle is piecewise
linear in the state at its beginning. On each stretch the rows b of the derivative D stay, and the
rows a solve `K_aa D_a = -K_ab D_b` with K the rows of these equations. As long as nodes only begin
to move, the rows of b are those from before the first of them began (the base). A motion that stops
within a segment stops where an event comes, and the event moves with the state.

The work of friction of a cycle is that of the loads less the elastic energy gained. By parts its
change in the first order of a change du of the state `u = [v, w - g0]` is the integral of `du .
dr^w` over the cycle, less `r . du` at its end, plus `r . du` at its beginning.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...base import CONDENSATION, ROUNDING, Array, Booleans, frozen
from ...errors import NoContinuation
from .kernel import OPEN, STICK
from .path import ExactPath

_INSTANT = (
    ROUNDING / 10
)  # stretches of a segment shorter than this share of it lie between events that happen at once


@dataclass(frozen=True, eq=False)
class ReturnMap:
    """A cycle of a transient with its derivative: exact, or of increments.

    Attributes
    ----------
    before
        (M,) `u = [v, w - g0]` at its beginning, length.
    derivative
        (M, M) derivative of u at its end with respect to `before`. On the exact path it may differ
        from direction to direction where several events that happen at once stop a motion; it is
        then that of one of them.
    work_gradient
        (M,) derivative of the work of friction with respect to `before`, force (per depth).
    status
        (E, N) statuses on each stretch between two events, or after each increment: 0 stick, +1 and
        -1 slip along +x and against it, 2 open.
    r
        (E, 2, M) reactions `[q, p]` at the beginning and at the end of each stretch, (E, 1, M)
        after each increment, force (per depth).
    motion_derivative
        (m, M) `rows @ D`, from the number of a stretch and rows (m, M), with D the derivative of u
        there with respect to `before`.

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
        """(N,) whether the node sticks all the time: its slip stays as it is."""
        return np.asarray((self.status == STICK).all(axis=0))


def return_map(path: ExactPath) -> ReturnMap:
    """Follow one cycle from the corner at which a path is, and take its derivative along its events; the path stays where it is.

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
    n, last, before, start = (
        path.nodes,
        path.state.status.copy(),
        path.state.u.copy(),
        path.state.r.copy(),
    )
    closed = np.r_[np.ones(n), last == OPEN]  # the gap of a closed node has no freedom
    growth, gradient = _growth(path, np.full(n, STICK), np.diag(closed)), np.zeros(2 * n)
    kept: list[
        tuple[_Growth, int, NDArray[np.int8], Array]
    ] = []  # on each stretch, with statuses and reactions
    for corner, where in path.legs:
        drive, begin = corner - path.bonded, path.visited
        path.history.clear()
        path.follow_to(corner, where)
        time, _, r, status, _ = path.states()
        length = np.diff(time - begin)
        last = np.where(
            last == OPEN, OPEN, STICK
        )  # slipping nodes stick at the corner; the new direction says which slip
        growth = _growth(path, last, growth.derivative())
        stretches: dict[_Growth, list[tuple[int, float]]] = {}
        for k in np.flatnonzero(length > _INSTANT):
            growth, last = _after_event(path, growth, last, status[k], drive), status[k]
            stretches.setdefault(growth, []).append((len(growth.order), length[k]))
            kept.append((growth, len(growth.order), last.astype(np.int8), r[k : k + 2]))
        for one, own in stretches.items():
            gradient += one.integral(drive, own)
    derivative = growth.derivative()

    def motion_derivative(stretch: int, rows: Array) -> Array:
        one, begun, *_ = kept[stretch]
        return np.asarray(one.reduced(rows, begun) @ one.base)

    return ReturnMap(
        before=frozen(before),
        derivative=frozen(derivative),
        work_gradient=frozen(gradient + start - path.state.r @ derivative),
        status=np.array([status for *_, status, _ in kept], dtype=np.int8).reshape(-1, n),
        r=frozen(np.reshape([r for *_, r in kept], (-1, 2, 2 * n))),
        motion_derivative=motion_derivative,
    )


@dataclass(eq=False)
class _Growth:
    """Motions that begin one after the other while none stops, and how they follow from those that rest.

    Their equations K are factored as L U without exchange of rows. So the leading blocks of the
    inverse factors are those of the motions that have begun first, and one factorisation is enough
    for all stretches. `factor` (2N,) is that of p in the equation of each motion, `base` (2N, 2N)
    the derivative of those that rest. `order` are those of u (2N,) that move, as they begin; it may
    grow until the factors are asked for.
    """

    S: Array
    factor: Array
    base: Array
    order: list[int]

    @cached_property
    def equations(self) -> Array:
        """(n, 2N) equations of the n that move."""
        slips = [motion for motion in self.order if self.factor[motion]]
        rows, places = self.S[self.order], np.flatnonzero(self.factor[self.order])
        rows[places] += (
            self.factor[slips, None] * self.S[len(self.S) // 2 + np.array(slips, dtype=np.intp)]
        )
        return rows

    @cached_property
    def inverses(self) -> tuple[Array, Array]:
        """(n, n) inverses of L and of U; NoContinuation if a pivot is none beside the stiffness of its motion: the rates are not unique."""
        n, K = len(self.order), self.equations[:, self.order]
        lower, upper = np.eye(n), np.eye(n)
        for k in range(n):
            row, column = K[k, :k] @ upper[:k, :k], lower[:k, :k] @ K[:k, k]
            pivot = K[k, k] - row @ column
            if not abs(pivot) > CONDENSATION * self.S[self.order[k], self.order[k]]:
                raise NoContinuation(
                    "derivative of a cycle: friction is critical at a node that slips, so that "
                    "its rates are not unique"
                )
            lower[k, :k] = -row @ lower[:k, :k]
            upper[:k, k], upper[k, k] = upper[:k, :k] @ column / -pivot, 1 / pivot
        return lower, upper

    def reduced(self, rows: Array, begun: int) -> Array:
        """(m, 2N) rows that give the same product with `base` as rows (m, 2N) with the derivative when so many motions have begun."""
        moving, (lower, upper) = self.order[:begun], self.inverses
        share = rows[:, moving] @ upper[:begun, :begun] @ lower[:begun, :begun]
        return np.asarray(rows - share @ self.equations[:begun])

    def integral(self, row: Array, stretches: list[tuple[int, float]]) -> Array:
        """(2N,) the sum over stretches, numbers of motions begun and lengths, of the derivative's product with a row (2N,)."""
        (lower, upper), after = self.inverses, np.zeros(len(self.order) + 1)
        for begun, length in stretches:
            after[begun] += length
        lasting = after[::-1].cumsum()[
            ::-1
        ]  # by number begun: the length of all stretches with at least so many
        share = (row[self.order] @ upper * lasting[1:]) @ lower
        return np.asarray((lasting[0] * row - share @ self.equations) @ self.base)

    def derivative(self) -> Array:
        """(2N, 2N) the derivative when all have begun."""
        (lower, upper), found, rest = self.inverses, self.base.copy(), self.equations.copy()
        rest[:, self.order] = 0.0
        found[self.order] = -upper @ (lower @ (rest @ self.base))
        return found

    def rate(self, drive: Array) -> Array:
        """(2N,) rates of u under rates of the bonded reactions when all have begun."""
        (lower, upper), rate = self.inverses, np.zeros_like(drive)
        load = drive + self.factor * np.tile(drive[len(drive) // 2 :], 2)
        rate[self.order] = -upper @ (lower @ load[self.order])
        return rate


def _growth(path: ExactPath, status: NDArray[np.int8], base: Array) -> _Growth:
    """The motions under these statuses, which begin at once."""
    factor = np.concatenate([status * path.friction * (status != OPEN), np.zeros(path.nodes)])
    return _Growth(
        path.system.S,
        factor,
        base,
        np.flatnonzero(np.concatenate([status != STICK, status == OPEN])).tolist(),
    )


def _after_event(
    path: ExactPath,
    growth: _Growth,
    before: NDArray[np.int8],
    status: NDArray[np.int8],
    drive: Array,
) -> _Growth:
    """The motions after an event that takes some statuses to others, on a segment that changes the bonded reactions by `drive`.

    A motion that stops does so when some node begins to slip, opens or closes: its end moves with
    the time of that event.
    """
    new, n, opens, opened = (
        _growth(path, status, growth.base),
        path.nodes,
        status == OPEN,
        before == OPEN,
    )
    if not np.any((before != STICK) & (status != before)):  # nodes only begin to move
        growth.factor, begun = new.factor, set(growth.order)
        growth.order += [motion for motion in new.order if motion not in begun]
        return growth
    new.base = growth.derivative()
    stops = np.setdiff1d(growth.order, new.order)
    causes = np.flatnonzero((opens != opened) | ((before == STICK) & (status != STICK)))
    if len(stops):
        if len(causes):
            node, rate, weights = int(causes[0]), growth.rate(drive), np.zeros(2 * n)
            weights[node], weights[n + node] = (
                (0.0, 1.0) if opens[node] else (1.0, status[node] * path.friction[node])
            )
            row, load = (
                (np.eye(2 * n)[n + node], 0.0)
                if opened[node]
                else (weights @ growth.S, weights @ drive)
            )
            new.base[stops] -= np.outer(rate[stops], (row @ new.base) / (row @ rate + load))
        new.base[n:][~opens] = 0.0
    return new
