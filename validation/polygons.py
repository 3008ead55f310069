"""Limits in three dimensions by linear programs of scipy over raw slips, with polygons around the friction circles."""

from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

_SIDES = 24  # of each polygon at first
_CUTS = 40  # rounds that add sides
_EXCESS = 1e-10  # over a circle, that counts as none
# need of pressure beyond what keeps a node from lifting off, over its loads, that counts as none
_LIFTS = 1e-8
_TIGHT = {
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 10.0,
}


def polygon_limit(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, *, least: bool = False
) -> float | None:
    """The shakedown limit or, if asked for, the least load factor with a safe slip; None where scipy finds none."""
    (q0, p0), f = cycle.mean_reaction(system), np.broadcast_to(friction, system.nodes)
    i, shear, closed, unit = _rows(system, cycle, range(system.nodes))
    goal = np.append(np.zeros(2 * system.nodes), 1.0 if least else -1.0)
    circles = shear, q0[i] / unit[:, None], f[i, None] * closed, f[i] * p0[i] / unit
    status, x = _minimum(goal, *circles, less=(-closed, p0[i] / unit), lowest=0.0)  # no node opens
    return float("inf") if status == 3 else None if status != 0 else float(x[-1])


def least_critical(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """Least load factor at which a safe slip leaves some node no more pressure than it needs; inf where none does, None if scipy fails."""
    n, f = system.nodes, np.broadcast_to(friction, system.nodes)
    (q0, p0), (q1, p1) = cycle.mean_reaction(system), cycle.corner_reactions(system)
    least = np.inf
    for node in np.flatnonzero(f > 0).tolist():
        size = float(
            np.linalg.norm(q1[:, node], axis=-1).max() + f[node] * np.abs(p1[:, node]).max()
        )
        if size == 0:
            continue
        turn, none = np.tile(np.eye(2, 3, 1), (len(q1), 1, 1)), np.zeros((len(q1), 3))
        none[:, 0] = f[node]
        status, state = _minimum(
            np.eye(3)[0], turn, q1[:, node] / size, none, f[node] * p1[:, node] / size
        )
        if status != 0:
            return None
        rho, *c = state * size
        if rho <= float((-p1[:, node]).max()) + _LIFTS * size:
            continue
        i, shear, closed, unit = _rows(system, cycle, np.delete(np.arange(n), node))
        own = np.column_stack(
            [
                system.S[[2 * n + node, node, n + node], : 2 * n] / system.stiffness_scale,
                [-rho, *(-part for part in c)],
            ]
        )
        scale = p0[node] if p0[node] > 0 else 1.0
        equal = own / scale, -np.r_[p0[node], q0[node]] / scale
        circles = shear, q0[i] / unit[:, None], f[i, None] * closed, f[i] * p0[i] / unit
        status, x = _minimum(np.eye(2 * n + 1)[-1], *circles, equal=equal, lowest=0.0)
        if status not in (0, 2):
            return None
        least = min(least, float(x[-1]) if status == 0 else np.inf)
    return least


def balanced(system: fo.ContactSystem, motions: np.ndarray, friction: float) -> float | None:
    """Largest load factor at which forces within friction balance P and Q in motions (M, m) of size about one; None where scipy finds none."""
    n, axes = system.nodes, system.tangents + 1
    mean, pushed = (
        np.concatenate([q.T.ravel(), p]) for q, p in (system.bonded["P"], system.bonded["Q"])
    )
    force = float(mean[-n:].sum())
    unit = friction * force / float(np.linalg.norm(pushed[:-n].reshape(-1, n).sum(axis=1)))
    size = np.r_[np.full((axes - 1) * n, friction * force), np.full(n, force)] / n
    equal = np.column_stack([motions.T * size, -unit * (motions.T @ pushed)])
    rows = np.abs(equal).max(axis=1)
    shear, pressure = np.zeros((n, 2, len(size) + 1)), np.zeros((n, len(size) + 1))
    for along in range(axes - 1):
        shear[np.arange(n), along, along * n + np.arange(n)] = 1.0
    pressure[np.arange(n), (axes - 1) * n + np.arange(n)] = 1.0
    goal = -np.eye(len(size) + 1)[-1]
    no = np.zeros(n)
    status, x = _minimum(
        goal,
        shear,
        np.zeros((n, 2)),
        pressure,
        no,
        less=(-pressure, no),
        equal=(equal / rows[:, None], motions.T @ mean / rows),
        lowest=0.0,
    )
    return None if status != 0 else unit * float(x[-1])


def _rows(system: fo.ContactSystem, cycle: fo.LoadCycle, nodes: Any) -> tuple[Any, Any, Any, Any]:
    """For these nodes at every corner: their numbers, rows of shear (m, 2, 2N + 1) and pressure in slips and load factor, and their units."""
    n, p0, (q1, p1) = system.nodes, cycle.mean_reaction(system)[1], cycle.corner_reactions(system)
    k, i = (grid.ravel() for grid in np.meshgrid(np.arange(len(p1)), nodes, indexing="ij"))
    unit = np.where(p0 > 0, p0, 1.0)[i]
    A, B = (
        np.stack([system.A[:n], system.A[n:]], axis=1) / system.stiffness_scale,
        system.B / system.stiffness_scale,
    )
    shear = np.concatenate([A[i], q1[k, i][..., None]], axis=-1)
    return i, shear / unit[:, None, None], np.column_stack([B[i], p1[k, i]]) / unit[:, None], unit


def _minimum(
    cost: Any,
    shear: Any,
    q: Any,
    bound: Any,
    p: Any,
    *,
    less: Any = None,
    equal: Any = (None, None),
    lowest: float | None = None,
) -> tuple[int, Any]:
    """Status of scipy, and the x of least cost with `|shear x + q| <= bound x + p` for all circles, and more rows; last entry >= `lowest`."""
    free = [(None, None)] * (len(cost) - 1) + [(lowest, None)]
    circle, angle = (
        grid.ravel()
        for grid in np.meshgrid(
            np.arange(len(q)), 2 * np.pi * np.arange(_SIDES) / _SIDES, indexing="ij"
        )
    )
    rows, level = less or (np.zeros((0, len(cost))), np.zeros(0))
    for cut in range(_CUTS):
        way = np.column_stack([np.cos(angle), np.sin(angle)])
        rows = np.vstack([rows, np.einsum("ma,mai->mi", way, shear[circle]) - bound[circle]])
        level = np.r_[level, p[circle] - np.sum(way * q[circle], axis=1)]
        for method in ("highs-ds", "highs-ipm"):
            found = linprog(cost, rows, level, *equal, free, method=method, options=_TIGHT)
            if found.status in (
                (0, 2) if cut else (0, 2, 3)
            ):  # more rows make no bounded program unbounded
                break
        if found.status != 0:
            return (1 if cut and found.status == 3 else found.status), None
        off = shear @ found.x + q
        beyond = np.linalg.norm(off, axis=-1) - bound @ found.x - p
        circle = np.flatnonzero(beyond > _EXCESS)
        if not len(circle):
            return 0, found.x
        angle = np.arctan2(off[circle, 1], off[circle, 0])
    return 1, None
