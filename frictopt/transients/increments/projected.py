"""One friction increment by Newton's method on the projected law (Alart & Curnier 1991), with line search.

With `[q, p] = trial + S u`, `u = [dv, w]` and any c, d > 0, the contact law is::

    p = max(p - c w, 0),     q = projection of (q - d dv) on the circle of radius f max(p - c w, 0)

It is piecewise smooth: nodes that are open have q = p = 0, closed ones w = 0, sticking ones dv = 0, and slipping ones `q = f p n` with n the
direction of `q - d dv`. Newton's method takes the piece at hand.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from ...contact.checks import Array
from ...contact.parts import parted
from ...contact.tolerances import NEWTON, RESIDUAL, ROUNDING, STALLED

__all__ = ["OPEN", "SLIP", "STICK", "Law3D", "State3D", "by_friction", "newton"]

STICK, SLIP, OPEN = 0, 1, 2

_STEPS = 60  # Newton steps for one increment at most
_HALVINGS = 6  # of a step in the line search
_FIRST_SHARE, _LEAST_SHARE = 0.25, 1e-4  # of the friction, by which it grows from one state to the next


@dataclass(frozen=True, eq=False)
class Law3D:
    """Dimensionless stiffness, friction, and the c and d of each node.

    Attributes
    ----------
    S
        (3N, 3N) stiffness over its scale.
    friction
        (N,) coefficients of friction.
    own
        (3N,) positive numbers of the size of each direction's own stiffness, alike for the tangents of a node: d, d and c.
    """

    S: Array
    friction: Array
    own: Array

    @property
    def c(self) -> Array:
        """(N,) of the normals."""
        return self.own[2 * len(self.friction) :]

    @property
    def d(self) -> Array:
        """(N,) of the circles."""
        return self.own[: len(self.friction)]


@dataclass(frozen=True, eq=False)
class State3D:
    """A claimed state, dimensionless: (3N,) slip increments and gaps u, (3N,) reactions r, (N,) status of the nodes, steps, and error of the law."""

    u: Array
    r: Array
    status: np.ndarray
    steps: int
    error: float


def by_friction(law: Law3D, trial: Array) -> State3D:
    """The state that is reached from that without friction while the coefficients grow to what they are, or the last one on this way."""

    def found(share: float, u: Array) -> State3D:
        return newton(Law3D(law.S, share * law.friction, law.own), trial, u)

    share, step, state = 0.0, _FIRST_SHARE, found(0.0, np.zeros_like(trial))
    while state.error <= RESIDUAL and share < 1 and step > _LEAST_SHARE:
        ahead = min(share + step, 1.0)
        further = found(ahead, state.u)
        if further.error <= RESIDUAL:
            share, step, state = ahead, 2 * step, further
        else:
            step /= 4
    return state


def newton(law: Law3D, trial: Array, u: Array) -> State3D:
    """The state that Newton's method reaches from motions u; whether it obeys the law is for the referee to say."""
    best, steps = _Piece(law, trial, u), 0
    while steps < _STEPS and best.error > NEWTON:
        steps += 1
        direction, share, found = best.step(), 1.0, best
        for _ in range(_HALVINGS):
            found = _Piece(law, trial, best.u + share * direction)
            if found.merit < best.merit:
                break
            share /= 2
        if found.merit >= best.merit and best.error <= STALLED:
            break
        best = found
    return best.state(steps)


def _least_motion(matrix: Array, right: Array) -> Array:
    """Solution of linear equations; where they leave motions free, which nothing holds, the one without them."""
    factors, pivots, singular = dgetrf(matrix)
    if not singular and dgecon(factors, np.abs(matrix).sum(axis=0).max())[0] > ROUNDING:
        return np.asarray(dgetrs(factors, pivots, right)[0])
    return np.asarray(lstsq(matrix, right, cond=ROUNDING, lapack_driver="gelsy", check_finite=False)[0])


class _Piece:
    """The smooth piece of the law at motions u, and its error there."""

    def __init__(self, law: Law3D, trial: Array, u: Array) -> None:
        n = len(law.friction)
        self.law, self.u, self._n = law, u, n
        self.r = trial + law.S @ u
        (dv, w), (q, p) = parted(u, 3), parted(self.r, 3)
        pressed = p - law.c * w
        self._radius = law.friction * np.maximum(pressed, 0.0)
        pull = q - law.d[:, None] * dv
        size = np.linalg.norm(pull, axis=1)
        self.status = np.where(pressed <= 0, OPEN, np.where(size > self._radius, SLIP, STICK))
        self._unit = pull / np.where(size > 0, size, 1.0)[:, None]
        self._shrink = self._radius / np.where(size > 0, size, 1.0)
        project = np.where((self.status == SLIP)[:, None], self._radius[:, None] * self._unit, pull)
        project[self.status == OPEN] = 0.0
        self._error_q, self._error_p = q - project, p - np.maximum(pressed, 0.0)
        self.merit = float(np.sum(self._error_q**2) + np.sum(self._error_p**2))
        self.error = float(max(np.abs(self._error_q).max(), np.abs(self._error_p).max()))

    def step(self) -> Array:
        """Newton's step on this piece: sticking and closed motions vanish, the others solve their equations."""
        law, n = self.law, self._n
        slip, opened = np.flatnonzero(self.status == SLIP), np.flatnonzero(self.status == OPEN)
        free = np.concatenate([slip, n + slip, opened, n + opened, 2 * n + opened])
        step = -self.u.copy()
        step[free] = 0.0
        if not len(free):
            return step
        a, b = self._unit[slip].T
        f, c, d, shrink, s = law.friction[slip], law.c[slip], law.d[slip], self._shrink[slip], len(slip)
        # tangential rows: (1 - shrink P) S_q + shrink d P - n f (S_p - c e_w), with P across the direction n = (a, b)
        xx, xy, yy = 1 - shrink * b * b, shrink * a * b, 1 - shrink * a * a
        rows = law.S[free]
        normal = law.S[2 * n + slip]
        rows_1, rows_2 = rows[:s].copy(), rows[s : 2 * s].copy()
        rows[:s] = xx[:, None] * rows_1 + xy[:, None] * rows_2 - (f * a)[:, None] * normal
        rows[s : 2 * s] = xy[:, None] * rows_1 + yy[:, None] * rows_2 - (f * b)[:, None] * normal
        own = np.arange(s)
        rows[own, slip] += d * (1 - xx)
        rows[own, n + slip] -= d * xy
        rows[s + own, slip] -= d * xy
        rows[s + own, n + slip] += d * (1 - yy)
        rows[own, 2 * n + slip] += f * a * c
        rows[s + own, 2 * n + slip] += f * b * c
        errors = np.concatenate([self._error_q[slip].T.ravel(), self._error_q[opened].T.ravel(), self._error_p[opened]])
        root = np.sqrt(law.own[free])
        step[free] = _least_motion(rows[:, free] / np.outer(root, root), (-errors - rows @ step) / root) / root
        return step

    def state(self, steps: int) -> State3D:
        """The state with the motions that the piece lets vanish at zero."""
        still = np.concatenate([np.tile(self.status == STICK, 2), self.status != OPEN])
        u = np.where(still, 0.0, self.u)
        return State3D(u, self.r + self.law.S @ (u - self.u), self.status, steps, self.error)
