"""A program as solvers take it: a cost, sparse rows and one dense block, in cones; and its exact solution next to a rough one."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dsycon, dsytrf, dsytrf_lwork, dsytrs
from scipy.sparse import csr_array, eye_array, hstack, vstack

from ..base import ROUNDING, STALLED, Array, Integers

_NOT_UNIQUE = (
    ROUNDING / 10
)  # singular directions of these equations, over the largest: there the solution stays as it is
_POLISHED = 1e-3 * ROUNDING  # errors of the equations of active cones that no step makes smaller
_STEPS = 8  # of Newton's method at most; mostly three do
_GAPS = 4  # between ratios of multiplier to slack that are tried
_REVISIONS = 4  # of the active rows and cones from one such gap
_LEAST_RATIO = 1e-12  # ratios below it, and above its inverse, are alike


@dataclass(frozen=True, eq=False)
class Arrays:
    """A program as solvers take it: min `cost @ x` over the x whose slacks `right - sparse @ [x, block @ x]` are in cones.

    The first `zero` slacks are zero; the others are in cones `|s[1:]| <= s[0]` of these `sizes`,
    the linear ones, of size 1, first.
    """

    sparse: csr_array
    block: Array
    right: Array
    cost: Array
    zero: int
    sizes: Integers

    @cached_property
    def matrix(self) -> csr_array:
        """All rows on x alone."""
        if not len(self.block):
            return self.sparse
        width = self.block.shape[1]
        return csr_array(self.sparse[:, :width].toarray() + self.sparse[:, width:] @ self.block)

    @cached_property
    def cones(self) -> list[Integers]:
        """The rows of the cones, (n, d) for each size d."""
        starts = self.zero + np.cumsum(self.sizes) - self.sizes
        return [
            starts[self.sizes == size][:, None] + np.arange(size) for size in np.unique(self.sizes)
        ]

    def slack(self, x: Array) -> Array:
        """Slacks of all rows."""
        return np.asarray(self.right - self.sparse @ np.concatenate([x, self.block @ x]))

    def violation(self, x: Array) -> float:
        """Largest violation of a row."""
        s = self.slack(x)
        outside = [
            (np.linalg.norm(s[cone[:, 1:]], axis=1) - s[cone[:, 0]]).max(initial=0.0)
            for cone in self.cones
        ]
        return float(max([*outside, np.abs(s[: self.zero]).max(initial=0.0)]))

    def off(self, x: Array, y: Array) -> float:
        """Largest violation of the optimality conditions: slacks, balance of the multipliers, and their work on the slacks."""
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            return np.inf
        return float(
            max(
                self.violation(x),
                np.abs(self.matrix.T @ y + self.cost).max(initial=0.0),
                abs(y @ self.slack(x)),
            )
        )

    @property
    def widened(self) -> "Arrays":
        """The program with `block @ x` as unknowns of their own, defined by its first equations, so that all rows are sparse."""
        parts, width = self.block.shape
        if not parts:
            return self
        matrix = csr_array(
            vstack([hstack([csr_array(self.block), -eye_array(parts)]), self.sparse])
        )
        right, cost = np.r_[np.zeros(parts), self.right], np.r_[self.cost, np.zeros(parts)]
        return Arrays(
            matrix, np.zeros((0, width + parts)), right, cost, parts + self.zero, self.sizes
        )

    def admissible(self, y: Array) -> Array:
        """The multipliers nearby that are in their cones."""
        y = y.copy()
        for cone in self.cones:
            y[cone[y[cone[:, 0]] < 0]] = 0.0
            y[cone[:, 0]] = np.maximum(y[cone[:, 0]], np.linalg.norm(y[cone[:, 1:]], axis=1))
        return y


def polish(program: Arrays, x: Array, y: Array) -> tuple[Array, Array]:
    """Move a solution onto its active rows and cones, by Newton's method on their equations.

    Which are active is read from the ratios of multiplier to slack, which solvers leave large for
    active rows and cones and small for the others. Where the widest gap between the ratios does not
    part them rightly, the next ones are tried; rows and cones that the solution contradicts change
    sides. The answer is the point that breaks the conditions of the whole program least; whether it
    is good enough is for a residual to say.
    """
    best = x, program.admissible(y)
    least = program.off(*best)
    with np.errstate(all="ignore"):  # a step of a wrong guess may go anywhere, and `off` judges it
        for share in _shares(program, x, y):
            at, slopes, before = x, y, None
            for _ in range(_REVISIONS):
                active = _Active(program, at, slopes, share)
                if before is not None and all(
                    np.array_equal(*pair) for pair in zip(active.rows, before.rows, strict=True)
                ):
                    break
                at, slopes = active.solved(at, slopes)
                for told in (
                    slopes,
                    y,
                ):  # where more is active than there are unknowns, the multipliers are not unique
                    told = program.admissible(told)
                    if (off := program.off(at, told)) < least:
                        best, least = (at, told), off
                    if least <= ROUNDING:
                        return best
                before = active
    return best


def _shares(program: Arrays, x: Array, y: Array) -> list[float]:
    """Ratios of multiplier to slack in the middle of the widest gaps between those of all rows and cones, the widest gap first."""
    s = program.slack(x)
    room, by = np.hstack([side for cone in program.cones for side in _sides(s[cone], y[cone])])
    ratios = np.where(room > 0, by / np.where(room > 0, room, 1.0), np.inf)
    powers = np.sort(np.log10(np.clip(ratios, _LEAST_RATIO, 1 / _LEAST_RATIO)))
    return [
        float(10 ** powers[[k, k + 1]].mean())
        for k in np.argsort(-np.diff(powers), kind="stable")[:_GAPS]
    ]


def _sides(s: Array, y: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Slacks and multipliers of cones, (n, d), on their boundary and at their apex."""
    radius, slid = np.linalg.norm(s[:, 1:], axis=1), np.linalg.norm(y[:, 1:], axis=1)
    return (s[:, 0] - radius, y[:, 0] + np.copysign(slid, y[:, 0])), (
        s[:, 0] + radius,
        y[:, 0] - slid,
    )


def _directed(vectors: Array) -> tuple[Array, Array]:
    """Lengths and directions of vectors, (n, d); 1 and 0 of one that vanishes."""
    radius = np.linalg.norm(vectors, axis=1)
    radius = np.where(radius > 0, radius, 1.0)
    return radius, vectors / radius[:, None]


class _Active:
    """What is active at a point: equations, cones at their apex, where all slacks vanish, and cones on their boundary, which are the last `rows`."""

    def __init__(self, program: Arrays, x: Array, y: Array, share: float) -> None:
        self._program, s = program, program.slack(x)
        shut, on = [np.arange(program.zero)], list[Integers]()
        for cone in (
            program.cones if program.zero < len(x) else ()
        ):  # as many equations as unknowns fix them, and prove it
            (slack, slid), (tip, excess) = _sides(s[cone], y[cone])
            apex = excess > share * tip
            shut.append(cone[apex].ravel())
            on += (
                [cone[(slid > share * slack) & ~apex & s[cone[:, 1:]].any(axis=1)]]
                if cone.shape[1] > 1
                else []
            )
        self.rows = [np.concatenate(shut), *on]

    def _equations(self, x: Array, m: Array) -> tuple[Array, Array, Array]:
        """Values of the active rows and cones, their gradients, and the Hessian of their sum weighted by the multipliers m, negative."""
        (shut, *on), matrix, s, n = self.rows, self._program.matrix, self._program.slack(x), len(x)
        values, gradients, hessian, at = (
            [s[shut]],
            [-matrix[shut].toarray()],
            np.zeros((n, n)),
            len(shut),
        )
        for cone in on:
            radius, unit = _directed(s[cone[:, 1:]])
            sides = -matrix[cone[:, 1:].ravel()].toarray().reshape(*unit.shape, n)
            along = np.einsum("ri,riz->rz", unit, sides)
            values.append(s[cone[:, 0]] - radius)
            gradients.append(-matrix[cone[:, 0]].toarray() - along)
            weight = np.sqrt(np.maximum(m[at : at + len(cone)], 0.0) / radius)
            across = ((sides - unit[:, :, None] * along[:, None]) * weight[:, None, None]).reshape(
                -1, n
            )
            hessian, at = hessian + across.T @ across, at + len(cone)
        return np.concatenate(values), np.vstack(gradients), hessian

    def solved(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The x and multipliers that solve the equations of what is active, by Newton's method from a point."""
        cost, (shut, *on) = self._program.cost, self.rows
        m, least = np.concatenate([y[shut], *(y[cone[:, 0]] for cone in on)]), np.inf
        best = x, m
        for _ in range(_STEPS):
            values, gradients, hessian = self._equations(x, m)
            error = max(
                float(np.abs(gradients.T @ m - cost).max(initial=0.0)),
                float(np.abs(values).max(initial=0.0)),
            )
            if error < least:
                best, least = (x, m), error
            elif least <= STALLED or not np.isfinite(error):
                break
            if error <= _POLISHED:
                break
            matrix = np.block([[-hessian, gradients.T], [gradients, np.zeros((len(m), len(m)))]])
            step = _least(matrix, np.r_[cost, -values])
            x, m = x + step[: len(x)], step[len(x) :]
        (x, m), slopes, at = best, np.zeros(len(y)), len(shut)
        s, slopes[shut] = self._program.slack(x), m[:at]
        for cone in on:
            size = m[at : at + len(cone)]
            slopes[cone[:, 0]], at = size, at + len(cone)
            slopes[cone[:, 1:]] = -size[:, None] * _directed(s[cone[:, 1:]])[1]
        return x, slopes


def _least(matrix: Array, right: Array) -> Array:
    """The solution of symmetric equations, the least one where they have several."""
    factor, order, _ = dsytrf(matrix, lwork=int(dsytrf_lwork(len(matrix))[0]))
    if dsycon(factor, order, np.abs(matrix).sum(axis=0).max())[0] > _NOT_UNIQUE:
        return np.asarray(dsytrs(factor, order, right)[0])
    return np.asarray(
        lstsq(matrix, right, cond=_NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0]
    )
