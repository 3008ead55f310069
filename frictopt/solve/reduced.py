"""The reduction of a compiled program, step by step, and the way back for its answer.

Each step makes the program smaller or better scaled, and maps the answer back, see `Step`. No step
depends on the meaning of the program.

1. Unknowns that single rows define are eliminated (`eliminated.py`).
2. Redundant rows are left out (`redundant.py`).
3. Dense equations become one block that all rows share, square ones in unknowns in which their
   values are sparse (`dense.py`).
4. Unknowns, rows and cost are scaled, and cones without room become equations (`scaled.py`).
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import cvxpy as cp
import numpy as np

from ..base import Array
from .arrays import Arrays
from .compiled import Change, Compiled
from .dense import Changed, Stacked, dense_multipliers, program_of
from .eliminated import Eliminated
from .program import ChangesRows, ChangesUnknowns, Program, Step
from .redundant import RowsLeftOut, dependent, empty, implied_by_norms, redundant
from .scaled import Felt, ScaledRows, ScaledUnknowns, ShutCones

After = TypeVar("After")


class Reduced:
    """A compiled program with few and well-scaled unknowns and rows.

    `arrays` is the reduced program, and `cost_unit` the unit of its cost. `z_unit` are the units of
    the unknowns z of the compiled program. `left_out` counts the redundant rows.
    """

    def __init__(
        self,
        compiled: Compiled,
        units: Mapping[cp.Variable, Any],
        changes: Sequence[Change] = (),
        simplify: bool = True,
        defines: bool = True,
    ) -> None:
        self.compiled = compiled
        squares = {change.row: change for change in changes}
        self._changes = [
            (squares[block.row], block) for block in compiled.blocks if block.row in squares
        ]
        self._of_unknowns: list[ChangesUnknowns[Any]] = []
        self._of_rows: list[ChangesRows[Any]] = []
        self._eliminated = Eliminated(program_of(compiled, units), by_equations=defines)
        program = self._after(self._eliminated)
        rows = len(program.right)
        program = self._without_redundant_rows(program, simplify)
        self.left_out = rows - len(program.right)
        self.arrays = self._scaled(program)

    def _after(self, step: Step[After]) -> After:
        """The program after a further step."""
        if isinstance(step, ChangesUnknowns):
            self._of_unknowns.append(step)
        if isinstance(step, ChangesRows):
            self._of_rows.append(step)
        after = step.after
        del step.after  # its dense matrices are large, and the next step needs them only once
        return after

    def _without_redundant_rows(self, program: Program, simplify: bool) -> Program:
        """The program without redundant rows; without `simplify` only empty rows are left out."""
        if not simplify:
            return self._after(RowsLeftOut(program, empty(program)))
        whole = self._eliminated
        by_norms = np.isin(whole.rows, implied_by_norms(whole.before, whole.bounds))
        program = self._after(RowsLeftOut(program, np.flatnonzero(by_norms)))
        return self._after(RowsLeftOut(program, redundant(program)))

    def _scaled(self, program: Program) -> Arrays:
        """The program in its final unknowns and units, for the solvers."""
        new_unknowns = 0
        changes = list[Changed]()
        for change, _ in self._changes:
            changes.append(Changed(program, change, new_unknowns))
            program = self._after(changes[-1])
            new_unknowns = changes[-1].end
        stacked = Stacked(program)
        arrays = self._after(stacked)

        from_changes = int((stacked.unknowns < new_unknowns).sum())
        scaled = ScaledUnknowns(arrays, stacked.unit, from_changes)
        arrays = self._after(scaled)
        units = stacked.units(scaled.units)
        for changed in reversed(changes):
            units = changed.units(units)
        self.z_unit = self._eliminated.units(units)

        arrays = self._after(Felt(arrays))
        arrays = self._after(ShutCones(arrays))
        scaled_rows = ScaledRows(arrays)
        self.cost_unit = scaled_rows.cost_unit
        arrays = self._after(scaled_rows)
        return self._after(RowsLeftOut(arrays, dependent(arrays)))

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The unknowns and the multipliers of the compiled program, from those of this one."""
        z = self.unknowns(x)
        return z, self.multipliers(y, np.maximum(np.abs(z), self.z_unit))

    def unknowns(self, x: Array) -> Array:
        """The unknowns of the compiled program, from those of this one."""
        z = self._remaining(x)
        changed = {square.row for _, square in self._changes}
        for block in self.compiled.blocks:
            if block.row not in changed:
                z[block.defined] = block.matrix @ z[block.of]
        return self._eliminated.values(z)

    def _remaining(self, x: Array) -> Array:
        """The unknowns that were not eliminated; dense equations are still to be computed."""
        for step in reversed(self._of_unknowns[1:]):
            x = step.values(x)
        return x

    def direction(self, x: Array) -> tuple[Array, Array]:
        """A direction of the compiled program from one of this program, and the sizes of its terms.

        The size of a value is the sum of the sizes of its terms. Dense equations compute the values
        that they define, as in the user's problem; changes of variables do not.
        """
        z = self._remaining(x)
        sizes = np.abs(z)
        for block in self.compiled.blocks:
            z[block.defined] = block.matrix @ z[block.of]
            sizes[block.defined] = np.abs(block.matrix) @ np.abs(z[block.of])
        return self._eliminated.direction(z, sizes)

    def multipliers(self, y: Array, sizes: Array, cost_factor: float = 1.0) -> Array:
        """The multipliers of the compiled program, from those of this one.

        `sizes` are the weights of the errors of their balance. For `cost_factor`, see `Step`.
        """
        for step in reversed(self._of_rows):
            y = step.multipliers(y, cost_factor)
        cost = cost_factor * self.compiled.cost
        return dense_multipliers(self.compiled, self._changes, y, cost, sizes)
