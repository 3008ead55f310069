"""The printed problem of a best design: the rows of all scenarios, its preloads and profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from ..solve.problem import Problem
from . import models
from .design_program import Choice, Scenario, open_slips
from .filled import fill
from .listing import rest_rows, state_rows
from .models import Row, Unknowns, constant, defines, unknowns
from .solution import Solution
from .user_rows import UserRows

# Names of the matrices of the design in q, p, the gaps and the slips of open nodes.
_SYMBOLS = {"preload": ("q_j", "p_j", "w_j", "v_j"), "profile": ("-B.T", "-C", "-w", "-v")}


class Added(NamedTuple):
    """The terms that a design adds to a question, and the rows that define their unknowns."""

    listed: list[cp.Expression]  # added to q, p and, if nodes are open, to the gaps
    open_slip: cp.Expression | None  # added to the slips of open nodes
    rows: list[Row]


def design_problem(
    choice: Choice,
    scenarios: Sequence[Scenario],
    solution: Solution,
    x: Unknowns,
    user: UserRows | None,
) -> cp.Problem:
    """The problem of a design with the values and multipliers of its solution."""
    rows = list[Row]()
    whole = solution.solved("design")
    fillings = []
    first = 0
    for number, scenario in enumerate(scenarios):
        question = scenario.question
        corners = range(len(question.r1))
        suffix = f"_{number}" if number else ""
        own = x
        if number:
            own = unknowns(question.system.slip_shape, corners, x.load_factor, suffix)
        f = models.friction(question.friction, suffix)
        with_open_slips = number == 0 and user is not None and bool(question.open_nodes.any())
        added = _added(choice, scenario, suffix, with_open_slips)
        more = dict.fromkeys(corners, added.listed)
        listed = [*added.rows, *state_rows(question, own, f, list(corners), more=more)]
        slip = solution.closed_slip(number)
        if with_open_slips:
            listed += rest_rows(question, x, added.open_slip)
            slip = whole.values["slip"]
        here = slice(first, first := first + len(question.r1))
        multipliers = {
            name: value[here] if value.ndim == 2 and len(value) > len(question.r1) else value
            for name, value in whole.multipliers.items()
        }
        part = replace(whole, question=question, moves=whole.moves[here], multipliers=multipliers)
        fillings.append((listed, part, {own.slip: slip}))
        rows += listed
    problem = models.shakedown(x, rows)
    goal = problem.objective
    user_rows: list[Row] = []
    if user is not None:
        user.save(whole.values["user"])
        user_rows = [*user.rows.values()]
        goal = goal if user.objective is None else cp.Maximize(user.objective)
    problem = Problem(goal, [*problem.constraints, *user_rows])
    x.load_factor.save_value(np.array(solution.load_factor))
    for variable, name in choice.variables.items():
        variable.save_value(solution.values(name))
    fillings.append(([problem.constraints[len(rows)]], whole, {}))
    for listed, part, values in fillings:
        fill(problem, listed, part, values)
    return problem


def _added(choice: Choice, scenario: Scenario, suffix: str, with_open_slips: bool) -> Added:
    """The terms that a design adds to a scenario. All names end with `suffix`.

    `with_open_slips`: also to the slips of open nodes, which rows of the user may contain.
    """
    question = scenario.question
    by_unknown: list[list[cp.Expression]] = []
    rows: list[Row] = []
    effects = choice.effects(scenario)
    for variable, name in choice.variables.items():
        of_parts = [*question.parts(question.forces_of(effects[name]).T)]
        if question.compliance is None:
            of_parts = of_parts[:2]
        elif with_open_slips:
            of_parts.append(open_slips(question, effects[name]))
        terms = [
            constant(effect, symbol + suffix) @ variable
            for effect, symbol in zip(of_parts, _SYMBOLS[name], strict=False)
        ]
        if name == "profile":
            parts = [
                cp.Variable(term.size, name=f"{part}_g{suffix}")
                for part, term in zip("qpwv", terms, strict=False)
            ]
            rows = [defines(part, term) for part, term in zip(parts, terms, strict=True)]
            terms = parts
        by_unknown.append(terms)

    q, p, *of_open_nodes = (sum(terms[1:], terms[0]) for terms in zip(*by_unknown, strict=True))
    if choice.system.tangents > 1:
        q = cp.reshape(q, choice.system.slip_shape, order="F")
    open_slip = of_open_nodes[1] if with_open_slips else None
    return Added([q, p, *of_open_nodes[:1]], open_slip, rows)
