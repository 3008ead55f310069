"""A compiled program in few and well-scaled unknowns: its dense equations put in, maybe by the inverse of a square one, and the way back."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array, vstack

from ..contact import NO_COUPLING, Array, Integers
from .arrays import Arrays, independent, largest_of, shut_cones
from .compiled import Block, Compiled
from .reductions import Rows, defined_unknowns, dominated, own_unknowns


@dataclass(frozen=True, eq=False)
class Change:
    """A change of variables of a dense equation `row`, `z[defined] = square @ z[of]`: `z[of] = matrix @ x`, and `z[defined] = product @ x`, sparse.

    `blocks` are what other dense equations of the same unknowns are of x; `unit` (n,) is the unit of x. The first of x are the values `loaded` of the
    left side, in their units, and the rest is what no value resists.
    """

    row: cp.Constraint
    matrix: Array
    product: csr_array
    blocks: Mapping[cp.Constraint, Array]
    unit: Array
    loaded: Integers

    @property
    def values(self) -> int:
        """How many of x are values of the left side."""
        return len(self.loaded)


class Reduced:
    """A compiled program in as few and as well-scaled unknowns and rows as it has, and the way back for its answer.

    Its unknowns are x: those of the change of variables, and those that are left of z.

    Parameters
    ----------
    compiled
        The program.
    units
        Units of its variables, one or one for each entry; those of others follow from the rows in which they stand.
    changes
        Changes of variables, one for each of some dense equations.
    simplify
        Whether to leave out rows that others stand for.

    Attributes
    ----------
    arrays
        The reduced program.
    left_out
        How many rows others stand for.
    """

    def __init__(self, compiled: Compiled, units: Mapping[cp.Variable, Any], changes: Sequence[Change] = (), simplify: bool = True) -> None:
        self.compiled = compiled
        self.unit = np.zeros(len(compiled.cost))  # of z; 0 where it is not known
        for variable, unit in units.items():
            if compiled.has(variable):
                self.unit[compiled.place(variable)] = np.ravel(np.broadcast_to(unit, variable.shape), order="F")
        program = Rows(compiled)
        self._steps = [step] if (step := own_unknowns(program)) else []
        while step := defined_unknowns(program, np.where(self.unit > 0, self.unit, 1.0)):
            self._steps.append(step)
        self._on_blocks(program, changes)
        left_out = dominated(program) if simplify else np.zeros(0, dtype=int)
        empty = np.flatnonzero((np.diff(program.matrix.indptr) == 0) & (program.right >= 0))
        self._scaled(program, np.union1d(left_out, empty))

    def _on_blocks(self, program: Rows, changes: Sequence[Change]) -> None:
        """The unknowns x and the dense block, and what z is of them."""
        compiled, n = self.compiled, len(self.compiled.cost)
        direct = np.zeros(n, dtype=bool)
        direct[program.matrix.indices], direct[program.equations.indices], direct[program.cost != 0] = True, True, True
        squares = {change.row: next(block for block in compiled.blocks if block.row is change.row) for change in changes}
        dense, used, gone = [block for block in compiled.blocks if block.row not in squares], direct.copy(), np.zeros(n, dtype=bool)
        for step in self._steps:
            gone[step.unknowns] = True
        for block in compiled.blocks:
            gone[block.defined] = True
        for block in dense:
            used[block.of] |= used[block.defined].any()
        for square in squares.values():
            gone[square.of] = True
        self._changes = [self._felt(change, squares[change.row], direct, used, dense) for change in changes]
        self.kept = np.flatnonzero(used & ~gone)
        ends = np.cumsum([0, *(change.matrix.shape[1] for change, _ in self._changes)])
        m, where = int(ends[-1]), np.full(n, -1)
        self._spans, self.changed, count = [slice(a, b) for a, b in pairwise(ends)], m, m + len(self.kept)
        width, where[self.kept] = count, m + np.arange(len(self.kept))
        parts, rows, columns, data = list[Array](), [self.kept], [where[self.kept]], [np.ones(len(self.kept))]
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            of = change.product.tocoo()
            rows, columns, data = [*rows, square.defined[of.row]], [*columns, span.start + of.col], [*data, of.data]
        named = [
            (block.defined[which], self._on_x(block, which, width, where)) for block in dense if len(which := np.flatnonzero(used[block.defined]))
        ]
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            own = np.flatnonzero(direct[square.of])
            matrix = np.zeros((len(own), width))
            matrix[:, span] = change.matrix[own]
            named.append((square.of[own], matrix))
        for defined, matrix in named:
            parts.append(matrix)
            rows, columns, data = [*rows, defined], [*columns, count + np.arange(len(matrix))], [*data, np.ones(len(matrix))]
            count += len(matrix)
        self.block = np.vstack([np.zeros((0, width)), *parts])
        self._of_x = csr_array((np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))), shape=(n, count))

    def _on_x(self, block: Block, which: Integers, width: int, where: Integers) -> Array:
        """Rows of a dense block on x."""
        matrix, kept = np.zeros((len(which), width)), where[block.of] >= 0
        matrix[:, where[block.of[kept]]] = block.matrix[which][:, kept]
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            matrix[:, span] = _moved(block, which, change, square)
        return matrix

    def _felt(self, change: Change, square: Block, direct: Array, used: Array, dense: Sequence[Block]) -> tuple[Change, Block]:
        """A change without the unknowns that no row feels, with its equation."""
        felt = np.abs(change.product[np.flatnonzero(direct[square.defined])]).sum(axis=0) + np.abs(change.matrix[direct[square.of]]).sum(axis=0)
        felt = felt + sum(np.abs(_moved(block, np.flatnonzero(used[block.defined]), change, square)).sum(axis=0) for block in dense)
        keep = np.flatnonzero(np.ravel(felt))
        if len(keep) == len(felt):
            return change, square
        blocks, loaded = {row: matrix[:, keep] for row, matrix in change.blocks.items()}, change.loaded[keep[keep < change.values]]
        matrix, product = change.matrix[:, keep], csr_array(change.product[:, keep])
        return replace(change, matrix=matrix, product=product, blocks=blocks, unit=change.unit[keep], loaded=loaded), square

    def _scaled(self, program: Rows, left_out: Integers) -> None:
        """Units of unknowns and rows, and the arrays in them."""
        of_x, m, width, linear = self._of_x, self.changed, self.block.shape[1], int((program.sizes == 1).sum())
        keep = np.ones(len(program.right), dtype=bool)
        keep[left_out[left_out < linear]] = False
        self._names, self._named, self.left_out = program.names[keep], program.named, int((~keep).sum())
        sizes = np.r_[np.ones(int(keep[:linear].sum()), dtype=int), program.sizes[program.sizes > 1]]
        sparse, equations, right = csr_array(program.matrix[keep] @ of_x), csr_array(program.equations @ of_x), program.right[keep]
        block_unit, inner = np.zeros(len(self.block)), of_x.indices >= width
        block_unit[of_x.indices[inner] - width] = self.unit[np.repeat(np.arange(of_x.shape[0]), np.diff(of_x.indptr))[inner]]
        own = [change.unit for change, _ in self._changes]
        unit = self._derived(np.concatenate([*own, self.unit[self.kept], block_unit]), csr_array(np.abs(sparse)), np.abs(right))
        self.x_unit, block_unit = unit[:width].copy(), unit[width:]
        block = self.block * self.x_unit / block_unit[:, None]
        largest = np.abs(block[:, :m]).max(axis=0, initial=1.0)
        self.x_unit[:m] /= largest
        block[:, :m] /= largest
        units = np.r_[self.x_unit, block_unit]
        block[np.abs(block).max(axis=1, initial=0.0) <= NO_COUPLING] = 0.0
        sides = program.sides
        for matrix in (sparse, equations):
            matrix.data *= units[matrix.indices]
        heads, tails, left = shut_cones(Arrays(sparse, block, right, np.zeros(width), 0, sizes))
        self._apexes = self._names[heads], self._names[tails]
        if len(heads):
            equations, sides = csr_array(vstack([equations, sparse[tails.ravel()]])), np.r_[sides, right[tails.ravel()]]
            self._named, self._names = np.r_[self._named, self._names[tails.ravel()]], self._names[left]
            sizes, sparse, right = sizes[np.isin(np.cumsum(sizes) - sizes, left)], csr_array(sparse[left]), right[left]
        row_unit = largest_of(sparse, right)
        if len(sizes):
            row_unit = np.repeat(np.maximum.reduceat(row_unit, np.cumsum(sizes) - sizes), sizes)
        equation_unit = largest_of(equations, sides)
        for matrix, unit in ((equations, equation_unit), (sparse, row_unit)):
            matrix.data *= np.repeat(1 / unit, np.diff(matrix.indptr))
        sides = sides / equation_unit
        chosen = independent(Arrays(equations, block, sides, np.zeros(width), len(sides), sizes[:0]))
        self._named, cost = self._named[chosen], np.asarray(of_x.T @ program.cost)
        cost = cost[:width] + cost[width:] @ self.block
        self.row_unit = np.r_[equation_unit[chosen], row_unit]
        rows = csr_array(vstack([equations[chosen], sparse]))
        self.arrays = Arrays(rows, block, np.r_[sides[chosen], right / row_unit], cost * self.x_unit, len(chosen), sizes)
        self.z_unit = self.unit.copy()
        self.z_unit[self.kept] = self.x_unit[m:]
        for step in reversed(self._steps):
            step.unit(self.z_unit)

    def _derived(self, unit: Array, size: csr_array, constant: Array) -> Array:
        """Units of the unknowns, those not known from what the rows in which they stand allow them."""
        entries = size.tocoo()
        while (unknown := unit == 0).any():
            known = size @ unit + constant
            mine = unknown[entries.col] & (known[entries.row] > 0) & (entries.data > 0)
            if not mine.any():
                break
            allowed = np.full(len(unit), np.inf)
            np.minimum.at(allowed, entries.col[mine], known[entries.row[mine]] / entries.data[mine])
            unit = np.where(unknown & np.isfinite(allowed), allowed, unit)
        return np.where(unit == 0, 1.0, unit)

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The unknowns and the multipliers of the compiled program, from those of this one."""
        compiled, x = self.compiled, x * self.x_unit
        z = np.zeros(len(compiled.cost))
        z[self.kept] = x[self.changed :]
        squares = {square.row for _, square in self._changes}
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            z[square.of], z[square.defined] = change.matrix @ x[span], change.product @ x[span]
        for block in compiled.blocks:
            if block.row not in squares:
                z[block.defined] = block.matrix @ z[block.of]
        for step in reversed(self._steps):
            step.value(z)
        return z, self.multipliers(y, compiled.cost, np.maximum(np.abs(z), self.z_unit))

    def multipliers(self, y: Array, cost: Array, sizes: Array) -> Array:
        """The multipliers of the compiled program with a cost, its own or none; `sizes` weigh by how much they do not balance."""
        compiled, y, multipliers = self.compiled, y / self.row_unit, np.zeros(len(self.compiled.right))
        multipliers[self._named], multipliers[self._names] = y[: self.arrays.zero], y[self.arrays.zero :]
        heads, tails = self._apexes
        multipliers[heads] = np.linalg.norm(multipliers[tails], axis=1)
        for step in self._steps:
            step.multiplier(multipliers, compiled.matrix, cost)
        off = compiled.matrix.T @ multipliers + cost
        for block in compiled.blocks:
            multipliers[block.rows] = -block.sign * off[block.defined]
        off, mended = compiled.matrix.T @ compiled.whole(multipliers) + cost, multipliers.copy()
        for change, square in self._changes:  # the rounding of the inverse, which soft unknowns make large
            at, count = np.arange(square.rows.start, square.rows.stop)[change.loaded], change.values
            mended[at] += square.sign * (off[square.of] @ change.matrix[:, :count]) / change.product[change.loaded][:, :count].diagonal()
        left = compiled.matrix.T @ compiled.whole(mended) + cost
        return mended if np.abs(left) @ sizes < np.abs(off) @ sizes else multipliers


def _moved(block: Block, which: Integers, change: Change, square: Block) -> Array:
    """Rows of a dense block on the unknowns of a change of variables."""
    if block.row in change.blocks:
        return change.blocks[block.row][which]
    _, at, by = np.intersect1d(block.of, square.of, return_indices=True)
    return np.asarray(block.matrix[np.ix_(which, at)] @ change.matrix[by])
