"""A linear program in which entries of variables may be fixed to zero, solved again and again.

The problem is compiled once. Its equations are substituted, and HiGHS keeps the program, so that
each solution starts from the basis of the one before. Bounds are proven by weak duality.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from scipy.sparse import csr_array, vstack

from ..base import Array, Booleans, Integers
from .compiled import Compiled
from .reduced import Reduced
from .solvers import CUT_OFF, OPTIMAL, WarmProgram


class FixedSolution(NamedTuple):
    """The upper bound that the multipliers prove, and the entries of the solution (None without).

    With more entries fixed, the basis is a good start: it is dual feasible then, too.

    The bound includes the error of the balance of the multipliers, for unknowns of the size of the
    solution or of their units.
    """

    bound: float
    entries: Array | None
    basis: Any = None


class Fixable:
    """A linear program to be maximised, with the `entries` of variables that may be fixed to zero.

    The objective has no constant term. An entry is a variable, a vector, and an index into it.
    """

    def __init__(
        self,
        compiled: Compiled,
        units: Mapping[cp.Variable, Any],
        entries: Sequence[tuple[cp.Variable, Integers]],
    ) -> None:
        # Without a change of variables the rows hold the matrices of the problem themselves.
        reduced = Reduced(compiled, units)
        arrays = reduced.arrays
        places = [compiled.place(variable).start + indices for variable, indices in entries]
        self._of_x, self._at_zero = _affine(reduced, np.concatenate(places))
        self._constant = float(compiled.cost @ reduced.unknowns(np.zeros(len(arrays.cost))))
        self._cost = arrays.cost
        self._cost_unit = reduced.cost_unit
        self._rows = csr_array(vstack([arrays.matrix, self._of_x]))
        self._zero = arrays.zero
        self._right = np.r_[arrays.right, -self._at_zero]
        self._first = len(arrays.right)
        count = len(self._right)
        least = np.full(count, -np.inf)
        least[: arrays.zero] = arrays.right[: arrays.zero]
        most = self._right.copy()
        most[self._first :] = np.inf
        free = np.full(len(self._cost), np.inf)
        self._program = WarmProgram(self._rows, least, most, self._cost, -free, free)
        self._fixed = np.zeros(len(self._at_zero), dtype=bool)

    def solve(self, fixed: Booleans, basis: Any = None, above: float = -np.inf) -> FixedSolution:
        """The solution with some entries fixed to zero; its bound is infinite if none exists.

        It starts from the basis of a solution, or of the last one. The solver may stop as soon as
        the value is proven not to exceed `above`; the solution then has no entries.
        """
        changed = np.flatnonzero(fixed != self._fixed)
        rights = self._right[self._first + changed]
        self._program.bound_rows(
            self._first + changed,
            np.where(fixed[changed], rights, -np.inf),
            np.where(fixed[changed], rights, np.inf),
        )
        self._fixed = fixed.copy()
        outcome, x, y = self._program.solve(basis, -(above + self._constant) / self._cost_unit)
        if outcome == CUT_OFF:
            return FixedSolution(self._bound(x, y), None)
        if outcome != OPTIMAL:
            return FixedSolution(np.inf, None)
        entries = self._of_x @ x + self._at_zero
        return FixedSolution(self._bound(x, y), entries, self._program.basis)

    def _bound(self, x: Array, y: Array) -> float:
        """The upper bound that multipliers prove, with the error of their balance."""
        y = y.copy()
        inequalities = slice(self._zero, self._first)
        y[inequalities] = np.maximum(y[inequalities], 0.0)
        y[self._first :][~self._fixed] = 0.0
        off = self._rows.T @ y + self._cost
        defect = float(np.abs(off) @ np.maximum(np.abs(x), 1.0))
        return self._cost_unit * (float(self._right @ y) + defect) - self._constant


def _affine(reduced: Reduced, places: Integers) -> tuple[Array, Array]:
    """Entries of the unknowns of the compiled program as `matrix @ x + vector`."""
    width = len(reduced.arrays.cost)
    at_zero = reduced.unknowns(np.zeros(width))[places]
    columns = [reduced.unknowns(unit)[places] - at_zero for unit in np.eye(width)]
    return np.column_stack(columns), at_zero
