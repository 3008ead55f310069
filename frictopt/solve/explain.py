"""Printing a model by the names of its parts."""

import sys
from collections.abc import Mapping
from typing import IO, TypeAlias

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import RESIDUAL, Array, Recorded

_BINDING = 100 * RESIDUAL  # slack, over the largest of its row, up to which it is printed as binding: solvers leave more than the residual

Units: TypeAlias = Mapping[str, float | Array]

_SAID = {True: "yes", False: "no"}
_SHOWN = 8  # rows of the mechanism that are printed


class Explained(Recorded):
    """Base of answers of a program, which print it by the names of its parts."""

    problem: cp.Problem | None
    _units: Units  # name of a variable -> its unit in the caller's units, one or one per entry

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        """Title; the answer, with which what stands in the problem must agree to be printed; slips that limit the load, largest first; the reason."""
        raise NotImplementedError

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind.

        `file` is where to print; standard output by default.
        """
        title, value, mechanism, reason = self._told()
        lines = [title, "=" * len(title)]
        lines += [] if value is None else [f"answer      {value:.12g}"]
        lines += [f"reason      {reason}"] if reason else []
        none = ["problem     none: closed form, or left behind by a copy"]
        lines += none if self.problem is None else _problem_lines(self.problem, value, self._units)
        lines += ["left out"] + [f"    {text}" for text in self.record.left_out or ("nothing",)]
        if mechanism is not None and len(mechanism):
            table = mechanism.head(_SHOWN).to_string(index=False, float_format="{:.4g}".format)
            lines += [f"binding mechanism, {min(_SHOWN, len(mechanism))} of {len(mechanism)} slips", *(f"    {row}" for row in table.split("\n"))]
        print("\n".join(lines), file=file or sys.stdout)


def _problem_lines(problem: cp.Problem, value: float | None, units: Units) -> list[str]:
    objective = problem.objective.expr
    unit = units.get(objective.name(), 1.0) if isinstance(objective, cp.Variable) and objective.name() != "margin" else 1.0
    solved = objective.value is not None and (value is None or bool(np.isclose(objective.value * unit, value, rtol=1e-12, atol=0.0)))
    compiled = f"convex (DCP) {_SAID[problem.is_dcp()]}, compiled once for all parameters (DPP) {_SAID[problem.is_dpp()]}"
    lines = [f"problem     {problem.status or 'not solved'}, {compiled}"]
    lines[0] += ", mixed-integer" if problem.is_mixed_integer() else ""
    name = objective.name() if isinstance(objective, cp.Variable) else f"an expression of {', '.join(v.name() for v in objective.variables())}"
    lines.append(f"objective   {type(problem.objective).NAME} {name}{f', in units of {unit:.12g}' if unit != 1 else ''}")
    if not solved:
        lines.append("values      none here: the problem has no optimum, or has been solved for something else since")
    lines.append("variables")
    for variable in problem.variables():
        scale = f", unit {_range(units[variable.name()])}" if variable.name() in units else ""
        lines.append(f"    {variable.name():<24} {_size(variable.shape)}{_domain(variable)}{scale}")
    lines += ["parameters"] * bool(problem.parameters())
    lines += [
        f"    {parameter.name():<24} {_size(parameter.shape)}{f', {_range(parameter.value)}' if solved else ''}" for parameter in problem.parameters()
    ]
    lines.append("constraints")
    for constraint in problem.constraints:
        cone = isinstance(constraint, cp.SOC)
        curvature = "second-order cone" if cone else constraint.expr.curvature.lower()
        size = _size(constraint.args[0].shape if cone else constraint.shape)
        lines.append(f"    {constraint.label:<24} {size}, {curvature}{_binding(constraint) if solved else ''}")
    return lines


def _domain(variable: cp.Variable) -> str:
    return ", boolean" if variable.attributes["boolean"] else ", >= 0" if variable.is_nonneg() else ""


def _binding(constraint: cp.Constraint) -> str:
    low, high = (side.value for side in constraint.args)
    if low is None or high is None:
        return ""
    if isinstance(constraint, cp.constraints.Equality):
        return f", {constraint.size} of {constraint.size} rows bind"
    if isinstance(constraint, cp.SOC):  # its arguments are the bounds and the vectors
        low, high = np.linalg.norm(high, axis=constraint.axis), low
    slack, size = np.atleast_1d(high - low), max(float(np.abs(low).max()), float(np.abs(high).max()))
    return f", {int((slack <= _BINDING * size).sum())} of {slack.size} rows bind"


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in shape) or "scalar"


def _range(values: float | Array | None) -> str:
    if values is None:
        return "no value"
    least, most = float(np.min(values)), float(np.max(values))
    return f"{least:.4g}" if least == most else f"{least:.4g} .. {most:.4g}"
