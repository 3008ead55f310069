"""A cvxpy problem that can be copied and pickled, whatever solver has had it; and printing it by the names of its parts."""

import copy
import re
from collections.abc import Mapping
from typing import Any, TypeAlias

import cvxpy as cp
import numpy as np
import pandas as pd
from cvxpy.reductions.solution import Solution

from ..base import RESIDUAL, Array, Recorded

_BINDING = (
    100 * RESIDUAL
    # slack, over the largest of its row, up to which it is printed as binding: solvers leave more than
    # the residual
)

_SAID = {True: "yes", False: "no"}
_SHOWN = 8  # rows of the mechanism that are printed

Duals: TypeAlias = tuple[tuple[str, Array], ...]


class Problem(cp.Problem):  # type: ignore[misc]  # cvxpy does not say its type
    """A problem whose deep copies and pickles have its values, and unknowns and parameters of their own.

    cvxpy numbers the unknowns, and keeps parts that it has compiled by these numbers. In a plain
    copy the numbers are others, which ends Python. Nor can what solvers leave in a problem be
    pickled. So both stay behind.
    """

    stays_in_memory = True  # files of results leave it out

    def __str__(self) -> str:
        lines = dict[tuple[str, int], list[str]]()  # by what they are of a number k
        for line in super().__str__().split("\n"):
            numbers, again = set(re.findall(r"\[(\d+)\]", line)), 0
            kind, k = (
                (re.sub(r"\[\d+\]", "[k]", line), *numbers) if len(numbers) == 1 else (line, "")
            )
            while k in lines.get((kind, again), ()):
                again += 1
            lines.setdefault((kind, again), []).append(k)
        return "\n".join(_line(kind, ks) for (kind, _), ks in lines.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.objective, self.constraints, self.status, self.value)

    def __deepcopy__(self, memo: dict[Any, Any]) -> "Problem":
        return _again(self.objective, self.constraints, self.status, self.value, memo)


def _line(kind: str, ks: list[str]) -> str:
    if len(ks) == 1:
        return kind.replace("[k]", f"[{ks[0]}]")
    return f"{kind}  for k = {', '.join(ks if len(ks) < 5 else [*ks[:2], '...', ks[-1]])}"


def _again(
    objective: Any, constraints: list[cp.Constraint], status: str, value: float, memo: Any = None
) -> Problem:
    """A problem with numbers of its own: those of another process may stand for others here."""
    objective, constraints = copy.deepcopy((objective, constraints), memo)
    parts = [objective, *constraints]
    while parts:
        part = parts.pop()
        for name in [
            name for name in vars(part) if name.startswith("_lazy") or name == "__deepcopy__"
        ]:  # which is None in cvxpy's own copies
            delattr(part, name)
        parts += part.args
    problem = Problem(objective, constraints)
    if status in ("optimal", "optimal_inaccurate"):
        problem.unpack(
            Solution(status, value, {part.id: part.value for part in problem.variables()}, {}, {})
        )
    elif status in (cp.INFEASIBLE, cp.UNBOUNDED):
        set_no_optimum(problem, status)
    return problem


def set_no_optimum(problem: cp.Problem, status: str) -> None:
    """Give a problem the status infeasible or unbounded, and the value that cvxpy has for it. Its unknowns then have no values.

    The multipliers that stand in an infeasible one stay, for they prove it.
    """
    multipliers = {dual: dual.value for row in problem.constraints for dual in row.dual_variables}
    low = isinstance(problem.objective, cp.Maximize) == (status == cp.INFEASIBLE)
    problem.unpack(Solution(status, -np.inf if low else np.inf, {}, {}, {}))
    if status == cp.INFEASIBLE:
        put_back(multipliers)


class Explained(Recorded):
    """Base of answers of a program, which print it by the names of its parts."""

    problem: cp.Problem | None

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        """Title; the answer, with which what stands in the problem must agree to be printed; slips that limit the load, largest first; the reason."""
        raise NotImplementedError

    def explain(self) -> str:
        """The model by its names, as text: sizes, curvature, DPP, what was left out, and the rows that bind."""
        title, value, mechanism, reason = self._told()
        lines = [title, "=" * len(title)]
        lines += [] if value is None else [f"answer      {value:.12g}"]
        lines += [f"reason      {reason}"] if reason else []
        lines += (
            ["problem     none"] if self.problem is None else _problem_lines(self.problem, value)
        )
        lines += ["left out"] + [f"    {text}" for text in self.record.left_out or ("nothing",)]
        if mechanism is not None and len(mechanism):
            table = mechanism.head(_SHOWN).to_string(index=False, float_format="{:.4g}".format)
            lines += [
                f"binding mechanism, {min(_SHOWN, len(mechanism))} of {len(mechanism)} slips",
                *(f"    {row}" for row in table.split("\n")),
            ]
        return "\n".join(lines)


def label_of(row: cp.Constraint) -> str:
    """The label of a row, or the side of it that is no constant."""
    return str(
        row.label or next((side for side in row.args if not side.is_constant()), row.args[0])
    )


def dual_of(row: cp.Constraint) -> Any:
    """The multiplier of a row, of a cone that of its bound."""
    return row.dual_value[0] if isinstance(row, cp.SOC) else row.dual_value


def standing(problem: cp.Problem) -> dict[cp.Variable, Any]:
    """What stands in the unknowns and multipliers of a problem."""
    parts = [
        *problem.variables(),
        *(dual for row in problem.constraints for dual in row.dual_variables),
    ]
    return {part: part.value for part in parts}


def put_back(values: Mapping[cp.Variable, Any]) -> None:
    """Put what stood in unknowns and multipliers back into them."""
    for part, value in values.items():
        part.save_value(value)


def duals(problem: cp.Problem) -> Duals:
    """The multipliers that stand in the rows of a problem, by the names of the rows."""
    rows = [(row, dual_of(row)) for row in problem.constraints]
    return tuple(
        (label_of(row), np.atleast_1d(np.array(dual, dtype=float)))
        for row, dual in rows
        if dual is not None
    )


def _problem_lines(problem: cp.Problem, value: float | None) -> list[str]:
    objective = problem.objective.expr
    solved = objective.value is not None and (
        value is None or bool(np.isclose(objective.value, value, rtol=1e-9, atol=1e-12))
    )
    compiled = f"convex (DCP) {_SAID[problem.is_dcp()]}, compiled once for all parameters (DPP) {_SAID[problem.is_dpp()]}"
    lines = [
        f"problem     {problem.status or 'not solved'}, {compiled}{', mixed-integer' if problem.is_mixed_integer() else ''}"
    ]
    lines += [f"    {line}" for line in str(problem).split("\n")]
    if not solved:
        lines.append(
            "values      none here: the problem has no optimum, or has been solved for something else since"
        )
    lines += [
        "variables",
        *(
            f"    {variable.name():<24} {_size(variable.shape)}{_domain(variable)}"
            for variable in problem.variables()
        ),
    ]
    lines += ["parameters"] * bool(problem.parameters())
    lines += [
        f"    {parameter.name():<24} {_size(parameter.shape)}{f', {_range(parameter.value)}' if solved else ''}"
        for parameter in problem.parameters()
    ]
    lines.append("constraints")
    for row in problem.constraints:
        cone = isinstance(row, cp.SOC)
        curvature = "second-order cone" if cone else row.expr.curvature.lower()
        size = _size(row.args[0].shape if cone else row.shape)
        lines.append(
            f"    {label_of(row):<24} {size}, {curvature}{_binding(row) if solved else ''}"
        )
    return lines


def _domain(variable: cp.Variable) -> str:
    return (
        ", boolean" if variable.attributes["boolean"] else ", >= 0" if variable.is_nonneg() else ""
    )


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
    return f", {int((slack <= _BINDING * size).sum())} of {slack.size} rows bind"


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in shape) or "scalar"


def _range(values: float | Array | None) -> str:
    if values is None:
        return "no value"
    least, most = float(np.min(values)), float(np.max(values))
    return f"{least:.4g}" if least == most else f"{least:.4g} .. {most:.4g}"
