"""Dense equations: they become one block that all rows share.

A dense equation of a square matrix may be changed to unknowns in which it is sparse, see `Change`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array

from ..base import Array
from .arrays import Arrays
from .compiled import Block, Change, Compiled
from .program import ChangesUnknowns, Program


def program_of(compiled: Compiled, units: Mapping[cp.Variable, Any]) -> Program:
    """A compiled program without the rows that replaced its dense equations for cvxpy."""
    first = compiled.sparse_zero
    return Program(
        sparse=csr_array(compiled.matrix[first:]),
        right=compiled.right[first:],
        cost=compiled.cost,
        zero=compiled.zero - first,
        sizes=compiled.sizes,
        unit=compiled.in_order(units),
        blocks=tuple(compiled.blocks),
    )


class Changed(ChangesUnknowns[Program]):
    """A dense equation of a square matrix is changed to the unknowns x of a `Change`.

    The unknowns x are inserted before the unknown number `start`. The left side of the equation is
    then sparse in x, and its other unknowns are defined by a dense equation of x.
    """

    def __init__(self, program: Program, change: Change, start: int) -> None:
        self._before = program
        self._change = change
        (self.square,) = (block for block in program.blocks if block.row is change.row)
        count = change.size
        self.end = start + count
        self._new = np.arange(start, self.end)
        old = np.arange(len(program.cost))
        self._old = np.where(old < start, old, old + count)  # new numbers of the old unknowns
        self.after = self._in_new_unknowns()

    def _in_new_unknowns(self) -> Program:
        """The program in the remaining old unknowns and in x."""
        program, change, square = self._before, self._change, self.square
        n, width = len(program.cost), len(program.cost) + len(self._new)
        stays = np.ones(n, dtype=bool)
        stays[square.defined] = False
        stays = np.flatnonzero(stays)
        values = change.values.tocoo()
        data = np.r_[np.ones(len(stays)), values.data]
        rows = np.r_[stays, square.defined[values.row]]
        columns = np.r_[self._old[stays], self._new[values.col]]
        before = csr_array((data, (rows, columns)), shape=(n, width))  # old z = before @ new z
        unit = np.empty(width)
        unit[self._old] = program.unit
        unit[self._new] = 1.0
        others = [self._moved(block) for block in program.blocks if block is not square]
        # Most programs have no rows about the unknowns of the square equation.
        in_rows = np.isin(square.of, program.sparse.indices) | (program.cost[square.of] != 0)
        chosen = np.flatnonzero(in_rows)
        unknowns = replace(
            square,
            defined=self._old[square.of[chosen]],
            of=self._new,
            matrix=change.rows(chosen),
        )
        return replace(
            program,
            sparse=csr_array(program.sparse @ before),
            cost=before.T @ program.cost,
            unit=unit,
            blocks=(*others, unknowns),
        )

    def _moved(self, block: Block) -> Block:
        """Another dense equation, with x in place of the unknowns of the square equation."""
        change = self._change
        shared, of_block, of_square = np.intersect1d(block.of, self.square.of, return_indices=True)
        defined = self._old[block.defined]
        if not len(shared):
            return replace(block, defined=defined, of=self._old[block.of])
        if block.row in change.by_slides:
            matrix = change.moved(block.matrix, change.by_slides[block.row])
        else:
            of_unknowns = np.zeros((len(block.matrix), len(change.inverse)))
            of_unknowns[:, of_square] = block.matrix[:, of_block]
            matrix = change.moved(of_unknowns, of_unknowns @ change.free)
        apart = np.delete(np.arange(len(block.of)), of_block)
        if len(apart):
            matrix = np.hstack([matrix, block.matrix[:, apart]])
        of = np.r_[self._new, self._old[block.of[apart]]]
        return replace(block, defined=defined, of=of, matrix=matrix)

    def values(self, x: Array) -> Array:
        """Values before the change, without the unknowns of other dense equations."""
        z = x[self._old]
        z[self.square.of] = self._change.unknowns(x[self._new])
        z[self.square.defined] = self._change.values_of(x[self._new])
        return z

    def units(self, unit: Array) -> Array:
        """Units of the unknowns before the change."""
        return unit[self._old]


class Stacked(ChangesUnknowns[Arrays]):
    """Unknowns x, and one dense block for all other unknowns that rows or cost need.

    The rows are then about `[x, block @ x]`.
    """

    def __init__(self, program: Program) -> None:
        needed = program.cost != 0
        needed[program.sparse.indices] = True
        self._needed = needed.copy()  # by rows or cost
        defined = np.zeros(len(needed), dtype=bool)
        for block in program.blocks:
            needed[block.of] |= needed[block.defined].any()
            defined[block.defined] = True
        self.unknowns = np.flatnonzero(needed & ~defined)
        parts = [block.defined[self._needed[block.defined]] for block in program.blocks]
        # The unknowns before the step, in the order of `[x, block @ x]`, and their units.
        self._columns = np.concatenate([self.unknowns, *parts])
        self.unit = program.unit[self._columns]
        self._unit_before = program.unit
        self.after = self._of_needed_unknowns(program)

    def _of_needed_unknowns(self, program: Program) -> Arrays:
        """The program of the needed unknowns."""
        width = len(self.unknowns)
        place = np.full(len(program.cost), -1)
        place[self.unknowns] = np.arange(width)
        parts = [np.zeros((0, width))]
        for equations in program.blocks:
            needed = self._needed[equations.defined]
            part = np.zeros((int(needed.sum()), width))
            columns = place[equations.of]
            part[:, columns[columns >= 0]] = equations.matrix[needed][:, columns >= 0]
            parts.append(part)
        block = np.vstack(parts)
        cost = program.cost[self._columns]
        return Arrays(
            sparse=csr_array(program.sparse[:, self._columns]),
            block=block,
            right=program.right,
            cost=cost[:width] + cost[width:] @ block,
            zero=program.zero,
            sizes=program.sizes,
        )

    def values(self, x: Array) -> Array:
        """All unknowns; unneeded unknowns, and unknowns of dense equations, are zero."""
        z = np.zeros(len(self._unit_before))
        z[self.unknowns] = x
        return z

    def units(self, unit: Array) -> Array:
        """Units of all unknowns, from the units of x."""
        units = self._unit_before.copy()
        units[self.unknowns] = unit
        return units


def dense_multipliers(
    compiled: Compiled,
    changes: Sequence[tuple[Change, Block]],
    y: Array,
    cost: Array,
    sizes: Array,
) -> Array:
    """The multipliers of all compiled rows, from the multipliers of the sparse rows, for this cost.

    The multipliers of a dense equation balance the unknowns that it defines. Rounding of an inverse
    may leave the other unknowns out of balance. The multipliers of the changed equations are then
    corrected, if this reduces the error. `sizes` (n,) are the weights of the balances.
    """
    multipliers = np.r_[np.zeros(compiled.sparse_zero), y]
    off = compiled.matrix.T @ multipliers + cost
    for block in compiled.blocks:
        multipliers[block.rows] = -block.sign * off[block.defined]
    multipliers = compiled.whole(multipliers)
    off = compiled.matrix.T @ multipliers + cost

    corrected = multipliers.copy()
    for change, square in changes:
        loaded = change.loaded
        rows = np.arange(square.rows.start, square.rows.stop)[loaded]
        scale = change.values[loaded].diagonal()
        corrected[rows] += square.sign * change.work(off[square.of]) / scale
    corrected = compiled.whole(corrected)
    still_off = compiled.matrix.T @ corrected + cost
    return corrected if np.abs(still_off) @ sizes < np.abs(off) @ sizes else multipliers
