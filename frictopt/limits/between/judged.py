"""A state and multipliers as a solution of the exact program, whose checks judge both."""

from __future__ import annotations

import numpy as np

from ...base import Array
from ...solve.rows import CONE, Rows
from ..program.question import Question
from ..program.rest_program import RestProgram
from ..program.solution import Solution
from .bounds import raised
from .cones import Cones, Point


def solution_of(program: RestProgram, cones: Cones, safe: Point, moves: Array) -> Solution:
    """The solution of the exact program, which evaluates it on stiffness, loads and contact law.

    The program has the rows of all corners. `moves` (K, t + 1, R) are the multipliers of the cones.
    """
    question = program.question
    unknowns = program.slips[0]
    slips = unknowns.elastic.slips
    x = np.zeros(program.width)
    x[program.place("load_factor").column] = safe.load_factor
    # The unknowns count from the state without friction.
    shear = safe.shear.ravel()[slips] * question.force + program.start[0, slips]
    x[unknowns.shear] = shear / unknowns.shear_units

    stacked = program.stacked
    of_cones = np.zeros((len(question.r1), *moves.shape[1:]))
    of_cones[cones.corners] = raised(moves)
    y = np.concatenate([_of_rows(rows, cones, of_cones, question) for rows in stacked.rows])
    return Solution(program, x, y * stacked.units, "load_factor")


def _of_rows(rows: Rows, cones: Cones, moves: Array, question: Question) -> Array:
    """Multipliers of some rows of the program, from those of the cones."""
    part = cones.labels.get(rows.label)
    if part is None or not len(rows.nodes):
        return np.zeros(len(rows.constants))
    place = part.start + np.searchsorted(cones.node[part], rows.nodes)
    slips, lifts = moves[rows.instants, :-1, place], moves[rows.instants, -1, place]
    if rows.label == "apart":
        return np.asarray(lifts / question.clearance)
    if rows.kind == CONE:
        return np.column_stack([lifts, slips]).ravel() / question.force
    # The first weights of a row in the plane are those of its shear, which has two rows.
    return np.asarray((lifts + rows.weights[0] * slips[:, 0]) / 2 / question.force)
