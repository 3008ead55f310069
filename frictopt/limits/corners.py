"""The corners of a load cycle that matter: outside the hull of the others, and governing."""

from contextlib import suppress

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..base import ROUNDING, Array, Integers
from ..contact import LoadCycle


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
        with suppress(QhullError):
            return sorted(ConvexHull(along).vertices.tolist())
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
