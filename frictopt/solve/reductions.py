"""What makes the rows of a compiled program fewer, step by step: each puts something in, and knows the way back for its answer.

In the order in which they are applied: unknowns of cvxpy's own (the bounds of abs and norm), unknowns that an equation defines, rows that others
stand for. None knows what a program is about.
"""

import numpy as np
from scipy.sparse import csr_array

from ..contact import Array, Booleans, Integers
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
        place = np.full(len(self.cost), -1)
        place[unknowns] = np.arange(len(unknowns))
        theirs, gone = entries_of(self.matrix, place[self.matrix.indices] >= 0), np.isin(np.arange(len(place)), unknowns)
        at, cost = place[theirs.indices], self.cost[unknowns] / pivots
        share = csr_array((theirs.data * (1 / pivots)[at], at, theirs.indptr), shape=(len(self.right), len(unknowns)))
        matrix = csr_array(self.matrix - share @ rows)
        self.matrix, self.right = entries_of(matrix, (matrix.data != 0) & ~gone[matrix.indices]), self.right - share @ sides
        self.matrix.sort_indices()
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
    n, width, entries = len(program.right), len(program.cost), program.matrix.tocoo()
    head, linear = np.zeros(n, dtype=bool), entries.row < (program.sizes == 1).sum()
    head[program.heads] = True

    def count(which: Array) -> Array:
        return np.bincount(entries.col[which], minlength=width).astype(float)

    up, in_head = entries.data > 0, head[entries.row]
    elsewhere = count(~in_head) + np.bincount(program.equations.indices, minlength=width)
    only = (program.cost == 0) & (count(in_head & up) == 1) & (count(linear & up) == 1) & (elsewhere == 0) & (count(in_head & ~up) > 0)
    only[program.taken] = False
    if not only.any():
        return None
    bounds = up & only[entries.col]
    row, first = np.unique(entries.row[bounds], return_index=True)
    unknowns, chosen = entries.col[bounds][first], np.zeros(width, dtype=bool)
    chosen[unknowns] = True
    alone = np.bincount(entries.row[chosen[entries.col]], minlength=n)[row] == 1
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
    entries, coefficient = matrix.tocoo(), np.zeros(n)
    its, ways = entries.col == unknown, np.random.default_rng(0).normal(size=(matrix.shape[1], 2))
    coefficient[entries.row[its]], ways[unknown] = entries.data[its], 0.0
    mark = matrix @ ways  # equal rows have equal marks, and others never, but for chance
    order = np.lexsort([right, -coefficient, mark[:, 1], mark[:, 0]])
    new = np.r_[True, (np.diff(mark[order], axis=0) != 0).any(axis=1)]
    rank, after = np.unique(right[order], return_inverse=True)[1], (n + 1) * np.cumsum(new)
    least = np.minimum.accumulate(rank - after) + after  # of each group: those of the next are less than all before
    stronger = new | (rank < np.r_[n, least[:-1]])
    return np.setdiff1d(order[~stronger], signed)  # the row that says the sign is needed for all others


def entries_of(matrix: csr_array, chosen: Booleans) -> csr_array:
    """A matrix of chosen ones of its entries alone."""
    return csr_array((matrix.data[chosen], matrix.indices[chosen], np.r_[0, np.cumsum(chosen)][matrix.indptr]), shape=matrix.shape)
