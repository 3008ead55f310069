"""Steps towards periodic orbits (steady cycles) with more or less work of friction.

The work of a periodic orbit depends on its start only through the slips of its locked nodes, which
stick through the whole cycle. A step is a linear program. It finds the change of these slips,
within a trust region, that changes the work most, while every locked node stays within its friction
bound at every event. In space four tangents replace the friction circle. One of them touches the
circle in the direction of the shear. The motions of the other nodes follow, because the orbit stays
periodic. The step is only a proposal; the transient from the new start decides.
"""

from copy import copy
from typing import cast

import numpy as np
from scipy.optimize import linprog

from ..base import CONDENSATION, ROUNDING, Array
from ..contact import parted
from ..transients.exact import ExactPath, ReturnMap, return_map
from ..transients.stepped import SteppedPath, SteppedState
from ..transients.transient import OPEN, STICK, Transient


class Ascent:
    """Changes of a periodic orbit by which its work grows (sense 1) or falls (sense -1).

    The path is on the orbit, at the last corner, where the slip is `before`, (N,) or (N, 2),
    length. `slip_bound` (N,) is the largest size of this slip, or None. Raises NoContinuation or
    SolverError if the cycle has no derivative.
    """

    def __init__(self, path: Transient, sense: int, slip_bound: Array | None) -> None:
        tangents, n = path.system.tangents, path.nodes
        if isinstance(path, SteppedPath):
            cycle = increment_map(path)
        else:
            cycle = return_map(cast(ExactPath, path))
        self.path = path
        self.before, _ = parted(cycle.before, tangents + 1)
        self._slip_bound = slip_bound
        self._before = cycle.before[:-n].reshape(tangents, n)
        follow = _followed(cycle, tangents)  # (M, L)
        self._slip = follow[:-n].reshape(tangents, n, -1)  # derivative of the slip, (t, N, L)
        self._gain = sense * (cycle.work_gradient @ follow)  # derivative of the work, (L,)
        self._bounds = _bounds(path, cycle, follow) if self._gain.any() else None

    def step(self, radius: float) -> tuple[Array, float] | None:
        """The change of the slip that changes the work most, and the gain of work to first order.

        At each locked node the slip, (N,) or (N, 2), changes by at most `radius`, length. None if
        no node is locked, if no change of slip changes the work, or if the slip already exceeds its
        bound.
        """
        if self._bounds is None:
            return None
        rows, reserve = self._bounds
        if self._slip_bound is not None:
            unit = np.maximum(self._slip_bound, radius)
            for tangent in _tangents(self._before):
                along = -np.einsum("tn,tnx->nx", tangent / unit, self._slip)
                left = (self._slip_bound - (tangent * self._before).sum(axis=0)) / unit
                rows = np.vstack([rows, along])
                reserve = np.concatenate([reserve, left])
        answer = linprog(
            -self._gain / np.abs(self._gain).max(),
            -radius * rows,
            reserve,
            bounds=(-1.0, 1.0),
            options={"presolve": False},
        )
        if answer.status != 0:
            return None
        locked_change = radius * answer.x
        change = self._slip @ locked_change
        slip_change = change[0] if len(change) == 1 else change.T
        return slip_change, float(self._gain @ locked_change)


def _followed(cycle: ReturnMap, tangents: int) -> Array:
    """(M, L) derivative of the state of a periodic orbit by the L slips of its locked nodes."""
    locked = np.r_[np.tile(cycle.locked, tangents), np.zeros_like(cycle.locked)]
    follow = np.zeros((len(locked), int(locked.sum())))
    follow[locked] = np.eye(follow.shape[1])
    others = ~locked & (cycle.derivative != 0).any(axis=1)
    if others.any():
        # The other nodes return to their state: change = free_derivative @ change + by_locked.
        free_derivative = cycle.derivative[np.ix_(others, others)]
        by_locked = cycle.derivative[np.ix_(others, locked)]
        # A motion that a cycle changes by less than the error of the data stays as it is.
        matrix = np.eye(len(free_derivative)) - free_derivative
        follow[others] = np.linalg.lstsq(matrix, by_locked, rcond=CONDENSATION)[0]
    return follow


def _bounds(path: Transient, cycle: ReturnMap, follow: Array) -> tuple[Array, Array]:
    """Friction bounds of the locked nodes, as rows and reserves of `rows @ change + reserve >= 0`.

    The program has the bounds at the tightest events of each node, relative to the size of the
    bound.
    """
    n, f, S = path.nodes, path.friction, path.system.S
    locked = np.flatnonzero(cycle.locked)
    events = len(cycle.r)
    q = cycle.r[:, -1, :-n].reshape(events, -1, n)  # (E, t, N), at the end of each stretch
    p = cycle.r[:, -1, -n:]  # (E, N)
    tangential = S[:-n].reshape(-1, n, len(S))  # (t, N, M)
    smallest_bound = 1e-3 * float(np.abs(cycle.r[..., -n:]).mean())
    rows = list[Array]()
    reserves = list[Array]()
    # The program has the bounds of each locked node at this many events with the least reserve.
    events = 2
    for tangents in _tangents(q):
        reserve = (f * p - (tangents * q).sum(axis=1))[:, locked]  # (E, locked)
        tightest = np.argsort(reserve, axis=0, kind="stable")[:events]
        for event in np.unique(tightest):
            here = np.flatnonzero((tightest == event).any(axis=0))
            nodes = locked[here]
            tangent = tangents[event]
            unit = (f * np.abs(p[event]))[nodes] + smallest_bound
            # (nodes, M) derivative of the reserve with respect to the state at the event
            by_pressure = f[nodes, None] * S[-n:][nodes]
            by_shear = np.einsum("tn,tnm->nm", tangent[:, nodes], tangential[:, nodes])
            derivative = (by_pressure - by_shear) @ cycle.motions[event]
            rows.append(derivative @ follow / unit[:, None])
            reserves.append(np.maximum(reserve[event, here], 0.0) / unit)
    return np.vstack(rows), np.concatenate(reserves)


def _tangents(q: Array) -> list[Array]:
    """Unit normals (..., t, N) of tangents to the friction bounds of shear vectors (..., t, N).

    In the plane they point both ways; in space along each vector, against it, and across it.
    """
    if q.shape[-2] == 1:
        return [-np.ones_like(q), np.ones_like(q)]
    size = np.linalg.norm(q, axis=-2, keepdims=True)
    along = np.where(size > 0, q / np.where(size > 0, size, 1.0), [[1.0], [0.0]])
    across = np.stack([-along[..., 1, :], along[..., 0, :]], axis=-2)
    return [along, across, -along, -across]


def increment_map(path: SteppedPath) -> ReturnMap:
    """A cycle of increments with its derivative, from the corner that a transient has reached.

    The transient itself stays there. An increment takes the slip `v'` to the state `u = [v, w -
    g0]` after it. Sticking nodes keep their slip; a node that slips by `d = v - v'` obeys `q + f p
    d / |d| = 0`, an open one q = p = 0. With these statuses the derivatives follow from one linear
    system for each increment::

        dq + f dp e + f p (1 - e e^T) (dv - dv') / |d| = 0,   e = d / |d|,
        dq = dp = 0 at open nodes

    In the plane the term with `1 - e e^T` vanishes. The work of an increment is the distance slid
    times the mean bound, as `SteppedPath` counts it. Raises NoContinuation or SolverError if an
    increment has no valid answer.
    """
    before = path.state
    points = copy(path).follow(path.segments)
    n, S, f = path.nodes, path.system.S, path.friction
    m = len(before.u)
    # (M, M) derivative of the state with respect to the first slips. Gaps follow from the slips.
    D = np.diag(np.r_[np.ones(m - n), np.zeros(n)])
    work_gradient = np.zeros(m)
    derivatives = list[Array]()
    previous = before
    for point in points:
        slid = (point.u - previous.u)[:-n].reshape(-1, n)  # (t, N)
        distance = np.linalg.norm(slid, axis=0)
        # A node that just begins to stick is on its bound, and slides by rounding errors alone.
        just_stuck = distance <= ROUNDING * np.abs(point.u).max()
        slips = ~just_stuck & (point.status != STICK) & (point.status != OPEN)
        e = np.where(slips, slid / np.where(slips, distance, 1.0), 0.0)
        D_after = _derivative_after(S, f, point, D, e, distance)
        mean_bound = f * (previous.r + point.r)[-n:] / 2
        by_bound = (f * np.where(slips, distance, 0.0) / 2) @ S[-n:] @ (D + D_after)
        by_distance = np.tensordot(mean_bound * e, (D_after - D)[:-n].reshape(-1, n, m))
        work_gradient += by_bound + by_distance
        D = D_after
        previous = point
        derivatives.append(D)
    return ReturnMap(
        before=before.u,
        derivative=D,
        work_gradient=work_gradient,
        status=np.array([point.status for point in points]),
        r=np.array([point.r for point in points])[:, None],
        motions=derivatives,
    )


def _derivative_after(
    S: Array, f: Array, point: SteppedState, D: Array, e: Array, distance: Array
) -> Array:
    """(M, M) derivative of the state after an increment, from D, the derivative before it.

    Nodes slip along e (t, N), which is zero elsewhere, by a distance (N,).
    """
    t, n = e.shape
    slips = e.any(axis=0)
    opened = point.status == OPEN
    moving = np.r_[np.tile(slips | opened, t), opened]
    # f p (1 - e e^T) / |d|, (t, t, N), and as a matrix of t * t diagonal blocks
    bound_over_distance = np.where(slips, f * point.r[-n:] / np.where(slips, distance, 1.0), 0.0)
    across = bound_over_distance * (np.eye(t)[:, :, None] - e[:, None] * e)
    across_blocks = np.block([[np.diag(block) for block in row] for row in across])

    rows = S.copy()
    rows[:-n] += (e[:, :, None] * (f[:, None] * S[-n:])).reshape(t * n, -1)
    rows[:-n, :-n] += across_blocks
    right = np.zeros_like(D)
    slips_before = D[:-n].reshape(t, n, -1)
    right[:-n] = np.einsum("abn,bnm->anm", across, slips_before).reshape(t * n, -1)

    after = np.where(moving[:, None], 0.0, D)
    after[-n:] = 0.0
    known = right[moving] - rows[moving] @ after
    after[moving] = np.linalg.solve(rows[np.ix_(moving, moving)], known)
    return after
