"""The exact solution of a linear or cone program on the rows and cones that a solver has found active."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import lstsq, null_space
from scipy.linalg.lapack import dsycon, dsytrf, dsytrf_lwork, dsytrs

from ..contact import ROUNDING, STALLED, Array, Integers
from .arrays import Arrays

_NOT_UNIQUE = ROUNDING / 10  # singular directions of these equations, over the largest: there the solution stays as it is
_POLISHED = 1e-3 * ROUNDING  # errors of the equations of active cones that no step makes smaller
_STEPS = 8  # of Newton's method at most; mostly three do
_GAPS = 4  # between ratios of multiplier to slack that are tried
_REVISIONS = 4  # of the active rows and cones from one such gap
_LEAST_RATIO = 1e-12  # ratios below it, and above its inverse, are alike


class _Form:
    """The program in the words of its maximum, with a solution: `objective = matrix.T @ y`."""

    def __init__(self, program: Arrays, z: Array, y: Array) -> None:
        self.matrix, self.right, self.objective, self.zero, self.cones = program.matrix, program.right, -program.cost, program.zero, program.cones
        self.z, self.y = z, y

    def slack(self, z: Array) -> Array:
        """Slacks of all rows."""
        return np.asarray(self.right - self.matrix @ z)

    def off(self, z: Array, y: Array) -> float:
        """Largest violation of the optimality conditions: slacks, balance of the multipliers, and their work on the slacks."""
        if not (np.isfinite(z).all() and np.isfinite(y).all()):
            return np.inf
        s = self.slack(z)
        outside = [(np.linalg.norm(s[cone[:, 1:]], axis=1) - s[cone[:, 0]]).max(initial=0.0) for cone in self.cones]
        return float(max(*outside, np.abs(s[: self.zero]).max(initial=0.0), np.abs(self.matrix.T @ y - self.objective).max(), abs(y @ s)))


def polish(program: Arrays, z: Array, y: Array) -> tuple[Array, Array]:
    """Move a solution onto its active rows and cones, by Newton's method on their equations.

    Which are active is read from the ratios of multiplier to slack, which solvers leave large for active rows and cones and small for the others.
    Where the widest gap between the ratios does not part them rightly, the next ones are tried; rows and cones that the solution contradicts change
    sides. The answer is the point that breaks the conditions of the whole program least; whether it is good enough is for a residual to say.
    """
    form = _Form(program, z, y)
    free = null_space(form.matrix[: form.zero].toarray(), rcond=_NOT_UNIQUE) if form.zero else None
    best = z, program.admissible(y)
    least = form.off(*best)
    with np.errstate(all="ignore"):  # a step of a wrong guess may go anywhere, and what it is off tells
        for at, slopes in _tried(form, free):
            slopes = program.admissible(slopes)
            if (off := form.off(at, slopes)) < least:
                best, least = (at, slopes), off
            if least <= ROUNDING:
                break
    return best


def _tried(form: _Form, free: Array | None) -> Iterator[tuple[Array, Array]]:
    """Points that the active rows and cones of different guesses make."""
    for share in _shares(form):
        (z, y), before = (form.z, form.y), None
        for _ in range(_REVISIONS):
            active = _Active(form, free, z, y, share)
            if before is not None and active.same_as(before):
                break
            z, y = active.solved(z, y)
            yield z, y
            yield z, form.y  # where more is active than there are unknowns, the multipliers are not unique
            before = active


def _shares(form: _Form) -> list[float]:
    """Ratios of multiplier to slack in the middle of the widest gaps between those of all rows and cones, the widest gap first."""
    s = form.slack(form.z)
    room, by = np.hstack([side for cone in form.cones for side in _sides(s[cone], form.y[cone])])
    ratios = np.where(room > 0, by / np.where(room > 0, room, 1.0), np.inf)
    powers = np.sort(np.log10(np.clip(ratios, _LEAST_RATIO, 1 / _LEAST_RATIO)))
    return [float(10 ** powers[[k, k + 1]].mean()) for k in np.argsort(-np.diff(powers), kind="stable")[:_GAPS]]


def _sides(s: Array, y: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Slacks and multipliers of cones, (n, d), on their boundary and at their apex."""
    radius, slid = np.linalg.norm(s[:, 1:], axis=1), np.linalg.norm(y[:, 1:], axis=1)
    return (s[:, 0] - radius, y[:, 0] + np.copysign(slid, y[:, 0])), (s[:, 0] + radius, y[:, 0] - slid)


def _directed(vectors: Array) -> tuple[Array, Array]:
    """Lengths and directions of vectors, (n, d); 1 and 0 of one that vanishes."""
    radius = np.linalg.norm(vectors, axis=1)
    radius = np.where(radius > 0, radius, 1.0)
    return radius, vectors / radius[:, None]


class _Active:
    """The cones that are active at a point: at their apex, where all slacks vanish, or on their boundary."""

    def __init__(self, form: _Form, free: Array | None, z: Array, y: Array, share: float) -> None:
        self._form, self._free, s = form, free, form.slack(z)
        shut, self._on = list[Integers](), list[Integers]()
        for cone in form.cones:
            (slack, slid), (tip, excess) = _sides(s[cone], y[cone])
            apex = excess > share * tip
            shut.append(cone[apex].ravel())
            self._on += [cone[(slid > share * slack) & ~apex & s[cone[:, 1:]].any(axis=1)]] if cone.shape[1] > 1 else []
        self._shut = np.concatenate(shut)

    def same_as(self, other: "_Active") -> bool:
        """Whether the same rows and cones are active."""
        return all(np.array_equal(*pair) for pair in zip([self._shut, *self._on], [other._shut, *other._on], strict=True))

    def _slopes(self, rows: Integers) -> Array:
        """Gradients of slacks, along the free directions."""
        matrix = self._form.matrix[rows]
        return np.asarray(-(matrix.toarray() if self._free is None else matrix @ self._free))

    def _equations(self, z: Array, m: Array) -> tuple[Array, Array, Array]:
        """Values of the active rows and cones, their gradients, and the Hessian of their sum weighted by the multipliers m, negative."""
        s, gradients = self._form.slack(z), [self._slopes(self._shut)]
        values, free, at = [s[self._shut]], gradients[0].shape[1], len(self._shut)
        hessian = np.zeros((free, free))
        for cone in self._on:
            radius, unit = _directed(s[cone[:, 1:]])
            sides = self._slopes(cone[:, 1:].ravel()).reshape(*unit.shape, free)
            along = np.einsum("ri,riz->rz", unit, sides)
            values.append(s[cone[:, 0]] - radius)
            gradients.append(self._slopes(cone[:, 0]) - along)
            weight = np.sqrt(np.maximum(m[at : at + len(cone)], 0.0) / radius)
            across = ((sides - unit[:, :, None] * along[:, None]) * weight[:, None, None]).reshape(-1, free)
            hessian, at = hessian + across.T @ across, at + len(cone)
        return np.concatenate(values), np.vstack(gradients), hessian

    def solved(self, z: Array, y: Array) -> tuple[Array, Array]:
        """Variables and multipliers that solve the equations of what is active, by Newton's method from a point."""
        form, free = self._form, self._free
        fixed = form.matrix[: form.zero].toarray()
        z = z + lstsq(fixed, form.right[: form.zero] - fixed @ z)[0] if form.zero else z
        m = np.concatenate([y[self._shut], *(y[cone[:, 0]] for cone in self._on)])
        if free is not None and not free.size:  # the equations alone fix z, and prove it
            return z, self._multipliers(z, np.zeros_like(m))
        best, least = (z, m), np.inf
        goal = form.objective if free is None else free.T @ form.objective
        for _ in range(_STEPS):
            values, gradients, hessian = self._equations(z, m)
            error = max(float(np.abs(goal + gradients.T @ m).max(initial=0.0)), float(np.abs(values).max(initial=0.0)))
            if error < least:
                best, least = (z, m), error
            elif least <= STALLED or not np.isfinite(error):
                break
            if error <= _POLISHED:
                break
            matrix = np.block([[-hessian, gradients.T], [gradients, np.zeros((len(m), len(m)))]])
            step = _least(matrix, -np.r_[goal, values])
            z, m = z + (step[: len(goal)] if free is None else free @ step[: len(goal)]), step[len(goal) :]
        return best[0], self._multipliers(*best)

    def _multipliers(self, z: Array, m: Array) -> Array:
        """Multipliers of all rows from those of the active ones; those of the equations fit best."""
        form, s, y, at = self._form, self._form.slack(z), np.zeros(len(self._form.right)), len(self._shut)
        y[self._shut] = m[:at]
        for cone in self._on:
            size = m[at : at + len(cone)]
            y[cone[:, 0]] = size
            y[cone[:, 1:]] = -size[:, None] * _directed(s[cone[:, 1:]])[1]
            at += len(cone)
        if form.zero:
            y[: form.zero] = lstsq(form.matrix[: form.zero].toarray().T, form.objective - form.matrix.T @ y)[0]
        return y


def _least(matrix: Array, right: Array) -> Array:
    """The solution of symmetric equations, the least one where they have several."""
    factor, order, _ = dsytrf(matrix, lwork=int(dsytrf_lwork(len(matrix))[0]))
    if dsycon(factor, order, np.abs(matrix).sum(axis=0).max())[0] > _NOT_UNIQUE:
        return np.asarray(dsytrs(factor, order, right)[0])
    return np.asarray(lstsq(matrix, right, cond=_NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0])
