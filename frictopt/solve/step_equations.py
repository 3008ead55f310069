"""The linear equations of a step of the interior point, for rows with one dense block.

The matrix A of the rows has a sparse part and a dense one: `A y = sparse [y, block y]`. W is the
scaling of the cones. A step solves `A' z = u` and `A y - W^2 z = v`. There are two ways to
eliminate z. Below, H is the sparse matrix `sparse' W^-2 sparse`, which multiplies w = [y, block y].

- `_Direct`: one equation for each unknown y, with the matrix `A' W^-2 A`.
- `_ThroughBlock`: y minimises `w' H w / 2 - work' w` over the w with `[block, -1] w = 0`. With
  `H = R' R` and `F = [block, -1] R^-1`, R w is the projection of `R'^-1 work` onto the vectors that
  F maps to zero. This takes one equation for each row of the block, with the matrix F F'.

A contact in space has two unknowns for each row of its block. The second way then takes a third of
the work of the first. The second way loses its digits near an optimum: F F' then holds the squares
of very large and very small entries of R^-1. So the errors of the original equations are computed,
and the first way takes over if iterative refinement does not make them small.
"""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.sparse import csc_array, csr_array, dia_array, eye_array, triu
from scipy.sparse.linalg import splu

from ..base import Array
from .condensed import Condensed, Scaling

# Constants of the equations of a step.

# Relative increases of the diagonal of a step's matrix, tried in turn until the Cholesky
# factorisation succeeds.
_SHIFTS = (1e-14, 1e-13, 1e-12, 1e-11)
# An error of the equations of a step, relative to their right side, is corrected only if it is
# above this number.
_CORRECT = 1e-13
# Corrections go on as long as each leaves less than this share of the error.
_HELPS = 0.1
# Number of rows of the matrix that are computed at once, from the diagonal on.
_ROWS = 250
# The way through the block needs at least this number of unknowns, and of unknowns for each row of
# the block. With fewer unknowns, its sparse matrices take longer than the dense ones that it saves.
_UNKNOWNS = 600
_UNKNOWNS_PER_ROW = 1.5
# Largest number of entries of R for each of its rows: blocks of a node have three.
_ENTRIES = 12
# Error of the equations, relative to their right side, above which the direct way takes over from
# the way through the block. Near an optimum the direct way itself usually leaves a larger error.
_ENOUGH = 1e-12


def begins_through_block(program: Condensed) -> bool:
    """Whether the way through the block takes less work for a program."""
    rows, unknowns = program.block.shape
    return unknowns >= max(_UNKNOWNS, _UNKNOWNS_PER_ROW * rows)


class Equations:
    """The equations `A' z = u` and `A y - W^2 z = v` of a step.

    `through_block`: whether they are solved through the block; it becomes False if this way fails.
    ArithmeticError if their matrix cannot be factorised.
    """

    def __init__(self, program: Condensed, scaling: Scaling, through_block: bool = False) -> None:
        self._program = program
        self._scaling = scaling
        self._way: _Direct | _ThroughBlock | None = None
        if through_block:
            with suppress(ArithmeticError):
                self._way = _ThroughBlock(program, scaling)
        if self._way is None:
            self._way = _Direct(program, scaling)

    @property
    def through_block(self) -> bool:
        """Whether the equations are solved through the block."""
        return isinstance(self._way, _ThroughBlock)

    def solved(self, u: Array, v: Array) -> tuple[Array, Array]:
        """The y and z, improved by iterative refinement in the original equations."""
        y, z, error = self._refined(u, v)
        if self.through_block and not error <= _ENOUGH * _largest(u, v):
            self._way = None  # its matrices are not needed beside the matrices of the direct way
            self._way = _Direct(self._program, self._scaling)
            y, z, _ = self._refined(u, v)
        return y, z

    def _refined(self, u: Array, v: Array) -> tuple[Array, Array, float]:
        """The y and z, and the largest error of their equations."""
        program, over, times = self._program, self._scaling.over, self._scaling.times
        assert self._way is not None
        y, z = np.zeros(len(u)), np.zeros(len(v))
        left, right = u, v
        size = _largest(u, v)
        error, before = size, np.inf
        while _CORRECT * size < error < _HELPS * before:
            work = program.sparse.T @ over(over(right))
            work[: len(u)] += left
            step = self._way.solved(work)
            of_step = program.rows(step)
            # The first y is the step itself.
            of_y = program.rows(y + step) if y.any() else of_step
            y = y + step
            z = z + over(over(of_step - right))
            left = u - program.columns(z)
            right = v - of_y + times(times(z))
            error, before = _largest(left, right), error
        return y, z, error


class _Direct:
    """The y with `A' W^-2 A y = [1, block'] work`; `work` (n + m) is the work on `[y, block y]`."""

    def __init__(self, program: Condensed, scaling: Scaling) -> None:
        self._block = program.block
        self._weights = scaling.inverse_square(program.sparse)
        self._factor = _factor(self._matrix)

    def _matrix(self) -> Array:
        """The lower triangle of `A' W^-2 A`, stored by columns.

        It is computed a few columns at a time, as a second array of its size would fill the memory.
        """
        block, weights = self._block, self._weights
        n = block.shape[1]
        across = csc_array(weights[n:, :n])
        of_block = weights[n:, n:]
        matrix = np.zeros((n, n), order="F")
        for start in range(0, n, _ROWS):
            rows = slice(start, min(start + _ROWS, n))
            half = across[:, rows] + of_block @ block[:, rows]
            matrix[start:, rows] = (half.T @ block[:, start:]).T
            matrix[start:, rows] += across[:, start:].T @ block[:, rows]
            matrix[start:, rows] += weights[start:n, rows].toarray()
        return matrix

    def solved(self, work: Array) -> Array:
        n = self._block.shape[1]
        right = work[:n] + work[n:] @ self._block
        return np.asarray(dpotrs(self._factor, right, lower=True)[0])


class _ThroughBlock:
    """The y of `_Direct`, by the projection at the head of this file.

    R is ordered so that its first rows belong to `block y`. Then F is diagonal, or nearly so, in
    its first columns, and dense in its other columns.
    """

    def __init__(self, program: Condensed, scaling: Scaling) -> None:
        m, n = program.block.shape
        inverse = _inverse_root(scaling.inverse_square(program.sparse), n)
        self._inverse = inverse
        of_y, of_block = inverse[:n], inverse[n:]
        self._sparse = csr_array(-of_block[:, :m])
        dense = csr_array(of_y[:, m:].T) @ program.block.T
        entries = of_block[:, m:].tocoo()
        dense[entries.col, entries.row] -= entries.data
        self._dense = dense.T
        self._factor = _factor(self._matrix)

    def _matrix(self) -> Array:
        """The lower triangle of F F', stored by columns."""
        matrix = dsyrk(1.0, self._dense, lower=True)
        entries = (self._sparse @ self._sparse.T).tocoo()
        matrix[entries.row, entries.col] += entries.data
        return np.asarray(matrix)

    def solved(self, work: Array) -> Array:
        m, n = self._dense.shape
        t = self._inverse.T @ work
        outside = self._sparse @ t[:m] + self._dense @ t[m:]
        forces = dpotrs(self._factor, outside, lower=True)[0]
        t[:m] -= self._sparse.T @ forces
        t[m:] -= forces @ self._dense
        return np.asarray((self._inverse @ t)[:n])


def _inverse_root(weights: csr_array, n: int) -> csr_array:
    """The matrix `X = R^-1` with `weights = R' R`, for a sparse positive definite matrix.

    The rows of X are in the order of the weights. The columns of X are reordered: first come the
    columns for the weights from index n on, and in both parts the columns with few entries come
    first. Then R has few entries, and so has X. ArithmeticError if R or X has many entries, or if
    rounding leaves the weights indefinite.
    """
    counts = np.diff(weights.indptr)
    order = np.concatenate(
        [n + np.argsort(counts[n:], kind="stable"), np.argsort(counts[:n], kind="stable")]
    )
    ordered = csc_array(weights[order][:, order])
    try:
        factors = splu(ordered, "NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise ArithmeticError(str(error)) from None
    upper = factors.U
    pivots = upper.diagonal()
    in_order = np.array_equal(factors.perm_r, np.arange(len(order)))
    if not (in_order and (pivots > 0).all()) or upper.nnz > _ENTRIES * len(order):
        raise ArithmeticError("the weights of a step have no sparse root")
    # With U = D (1 + N), the inverse of 1 + N is the sum of the powers of -N, which vanish soon.
    power = inverse = csr_array(eye_array(len(order)))
    nilpotent = csr_array(triu(_diagonal(1 / pivots) @ upper, k=1))
    while power.nnz:
        power = csr_array(-(power @ nilpotent))
        inverse = inverse + power
        if inverse.nnz > _ENTRIES * len(order):
            raise ArithmeticError("the weights of a step have no sparse root")
    scaled = csr_array(inverse @ _diagonal(1 / np.sqrt(pivots)))
    return csr_array(scaled[np.argsort(order)])


def _diagonal(values: Array) -> dia_array:
    return dia_array((values[None], 0), shape=(len(values),) * 2)


def _largest(u: Array, v: Array) -> float:
    """The largest entry of two vectors."""
    return max(float(np.abs(u).max()), float(np.abs(v).max()))


def _factor(matrix_of: Callable[[], Array]) -> Array:
    """The lower Cholesky factor of a matrix, given by a function that computes its lower triangle.

    The factor takes the place of the matrix, which is computed again if the factorisation fails.
    """
    for shift in _SHIFTS:
        matrix = matrix_of()
        np.fill_diagonal(matrix, matrix.diagonal() * (1 + shift))
        factor, failed = dpotrf(matrix, lower=True, clean=False, overwrite_a=True)
        if not failed:
            return np.asarray(factor)
        del matrix, factor  # not needed beside the next one
    raise ArithmeticError("the equations of a step cannot be factorised")
