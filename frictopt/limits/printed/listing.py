"""The printed problem of an answer: `models.py` with the values and multipliers of the answer.

The arrays of the solver never pass through cvxpy (`rest_program.py`). The answer that the solver
finds is put into the printed problem, and `problem.solve()` then finds the same answer by cvxpy.

In the problem of an order of events, the load of an event lies at an unknown place of its segment.
If only the scaled loads vary on the segment, the unknown is the place times the load factor. If
only fixed loads vary, the unknown is the place. If both vary, the problem is linearised about the
load factor and the place of the answer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np

from ...base import Array
from ...solve.problem import Problem, set_no_optimum, set_optimal
from ...solve.solvers import OPTIMAL
from ..balance.statics import CornerQuestion
from ..events.lift_off import LiftOff
from ..events.ordered import About, Forces, forces_of_order, is_scaled
from ..program.question import Question
from ..program.solution import Solved
from . import models
from .models import Row, Unknowns, constant, defines, rest, stuck, times, unknowns, vec, within

# The label of an equation that all corners share: q_r, p_r and w_r.
_OF_ALL_CORNERS = re.compile(r"([qpw])_r(?:_\d+)?")

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
            # An equation that defines an unknown has the name of the unknown.
            if len(defined) == 1 and defined[0].name() == row.label:
                value = np.reshape(row.args[1].value, defined[0].shape, order="F")
                defined[0].save_value(value)
        set_optimal(problem)
    else:
        set_no_optimum(problem, solved.status)


def _fill_row(row: Row, solved: Solved) -> None:
    """Put the multipliers of a row into it, by its label."""
    value = _multipliers(row.label, solved)
    if value is None:
        return
    shape = row.dual_variables[0].shape
    row.save_dual_value(np.reshape(value, shape, order="F"))


def _multipliers(name: str, solved: Solved) -> Any:
    """The multipliers of a row of `models.py`, in column order; None if no row has the name."""
    if name in solved.multipliers:
        return solved.multipliers[name]
    question = solved.question
    parts = dict(zip(("q", "p", "gap"), question.parts(solved.moves.T), strict=True))
    total = _OF_ALL_CORNERS.fullmatch(name)
    if total is not None:
        return parts[{"w": "gap"}.get(total[1], total[1])].sum(axis=1)
    match = _OF_CORNER.fullmatch(name)
    if match is None:
        return None
    kind, corner = match[1], int(match[2])
    if kind in parts:
        return parts[kind][:, corner]
    # Rows that other rows imply have no multipliers.
    by_node = solved.multipliers.get(kind, np.zeros_like(parts["p"].T))[corner]
    for term in question.law.terms:
        if term.row == kind:
            return by_node[term.nodes]
    return by_node[question.open_nodes] if kind == "apart" else by_node


def ordered(solved: Solved) -> cp.Problem:
    """The problem of an order of events: the largest load factor, or the margin at a given one."""
    question = solved.question
    assert isinstance(question, LiftOff)
    values = solved.values
    slip_shape = question.system.slip_shape
    margin = cp.Variable(name="margin") if "margin" in values else None
    given = None
    if margin is not None:
        given = cp.Constant(values["load_factor"], name="load_factor")
    x = unknowns(slip_shape, range(len(question.sets)), given)
    f = models.friction(question.friction)
    friction = partial(stuck, law=question.law)
    if margin is not None:
        friction = _inside(question, margin)
    touching = {
        m: sorted(instant.switching)
        for m, instant in enumerate(question.at)
        if instant.event is not None
    }
    way = [cp.Variable(name=f"way[{m}]") for m in touching]
    more = {f"way{event}": place for event, place in enumerate(way)}
    if "later_slip" in values:
        more["later_slip"] = cp.Variable(values["later_slip"].shape, name="later_slip")

    # If the load factor is given, its product with a place is linear.
    places = [0.0] * len(way) if margin is not None else values["ways"].tolist()
    about = About(values["load_factor"], places)
    forces = forces_of_order(question, None, about)
    parts = [*_parts(solved, x, partial(friction, f=f), forces, more)]
    shared = [
        *models.ordered(_ways_of_segments(question, way, x.load_factor)),
        *models.events(x, touching),
    ]
    listed = [row for rows, _ in parts for row in rows] + shared
    if margin is None:
        problem = models.shakedown(x, listed)
    else:
        problem = models.safe_slip(margin, listed)
    filled = _values_by_name(problem, values) | dict(zip(way, values["ways"], strict=True))
    on_events = _multipliers_of_events(question, solved, touching)
    whole = replace(solved, multipliers={**solved.multipliers, **on_events})
    fill(problem, [*shared, problem.constraints[-1]], whole, filled)
    for rows, part in parts:
        fill(problem, rows, part, {})
    return problem


def _parts(
    solved: Solved,
    x: Unknowns,
    friction: Callable[..., list[Row]],
    forces: Forces,
    more: Mapping[str, cp.Variable],
) -> Iterator[tuple[list[Row], Solved]]:
    """For each set of open nodes, the rows of its instants and the multipliers of these rows."""
    question = solved.question
    assert isinstance(question, LiftOff)
    slip_shape = question.system.slip_shape
    for number, response in enumerate(forces.responses):
        instants = np.flatnonzero(forces.response_of == number).tolist()
        of_set = question.sets[instants[0]]
        A, B, W = of_set.parts(response)
        rate = forces.effects["load_factor"]
        loads = {
            m: of_set.named_loads((forces.start[m], f"[{m}]"), (rate[m], f"[{m}]"))
            for m in instants
        }
        terms = {m: _more(of_set, forces, m, more) for m in instants}
        contact = SimpleNamespace(A=A, B=B, W=W, loads=loads.__getitem__)
        suffix = f"_{number}" if number else ""
        own = replace(unknowns(slip_shape, (), x.load_factor, suffix), slip=x.slip, q=x.q, p=x.p)
        rows = models.rest(contact, own, instants, terms) + friction(own, corners=instants)
        moves = np.zeros_like(solved.moves)
        moves[instants] = solved.moves[instants]
        yield rows, replace(solved, question=of_set, moves=moves)


def _inside(question: Question, margin: cp.Variable) -> partial[list[Row]]:
    """The friction rows with a margin. Nodes have no reserve at their events or while open."""
    sticks = question.statuses[0]
    spare: dict[int, cp.Expression] = {}
    press: dict[int, cp.Expression] = {}
    for k in range(len(question.names)):
        suffix = f"[{k}]" if isinstance(question, LiftOff) else ""
        has_reserve = sticks[k % len(sticks)]
        bound, pressure = question.mean_bound * has_reserve, question.mean_pressure * has_reserve
        spare[k] = times(margin, constant(bound, f"mean_bound{suffix}"))
        press[k] = times(margin, constant(pressure, f"mean_pressure{suffix}"))
    apart = times(margin, constant(question.clearance, "clearance"))
    return partial(models.inside, spare=spare, press=press, apart=apart)


def _more(
    of_set: Question, forces: Forces, m: int, unknown: Mapping[str, cp.Variable]
) -> list[cp.Expression]:
    """The terms of q, p and gaps at an instant that depend on places of events or later slips."""
    terms = dict[str, list[cp.Expression]]()
    for name, variable in unknown.items():
        effect = forces.effects[name][m]
        if not effect.any():
            continue
        if effect.ndim == 1:
            for part, value in of_set.shaped(effect).items():
                change = times(variable, constant(value, f"d{part}[{m}]"))
                terms.setdefault(part, []).append(change)
            continue
        for part, matrix in zip("qpw", of_set.parts(effect), strict=True):
            if len(matrix):
                due = constant(matrix, f"d{part}_later[{m}]") @ vec(variable)
                if part == "q" and of_set.system.tangents > 1:
                    due = cp.reshape(due, of_set.system.slip_shape, order="F")
                terms.setdefault(part, []).append(due)
    return [sum(each[1:], each[0]) for each in terms.values()]


def _ways_of_segments(
    question: LiftOff, ways: Sequence[cp.Variable], load_factor: Any
) -> Iterator[tuple[list[cp.Variable], Any]]:
    """For each segment, the unknown places of its events, and the place of its end."""
    on_segments = question.order.on_segments
    for segment in dict.fromkeys(on_segments):
        places = [place for place, of in zip(ways, on_segments, strict=True) if of == segment]
        yield places, load_factor if is_scaled(question, segment) else 1.0


def _multipliers_of_events(
    question: LiftOff, solved: Solved, touching: Mapping[int, Sequence[int]]
) -> dict[str, Array]:
    """Multipliers of the rows that set the forces of nodes to zero at their events.

    The solved program has them by component; a printed row has all components of a force.
    """
    multipliers = dict[str, Array]()
    for m, nodes in touching.items():
        by_axis = [
            solved.multipliers[f"event_q{axis}"][m][nodes]
            for axis in range(question.system.tangents)
        ]
        multipliers[f"event_q[{m}]"] = np.concatenate(by_axis)
        multipliers[f"event_p[{m}]"] = solved.multipliers["event_p"][m][nodes]
    return multipliers


def _values_by_name(problem: cp.Problem, values: Mapping[str, Any]) -> dict[cp.Variable, Any]:
    """The variables of a problem that have one of these names, with their values."""
    return {
        variable: values[variable.name()]
        for variable in problem.variables()
        if variable.name() in values
    }


def state_rows(
    question: Question,
    x: Unknowns,
    f: cp.Parameter,
    corners: Sequence[int],
    friction: Any = None,
    more: models.More | None = None,
) -> list[Row]:
    """The rows of a state of rest at corners, without a goal; see `models.rest`.

    `friction` lists other rows in place of `models.stuck`.
    """
    rows = rest(question, x, corners, more)
    rows += (friction or partial(stuck, law=question.law))(x, f, corners)
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

    `user_rows` and `objective` come from the user; the rows already have their multipliers.
    """
    if solved.problem is not None:
        return solved.problem
    if solved.goal == "ordered":
        return ordered(solved)
    extended = bool(user_rows) or objective is not None or "user" in solved.values
    problem = _LISTED[solved.goal](solved, extended)
    values = _values_by_name(problem, solved.values)
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
    question: Question, x: Unknowns, f: Any, extended: bool, friction: Any = None
) -> list[Row]:
    """The rows of a state of rest.

    If `extended` by rows of the user, the rows cover all corners and all slips.
    """
    corners = [*x.q] if extended else question.listed_corners
    rows = state_rows(question, x, f, corners, friction)
    if extended and question.compliance is not None:
        rows += rest_rows(question, x)
    return rows


def _shakedown(solved: Solved, extended: bool) -> Problem:
    x, f = _unknowns_of(solved)
    return models.shakedown(x, _rows(solved.question, x, f, extended))


def rest_rows(question: Question, x: Unknowns, more: Any = 0) -> list[Row]:
    """Rows that set the slip of open nodes to their slip under the mean load.

    Rows of the user may contain this slip. It is `v0 + V slip`. v0 is the slip of the open nodes
    while the closed nodes do not slip, and `V slip` is what the slip of the closed nodes adds.
    `more`: terms due to unknown loads.
    """
    system = question.system
    opened = np.tile(question.open_nodes, system.tangents)  # (t N,)
    at_rest = question.slip_at_mean_load(np.zeros(system.slip_shape))
    v0 = at_rest.ravel(order="F")[opened]
    V = question.motions_of_open(np.flatnonzero(opened))
    slip = vec(x.slip)
    v_r = cp.Variable(len(v0), name="v_r")
    chosen = constant(np.eye(len(opened))[opened], "open")
    follows = chosen @ slip == constant(v0, "v0") + v_r + more
    return [defines(v_r, constant(V, "V") @ slip), follows.set_label("open")]


def _safe_slip(solved: Solved, extended: bool) -> Problem:
    question = solved.question
    load_factor = cp.Parameter(nonneg=True, name="load_factor", value=solved.values["load_factor"])
    x, f = _unknowns_of(solved, load_factor)
    margin = cp.Variable(name="margin")
    return models.safe_slip(margin, _rows(question, x, f, extended, _inside(question, margin)))


def _critical(solved: Solved, extended: bool) -> Problem:
    question = solved.question
    state = solved.values["state"]
    # Friction is no parameter, because the reactions that the node needs depend on it.
    x, _ = _unknowns_of(solved)
    rows = _rows(question, x, constant(question.friction, "f"), extended)
    names = ("c0", "rho0") if question.fixed else (f"q0[{state.node}]", f"p0[{state.node}]")
    load = _shear_and_pressure(-state.at_zero, names)
    needed = _shear_and_pressure(state.rate, ("c", "rho"))
    return models.critical(x, state.node, load, needed, rows)


def _shear_and_pressure(reactions: Array, names: Sequence[str]) -> list[cp.Constant]:
    """The reactions (t + 1,) of a node as constants of these names."""
    *shear, pressure = reactions
    return [
        constant(np.array(shear) if len(shear) > 1 else shear[0], names[0]),
        constant(pressure, names[1]),
    ]


_LISTED: dict[str, Callable[[Solved, bool], Problem]] = {
    "shakedown": _shakedown,
    "safe_slip": _safe_slip,
    "critical": _critical,
}


def corner_problem(asked: CornerQuestion, load_factor: float, forces: Array) -> cp.Problem:
    """The problem of a corner, with its load factor and the forces (M,) that balance its load."""
    question = asked.question
    system = question.system
    name = f"r0[{asked.corner}]" if question.fixed else "r0"
    load = {name: asked.r0, f"r1[{asked.corner}]": asked.r1}
    f = models.friction(question.friction)
    problem = models.gross_slip(asked.N, load, f, question.law, system.slip_shape)
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
