"""The guaranteed limit in three dimensions by linear programs of scipy over raw slips, with polygons around the friction circles."""

from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

_SIDES, _CUTS, _EXCESS = 24, 40, 1e-10  # sides of each polygon at first, rounds that add sides, and the excess over a circle that counts as none
_LIFTS = 1e-8  # need of pressure beyond what keeps a node from lifting off, over its loads, that counts as none
_TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "time_limit": 10.0}


def least_critical(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """Least load factor at which a safe slip leaves some node no more pressure than it needs; inf where none does, None if scipy fails."""
    n, f = system.nodes, np.broadcast_to(friction, system.nodes)
    (q0, p0), (q1, p1) = cycle.mean_reaction(system), cycle.corner_reactions(system)
    A = np.stack([system.A[:n], system.A[n:]], axis=1) / system.stiffness_scale
    B, least = system.B / system.stiffness_scale, np.inf
    for node in np.flatnonzero(f > 0).tolist():
        size = float(np.linalg.norm(q1[:, node], axis=-1).max() + f[node] * np.abs(p1[:, node]).max())
        if size == 0:
            continue
        turn, none = np.tile(np.eye(2, 3, 1), (len(q1), 1, 1)), np.zeros((len(q1), 3))
        none[:, 0] = f[node]
        state = _minimum(np.eye(3)[0], turn, q1[:, node] / size, none, f[node] * p1[:, node] / size, np.zeros((0, 3)), np.zeros(0))
        if state is None:
            return None
        rho, c = state[0] * size, state[1:] * size
        if rho <= float((-p1[:, node]).max()) + _LIFTS * size:
            continue
        k, i = (grid.ravel() for grid in np.meshgrid(np.arange(len(q1)), np.delete(np.arange(n), node), indexing="ij"))
        unit = np.where(p0 > 0, p0, 1.0)
        shear = np.concatenate([A[i], q1[k, i][..., None]], axis=-1) / unit[i, None, None]
        bound = f[i, None] * np.column_stack([B[i], p1[k, i]]) / unit[i, None]
        equal = np.column_stack([np.vstack([B[node], A[node]]), -np.r_[rho, c]]) / unit[node]
        right = -np.r_[p0[node], q0[node]] / unit[node]
        found = _minimum(np.eye(2 * n + 1)[-1], shear, q0[i] / unit[i, None], bound, f[i] * p0[i] / unit[i], equal, right)
        if found is None:
            return None
        least = min(least, float(found[-1]))
    return least


def _minimum(cost: Any, shear: Any, q: Any, bound: Any, p: Any, equal: Any, right: Any) -> Any:
    """The x of least cost with `|shear x + q| <= bound x + p` for all circles, `equal x = right`, and its last entry >= 0 where there are equations.

    Infinite where there is none; None where scipy finds neither.
    """
    free = [(None, None)] * (len(cost) - 1) + [(0.0 if len(equal) else None, None)]
    circle, angle = (grid.ravel() for grid in np.meshgrid(np.arange(len(q)), 2 * np.pi * np.arange(_SIDES) / _SIDES, indexing="ij"))
    rows, level = np.zeros((0, len(cost))), np.zeros(0)
    for _ in range(_CUTS):
        way = np.column_stack([np.cos(angle), np.sin(angle)])
        rows = np.vstack([rows, np.einsum("ma,mai->mi", way, shear[circle]) - bound[circle]])
        level = np.r_[level, p[circle] - np.sum(way * q[circle], axis=1)]
        found = linprog(cost, rows, level, equal, right, free, method="highs-ds", options=_TIGHT)
        if found.status == 2:
            return np.full(len(cost), np.inf)
        if found.status != 0:
            return None
        off = shear @ found.x + q
        beyond = np.linalg.norm(off, axis=-1) - bound @ found.x - p
        circle = np.flatnonzero(beyond > _EXCESS)
        if not len(circle):
            return found.x
        angle = np.arctan2(off[circle, 1], off[circle, 0])
    return None
