"""The programs of questions as arrays, and the rows that they share.

A program is a `RestProgram`; its goal is the largest or least value of one of its named unknowns.
`at_corners` begins a program. `law_rows` adds the rows of the contact law: `|q| <= f p`, its
further terms, `p >= 0`, gaps of open nodes; `stuck` adds them at the corners. `within_slip_bound`
adds the slip bound. `printed/models.py` lists most programs for readers:

================================================  ================================================
program as arrays                                 listing in `models.py`
================================================  ================================================
`shakedown`                                       `shakedown` with the rows `stuck`
`safe_slip`                                       `safe_slip` with the rows `inside`
`critical` in `guarantee/critical_search.py`      `critical` with the rows `stuck`
`ordered_program` in `events/ordered.py`          `shakedown` or `safe_slip` with the rows
                                                  `ordered` and `events`
`design_program` in `best_design/program.py`      `shakedown` with the rows of all scenarios
`corner_answer` in `balance/statics.py`           `gross_slip`
================================================  ================================================

`wedging`, `most_pressed`, and the programs of loose nodes and of fatigue parameters (`search`) have
no listing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...base import Array, Booleans, Integers
from ...solve.arrays import CONE, LINEAR, Term
from .question import Question, ruling
from .rest_program import RestProgram

# Above this friction the rows `|q| <= f p` imply `p >= 0` to all digits.
_LOW_FRICTION = 0.01


def law_rows(
    program: RestProgram,
    question: Question,
    closed: Booleans,
    opened: Booleans,
    *,
    reserve: Booleans | None = None,
    only_governing: bool = False,
) -> None:
    """Add rows of the contact law: `closed` and `opened` are masks (K, N) of nodes at instants.

    `question` gives the contact law and the units.

    `reserve`: a mask (K, N) of rows that must hold with a reserve. The unknown `margin` is this
    reserve, in the units of `SafeSlip`. `only_governing`: the instants are corners whose forces
    differ by the loads alone. In the plane a node then has rows only at the corners that govern it
    at some load factor.
    """
    if question.system.tangents == 1:
        _plane_friction(program, question, closed, reserve, only_governing)
    else:
        _space_friction(program, question, closed, reserve)
    low = closed & (question.friction < _LOW_FRICTION)
    _normal(program, "pressed", low, question.node_unit, question.mean_pressure, reserve)
    clearance = np.full(question.system.nodes, question.clearance)
    _normal(program, "apart", opened, clearance, clearance, reserve)


def _plane_friction(
    program: RestProgram,
    question: Question,
    closed: Booleans,
    reserve: Booleans | None,
    only_governing: bool,
) -> None:
    n = question.system.nodes
    mean_bound = question.mean_bound
    for term in question.law.terms:
        rows = closed & np.isfinite(term.constant)
        by_sign = rows, rows
        if only_governing:
            by_sign = _governing(program, rows, term.slope)
        for sign, of_sign in zip((1.0, -1.0), by_sign, strict=True):
            at, nodes = np.nonzero(of_sign)
            terms = [
                (program.force(at, nodes), np.full(len(at), -sign)),
                (program.force(at, n + nodes), term.slope[nodes]),
            ]
            if reserve is not None:
                terms.append(_reserve(program, mean_bound, reserve, at, nodes))
            constant, unit = term.constant[nodes], question.shear_unit[nodes]
            program.add(term.row, LINEAR, [terms], constant, unit, at, nodes)


def _space_friction(
    program: RestProgram, question: Question, closed: Booleans, reserve: Booleans | None
) -> None:
    n = question.system.nodes
    mean_bound = question.mean_bound
    for term in question.law.terms:
        has_term = closed & np.isfinite(term.constant)
        # If the law allows no shear force, the cone is a single point, and equations take its
        # place.
        room = has_term & ((term.slope > 0) | (term.constant > 0) | (reserve is not None))
        at, nodes = np.nonzero(room)
        ones = np.ones(len(nodes))
        head = [(program.force(at, 2 * n + nodes), term.slope[nodes])]
        if reserve is not None:
            head.append(_reserve(program, mean_bound, reserve, at, nodes))
        sides = [[(program.force(at, axis * n + nodes), ones)] for axis in (0, 1)]
        unit = question.shear_unit[nodes]
        parts = [head, *sides]
        program.add(term.row, CONE, parts, term.constant[nodes], unit, at, nodes)
        at, nodes = np.nonzero(has_term & ~room)
        for axis in (0, 1):
            program.no_force(term.row, axis, at, nodes, question.shear_unit)


def _normal(
    program: RestProgram,
    label: str,
    where: Booleans,
    unit: Array,
    margin_unit: Any,
    reserve: Booleans | None,
) -> None:
    """Normal forces or gaps are at least 0; with a reserve, at least the margin times its unit."""
    if not where.any():
        return
    at, nodes = np.nonzero(where)
    normal = program.force(at, program.start.shape[1] - where.shape[1] + nodes)
    terms = [(normal, np.ones(len(nodes)))]
    if reserve is not None:
        terms.append(_reserve(program, margin_unit, reserve, at, nodes))
    program.add(label, LINEAR, [terms], np.zeros(len(nodes)), unit[nodes], at, nodes)


def _reserve(
    program: RestProgram, unit: Any, reserve: Booleans, at: Integers, nodes: Integers
) -> Term:
    """The term `-unit margin` of rows with a reserve, else 0; `unit` is one number or (N,)."""
    units = unit * reserve.astype(float)
    return np.full(len(nodes), program.unknown("margin")), -units[at, nodes]


def _governing(program: RestProgram, rows: Booleans, slope: Array) -> tuple[Booleans, Booleans]:
    """Masks (K, N) of the rows `q <= slope p` and `-q <= slope p` that govern at some load factor.

    Load factors are at least 0. The slip enters the rows of a node alike at all corners, so only
    the loads decide which rows govern. All nodes with rows have them at the same corners.
    """
    corners = rows.any(axis=1)
    rate = np.zeros_like(program.start)
    if "load_factor" in program.named:
        rate = program.effects[:, program.named["load_factor"]].reshape(rate.shape)
    shear, normal = np.split(np.stack([program.start, rate])[:, corners], 2, axis=2)
    needed = np.concatenate([shear - slope * normal, -shear - slope * normal], axis=2)
    governs = np.hstack([rows, rows])
    governs[corners] &= ruling(*needed)
    return governs[:, : rows.shape[1]], governs[:, rows.shape[1] :]


def at_corners(
    question: Question,
    load_factor: float | None = None,
    units: Mapping[str, Any] | None = None,
    effects: Mapping[str, Array] | None = None,
    residual: bool = False,
) -> RestProgram:
    """The program at the corners of a load cycle, without the rows of the contact law.

    `load_factor`: the given load factor. If it is None, the load factor is a named unknown and the
    goal, with the row `load_factor >= 0`. If the question has a slip bound, its rows are added.
    `units` and `effects` belong to further named unknowns. With `residual`, one more instant comes
    last, at which the slip alone causes the forces.
    """
    rate = question.rate
    start = question.start
    all_units = dict(units or {})
    all_effects = dict(effects or {})
    if load_factor is None:
        all_units["load_factor"] = question.load_unit
        all_effects["load_factor"] = rate
    else:
        start = start + load_factor * rate
    if residual:
        start = np.vstack([start, np.zeros_like(start[:1])])
        all_effects = {
            name: np.concatenate([effect, np.zeros_like(effect[:1])])
            for name, effect in all_effects.items()
        }
    program = RestProgram([question], all_units, start, all_effects)
    if load_factor is None:
        program.goal = "load_factor"
        program.row("load_factor", {"load_factor": 1.0})
    within_slip_bound(program)
    return program


def stuck(
    program: RestProgram, margin: bool = False, but: int = -1, every: bool = False
) -> RestProgram:
    """Add the rows of the contact law at the corners, and return the program.

    `models.stuck` lists the same rows. With `margin` all rows have a reserve, as in
    `models.inside`. The node `but` has no rows, because the equations of its critical state imply
    them. `every`: all corners have rows, even corners within the hull of the other corners, because
    their forces differ by more than the loads.
    """
    question = program.question
    corners = np.zeros(len(program.start), dtype=bool)
    corners[slice(None) if every else question.listed_corners] = True
    listed = corners[:, None] & (np.arange(question.system.nodes) != but)
    closed = listed & ~question.open_nodes
    opened = listed & question.open_nodes
    reserve = listed if margin else None
    law_rows(
        program,
        question,
        closed,
        opened,
        reserve=reserve,
        only_governing=question.simplify and not every,
    )
    return program


def shakedown(question: Question) -> RestProgram:
    """The program of the load factors of states of rest; its goal is the largest or the least."""
    return stuck(at_corners(question))


def safe_slip(question: Question, load_factor: float) -> RestProgram:
    """The program of slips at a load factor; its goal is the largest `margin`, at most 1.

    The margin is the reserve in all rows.
    """
    program = stuck(at_corners(question, load_factor, {"margin": 1.0}), margin=True)
    program.row("cap", {"margin": -1.0}, 1.0)
    return program


def wedging(question: Question) -> RestProgram:
    """The program of slips that obey the contact law without any load; its goal is `wedge`.

    Two bounds limit `wedge`: 1, and the sum of the normal forces divided by the mean normal force.
    The largest value of `wedge` is 1 if friction wedges: then residual slips may press the contact
    without end.
    """
    n = question.system.nodes
    program = RestProgram([question], {"wedge": 1.0}, np.zeros((1, len(question.S))), {})
    closed = ~question.open_nodes[None]
    law_rows(program, question, closed, ~closed)
    nodes = np.flatnonzero(closed[0])
    first = program.start.shape[1] - n
    pressures = [(program.force(0, first + nodes[[i]]), np.ones(1)) for i in range(len(nodes))]
    wedge = np.array([program.unknown("wedge")]), np.full(1, -question.force)
    program.add("mean", LINEAR, [[*pressures, wedge]], np.zeros(1), np.array([question.force]))
    program.row("cap", {"wedge": -1.0}, 1.0)
    return program


def most_pressed(question: Question, load_factor: float) -> RestProgram:
    """The program of slips that friction need not bound; its goal is the largest `margin`.

    The margin is the least normal force over nodes and corners, divided by the mean normal force,
    and at most 1. All nodes are closed.
    """
    program = at_corners(question, load_factor, {"margin": 1.0})
    everywhere = np.ones((len(program.start), question.system.nodes), dtype=bool)
    force = np.full(question.system.nodes, question.force)
    _normal(program, "pressed", everywhere, force, force, everywhere)
    program.row("cap", {"margin": -1.0}, 1.0)
    return program


def within_slip_bound(program: RestProgram, number: int = 0) -> None:
    """Add the rows `|slip| <= slip_bound` of closed nodes for one slip, if it has a bound.

    `number`: the index of the slip and of its question.
    """
    question = program.questions[number]
    slip_bound = question.slip_bound
    if slip_bound is None:
        return
    n = question.system.nodes
    first = program.first_slip + number * n * question.system.tangents
    nodes = np.flatnonzero(~question.open_nodes)
    slips = [first + axis * n + nodes for axis in range(question.system.tangents)]
    bound = slip_bound[nodes]
    own = question.shear_unit / question.system.own_stiffness[:n]
    unit = np.where(bound > 0, bound, own[nodes])
    ones = np.ones(len(nodes))
    label = f"slip_bound_{number}" if number else "slip_bound"
    if question.system.tangents == 1:
        for sign in (1.0, -1.0):
            side = [(slips[0], -sign * ones)]
            program.add(label, LINEAR, [side], bound, unit, None, nodes)
    else:
        sides = [[(slip, ones)] for slip in slips]
        program.add(label, CONE, [[], *sides], bound, unit, None, nodes)
