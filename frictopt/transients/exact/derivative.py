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

import numpy as np
from numpy.typing import NDArray

from ...contact.checks import Array, frozen
from ...contact.tolerances import ROUNDING
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
    >>> one.locked.tolist(), round(one.work, 6), one.derivative.diagonal()[:4].round(6).tolist()
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
    _stretches: "tuple[_Stretch, ...]"

    def motion_derivative(self, stretch: int, rows: Array) -> Array:
        """(m, 2N) `rows @ D`, with D the derivative of u on a stretch with respect to `before`; rows (m, 2N)."""
        return self._stretches[stretch].apply(rows)


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


@dataclass(frozen=True, eq=False)
class _Stretch:
    """The stiffness, (2N,) which of u move between two events, the factor of p in their equations, and (2N, 2N) the derivative of those that rest."""

    S: Array
    moving: np.ndarray
    factor: Array
    base: Array

    def equations(self, columns: np.ndarray) -> Array:
        """(n, m) equations of the n that move, over some of u (2N,)."""
        places, along = np.flatnonzero(self.moving), np.flatnonzero(columns)
        slips = np.flatnonzero(self.factor[places])
        rows = self.S[np.ix_(places, along)]
        rows[slips] += self.factor[places[slips], None] * self.S[np.ix_(len(self.S) // 2 + places[slips], along)]
        return rows

    def reduced(self, rows: Array) -> Array:
        """(m, 2N) rows that give the same product with `base` as rows (m, 2N) with the derivative on this stretch."""
        share, n = np.zeros_like(rows), len(self.S) // 2
        share[:, self.moving] = np.linalg.solve(self.equations(self.moving).T, rows[:, self.moving].T).T
        share[:, n:] += share[:, :n] * self.factor[:n]
        return np.asarray(np.where(self.moving, 0.0, rows - share @ self.S))

    def apply(self, rows: Array) -> Array:
        """(m, 2N) rows times the derivative on this stretch."""
        return self.reduced(rows) @ self.base

    def derivative(self) -> Array:
        """(2N, 2N) the derivative on this stretch."""
        found, rest = self.base.copy(), ~self.moving
        found[self.moving] = np.linalg.solve(self.equations(self.moving), -self.equations(rest) @ self.base[rest])
        return found


class _Follower:
    """Follows the cycle segment by segment and carries the derivative along."""

    def __init__(self, path: ExactPath) -> None:
        self.path, n = path, path.nodes
        self.S = path.system.S
        self.status = path.state.status.copy()  # on the last stretch
        closed = np.r_[np.ones(n), self.status == OPEN]  # the gap of a closed node has no freedom
        self.stretch = self._stretch(np.full(n, STICK), np.diag(closed))
        self.gradient = np.zeros(2 * n)
        self.smooth = True
        self.kept: list[tuple[_Stretch, np.ndarray, Array]] = []  # with statuses and reactions

    def map(self) -> ReturnMap:
        path, n = self.path, self.path.nodes
        before, start, work = path.state.u.copy(), path.state.r.copy(), path.state.work.sum()
        for leg in path.legs:
            self._segment(*leg)
        derivative = self.stretch.derivative()
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
        path, n = self.path, self.path.nodes
        drive, begin = corner - path.bonded, path.visited
        path.history.clear()
        path.follow_to(corner, where)
        time, _, r, status, _ = (np.concatenate(parts) for parts in zip(*path.history, strict=True))
        length = np.diff(time - begin)
        turned = np.where(self.status == OPEN, OPEN, STICK).astype(np.int8)  # slipping nodes stick at the corner; the new direction says which slip
        self.stretch, self.status = self._stretch(turned, self.stretch.derivative()), turned
        sums = np.zeros((1, 2 * n))  # rows that give the gradient of the work with the base of this stretch
        for k in np.flatnonzero(length > _INSTANT):
            base = self.stretch.base
            self._event(status[k], drive)
            if self.stretch.base is not base:
                self.gradient += (sums @ base)[0]
                sums = np.zeros((1, 2 * n))
            sums += length[k] * self.stretch.reduced(drive[None])
            self.kept.append((self.stretch, status[k], r[k : k + 2]))
        self.gradient += (sums @ self.stretch.base)[0]

    def _stretch(self, status: np.ndarray, base: Array) -> _Stretch:
        opened = status == OPEN
        factor = np.r_[status * self.path.friction * ~opened, np.zeros(len(status))]
        return _Stretch(self.S, np.r_[status != STICK, opened], factor, base)

    def _event(self, status: np.ndarray, drive: Array) -> None:
        """Carry the derivative over an event to the stretch with these statuses."""
        moving = np.r_[status != STICK, status == OPEN]
        base = self.stretch.base
        if np.any((self.status != STICK) & (status != self.status)):  # some node stops, opens or closes
            base = self.stretch.derivative()
            stops = self.stretch.moving & ~moving
            if stops.any():
                base[stops] += np.outer(self._rate(drive)[stops], self._delay(status, drive))
                base[len(status) :][status != OPEN] = 0.0
        self.stretch, self.status = self._stretch(status, base), status

    def _rate(self, drive: Array) -> Array:
        """(2N,) rates of u on the last stretch."""
        n, moving = self.path.nodes, self.stretch.moving
        slips = self.status * (self.status != OPEN)
        load = np.r_[drive[:n] + slips * self.path.friction * drive[n:], drive[n:]]
        rate = np.zeros(2 * n)
        rate[moving] = np.linalg.solve(self.stretch.equations(moving), -load[moving])
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
            row, load = weights[0] * self.S[node] + weights[1] * self.S[n + node], weights[0] * drive[node] + weights[1] * drive[n + node]
        return np.asarray(-self.stretch.apply(row[None])[0] / (row @ self._rate(drive) + load))
