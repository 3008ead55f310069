"""Statics of bodies and faces at one load corner; rigid motions as a table and in words.

`corner_answer` has the largest or least load factor at which contact forces balance the load at a
corner of the load cycle. Contact forces within friction have to do the work of the loads in all
rigid motions of the bodies. If no forces do so at a larger load factor, a rigid motion proves it:
contact forces cannot do negative work on this motion, but a larger load would need such work. The
multipliers of the balance give this motion; `motion_table` and `motions_in_words` describe it.

`slides_in_full_at` has the load factor at which all nodes of one face of a joint slide. While all
faces stick, the loads send a resultant and a moment through the face, which its shear forces have
to carry. The face slides in full at the least load factor at which no shear forces within friction
have this resultant and moment. The normal force of the face changes with the loads, but its
distribution stays the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...base import (
    CONDENSATION,
    COUNTS,
    FLOOR,
    ZERO_LOAD_FACTOR,
    Array,
    Booleans,
    SolveRecord,
    Table,
    frame,
    kept,
    worst,
)
from ...contact import ContactLaw, ContactSystem, contact_law
from ...contact.components import null_space, rigid_displacements
from ...solve.answer import answer, without_optimum
from ...solve.arrays import CONE, LINEAR, Arrays, Rows, program_of, rows_of
from ...transients.balance import balance_rows, force_rows
from ..program.question import Question


@kept
@dataclass(frozen=True, eq=False)
class CornerQuestion:
    """Asks for the largest (sense 1) or least load factor at which forces balance a corner's load.

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
    """A load factor of a corner, its bound, and the motion phi (M,) of size 1 that proves both.

    The load factor is NaN if there is none at which contact forces balance the load.
    """

    asked: CornerQuestion
    load_factor: float
    bound: float
    residual: float
    phi: Array
    forces: Array  # (M,) forces that balance the load at the load factor; NaN if there is none
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
    rows = force_rows(question.law, question.shear_unit, question.node_unit, system.tangents)
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
        """The claim, with the motion that the multipliers y give.

        The residual includes both errors of the motion, see `error_of_motion`.
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
        # No load factor is below 0, so a least load factor of 0 needs no motion as proof.
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
    """The program of the largest (sense 1) or least load factor, >= 0, under some rows.

    The load factor is the last quantity; `units` has the unit of each quantity.
    """
    last = len(units) - 1
    load_factor = [(np.array([last]), np.ones(1))]
    not_negative = rows_of("load_factor", LINEAR, [load_factor], np.zeros(1), units[last:])
    cost = np.zeros(len(units))
    cost[last] = -sense
    return program_of([*rows, not_negative], units, cost)


def error_of_motion(question: Question, phi: Array) -> float:
    """The larger of two errors of a motion phi (M,) of size 1.

    The first is the strain of the bodies. The second is the largest amount by which the lift of a
    node is below friction times its slip.
    """
    system = question.system
    *v, w = phi.reshape(-1, system.nodes)
    # A node whose surface shears off need not lift.
    lack = float((question.law.wedging_slope * np.linalg.norm(v, axis=0) - w).max())
    stiffest = float(np.diag(system.S).max()) or 1.0
    return max(lack, float(np.abs(system.S @ phi).max()) / stiffest)


def drives(N: Array, r: Array) -> bool:
    """Whether a load r (M,) does work in the rigid motions N, by more than rounding."""
    return bool(np.linalg.norm(N.T @ r) > CONDENSATION * np.linalg.norm(r))


def _load_unit(question: Question, N: Array, r0: Array, r1: Array) -> float:
    """Load factor at which the cyclic load is about what friction under the mean load can hold.

    The shear work of the cyclic load is compared with the friction of the mean load, and its work
    in normal motions with the mean load itself.
    """
    friction = min(float(question.friction.max()), 1.0) or 1.0
    shear = len(r1) - question.system.nodes
    along = float(np.linalg.norm(N[:shear].T @ r1[:shear]))
    normal = float(np.linalg.norm(N[shear:].T @ r1[shear:]))
    return friction * float(np.linalg.norm(N.T @ r0)) / (along + friction * normal)


# Numbers of motions in words.

# Motions below this share of the largest one are reported as zero: this is the error of cone
# solvers.
MOVES = 1e-4
# Nodes move as one body if each is off the body's motion by at most this share of the largest
# motion.
_FIT = COUNTS
# Largest number of contacts, and of motions, that a reason names.
_MOST_PARTS = 3


def motion_table(system: ContactSystem, phi: Array) -> Table:
    """The table of `GrossSlip.motion`, from motions phi (t + 1, N) whose largest has the size 1."""
    names = system.contact
    if names is None:
        names = np.full(system.nodes, "the contact")
    stretch = np.vstack([system.stretch.reshape(system.nodes, -1).T, np.ones(system.nodes)])
    # (N, axes) motions in the axes of space, from slips along the tangents and lifts.
    moves = np.einsum("an,nak->nk", phi / stretch, system.frames)
    moving = np.abs(phi).max(axis=0) > MOVES

    rows = list[list[Any]]()
    for name in dict.fromkeys(names[moving].tolist()):
        nodes = moving & (names == name)
        motion = _motion_as_one_body(system.points[nodes], system.normals[nodes], moves[nodes])
        rows.append([name, int(nodes.sum()), *motion])
    axes = "xyz"[: system.tangents + 1]
    columns = ["contact", "nodes", *axes, "slide", "lift", "turn", *(f"at_{axis}" for axis in axes)]
    return frame(rows, system.units, columns)


def _motion_as_one_body(points: Array, normals: Array, moves: Array) -> list[float]:
    """The rigid motion of some nodes, see `GrossSlip.motion`: direction, slide, lift, turn, point.

    All are NaN if the nodes do not move as one body. The direction is the direction of the slide,
    or, for a turn in space, of its axis. The point is the centre of a turn, in space a point of its
    axis.
    """
    axes = points.shape[1]
    centre = points.mean(axis=0)
    arms = points - centre
    shift, spin, error = _rigid_fit(arms, moves)
    if error > _FIT:
        return [np.nan] * (2 * axes + 3)

    turn = float(np.linalg.norm(spin))
    turns = turn * np.linalg.norm(arms, axis=1).max() > MOVES
    if turns and axes == 2:
        at = centre + np.array([-shift[1], shift[0]]) / spin[0]
        return [0.0, 0.0, 0.0, 0.0, float(spin[0]), *at.tolist()]
    if turns:
        axis = spin / turn
        at = centre + np.cross(spin, shift) / turn**2
        return [*axis.tolist(), float(axis @ shift), 0.0, turn, *at.tolist()]

    lift = 0.0
    if (np.abs(normals - normals[0]) <= _FIT).all():
        lift = float(shift @ normals[0])
    shift = shift - lift * normals[0]
    slide = float(np.linalg.norm(shift))
    direction = shift / slide if slide > MOVES else np.zeros(axes)
    return [*direction.tolist(), slide, lift, 0.0, *[np.nan] * axes]


def _rigid_fit(arms: Array, moves: Array) -> tuple[Array, Array, float]:
    """Shift and spin that fit motions (n, axes) of points at these arms best, and the error."""
    axes = arms.shape[1]
    basis = rigid_displacements(arms).reshape(moves.size, -1)
    fit: Any = np.linalg.lstsq(basis, moves.ravel())[0]
    error = float(np.abs(basis @ fit - moves.ravel()).max())
    return fit[:axes], fit[axes:], error


def motions_in_words(motion: Table) -> str:
    """The motions of a table in words; contacts that move in the same way share a phrase."""
    contacts: dict[str, list[str]] = {}
    for row in motion.to_dict("records"):
        contacts.setdefault(_in_words(row), []).append(str(row["contact"]))
    motions = [f"{_first_parts(names, ', ')} {text}" for text, names in contacts.items()]
    return f"body 1 moves at {_first_parts(motions, '; ')}"


def _in_words(row: dict[Any, Any]) -> str:
    names = [name for name in "xyz" if name in row]
    direction = _point([row[name] for name in names])
    at = _point([row[f"at_{name}"] for name in names])
    if np.isnan(row["slide"]):
        return "not as one body"
    if row["turn"] and len(names) == 2:
        return f"by a turn about {at}"
    if row["turn"]:
        return f"by a turn about the axis {direction} through {at}"
    return f"along {direction}" if row["slide"] > MOVES else "off"


def _first_parts(parts: Sequence[str], separator: str) -> str:
    shown = list(parts[:_MOST_PARTS])
    if len(parts) > _MOST_PARTS:
        shown.append("...")
    return separator.join(shown)


def _point(values: list[float]) -> str:
    # Adding 0 turns -0 into 0.
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 4) + 0.0) + ")"


# Largest residual of the load factor of a face. More accuracy would take a hundred times as long.
_TOLERANCE = 1e-6


class FaceLoad(NamedTuple):
    """The reactions (M,) of a corner, and a state that shows how normal forces are distributed.

    `constant` does not depend on the load factor, and `shear` is the part of `constant` that drives
    bodies. A load factor of 1 adds `cyclic`. The state has normal forces `p` (N,) under the load
    `of_state`.
    """

    constant: Array
    shear: Array
    cyclic: Array
    p: Array
    of_state: Array


class _Sliding(NamedTuple):
    """The load factor at which a face slides in full, and the error of its proof."""

    load_factor: float
    residual: float


def slides_in_full_at(
    system: ContactSystem, friction: Array, face: Booleans, loads: Iterable[FaceLoad]
) -> float:
    """The least load factor at which a face slides in full; NaN if it cannot slide as a whole."""
    motions = _sliding_motions(system, face)
    if not motions.size:
        return np.nan
    return min(_at_corner(system, friction, face, motions, load) for load in loads)


def _sliding_motions(system: ContactSystem, face: Booleans) -> Array:
    """(t n, k) slips of the n nodes of a face, if it moves as one body and no node opens."""
    arms = system.points[face] - system.points[face].mean(axis=0)
    motions = rigid_displacements(arms / (np.abs(arms).max() or 1.0))
    along = np.einsum("nak,nkm->anm", system.frames[face], motions)
    flat = null_space(along[-1], np.sqrt(len(arms)) * COUNTS)
    stretch = system.stretch.reshape(system.nodes, -1)[face].T
    slips = (along[:-1] * stretch[:, :, None]).reshape(-1, len(flat)) @ flat
    basis, size, _ = np.linalg.svd(slips, full_matrices=False)
    return basis[:, size > COUNTS]


def _at_corner(
    system: ContactSystem, friction: Array, face: Booleans, motions: Array, load: FaceLoad
) -> float:
    """The load factor up to which shear forces within friction can carry the resultants of a load.

    The unknowns are the shear forces of the face, and the load factor.
    """
    count, k = motions.shape

    def shear(r: Array) -> Array:
        return r.reshape(system.tangents + 1, -1)[:-1, face].ravel()

    law = contact_law(system, friction)
    force = float(law.bound(load.p)[face].sum()) or 1.0
    cyclic = shear(load.cyclic)
    if not drives(motions, cyclic):
        # The forces balance each other, such as the forces of a strain beside the face.
        cyclic = np.zeros_like(cyclic)
    unit = force / (float(np.abs(motions.T @ cyclic).max()) or 1.0)
    balance = balance_rows(motions, shear(load.shear), cyclic, np.full(k, force))
    rows = [balance, *_friction_rows(system, law, face, load, force)]
    program = balance_program(rows, np.r_[np.full(count, force), unit], 1.0)

    def claimed(x: Array, y: Array) -> _Sliding:
        bound, error = program.lower_bound(x, y)
        gap = abs(bound + x[-1]) + error
        return _Sliding(float(x[-1]) * unit, worst([gap, program.violation(x)]))

    def no_optimum(outcome: str) -> _Sliding | None:
        proof = without_optimum(program, outcome)
        return None if proof is None else _Sliding(np.inf if proof[0] is None else 0.0, proof[1])

    found, _ = answer(program, claimed, no_optimum=no_optimum, tolerance=_TOLERANCE)
    # A load factor no larger than its error counts as 0, as without friction.
    return found.load_factor if found.load_factor > _TOLERANCE * unit else 0.0


def _friction_rows(
    system: ContactSystem, law: ContactLaw, face: Booleans, load: FaceLoad, force: float
) -> list[Rows]:
    """The rows `|q| <= f p` of a face, whose pressure keeps its distribution as the load grows."""

    def pressing(r: Array) -> float:
        return float(r[-system.nodes :][face].sum())

    p = load.p[face]
    n = len(p)
    total = float(p.sum()) or np.inf
    growth = p * pressing(load.cyclic) / total
    at_zero = p * (1.0 + pressing(load.constant - load.of_state) / total)
    rows = []
    for term in law.terms:
        slope, constant = term.slope[face], term.constant[face]
        nodes = np.flatnonzero(np.isfinite(constant))
        load_factor = np.full(len(nodes), system.tangents * n)
        bound = [(load_factor, (slope * growth)[nodes])]
        axes = [[(axis * n + nodes, np.ones(len(nodes)))] for axis in range(system.tangents)]
        at_rest = (slope * at_zero + constant)[nodes]
        units = np.full(len(nodes), force)
        rows.append(rows_of(term.row, CONE, [bound, *axes], at_rest, units))
    return rows
