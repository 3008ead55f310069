"""The largest or least load factor at which contact forces balance one corner of a load cycle.

Forces within friction have to do the work of the loads in all rigid motions of the bodies. If no
larger load factor has such forces, the multipliers of this balance are a rigid motion that proves
it: contact forces cannot do negative work on this motion, but a larger load would need such work.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...base import CONDENSATION, FLOOR, ZERO_LOAD_FACTOR, Array, SolveRecord, kept, worst
from ...contact import contact_law
from ...solve.answer import answer, without_optimum
from ...solve.arrays import LINEAR, Arrays, Rows, program_of, rows_of
from ...transients.balance import balance_rows, force_rows
from ..program.question import Question


@kept
@dataclass(frozen=True, eq=False)
class CornerQuestion:
    """The largest (sense 1) or least load factor at which contact forces balance a corner.

    N (M, m) are rigid motions, r0 (M,) the reactions of the corner at load factor 0, and r1 (M,)
    the reactions that a load factor of 1 adds.
    """

    question: Question
    N: Array
    corner: int
    r0: Array
    r1: Array
    sense: float


@dataclass(frozen=True, eq=False)
class CornerAnswer:
    """A load factor of a corner, its bound, and the motion phi (M,) of size 1 that proves it.

    The load factor is NaN if none has forces that balance the load.
    """

    asked: CornerQuestion
    load_factor: float
    bound: float
    residual: float
    phi: Array
    forces: Array  # (M,) that balance the load factor; NaN without one
    record: SolveRecord = SolveRecord()


def corner_answer(asked: CornerQuestion) -> CornerAnswer:
    """The answer to a question; SolverError if no solver gives one that passes the checks."""
    question, N, sense = asked.question, asked.N, asked.sense
    r0, r1 = asked.r0, asked.r1
    system = question.system
    M = len(r0)
    driven = drives(N, r1)
    if not driven:
        r1 = np.zeros_like(r1)
    unit = 1.0
    if driven and drives(N, r0):
        unit = _load_unit(question, N, r0, r1)
    law = contact_law(system, question.friction)
    rows = force_rows(law, question.shear_unit, question.node_unit, system.tangents)
    units = np.r_[np.tile(question.shear_unit, system.tangents), question.node_unit, unit]
    sizes = np.abs(N.T) @ units[:M]
    program = balance_program([balance_rows(N, r0, r1, sizes), *rows], units, sense)

    no_forces = np.full(M, np.nan)

    def claim(
        load_factor: float,
        bound: float,
        residual: float,
        y: Array | None = None,
        forces: Array = no_forces,
    ) -> CornerAnswer:
        """The claim with the motion of multipliers.

        Its residual includes how far the motion strains the bodies, or lifts nodes less than
        friction needs.
        """
        phi = np.zeros(M)
        if y is not None:
            phi = -N @ (y[: N.shape[1]] / sizes)
            size = float(np.linalg.norm(phi.reshape(-1, system.nodes), axis=0).max())
            phi = phi / (size or np.nan)
            residual = worst([residual, error_of_motion(question, phi)])
        return CornerAnswer(asked, load_factor, bound, residual, phi, forces)

    def claimed(x: Array, y: Array) -> CornerAnswer:
        value = float(x[M]) * unit
        value = value if value > ZERO_LOAD_FACTOR * unit else 0.0
        least_cost, error = program.lower_bound(x, y)
        bound = -sense * least_cost * unit
        gap = (abs(bound - value) + error * unit) / max(value, FLOOR * unit)
        residual = max(gap, program.violation(x))
        # No motion needs to prove that a load factor is at least 0.
        proof = None if value == 0 and sense < 0 else y
        return claim(value, bound, residual, proof, x[:M] * units[:M])

    def no_optimum(outcome: str) -> CornerAnswer | None:
        proof = without_optimum(program, outcome)
        if proof is None:
            return None
        y, error = proof
        load_factor = np.inf if y is None else np.nan
        return claim(load_factor, load_factor, error, y)

    found, record = answer(program, claimed, no_optimum=no_optimum)
    return replace(found, record=record)


def balance_program(rows: list[Rows], units: Array, sense: float) -> Arrays:
    """The largest (sense 1) or least load factor, >= 0, of forces that obey some rows.

    The load factor is the last quantity; `units` are those of all quantities.
    """
    last = len(units) - 1
    load_factor = [(np.array([last]), np.ones(1))]
    not_negative = rows_of("load_factor", LINEAR, [load_factor], np.zeros(1), units[last:])
    cost = np.zeros(len(units))
    cost[last] = -sense
    return program_of([*rows, not_negative], units, cost)


def error_of_motion(question: Question, phi: Array) -> float:
    """How far a motion phi (M,) of size 1 strains the bodies, or rises less than friction needs."""
    system = question.system
    *v, w = phi.reshape(-1, system.nodes)
    # A node that shears off its surface need not rise.
    lack = float((question.law.wedging_slope * np.linalg.norm(v, axis=0) - w).max())
    stiffest = float(np.diag(system.S).max()) or 1.0
    return max(lack, float(np.abs(system.S @ phi).max()) / stiffest)


def drives(N: Array, r: Array) -> bool:
    """Whether a load r (M,) does work in the rigid motions N, by more than rounding."""
    return bool(np.linalg.norm(N.T @ r) > CONDENSATION * np.linalg.norm(r))


def _load_unit(question: Question, N: Array, r0: Array, r1: Array) -> float:
    """Load factor at which the cyclic load is as large as the mean load can hold.

    Its work in shear counts against the friction of the mean load, its work in normal motions
    against the mean load itself.
    """
    friction = min(float(question.friction.max()), 1.0) or 1.0
    shear = len(r1) - question.system.nodes
    along = float(np.linalg.norm(N[:shear].T @ r1[:shear]))
    normal = float(np.linalg.norm(N[shear:].T @ r1[shear:]))
    return friction * float(np.linalg.norm(N.T @ r0)) / (along + friction * normal)
