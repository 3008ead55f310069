"""The rows of the contact law as arrays: `|q| <= f p`, its further terms, `p >= 0`, and open gaps.

`models.stuck` and `models.inside` list the same rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import Array, Booleans, Integers
from ..solve.rows import CONE, EQUATION, LINEAR, Term
from .corners import ruling
from .question import Question
from .rest_program import RestProgram

# With more friction the rows `|q| <= f p` imply `p >= 0` to all digits.
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
    """Add the rows of the nodes that are closed, (K, N), and of those that are open, at instants.

    The question has the contact law and the units.

    With `reserve`, the unknown `margin` is the reserve of the rows of these nodes, (K, N), in the
    units of `SafeSlip`. `only_governing`: instants are corners that differ in the load factor
    alone, and in the plane a node needs rows only at corners that govern it at some load factor.
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
        at, nodes = np.nonzero(closed & np.isfinite(term.constant))
        for sign in (1.0, -1.0):
            terms = [
                (program.force(at, nodes), np.full(len(at), -sign)),
                (program.force(at, n + nodes), term.slope[nodes]),
            ]
            kept = np.ones(len(at), dtype=bool)
            if only_governing:
                kept = _governing(program, at, nodes, terms)
            if reserve is not None:
                terms.append(_reserve(program, mean_bound, reserve, at, nodes))
            terms = [(quantities[kept], weights[kept]) for quantities, weights in terms]
            of_nodes = nodes[kept]
            constant, unit = term.constant[of_nodes], question.shear_unit[of_nodes]
            program.add(term.row, LINEAR, [terms], constant, unit, at[kept], of_nodes)


def _space_friction(
    program: RestProgram, question: Question, closed: Booleans, reserve: Booleans | None
) -> None:
    n = question.system.nodes
    mean_bound = question.mean_bound
    for term in question.law.terms:
        has_term = closed & np.isfinite(term.constant)
        # A cone without room holds one point: its shear forces are zero.
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
            side = [(program.force(at, axis * n + nodes), np.ones(len(nodes)))]
            unit = question.shear_unit[nodes]
            program.add(term.row, EQUATION, [side], np.zeros(len(nodes)), unit, at, nodes)


def _normal(
    program: RestProgram,
    label: str,
    where: Booleans,
    unit: Array,
    margin_unit: Any,
    reserve: Booleans | None,
) -> None:
    """Normal forces or gaps are at least 0, or the reserve times the margin."""
    at, nodes = np.nonzero(where)
    normal = program.force(at, program.start.shape[1] - where.shape[1] + nodes)
    terms = [(normal, np.ones(len(nodes)))]
    if reserve is not None:
        terms.append(_reserve(program, margin_unit, reserve, at, nodes))
    program.add(label, LINEAR, [terms], np.zeros(len(nodes)), unit[nodes], at, nodes)


def _reserve(
    program: RestProgram, unit: Any, reserve: Booleans, at: Integers, nodes: Integers
) -> Term:
    """The term of the margin: its unit, one or (N,), if the rows have a reserve."""
    units = unit * reserve.astype(float)
    return np.full(len(nodes), program.unknown("margin")), -units[at, nodes]


def _governing(
    program: RestProgram, at: Integers, nodes: Integers, terms: Sequence[Term]
) -> Booleans:
    """Which rows govern their node at some load factor >= 0.

    The slip enters the rows of a node alike at all corners. So only the loads decide.
    """
    start = np.zeros(len(at))
    rate = np.zeros(len(at))
    for quantities, weights in terms:
        start += weights * program.start.ravel()[quantities]
        if "load_factor" in program.named:
            rate += weights * program.effects[quantities, program.named["load_factor"].start]
    # Grids of the instants and nodes that have rows: each of these nodes has as many.
    instants, of_instant = np.unique(at, return_inverse=True)
    with_rows, of_node = np.unique(nodes, return_inverse=True)
    needed = np.zeros((len(instants), len(with_rows)))
    rates = np.zeros_like(needed)
    needed[of_instant, of_node] = -start
    rates[of_instant, of_node] = -rate
    governs = np.zeros(needed.shape, dtype=bool)
    governs[ruling(needed, rates)] = True
    return np.asarray(governs[of_instant, of_node])
