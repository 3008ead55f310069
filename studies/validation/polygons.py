"""Limits in three dimensions by linear programs of scipy, with polygons around friction circles."""

from typing import Any

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

# Number of sides of each polygon at first.
_SIDES = 24
# Largest number of rounds that add sides.
_CUTS = 40
# Distance outside a circle that counts as none.
_EXCESS = 1e-10
# A node may need pressure to stay closed, and more pressure to stick. A difference up to this share
# of its loads counts as none.
_LIFTS = 1e-8
_TIGHT = {
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 10.0,
}


def polygon_limit(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, *, least: bool = False
) -> float | None:
    """The shakedown limit or, with `least`, the least safe load factor, with all nodes closed.

    None if scipy gives no answer.
    """
    q0, p0 = cycle.mean_reaction(system)
    f = np.broadcast_to(friction, system.nodes)
    i, shear, closed, unit = _rows(system, cycle, range(system.nodes))
    goal = np.append(np.zeros(2 * system.nodes), 1.0 if least else -1.0)
    circles = shear, q0[i] / unit[:, None], f[i, None] * closed, f[i] * p0[i] / unit
    no_node_opens = -closed, p0[i] / unit
    status, x = _minimum(goal, *circles, less=no_node_opens, lowest=0.0)
    if status == 3:
        return float("inf")
    return float(x[-1]) if status == 0 else None


def least_critical(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """Least load factor at which a safe slip leaves some node only the pressure that it needs.

    The result is inf if no slip does, and None if scipy gives no answer.
    """
    n = system.nodes
    f = np.broadcast_to(friction, n)
    q0, p0 = cycle.mean_reaction(system)
    q1, p1 = cycle.corner_reactions(system)
    least = np.inf
    for node in np.flatnonzero(f > 0).tolist():
        largest_shear = np.linalg.norm(q1[:, node], axis=-1).max()
        size = float(largest_shear + f[node] * np.abs(p1[:, node]).max())
        if size == 0:
            continue
        # The least pressure that the node needs to stick, and its shear force at this pressure.
        turn = np.tile(np.eye(2, 3, 1), (len(q1), 1, 1))
        bound = np.zeros((len(q1), 3))
        bound[:, 0] = f[node]
        status, state = _minimum(
            np.eye(3)[0], turn, q1[:, node] / size, bound, f[node] * p1[:, node] / size
        )
        if status != 0:
            return None
        pressure, *shear_force = state * size
        if pressure <= float((-p1[:, node]).max()) + _LIFTS * size:
            continue
        # The slips of all nodes give the node exactly these forces; the other nodes stick.
        i, shear, closed, unit = _rows(system, cycle, np.delete(np.arange(n), node))
        of_node = system.S[[2 * n + node, node, n + node], : 2 * n] / system.stiffness_scale
        forces = [-pressure, *(-part for part in shear_force)]
        scale = p0[node] if p0[node] > 0 else 1.0
        equal = np.column_stack([of_node, forces]) / scale, -np.r_[p0[node], q0[node]] / scale
        circles = shear, q0[i] / unit[:, None], f[i, None] * closed, f[i] * p0[i] / unit
        status, x = _minimum(np.eye(2 * n + 1)[-1], *circles, equal=equal, lowest=0.0)
        if status not in (0, 2):
            return None
        least = min(least, float(x[-1]) if status == 0 else np.inf)
    return least


def balanced(system: fo.ContactSystem, motions: np.ndarray, friction: float) -> float | None:
    """Largest load factor at which contact forces within friction balance the loads P and Q.

    The forces balance the loads in each of the `motions` (M, m), whose sizes are about 1. None if
    scipy gives no answer.
    """
    n = system.nodes
    axes = system.tangents + 1
    mean, pushed = (
        np.concatenate([q.T.ravel(), p]) for q, p in (system.bonded["P"], system.bonded["Q"])
    )
    force = float(mean[-n:].sum())
    unit = friction * force / float(np.linalg.norm(pushed[:-n].reshape(-1, n).sum(axis=1)))
    size = np.r_[np.full((axes - 1) * n, friction * force), np.full(n, force)] / n
    equal = np.column_stack([motions.T * size, -unit * (motions.T @ pushed)])
    rows = np.abs(equal).max(axis=1)
    shear = np.zeros((n, 2, len(size) + 1))
    pressure = np.zeros((n, len(size) + 1))
    for along in range(axes - 1):
        shear[np.arange(n), along, along * n + np.arange(n)] = 1.0
    pressure[np.arange(n), (axes - 1) * n + np.arange(n)] = 1.0
    goal = -np.eye(len(size) + 1)[-1]
    none = np.zeros(n)
    status, x = _minimum(
        goal,
        shear,
        np.zeros((n, 2)),
        pressure,
        none,
        less=(-pressure, none),
        equal=(equal / rows[:, None], motions.T @ mean / rows),
        lowest=0.0,
    )
    return None if status != 0 else unit * float(x[-1])


def _rows(system: fo.ContactSystem, cycle: fo.LoadCycle, nodes: Any) -> tuple[Any, Any, Any, Any]:
    """Rows of shear and pressure for some nodes at every corner.

    Returns the m numbers of the nodes, rows of shear (m, 2, 2N + 1) and of pressure (m, 2N + 1) for
    slips and load factor, and the m units of force.
    """
    n = system.nodes
    p0 = cycle.mean_reaction(system)[1]
    q1, p1 = cycle.corner_reactions(system)
    k, i = (grid.ravel() for grid in np.meshgrid(np.arange(len(p1)), nodes, indexing="ij"))
    unit = np.where(p0 > 0, p0, 1.0)[i]
    A = np.stack([system.A[:n], system.A[n:]], axis=1) / system.stiffness_scale
    B = system.B / system.stiffness_scale
    shear = np.concatenate([A[i], q1[k, i][..., None]], axis=-1)
    pressure = np.column_stack([B[i], p1[k, i]])
    return i, shear / unit[:, None, None], pressure / unit[:, None], unit


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
    """The x of least cost with `|shear x + q| <= bound x + p` for all circles.

    The last entry of x is at least `lowest`. `less` and `equal` add linear rows. Returns the status
    of scipy, and x.
    """
    x_bounds = [(None, None)] * (len(cost) - 1) + [(lowest, None)]
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    circle, angle = (grid.ravel() for grid in np.meshgrid(np.arange(len(q)), angles, indexing="ij"))
    rows, level = less or (np.zeros((0, len(cost))), np.zeros(0))
    for cut in range(_CUTS):
        direction = np.column_stack([np.cos(angle), np.sin(angle)])
        sides = np.einsum("ma,mai->mi", direction, shear[circle]) - bound[circle]
        rows = np.vstack([rows, sides])
        level = np.r_[level, p[circle] - np.sum(direction * q[circle], axis=1)]
        # After the first cut, the status "unbounded" is an error of the solver: more rows do not
        # make a bounded program unbounded.
        known_statuses = (0, 2) if cut else (0, 2, 3)
        for method in ("highs-ds", "highs-ipm"):
            answer = linprog(cost, rows, level, *equal, x_bounds, method=method, options=_TIGHT)
            if answer.status in known_statuses:
                break
        if answer.status != 0:
            return (1 if cut and answer.status == 3 else answer.status), None
        force = shear @ answer.x + q
        excess = np.linalg.norm(force, axis=-1) - bound @ answer.x - p
        circle = np.flatnonzero(excess > _EXCESS)
        if not len(circle):
            return 0, answer.x
        # A new side touches each circle in the direction of the force that is outside it.
        angle = np.arctan2(force[circle, 1], force[circle, 0])
    return 1, None
