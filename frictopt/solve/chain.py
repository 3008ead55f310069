"""The solution of a linear or cone program, step by step.

A program is compiled, reduced, solved, polished, proven, and put back into the cvxpy problem.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from time import perf_counter
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
from scipy.sparse import coo_array, csr_array, hstack, vstack

from ..base import CONDENSATION, RESIDUAL, ROUNDING, Array, Attempt, Integers, SolveRecord
from .arrays import Arrays, polish
from .compiled import Change, Compiled, Proof, proof
from .fixable import Fixable
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

# Number of unknowns above which our interior point is faster than Clarabel.
_LARGE = 400
# Rounding of the sum of a few exact numbers, relative to the size of its terms.
_EXACT = ROUNDING / 100


class NoAnswer(NamedTuple):
    """The proof that a program has no optimum.

    Either the rows with the ids `ruling` contradict each other, or the unknowns z grow without end.
    """

    ruling: frozenset[int]
    z: Array | None
    residual: float


class Chain:
    """A problem with its units, its compiled and its reduced program, and the solution of these.

    `units` are the units of variables, one number or one for each entry, in the units of the
    problem. Units of other variables follow from the rows. `unit` is the unit of the objective, and
    `changes` are changes of variables. All three may be set anew for each solution.

    With `simplify` redundant rows are left out. With `defines` unknowns are eliminated by
    equations. This is not useful if the equations balance unknowns that are in cones of their own,
    see `flipped`.
    """

    proof: Proof
    """The bound that the multipliers in the problem prove."""
    violation: float
    """Largest violation of a compiled row by the values in the problem, relative to its terms."""

    def __init__(
        self,
        problem: cp.Problem,
        units: Mapping[cp.Variable, Any],
        changes: Sequence[Change] = (),
        simplify: bool = True,
        unit: float = 1.0,
        defines: bool = True,
    ) -> None:
        self.problem = problem
        self.units = dict(units)
        self.changes = changes
        self.unit = unit
        self._simplify = simplify
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
        checked: Callable[[], C],
        solver: str | None = None,
        *,
        no_optimum: Callable[[], C | None] | None = None,
        above: float = -np.inf,
        tolerance: float = RESIDUAL,
    ) -> tuple[C, SolveRecord]:
        """Solve with the first solver whose answer has a residual within the tolerance.

        `checked` builds the claim from the values and multipliers in the problem. If a solver finds
        no optimum, `no_optimum` builds the claim. A solver may stop once it has proven that the
        objective is not `above` this number.
        """
        started = perf_counter()
        attempts = list[Attempt]()
        self._compiled.read()
        self._reduced = None
        reduced = self.reduced
        kind = kind_of(reduced.arrays)
        # This claim depends only on the program, so it is computed once for all solvers.
        claim_of_none = cache(no_optimum or (lambda: None))
        agreed = True
        for way in _ways(reduced.arrays, solver):
            outcome, x, y = way.run(above / reduced.cost_unit)
            if outcome == OPTIMAL:
                no_optimum_exists = False
                enough = ROUNDING if kind == SOCP else tolerance
                claim: C | None = self._best_claim(way, x, y, checked, enough, attempts)
            else:
                no_optimum_exists = outcome in (INFEASIBLE, UNBOUNDED, NONE)
                claim = claim_of_none() if no_optimum_exists else None
                residual = claim.residual if claim else np.inf
                attempts.append(Attempt(way.solver, outcome, residual))
            agreed = agreed and no_optimum_exists
            if claim and claim.residual <= tolerance:
                left_out = self._left_out
                # Its dense block is large, and the next solution makes it anew.
                self._reduced = None
                seconds = perf_counter() - started
                return claim, SolveRecord(
                    way.solver, tuple(attempts), claim.residual, left_out, seconds
                )
        raise failed(kind, tolerance, attempts, agreed)

    def fixable(self, entries: Sequence[tuple[cp.Variable, Integers]]) -> Fixable:
        """The linear program with its present parameters, and entries that may be fixed to zero."""
        self._compiled.read()
        return Fixable(self._compiled, self.units, entries)

    @property
    def _left_out(self) -> tuple[str, ...]:
        count = self.reduced.left_out
        return (f"rows: {count} redundant",) if count else ()

    def _best_claim(
        self,
        way: "_Way",
        x: Array,
        y: Array,
        checked: Callable[[], C],
        enough: float,
        attempts: list[Attempt],
    ) -> C:
        """The claim of an optimum, or of the polished one if its residual is not `enough`."""
        rough = way.rough(x, y)
        claim = self._claim(*rough, checked)
        residual = claim.residual
        attempts.append(Attempt(way.solver, OPTIMAL, residual))
        if not way.polished or residual <= enough:
            return claim
        # In small programs it costs little to gain the digits that interior points lack.
        refined = self._claim(*way.refined(x, y), checked)
        linear = kind_of(self.reduced.arrays) == LP
        outcome = "refined on the vertex" if linear else "refined on the active cones"
        attempts.append(Attempt(way.solver, outcome, refined.residual))
        if residual < refined.residual:
            return self._claim(*rough, checked)  # the rough answer is put back into the problem
        return refined

    def _claim(self, x: Array, y: Array, checked: Callable[[], C]) -> C:
        """Put an answer of the reduced program into the problem, and return its claim."""
        reduced = self.reduced
        z, multipliers = reduced.back(x, y)
        self.violation = self._compiled.violation(z, reduced.z_unit)
        self._compiled.save(z, multipliers)
        self.proof = proof(self._compiled, z, multipliers, reduced.z_unit, self.unit)
        return checked()

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Restore the values and multipliers of the problem afterwards."""
        values = standing(self.problem)
        try:
            yield
        finally:
            put_back(values)

    def value_along(self, growth: NoAnswer, variable: cp.Variable) -> Any:
        """The entries of a variable in the direction in which the unknowns grow without end."""
        assert growth.z is not None
        part = growth.z[self._compiled.place(variable)]
        values = part.reshape(variable.shape, order="F")
        return float(values) if values.ndim == 0 else values

    def contradiction(self) -> NoAnswer | None:
        """Proof that no values of the variables obey all rows (Farkas's lemma), or None.

        If there is one, its multipliers are put into the rows. Along unknowns that can grow without
        end, the proof must hold up to rounding of its terms.
        """
        excess = _least_excess(self.reduced.arrays)
        if excess is None or not excess[0] > RESIDUAL:
            return None
        growing = self.ray()
        ray = None if growing is None else growing[0]
        for y in (excess[1], _clean(excess[1])):
            multipliers = self.reduced.multipliers(y, self.reduced.z_unit, cost_factor=0.0)
            error = self._contradicts(multipliers, ray)
            if error <= RESIDUAL:
                sizes = self._compiled.save_multipliers(multipliers)
                set_no_optimum(self.problem, cp.INFEASIBLE)
                largest = max(sizes.values(), default=0.0)
                ruling = (row for row, size in sizes.items() if size > RESIDUAL * largest)
                return NoAnswer(frozenset(ruling), None, error)
        return None

    def _contradicts(self, multipliers: Array, ray: Array | None) -> float:
        """The error of a contradiction by multipliers; inf if they prove none.

        A contradiction must hold for unknowns up to many times their units, and along a whole ray.
        """
        compiled = self._compiled
        balance = compiled.matrix.T @ multipliers
        outside = compiled.outside(multipliers)
        terms = np.abs(compiled.matrix)
        lack = -float(compiled.right @ multipliers) - float(outside @ np.abs(compiled.right))
        if not lack > 0:
            return np.inf
        if ray is not None:
            terms_along = np.abs(multipliers) @ (terms @ np.abs(ray))
            if abs(balance @ ray) > RESIDUAL * terms_along:
                return np.inf
        units = self.reduced.z_unit
        error = float(np.abs(balance) @ units + outside @ (terms @ units))
        # The proof holds for unknowns up to `1 / (far RESIDUAL)` times their units.
        far = 1e3
        return error / lack / far

    def ray(self, rounding: float = _EXACT) -> tuple[Array, float] | None:
        """A direction z in which the objective grows without end, and its error, or None.

        The direction is valid from any point that obeys all rows. The error is the largest
        violation of a row of the compiled program by z, relative to the terms of z in that row.
        `rounding` is the rounding of the data, see `Compiled.leaving`.
        """
        program, compiled = self.reduced.arrays, self._compiled
        for along in _inside(program, np.zeros(len(program.right)), program.cost):
            z, sizes = self.reduced.direction(along)
            growing = -float(compiled.cost @ z)
            terms = float(np.abs(compiled.cost) @ np.abs(z))
            leaving = compiled.leaving(z, sizes, rounding)
            if leaving <= RESIDUAL and growing > RESIDUAL * terms:
                return z, leaving
        return None

    def growth(self, rounding: float = _EXACT) -> NoAnswer | None:
        """Proof that the objective grows without end, or None.

        It consists of a `ray`, and of values that obey all rows as they were compiled. If the data
        are a condensed stiffness, a direction in which the friction bounds stay the same obeys the
        rows only up to the rounding of the stiffness: `rounding` is CONDENSATION.
        """
        ray = self.ray(rounding)
        if ray is None:
            return None
        program, reduced = self.reduced.arrays, self.reduced
        for start in _inside(program, program.right):
            z, _ = reduced.back(start, np.zeros(len(program.right)))
            unsafe = self._compiled.violation(z, reduced.z_unit)
            if unsafe <= RESIDUAL:
                set_no_optimum(self.problem, cp.UNBOUNDED)
                return NoAnswer(frozenset(), ray[0], max(ray[1], unsafe))
        return None


class _Way(NamedTuple):
    """A form of a program, the solver that is to solve it, and whether its answer is polished."""

    form: Plain | Flipped
    solver: str
    polished: bool

    def run(self, above: float = -np.inf) -> tuple[str, Array, Array]:
        """Status of the program, and x and multipliers of its form."""
        status, x, y = run(self.form.arrays, self.solver, self.form.above(above))
        return self.form.outcomes.get(status, status), x, y

    def rough(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The solution of the program as the solver left it, with multipliers in their cones."""
        return self.form.back(x, self.form.arrays.admissible(y))

    def refined(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The polished solution of the program."""
        return self.form.back(*polish(self.form.arrays, x, y))

    def solutions(self) -> Iterator[tuple[Array, Array]]:
        """Solutions of the program to be judged, the polished one last."""
        status, x, y = self.run()
        if status == OPTIMAL:
            yield self.rough(x, y)
            if self.polished:
                yield self.refined(x, y)


def kind_of(program: Arrays) -> str:
    """The kind of a program, which has its own solvers."""
    if program.sizes.max(initial=1) == 1:
        return LP
    return LARGE_SOCP if len(program.cost) >= _LARGE else SOCP


def _ways(program: Arrays, solver: str | None = None) -> list[_Way]:
    """Forms and solvers in the order in which they are tried."""
    kind = kind_of(program)
    # For a large program of few entries Clarabel is faster, and the polish would take far longer.
    sparse = kind == LARGE_SOCP and not len(program.block)
    names = solver_order(solver, SOCP if sparse else kind)
    plain = Plain(program)
    dual = flipped(program)
    ways = list[_Way]()
    if dual:
        ways += [_Way(dual, name, True) for name in solver_order(solver, LARGE_SOCP)]
    if sparse:
        ways += [_Way(plain, name, False) for name in names]
    return ways + [_Way(plain, name, True) for name in names]


def _inside(program: Arrays, right: Array, cost: Array | None = None) -> Iterator[Array]:
    """Values whose slacks, for this right side, are as deep inside their cones as possible.

    The depth is at most 1. With a cost the values also have `-cost @ x >= 1`. Slacks may still lie
    outside of their cones; the caller checks this. There are no values if the multipliers prove
    that a slack of all values is far outside.
    """
    parts, width = program.block.shape
    linear = program.linear
    raised = _raised(program.sparse, width, program.heads)
    bounds = np.zeros((1 if cost is None else 2, width + 1 + parts))
    bounds[0, width] = -1.0  # the depth, which is minus the raise, is at most 1
    bound_right = [1.0]
    if cost is not None:
        bounds[1, :width] = cost
        bound_right.append(-1.0)
    arrays = _least_raise(
        program,
        csr_array(vstack([raised[:linear], csr_array(bounds), raised[linear:]])),
        np.r_[right[:linear], bound_right, right[linear:]],
        program.zero,
    )
    # If a slack is proven to be this far outside of its cone, for all values, rounding does not
    # hide values inside: they would be more than a hundred thousand times their units.
    outside = 1e-3
    for way in _ways(arrays):
        status, x, y = way.run()
        if status == OPTIMAL:
            rough, multipliers = way.rough(x, y)
            if (_proven_excess(arrays, rough, multipliers) or 0.0) > outside:
                return
            yield rough[:width]
            deepest = way.refined(x, y)[0][:width]
            yield deepest
            yield _clean(deepest)


def _least_excess(program: Arrays) -> tuple[float, Array] | None:
    """The least e >= 0 by which all slacks must be raised to be in their cones, and multipliers.

    An equation is raised in both senses. None if no solver finds the answer.
    """
    parts, width = program.block.shape
    zero = program.zero
    linear = program.linear
    right = program.right
    raised = _raised(program.sparse, width, np.r_[np.arange(zero), program.heads])
    opposite = _raised(-program.sparse[:zero], width, np.arange(zero))
    sign = csr_array(-np.eye(1, width + 1 + parts, width))  # -e <= 0
    arrays = _least_raise(
        program,
        csr_array(vstack([raised[:linear], opposite, sign, raised[linear:]])),
        np.r_[right[:linear], -right[:zero], 0.0, right[linear:]],
        0,
    )
    for way in _ways(arrays):
        for x, y in way.solutions():
            excess = _proven_excess(arrays, x, y)
            if excess is not None:
                of_equations = y[:zero] - y[linear : linear + zero]
                of_cones = y[linear + zero + 1 :]
                return excess, np.r_[of_equations, y[zero:linear], of_cones]
    return None


def _proven_excess(arrays: Arrays, x: Array, y: Array) -> float | None:
    """The least excess, if the multipliers prove it or prove that it is above zero; else None."""
    value = float(arrays.cost @ x)
    bound, off = arrays.lower_bound(x, y)
    if bound - off > RESIDUAL:
        return bound
    return min(value, bound) if abs(value - bound) + off <= RESIDUAL else None


def _raised(sparse: csr_array, width: int, heads: Integers) -> csr_array:
    """Rows with a further unknown, the number `width`, by which the slacks `heads` are raised."""
    column = coo_array(
        (-np.ones(len(heads)), (heads, np.zeros(len(heads), dtype=int))),
        shape=(sparse.shape[0], 1),
    )
    return csr_array(hstack([sparse[:, :width], column, sparse[:, width:]]))


def _least_raise(program: Arrays, sparse: csr_array, right: Array, zero: int) -> Arrays:
    """The program that minimises the last unknown under these rows, with the cones of `program`.

    The first `zero` rows are equations. Further rows, which `program` does not have, are linear.
    """
    parts, width = program.block.shape
    cones = program.sizes[program.sizes > 1]
    linear = len(right) - zero - int(cones.sum())
    return Arrays(
        sparse=sparse,
        block=np.hstack([program.block, np.zeros((parts, 1))]),
        right=right,
        cost=np.eye(1, width + 1, width)[0],
        zero=zero,
        sizes=np.r_[np.ones(linear, dtype=int), cones],
    )


def _clean(values: Array) -> Array:
    """Values, with 0 for those that are rounding relative to the largest one.

    At the apex of a cone, rounding errors lie outside of it.
    """
    size = np.abs(values)
    return np.where(size > CONDENSATION * size.max(initial=0.0), values, 0.0)
