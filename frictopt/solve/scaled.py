"""Scaling of unknowns, rows and cost of a program to sizes near one."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from ..base import NO_COUPLING, ROUNDING, Array, Booleans
from .arrays import Arrays
from .program import ChangesRows, ChangesUnknowns
from .redundant import largest_entries


class ScaledUnknowns(ChangesUnknowns[Arrays]):
    """The unknowns are scaled by their units.

    `unit` holds the units of `[x, block @ x]`; units that are 0 follow from the rows. The first
    `changed` unknowns come from changes of variables. Their units are reduced until no entry of the
    block exceeds 1.
    """

    def __init__(self, program: Arrays, unit: Array, changed: int) -> None:
        width = program.block.shape[1]
        inequalities = slice(program.zero, None)
        sizes = csr_array(np.abs(program.sparse[inequalities]))
        units = _derived(unit, sizes, np.abs(program.right[inequalities]))
        block = program.block * units[:width]
        block /= units[width:, None]
        largest = np.abs(block[:, :changed]).max(axis=0, initial=1.0)
        units[:changed] /= largest
        block[:, :changed] /= largest
        block[np.abs(block).max(axis=1, initial=0.0) <= NO_COUPLING] = 0.0
        self.units = units[:width]

        sparse = program.sparse.copy()
        sparse.data *= units[sparse.indices]
        cost = program.cost * self.units
        self.after = replace(program, sparse=sparse, block=block, cost=cost)

    def values(self, x: Array) -> Array:
        """Values in the units of the user."""
        return x * self.units


def _derived(unit: Array, sizes: csr_array, constant: Array) -> Array:
    """Units of the unknowns; a missing unit is the largest that the rows allow, or 1.

    `sizes` are the sizes of the entries of the rows, `constant` the sizes of their right sides. A
    row allows a term to be as large as the sum of its other terms in their units.
    """
    entries = sizes.tocoo()
    while (unit == 0).any():
        unknown = unit == 0
        allowance = sizes @ unit + constant
        bounding = unknown[entries.col] & (allowance[entries.row] > 0) & (entries.data > 0)
        if not bounding.any():
            break
        allowed = np.full(len(unit), np.inf)
        np.minimum.at(
            allowed,
            entries.col[bounding],
            allowance[entries.row[bounding]] / entries.data[bounding],
        )
        unit = np.where(unknown & np.isfinite(allowed), allowed, unit)
    return np.where(unit == 0, 1.0, unit)


class Felt(ChangesUnknowns[Arrays]):
    """Unknowns that occur neither in rows nor in the cost leave the program with values of zero."""

    def __init__(self, program: Arrays) -> None:
        width = program.block.shape[1]
        in_rows = np.bincount(program.sparse.indices, minlength=width)[:width] > 0
        felt = np.flatnonzero(program.block.any(axis=0) | in_rows | (program.cost != 0))
        self._width = width
        self._felt = felt
        self.after = program
        if len(felt) < width:
            columns = np.r_[felt, width : program.sparse.shape[1]]
            self.after = replace(
                program,
                sparse=csr_array(program.sparse[:, columns]),
                block=program.block[:, felt],
                cost=program.cost[felt],
            )

    def values(self, x: Array) -> Array:
        """All unknowns."""
        values = np.zeros(self._width)
        values[self._felt] = x
        return values


class ShutCones(ChangesRows[Arrays]):
    """Cones whose first slack is zero for all unknowns become equations of their other slacks."""

    def __init__(self, program: Arrays) -> None:
        self._before = program
        self._shut = _shut(program)
        of_cone = np.repeat(np.arange(len(program.sizes)), program.sizes)
        rows = np.arange(program.zero, len(program.right))
        heads = program.heads
        in_shut = self._shut[of_cone]
        self._heads = heads[self._shut]
        self._tails = rows[in_shut & (heads[of_cone] != rows)]
        # The new equations come after the others.
        self._order = np.r_[: program.zero, self._tails, rows[~in_shut]]
        self.after = program
        if len(self._heads):
            self.after = replace(
                program,
                sparse=csr_array(program.sparse[self._order]),
                right=program.right[self._order],
                zero=program.zero + len(self._tails),
                sizes=program.sizes[~self._shut],
            )

    def multipliers(self, y: Array, cost_factor: float) -> Array:
        """The multiplier of a first slack is large enough for its cone."""
        multipliers = np.zeros(len(self._before.right))
        multipliers[self._order] = y
        if len(self._heads):
            lengths = self._before.sizes[self._shut] - 1
            starts = np.cumsum(lengths) - lengths
            squares = np.add.reduceat(multipliers[self._tails] ** 2, starts)
            multipliers[self._heads] = np.sqrt(squares)
        return multipliers


def _shut(program: Arrays) -> Booleans:
    """Which cones have a first slack that is rounding, relative to their other slacks."""
    if program.sizes.max(initial=1) == 1:
        return np.zeros(len(program.sizes), dtype=bool)
    heads = program.heads - program.zero
    of_cone = np.repeat(np.arange(len(program.sizes)), program.sizes)
    columns = np.r_[np.ones(program.block.shape[1]), np.abs(program.block).max(axis=1, initial=0.0)]
    terms = (np.abs(program.sparse) @ columns + np.abs(program.right))[program.zero :]
    after_head = np.r_[terms[1:] * (np.diff(of_cone) == 0), 0.0]
    largest = np.maximum.reduceat(after_head, heads)
    return np.asarray((program.sizes > 1) & (terms[heads] <= ROUNDING * largest))


class ScaledRows(ChangesRows[Arrays]):
    """Rows and cost in units of their largest entries; the rows of one cone have one unit."""

    def __init__(self, program: Arrays) -> None:
        self.cost_unit = float(np.abs(program.cost).max(initial=0.0)) or 1.0
        largest = largest_entries(program.sparse)
        right = np.abs(program.right)
        unit = np.where(largest > 0, largest, np.where(right > 0, right, 1.0))
        if len(program.sizes):
            zero = program.zero
            of_cones = np.maximum.reduceat(unit[zero:], program.heads - zero)
            unit[zero:] = np.repeat(of_cones, program.sizes)
        self._unit = unit
        sparse = program.sparse.copy()
        sparse.data *= np.repeat(1 / unit, np.diff(sparse.indptr))
        cost = program.cost / self.cost_unit
        self.after = replace(program, sparse=sparse, right=program.right / unit, cost=cost)

    def multipliers(self, y: Array, cost_factor: float) -> Array:
        """Multipliers in the units of the user."""
        return y * self.cost_unit / self._unit
