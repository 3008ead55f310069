"""What makes the rows of a compiled program fewer, step by step: each puts something in, and knows the way back for its answer.

In the order in which they are applied: unknowns of cvxpy's own (the bounds of abs and norm), unknowns that an equation defines, rows that others
stand for. None knows what a program is about.
"""

import numpy as np
import pandas as pd
from scipy.sparse import csc_array, csr_array, diags_array

from ..contact import Array, Integers
from .compiled import Compiled


class Rows:
    """The rows of a program as they are reduced: `right - matrix @ z >= 0` or in cones, `equations @ z = sides`, and the cost.

    `heads` are the rows of which each cone is the first, by `sizes`; the linear rows have size 1 and stand first.
    """

    def __init__(self, compiled: Compiled) -> None:
        zero, first = compiled.zero, compiled.sparse_zero
        self.matrix, self.right, self.cost = csr_array(compiled.matrix[zero:]), compiled.right[zero:].copy(), compiled.cost.copy()
        self.equations, self.sides, self.constant = csr_array(compiled.matrix[first:zero]), compiled.right[first:zero].copy(), 0.0
        self.sizes = np.r_[np.ones(compiled.nonneg, dtype=int), np.array(compiled.soc, dtype=int)]
        self.names, self.named = np.arange(zero, len(compiled.right)), np.arange(first, zero)  # places of the rows left among the compiled ones
        taken = [np.r_[block.defined, block.of] for block in compiled.blocks]
        self.taken = np.unique(np.concatenate(taken)) if taken else np.zeros(0, dtype=int)  # unknowns of dense equations

    @property
    def heads(self) -> Integers:
        """The first row of each cone."""
        return np.asarray(np.cumsum(self.sizes) - self.sizes)

    def without(self, unknowns: Integers, pivots: Array, rows: csr_array, sides: Array) -> None:
        """Put in `unknowns = (sides - the rest of rows @ z) / pivots`."""
        by = diags_array(1 / pivots)
        share, cost = csr_array(csc_array(self.matrix)[:, unknowns] @ by), self.cost[unknowns] / pivots
        self.matrix, self.right = _clean(self.matrix - share @ rows, unknowns), self.right - share @ sides
        self.constant += float(cost @ sides)
        self.cost = self.cost - rows.T @ cost
        self.cost[unknowns] = 0.0


class Defined:
    """Unknowns that rows define, `pivots * z[unknowns] + rest = sides`: equations, or bounds that only help where they are met."""

    def __init__(self, unknowns: Integers, rows: csr_array, sides: Array, names: Integers) -> None:
        self.unknowns, self._rows, self._sides, self._names = unknowns, rows, sides, names
        self._pivots = np.asarray(rows[np.arange(len(unknowns)), unknowns]).ravel()

    def put_in(self, program: Rows) -> None:
        """The program without them."""
        program.without(self.unknowns, self._pivots, self._rows, self._sides)

    def value(self, z: Array) -> None:
        """Their values, from those of the others."""
        z[self.unknowns] = 0.0
        z[self.unknowns] = (self._sides - self._rows @ z) / self._pivots

    def unit(self, units: Array) -> None:
        """Their units, where none is known, from those of the others in their rows."""
        none = self.unknowns[units[self.unknowns] == 0]
        sizes = (np.abs(self._rows) @ units + np.abs(self._sides)) / np.abs(self._pivots)
        units[none] = sizes[np.isin(self.unknowns, none)]

    def multiplier(self, y: Array, matrix: csr_array, cost: Array) -> None:
        """The multipliers of their rows, from those of all others with them."""
        y[self._names] = -(matrix.T @ y + cost)[self.unknowns] / self._pivots


def own_unknowns(program: Rows) -> Defined | None:
    """Leave out unknowns `t <= b - a @ z` that one row bounds and that only help in all others: those of abs and norm, one a row."""
    linear, heads = np.arange(program.right.size) < (program.sizes == 1).sum(), np.zeros(program.right.size, dtype=bool)
    heads[program.heads] = True
    matrix = csc_array(program.matrix)

    def count(rows: Array, sign: int) -> Array:
        return np.asarray(((sign * matrix[rows]) > 0).sum(axis=0)).ravel()

    elsewhere = np.asarray((matrix[~heads] != 0).sum(axis=0)).ravel() + np.asarray((program.equations != 0).sum(axis=0)).ravel()
    only = (program.cost == 0) & (count(heads, 1) == 1) & (count(linear, 1) == 1) & (elsewhere == 0) & (count(heads, -1) > 0)
    only[program.taken] = False
    unknowns = np.flatnonzero(only)
    if not len(unknowns):
        return None
    entries = matrix[:, unknowns].tocoo()
    up = entries.data > 0
    row, first = np.unique(entries.row[up], return_index=True)
    unknowns = unknowns[entries.col[up][first]]
    alone = np.asarray((program.matrix[row][:, unknowns] != 0).sum(axis=1)).ravel() == 1
    row, unknowns = row[alone], unknowns[alone]
    defined = Defined(unknowns, csr_array(program.matrix[row]), program.right[row], program.names[row])
    defined.put_in(program)
    keep = np.setdiff1d(np.arange(len(program.right)), row)
    program.matrix, program.right, program.names = csr_array(program.matrix[keep]), program.right[keep], program.names[keep]
    program.sizes = np.r_[np.ones((program.sizes == 1).sum() - len(row), dtype=int), program.sizes[program.sizes > 1]]
    return defined


def defined_unknowns(program: Rows, unit: Array) -> Defined | None:
    """Leave out unknowns that stand in one equation alone, one an equation: that of the largest part in it."""
    entries = program.equations.tocoo()
    alone = np.bincount(entries.col, minlength=len(unit)) == 1
    alone[program.taken] = False
    row, column, size = (part[alone[entries.col]] for part in (entries.row, entries.col, np.abs(entries.data) * unit[entries.col]))
    order = np.lexsort([column, -size, row])
    row, first = np.unique(row[order], return_index=True)
    if not len(row):
        return None
    defined = Defined(column[order][first].astype(int), csr_array(program.equations[row]), program.sides[row], program.named[row])
    defined.put_in(program)
    keep = np.setdiff1d(np.arange(len(program.sides)), row)
    program.equations, program.sides, program.named = csr_array(program.equations[keep]), program.sides[keep], program.named[keep]
    return defined


def dominated(program: Rows) -> Integers:
    """The rows that others stand for: they differ in the coefficient of one unknown >= 0, and in the right side, and are weaker in both."""
    n = int((program.sizes == 1).sum())
    matrix, right = csr_array(program.matrix[:n]), program.right[:n]
    single = np.flatnonzero(np.diff(matrix.indptr) == 1)
    at = matrix.indptr[single]
    signed = single[(matrix.data[at] < 0) & (right[single] <= 0)]
    if not len(signed):
        return np.zeros(0, dtype=int)
    unknown = int(matrix.indices[matrix.indptr[signed[0]]])
    coefficient = matrix[:, [unknown]].toarray().ravel()
    others = _clean(matrix, np.array([unknown]))
    ways = np.random.default_rng(0).normal(size=(matrix.shape[1], 2))
    mark = others @ ways  # equal rows have equal marks, and others never, but for chance
    order = np.lexsort([right, -coefficient, mark[:, 1], mark[:, 0]])
    new = np.r_[True, (np.diff(mark[order], axis=0) != 0).any(axis=1)]
    group = np.cumsum(new)
    least = pd.Series(right[order]).groupby(group).cummin().to_numpy()
    before = np.r_[np.inf, least[:-1]]
    stronger = new | (right[order] < before)
    return np.setdiff1d(order[~stronger], signed)  # the row that says the sign is needed for all others


def _clean(matrix: csr_array, unknowns: Integers) -> csr_array:
    """A matrix without the entries of unknowns that have been put in."""
    kept = np.ones(matrix.shape[1])
    kept[unknowns] = 0.0
    matrix = csr_array(csr_array(matrix) @ diags_array(kept))
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix
