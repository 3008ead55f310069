"""A safe point and multipliers as a slip and a mechanism, with the error of each proof."""

from __future__ import annotations

import numpy as np

from ...base import RESIDUAL, Array, SolveRecord, worst
from ...contact import ContactProducts
from ...errors import SolverError
from ..program.question import Question
from ..program.rest_program import elastic
from ..program.solution import Mechanism
from .cones import Cones, Point, without_gap
from .search import margins, raised


def judged(
    question: Question, cones: Cones, safe: Point, moves: Array
) -> tuple[float, Array, float, Mechanism, float, float]:
    """The slip of a safe point, and the mechanism of multipliers (K, t + 1, R) of the rows.

    Both proofs are evaluated by products of full precision. Returned are, in the units of the user,
    the load factor, its slip, and the largest violation of a row, relative to `Question.force`;
    then the mechanism, its bound, and the error of the bound, because the multipliers do not
    balance exactly.
    """
    load_factor = safe.load_factor * question.load_unit
    unsafe = -float(margins(cones.at(safe.load_factor, safe.shear).rows).min())

    moves = raised(moves)
    drive = -float((moves * cones.rate).sum())
    return (
        load_factor,
        slip_of(question, safe.shear),
        unsafe,
        mechanism_of(question, cones, moves / drive),
        float((moves * cones.start).sum()) / drive * question.load_unit,
        work_of_stress(cones, moves, safe.shear) / drive * question.load_unit,
    )


def work_of_stress(cones: Cones, moves: Array, shear: Array) -> float:
    """The work that multipliers do because they do not balance exactly.

    Their stress does this work on residual shear of the size of the given `shear` (t, N) or, if
    this is smaller, of the unit.
    """
    return float((np.abs(cones.stress(moves)) * np.maximum(np.abs(shear), 1.0)).sum())


def record_of(question: Question, load_factor: float, slip: Array, error: float) -> SolveRecord:
    """The record of two proofs with this error; SolverError if rounding hides one of them."""
    residual = worst([error])
    if not isinstance(question.system, ContactProducts):
        # The stiffness shows an error of the products.
        residual = worst([error, question.violation(load_factor, slip)])
    if not residual <= RESIDUAL:
        raise SolverError(
            f"gap: rounding leaves an error of {residual:.1e} in the slip or in the mechanism "
            f"(tolerance {RESIDUAL:g}); {without_gap(question.system)}"
        )
    return SolveRecord("primal-dual hybrid gradient", residual=residual)


def slip_of(question: Question, shear: Array) -> Array:
    """(N,) or (N, 2) slip of all nodes that causes residual shear (t, N)."""
    parts = elastic(question)
    slip = np.zeros(shear.size)
    slip[parts.slips] = parts.compliance @ (question.force * shear.ravel()[parts.slips])
    return question.slip_at_mean_load(slip.reshape(question.system.slip_shape, order="F"))


def mechanism_of(question: Question, cones: Cones, moves: Array) -> Mechanism:
    """The mechanism of multipliers (K, t + 1, R) of the rows."""
    # Moves of the forces, and of the gaps of open nodes, by those of the rows.
    by_node = np.zeros_like(question.r1)
    unit = np.where(question.open_nodes, question.clearance, question.force)[cones.node]
    for corner, of_rows in zip(cones.corners, moves * question.load_unit / unit, strict=True):
        for axis, part in enumerate(of_rows):
            weight = cones.slope if axis == len(of_rows) - 1 else cones.sheared
            by_node[corner, axis] = np.bincount(cones.node, weight * part, by_node.shape[-1])
    return Mechanism.of(question, by_node.reshape(len(by_node), -1))
