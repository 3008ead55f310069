"""The programs of questions as arrays, in the order of `models.py`, which lists them for readers.

Each returns a `RestProgram` with its rows; its goal is the largest or least value of one of its
named unknowns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..base import Array, Integers
from ..solve.rows import CONE, EQUATION, LINEAR
from .critical_state import CriticalState
from .law_rows import law_rows
from .loose_nodes import own_motions
from .question import Question
from .rest_program import RestProgram


def at_corners(
    question: Question,
    load_factor: float | None = None,
    units: Mapping[str, Any] | None = None,
    effects: Mapping[str, Array] | None = None,
    residual: bool = False,
) -> RestProgram:
    """The program at the corners of a load cycle, without rows but the slip bound.

    `load_factor`: the given one; None: it is a named unknown, which is at least 0. `units` and
    `effects` belong to further named unknowns. With `residual`, a further instant holds the forces
    of the slip alone.
    """
    rate = question.rate
    start = np.broadcast_to(question.start, rate.shape)
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
        program.row("load_factor", {"load_factor": 1.0})
    within_slip_bound(program)
    return program


def stuck(
    program: RestProgram, margin: bool = False, but: int = -1, every: bool = False
) -> RestProgram:
    """Add the rows of the contact law at the corners, see `models.stuck` and `models.inside`.

    The rows of the node `but` are left out, because others imply them. `every`: forces at the
    corners differ in more than the loads, so that each corner has rows.
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
    """The load factors of states of rest, for their largest or least value."""
    return stuck(at_corners(question))


def loose(question: Question, nodes: Integers) -> RestProgram:
    """The load factors of states of rest in which some nodes are neither open nor closed.

    The slip has no bound, because open nodes do not have it.
    """
    slips = np.zeros(len(question.r1), dtype=int)
    program = at_corners(
        replace(question, slip_bound=None), None, *own_motions([question], slips, nodes)
    )
    return stuck(program, every=True)


def safe_slip(question: Question, load_factor: float) -> RestProgram:
    """The slips at a load factor with a reserve in all rows, for the largest `margin`."""
    program = stuck(at_corners(question, load_factor, {"margin": 1.0}), margin=True)
    program.row("cap", {"margin": -1.0}, 1.0)
    return program


def critical(question: Question, state: CriticalState) -> RestProgram:
    """The load factors at which a safe slip makes a node critical, for the least or largest one.

    The slip adds the reactions `at_zero + load_factor rate` of the state. The rows of the node hold
    then, unless a part of the cycle is fixed.
    """
    node = state.node
    program = stuck(at_corners(question, residual=True), but=-1 if question.fixed else node)
    n = question.system.nodes
    axes = len(state.rate)
    instant = np.array([len(program.start) - 1])
    load_factor = np.array([program.unknown("load_factor")])
    for axis in range(axes):
        force = program.force(instant, np.array([axis * n + node])), np.ones(1)
        needed = load_factor, -state.rate[[axis]]
        label = "critical_q" if axis < axes - 1 else "critical_p"
        unit = question.node_unit[[node]]
        constant = -state.at_zero[[axis]]
        program.add(label, EQUATION, [[force, needed]], constant, unit)
    return program


def furthest(question: Question, load_factor: float) -> RestProgram:
    """The safe slips at a load factor; `program.with_cost` of their residual shear forces."""
    return stuck(at_corners(question, load_factor))


def most_pressed(question: Question, load_factor: float) -> RestProgram:
    """Slips with the `least` normal force over nodes and corners, in mean forces; no friction."""
    program = at_corners(question, load_factor, {"least": 1.0})
    n = question.system.nodes
    corner, nodes = np.nonzero(np.ones((len(program.start), n), dtype=bool))
    pressure = program.force(corner, program.start.shape[1] - n + nodes), np.ones(len(nodes))
    least = np.full(len(nodes), program.unknown("least")), np.full(len(nodes), -question.force)
    unit = np.full(len(nodes), question.force)
    constant = np.zeros(len(nodes))
    program.add("pressed", LINEAR, [[pressure, least]], constant, unit, corner, nodes)
    program.row("cap", {"least": -1.0}, 1.0)
    return program


def least_pressure(question: Question, node: int, load_factor: float) -> RestProgram:
    """The least normal force, `pressure`, of a node over all safe slips and loads.

    The loads are those of the mean plus `shares` of the corners, which are >= 0 and add up to at
    most the load factor.
    """
    n = question.system.nodes
    count = len(question.r1)
    units = {"pressure": question.force, "shares": np.full(count, question.load_unit)}
    effects = {"shares": question.rate.T[None]}
    program = RestProgram([question], units, question.start[:1], effects)
    closed = np.ones((1, n), dtype=bool)
    law_rows(program, question, closed, ~closed)
    not_negative = [(program.unknown("shares") + np.arange(count), np.ones(count))]
    program.add("share", LINEAR, [not_negative], np.zeros(count), units["shares"])
    program.row("shares", {"shares": -np.ones(count)}, load_factor)
    at_node = program.force(np.zeros(1, dtype=int), np.array([program.start.shape[1] - n + node]))
    pressure = np.array([program.unknown("pressure")])
    least = [(pressure, np.ones(1)), (at_node, -np.ones(1))]
    force = np.array([question.force])
    program.add("least", LINEAR, [least], np.zeros(1), force)
    return program


def within_slip_bound(program: RestProgram, number: int = 0) -> None:
    """The rows `|slip| <= slip_bound` of the closed nodes, for the slip of this number."""
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
