"""Elimination of unknowns that single rows define: rows of abs and norm, and equations.

cvxpy compiles `abs(q) <= f p` to `q <= t`, `-q <= t` and `t <= f p` with an unknown t of its own.
Only the last row bounds t, and a larger t relaxes the others. So t may be replaced by `f p`.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ..base import Array, Booleans, Integers
from .program import ChangesRows, ChangesUnknowns, Program


class Definitions(NamedTuple):
    """Rows that define one unknown each: `pivots * z[unknowns] + rest of the row @ z = right`."""

    unknowns: Integers
    rows: Integers
    pivots: Array


class Eliminated(ChangesUnknowns[Program], ChangesRows[Program]):
    """Unknowns are replaced by the expressions that single rows define for them.

    The rows are `bounds` of abs and norm, and equations. They leave the program, and the unknowns
    follow: `z = follows @ z + start`. The columns of these unknowns remain, but are empty. `rows`
    are the remaining rows.
    """

    def __init__(self, program: Program, by_equations: bool) -> None:
        self.before = program
        self.bounds = bounds_of_norms(program)
        self._rounds = [self.bounds]
        if by_equations:
            self._rounds += _rounds_of_equations(program)
        defining = np.concatenate([definitions.rows for definitions in self._rounds])
        self.rows = np.delete(np.arange(len(program.right)), defining)
        self._remaining = np.ones(len(program.cost), dtype=bool)
        for definitions in self._rounds:
            self._remaining[definitions.unknowns] = False
        self._follows, self._start = _substitution(program, self._rounds, self._remaining)
        self.after = self._of_remaining_rows()

    def _of_remaining_rows(self) -> Program:
        """The program of the remaining rows."""
        program = self.before
        rows = program.sparse[self.rows]
        sparse = csr_array(rows @ self._follows)
        sparse.eliminate_zeros()
        sparse.sort_indices()
        bounds = len(self.bounds.rows)  # linear rows come before the cones
        return replace(
            program,
            sparse=sparse,
            right=program.right[self.rows] - rows @ self._start,
            cost=program.cost @ self._follows,
            zero=int((self.rows < program.zero).sum()),
            sizes=program.sizes[bounds:],
        )

    def values(self, x: Array) -> Array:
        """All unknowns, from the remaining ones."""
        return np.asarray(self._follows @ x + self._start)

    def direction(self, x: Array, sizes: Array) -> tuple[Array, Array]:
        """A direction in all unknowns and the sizes of its terms, from a direction in x."""
        return self._follows @ x, np.abs(self._follows) @ sizes

    def units(self, unit: Array) -> Array:
        """Units of all unknowns, from the units of the remaining unknowns."""
        derived = np.abs(self._follows) @ unit + np.abs(self._start)
        return np.where(self._remaining | (self.before.unit > 0), unit, derived)

    def multipliers(self, y: Array, cost_factor: float) -> Array:
        """All multipliers.

        The multipliers of the defining rows follow from the balance of the unknowns that these rows
        define.
        """
        program = self.before
        multipliers = np.zeros(len(program.right))
        multipliers[self.rows] = y
        cost = cost_factor * program.cost
        for unknowns, rows, pivots in self._rounds:
            multipliers[rows] = -(program.sparse.T @ multipliers + cost)[unknowns] / pivots
        return multipliers


def _substitution(
    program: Program, rounds: list[Definitions], remaining: Booleans
) -> tuple[csr_array, Array]:
    """The matrix `follows` (n, n) and the vector `start` (n,) with `z = follows @ z + start`.

    The rows of a round may contain unknowns of later rounds, but none of earlier rounds. So the
    last round is substituted first.
    """
    n = len(program.cost)
    places = np.flatnonzero(remaining)
    follows = csr_array((np.ones(len(places)), (places, places)), shape=(n, n))
    start = np.zeros(n)
    for unknowns, names, pivots in reversed(rounds):
        rows = program.sparse[names]
        over_pivots = csr_array(
            (-1 / pivots, (unknowns, np.arange(len(names)))), shape=(n, len(names))
        )
        follows = csr_array(follows + over_pivots @ (rows @ follows))
        start[unknowns] = (program.right[names] - rows @ start) / pivots
    return follows, start


def bounds_of_norms(program: Program) -> Definitions:
    """Unknowns `t <= b - a @ z` that one linear row bounds and that relax all other rows.

    The unknowns that cvxpy adds for abs and norm are of this kind. At most one unknown is taken for
    each row.
    """
    entries = program.sparse.tocoo()
    width = len(program.cost)
    count_rows = len(program.right)
    is_head = np.zeros(count_rows, dtype=bool)
    is_head[program.heads] = True
    in_head = is_head[entries.row]
    in_linear = entries.row < program.linear
    positive = entries.data > 0
    bounding = positive & in_head

    def count(which: Booleans) -> Integers:
        """The number of these entries in the column of each unknown."""
        return np.bincount(entries.col[which], minlength=width)

    free = (program.cost == 0) & ~program.in_blocks
    bounded_once = (count(bounding) == 1) & (count(bounding & in_linear) == 1)
    relaxes = (count(~in_head) == 0) & (count(in_head & ~positive) > 0)
    fits = bounding & (free & bounded_once & relaxes)[entries.col]

    rows, first = np.unique(entries.row[fits], return_index=True)
    unknowns = entries.col[fits][first]
    pivots = entries.data[fits][first]
    chosen = np.zeros(width, dtype=bool)
    chosen[unknowns] = True
    chosen_in_row = np.bincount(entries.row[chosen[entries.col]], minlength=count_rows)
    alone = chosen_in_row[rows] == 1
    return Definitions(unknowns[alone], rows[alone], pivots[alone])


def _rounds_of_equations(program: Program) -> Iterator[Definitions]:
    """Definitions by equations, round after round, as long as equations define unknowns."""
    equations = np.arange(program.zero)
    definitions = defined_unknowns(program, equations)
    while len(definitions.rows):
        yield definitions
        equations = equations[~np.isin(equations, definitions.rows)]
        definitions = defined_unknowns(program, equations)


def defined_unknowns(program: Program, equations: Integers) -> Definitions:
    """Unknowns that occur in only one of these equations, one unknown from each equation.

    It is the unknown with the largest coefficient times unit in the equation. The
    coefficient itself, or its product with the unit, must be well above rounding.
    """
    entries = csr_array(program.sparse[equations]).tocoo()
    unit = np.where(program.unit > 0, program.unit, 1.0)
    in_one_equation = np.bincount(entries.col, minlength=len(unit)) == 1
    fits = (in_one_equation & ~program.in_blocks)[entries.col]
    plain = np.abs(entries.data)
    weighed = plain * unit[entries.col]
    fits &= _is_large(plain, entries.row) | _is_large(weighed, entries.row)

    row = entries.row[fits]
    column = entries.col[fits]
    pivot = entries.data[fits]
    order = np.lexsort([column, -weighed[fits], row])
    rows, first = np.unique(row[order], return_index=True)
    best = order[first]
    return Definitions(column[best].astype(int), equations[rows], pivot[best])


def _is_large(size: Array, row: Integers) -> Booleans:
    """Which entries are above rounding, relative to the largest entry of their row."""
    largest = np.zeros(row.max(initial=-1) + 1)
    np.maximum.at(largest, row, size)
    # An equation defines an unknown only if its coefficient is at least this share of the largest
    # one in the equation. Rounding is far below.
    least_pivot = 1e-6
    return np.asarray(size > least_pivot * largest[row])
