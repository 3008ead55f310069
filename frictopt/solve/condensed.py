"""A cone program without the variables that its equations define: sparse rows, and one dense block that all of them share."""

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.sparse import csc_array, csr_array, hstack

from ..contact.checks import Array
from .cones import Scaling

_LONG = 0.2  # share of the unknowns from which on a row counts as dense
_ROWS = 500  # rows in a part of the product, of which only the lower triangle is computed
_SHIFT = 1e-14  # of the diagonal, over itself, so that rounding leaves the equations a factor


class Condensed:
    """The rows `right - A y` of cones and `objective @ y`, with `A y = sparse [y, block y]`.

    The block has the rows that define variables of the program, and the long rows of its cones.

    Parameters
    ----------
    matrix, right, objective
        The rows `right - matrix x` of the program, and its objective.
    zero
        How many of the first rows are zero; each must define a variable that no other one of them has.

    Raises
    ------
    ValueError
        An equation defines no variable.
    """

    def __init__(self, matrix: csr_array, right: Array, objective: Array, zero: int) -> None:
        equations, rows = csc_array(matrix[:zero]), csc_array(matrix[zero:])
        alone = np.flatnonzero(np.diff(equations.indptr) == 1)
        defining, first = np.unique(equations.indices[equations.indptr[alone]], return_index=True)
        if len(defining) < zero:
            raise ValueError("an equation defines no variable of its own")
        self._defined = alone[first]
        self._kept = np.setdiff1d(np.arange(matrix.shape[1]), self._defined)
        self._pivots = equations.data[equations.indptr[self._defined]]
        self._start, self._costs = right[:zero] / self._pivots, objective[self._defined]
        define = -equations[:, self._kept].toarray() / self._pivots[:, None]
        on_kept, on_defined = csr_array(rows[:, self._kept]), rows[:, self._defined]
        long = np.diff(on_kept.indptr) > _LONG * len(self._kept)
        chosen = csr_array((np.ones(long.sum()), (np.flatnonzero(long), np.arange(long.sum()))), shape=(len(long), int(long.sum())))
        self._block = np.vstack([define, on_kept[long].toarray()])
        self._sparse = csr_array(hstack([on_kept.multiply(~long[:, None]), on_defined, chosen]))
        self._transposed = csr_array(self._sparse.T)
        self.right, self.objective = right[zero:] - on_defined @ self._start, objective[self._kept] + define.T @ self._costs

    def rows(self, y: Array) -> Array:
        """`A y`."""
        return np.asarray(self._sparse @ np.concatenate([y, self._block @ y]))

    def columns(self, z: Array) -> Array:
        """`A' z`."""
        work = self._transposed @ z
        return np.asarray(work[: len(self._kept)] + work[len(self._kept) :] @ self._block)

    def whole(self, y: Array, z: Array) -> tuple[Array, Array]:
        """Variables and multipliers of the program."""
        x, zero, n = np.empty(len(self._kept) + len(self._defined)), len(self._defined), len(self._kept)
        x[self._kept], x[self._defined] = y, self._start + self._block[:zero] @ y
        work = self._transposed @ z
        return x, np.concatenate([-(self._costs + work[n : n + zero]) / self._pivots, z])

    def factor(self, scaling: Scaling) -> Array:
        """The Cholesky factor of the equations `A' W^-2 A`, upper.

        Raises
        ------
        ArithmeticError
            They have none.
        """
        n, weights = len(self._kept), self._transposed @ scaling.inverse_square() @ self._sparse
        across = weights[n:, :n]
        block, matrix = weights[n:, n:] @ self._block + across, across.T @ self._block
        matrix += weights[:n, :n]
        for start in range(0, n, _ROWS):
            rows = slice(start, start + _ROWS)
            matrix[rows, : rows.stop] += self._block[:, rows].T @ block[:, : rows.stop]
        matrix[np.diag_indices(n)] *= 1 + _SHIFT
        factor, failed = dpotrf(matrix.T, overwrite_a=1)  # its upper triangle, in the order of columns
        if failed:
            raise ArithmeticError("the equations of a step have no factor")
        return np.asarray(factor)

    @staticmethod
    def solved(factor: Array, right: Array) -> Array:
        """The solution of the equations."""
        return np.asarray(dpotrs(factor, right)[0])
