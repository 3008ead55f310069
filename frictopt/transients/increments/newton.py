"""A friction increment by Newton's method on the projected law (Alart & Curnier 1991).

With `[q, p] = trial + S u`, `u = [dv, w]` and any c, d > 0, the contact law is::

    p = max(p - c w, 0),     q = projection of (q - d dv) on |q| <= bound(max(p - c w, 0))

The bound is the smallest of the linear terms of `contact/law.py`. The law is piecewise smooth:
open nodes have q = p = 0, closed nodes w = 0, sticking nodes dv = 0, and slipping nodes `q =
bound(p) n` with n the direction of `q - d dv`. Newton's method with a line search steps on the
piece that holds at the present motions. A node has one tangent in the plane and two in space.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from ...base import ROUNDING, STALLED, Array
from ..transient import OPEN, SLIP, STICK
from .sweeps import reactions

# The numbers of Newton's method.

# Dimensionless error of the law at which the method ends with success.
_ENOUGH = 1e-2 * ROUNDING
# Largest number of steps that a line search tries; each is half as long as the step before.
_HALVINGS = 6
# If a step leaves more than this share of the squared error, the error may be rounding.
_SMALL_GAIN = 0.25
# The method ends without a state after `_IDLE_STEPS` successive steps that each leave more than
# this share of the squared error: a body slides, and further motion does not change the forces.
_NO_GAIN = 0.99
_IDLE_STEPS = 6


@dataclass(frozen=True, eq=False)
class Law:
    """The dimensionless contact law of N nodes, M motions, t tangents.

    `S` (M, M) is the stiffness over its scale. The friction bound has J terms with `slopes` and
    `constants` (J, N); the constants are in the unit of the forces. `augmentation` (t + 1, N) has
    the d of the tangents and the c of each node, which are about as large as the stiffness of the
    node.
    """

    S: Array
    slopes: Array
    constants: Array
    augmentation: Array

    def per_force(self, force: float) -> "Law":
        """The law in another unit of force, from a law with the unit 1."""
        return replace(self, constants=self.constants / force)

    def bound(self, p: Array) -> Array:
        """(N,) largest shear under normal forces; 0 at nodes that nothing presses."""
        smallest = (self.slopes * np.maximum(p, 0.0) + self.constants).min(axis=0)
        return np.where(p > 0, smallest, 0.0)

    def slope(self, p: Array, nodes: NDArray[np.intp]) -> Array:
        """Slope of the governing term of the bound of some nodes, under their normal forces."""
        terms = self.slopes[:, nodes] * p + self.constants[:, nodes]
        # If two terms are equal, the later one governs.
        governs = len(terms) - 1 - terms[::-1].argmin(axis=0)
        return np.asarray(self.slopes[governs, nodes])


@dataclass(frozen=True, eq=False)
class State:
    """A claimed state, dimensionless.

    (M,) slip increments and gaps u, (M,) reactions r, (N,) status of the nodes, number of steps,
    and error of the law.
    """

    u: Array
    r: Array
    status: NDArray[np.int8]
    steps: int
    error: float


def newton(law: Law, trial: Array, u: Array, most: int = 60) -> State:
    """The state after at most `most` Newton steps from the motions u.

    The caller must check whether it obeys the law. If the error at u is small enough already, no
    step is made. In the plane slip against +x has the status -1.
    """
    best = _piece(law, trial, u)
    steps = 0
    idle = 0
    while steps < most and idle < _IDLE_STEPS and best.error > _ENOUGH:
        steps += 1
        tried = _line_search(law, trial, best, _step(law, best))
        if _is_rounding(tried, best):
            break
        idle = idle + 1 if tried.merit > _NO_GAIN * best.merit else 0
        best = tried
    return _on_law(law, best, steps)


def _line_search(law: Law, trial: Array, best: "_Piece", direction: Array) -> "_Piece":
    """The longest step that reduces the squared error; if none does, the shortest step."""
    for share in 0.5 ** np.arange(_HALVINGS):
        tried = _piece(law, trial, best.u + share * direction)
        if tried.merit < best.merit:
            break
    return tried


def _is_rounding(tried: "_Piece", best: "_Piece") -> bool:
    """Whether the error is rounding: it is small, and a step hardly reduces it."""
    return tried.merit > _SMALL_GAIN * best.merit and best.error <= STALLED


def _on_law(law: Law, piece: "_Piece", steps: int) -> State:
    """The state of a piece, exactly: forbidden motions are zero, slipping nodes on their bound."""
    tangents = len(piece.unit)
    sticks = piece.status == STICK
    opened = piece.status == OPEN
    slips = piece.status == SLIP
    u = np.where(np.concatenate([np.tile(sticks, tangents), ~opened]), 0.0, piece.u)
    r = reactions(law.S, piece.r, u - piece.u).reshape(law.augmentation.shape)
    r[:, opened] = 0.0
    r[:-1] = np.where(slips, law.bound(r[-1]) * piece.unit, r[:-1])
    status = piece.status
    if tangents == 1:
        status = np.where(slips, -np.sign(piece.unit[0]), status).astype(np.int8)
    return State(u, r.ravel(), status, steps, piece.error)


class _Piece(NamedTuple):
    """The smooth piece of the law at motions u, and its errors there.

    Slips and shear forces are (t, N) here. `unit` is the direction of `q - d dv` at each node, and
    `shrink` the friction bound divided by the size of `q - d dv`. `merit` is the sum of squared
    errors, `error` the largest error.
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


def _piece(law: Law, trial: Array, u: Array) -> _Piece:
    d, c = law.augmentation[:-1], law.augmentation[-1]
    r = reactions(law.S, trial, u)
    forces = r.reshape(law.augmentation.shape)
    motions = u.reshape(law.augmentation.shape)
    q, p = forces[:-1], forces[-1]
    dv, w = motions[:-1], motions[-1]

    pressed = p - c * w
    bound = law.bound(pressed)
    pull = q - d * dv
    size = np.sqrt((pull**2).sum(axis=0))
    status = np.where(pressed <= 0, OPEN, np.where(size > bound, SLIP, STICK)).astype(np.int8)
    positive_size = np.where(size > 0, size, 1.0)
    unit = pull / positive_size

    projection = np.where(status == SLIP, bound * unit, pull)
    projection[:, status == OPEN] = 0.0
    error_q = q - projection
    error_p = p - np.maximum(pressed, 0.0)
    return _Piece(
        u=u,
        r=r,
        status=status,
        unit=unit,
        shrink=bound / positive_size,
        error_q=error_q,
        error_p=error_p,
        merit=float((error_q**2).sum() + (error_p**2).sum()),
        error=float(max(np.abs(error_q).max(), np.abs(error_p).max())),
    )


def _step(law: Law, piece: _Piece) -> Array:
    """Newton's step on a piece.

    Sticking and closed motions become zero. The free motions solve the linearised equations; free
    motions that nothing holds do not change.
    """
    t, n = piece.unit.shape
    slips = np.flatnonzero(piece.status == SLIP)
    opened = np.flatnonzero(piece.status == OPEN)
    free = np.concatenate(
        [*(k * n + slips for k in range(t)), *(k * n + opened for k in range(t + 1))]
    )
    step = -piece.u.copy()
    step[free] = 0.0
    if not len(free):
        return step

    # Motions that become zero also change: their columns are on the right side.
    ending = step != 0
    ending[t * n + slips] = False
    columns = np.concatenate([free, t * n + slips, np.flatnonzero(ending)])
    rows = _linearised(law, piece, slips, columns, len(free))

    root = np.sqrt(law.augmentation.ravel()[free])
    matrix = rows[:, : len(free)] / np.outer(root, root)
    right = (-piece.errors(free) - rows @ step[columns]) / root
    lu, pivots, singular = dgetrf(matrix)
    if not singular and dgecon(lu, np.abs(matrix).sum(axis=0).max())[0] > ROUNDING:
        scaled = dgetrs(lu, pivots, right)[0]
    else:
        scaled = lstsq(matrix, right, cond=ROUNDING, lapack_driver="gelsy", check_finite=False)[0]
    step[free] = np.asarray(scaled) / root
    return step


def _linearised(
    law: Law, piece: _Piece, slips: NDArray[np.intp], columns: NDArray[np.intp], m: int
) -> Array:
    """(m, len(columns)) derivatives of the errors in the m free motions.

    The first columns belong to the free motions, the next to the gaps of slipping nodes, the last
    to motions that become zero. The rows of tangents are
    `(1 - shrink P) S_q + shrink d P - n f (S_p - c e_w)`, with P = 1 - n n' across the direction n
    of the pull.
    """
    t, n = piece.unit.shape
    s = len(slips)
    d, c = law.augmentation[-2:, slips]
    unit = piece.unit[:, slips]
    shrink = piece.shrink[slips]
    pressed = (piece.r[t * n :] - law.augmentation[-1] * piece.u[t * n :])[slips]
    f = law.slope(pressed, slips)

    across = np.eye(t)[:, :, None] - unit[:, None] * unit[None]
    share = np.eye(t)[:, :, None] - shrink * across
    stiffness = law.S[np.ix_(columns[: m + s], columns)]
    rows, normal = stiffness[:m], stiffness[m:]
    sheared = rows[: t * s].reshape(t, s, len(columns)).copy()
    node = np.arange(s)
    for a in range(t):
        turned = (share[a][:, :, None] * sheared).sum(axis=0)
        rows[a * s : (a + 1) * s] = turned - (f * unit[a])[:, None] * normal
        for b in range(t):
            rows[a * s + node, b * s + node] += d * shrink * across[a, b]
        rows[a * s + node, m + node] += f * unit[a] * c
    return rows
