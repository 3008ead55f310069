"""The printed problem of an order of events: the rows of all instants, at unknown places.

The load of an event lies at an unknown place of its leg. If only the scaled loads vary on a leg,
the unknown is the place times the load factor; if only fixed ones vary, it is the place. If both
vary, the problem is linear about the load factor and the place of the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import Array
from . import models
from .filled import fill
from .lift_off import LiftOff
from .models import Row, Unknowns, constant, times, unknowns, vec
from .ordered import About, Forces, LaterSlips, forces_of_order, is_scaled
from .question import Question
from .solved import Solved


def ordered(solved: Solved) -> cp.Problem:
    """The largest load factor of an order of events, or the largest margin at a given one."""
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
    friction = models.stuck if margin is None else _inside(question, margin)
    touching = {
        m: sorted(instant.switching)
        for m, instant in enumerate(question.at)
        if instant.event is not None
    }
    way = [cp.Variable(name=f"way[{m}]") for m in touching]
    more = {f"way{event}": place for event, place in enumerate(way)}
    if "later_slip" in values:
        more["later_slip"] = cp.Variable(values["later_slip"].shape, name="later_slip")

    # At a given load factor its product with a place is linear.
    places = [0.0] * len(way) if margin is not None else values["ways"].tolist()
    about = About(values["load_factor"], places)
    forces = forces_of_order(question, LaterSlips.of(question), None, about)
    parts = [*_parts(solved, x, partial(friction, f=f), forces, more)]
    shared = [
        *models.ordered(_ways_of_legs(question, way, x.load_factor)),
        *models.events(x, touching),
    ]
    listed = [row for rows, _ in parts for row in rows] + shared
    if margin is None:
        problem = models.shakedown(x, listed)
    else:
        problem = models.safe_slip(margin, listed)
    known = {variable.name(): variable for variable in problem.variables()}
    filled = {known[name]: value for name, value in values.items() if name in known}
    filled |= dict(zip(way, values["ways"], strict=True))
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
    """The rows of instants with the same open nodes and slips, and what is solved there."""
    question = solved.question
    assert isinstance(question, LiftOff)
    slip_shape = question.system.slip_shape
    for number, response in enumerate(forces.responses):
        instants = np.flatnonzero(forces.response_of == number).tolist()
        of_set = question.sets[instants[0]]
        A, B, W = of_set.parts(response)
        loads = {m: _loads(of_set, forces, m) for m in instants}
        terms = {m: _more(of_set, forces, m, more) for m in instants}
        contact = SimpleNamespace(A=A, B=B, W=W, loads=loads.__getitem__)
        suffix = f"_{number}" if number else ""
        own = replace(unknowns(slip_shape, (), x.load_factor, suffix), slip=x.slip, q=x.q, p=x.p)
        rows = models.rest(contact, own, instants, terms) + friction(own, corners=instants)
        moves = np.zeros_like(solved.moves)
        moves[instants] = solved.moves[instants]
        yield rows, replace(solved, question=of_set, moves=moves)


def _inside(question: LiftOff, margin: cp.Variable) -> partial[list[Row]]:
    """The friction rows with a margin. Nodes have no reserve at their events."""
    spare: dict[int, cp.Expression] = {}
    press: dict[int, cp.Expression] = {}
    for m, sticks in enumerate(question.statuses[0]):
        spare[m] = times(margin, constant(question.mean_bound * sticks, f"mean_bound[{m}]"))
        press[m] = times(margin, constant(question.mean_pressure * sticks, f"mean_pressure[{m}]"))
    apart = times(margin, constant(question.clearance, "clearance"))
    return partial(models.inside, spare=spare, press=press, apart=apart)


def _shaped(of_set: Question, forces: Array) -> dict[str, Array]:
    """Shear forces q, normal forces p and gaps w of forces (M,)."""
    q, p, w = of_set.parts(forces)
    return {"q": q.reshape(of_set.system.slip_shape, order="F"), "p": p, "w": w}


def _loads(of_set: Question, forces: Forces, m: int) -> dict[str, Array]:
    """The loads of an instant, in the order of `Question.loads`."""
    at_zero = _shaped(of_set, forces.start[m])
    rate = _shaped(of_set, forces.effects["load_factor"][m])
    loads = dict[str, Array]()
    for parts in ("qp", "w"):
        loads |= {f"{part}0[{m}]": at_zero[part] for part in parts}
        loads |= {f"{part}1[{m}]": rate[part] for part in parts}
    return loads


def _more(
    of_set: Question, forces: Forces, m: int, unknown: Mapping[str, cp.Variable]
) -> list[cp.Expression]:
    """The terms of q, p and gaps that the places of events and later slips add at an instant."""
    terms = dict[str, list[cp.Expression]]()
    for name, variable in unknown.items():
        effect = forces.effects[name][m]
        if not effect.any():
            continue
        if effect.ndim == 1:
            for part, value in _shaped(of_set, effect).items():
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


def _ways_of_legs(
    question: LiftOff, ways: Sequence[cp.Variable], load_factor: Any
) -> Iterator[tuple[list[cp.Variable], Any]]:
    """The unknown places of the events of each leg, and the place of its end."""
    on_legs = question.order.on_legs
    for leg in dict.fromkeys(on_legs):
        places = [place for place, of in zip(ways, on_legs, strict=True) if of == leg]
        yield places, load_factor if is_scaled(question, leg) else 1.0


def _multipliers_of_events(
    question: LiftOff, solved: Solved, touching: Mapping[int, Sequence[int]]
) -> dict[str, Array]:
    """Multipliers of the rows without force at events; the arrays have them by component."""
    multipliers = dict[str, Array]()
    for m, nodes in touching.items():
        by_axis = [
            solved.multipliers[f"event_q{axis}"][m][nodes]
            for axis in range(question.system.tangents)
        ]
        multipliers[f"event_q[{m}]"] = np.concatenate(by_axis)
        multipliers[f"event_p[{m}]"] = solved.multipliers["event_p"][m][nodes]
    return multipliers
