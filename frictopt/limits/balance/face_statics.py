"""The load factor at which one face of a joint slides in full.

The shear forces of a face have the resultant and the moment that the loads send through the face
while all faces stick. The face slides in full at the least load factor at which no shear forces
within friction have this resultant and moment. The normal force of the face changes with the loads,
and keeps its distribution.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...base import COUNTS, ROUNDING, Array, Booleans, worst
from ...contact import ContactLaw, ContactSystem, contact_law
from ...solve.answer import answer, without_optimum
from ...solve.arrays import CONE, Rows, rows_of
from ...transients.balance import balance_rows
from .corner_statics import balance_program

# Largest residual of the load factor of a face. More digits take a hundred times as long.
_TOLERANCE = 1e-6


class FaceLoad(NamedTuple):
    """The reactions (M,) of a corner, and a state with the distribution of the normal forces.

    `constant` does not depend on the load factor, and `shear` is its part that drives bodies. A
    load factor of 1 adds `cyclic`. The state has normal forces `p` (N,) under the load `of_state`.
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
    """(t n, k) slips of the n nodes of a face that move as one body and do not open."""
    arms = system.points[face] - system.points[face].mean(axis=0)
    n, axes = arms.shape
    arms = arms / (np.abs(arms).max() or 1.0)
    turns = [arms[:, ::-1] * [-1, 1]] if axes == 2 else [np.cross(e, arms) for e in np.eye(3)]
    motions = np.concatenate([np.tile(np.eye(axes), (n, 1, 1)), np.stack(turns, axis=-1)], axis=-1)
    along = np.einsum("nak,nkm->anm", system.frames[face], motions)
    flat = without_lift(along[-1], np.sqrt(n) * COUNTS)
    stretch = system.stretch.reshape(system.nodes, -1)[face].T
    slips = (along[:-1] * stretch[:, :, None]).reshape(-1, len(flat)) @ flat
    basis, size, _ = np.linalg.svd(slips, full_matrices=False)
    return basis[:, size > COUNTS]


def without_lift(lifts: Array, size: float) -> Array:
    """(k, m) combinations of k motions whose lifts (n, k) have at most a size."""
    _, sizes, parts = np.linalg.svd(lifts)
    small = np.pad(sizes, (0, len(parts) - len(sizes))) <= size
    return parts[small].T


def _at_corner(
    system: ContactSystem, friction: Array, face: Booleans, motions: Array, load: FaceLoad
) -> float:
    """The load factor up to which shear forces within friction have the resultants of a load.

    The unknowns are the shear forces of the face, and the load factor.
    """
    count, k = motions.shape

    def shear(r: Array) -> Array:
        return r.reshape(system.tangents + 1, -1)[:-1, face].ravel()

    law = contact_law(system, friction)
    force = float(law.bound(load.p)[face].sum()) or 1.0
    cyclic = shear(load.cyclic)
    # If forces balance each other, such as those of a strain beside the face, their resultant is
    # only rounding.
    if (np.abs(motions.T @ cyclic) <= ROUNDING * (np.abs(motions.T) @ np.abs(cyclic))).all():
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
    # A load factor of the size of its error is 0, as without friction.
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
        rows.append(rows_of(term.row, CONE, [bound, *axes], at_rest, units, nodes=nodes))
    return rows
