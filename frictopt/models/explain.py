"""Printing a model by the names of its parts."""

import sys
from collections.abc import Mapping, Sequence
from typing import IO

import cvxpy as cp
import numpy as np
import pandas as pd

__all__ = ["explain"]

_BINDING = 1e-7  # dimensionless slack below which a row counts as binding
_SHOWN = 8  # rows of the mechanism that are printed


def explain(
    title: str, problem: cp.Problem | None, units: Mapping[str, float], left_out: Sequence[str], mechanism: pd.DataFrame, file: IO[str] | None
) -> None:
    """Print title, variables, parameters, objective, constraints with the rows that bind, units, what was left out, and the mechanism.

    Parameters
    ----------
    title
        What the model computes.
    problem
        A cvxpy problem whose variables, parameters and constraints have names; None for a closed form.
    units
        Name of a variable -> its unit in the caller's units.
    left_out
        What the scene did not need.
    mechanism
        Slips that limit the load, largest share first.
    file
        Where to print; standard output by default.
    """
    lines = [title, "=" * len(title)]
    lines += ["no optimisation problem: closed form"] if problem is None else _problem_lines(problem, units)
    lines += ["left out"] + [f"    {text}" for text in left_out or ("nothing",)]
    if len(mechanism):
        table = mechanism.head(_SHOWN).to_string(index=False, float_format="{:.4g}".format)
        lines += [f"binding mechanism, {min(_SHOWN, len(mechanism))} of {len(mechanism)} slips", *(f"    {row}" for row in table.split("\n"))]
    print("\n".join(lines), file=file or sys.stdout)


def _problem_lines(problem: cp.Problem, units: Mapping[str, float]) -> list[str]:
    lines = [f"problem     {problem.status or 'not solved'}, convex (DCP) {_yes(problem.is_dcp())}, compiled once for all parameters (DPP) "]
    lines[0] += _yes(problem.is_dpp())
    if problem.status == cp.OPTIMAL:
        lines.append(f"objective   {type(problem.objective).NAME} {problem.objective.expr} = {problem.value:.10g} (dimensionless)")
    lines.append("variables")
    for variable in problem.variables():
        unit = f", unit {units[variable.name()]:.6g}" if variable.name() in units else ""
        lines.append(f"    {variable.name():<18} {_size(variable.shape)}{', >= 0' if variable.is_nonneg() else ''}{unit}")
    lines.append("parameters")
    lines += [f"    {parameter.name():<18} {_size(parameter.shape)}, {_range(parameter)}" for parameter in problem.parameters()]
    lines.append("constraints")
    for constraint in problem.constraints:
        curvature = constraint.args[0].curvature.lower()
        lines.append(f"    {constraint.label:<18} {_size(constraint.shape)}, {curvature}{_binding(constraint)}")
    return lines


def _binding(constraint: cp.Constraint) -> str:
    if constraint.args[0].value is None:
        return ""
    slack = np.atleast_1d(constraint.args[1].value - constraint.args[0].value)
    return f", {int((slack < _BINDING).sum())} of {slack.size} rows bind"


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in shape) or "scalar"


def _range(parameter: cp.Parameter) -> str:
    return "no value" if parameter.value is None else f"from {np.min(parameter.value):.4g} to {np.max(parameter.value):.4g}"


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"
