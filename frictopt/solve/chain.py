"""The one way of a linear or cone program to its answer: compiled, reduced, solved, polished, proven, and put back into the cvxpy problem."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from scipy.sparse import coo_array, csr_array, hstack, vstack

from ..base import CONDENSATION, RESIDUAL, ROUNDING, Array, Attempt, SolveRecord
from .arrays import Arrays, polish
from .compiled import Change, Compiled, Proof, proof
from .flipped import Flipped, Plain, flipped
from .problem import put_back, set_no_optimum, standing
from .reduced import Reduced
from .solvers import (
    INFEASIBLE,
    LARGE_SOCP,
    LP,
    NONE,
    OPTIMAL,
    SOCP,
    UNBOUNDED,
    C,
    failed,
    run,
    solver_order,
)

_LARGE = 400  # unknowns from which on the own interior point is faster than Clarabel
# a proof that there is no answer holds for unknowns at least `1 / FAR / RESIDUAL` times as large as
# their units
_FAR = 1e3


class NoAnswer(NamedTuple):
    """Why a program has no optimum: the ids of the rows that contradict each other, or the unknowns z that grow without end."""

    ruling: frozenset[int]
    z: Array | None
    residual: float


class Chain:
    """A problem with what it takes to solve it: the units of its variables and of its objective, and changes of variables.

    `units` are one or one for each entry, in the units of the problem; others follow from the rows.
    All three may be set anew for each solution. `simplify`: leave out rows that others stand for.
    `defines`: let equations define unknowns; a balance of unknowns that are in cones of their own
    is better kept, see `flipped`.
    """

    proof: Proof  # by the multipliers that stand in the problem
    # largest one of a compiled row by the values that stand there, over the size of its terms
    violation: float

    def __init__(
        self,
        problem: cp.Problem,
        units: Mapping[cp.Variable, Any],
        changes: Sequence[Change] = (),
        simplify: bool = True,
        unit: float = 1.0,
        defines: bool = True,
    ) -> None:
        self.problem, self.units, self.changes, self._simplify, self.unit = (
            problem,
            dict(units),
            changes,
            simplify,
            unit,
        )
        self._defines = defines
        self._compiled = Compiled(problem)
        self._reduced: Reduced | None = None

    @property
    def reduced(self) -> Reduced:
        """The reduced program with the parameters of the last `solve`."""
        if self._reduced is None:
            self._reduced = Reduced(
                self._compiled, self.units, self.changes, self._simplify, self._defines
            )
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
        asked, none = False, None
        self._compiled.read()
        self._reduced = None
        program = self.reduced.arrays
        kind, ways = _ways(program, solver)
        enough = ROUNDING if kind == SOCP else tolerance
        for form, name, polished in ways:
            outcome, x, y = run(form.arrays, name, form.above(above / self.reduced.cost_unit))
            outcome = form.said.get(outcome, outcome)
            claim = None
            if outcome == OPTIMAL:
                agreed, claim = False, self._claim(*form.back(x, form.arrays.admissible(y)), judged)
                attempts.append(Attempt(name, outcome, claim.residual))
                if (
                    polished and not claim.residual <= enough
                ):  # the digits that interior points leave cost little in small programs
                    refined = self._claim(*form.back(*polish(form.arrays, x, y)), judged)
                    attempts.append(
                        Attempt(
                            name,
                            f"refined on the {'vertex' if kind == LP else 'active cones'}",
                            refined.residual,
                        )
                    )
                    worse = claim.residual < refined.residual
                    claim = (
                        self._claim(*form.back(x, form.arrays.admissible(y)), judged)
                        if worse
                        else refined
                    )
            else:
                said = outcome in (INFEASIBLE, UNBOUNDED, NONE)
                if said and no_optimum and not asked:
                    none, asked = (
                        no_optimum(),
                        True,
                    )  # once, for it depends on the program and not on the solver
                claim = none if said else None
                attempts.append(Attempt(name, outcome, claim.residual if claim else float("inf")))
                agreed = agreed and said
            if claim and claim.residual <= tolerance:
                told = (f"rows: {self.reduced.left_out} that others stand for",) * (
                    self.reduced.left_out > 0
                )
                return claim, SolveRecord(
                    name, tuple(attempts), claim.residual, told, perf_counter() - started
                )
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

    def contradiction(self) -> NoAnswer | None:
        """Proof that no values of the variables obey all rows (Farkas's lemma): its multipliers stand in the rows then. None where there is none.

        Along unknowns that can grow without end, it must hold to the last digits of its terms.
        """
        found = _least_excess(self.reduced.arrays)
        if found is None or not found[0] > RESIDUAL:
            return None
        ray, compiled = self.ray(), self._compiled
        for told in (found[1], _clean(found[1])):
            multipliers = self.reduced.multipliers(
                told, np.zeros(len(compiled.cost)), self.reduced.z_unit
            )
            error = self._contradicts(multipliers, None if ray is None else ray[0])
            if error <= RESIDUAL:
                sizes = compiled.save_multipliers(multipliers)
                set_no_optimum(self.problem, cp.INFEASIBLE)
                largest = max(sizes.values(), default=0.0)
                return NoAnswer(
                    frozenset(row for row, size in sizes.items() if size > RESIDUAL * largest),
                    None,
                    error,
                )
        return None

    def _contradicts(self, multipliers: Array, ray: Array | None) -> float:
        """The error of a contradiction by multipliers, for unknowns up to many times their units and all along a ray; inf if they prove none."""
        compiled, units = self._compiled, self.reduced.z_unit
        balance, outside, terms = (
            compiled.matrix.T @ multipliers,
            compiled.outside(multipliers),
            np.abs(compiled.matrix),
        )
        lack = -float(compiled.right @ multipliers) - float(outside @ np.abs(compiled.right))
        if not lack > 0:
            return np.inf
        if ray is not None and abs(balance @ ray) > RESIDUAL * (
            np.abs(multipliers) @ (terms @ np.abs(ray))
        ):
            return np.inf
        return float(np.abs(balance) @ units + outside @ (terms @ units)) / lack / _FAR

    def ray(self) -> tuple[Array, float] | None:
        """A direction z in which the objective grows without end from any values that obey all rows, and its error; None where none is found.

        The error is how far z leaves a row of the program as it was compiled, over the terms of z
        in that row.
        """
        program, compiled = self.reduced.arrays, self._compiled
        for along in _inside(program, np.zeros(len(program.right)), program.cost):
            z, sizes = self.reduced.direction(along)
            growing, terms = -float(compiled.cost @ z), float(np.abs(compiled.cost) @ np.abs(z))
            leaving = compiled.leaving(z, sizes)
            if leaving <= RESIDUAL and growing > RESIDUAL * terms:
                return z, leaving
        return None

    def growth(self) -> NoAnswer | None:
        """Proof that the objective grows without end: a `ray`, and values that obey all rows as they were compiled; None where there is none."""
        ray = self.ray()
        if ray is None:
            return None
        program, reduced = self.reduced.arrays, self.reduced
        for start in _inside(program, program.right):
            unsafe = self._compiled.violation(
                reduced.back(start, np.zeros(len(program.right)))[0], reduced.z_unit
            )
            if unsafe <= RESIDUAL:
                set_no_optimum(self.problem, cp.UNBOUNDED)
                return NoAnswer(frozenset(), ray[0], max(ray[1], unsafe))
        return None


def _inside(program: Arrays, right: Array, cost: Array | None = None) -> Iterator[Array]:
    """Values whose slacks, with this right side, lie as deep in their cones as solvers find, up to 1; with `-cost @ x >= 1` if there is a cost.

    They may lie outside. The caller judges them.
    """
    (parts, width), zero = program.block.shape, program.zero
    heads = zero + np.cumsum(program.sizes) - program.sizes
    raised = coo_array(
        (-np.ones(len(heads)), (heads, np.zeros(len(heads), dtype=int))), shape=(len(right), 1)
    )
    rows = csr_array(hstack([program.sparse[:, :width], raised, program.sparse[:, width:]]))
    last = np.zeros((1 if cost is None else 2, width + 1 + parts))
    last[0, width] = -1.0
    if cost is not None:
        last[1, :width] = cost
    sides, linear = np.r_[1.0, -np.ones(len(last) - 1)], zero + int((program.sizes == 1).sum())
    arrays = Arrays(
        sparse=csr_array(vstack([rows[:linear], csr_array(last), rows[linear:]])),
        block=np.hstack([program.block, np.zeros((parts, 1))]),
        right=np.r_[right[:linear], sides, right[linear:]],
        cost=np.eye(1, width + 1, width)[0],
        zero=zero,
        sizes=np.r_[
            np.ones(linear - zero + len(sides), dtype=int), program.sizes[program.sizes > 1]
        ],
    )
    for form, name, _ in _ways(arrays)[1]:
        status, x, y = run(form.arrays, name, -np.inf)
        if status == OPTIMAL:
            yield form.back(x, form.arrays.admissible(y))[0][:width]
            deepest = form.back(*polish(form.arrays, x, y))[0][:width]
            yield deepest
            yield _clean(deepest)


def _clean(values: Array) -> Array:
    """Values with 0 for those that are rounding beside the largest one: at the end of a cone, rounding lies outside of it."""
    size = np.abs(values)
    return np.where(size > CONDENSATION * size.max(initial=0.0), values, 0.0)


def _least_excess(program: Arrays) -> tuple[float, Array] | None:
    """The least e >= 0 by which all slacks must be raised to be in their cones, equations too, and the multipliers of the rows.

    None where no solver finds it.
    """
    (parts, width), zero, linear = (
        program.block.shape,
        program.zero,
        int((program.sizes == 1).sum()),
    )
    sparse, right, count = csr_array(program.sparse), program.right, len(program.right)
    heads = np.r_[np.arange(zero), zero + np.cumsum(program.sizes) - program.sizes]
    raised = coo_array(
        (-np.ones(len(heads)), (heads, np.zeros(len(heads), dtype=int))), shape=(count, 1)
    )
    rows = csr_array(hstack([sparse[:, :width], raised, sparse[:, width:]]))
    back = (
        csr_array(hstack([-sparse[:zero, :width], -np.ones((zero, 1)), -sparse[:zero, width:]]))
        if zero
        else rows[:0]
    )
    last = csr_array(-np.eye(1, width + 1 + parts, width))
    arrays = Arrays(
        sparse=csr_array(vstack([rows[: zero + linear], back, last, rows[zero + linear :]])),
        block=np.hstack([program.block, np.zeros((parts, 1))]),
        right=np.r_[right[: zero + linear], -right[:zero], 0.0, right[zero + linear :]],
        cost=np.eye(1, width + 1, width)[0],
        zero=0,
        sizes=np.r_[np.ones(2 * zero + linear + 1, dtype=int), program.sizes[program.sizes > 1]],
    )
    for form, name, polished in _ways(arrays)[1]:
        status, *found = run(form.arrays, name, -np.inf)
        for refined in (False, True)[: 1 + polished] if status == OPTIMAL else ():
            x, y = form.back(
                *(
                    polish(form.arrays, *found)
                    if refined
                    else (found[0], form.arrays.admissible(found[1]))
                )
            )
            value, bound = float(x[width]), -float(arrays.right @ y)
            off = float(np.abs(arrays.matrix.T @ y + arrays.cost) @ np.maximum(np.abs(x), 1.0))
            if abs(value - bound) + off <= RESIDUAL or bound - off > RESIDUAL:
                own = np.r_[
                    y[:zero] - y[zero + linear : 2 * zero + linear],
                    y[zero : zero + linear],
                    y[2 * zero + linear + 1 :],
                ]
                return bound if bound - off > RESIDUAL else min(value, bound), own
    return None


def _ways(
    program: Arrays, solver: str | None = None
) -> tuple[str, list[tuple[Plain | Flipped, str, bool]]]:
    """The kind of a program, and the forms, the solvers, and whether to polish, in the order in which they are tried."""
    kind = (
        LP
        if program.sizes.max(initial=1) == 1
        else LARGE_SOCP
        if len(program.cost) >= _LARGE
        else SOCP
    )
    sparse = kind == LARGE_SOCP and not len(
        program.block
    )  # of few entries: Clarabel factors it faster, and the polish takes far longer
    names, plain, dual = (
        solver_order(solver, SOCP if sparse else kind),
        Plain(program),
        flipped(program),
    )
    ways: list[tuple[Plain | Flipped, str, bool]] = (
        [(dual, name, True) for name in solver_order(solver, LARGE_SOCP)] if dual else []
    )
    ways += [(plain, name, False) for name in names if sparse]
    return kind, ways + [(plain, name, True) for name in names]
