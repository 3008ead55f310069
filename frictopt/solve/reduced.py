"""What makes a compiled program small and well scaled, step by step, and the way back for its answer. None of it knows what a program is about.

1. Unknowns of cvxpy's own, the bounds of abs and norm, and unknowns that an equation defines: they
   follow from the others, see `Step`.
2. Dense equations: put in as one block that all rows share, or changed to the unknowns in which a
   square one is sparse, see `Change`.
3. Rows that others stand for, see `implied`, `dominated` and `headed`, and cones that are shut,
   which are equations.
4. Units of unknowns, rows and cost.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array, vstack

from ..base import NO_COUPLING, ROUNDING, Array, Booleans, Integers
from .arrays import Arrays
from .compiled import Change, Compiled
from .implied import implied
from .redundant import dominated, headed, independent

# an equation defines an unknown only if its part is at least this share of the largest one:
# rounding is far below
_PIVOT = 1e-6


class Step(NamedTuple):
    """Unknowns that rows of the compiled program define, one each: `pivots * z[unknowns] + the rest of the row @ z = right`."""

    unknowns: Integers
    names: Integers
    pivots: Array


class Reduced:
    """A compiled program in as few and as well-scaled unknowns and rows as it has, and the way back for its answer.

    Its unknowns x are those of the changes of variables, and those that are left of z, whose units
    are `z_unit`. Others stand for `left_out` rows.
    """

    def __init__(
        self,
        compiled: Compiled,
        units: Mapping[cp.Variable, Any],
        changes: Sequence[Change] = (),
        simplify: bool = True,
        defines: bool = True,
    ) -> None:
        self.compiled, n, zero = compiled, len(compiled.cost), compiled.zero
        unit, taken = np.zeros(n), np.zeros(n, dtype=bool)  # 0 where none is known
        for variable, size in units.items():
            if variable.id in compiled.columns:
                unit[compiled.place(variable)] = np.ravel(
                    np.broadcast_to(size, variable.shape), order="F"
                )
        for block in compiled.blocks:
            taken[block.defined], taken[block.of] = True, True
        equations, own = np.arange(compiled.sparse_zero, zero), own_unknowns(compiled, taken)
        self._steps = [own] if own else []
        while defines and (
            step := defined_unknowns(compiled, equations, taken, np.where(unit > 0, unit, 1.0))
        ):
            self._steps.append(step)
            equations = np.setdiff1d(equations, step.names)
        self._follow()
        inner = (
            np.arange(zero, len(compiled.right))
            if own is None
            else np.setdiff1d(np.arange(zero, len(compiled.right)), own.names)
        )
        idle = implied(compiled, *own) if own and simplify else inner[:0]
        inner = np.setdiff1d(inner, idle)
        self._names, soc = np.r_[equations, inner], np.array(compiled.soc, dtype=int)
        sizes = np.r_[np.ones(len(inner) - soc.sum(), dtype=int), soc]
        rows = compiled.matrix[self._names]
        matrix, right, cost = (
            csr_array(rows @ self._follows),
            compiled.right[self._names] - rows @ self._start,
            compiled.cost @ self._follows,
        )
        matrix.eliminate_zeros()
        matrix.sort_indices()
        zero, linear = len(equations), len(equations) + int((sizes == 1).sum())
        keep = np.ones(len(right), dtype=bool)
        if simplify:
            keep[zero + dominated(csr_array(matrix[zero:linear]), right[zero:linear])] = False
            keep[zero + headed(csr_array(matrix[zero:]), right[zero:], sizes)] = False
        keep[zero:linear] &= (np.diff(matrix.indptr)[zero:linear] > 0) | (right[zero:linear] < 0)
        self.left_out = int((~keep).sum()) + len(idle)
        self._dense(matrix, cost, changes)
        self._names, matrix, right, sizes = (
            self._names[keep],
            csr_array(matrix[keep] @ self._of_x),
            right[keep],
            sizes[int((~keep).sum()) :],
        )
        self._scale(matrix, right, self._of_x.T @ cost, zero, sizes, unit)

    def _follow(self) -> None:
        """The unknowns of the steps from the others: `z = follows @ z + start`."""
        matrix, right, n = self.compiled.matrix, self.compiled.right, len(self.compiled.cost)
        self._others, self._start = np.ones(n, dtype=bool), np.zeros(n)
        for step in self._steps:
            self._others[step.unknowns] = False
        at = np.flatnonzero(self._others)
        self._follows = csr_array((np.ones(len(at)), (at, at)), shape=(n, n))
        for unknowns, names, pivots in reversed(
            self._steps
        ):  # those of a later one stand in the rows of an earlier one, never the other way round
            rows, share = (
                matrix[names],
                csr_array((-1 / pivots, (unknowns, np.arange(len(names)))), shape=(n, len(names))),
            )
            self._follows = csr_array(self._follows + share @ (rows @ self._follows))
            self._start[unknowns] = (right[names] - rows @ self._start) / pivots

    def _dense(self, rows: csr_array, cost: Array, changes: Sequence[Change]) -> None:
        """The unknowns x, the dense block, and `z = of_x @ [x, block @ x]` of the unknowns that stand in rows or cost."""
        blocks, n = self.compiled.blocks, len(cost)
        direct, own = cost != 0, self._others.copy()
        direct[rows.indices] = True
        used, squares = direct.copy(), {change.row: change for change in changes}
        self._changes = [(squares[block.row], block) for block in blocks if block.row in squares]
        plain = [block for block in blocks if block.row not in squares]
        for block in plain:
            used[block.of] |= used[block.defined].any()
        for block in blocks:
            own[block.defined] = False
            own[block.of] &= block.row not in squares
        self._kept, ends = (
            np.flatnonzero(used & own),
            np.cumsum([0, *(change.matrix.shape[1] for change, _ in self._changes)]),
        )
        self._spans, m = [slice(*ends[k : k + 2]) for k in range(len(self._changes))], int(ends[-1])
        width, where = m + len(self._kept), np.full(n, -1)
        where[self._kept] = np.arange(m, width)
        places, parts = (
            [self._kept],
            [
                csr_array(
                    (np.ones(width - m), (np.arange(width - m), where[self._kept])),
                    shape=(width - m, width),
                )
            ],
        )
        named = list[tuple[Integers, Array]]()
        for block in plain:
            which, at = np.flatnonzero(used[block.defined]), where[block.of]
            matrix = np.zeros((len(which), width))
            matrix[:, at[at >= 0]] = block.matrix[which][:, at >= 0]
            for (change, square), span in zip(self._changes, self._spans, strict=True):
                if block.row in change.blocks:
                    matrix[:, span] = change.blocks[block.row][which]
                else:
                    _, at, by = np.intersect1d(block.of, square.of, return_indices=True)
                    matrix[:, span] = block.matrix[np.ix_(which, at)] @ change.matrix[by]
            named.append((block.defined[which], matrix))
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            places.append(square.defined)
            parts.append(
                csr_array(
                    (
                        change.product.data,
                        change.product.indices + span.start,
                        change.product.indptr,
                    ),
                    shape=(len(places[-1]), width),
                )
            )
            which = np.flatnonzero(direct[square.of])
            matrix = np.zeros((len(which), width))
            matrix[:, span] = change.matrix[which]
            named.append((square.of[which], matrix))
        self._block = np.vstack([np.zeros((0, width)), *(matrix for _, matrix in named)])
        sparse, count = vstack(parts).tocoo(), len(self._block)
        row, column = (
            np.concatenate([np.concatenate(places)[sparse.row], *(at for at, _ in named)]),
            np.r_[sparse.col, width : width + count],
        )
        self._of_x = csr_array(
            (np.r_[sparse.data, np.ones(count)], (row, column)), shape=(n, width + count)
        )

    def _scale(
        self, sparse: csr_array, right: Array, cost: Array, zero: int, sizes: Integers, unit: Array
    ) -> None:
        """Units of unknowns and rows, and the arrays in them, without the unknowns that no row feels."""
        of_x, (count, width) = self._of_x, self._block.shape
        m, inner = width - len(self._kept), of_x.indices >= width
        block_unit = np.zeros(count)
        block_unit[of_x.indices[inner] - width] = np.repeat(unit, np.diff(of_x.indptr))[inner]
        own = np.concatenate(
            [*(change.unit for change, _ in self._changes), unit[self._kept], block_unit]
        )
        units = _derived(own, csr_array(np.abs(sparse[zero:])), np.abs(right[zero:]))
        block = self._block * units[:width] / units[width:, None]
        largest = np.abs(block[:, :m]).max(axis=0, initial=1.0)
        units[:m] /= largest
        block[:, :m] /= largest
        block[np.abs(block).max(axis=1, initial=0.0) <= NO_COUPLING] = 0.0
        sparse.data *= units[sparse.indices]
        cost = (cost[:width] + cost[width:] @ self._block) * units[:width]
        self._felt = np.flatnonzero(
            block.any(axis=0)
            | (np.bincount(sparse.indices, minlength=width)[:width] > 0)
            | (cost != 0)
        )
        if len(self._felt) < width:
            sparse, block, cost = (
                csr_array(sparse[:, np.r_[self._felt, width : width + count]]),
                block[:, self._felt],
                cost[self._felt],
            )
        self.cost_unit = float(np.abs(cost).max(initial=0.0)) or 1.0
        cost = cost / self.cost_unit
        self._x_unit, known = units[:width], unit.copy()
        known[self._kept] = units[m:width]
        self.z_unit = np.where(
            self._others | (unit > 0), known, np.abs(self._follows) @ known + np.abs(self._start)
        )
        order, zero, sizes = self._open(sparse, block, right, zero, sizes)
        sparse, right, self._names = csr_array(sparse[order]), right[order], self._names[order]
        largest = np.maximum.reduceat(np.r_[np.abs(sparse.data), 0.0], sparse.indptr[:-1]) * (
            np.diff(sparse.indptr) > 0
        )
        size = np.where(largest > 0, largest, np.where(right != 0, np.abs(right), 1.0))
        if len(sizes):
            size[zero:] = np.repeat(
                np.maximum.reduceat(size[zero:], np.cumsum(sizes) - sizes), sizes
            )
        sparse.data *= np.repeat(1 / size, np.diff(sparse.indptr))
        self.arrays, self._row_unit = Arrays(sparse, block, right / size, cost, zero, sizes), size
        if zero and len(chosen := independent(self.arrays)) < zero:
            rows = np.r_[chosen, zero : len(right)]
            self._names, self._row_unit = self._names[rows], size[rows]
            self.arrays = Arrays(
                csr_array(sparse[rows]), block, self.arrays.right[rows], cost, len(chosen), sizes
            )

    def _open(
        self, sparse: csr_array, block: Array, right: Array, zero: int, sizes: Integers
    ) -> tuple[Integers, int, Integers]:
        """The order of rows in which those of cones whose first slack is zero, whatever the unknowns, are equations; their count, and sizes left."""
        heads, of, every = (
            np.cumsum(sizes) - sizes,
            np.repeat(np.arange(len(sizes)), sizes),
            np.arange(zero, len(right)),
        )
        self._apexes = self._names[:0], self._names[:0], heads[:0]
        if sizes.max(initial=1) == 1:
            return np.arange(len(right)), zero, sizes
        terms = (
            np.abs(sparse) @ np.r_[np.ones(block.shape[1]), np.abs(block).max(axis=1, initial=0.0)]
            + np.abs(right)
        )[zero:]
        shut = (sizes > 1) & (
            terms[heads]
            <= ROUNDING * np.maximum.reduceat(np.r_[terms[1:] * (np.diff(of) == 0), 0.0], heads)
        )
        tails = every[shut[of] & (heads[of] != every - zero)]
        self._apexes = (
            self._names[zero + heads[shut]],
            self._names[tails],
            np.cumsum(sizes[shut] - 1) - (sizes[shut] - 1),
        )
        return np.r_[:zero, tails, every[~shut[of]]], zero + len(tails), sizes[~shut]

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The unknowns and the multipliers of the compiled program, from those of this one."""
        compiled, (every, z) = self.compiled, self._own(x)
        squares = {square.row for _, square in self._changes}
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            z[square.of], z[square.defined] = (
                change.matrix @ every[span],
                change.product @ every[span],
            )
        for block in compiled.blocks:
            if block.row not in squares:
                z[block.defined] = block.matrix @ z[block.of]
        z = self._follows @ z + self._start
        return z, self.multipliers(y, compiled.cost, np.maximum(np.abs(z), self.z_unit))

    def _own(self, x: Array) -> tuple[Array, Array]:
        """All unknowns x in the user's units, and those of the compiled program that are among them."""
        every, z = np.zeros(self._block.shape[1]), np.zeros(len(self.compiled.cost))
        every[self._felt] = x * self._x_unit[self._felt]
        z[self._kept] = every[len(every) - len(self._kept) :]
        return every, z

    def direction(self, x: Array) -> tuple[Array, Array]:
        """A direction of the compiled program from one of this program, and for each of its values the size of the terms that it is the sum of.

        Values that dense equations define are computed by these equations, as in the user's
        problem, and not by the changes of variables.
        """
        every, z = self._own(x)
        for (change, square), span in zip(self._changes, self._spans, strict=True):
            z[square.of] = change.matrix @ every[span]
        sizes = np.abs(z)
        for block in self.compiled.blocks:
            z[block.defined], sizes[block.defined] = (
                block.matrix @ z[block.of],
                np.abs(block.matrix) @ np.abs(z[block.of]),
            )
        return self._follows @ z, np.abs(self._follows) @ sizes

    def multipliers(self, y: Array, cost: Array, sizes: Array) -> Array:
        """The multipliers of the compiled program with a cost, its own or none; `sizes` weigh by how much they do not balance."""
        compiled, multipliers, (heads, tails, starts) = (
            self.compiled,
            np.zeros(len(self.compiled.right)),
            self._apexes,
        )
        multipliers[self._names] = y * self.cost_unit / self._row_unit
        if len(heads):
            multipliers[heads] = np.sqrt(np.add.reduceat(multipliers[tails] ** 2, starts))
        for unknowns, names, pivots in self._steps:
            multipliers[names] = -(compiled.matrix.T @ multipliers + cost)[unknowns] / pivots
        off = compiled.matrix.T @ multipliers + cost
        for block in compiled.blocks:
            multipliers[block.rows] = -block.sign * off[block.defined]
        off, mended = compiled.matrix.T @ compiled.whole(multipliers) + cost, multipliers.copy()
        for (
            change,
            square,
        ) in self._changes:  # the rounding of the inverse, which soft unknowns make large
            at, count = (
                np.arange(square.rows.start, square.rows.stop)[change.loaded],
                len(change.loaded),
            )
            mended[at] += (
                square.sign
                * (off[square.of] @ change.matrix[:, :count])
                / change.product[change.loaded][:, :count].diagonal()
            )
        left = compiled.matrix.T @ compiled.whole(mended) + cost
        return mended if np.abs(left) @ sizes < np.abs(off) @ sizes else multipliers


def own_unknowns(program: Compiled, taken: Booleans) -> Step | None:
    """Unknowns `t <= b - a @ z` that one row bounds and that only help in all others: those of abs and norm, one a row."""
    entries, width = csr_array(program.matrix[program.sparse_zero :]).tocoo(), len(program.cost)
    row, soc = entries.row + program.sparse_zero, np.array(program.soc, dtype=int)
    linear, head = (
        np.arange(len(program.right)) < program.zero + program.nonneg,
        np.zeros(len(program.right), dtype=bool),
    )
    head[program.zero : program.zero + program.nonneg] = True
    head[program.zero + program.nonneg + np.cumsum(soc) - soc] = True
    up, in_head = entries.data > 0, head[row]

    def count(which: Booleans) -> Integers:
        return np.bincount(entries.col[which], minlength=width)

    bounds = up & in_head
    only = (program.cost == 0) & ~taken & (count(bounds) == 1) & (count(bounds & linear[row]) == 1)
    only &= (count(~in_head) == 0) & (count(in_head & ~up) > 0)
    at = bounds & only[entries.col]
    names, first = np.unique(row[at], return_index=True)
    unknowns, chosen = entries.col[at][first], np.zeros(width, dtype=bool)
    chosen[unknowns] = True
    alone = np.bincount(row[chosen[entries.col]], minlength=len(head))[names] == 1
    return (
        Step(unknowns[alone], names[alone], entries.data[at][first][alone]) if alone.any() else None
    )


def defined_unknowns(
    program: Compiled, equations: Integers, taken: Booleans, unit: Array
) -> Step | None:
    """Unknowns that stand in one equation alone, one an equation: the one of the largest part in it, and none whose part may be rounding."""
    entries = csr_array(program.matrix[equations]).tocoo()
    alone = ((np.bincount(entries.col, minlength=len(unit)) == 1) & ~taken)[entries.col]
    certain = np.zeros(len(alone), dtype=bool)
    for size in (
        np.abs(entries.data),
        np.abs(entries.data) * unit[entries.col],
    ):  # rounding is small in both
        largest = np.zeros(len(equations))
        np.maximum.at(largest, entries.row, size)
        certain |= size > _PIVOT * largest[entries.row]
    alone &= certain
    row, column, data = entries.row[alone], entries.col[alone], entries.data[alone]
    order = np.lexsort([column, -np.abs(data) * unit[column], row])
    row, first = np.unique(row[order], return_index=True)
    return (
        Step(column[order][first].astype(int), equations[row], data[order][first])
        if len(row)
        else None
    )


def _derived(unit: Array, size: csr_array, constant: Array) -> Array:
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
