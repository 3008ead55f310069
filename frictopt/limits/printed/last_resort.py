"""The last resort: plain cvxpy solves the printed problem of a shakedown limit.

It is tried if no answer of the arrays passes its checks. The unknowns and multipliers that cvxpy
finds are converted to the form of the arrays, so that the polish and the proof are the same as for
other answers. Only Coulomb's law with friction at all nodes is handled, without a slip bound and
without user constraints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cvxpy as cp
import numpy as np

from ...base import RESIDUAL, Array, SolveRecord
from ...errors import SolverError
from ...solve.arrays import CONE, Rows, polish
from ...solve.by_cvxpy import solve
from ...solve.solvers import C
from ..program.assembled import shakedown
from ..program.question import Question
from ..program.rest_program import RestProgram
from ..program.solution import Solution
from . import models
from .listing import state_rows
from .models import unknowns


def by_plain_cvxpy(
    question: Question, claimed: Callable[[Solution], C], error: SolverError
) -> tuple[C, SolveRecord]:
    """The claim of plain cvxpy, and its record; raises `error` if it fails the checks, too."""
    other = question.slip_bound is not None or question.system.capped
    if other or not question.friction.all():
        raise error
    question = replace(question, simplify=False)
    program = shakedown(question)
    x = unknowns(question.system.slip_shape, range(len(question.r1)))
    problem = models.shakedown(
        x, state_rows(question, x, models.friction(question.friction), [*x.q])
    )
    claims = list[C]()

    def residual() -> float:
        rough = _read(program, problem)
        polished = polish(program.arrays(), *rough)
        for values, multipliers in (rough, polished):
            solution = Solution(program, values, multipliers[program.form.slides :])
            claims.append(claimed(solution))
        claims.sort(key=lambda claim: claim.residual)
        return claims[0].residual

    try:
        attempts = solve(problem, residual)
    except SolverError:
        raise error from None
    if not claims[0].residual <= RESIDUAL:
        raise error
    return claims[0], SolveRecord(f"cvxpy: {attempts[-1].solver}", attempts, claims[0].residual)


def _read(program: RestProgram, problem: cp.Problem) -> tuple[Array, Array]:
    """Unknowns and multipliers of the arrays, from the values in a solved problem."""
    question = program.question
    values = {variable.name(): variable.value for variable in problem.variables()}
    x = np.zeros(len(program.form.arrays.cost))
    goal = program.place
    x[goal.column] = values[program.goal] / goal.unit
    slip = program.form.slips[0]
    beyond = values["slip"].ravel(order="F") - slip.reference
    x[slip.shear] = (question.A @ beyond)[slip.elastic.slips] / slip.shear_units
    x[slip.slide] = np.linalg.pinv(slip.slides) @ beyond[slip.elastic.slips]

    duals = {row.label: np.atleast_1d(row.dual_value) for row in problem.constraints}
    corners = range(len(question.r1))
    q = np.array([duals[f"q[{k}]"].ravel(order="F") for k in corners])
    n = question.system.nodes
    places = {"apart": np.cumsum(question.open_nodes) - 1}

    def multipliers_of(rows: Rows) -> Array:
        at, nodes = rows.instants, rows.nodes
        if not len(nodes):
            return np.zeros(0)
        if rows.label == program.goal:
            return duals[program.goal]
        listed = np.array([duals[f"{rows.label}[{k}]"] for k in corners])
        own = listed[at, places.get(rows.label, np.arange(n))[nodes]]
        if rows.label != "stuck":
            return np.asarray(own)
        shears = [q[at, axis * n + nodes] for axis in range(question.system.tangents)]
        if rows.kind == CONE:
            return np.column_stack([own, *shears]).ravel()
        # In the arrays `abs(q) <= f p` is two rows, one for each sign of q. They share the
        # multiplier of the printed row.
        return np.asarray((own + rows.weights[: len(at)] * shears[0]) / 2)

    rows = program.form.stacked
    y = np.concatenate([multipliers_of(part) for part, _ in rows.parts]) * rows.units / goal.unit
    return x, np.r_[np.zeros(program.form.slides), y]
