"""One friction increment by Newton's method on the projected law (Alart & Curnier 1991), with line search.

With `[q, p] = trial + S u`, `u = [dv, w]` and any c, d > 0, the contact law is::

    p = max(p - c w, 0),     q = projection of (q - d dv) on |q| <= f max(p - c w, 0)

or on the shear strength of the surface where that is less. It is piecewise smooth: nodes that are
open have q = p = 0, closed ones w = 0, sticking ones dv = 0, and slipping ones `q = f p n` (or the
strength times n) with n the direction of `q - d dv`. Newton's method takes the piece at hand. A
node has one tangent in the plane and two in space.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from ...base import ROUNDING, STALLED, Array
from ..begin import OPEN, SLIP, STICK
from .sweeps import reactions

_NEWTON = 1e-2 * ROUNDING  # dimensionless errors of the law from which on Newton's method is done
_STEPS = 60  # Newton steps for one increment at most
_HALVINGS = 6  # of a step in the line search
_AGAIN = (
    0.1  # of the error that a step with earlier factors leaves at most: else new ones gain more
)
_GAIN = 0.25  # of the squared error by a step: where it falls by less, what is left is rounding


@dataclass(frozen=True, eq=False)
class Law:
    """Stiffness (M, M) over its scale, friction (N,), and the d of the tangents and c of each node, (t + 1, N), of the size of its own stiffness.

    The shear strength (N,) is in the units of the forces.
    """

    S: Array
    friction: Array
    own: Array
    strength: Array

    def bound(self, p: Array) -> Array:
        """(N,) largest shear under normal forces."""
        return np.minimum(self.friction * np.maximum(p, 0.0), self.strength)


@dataclass(frozen=True, eq=False)
class State:
    """A claimed state, dimensionless: (M,) slip increments and gaps u, (M,) reactions r, (N,) status of the nodes, steps, and error of the law."""

    u: Array
    r: Array
    status: NDArray[np.int8]
    steps: int
    error: float


def newton(law: Law, trial: Array, u: Array, most: int = _STEPS) -> State:
    """The state that so many steps of Newton's method reach from motions u at most; whether it obeys the law is for the referee to say.

    It makes none where the error of u is small enough already. Where statuses stay, steps with the
    factors of an earlier one, which cost little, come first. In the plane slip against +x has the
    status -1.
    """
    best, steps, factors = _piece(law, trial, u), 0, None
    while steps < most and best.error > _NEWTON:
        if factors and (factors.status == best.status).all():
            found = _piece(law, trial, best.u + factors.step(best))
            if found.error <= _AGAIN * best.error:
                best = found
                continue
            if _is_rounding(found, best):
                break
        steps += 1
        direction, factors = _step(law, best)
        for share in 0.5 ** np.arange(_HALVINGS):
            found = _piece(law, trial, best.u + share * direction)
            if found.merit < best.merit:
                break
        if _is_rounding(found, best):
            break
        best = found
    return _on_law(law, best, steps)


def _is_rounding(found: "_Piece", best: "_Piece") -> bool:
    """Whether what is left of the errors is rounding: a step hardly reduces them."""
    return found.merit > _GAIN * best.merit and best.error <= STALLED


def _on_law(law: Law, best: "_Piece", steps: int) -> State:
    """The state of a piece: what it lets vanish is zero, and slipping nodes are on their bound."""
    still = np.concatenate([np.tile(best.status == STICK, len(best.unit)), best.status != OPEN])
    u = np.where(still, 0.0, best.u)
    sense = -np.sign(best.unit[0]).astype(np.int8) if len(best.unit) == 1 else 1
    r = reactions(law.S, best.r, u - best.u).reshape(law.own.shape)
    r[:, best.status == OPEN] = 0.0
    r[:-1] = np.where(best.status == SLIP, law.bound(r[-1]) * best.unit, r[:-1])
    return State(
        u,
        r.ravel(),
        np.where(best.status == SLIP, sense, best.status).astype(np.int8),
        steps,
        best.error,
    )


class _Piece(NamedTuple):
    """The smooth piece of the law at motions u, and its errors there; slips and shear forces are (t, N) here.

    `unit` is the direction of `q - d dv` at each node, `shrink` the friction bound over its size.
    """

    u: Array
    r: Array
    status: NDArray[np.int8]
    unit: Array
    shrink: Array
    error_q: Array
    error_p: Array
    merit: float
    error: float

    def errors(self, free: NDArray[np.intp]) -> Array:
        """Errors of the law in motions that are free."""
        return np.concatenate([self.error_q.ravel(), self.error_p])[free]


class Factors(NamedTuple):
    """The factors of a step, in which some motions are free, for pieces with the same statuses."""

    status: NDArray[np.int8]
    free: NDArray[np.intp]
    root: Array
    lu: Array
    pivots: NDArray[np.int32]

    def step(self, piece: _Piece) -> Array:
        """A step with these factors."""
        step = -piece.u
        step[self.free] = (
            dgetrs(self.lu, self.pivots, -piece.errors(self.free) / self.root)[0] / self.root
        )
        return step


def _piece(law: Law, trial: Array, u: Array) -> _Piece:
    (d, c), r = law.own[-2:], reactions(law.S, trial, u)
    (dv, w), (q, p) = (
        (values.reshape(law.own.shape)[:-1], values.reshape(law.own.shape)[-1]) for values in (u, r)
    )
    pressed = p - c * w
    radius = law.bound(pressed)
    pull = q - d * dv
    size = np.sqrt((pull**2).sum(axis=0))
    status = np.where(pressed <= 0, OPEN, np.where(size > radius, SLIP, STICK)).astype(np.int8)
    whole = np.where(size > 0, size, 1.0)
    unit = pull / whole
    project = np.where(status == SLIP, radius * unit, pull)
    project[:, status == OPEN] = 0.0
    error_q, error_p = q - project, p - np.maximum(pressed, 0.0)
    merit, error = (
        float((error_q**2).sum() + (error_p**2).sum()),
        float(max(np.abs(error_q).max(), np.abs(error_p).max())),
    )
    return _Piece(u, r, status, unit, radius / whole, error_q, error_p, merit, error)


def _step(law: Law, piece: _Piece) -> tuple[Array, Factors | None]:
    """Newton's step on a piece: sticking and closed motions vanish, the others solve their equations; what nothing holds does not move.

    With its factors, where all is held.
    """
    t, n = piece.unit.shape
    slip, opened = np.flatnonzero(piece.status == SLIP), np.flatnonzero(piece.status == OPEN)
    axes, s = range(t), len(slip)
    free = np.concatenate([*(k * n + slip for k in axes), *(k * n + opened for k in range(t + 1))])
    step = -piece.u.copy()
    step[free] = 0.0
    if not len(free):
        return step, None
    (d, c), unit, shrink = law.own[-2:, slip], piece.unit[:, slip], piece.shrink[slip]
    pressed = (piece.r[t * n :] - law.own[-1] * piece.u[t * n :])[slip]
    f = np.where(
        law.friction[slip] * pressed < law.strength[slip], law.friction[slip], 0.0
    )  # the strength does not change with p
    m, ends = len(free), step != 0
    ends[t * n + slip] = False
    columns = np.concatenate(
        [free, t * n + slip, np.flatnonzero(ends)]
    )  # all others neither move nor did
    # tangential rows: (1 - shrink P) S_q + shrink d P - n f (S_p - c e_w), with P = 1 - n n' across
    # the direction n
    across = np.eye(t)[:, :, None] - unit[:, None] * unit[None]
    share = np.eye(t)[:, :, None] - shrink * across
    rows, own = law.S[np.ix_(columns[: m + s], columns)], np.arange(s)
    rows, normal, sheared = rows[:m], rows[m:], rows[: t * s].reshape(t, s, len(columns)).copy()
    for a in axes:
        rows[a * s : (a + 1) * s] = (share[a][:, :, None] * sheared).sum(axis=0) - (f * unit[a])[
            :, None
        ] * normal
        for b in axes:
            rows[a * s + own, b * s + own] += d * shrink * across[a, b]
        rows[a * s + own, m + own] += f * unit[a] * c
    root = np.sqrt(law.own.ravel()[free])
    matrix, right = (
        rows[:, :m] / np.outer(root, root),
        (-piece.errors(free) - rows @ step[columns]) / root,
    )
    lu, pivots, singular = dgetrf(matrix)
    if not singular and dgecon(lu, np.abs(matrix).sum(axis=0).max())[0] > ROUNDING:
        step[free] = np.asarray(dgetrs(lu, pivots, right)[0]) / root
        return step, Factors(piece.status, free, root, lu, pivots)
    step[free] = (
        np.asarray(
            lstsq(matrix, right, cond=ROUNDING, lapack_driver="gelsy", check_finite=False)[0]
        )
        / root
    )
    return step, None
