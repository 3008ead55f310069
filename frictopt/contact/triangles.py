"""Triangles between neighbouring nodes of a contact face, without triangles in its holes."""

from heapq import heapify, heappop, heappush

import numpy as np
from matplotlib.tri import Triangulation

from ..base import Array, Booleans
from ..base.checks import Names


def neighbours(
    names: Names | None, places: Array, has_value: Booleans, areas: Array | None
) -> Triangulation | None:
    """Triangles between neighbours (n, 2) of one contact that have values; None if there are none.

    `names` (n,) are the contacts of the nodes, None for one contact. `areas` (n,) are the areas of
    the nodes on the map, None if unknown; they show which triangles lie in a hole.
    """
    rank_tolerance = 1e-9 * float(np.ptp(places))
    if np.linalg.matrix_rank(places - places.mean(axis=0), tol=rank_tolerance) < 2:
        return None
    mesh = Triangulation(*places.T)
    corners = mesh.triangles
    hidden = _has_long_edge(places, corners)
    if names is not None:
        hidden |= (names[corners] != names[corners[:, :1]]).any(axis=1)
    if areas is not None:
        contact = np.zeros(len(places)) if names is None else names
        for name in np.unique(contact):
            nodes = contact == name
            _hide_holes(mesh, hidden, nodes[corners].all(axis=1), float(areas[nodes].sum()))
    hidden |= ~has_value[corners].all(axis=1)
    if hidden.all():
        return None
    mesh.set_mask(hidden)
    return mesh


def _has_long_edge(places: Array, corners: Array) -> Booleans:
    """Which triangles have an edge much longer than the median edges at their corners."""
    ends = corners[:, [[0, 1], [1, 2], [2, 0]]]
    lengths = np.linalg.norm(places[ends[..., 0]] - places[ends[..., 1]], axis=-1)
    usual = np.zeros(len(places))
    for node in range(len(places)):
        at_node = lengths[(corners == node).any(axis=1)]
        if at_node.size:
            usual[node] = np.median(at_node)
    # An edge this many times longer than the usual edges at its corners spans a hole or a notch.
    long_edge = 1.8
    return np.asarray(lengths.max(axis=1) > long_edge * usual[corners].max(axis=1))


def _hide_holes(mesh: Triangulation, hidden: Booleans, of_contact: Booleans, area: float) -> None:
    """Hide triangles in holes and notches, until the visible ones have the area of the contact.

    `of_contact` shows which triangles join nodes of this contact. Triangles in a hole join nodes of
    its rim. Each has an obtuse angle, opposite to the edge that faces the middle of the hole, and
    the most obtuse triangle is hidden first. Then its neighbours are at the edge of the drawn area.
    """
    corners = np.column_stack([mesh.x, mesh.y])[mesh.triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    sizes = np.abs(np.linalg.det(sides[:, :2])) / 2
    # The drawn area may exceed the area of the contact by a part in a thousand.
    full_area = 1.001
    excess = sizes[of_contact & ~hidden].sum() - full_area * area

    # Cosine of the angle opposite to each side.
    lengths = np.linalg.norm(sides, axis=2)
    before = np.roll(sides, 1, axis=1)
    after = np.roll(sides, -1, axis=1)
    products = np.roll(lengths, 1, axis=1), np.roll(lengths, -1, axis=1)
    opposite = -np.sum(before * after, axis=2) / products[0] / products[1]

    def free_obtuse_sides(triangle: int) -> list[tuple[float, int]]:
        """(cosine, triangle) of each side at the edge of the drawn area, if it is obtuse."""
        beyond = mesh.neighbors[triangle]
        is_free = (beyond < 0) | hidden[beyond] | ~of_contact[beyond]
        # A triangle lies in a hole only if the angle opposite to its edge in the hole has a cosine
        # below this number.
        obtuse_cosine = -0.1
        obtuse = is_free & (opposite[triangle] < obtuse_cosine)
        return [(cosine, triangle) for cosine in opposite[triangle][obtuse].tolist()]

    queue = []
    for triangle in np.flatnonzero(of_contact & ~hidden).tolist():
        queue += free_obtuse_sides(triangle)
    heapify(queue)
    while queue and excess > 0:
        _, triangle = heappop(queue)
        if hidden[triangle]:
            continue
        hidden[triangle] = True
        excess -= sizes[triangle]
        for neighbour in mesh.neighbors[triangle].tolist():
            if neighbour >= 0 and of_contact[neighbour] and not hidden[neighbour]:
                for side in free_obtuse_sides(neighbour):
                    heappush(queue, side)
