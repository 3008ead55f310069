"""The one way of a linear or cone program to its answer: compiled, reduced, solved, polished, proven, and put back into the cvxpy problem."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from scipy.sparse import coo_array, csr_array, hstack, vstack

from ..contact import RESIDUAL, ROUNDING, Array, Attempt, SolveRecord
from .arrays import Arrays, polish
from .compiled import Change, Compiled, Proof, proof
from .problem import put_back, standing
from .reduced import Reduced
from .solvers import INFEASIBLE, LARGE_SOCP, LP, NONE, OPTIMAL, SOCP, UNBOUNDED, C, failed, run, solver_order

_LARGE = 400  # unknowns from which on the own interior point is faster than Clarabel
_FAR = 1e3  # a proof that there is no answer holds for unknowns at least `1 / FAR / RESIDUAL` times as large as their units


class NoAnswer(NamedTuple):
    """Why a program has no optimum: the ids of the rows that contradict each other, or the unknowns z that grow without end."""

    ruling: frozenset[int]
    z: Array | None
    residual: float


class Chain:
    """A problem with what it takes to solve it: the units of its variables and of its objective, and changes of variables.

    `units` are one or one for each entry, in the units of the problem; others follow from the rows. All three may be set anew for each solution.
    `simplify`: leave out rows that others stand for.
    """

    proof: Proof  # by the multipliers that stand in the problem
    violation: float  # largest one of a compiled row by the values that stand there, over the size of its terms

    def __init__(
        self, problem: cp.Problem, units: Mapping[cp.Variable, Any], changes: Sequence[Change] = (), simplify: bool = True, unit: float = 1.0
    ) -> None:
        self.problem, self.units, self.changes, self._simplify, self.unit = problem, dict(units), changes, simplify, unit
        self._compiled = Compiled(problem)
        self._reduced: Reduced | None = None

    @property
    def reduced(self) -> Reduced:
        """The reduced program with the parameters of the last `solve`."""
        if self._reduced is None:
            self._reduced = Reduced(self._compiled, self.units, self.changes, self._simplify)
        return self._reduced

    def solve(
        self,
        judged: Callable[[], C],
        solver: str | None = None,
        *,
        no_optimum: Callable[[], C | None] | None = None,
        above: float = -np.inf,
        tolerance: float = RESIDUAL,
    ) -> tuple[C, SolveRecord]:
        """Solve with the first solver whose answer passes, polished if need be: what `judged` makes of what then stands in the problem."""
        started, attempts, agreed = perf_counter(), list[Attempt](), True
        self._compiled.read()
        self._reduced = None
        program = self.reduced.arrays
        kind = LP if program.sizes.max(initial=1) == 1 else LARGE_SOCP if len(program.cost) >= _LARGE else SOCP
        sparse = kind == LARGE_SOCP and not len(program.block)  # of few entries: Clarabel factors it faster, and the polish takes far longer
        names, enough = solver_order(solver, SOCP if sparse else kind), ROUNDING if kind == SOCP else tolerance
        for name, polished in [*((name, False) for name in names if sparse), *((name, True) for name in names)]:
            outcome, x, y = run(program, name, above)
            claim = None
            if outcome == OPTIMAL:
                agreed, claim = False, self._claim(x, program.admissible(y), judged)
                attempts.append(Attempt(name, outcome, claim.residual))
                if polished and not claim.residual <= enough:  # the digits that interior points leave cost little in small programs
                    refined = self._claim(*polish(program, x, y), judged)
                    attempts.append(Attempt(name, f"refined on the {'vertex' if kind == LP else 'active cones'}", refined.residual))
                    claim = self._claim(x, program.admissible(y), judged) if claim.residual < refined.residual else refined
            else:
                said = outcome in (INFEASIBLE, UNBOUNDED, NONE)
                claim = no_optimum() if said and no_optimum else None
                attempts.append(Attempt(name, outcome, claim.residual if claim else float("inf")))
                agreed = agreed and said
            if claim and claim.residual <= tolerance:
                told = (f"rows: {self.reduced.left_out} that others stand for",) * (self.reduced.left_out > 0)
                return claim, SolveRecord(name, tuple(attempts), claim.residual, told, perf_counter() - started)
        raise failed(kind, tolerance, attempts, agreed)

    def _claim(self, x: Array, y: Array, judged: Callable[[], C]) -> C:
        reduced = self.reduced
        z, multipliers = reduced.back(x, y)
        self.violation = self._compiled.violation(z, reduced.z_unit)
        self._compiled.save(z, multipliers)
        self.proof = proof(self._compiled, z, multipliers, reduced.z_unit, self.unit)
        return judged()

    @contextmanager
    def kept(self) -> Iterator[None]:
        """What stands in the unknowns and multipliers of the problem stands in them again afterwards."""
        values = standing(self.problem)
        try:
            yield
        finally:
            put_back(values)

    def value_along(self, growth: NoAnswer, variable: cp.Variable) -> Any:
        """The part of a variable in unknowns that grow without end."""
        assert growth.z is not None
        values = growth.z[self._compiled.place(variable)].reshape(variable.shape, order="F")
        return float(values) if values.ndim == 0 else values

    def contradiction(self, growth: NoAnswer | None = None) -> NoAnswer | None:
        """Proof that no values of the variables obey all rows (Farkas's lemma): its multipliers stand in the rows then. None where there is none.

        Along unknowns that can grow without end, it must hold to the last digits of its terms.
        """
        program, reduced, compiled = self.reduced.arrays, self.reduced, self._compiled
        found = _least_excess(program, program.right, None)
        if found is None or not found[0] > RESIDUAL:
            return None
        multipliers = reduced.multipliers(found[2], np.zeros(len(compiled.cost)), reduced.z_unit)
        balance = compiled.matrix.T @ multipliers
        lack, off = -float(compiled.right @ multipliers), float(np.abs(balance) @ reduced.z_unit)
        if not lack > 0 or off / lack / _FAR > RESIDUAL:
            return None
        if growth and growth.z is not None:
            terms = np.abs(multipliers) @ (np.abs(compiled.matrix) @ np.abs(growth.z))
            if abs(balance @ growth.z) > RESIDUAL * terms:
                return None
        sizes = compiled.save_multipliers(multipliers)
        largest = max(sizes.values(), default=0.0)
        return NoAnswer(frozenset(row for row, size in sizes.items() if size > RESIDUAL * largest), None, off / lack / _FAR)

    def growth(self) -> NoAnswer | None:
        """Proof that the objective of a program that has a solution grows without end: the z along which it does. None where there is none."""
        program, reduced = self.reduced.arrays, self.reduced
        none = np.zeros(len(program.right))
        found = _least_excess(program, none, program.cost)
        if found is None:
            return None
        along, grows = found[1], float(np.abs(program.cost).max())  # by at least half of it, whatever excess is left
        off = replace(program, right=none).violation(along) / max(1.0, float(np.abs(along).max(initial=0.0)))
        if off > RESIDUAL or not -program.cost @ along > grows / 2:
            return None
        z = reduced.back(along, none)[0] - reduced.back(np.zeros_like(along), none)[0]  # a direction: what is put in is affine
        return NoAnswer(frozenset(), z, off)


def _least_excess(program: Arrays, right: Array, cost: Array | None) -> tuple[float, Array, Array] | None:
    """The least e >= 0 by which all slacks must be raised to be in their cones, equations too, and `-cost @ x >= 1 - e` where there is a cost.

    With x and the multipliers of the rows; None where no solver finds it.
    """
    (parts, width), zero, linear = program.block.shape, program.zero, int((program.sizes == 1).sum())
    sparse, count = csr_array(program.sparse), len(right)
    heads = np.r_[np.arange(zero), zero + np.cumsum(program.sizes) - program.sizes]
    raised = coo_array((-np.ones(len(heads)), (heads, np.zeros(len(heads), dtype=int))), shape=(count, 1))
    rows = csr_array(hstack([sparse[:, :width], raised, sparse[:, width:]]))
    back = csr_array(hstack([-sparse[:zero, :width], -np.ones((zero, 1)), -sparse[:zero, width:]])) if zero else rows[:0]
    last = np.zeros((1 if cost is None else 2, width + 1 + parts))
    last[:, width] = -1.0
    if cost is not None:
        size = float(np.abs(cost).max()) or 1.0
        last[1, :width] = cost / size
    sides = np.r_[np.zeros(1), -np.ones(len(last) - 1)]
    arrays = Arrays(
        sparse=csr_array(vstack([rows[: zero + linear], back, csr_array(last), rows[zero + linear :]])),
        block=np.hstack([program.block, np.zeros((parts, 1))]),
        right=np.r_[right[: zero + linear], -right[:zero], sides, right[zero + linear :]],
        cost=np.eye(1, width + 1, width)[0],
        zero=0,
        sizes=np.r_[np.ones(2 * zero + linear + len(sides), dtype=int), program.sizes[program.sizes > 1]],
    )
    kind = LP if program.sizes.max(initial=1) == 1 else LARGE_SOCP if width >= _LARGE else SOCP
    for name in solver_order(None, kind):
        status, x, y = run(arrays, name, -np.inf)
        if status != OPTIMAL:
            continue
        for polished in (False, True) if kind == LARGE_SOCP else (True,):  # which takes long in large programs
            x, y = polish(arrays, x, y) if polished else (x, arrays.admissible(y))
            value, bound = float(x[width]), -float(arrays.right @ y)
            off = float(np.abs(arrays.matrix.T @ y + arrays.cost) @ np.maximum(np.abs(x), 1.0))
            if abs(value - bound) + off <= RESIDUAL or bound - off > RESIDUAL:
                last_rows = 2 * zero + linear + len(sides)
                own = np.r_[y[:zero] - y[zero + linear : 2 * zero + linear], y[zero : zero + linear], y[last_rows:]]
                return bound if bound - off > RESIDUAL else min(value, bound), x[:width], own
    return None
