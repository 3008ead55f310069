"""The answer of the first solver that passes the checks, and proofs that there is no optimum.

`answer` takes a program as arrays, and a function that makes a claim from unknowns x and
multipliers y. A claim is an answer that knows its own residual, whichever solver found it.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, hstack, vstack

from ..base import CONDENSATION, FAR, RESIDUAL, ROUNDING, Array, Attempt, SolveRecord
from .arrays import Arrays, polish
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

# Number of unknowns above which the interior-point method of frictopt is faster than Clarabel.
_LARGE = 180


def kind_of(program: Arrays) -> str:
    """The kind of a program; each kind has its own list of solvers."""
    if program.sizes.max(initial=1) == 1:
        return LP
    # Clarabel is faster for a large program without a dense block.
    return LARGE_SOCP if len(program.cost) >= _LARGE and len(program.block) else SOCP


def answer(
    program: Arrays,
    claimed: Callable[[Array, Array], C],
    solver: str | None = None,
    *,
    no_optimum: Callable[[str], C | None] = lambda outcome: None,
    above: float = -np.inf,
    tolerance: float = RESIDUAL,
) -> tuple[C, SolveRecord]:
    """The claim of the first solver whose residual is within the tolerance, and its record.

    `claimed(x, y)` makes the claim from an optimum. If a solver reports that there is no optimum,
    `no_optimum(outcome)` makes the claim. The outcome of a cone program is INFEASIBLE only if
    multipliers prove it; otherwise it is NONE. A solver may end as soon as it has proven that
    `-cost @ x` is at most `above`. SolverError if no claim is within the tolerance.
    """
    started = perf_counter()
    attempts = list[Attempt]()
    kind = kind_of(program)
    # Solvers leave fewer correct digits in the multipliers of cones than at the vertex of a linear
    # program. The polish adds digits, but in a large program it would take longer than the solver.
    enough = ROUNDING if kind == SOCP and tolerance <= RESIDUAL else tolerance
    claim_of_none: list[C | None] = []
    agreed = True
    for form, name in _ways(program, solver):
        outcome, x, y = run(form.arrays, name, -np.inf if form.is_dual else above)
        outcome = _known(form, outcome, y)
        best: C | None = None
        if outcome == OPTIMAL:
            agreed = False
            for outcome, solution in _solutions(form, x, y):
                claim = claimed(*solution)
                attempts.append(Attempt(name, outcome, claim.residual))
                if best is None or claim.residual < best.residual:
                    best = claim
                if best.residual <= enough:
                    break
        else:
            if outcome in (INFEASIBLE, UNBOUNDED, NONE):
                claim_of_none = claim_of_none or [no_optimum(outcome)]
                best = claim_of_none[0]
            else:
                agreed = False
            attempts.append(Attempt(name, outcome, best.residual if best else np.inf))
        if best and best.residual <= tolerance:
            seconds = perf_counter() - started
            return best, SolveRecord(name, tuple(attempts), best.residual, seconds=seconds)
    raise failed(kind, tolerance, attempts, agreed)


class _Form(NamedTuple):
    """Arrays for a solver, of a program or of its dual."""

    program: Arrays
    arrays: Arrays
    is_dual: bool = False

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Unknowns of the program, and its multipliers, moved into their cones."""
        if self.is_dual:
            x, y = -y[: self.arrays.zero], x
        return x, self.program.admissible(y)


def _known(form: _Form, outcome: str, y: Array) -> str:
    """The outcome of a program, from the outcome and the multipliers that a solver reports.

    A cone program counts as infeasible only if the multipliers prove it, because solvers also
    report that a program is infeasible if its solutions are far larger than their units.
    """
    if form.is_dual:
        # If the dual grows without end, the program has no optimum, but no multipliers prove it.
        return {INFEASIBLE: UNBOUNDED, UNBOUNDED: NONE}.get(outcome, outcome)
    program = form.program
    if outcome != INFEASIBLE or kind_of(program) == LP:
        return outcome
    proven = _error_of_none(program, program.admissible(y)) <= RESIDUAL
    return INFEASIBLE if proven else NONE


def _error_of_none(program: Arrays, y: Array) -> float:
    """The error of the proof, by multipliers in their cones, that no values satisfy all rows."""
    unbalanced = float(np.abs(program.columns(y)).sum())
    return error_of_contradiction(unbalanced, -float(program.right @ y))


def _ways(program: Arrays, solver: str | None = None) -> Iterator[tuple[_Form, str]]:
    """Forms and solvers, in the order in which they are tried: the dual last, if there is one."""
    solvers = solver_order(solver, kind_of(program))
    for name in solvers:
        yield _Form(program, program), name
    # The dual is last. In the program itself, the few motions of the bodies are the multipliers of
    # the balance of forces in cones, and solvers then satisfy this balance more exactly.
    if not len(program.block) and program.sizes.max(initial=1) > 1:
        for name in solvers:
            yield _Form(program, program.dual, is_dual=True), name


def _solutions(form: _Form, x: Array, y: Array) -> Iterator[tuple[str, tuple[Array, Array]]]:
    """The solution as the solver left it, and then polished in the form that the solver solved."""
    yield OPTIMAL, form.back(x, y)
    if len(x) < _LARGE or len(form.arrays.block):
        yield "refined", form.back(*polish(form.arrays, x, y))


def growths(program: Arrays) -> Iterator[Array]:
    """Directions in which `-cost @ x` grows while all slacks stay in their cones, or nearly so."""
    return _inside(program, np.zeros(len(program.right)), program.cost)


def interiors(program: Arrays) -> Iterator[Array]:
    """Values whose slacks are in their cones, or nearly so."""
    return _inside(program, program.right)


def contradictions(program: Arrays) -> Iterator[Array]:
    """Multipliers that may prove that no values have all slacks in their cones (Farkas's lemma).

    They are the multipliers of a program that finds the least e >= 0 with which all slacks, raised
    by e, are in their cones. The slack of an equation may be raised or lowered by e.
    """
    width, zero, linear = len(program.cost), program.zero, program.linear
    not_negative = csr_array(-np.eye(1, width + 1 + len(program.block), width))
    arrays = _least_raise(_without_equations(program), not_negative, np.zeros(1))
    for solutions in _optima(arrays):
        # The polished solution comes first, because it proves more.
        for x, y in reversed(solutions):
            if not float(arrays.cost @ x) > RESIDUAL:
                continue
            of_equations = y[:zero] - y[linear : linear + zero]
            found = np.r_[of_equations, y[zero:linear], y[linear + zero + 1 :]]
            yield program.admissible(found)
            yield program.admissible(_clean(found))


def infeasible(program: Arrays) -> tuple[Array, float] | None:
    """Multipliers that prove that no unknowns up to the size of their units satisfy all rows.

    Returned are the multipliers with the smallest error of this proof, or the first ones whose
    error is mere rounding, and their error. The result is None if no proof is found.
    """
    best: tuple[Array, float] | None = None
    for y in contradictions(program):
        error = _error_of_none(program, y)
        if error <= (best[1] if best else RESIDUAL):
            best = y, error
        if error <= ROUNDING:
            break
    return best


def error_of_contradiction(unbalanced: float, lack: float, far: float = FAR) -> float:
    """The error of the proof, by multipliers y, that rows contradict each other; inf without proof.

    `unbalanced` is the sum of the entries of `A'y`, which would all vanish without rounding. `lack`
    is the missing slack, `-right @ y`. The proof holds for unknowns up to `far` times their units.
    """
    return RESIDUAL * far * unbalanced / lack if lack > 0 else np.inf


def without_optimum(program: Arrays, outcome: str) -> tuple[Array | None, float] | None:
    """The proof that a program has no optimum, and its error; None if no proof is found.

    If `-cost @ x` grows without end, the proof is given as None, with its error. Otherwise it is
    the multipliers of `infeasible`. The outcome that a solver reported is tried first.
    """
    if outcome == UNBOUNDED:
        return unbounded(program) or infeasible(program)
    return infeasible(program) or unbounded(program)


def unbounded(program: Arrays) -> tuple[None, float] | None:
    """None in place of multipliers, and the error of the proof that `-cost @ x` grows without end.

    The result is None if no proof is found.
    """
    still = replace(program, right=np.zeros(len(program.right)))
    for ray in growths(program):
        size = float(np.abs(ray).max())
        leaving = still.violation(ray) / size if size else np.inf
        if leaving > RESIDUAL or -float(program.cost @ ray) <= RESIDUAL * size:
            continue
        for start in interiors(program):
            unsafe = program.violation(start) / max(1.0, float(np.abs(start).max()))
            if unsafe <= RESIDUAL:
                return None, max(leaving, unsafe)
    return None


def _inside(program: Arrays, right: Array, cost: Array | None = None) -> Iterator[Array]:
    """Values whose slacks, for this right side, are as deep inside their cones as possible.

    The depth is at most 1. With a cost the values also have `-cost @ x >= 1`. Slacks may still lie
    outside of their cones; the caller checks this.
    """
    width = len(program.cost)
    # The depth is minus the unknown that `_least_raise` minimises.
    bounds = np.zeros((1 if cost is None else 2, width + 1 + len(program.block)))
    bounds[0, width] = -1.0
    if cost is not None:
        bounds[1, :width] = cost
    bound_right = np.array([1.0, -1.0][: len(bounds)])
    arrays = _least_raise(replace(program, right=right), csr_array(bounds), bound_right)
    # The search ends if it is proven that all values leave some slack this far outside of its cone.
    # Rounding could then hide only values more than a hundred thousand times their units.
    outside = 1e-3
    for solutions in _optima(arrays):
        for x, y in solutions:
            least, error = arrays.lower_bound(x, y)
            if least - error > outside:
                return
            yield x[:width]
        yield _clean(x[:width])


def _optima(program: Arrays) -> Iterator[list[tuple[Array, Array]]]:
    """The solutions of all forms and solvers that find an optimum: each rough and polished."""
    for form, name in _ways(program):
        outcome, *rough = run(form.arrays, name, -np.inf)
        if outcome == OPTIMAL:
            yield [solution for _, solution in _solutions(form, *rough)]


def _without_equations(program: Arrays) -> Arrays:
    """The program with two opposite linear rows in place of each equation."""
    sparse, right = program.sparse, program.right
    zero, linear = program.zero, program.linear
    return replace(
        program,
        sparse=csr_array(vstack([sparse[:linear], -sparse[:zero], sparse[linear:]])),
        right=np.r_[right[:linear], -right[:zero], right[linear:]],
        zero=0,
        sizes=np.r_[np.ones(2 * zero, dtype=int), program.sizes],
    )


def _least_raise(program: Arrays, bounds: csr_array, bound_right: Array) -> Arrays:
    """The program that minimises one more unknown, by which all slacks in cones are raised.

    `bounds` are further linear rows.
    """
    sparse, right = program.sparse, program.right
    width, linear = len(program.cost), program.linear
    column = np.zeros((len(right), 1))
    column[program.heads] = -1.0
    raised = csr_array(hstack([sparse[:, :width], csr_array(column), sparse[:, width:]]))
    return Arrays(
        sparse=csr_array(vstack([raised[:linear], bounds, raised[linear:]])),
        block=np.hstack([program.block, np.zeros((len(program.block), 1))]),
        right=np.r_[right[:linear], bound_right, right[linear:]],
        cost=np.eye(1, width + 1, width)[0],
        zero=program.zero,
        sizes=np.r_[np.ones(len(bound_right), dtype=int), program.sizes],
    )


def _clean(values: Array) -> Array:
    """Values, with 0 in place of each value that is mere rounding relative to the largest one.

    At the apex of a cone, such rounding errors would move a point out of the cone.
    """
    size = np.abs(values)
    return np.where(size > CONDENSATION * size.max(initial=0.0), values, 0.0)
