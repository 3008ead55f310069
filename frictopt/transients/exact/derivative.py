"""One cycle of a path, and how its end and its work of friction change with the state at its beginning.

Between two events the unknown motions are a fixed set a: the slips of slipping nodes, where `q + sense f p = 0`, and the slips and gaps of open ones,
where q = p = 0. All others, b, rest. The cycle is therefore piecewise linear in the state at its beginning, and on each stretch the derivative D
follows from that on the stretch before: the rows of b stay, and those of a solve `K_aa D_a = -K_ab D_b` with K the rows of these equations. As long
as nodes only begin to move, the rows of b are those from before the first of them began (the base). A motion that stops at an event in the middle of
a segment needs more: it stops where the event comes, and the event moves with the state.

The work of friction of a cycle is that of the loads less the elastic energy gained. By parts, it is the integral of `u . dr^w` over the cycle, less
`r . du` at its end, plus `r . du` at its beginning in the first order of a change du of the state `u = [v, w - g0]`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...contact.checks import Array, frozen
from ...contact.tolerances import CONDENSATION, ROUNDING
from ...errors import NoContinuation
from .kernel import OPEN, STICK
from .path import ExactPath

_INSTANT = ROUNDING / 10  # stretches of a segment shorter than this share of it lie between events that happen at once


@dataclass(frozen=True, eq=False)
class ReturnMap:
    """One cycle of a path with its derivative.

    Attributes
    ----------
    before, after
        (2N,) `u = [v, w - g0]` at its beginning and at its end, length.
    work
        Work of friction, force times length per depth.
    derivative
        (2N, 2N) derivative of `after` with respect to `before`.
    work_gradient
        (2N,) derivative of `work` with respect to `before`, force per depth.
    locked
        (N,) whether the node sticks all the time: its slip stays as it is.
    smooth
        Whether the derivative is the same in all directions. It is not where several events that happen at once stop a motion.
    status
        (E, N) statuses on each stretch between two events: 0 stick, +1 and -1 slip along +x and against it, 2 open.
    r
        (E, 2, 2N) reactions `[q, p]` at the beginning and at the end of each stretch, force per depth.

    Examples
    --------
    >>> import frictopt as fo
    >>> from frictopt.transients.exact import ExactPath, return_map
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = ExactPath(rod, cycle, friction=0.5, load_factor=1.0)
    >>> path.start()
    >>> path.run_cycle()
    >>> one = return_map(path)
    >>> one.locked.tolist(), round(one.work, 6), (one.derivative.diagonal()[:4].round(6) + 0.0).tolist()
    ([False, True, True, True], 1.0, [0.0, 1.0, 1.0, 1.0])
    """

    before: Array
    after: Array
    work: float
    derivative: Array
    work_gradient: Array
    locked: NDArray[np.bool_]
    smooth: bool
    status: NDArray[np.int8]
    r: Array
    _stretches: "tuple[tuple[_Growth, int], ...]"

    def motion_derivative(self, stretch: int, rows: Array) -> Array:
        """(m, 2N) `rows @ D`, with D the derivative of u on a stretch with respect to `before`; rows (m, 2N)."""
        growth, begun = self._stretches[stretch]
        return growth.reduced(rows, begun) @ growth.base


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
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> path = ExactPath(rod, cycle, friction=0.5, load_factor=1.0)
    >>> path.start()
    >>> path.run_cycle()
    >>> return_map(path).work, path.visited
    (1.0, 2)
    """
    return _Follower(path.recorded()).map()


class _Growth:
    """Motions that begin one after the other while none stops, and how they follow from those that rest.

    Their equations K are factored as L U without exchange of rows. So the leading blocks of the inverse factors are those of the motions that have
    begun first, and one factorisation serves all stretches.

    Parameters
    ----------
    S, factor
        (2N, 2N) stiffness, and (2N,) factor of p in the equation of each motion.
    base
        (2N, 2N) derivative of the motions that rest.
    order
        Those of u (2N,) that move, in the order in which they begin. It may grow until the factors are asked for.
    """

    def __init__(self, S: Array, factor: Array, base: Array, order: list[int]) -> None:
        self.S, self.factor, self.base, self.order = S, factor, base, order

    @cached_property
    def equations(self) -> Array:
        """(n, 2N) equations of the n that move."""
        slips = [motion for motion in self.order if self.factor[motion]]
        rows, places = self.S[self.order], np.flatnonzero(self.factor[self.order])
        rows[places] += self.factor[slips, None] * self.S[len(self.S) // 2 + np.array(slips, dtype=np.intp)]
        return rows

    @cached_property
    def inverses(self) -> tuple[Array, Array]:
        """(n, n) inverses of L and of U.

        Raises
        ------
        NoContinuation
            A pivot is none beside the stiffness of its motion: the rates are not unique.
        """
        n, K = len(self.order), self.equations[:, self.order]
        lower, upper = np.eye(n), np.eye(n)
        for k in range(n):
            row, column = K[k, :k] @ upper[:k, :k], lower[:k, :k] @ K[:k, k]
            pivot = K[k, k] - row @ column
            if not abs(pivot) > CONDENSATION * self.S[self.order[k], self.order[k]]:
                raise NoContinuation("derivative of a cycle: friction is critical at a node that slips, so that its rates are not unique")
            lower[k, :k] = -row @ lower[:k, :k]
            upper[:k, k], upper[k, k] = upper[:k, :k] @ column / -pivot, 1 / pivot
        return lower, upper

    def reduced(self, rows: Array, begun: int) -> Array:
        """(m, 2N) rows that give the same product with `base` as rows (m, 2N) with the derivative when so many motions have begun."""
        moving, (lower, upper) = self.order[:begun], self.inverses
        share = rows[:, moving] @ upper[:begun, :begun] @ lower[:begun, :begun]
        found = rows - share @ self.equations[:begun]
        found[:, moving] = 0.0
        return np.asarray(found)

    def integral(self, row: Array, stretches: list[tuple[int, float]]) -> Array:
        """(2N,) the sum over stretches, numbers of motions begun and lengths, of the derivative's product with a row (2N,)."""
        (lower, upper), after = self.inverses, np.zeros(len(self.order) + 1)
        for begun, length in stretches:
            after[begun] += length
        lasting = after[::-1].cumsum()[::-1]  # by number begun: the length of all stretches with at least so many
        share = (row[self.order] @ upper * lasting[1:]) @ lower
        return np.asarray((lasting[0] * row - share @ self.equations) @ self.base)

    def solve(self, right: Array) -> Array:
        """What all the motions are, by the right sides (n, ...) of their equations."""
        lower, upper = self.inverses
        return np.asarray(upper @ (lower @ right))

    def derivative(self) -> Array:
        """(2N, 2N) the derivative when all have begun."""
        found, rest = self.base.copy(), self.equations.copy()
        rest[:, self.order] = 0.0
        found[self.order] = -self.solve(rest @ self.base)
        return found


class _Follower:
    """Follows the cycle segment by segment and carries the derivative along."""

    def __init__(self, path: ExactPath) -> None:
        self.path, n = path, path.nodes
        self.status = path.state.status.copy()  # on the last stretch
        closed = np.r_[np.ones(n), self.status == OPEN]  # the gap of a closed node has no freedom
        self.growth = self._growth(np.full(n, STICK), np.diag(closed))
        self.gradient = np.zeros(2 * n)
        self.smooth = True
        self.kept: list[tuple[tuple[_Growth, int], np.ndarray, Array]] = []  # with statuses and reactions

    def map(self) -> ReturnMap:
        path, n = self.path, self.path.nodes
        before, start, work = path.state.u.copy(), path.state.r.copy(), path.state.work.sum()
        for leg in path.legs:
            self._segment(*leg)
        derivative = self.growth.derivative()
        stretches, status, reactions = zip(*self.kept, strict=True) if self.kept else ((), np.zeros((0, n), np.int8), np.zeros((0, 2, 2 * n)))
        return ReturnMap(
            before=frozen(before),
            after=frozen(path.state.u),
            work=float(path.state.work.sum() - work),
            derivative=frozen(derivative),
            work_gradient=frozen(self.gradient + start - path.state.r @ derivative),
            locked=(np.array(status) == STICK).all(axis=0),
            smooth=self.smooth,
            status=np.array(status),
            r=frozen(reactions),
            _stretches=tuple(stretches),
        )

    def _segment(self, corner: Array, where: str) -> None:
        path = self.path
        drive, begin = corner - path.bonded, path.visited
        path.history.clear()
        path.follow_to(corner, where)
        time, _, r, status, _ = (np.concatenate(parts) for parts in zip(*path.history, strict=True))
        length = np.diff(time - begin)
        turned = np.where(self.status == OPEN, OPEN, STICK).astype(np.int8)  # slipping nodes stick at the corner; the new direction says which slip
        self.growth, self.status = self._growth(turned, self.growth.derivative()), turned
        stretches: dict[_Growth, list[tuple[int, float]]] = {}
        for k in np.flatnonzero(length > _INSTANT):
            self._event(status[k], drive)
            begun = len(self.growth.order)
            stretches.setdefault(self.growth, []).append((begun, length[k]))
            self.kept.append(((self.growth, begun), status[k], r[k : k + 2]))
        for growth, own in stretches.items():
            self.gradient += growth.integral(drive, own)

    def _growth(self, status: np.ndarray, base: Array) -> _Growth:
        return _Growth(self.path.system.S, self._factor(status), base, np.flatnonzero(np.concatenate([status != STICK, status == OPEN])).tolist())

    def _factor(self, status: np.ndarray) -> Array:
        """(2N,) factor of p in the equations of motions under these statuses."""
        return np.concatenate([status * self.path.friction * (status != OPEN), np.zeros(len(status))])

    def _event(self, status: np.ndarray, drive: Array) -> None:
        """Carry the derivative over an event to the stretch with these statuses."""
        moving = np.concatenate([status != STICK, status == OPEN])
        if np.any((self.status != STICK) & (status != self.status)):  # some node stops, opens or closes
            base, stops = self.growth.derivative(), np.array(self.growth.order, dtype=np.intp)
            stops = stops[~moving[stops]]
            if len(stops):
                base[stops] += np.outer(self._rate(drive)[stops], self._delay(status, drive))
                base[len(status) :][status != OPEN] = 0.0
            self.growth = self._growth(status, base)
        else:
            moving[self.growth.order] = False
            self.growth.order += np.flatnonzero(moving).tolist()
            self.growth.factor = self._factor(status)
        self.status = status

    def _rate(self, drive: Array) -> Array:
        """(2N,) rates of u on the last stretch."""
        growth, rate = self.growth, np.zeros_like(drive)
        load = drive + growth.factor * np.tile(drive[self.path.nodes :], 2)
        rate[growth.order] = -growth.solve(load[growth.order])
        return rate

    def _delay(self, status: np.ndarray, drive: Array) -> Array:
        """(2N,) derivative of the time of an event that stops some motion: at it one node begins to slip, opens or closes."""
        n, opens, opened = self.path.nodes, status == OPEN, self.status == OPEN
        causes = np.flatnonzero((opens != opened) | ((self.status == STICK) & (status != STICK)))
        self.smooth = self.smooth and len(causes) == 1
        if not len(causes):
            return np.zeros(2 * n)
        node = int(causes[0])
        if opened[node]:
            row, load = np.eye(2 * n)[n + node], 0.0
        else:
            weights = (0.0, 1.0) if opens[node] else (1.0, float(status[node] * self.path.friction[node]))
            S = self.path.system.S
            row, load = weights[0] * S[node] + weights[1] * S[n + node], weights[0] * drive[node] + weights[1] * drive[n + node]
        growth = self.growth
        return np.asarray(-(growth.reduced(row[None], len(growth.order)) @ growth.base)[0] / (row @ self._rate(drive) + load))
