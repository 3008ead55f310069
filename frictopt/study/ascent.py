"""Steps towards periodic orbits with more or less work of friction, over the slips of the nodes that stay locked.

The work of a periodic orbit depends on its start only through the locked slips. A step is a linear
program: the change of the locked slips, within a trust region, that changes the work most, while
every locked node stays within its bound at every event. In space four tangents stand for its
friction circle, one of them at the shear itself. All other motions follow, because the orbit stays
periodic. The answer is only proposed; the transient from it decides.
"""

from copy import copy
from typing import cast

import numpy as np
from scipy.optimize import linprog

from ..base import CONDENSATION, ROUNDING, Array
from ..contact import parted
from ..transients.transient import OPEN, STICK, Transient
from ..transients.exact import ExactPath, ReturnMap, return_map
from ..transients.stepped import Point, SteppedPath

# motions that a cycle changes by less than this share stay as they are: the data have this error
_STAYING = CONDENSATION
# events whose bounds each locked node keeps in the program: the ones where it has least reserve
_TIGHTEST = 2


class Ascent:
    """Changes of a periodic orbit, by which its work grows (sense 1) or falls (sense -1); NoContinuation, SolverError: its cycle has no derivative.

    The path is on the orbit, at the last corner, where the slip is `before`, (N,) or (N, 2),
    length, and at most `most`, (N,), if that is given.
    """

    def __init__(self, path: Transient, sense: int, most: Array | None) -> None:
        tangents, n = path.system.tangents, path.nodes
        cycle = (
            increment_map(path)
            if isinstance(path, SteppedPath)
            else return_map(cast(ExactPath, path))
        )
        self.path, self._most, self._before = path, most, cycle.before[:-n].reshape(tangents, n)
        self.before, _ = parted(cycle.before, tangents + 1)
        follow = _followed(cycle, tangents)
        self._slip = follow[:-n].reshape(tangents, n, -1)
        self._gain = sense * (cycle.work_gradient @ follow)
        self._bounds = _bounds(path, cycle, follow) if self._gain.any() else None

    def step(self, radius: float) -> tuple[Array, float] | None:
        """The change of the slip, (N,) or (N, 2), by at most a radius at a locked node, length, that changes the work most; and by how much, >= 0.

        The latter is of first order. None where no node is locked, nothing changes the work, or the
        slip exceeds its bound already.
        """
        if self._bounds is None:
            return None
        rows, right = self._bounds
        if self._most is not None:
            unit = np.maximum(self._most, radius)
            for way in _tangents(self._before):
                rows = np.vstack([rows, -np.einsum("tn,tnx->nx", way / unit, self._slip)])
                right = np.concatenate(
                    [right, (self._most - (way * self._before).sum(axis=0)) / unit]
                )
        near = (
            radius * np.abs(rows).sum(axis=1) > right
        )  # no change within the region meets the other rows
        box, cost = np.eye(len(self._gain)), np.r_[right[near], np.ones(2 * len(self._gain))]
        balance = np.hstack(
            [-radius * rows[near].T, box, -box]
        )  # of the dual program, which has fewer rows: its multipliers are the changes
        answer = linprog(
            cost,
            A_eq=balance,
            b_eq=self._gain / np.abs(self._gain).max(),
            options={"presolve": False},
        )
        if answer.status != 0:
            return None
        locked = radius * answer.eqlin.marginals
        change = self._slip @ locked
        return change[0] if len(change) == 1 else change.T, float(self._gain @ locked)


def _followed(cycle: ReturnMap, tangents: int) -> Array:
    """(M, L) changes of the state of a periodic orbit with the L slips of its locked nodes."""
    locked = np.r_[np.tile(cycle.locked, tangents), np.zeros_like(cycle.locked)]
    follow = np.zeros((len(locked), int(locked.sum())))
    follow[locked] = np.eye(follow.shape[1])
    others = ~locked & (cycle.derivative != 0).any(axis=1)
    if others.any():
        own, locks = (
            cycle.derivative[np.ix_(others, others)],
            cycle.derivative[np.ix_(others, locked)],
        )
        follow[others] = np.linalg.lstsq(np.eye(len(own)) - own, locks, rcond=_STAYING)[0]
    return follow


def _bounds(path: Transient, cycle: ReturnMap, follow: Array) -> tuple[Array, Array]:
    """Rows of `rows @ change + reserve >= 0`, and the reserves: bounds of locked nodes at their tightest events, over the node's bound there."""
    n, nodes, f, S = path.nodes, np.flatnonzero(cycle.locked), path.friction, path.system.S
    q, p = cycle.r[..., :-n].reshape(*cycle.r.shape[:2], -1, n), cycle.r[..., -n:]
    stiffness, size = S[:-n].reshape(-1, n, len(S)), 1e-3 * float(np.abs(p).mean())
    rows, right = [], []
    for ways in _tangents(q):
        reserve = (f * p - (ways * q).sum(axis=2))[:, -1, nodes]
        tightest = np.argsort(reserve, axis=0, kind="stable")[:_TIGHTEST]
        for stretch in np.unique(tightest):
            column = np.flatnonzero((tightest == stretch).any(axis=0))
            chosen, way = nodes[column], ways[stretch, -1]
            scale = (f * np.abs(p[stretch, -1]))[chosen] + size
            own = f[chosen, None] * S[-n:][chosen] - np.einsum(
                "tn,tnm->nm", way[:, chosen], stiffness[:, chosen]
            )
            rows.append(cycle.motion_derivative(stretch, own) @ follow / scale[:, None])
            right.append(np.maximum(reserve[stretch, column], 0.0) / scale)
    return np.vstack(rows), np.concatenate(right)


def _tangents(q: Array) -> list[Array]:
    """Unit vectors (..., t, N) at which tangents touch the bounds of vectors (..., t, N): both ways in the plane; in space along each, and round."""
    if q.shape[-2] == 1:
        return [-np.ones_like(q), np.ones_like(q)]
    size = np.linalg.norm(q, axis=-2, keepdims=True)
    along = np.where(size > 0, q / np.where(size > 0, size, 1.0), [[1.0], [0.0]])
    across = np.stack([-along[..., 1, :], along[..., 0, :]], axis=-2)
    return [along, across, -along, -across]


def increment_map(path: SteppedPath) -> ReturnMap:
    """One cycle of increments from the corner at which a transient is, which stays there, with its derivative.

    An increment takes the slip `v'` before it to the state `u = [v, w - g0]` after it. Sticking
    nodes keep their slip; a node that slips by `d = v - v'` obeys `q + f p d / |d| = 0`, an open
    one q = p = 0. With these statuses the derivatives follow from one linear system for each
    increment::

        dq + f dp e + f p (1 - e e^T) (dv - dv') / |d| = 0,   e = d / |d|,        dq = dp = 0 at
        open nodes

    In the plane the term with `1 - e e^T` vanishes. The work of an increment is the way slid times
    the mean bound, as `SteppedPath` counts it. NoContinuation, SolverError: an increment has no
    valid answer.
    """
    begin, points = path.state, copy(path).follow(path.legs)
    n, m, S, f = path.nodes, len(begin.u), path.system.S, path.friction
    D = np.diag(np.r_[np.ones(m - n), np.zeros(n)])  # a gap follows from the slips of the others
    gradient, derivatives, previous = np.zeros(m), [], begin
    for point in points:
        d = (point.u - previous.u)[:-n].reshape(-1, n)
        size = np.linalg.norm(d, axis=0)
        turned = size <= ROUNDING * np.abs(point.u).max()  # to stick, within rounding of its bound
        slips = ~turned & (point.status != STICK) & (point.status != OPEN)
        e = np.where(slips, d / np.where(slips, size, 1.0), 0.0)
        new = _after(S, f, point, D, e, size)
        bound = f * (previous.r + point.r)[-n:] / 2
        gradient += (f * np.where(slips, size, 0.0) / 2) @ S[-n:] @ (D + new) + np.tensordot(
            bound * e, (new - D)[:-n].reshape(-1, n, m)
        )
        D, previous = new, point
        derivatives.append(D)
    return ReturnMap(
        before=begin.u,
        derivative=D,
        work_gradient=gradient,
        status=np.array([point.status for point in points]),
        r=np.array([point.r for point in points])[:, None],
        motion_derivative=lambda increment, rows: np.asarray(rows @ derivatives[increment]),
    )


def _after(S: Array, f: Array, point: Point, D: Array, e: Array, size: Array) -> Array:
    """(M, M) derivative of u after an increment from that before it: nodes slip along e (t, N), which is zero elsewhere, by a size."""
    (t, n), slips, opened = e.shape, e.any(axis=0), point.status == OPEN
    moving = np.r_[np.tile(slips | opened, t), opened]
    across = np.where(slips, f * point.r[-n:] / np.where(slips, size, 1.0), 0.0) * (
        np.eye(t)[:, :, None] - e[:, None] * e
    )
    rows, right = S.copy(), np.zeros_like(D)
    rows[:-n] += (e[:, :, None] * (f[:, None] * S[-n:])).reshape(t * n, -1)
    rows[:-n, :-n] += np.block([[np.diag(one) for one in row] for row in across])
    right[:-n] = np.einsum("abn,bnm->anm", across, D[:-n].reshape(t, n, -1)).reshape(t * n, -1)
    new = np.where(moving[:, None], 0.0, D)
    new[-n:] = 0.0
    new[moving] = np.linalg.solve(rows[np.ix_(moving, moving)], right[moving] - rows[moving] @ new)
    return new
