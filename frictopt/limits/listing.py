"""The printed problem of an answer: `models.py` with the values and multipliers of the answer.

The arrays of the solver never pass through cvxpy (`rest_program.py`). What is found with them is
put into the printed problem, where `problem.solve()` finds it again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import cvxpy as cp
import numpy as np

from ..base import Array
from ..contact import contact_law
from ..errors import ModelError
from ..solve.problem import Problem, set_no_optimum, set_optimal
from . import models
from .corner_statics import CornerQuestion
from .critical_state import CriticalState, NodeLoads
from .filled import fill
from .models import Row, Unknowns, constant, defines, rest, stuck, times, unknowns, vec, within
from .ordered_listing import ordered
from .question import Question, motion_of_open_nodes
from .solved import Solved

# A problem, and the values of its free unknowns.
Listed: TypeAlias = tuple[cp.Problem, dict[cp.Variable, Any]]


def state_rows(
    question: Question,
    x: Unknowns,
    f: cp.Parameter,
    corners: Sequence[int],
    friction: Any = stuck,
    more: models.More | None = None,
) -> list[Row]:
    """The rows of a state of rest at corners, without a goal; see `models.rest`.

    `friction` lists other rows in the place of `models.stuck`.
    """
    rows = rest(question, x, corners, more)
    rows += friction(x, f, corners, law=question.law)
    if question.slip_bound is not None:
        closed = None
        if question.open_nodes.any():
            of_axes = np.broadcast_to(~question.open_nodes, x.slip.shape[::-1]).T
            closed = constant(of_axes.astype(float), f"closed{x.suffix}")
        rows += within(x, constant(question.slip_bound, f"slip_bound{x.suffix}"), closed)
    return rows


def problem_of(
    solved: Solved, user_rows: Sequence[Row] = (), objective: cp.Expression | None = None
) -> cp.Problem:
    """The printed problem of a solved program, with its values and multipliers.

    `user_rows`, `objective`: those of the user, whose multipliers are in them already.
    """
    if solved.problem is not None:
        return solved.problem
    if solved.goal == "ordered":
        return ordered(solved)
    extended = bool(user_rows) or objective is not None or "user" in solved.values
    problem, values = _LISTED[solved.goal](solved, extended)
    goal = problem.objective if objective is None else cp.Maximize(objective)
    listed = problem.constraints
    problem = Problem(goal, [*listed, *user_rows])
    fill(problem, listed, solved, values)
    return problem


def _unknowns_of(solved: Solved, load_factor: Any = None) -> tuple[Unknowns, cp.Parameter]:
    """The unknowns of a problem and its friction."""
    question = solved.question
    shape = question.system.slip_shape
    x = solved.unknowns or unknowns(shape, range(len(question.r1)), load_factor)
    return x, models.friction(question.friction)


def _rows(
    question: Question, x: Unknowns, f: cp.Parameter, extended: bool, friction: Any = stuck
) -> list[Row]:
    """The rows of a state of rest; of all corners and all slips if there are rows of the user."""
    corners = [*x.q] if extended else question.listed_corners
    rows = state_rows(question, x, f, corners, friction)
    if extended and question.compliance is not None:
        rows += rest_rows(question, x)
    return rows


def _shakedown(solved: Solved, extended: bool) -> Listed:
    x, f = _unknowns_of(solved)
    problem = models.shakedown(x, _rows(solved.question, x, f, extended))
    return problem, {x.slip: solved.values["slip"], x.load_factor: solved.values["load_factor"]}


def rest_rows(question: Question, x: Unknowns, more: Any = 0) -> list[Row]:
    """Rows that set the slip of open nodes to their slip under the mean load.

    Rows of the user may contain this slip. It is `v0 + V slip`: the slip without slip of the closed
    nodes, and the part that follows them. `more`: terms due to unknown loads.
    """
    system = question.system
    opened = np.tile(question.open_nodes, system.tangents)  # (t N,)
    at_rest = question.slip_at_mean_load(np.zeros(system.slip_shape))
    v0 = at_rest.ravel(order="F")[opened]
    V = motion_of_open_nodes(
        system, question.open_nodes, question.compliance, np.flatnonzero(opened)
    )
    slip = vec(x.slip)
    v_r = cp.Variable(len(v0), name="v_r")
    chosen = constant(np.eye(len(opened))[opened], "open")
    follows = chosen @ slip == constant(v0, "v0") + v_r + more
    return [defines(v_r, constant(V, "V") @ slip), follows.set_label("open")]


def _safe_slip(solved: Solved, extended: bool) -> Listed:
    question = solved.question
    closed = ~question.open_nodes
    load_factor = cp.Parameter(nonneg=True, name="load_factor", value=solved.values["load_factor"])
    x, f = _unknowns_of(solved, load_factor)
    x.load_factor.value = solved.values["load_factor"]
    margin = x.margin or cp.Variable(name="margin")
    mean_bound = constant(question.mean_bound * closed, "mean_bound")
    mean_pressure = constant(question.mean_pressure * closed, "mean_pressure")

    def inside(x: Unknowns, f: cp.Parameter, corners: Sequence[int], law: Any) -> list[Row]:
        spare = dict.fromkeys(corners, times(margin, mean_bound))
        press = dict.fromkeys(corners, times(margin, mean_pressure))
        apart = times(margin, constant(question.clearance, "clearance"))
        return models.inside(x, f, corners, spare, press, apart)

    rows = _rows(question, x, f, extended, inside)
    values = {x.slip: solved.values["slip"], margin: solved.values["margin"]}
    return models.safe_slip(margin, rows), values


def _critical(solved: Solved, extended: bool) -> Listed:
    question = solved.question
    state = solved.values["state"]
    x, f = _unknowns_of(solved)
    rows = _rows(question, x, f, extended)
    problem = models.critical(x, state.node, *_critical_state(question, state, f), rows)
    return problem, {x.slip: solved.values["slip"], x.load_factor: solved.values["load_factor"]}


def _critical_state(
    question: Question, state: CriticalState, f: cp.Parameter
) -> tuple[list[Any], list[cp.Parameter]]:
    """Shear and pressure of the mean load at a critical node, and those that its cyclic loads need.

    They follow from the friction of the node. If the corners differ at load factor 0, so do those
    of the mean load.
    """
    loads = NodeLoads.of(question, state.node, state.corners)
    shape = () if len(state.rate) == 2 else (2,)
    mean = [
        constant(loads.q0[0, 0], f"q0[{state.node}]"),
        constant(loads.p0[0, 0], f"p0[{state.node}]"),
    ]
    if question.fixed:
        mean = [
            cp.CallbackParam(partial(_needed, loads, f, 0, part), name=name)
            for part, name in enumerate(("c0", "rho0"))
        ]
    shear = slice(0, 2) if shape else 0
    needed = [
        cp.CallbackParam(partial(_needed, loads, f, 1, shear), shape, name="c"),
        cp.CallbackParam(partial(_needed, loads, f, 1, -1), name="rho"),
    ]
    return mean, needed


def _needed(loads: NodeLoads, f: cp.Parameter, rate: int, part: Any) -> Any:
    """A part of the rate of the reactions that a slip adds, or minus a part at load factor 0."""
    return loads.added(_friction_of(loads, f))[rate][part] * (1.0 if rate else -1.0)


def _friction_of(loads: NodeLoads, f: cp.Parameter) -> float:
    """The friction of a critical node; ModelError if it has none."""
    friction = float(f.value[loads.node])
    if not friction > 0:
        raise ModelError(
            f"f: {friction:g} at node {loads.node}, but a node without friction is never critical; "
            "give it friction, or use guaranteed_limit"
        )
    return friction


_LISTED: dict[str, Callable[[Solved, bool], Listed]] = {
    "shakedown": _shakedown,
    "safe_slip": _safe_slip,
    "critical": _critical,
}


def corner_problem(asked: CornerQuestion, load_factor: float, forces: Array) -> cp.Problem:
    """The problem of a corner, with its load factor and the forces (M,) that balance it."""
    question = asked.question
    system = question.system
    name = f"r0[{asked.corner}]" if question.fixed else "r0"
    load = {name: asked.r0, f"r1[{asked.corner}]": asked.r1}
    f = models.friction(question.friction)
    law = contact_law(system, question.friction)
    problem = models.gross_slip(asked.N, load, f, law, system.slip_shape)
    if not np.isfinite(forces).all():
        set_no_optimum(problem, cp.INFEASIBLE if np.isnan(load_factor) else cp.UNBOUNDED)
        return problem
    n = system.nodes
    values = {
        "load_factor": np.array(load_factor),
        "q": forces[:-n].reshape(system.slip_shape, order="F"),
        "p": forces[-n:],
    }
    for variable in problem.variables():
        variable.save_value(values[variable.name()])
    set_optimal(problem)
    return problem
