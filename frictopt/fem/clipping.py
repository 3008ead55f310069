"""Overlaps of intervals on a line, and of triangles in a plane, with their integration points.

Parts are intervals (m, 2, 1) or triangles (m, 3, 2), by their corners.
"""

import numpy as np

from ..base import Array, Integers

# Barycentric coordinates of integration points of equal weight, on an interval and on a triangle,
# by the number of corners. They are exact for products of two hat functions; on an interval also
# times a linear depth.
_NEAR = (1 - np.sqrt(1 / 3)) / 2
_POINTS = {
    2: np.array([[1 - _NEAR, _NEAR], [_NEAR, 1 - _NEAR]]),
    3: np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6,
}


def common_parts(a: Array, b: Array) -> tuple[Integers, Array]:
    """The parts that make up the overlaps of pairs of parts, and the pair (m,) of each.

    Triangles are counterclockwise, and intervals begin at their smaller end.
    """
    if a.shape[1] == 2:
        common = np.stack([np.maximum(a[:, 0], b[:, 0]), np.minimum(a[:, 1], b[:, 1])], axis=1)
        pair = np.arange(len(a))
    else:
        pair, common = _common_triangles(a, b)
    overlap = np.flatnonzero(_sizes(common) > 0)
    return pair[overlap], common[overlap]


def integration_points_of(parts: Array) -> tuple[Integers, Array, Array]:
    """Integration points (n, 1 or 2) of m parts, with the part (n,) of each and its weight (n,)."""
    rule = _POINTS[parts.shape[1]]
    points = np.concatenate([np.einsum("c,mcx->mx", weights, parts) for weights in rule])
    sizes = np.tile(_sizes(parts) / len(rule), len(rule))
    return np.tile(np.arange(len(parts)), len(rule)), points, sizes


def hat_functions(parts: Array, points: Array) -> Array:
    """(m, corners) hat functions of the corners of parts, at one point (m, 1 or 2) in each."""
    count = parts.shape[1]
    opposite = []
    for corner in range(count):
        corners = [points if c == corner else parts[:, c] for c in range(count)]
        opposite.append(_sizes(np.stack(corners, axis=1)))
    return np.asarray(np.column_stack(opposite) / np.sum(opposite, axis=0)[:, None])


def _common_triangles(a: Array, b: Array) -> tuple[Integers, Array]:
    """Triangles (m, 3, 2), some of size zero, of the overlaps of pairs of triangles (pairs, 3, 2).

    Each overlap is a convex polygon: triangle a, clipped by the three sides of triangle b.
    """
    polygons = a
    for corner in range(3):
        polygons = _clipped(polygons, b[:, corner], b[:, (corner + 1) % 3])
    fans = [
        np.stack([polygons[:, 0], polygons[:, c], polygons[:, c + 1]], axis=1)
        for c in range(1, polygons.shape[1] - 1)
    ]
    return np.tile(np.arange(len(a)), len(fans)), np.concatenate([a[:0], *fans])


def _clipped(polygons: Array, start: Array, end: Array) -> Array:
    """The parts of convex polygons (m, corners, 2) to the left of lines from `start` to `end`.

    The ends of the lines are (m, 2). All polygons have the same number of corners: the first corner
    is repeated.
    """
    height = _areas(start[:, None], end[:, None], polygons)
    next_height = np.roll(height, -1, axis=1)
    inside = height >= 0
    crosses = inside != (next_height >= 0)
    share = height / np.where(crosses, height - next_height, 1.0)
    cuts = polygons + share[:, :, None] * (np.roll(polygons, -1, axis=1) - polygons)

    # Each corner is followed by the cut of the side after it. Remaining points come first.
    m, count = inside.shape
    corners = np.stack([polygons, cuts], axis=2).reshape(m, 2 * count, 2)
    remains = np.stack([inside, crosses], axis=2).reshape(m, 2 * count)
    largest = remains.sum(axis=1).max(initial=1)
    order = np.argsort(~remains, axis=1, kind="stable")[:, :largest]
    corners = np.take_along_axis(corners, order[:, :, None], axis=1)
    remains = np.take_along_axis(remains, order, axis=1)
    return np.where(remains[:, :, None], corners, corners[:, :1])


def _sizes(parts: Array) -> Array:
    """Signed lengths of intervals or areas of triangles."""
    if parts.shape[1] == 2:
        return np.asarray(parts[:, 1, 0] - parts[:, 0, 0])
    return _areas(parts[:, 0], parts[:, 1], parts[:, 2])


def _areas(a: Array, b: Array, c: Array) -> Array:
    """Signed areas of triangles with corners (..., 2)."""
    return np.asarray(((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]) / 2)
