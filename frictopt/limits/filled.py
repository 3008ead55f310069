"""The values and multipliers of an answer in its printed problem."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import cvxpy as cp
import numpy as np

from ..solve.problem import Problem, set_no_optimum, set_optimal
from .models import Row
from .solved import INFEASIBLE, OPTIMAL, Solved

# The label of an equation that all corners share: q_r, p_r and w_r, and those of a profile.
_OF_ALL_CORNERS = re.compile(r"([qpw])_[rg](?:_\d+)?")

# The label of a row of a corner: its name, the number of its set of open nodes, and its corner.
_OF_CORNER = re.compile(r"(.+?)(?:_\d+)?\[(\d+)\]")


def fill(
    problem: Problem, rows: Sequence[Row], solved: Solved, values: dict[cp.Variable, Any]
) -> None:
    """Put values, the multipliers of some rows, and the status into a problem."""
    for variable, value in values.items():
        finite = bool(np.isfinite(value).all())
        variable.save_value(np.asarray(value, dtype=float) if finite else None)
    for row in rows:
        _fill_row(row, solved)
    if solved.status == OPTIMAL:
        for row in rows:
            defined = row.args[0].variables() if isinstance(row, cp.constraints.Equality) else []
            # Equations that define an unknown have its name.
            if len(defined) == 1 and defined[0].name() == row.label:
                value = np.reshape(row.args[1].value, defined[0].shape, order="F")
                defined[0].save_value(value)
        set_optimal(problem)
    else:
        set_no_optimum(problem, cp.INFEASIBLE if solved.status == INFEASIBLE else cp.UNBOUNDED)


def _fill_row(row: Row, solved: Solved) -> None:
    """Put the multipliers of a row into it, by its label."""
    value = _multipliers(row.label, solved)
    if value is None:
        return
    shape = row.dual_variables[0].shape
    row.save_dual_value(np.reshape(value, shape, order="F"))


def _multipliers(name: str, solved: Solved) -> Any:
    """The multipliers of a row of `models.py`, in column order; None if it is no row of these."""
    if name in solved.multipliers:
        return solved.multipliers[name]
    question = solved.question
    n = question.system.nodes
    moves = solved.moves
    opened = question.open_nodes if question.compliance is not None else np.zeros(n, dtype=bool)
    parts = {
        "q": moves[:, :-n],
        "p": np.where(opened, 0.0, moves[:, -n:]),
        "gap": moves[:, -n:][:, opened],
    }
    total = _OF_ALL_CORNERS.fullmatch(name)
    if total is not None:
        return parts[{"w": "gap"}.get(total[1], total[1])].sum(axis=0)
    match = _OF_CORNER.fullmatch(name)
    if match is None:
        return None
    kind, corner = match[1], int(match[2])
    if kind in parts:
        return parts[kind][corner]
    if kind not in solved.multipliers:
        return None
    by_node = solved.multipliers[kind][corner]
    for term in question.law.terms:
        if term.row == kind:
            return by_node[term.nodes]
    return by_node[opened] if kind == "apart" else by_node
