"""One cycle of increments, and how its end and its work of friction change with the slip at its beginning.

An increment takes the slip `v'` before it to the state `u = [v, w - g0]` after it. Sticking nodes keep their slip; a node that slips by `d = v - v'`
obeys `q + f p d / |d| = 0`, an open one q = p = 0. With these statuses the derivatives follow from one linear system for each increment::

    dq + f dp e + f p (1 - e e^T) (dv - dv') / |d| = 0,   e = d / |d|,        dq = dp = 0 at open nodes

In the plane the term with `1 - e e^T` vanishes. The work of an increment is the way slid times the mean bound, as `SteppedPath` counts it.
"""

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..contact.checks import Array
from ..transients.begin import OPEN, STICK
from ..transients.stepped import Point, SteppedPath


@dataclass(frozen=True, eq=False)
class IncrementMap:
    """One cycle of K increments with its derivative; the names are those of `ReturnMap`.

    Attributes
    ----------
    before
        (M,) `u` at its beginning, length.
    derivative
        (M, M) derivative of u at its end with respect to `before`.
    work_gradient
        (M,) derivative of the work of friction, force.
    locked
        (N,) whether the node sticks all the time.
    r
        (K, 1, M) reactions after each increment, force.
    """

    before: Array
    derivative: Array
    work_gradient: Array
    locked: NDArray[np.bool_]
    r: Array
    _derivatives: Array

    def motion_derivative(self, stretch: int, rows: Array) -> Array:
        """(m, M) rows (m, M) times the derivative of u after an increment."""
        return np.asarray(rows @ self._derivatives[stretch])


def increment_map(path: SteppedPath) -> IncrementMap:
    """Follow one cycle from the corner at which a transient is, and take its derivative; the transient stays where it is.

    Raises
    ------
    NoContinuation, SolverError
        An increment has no valid answer.
    """
    begin, follower, points = path.state, copy(path), list[Point]()
    for leg in path.legs:
        points += follower.follow_to(*leg)
    n, m, S, f = path.nodes, len(begin.u), path.system.S, path.friction
    D = np.diag(np.r_[np.ones(m - n), np.zeros(n)])  # a gap follows from the slips of the others
    gradient, derivatives, previous = np.zeros(m), [], begin
    for point in points:
        slips = (point.status != STICK) & (point.status != OPEN)
        d = (point.u - previous.u)[:-n].reshape(-1, n)
        size = np.linalg.norm(d, axis=0)
        slips &= size > 0  # one that turns to stick within rounding of its bound
        new = _after(S, f, point, D, slips, d)
        dp, mean = S[-n:] @ (D + new) / 2, (previous.r + point.r)[-n:] / 2
        for node in np.flatnonzero(slips):
            along = node + n * np.arange(len(d))
            e = d[:, node] / size[node]
            gradient += f[node] * (size[node] * dp[node] + mean[node] * (e @ (new[along] - D[along])))
        D, previous = new, point
        derivatives.append(D)
    return IncrementMap(
        before=begin.u,
        derivative=D,
        work_gradient=gradient,
        locked=(np.array([point.status for point in points]) == STICK).all(axis=0),
        r=np.array([point.r for point in points])[:, None],
        _derivatives=np.array(derivatives),
    )


def _after(S: Array, f: Array, point: Point, D: Array, slips: NDArray[np.bool_], d: Array) -> Array:
    """(M, M) derivative of u after an increment by `d` (t, N) to a state at which some nodes slip, from that before it."""
    n, t, opened = len(f), len(d), point.status == OPEN
    moving = np.r_[np.tile(slips | opened, t), opened]
    rows, right = S.copy(), np.zeros_like(D)
    size = np.where(slips, np.linalg.norm(d, axis=0), 1.0)
    for node in np.flatnonzero(slips):
        along = node + n * np.arange(t)
        e = d[:, node] / size[node]
        across = f[node] * point.r[t * n + node] / size[node] * (np.eye(t) - np.outer(e, e))
        rows[along] += f[node] * np.outer(e, S[t * n + node])
        rows[np.ix_(along, along)] += across
        right[along] = across @ D[along]
    new = np.where(moving[:, None], 0.0, D)
    new[-n:] = 0.0
    new[moving] = np.linalg.solve(rows[np.ix_(moving, moving)], (right - rows @ new)[moving])
    return new
