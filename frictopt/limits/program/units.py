"""The units of a limit question, and the corners of its load cycle that matter.

Units are forces and load factors that scale unknowns and margins.

r0 (K0, t + 1, N) are the reactions of the closed nodes at load factor 0, normal ones last. r1 (K,
t + 1, N) are the reactions of the scaled loads at load factor 1. `closed` (N,) is the mask of the
closed nodes.
"""

from contextlib import suppress
from typing import Any

import numpy as np
import scipy  # a part of it is imported when it is used

from ...base import CONDENSATION, ROUNDING, Array, Booleans, Integers
from ...contact import ContactSystem, LoadCycle


def outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners outside the convex hull of the other corners, by the amplitudes of all load cases."""
    count = len(cycle.corners)
    columns = []
    for loads in (cycle.corners, *([] if cycle.fixed is None else [cycle.fixed])):
        for case in sorted({case for load in loads for case in load}):
            columns.append([load.get(case, 0.0) for load in loads])
    return vertices_of_hull(np.array(columns).reshape(-1, count).T)


def vertices_of_hull(points: Array) -> list[int]:
    """Points (K, any number) that are no mean of the others; some others too in many directions."""
    count = len(points)
    # Coordinates in the directions in which the points differ.
    spread = np.ptp(points, axis=0)
    points = (points - points.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    _, size, directions = np.linalg.svd(points, full_matrices=False)
    differ = size > ROUNDING * max(size.max(initial=0.0), 1.0)
    along = points @ directions[differ].T
    dimension = along.shape[1]
    if dimension == 0:
        return [0]
    if dimension == 1:
        return sorted({int(along.argmin()), int(along.argmax())})
    # Hulls of corners are looked for in at most so many directions. With more, each corner has
    # rows.
    most_directions = 6
    if dimension <= most_directions and count > dimension + 1:
        # A hull that is nearly flat has no vertices that rounding leaves alone.
        with suppress(scipy.spatial.QhullError):
            return sorted(scipy.spatial.ConvexHull(along).vertices.tolist())
    return list(range(count))


def ruling(constant: Array, rate: Array) -> tuple[Integers, Integers]:
    """Corners and nodes (R,) of the rows that govern `x >= constant_k + load_factor rate_k`.

    A row (k, node) governs if it is the largest of its node at some load factor >= 0. The loop
    starts with the largest row at load factor 0, and follows the upper envelope from row to row.
    """
    if not constant.size:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    highest = constant == constant.max(axis=0)
    corner = np.where(highest, rate, -np.inf).argmax(axis=0)
    node = np.arange(rate.shape[1])
    corners = [corner]
    nodes = [node]
    while node.size:
        rate_gain = rate[:, node] - rate[corner, node]
        lead = constant[corner, node] - constant[:, node]
        crossing = np.where(rate_gain > 0, lead / np.where(rate_gain > 0, rate_gain, 1.0), np.inf)
        crosses = np.isfinite(crossing.min(axis=0))
        corner = crossing.argmin(axis=0)[crosses]
        node = node[crosses]
        corners.append(corner)
        nodes.append(node)
    return np.concatenate(corners), np.concatenate(nodes)


def units_of(
    system: ContactSystem, friction: Array, open_nodes: Booleans, r0: Array, r1: Array
) -> dict[str, Any]:
    """The units, see the fields of `Question` of these names."""
    closed = ~open_nodes
    force = _mean_force(r0, r1, closed)
    mean_bound = _mean_bound(r0, friction, closed, force)
    # Pressure margins have the unit `mean_bound` / friction. Friction below this value is replaced
    # by it, so that the unit is finite.
    least_friction = 0.01
    node_unit = np.where(open_nodes, force, _node_unit(r0, r1, force))

    # In space the radius of a friction cone is the friction bound. The bound is the unit if it is
    # smaller than the pressure.
    small_cones = (friction > 0) & (friction < 1)
    normal_stiffness = float(system.own_stiffness[-system.nodes :].mean())
    if not normal_stiffness > CONDENSATION * system.stiffness_scale:
        normal_stiffness = system.stiffness_scale
    return {
        "force": force,
        "mean_bound": mean_bound,
        "mean_pressure": mean_bound / np.maximum(friction, least_friction),
        "load_unit": _load_unit(r0, r1, friction, closed, force),
        "node_unit": node_unit,
        "shear_unit": node_unit * np.where(small_cones, friction, 1.0),
        "clearance": mean_bound / normal_stiffness,
    }


def _mean_force(r0: Array, r1: Array, closed: Booleans) -> float:
    """Mean normal force at load factor 0; a force of the same size if there is none."""
    if not closed.any():
        return 1.0
    pressure = float(np.abs(r0[:, -1, closed]).mean())
    if pressure:
        return pressure
    shear = np.linalg.norm(r0[:, :-1, closed], axis=1)
    cyclic_shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    cyclic_pressure = np.abs(r1[:, -1, closed])
    return float(max(shear.mean(), cyclic_shear.mean(), cyclic_pressure.mean())) or 1.0


def _mean_bound(r0: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Mean friction bound at load factor 0; `force` if it is only rounding (no pressure)."""
    if not closed.any():
        return force
    bound = float((friction * r0[:, -1])[:, closed].mean())
    size = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return bound if bound > CONDENSATION * size else force


def _load_unit(r0: Array, r1: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Load factor at which the cyclic reactions reach the mean friction bound."""
    if not closed.any():
        return 1.0
    f = friction[closed]
    shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    pressure = np.abs(r1[:, -1, closed])
    without_friction = float(pressure[:, f == 0].sum()) / int(closed.sum())
    demand = float(shear.mean() + (f * pressure).mean()) + without_friction
    if not demand > 0:
        return 1.0
    bound = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return (bound or force) / demand


def _node_unit(r0: Array, r1: Array, force: float) -> Array:
    """(N,) pressure of each node under the mean load, or its largest other force if it has none."""
    # Least force unit of a node, divided by the mean normal force: answers have errors of this
    # size.
    least_share = 1e-6
    smallest = least_share * force
    pressure = np.abs(r0[:, -1]).max(axis=0)
    shear = np.linalg.norm(r0[:, :-1], axis=1).max(axis=0)
    cyclic = np.maximum(np.linalg.norm(r1[:, :-1], axis=1), np.abs(r1[:, -1])).max(axis=0)
    other_forces = np.maximum(np.maximum(shear, cyclic), smallest)
    return np.asarray(np.where(pressure > smallest, pressure, other_forces))
