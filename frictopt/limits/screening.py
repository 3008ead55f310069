"""Load factors below which a node cannot be critical, from one slip mechanism for each node.

With multipliers d, a of the nodes for which `A d + B^T (f a) = 0`, the sum of `d q + f a p` over the nodes does not depend on the slip: it is that of
the mean load. A safe slip leaves every node `d q + f abs(d) p >= lam h(d)`, h(d) being the largest `-(d q1 + f abs(d) p1)` of a corner, and the
critical node j `q = lam c, p = lam rho`. So with `a = abs(d)` at all other nodes, though a_j = -1::

    resistance = sum of d q0 + f a p0   >=   lam drive,       drive = d_j c - f rho + sum of h(d) over the others

We look for such multipliers by fixed-point iteration for all nodes j at once. Where the iteration does not converge (large friction) the bound of
node j is 0.
"""

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import CONDENSATION, RESIDUAL
from .critical_state import needed
from .safe_set import SafeSet

_SETTLED = RESIDUAL  # change of a screening mechanism, over its size, that counts as none
_SCREENING = CONDENSATION  # relative rounding of a screening bound, which feels the errors of the data
_SPARE = 1e3 * RESIDUAL  # share by which a screening mechanism slips more than it must, so that it is admissible before it settles
_MOST = 300  # iterations
_MEANS = 3  # of slides in space; with more the bounds hardly rise
_NEAR = 1e-2  # share of the largest slip that a smaller one counts as in these means, which settle then
_LARGE = 1e6  # a mechanism of this size is on its way to infinity


def load_factor_bounds(v: SafeSet) -> Array:
    """(n,) lower bounds of the load factor at which each node can be critical; 0 where nothing is known, inf where it never can.

    Parameters
    ----------
    v
        Unknowns, units and question of the whole contact.
    """
    task = v.task
    if task.fixed:  # which corner rules depends on the load factor
        return np.zeros(len(task.friction))
    n, unit = len(task.friction), v.unit[:, None]
    slides = _Slides(v)
    total = -np.eye(n)  # columns: the mechanisms, each in units of the force of its nodes; rows: a
    for _ in range(_MOST):
        net = np.linalg.norm(slides.net(total), axis=0)
        size = unit * np.abs(total / unit).max(axis=0)
        following = (1 + _SPARE) * net + _SETTLED * size
        np.fill_diagonal(following, -1.0)
        np.fill_diagonal(net, -1.0)
        done = (net <= total).all(axis=0) & (np.abs(following - total) <= _SETTLED * size).all(axis=0)
        lost = ~(total.max(axis=0) < _LARGE)
        if (done | lost).all():
            break
        total = np.where(done | lost, total, following)
    d, fa, (shear, bound) = slides.net(total) / unit, task.friction[:, None] * total / unit, needed(task)
    held = np.array([_work(d, task.q0[0]), fa * task.p0[0][:, None]])
    driven = _work(d, shear) + total / unit * bound[:, None]
    if len(d) > 1:
        others = np.max([-_work(d, q1) - fa * p1[:, None] for q1, p1 in zip(task.q1, task.p1, strict=True)], axis=0)
        driven = np.where(np.eye(n, dtype=bool), driven, others)
    resistance, drive, terms = held.sum(axis=(0, 1)), driven.sum(axis=0), np.abs(held).sum(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        least = np.where(drive < 0, resistance / drive, np.inf) * (1 - _SCREENING)
    return np.asarray(np.where(done & (resistance < -_SCREENING * terms), least, 0.0))


def _work(d: Array, q: Array) -> Array:
    """Work (n, n) of shear forces (n,) or (n, 2) on slips (t, n, n): by node and mechanism."""
    return np.asarray(np.einsum("tij,it->ij", d, q.reshape(d.shape[1], -1)))


class _Slides:
    """The net slips d that balance given total slips a; where the body may slide as a whole, it does so until friction resists little."""

    def __init__(self, v: SafeSet) -> None:
        task, (rows, m), rows_of_shear = v.task, v.to_shear.shape, v.to_shear.toarray()
        n, others = len(v.unit), np.setdiff1d(np.arange(rows), v.loaded)
        right = np.hstack([v.to_pressure.T * task.friction, rows_of_shear[others].T])
        solved = -np.linalg.solve(rows_of_shear[v.loaded].T, right)
        self._follow, self._rigid, self._shape = np.zeros((rows, n)), np.zeros((rows, rows - m)), (rows // n, n, n)
        self._follow[v.loaded] = solved[:, :n]
        self._rigid[v.loaded], self._rigid[others] = solved[:, n:], np.eye(rows - m)
        hold = np.tile(np.maximum(task.friction * task.p0[0] / v.unit, 0.0), rows // n)
        self._hold = hold[:, None]
        median = rows == n and rows - m == 1 and bool(np.all(self._rigid != 0))
        self._slid = self._to_median if median else self._by_means if rows > max(n, m) else np.asarray

    def net(self, total: Array) -> Array:
        """(t, n, n) net slips of mechanisms with total slips (n, n)."""
        return np.asarray(self._slid(self._follow @ total).reshape(self._shape))

    def _to_median(self, net: Array) -> Array:
        """Slips along a line, to the slide of least resistance, which is their weighted median."""
        slides = net / self._rigid
        order = np.argsort(slides, axis=0)
        half = np.cumsum((self._hold * np.abs(self._rigid))[order, 0], axis=0)
        middle = np.argmax(half >= half[-1] / 2, axis=0)
        resting = order[middle, np.arange(order.shape[1])]
        return np.asarray(net - self._rigid * slides[resting, np.arange(len(resting))])

    def _by_means(self, net: Array) -> Array:
        """Slips in space, to a slide of little resistance, by weighted means, the weights of which are those of the slips before."""
        for _ in range(_MEANS):
            size = np.linalg.norm(net.reshape(self._shape), axis=0)
            weight = self._hold / np.tile(np.maximum(size, _NEAR * size.max() or 1.0), (self._shape[0], 1))
            square = np.einsum("rk,rj,rl->jkl", self._rigid, weight, self._rigid, optimize=True)
            net = net - self._rigid @ (np.linalg.pinv(square) @ (self._rigid.T @ (weight * net)).T[..., None])[..., 0].T
        return net
