"""The load factor at which one face of a joint slides in full.

The shear forces of a face have the resultant and the moment that the loads send through it while
all faces stick. The face slides in full at the least load factor at which no shear forces within
friction have them. Its normal force changes with the loads, and keeps its distribution.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...base import COUNTS, Array, Booleans, worst
from ...contact import ContactSystem, contact_law
from ...solve.answer import answer, infeasible, unbounded
from ...solve.rows import CONE, EQUATION, LINEAR, Rows, program_of, rows_of

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
    _, lifts, parts = np.linalg.svd(along[-1], full_matrices=True)
    flat = np.pad(lifts, (0, len(parts) - len(lifts))) <= np.sqrt(n) * COUNTS
    stretch = system.stretch.reshape(system.nodes, -1)[face].T
    slips = (along[:-1] * stretch[:, :, None]).reshape(-1, len(parts)) @ parts[flat].T
    basis, size, _ = np.linalg.svd(slips, full_matrices=False)
    return np.asarray(basis[:, size > COUNTS])


def _at_corner(
    system: ContactSystem, friction: Array, face: Booleans, motions: Array, load: FaceLoad
) -> float:
    """The load factor up to which shear forces within friction have the resultants of a load.

    The unknowns are the shear forces of the face, and the load factor.
    """
    t, k = system.tangents, motions.shape[1]
    nodes = np.arange(int(face.sum()))
    n = len(nodes)

    def shear(r: Array) -> Array:
        return motions.T @ r.reshape(t + 1, -1)[:-1, face].ravel()

    def pressing(r: Array) -> float:
        return float(r[-system.nodes :][face].sum())

    p = load.p[face]
    total = float(p.sum()) or np.inf
    growth = pressing(load.cyclic) / total
    at_zero = 1.0 + pressing(load.constant - load.of_state) / total
    work = shear(load.cyclic)
    law = contact_law(system, friction)
    force = float(law.bound(load.p)[face].sum()) or 1.0
    unit = force / (float(np.abs(work).max()) or 1.0)

    row, entry = np.indices(motions.T.shape)
    balance = Rows(
        "balance",
        EQUATION,
        np.ones(k, dtype=int),
        np.r_[row.ravel(), np.arange(k)],
        np.r_[entry.ravel(), np.full(k, t * n)],
        np.r_[motions.T.ravel(), -work],
        -shear(load.shear),
        np.full(k, force),
        np.full(k, -1),
        np.full(k, -1),
    )
    factor = np.full(n, t * n)
    one = np.ones(1)
    rows = [balance, rows_of("load_factor", LINEAR, [[(factor[:1], one)]], 0.0 * one, unit * one)]
    for term in law.terms:
        slope, constant = term.slope[face], term.constant[face]
        bounded = np.flatnonzero(np.isfinite(constant))
        bound = [(factor[bounded], (slope * p * growth)[bounded])]
        at_rest = (slope * p * at_zero + constant)[bounded]
        units = np.full(len(bounded), force)
        axes = [[(axis * n + bounded, np.ones(len(bounded)))] for axis in range(t)]
        rows.append(rows_of(term.row, CONE, [bound, *axes], at_rest, units, nodes=bounded))
    cost = np.zeros(t * n + 1)
    cost[-1] = -1.0
    program = program_of(rows, np.r_[np.full(t * n, force), unit], cost)

    def claimed(x: Array, y: Array) -> _Sliding:
        bound, error = program.lower_bound(x, y)
        gap = abs(bound + x[-1]) + error
        return _Sliding(float(x[-1]) * unit, worst([gap, program.violation(x)]))

    def without_optimum(_outcome: str) -> _Sliding | None:
        found = infeasible(program)
        if found is not None:
            return _Sliding(0.0, found[1])
        grown = unbounded(program)
        return None if grown is None else _Sliding(np.inf, grown)

    found, _ = answer(program, claimed, no_optimum=without_optimum, tolerance=_TOLERANCE)
    assert found is not None
    return max(found.load_factor, 0.0)
