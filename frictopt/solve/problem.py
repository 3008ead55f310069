"""A cvxpy problem that can be copied and pickled, even once it is solved, and its printing."""

import copy
import re
from functools import partial
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution

from ..base import RESIDUAL, Array


class Problem(cp.Problem):  # type: ignore[misc]  # cvxpy does not say its type
    """A problem whose deep copies and pickles have values, unknowns and parameters of their own.

    cvxpy numbers the unknowns, and its compiled parts refer to these numbers. In a plain copy the
    unknowns have other numbers than in the compiled parts, and Python crashes. The data of solvers
    cannot be pickled. So copies have neither compiled parts nor data of solvers.
    """

    stays_in_memory = True  # files of results leave it out

    def __str__(self) -> str:
        """The problem; lines that differ in one number in brackets are printed as one."""
        numbers_of = dict[tuple[str, int], list[str]]()  # by the line and its repetition
        for line in super().__str__().split("\n"):
            numbers = set(re.findall(r"\[(\d+)\]", line))
            kind, number = line, ""
            if len(numbers) == 1:
                kind = re.sub(r"\[\d+\]", "[k]", line)
                (number,) = numbers
            repetition = 0
            while number in numbers_of.get((kind, repetition), ()):
                repetition += 1
            numbers_of.setdefault((kind, repetition), []).append(number)
        return "\n".join(_line(kind, numbers) for (kind, _), numbers in numbers_of.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.objective, self.constraints, self.status)

    def __deepcopy__(self, memo: dict[Any, Any]) -> "Problem":
        return _again(self.objective, self.constraints, self.status, memo)


def _line(kind: str, numbers: list[str]) -> str:
    """A line with the numbers k for which it stands."""
    if len(numbers) == 1:
        return kind.replace("[k]", f"[{numbers[0]}]")
    few = numbers if len(numbers) < 5 else [*numbers[:2], "...", numbers[-1]]
    return f"{kind}  for k = {', '.join(few)}"


def _again(
    objective: Any, constraints: list[cp.Constraint], status: str, memo: Any = None
) -> Problem:
    """A copy of a problem whose unknowns have new numbers.

    The numbers of another process may already belong to other unknowns in this process.
    """
    objective, constraints = copy.deepcopy((objective, constraints), memo)
    parts = [objective, *constraints]
    while parts:
        part = parts.pop()
        for name in list(vars(part)):
            if name.startswith("_lazy") or name == "__deepcopy__":  # cvxpy's copies set it to None
                delattr(part, name)
        parts += part.args
    problem = Problem(objective, constraints)
    if status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        set_optimal(problem, status)
    elif status in (cp.INFEASIBLE, cp.UNBOUNDED):
        set_no_optimum(problem, status)
    return problem


def set_optimal(problem: cp.Problem, status: str = cp.OPTIMAL) -> None:
    """Give a problem whose unknowns and multipliers have values the status of an optimum."""
    values = {part.id: part.value for part in problem.variables()}
    problem.unpack(Solution(status, problem.objective.value, values, {}, {}))


def set_no_optimum(problem: cp.Problem, status: str) -> None:
    """Give a problem the status infeasible or unbounded, and the value that cvxpy has for it.

    Its unknowns then have no values. An infeasible problem keeps its multipliers, which prove that
    it is infeasible.
    """
    multipliers = {dual: dual.value for row in problem.constraints for dual in row.dual_variables}
    low = isinstance(problem.objective, cp.Maximize) == (status == cp.INFEASIBLE)
    problem.unpack(Solution(status, -np.inf if low else np.inf, {}, {}, {}))
    if status == cp.INFEASIBLE:
        for dual, value in multipliers.items():
            dual.save_value(value)


def printed_as(expression: cp.Expression, name: str) -> cp.Expression:
    """An expression that is printed by a name, instead of its atoms."""
    expression.name = partial(str, name)
    return expression


def label_of(row: cp.Constraint) -> str:
    """The label of a row; without a label, its side that is not constant."""
    if row.label:
        return str(row.label)
    return str(next((side for side in row.args if not side.is_constant()), row.args[0]))


def dual_of(row: cp.Constraint) -> Any:
    """The multiplier of a row; of a cone, the multiplier of its bound."""
    return row.dual_value[0] if isinstance(row, cp.SOC) else row.dual_value


def duals(problem: cp.Problem) -> dict[str, Array]:
    """The multipliers of the rows of a problem, by the names of the rows."""
    rows = [(row, dual_of(row)) for row in problem.constraints]
    return {
        label_of(row): np.atleast_1d(np.array(dual, dtype=float))
        for row, dual in rows
        if dual is not None
    }


def problem_lines(problem: cp.Problem, value: float | None) -> list[str]:
    """Lines of text that show a problem and its parts.

    The lines show which rows bind only if the objective of the problem equals `value`.
    """
    objective = problem.objective.expr.value
    solved = objective is not None and (
        value is None or bool(np.isclose(objective, value, rtol=1e-9, atol=1e-12))
    )
    convex, dpp = (_yes_or_no(known) for known in (problem.is_dcp(), problem.is_dpp()))
    mixed = ", mixed-integer" if problem.is_mixed_integer() else ""
    lines = [
        f"problem     {problem.status or 'not solved'}, convex (DCP) {convex}, "
        f"compiled once for all parameters (DPP) {dpp}{mixed}"
    ]
    lines += [f"    {line}" for line in str(problem).split("\n")]
    if not solved:
        lines.append(
            "values      none here: the problem has no optimum, "
            "or has been solved for something else since"
        )
    lines.append("variables")
    lines += map(_part_line, problem.variables())
    if problem.parameters():
        lines.append("parameters")
        lines += map(_part_line, problem.parameters())
    lines.append("constraints")
    return lines + [_row_line(row, solved) for row in problem.constraints]


def _part_line(part: cp.Variable | cp.Parameter) -> str:
    domain = ", >= 0" if part.is_nonneg() else ""
    if part.attributes["boolean"]:
        domain = ", boolean"
    return f"    {part.name():<24} {_size(part.shape)}{domain}"


def _row_line(row: cp.Constraint, solved: bool) -> str:
    kind, shape = "second-order cone", row.args[0].shape
    if not isinstance(row, cp.SOC):
        kind, shape = row.expr.curvature.lower(), row.shape
    binding = _binding(row) if solved else ""
    return f"    {label_of(row):<24} {_size(shape)}, {kind}{binding}"


def _yes_or_no(known: bool) -> str:
    return "yes" if known else "no"


def _binding(row: cp.Constraint) -> str:
    if len(row.args) < 2 or isinstance(row, cp.constraints.Equality):
        return ""
    low, high = (side.value for side in row.args)
    if low is None or high is None:
        return ""
    if isinstance(row, cp.SOC):  # its arguments are the bounds and the vectors
        low, high = np.linalg.norm(high, axis=row.axis), low
    slack = np.atleast_1d(high - low)
    size = max(float(np.abs(low).max(initial=0.0)), float(np.abs(high).max(initial=0.0)))
    binds = slack <= 100 * RESIDUAL * size  # solvers leave more slack than the residual
    return f", {int(binds.sum())} of {slack.size} rows bind"


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in shape) or "scalar"
