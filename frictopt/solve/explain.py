"""Printing a model by the names of its parts."""

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import RESIDUAL, Array, Recorded

_BINDING = 100 * RESIDUAL  # slack, over the largest of its row, up to which it is printed as binding: solvers leave more than the residual

_SAID = {True: "yes", False: "no"}
_SHOWN = 8  # rows of the mechanism that are printed


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
        lines += ["problem     none"] if self.problem is None else _problem_lines(self.problem, value)
        lines += ["left out"] + [f"    {text}" for text in self.record.left_out or ("nothing",)]
        if mechanism is not None and len(mechanism):
            table = mechanism.head(_SHOWN).to_string(index=False, float_format="{:.4g}".format)
            lines += [f"binding mechanism, {min(_SHOWN, len(mechanism))} of {len(mechanism)} slips", *(f"    {row}" for row in table.split("\n"))]
        return "\n".join(lines)


def called(row: cp.Constraint) -> str:
    """The label of a row, or the side of it that is no constant."""
    return str(row.label or next((side for side in row.args if not side.is_constant()), row.args[0]))


def _problem_lines(problem: cp.Problem, value: float | None) -> list[str]:
    objective = problem.objective.expr
    solved = objective.value is not None and (value is None or bool(np.isclose(objective.value, value, rtol=1e-9, atol=1e-12)))
    compiled = f"convex (DCP) {_SAID[problem.is_dcp()]}, compiled once for all parameters (DPP) {_SAID[problem.is_dpp()]}"
    lines = [f"problem     {problem.status or 'not solved'}, {compiled}{', mixed-integer' if problem.is_mixed_integer() else ''}"]
    lines += [f"    {line}" for line in str(problem).split("\n")]
    if not solved:
        lines.append("values      none here: the problem has no optimum, or has been solved for something else since")
    lines += ["variables", *(f"    {variable.name():<24} {_size(variable.shape)}{_domain(variable)}" for variable in problem.variables())]
    lines += ["parameters"] * bool(problem.parameters())
    lines += [
        f"    {parameter.name():<24} {_size(parameter.shape)}{f', {_range(parameter.value)}' if solved else ''}" for parameter in problem.parameters()
    ]
    lines.append("constraints")
    for row in problem.constraints:
        cone = isinstance(row, cp.SOC)
        curvature = "second-order cone" if cone else row.expr.curvature.lower()
        size = _size(row.args[0].shape if cone else row.shape)
        lines.append(f"    {called(row):<24} {size}, {curvature}{_binding(row) if solved else ''}")
    return lines


def _domain(variable: cp.Variable) -> str:
    return ", boolean" if variable.attributes["boolean"] else ", >= 0" if variable.is_nonneg() else ""


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
