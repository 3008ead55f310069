"""Redundant rows, which other rows imply, leave the program; their multipliers are zero."""

from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from ..base import ROUNDING, Array, Booleans, Integers
from .arrays import Arrays
from .eliminated import Definitions
from .program import ChangesRows, Program

P = TypeVar("P", Program, Arrays)


class RowsLeftOut(ChangesRows[P]):
    """Equations and linear rows leave the program."""

    def __init__(self, program: P, rows: Integers) -> None:
        stays = np.ones(len(program.right), dtype=bool)
        stays[rows] = False
        self._stays = stays
        self.after = program
        if not stays.all():
            linear_left_out = int((~stays[program.zero :]).sum())
            self.after = replace(
                program,
                sparse=csr_array(program.sparse[stays]),
                right=program.right[stays],
                zero=int(stays[: program.zero].sum()),
                sizes=program.sizes[linear_left_out:],
            )

    def multipliers(self, y: Array, cost_factor: float) -> Array:
        """Zero for the rows that were left out."""
        multipliers = np.zeros(len(self._stays))
        multipliers[self._stays] = y
        return multipliers


def redundant(program: Program) -> Integers:
    """Linear rows that other rows imply, or that are empty."""
    return np.concatenate([implied_by_cones(program), dominated(program), empty(program)])


def implied_by_norms(program: Program, bounds: Definitions) -> Integers:
    """Linear rows `a z <= b` that an abs or a norm implies, as `abs(q) <= f p` does `p >= 0`.

    The unknown t of an abs or a norm is never negative. So its bound `t + c a z <= c b`, a row of
    `bounds`, implies `a z <= b`.
    """
    sure = _never_negative(program, bounds.unknowns)
    unknowns, names, pivots = (part[sure] for part in bounds)
    rows = csr_array(program.sparse[names])
    is_bound = rows.indices == np.repeat(unknowns, np.diff(rows.indptr))
    rows.data = np.where(is_bound, 0.0, rows.data)
    # For smaller f the row `abs(q) <= f p` implies `p >= 0` only to a few digits, so `p >= 0` is
    # kept.
    least_clear = 0.01
    clear = largest_entries(rows) >= least_clear * pivots
    linear = np.arange(program.zero, program.linear)
    linear = np.delete(linear, bounds.rows - program.zero)
    return _implied_by(rows[clear], program.right[names[clear]], program, linear)


def implied_by_cones(program: Program) -> Integers:
    """Linear rows that the first slack >= 0 of a cone implies, if it contains a single unknown."""
    heads = program.heads[program.sizes > 1]
    heads = heads[np.diff(program.sparse.indptr)[heads] == 1]
    linear = np.arange(program.zero, program.linear)
    return _implied_by(program.sparse[heads], program.right[heads], program, linear)


def _implied_by(
    sources: csr_array, source_right: Array, program: Program, linear: Integers
) -> Integers:
    """The rows of `linear` that are multiples of a source and whose right side is not smaller."""
    if not sources.shape[0]:
        return linear[:0]
    # In their units, unknowns of a large unit are not lost in the rounding of a sum.
    unit = np.where(program.unit > 0, program.unit, 1.0)
    source_keys, source_limits, _ = _keys(_weighed(sources, unit), source_right)
    keys, limits, sizes = _keys(_weighed(program.sparse[linear], unit), program.right[linear])
    group = np.unique(np.r_[source_keys, keys], return_inverse=True)[1]
    count = len(source_keys)
    least = np.full(len(group), np.inf)  # the right side that sources imply for a group of rows
    np.minimum.at(least, group[:count], source_limits)
    return linear[(limits >= least[group[count:]]) & (sizes > 0)]


def _never_negative(program: Program, unknowns: Integers) -> Booleans:
    """Which unknowns t are never negative.

    The rows and first slacks with `-t` in them must add up to a multiple of `-t <= 0`.
    """
    heads = program.heads
    rows = program.sparse[heads]
    weights = csr_array(rows[:, unknowns].T)
    weights.data = np.minimum(weights.data, 0.0)
    total = csr_array(weights @ rows)
    total.data[np.abs(total.data) <= ROUNDING * np.abs(total.data).max(initial=0.0)] = 0.0
    total.eliminate_zeros()
    alone = np.diff(total.indptr) == 1
    alone[alone] = total.indices[total.indptr[:-1][alone]] == unknowns[alone]
    return np.asarray(alone & (weights @ program.right[heads] == 0))


def _weighed(rows: csr_array, unit: Array) -> csr_array:
    """The rows with their entries in the units of the unknowns."""
    return csr_array((rows.data * unit[rows.indices], rows.indices, rows.indptr), shape=rows.shape)


def _keys(rows: csr_array, right: Array) -> tuple[Array, Array, Array]:
    """Keys of rows, their scaled right sides, and their scales, which are their largest entries.

    A key is the product of the scaled row with a random complex vector. Rows that are multiples of
    each other have equal keys, up to 12 digits.
    """
    sizes = largest_entries(rows)
    scale = np.where(sizes > 0, sizes, 1.0)
    vectors = np.random.default_rng(0).normal(size=(2, rows.shape[1]))
    marks = rows @ (vectors[0] + 1j * vectors[1]) / scale
    return np.round(marks, 12), right / scale, sizes


def largest_entries(rows: csr_array) -> Array:
    """The size of the largest entry of each row, 0 of an empty one."""
    if not rows.shape[0]:
        return np.zeros(0)
    entries = np.r_[np.abs(rows.data), 0.0]  # a last entry, for empty rows at the end
    largest = np.maximum.reduceat(entries, rows.indptr[:-1])
    return np.asarray(largest * (np.diff(rows.indptr) > 0))


def dominated(program: Program) -> Integers:
    """Linear rows that another row implies for an unknown x >= 0.

    Such rows differ from the other row only in the coefficient of x and in the right side, and are
    weaker in both.
    """
    linear = slice(program.zero, program.linear)
    matrix = csr_array(program.sparse[linear])
    right = program.right[linear]
    n = len(right)
    single = np.flatnonzero(np.diff(matrix.indptr) == 1)
    first = matrix.indptr[single]
    # Rows -c x <= d with c > 0 and d <= 0: they say that x >= 0.
    signed = single[(matrix.data[first] < 0) & (right[single] <= 0)]
    if not len(signed):
        return np.zeros(0, dtype=int)
    unknown = int(matrix.indices[matrix.indptr[signed[0]]])

    entries = matrix.tocoo()
    in_column = entries.col == unknown
    coefficient = np.zeros(n)
    coefficient[entries.row[in_column]] = entries.data[in_column]
    group = _groups_of_equal_rows(matrix, unknown)

    # In each group the rows are ordered by falling coefficients. A row is stronger than all rows
    # before it only if its right side is smaller.
    order = np.lexsort([right, -coefficient, group])
    begins = np.diff(group[order], prepend=-1) != 0
    rank = np.unique(right[order], return_inverse=True)[1]
    shift = (n + 1) * np.cumsum(begins)  # all ranks of a group are below those of groups before
    least = np.minimum.accumulate(rank - shift) + shift
    stronger = begins | (rank < np.r_[n, least[:-1]])
    weaker = np.zeros(n, dtype=bool)
    weaker[order[~stronger]] = True
    weaker[signed] = False  # the sign itself must stay
    return np.asarray(program.zero + np.flatnonzero(weaker))


def _groups_of_equal_rows(matrix: csr_array, left_out: int) -> Integers:
    """For each row the number of its group; the rows of a group differ in one column at most."""
    others = matrix.copy()
    others.data[others.indices == left_out] = 0.0
    others.eliminate_zeros()
    others.sort_indices()
    groups = dict[tuple[bytes, bytes], int]()
    numbers = list[int]()
    for begin, end in pairwise(others.indptr.tolist()):
        row = others.indices[begin:end].tobytes(), others.data[begin:end].tobytes()
        numbers.append(groups.setdefault(row, len(groups)))
    return np.array(numbers, dtype=int)


def empty(program: Program) -> Integers:
    """Linear rows without unknowns that always hold."""
    linear = np.arange(program.zero, program.linear)
    without_entries = np.diff(program.sparse.indptr)[linear] == 0
    return np.asarray(linear[without_entries & ~(program.right[linear] < 0)])


def dependent(program: Arrays) -> Integers:
    """Equations that other equations imply. Contradicting equations are not among them."""
    zero = program.zero
    width = program.block.shape[1]
    if not zero:
        return np.zeros(0, dtype=int)
    equations = (
        program.sparse[:zero, :width].toarray() + program.sparse[:zero, width:] @ program.block
    )
    columns = np.vstack([equations.T, program.right[:zero]])
    upper, order = qr(columns, mode="r", pivoting=True)
    rank = int((np.abs(np.diagonal(upper)) > ROUNDING).sum())
    return np.asarray(np.sort(order[rank:]))
