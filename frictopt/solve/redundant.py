"""Rows that others stand for."""

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ..base import ROUNDING, Array, Booleans, Integers
from .arrays import Arrays


def dominated(matrix: csr_array, right: Array) -> Integers:
    """The linear rows that others stand for: they differ in the coefficient of one unknown >= 0, and in the right side, and are weaker in both."""
    n, single = len(right), np.flatnonzero(np.diff(matrix.indptr) == 1)
    at = matrix.indptr[single]
    signed = single[(matrix.data[at] < 0) & (right[single] <= 0)]
    if not len(signed):
        return np.zeros(0, dtype=int)
    unknown, entries, coefficient = (
        int(matrix.indices[matrix.indptr[signed[0]]]),
        matrix.tocoo(),
        np.zeros(n),
    )
    its, ways = entries.col == unknown, np.random.default_rng(0).normal(size=(matrix.shape[1], 2))
    coefficient[entries.row[its]], ways[unknown] = entries.data[its], 0.0
    mark = matrix @ ways  # equal rows have equal marks, and others only by chance
    order = np.lexsort([right, -coefficient, mark[:, 1], mark[:, 0]])
    new = np.r_[True, (np.diff(mark[order], axis=0) != 0).any(axis=1)]
    rank, after = np.unique(right[order], return_inverse=True)[1], (n + 1) * np.cumsum(new)
    least = (
        np.minimum.accumulate(rank - after) + after
    )  # of each group: those of the next are less than all before
    stronger = new | (rank < np.r_[n, least[:-1]])
    return np.setdiff1d(
        order[~stronger], signed
    )  # the row that says the sign is needed for all others


def headed(matrix: csr_array, right: Array, sizes: Integers) -> Integers:
    """The linear rows that say no more than `x >= 0` of an unknown x that alone bounds a cone: the cone says so, too."""
    linear, heads = int((sizes == 1).sum()), (np.cumsum(sizes) - sizes)[sizes > 1]

    def alone(rows: Integers, signs: Booleans) -> tuple[Integers, Integers]:
        """Of some rows those of one entry, which is negative, and the unknown of each."""
        rows = rows[(np.diff(matrix.indptr)[rows] == 1) & signs[rows]]
        rows = rows[matrix.data[matrix.indptr[rows]] < 0]
        return rows, matrix.indices[matrix.indptr[rows]]

    unknowns = alone(heads, right <= 0)[1]
    rows, signed = alone(np.arange(linear), right >= 0)
    return rows[np.isin(signed, unknowns)]


def independent(program: Arrays) -> Integers:
    """The equations for which no others stand; where others contradict them, too."""
    zero, width = program.zero, program.block.shape[1]
    equations = (
        program.sparse[:zero, :width].toarray() + program.sparse[:zero, width:] @ program.block
    )
    upper, order = qr(np.vstack([equations.T, program.right[:zero]]), mode="r", pivoting=True)
    return np.sort(order[: int((np.abs(np.diagonal(upper)) > ROUNDING).sum())])
