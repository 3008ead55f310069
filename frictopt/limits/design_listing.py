"""The printed problem of a best design: the rows of all scenarios, its preloads and profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from ..base import Array
from ..solve.problem import Problem
from . import models
from .design_program import Choice, Scenario
from .filled import fill
from .listing import rest_rows, state_rows
from .models import Row, Unknowns, constant, defines, unknowns
from .question import Question
from .solution import Solution
from .user_rows import UserRows


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
        added = _added(choice, scenario, suffix)
        more = dict.fromkeys(corners, added.listed)
        listed = [*added.rows, *state_rows(question, own, f, list(corners), more=more)]
        slip = solution.closed_slip(number)
        if number == 0 and user is not None and question.open_nodes.any():
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
    for listed, part, values in fillings:
        fill(problem, listed, part, values)
    return problem


def _added(choice: Choice, scenario: Scenario, suffix: str) -> Added:
    """The terms that a design adds to a scenario. All names end with `suffix`."""
    question, shares = scenario
    by_part: list[list[cp.Expression]] = []
    rows: list[Row] = []
    if choice.preload is not None:
        acting = choice.reactions * [shares.get(name, 1.0) for name in choice.names]
        names = ("q_j", "p_j", "w_j", "v_j")
        by_part.append(_products(question, acting, names, choice.preload, suffix))

    if choice.profile is not None:
        closing = -choice.system.S[:, -choice.system.nodes :]
        names = ("-B.T", "-C", "-w", "-v")
        products = _products(question, closing, names, choice.profile, suffix)
        parts = [
            cp.Variable(product.size, name=f"{symbol}_g{suffix}")
            for product, symbol in zip(products, "qpwv", strict=False)
        ]
        rows = [defines(part, product) for part, product in zip(parts, products, strict=True)]
        by_part.append(parts)

    q, p, *of_open_nodes = (sum(parts[1:], parts[0]) for parts in zip(*by_part, strict=True))
    if choice.system.tangents > 1:
        q = cp.reshape(q, choice.system.slip_shape, order="F")
    open_slip = of_open_nodes[1] if of_open_nodes else None
    return Added([q, p, *of_open_nodes[:1]], open_slip, rows)


def _products(
    question: Question, r: Array, names: Sequence[str], chosen: cp.Variable, suffix: str
) -> list[cp.Expression]:
    """The terms of loads, with unknown amplitudes `chosen` (J,), in q and p.

    `r` (M, J) are their bonded reactions. If nodes are open, also the terms in the gaps and in the
    slips of these nodes.
    """
    n = question.system.nodes
    carried = question.carried(r.T).reshape(r.shape[::-1]).T
    effects = [carried[:-n], carried[-n:]]
    if question.compliance is not None:
        follow = -(question.compliance @ r)
        open_nodes = question.open_nodes
        open_slips = np.tile(open_nodes, question.system.tangents)
        effects += [follow[-n:][open_nodes], follow[:-n][open_slips]]
    return [
        constant(effect, name + suffix) @ chosen
        for effect, name in zip(effects, names, strict=False)
    ]
