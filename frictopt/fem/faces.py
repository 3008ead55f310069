"""Faces of meshed bodies: their facets, in any number of dimensions, and in the plane as one chain of nodes, in order."""

import numpy as np
from scipy.spatial import cKDTree
from skfem import Mesh

from ..contact.checks import Array, place
from ..errors import ModelError
from .bodies import Body
from .ordering import Integers


def facets_around(mesh: Mesh, facets: Integers) -> Integers:
    """(facets, corners) nodes of facets of the outline, in the order in which their normals point into the body."""
    nodes = np.array(mesh.facets[:, facets].T)
    corners = mesh.p.T[nodes]
    inward = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1).T - corners[:, 0]
    away = np.sum(normals_of(corners) * inward, axis=1) < 0
    nodes[away] = nodes[away][:, ::-1]
    return nodes


def normals_of(corners: Array) -> Array:
    """(facets, d) unit normals of facets (facets, corners, d): of an edge that turned by 90 degrees, of a polygon that of its area."""
    normals = areas_of(corners)
    return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])


def areas_of(corners: Array) -> Array:
    """(facets, d) normals of facets (facets, corners, d) with the length of an edge, or with the area of a polygon."""
    arms = corners - corners[:, :1]
    if corners.shape[2] == 2:
        return np.column_stack([-arms[:, 1, 1], arms[:, 1, 0]])
    return np.asarray(np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1) / 2)


def sag(facets: Integers, points: Array) -> Array:
    """(nodes,) distance by which the facets at a node may miss the curved face that they stand for, from the angle that they turn there."""
    corners = points[facets]
    normals, longest = normals_of(corners)[:, None], np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    mean, turn, worst = np.zeros_like(points), np.zeros(len(points)), np.zeros(len(points))
    np.add.at(mean, facets, normals)
    mean = mean / np.maximum(np.linalg.norm(mean, axis=1), np.finfo(float).tiny)[:, None]
    np.maximum.at(turn, facets, 4 * np.arcsin(np.minimum(np.linalg.norm(mean[facets] - normals, axis=2) / 2, 1.0)))
    np.maximum.at(worst, facets, (turn[facets].max(axis=1) * longest / 8)[:, None])
    return worst


def neighbours(places: Array, reach: Array, others: Array, radii: Array) -> tuple[Integers, Integers]:
    """Pairs i, j of places and others, (n, d) and (m, d), at a distance of at most `reach[i] + radii[j]`; the search goes by sizes of radii."""
    octave, pairs = np.ceil(np.log2(radii)), []
    for size in np.unique(octave):
        some = np.flatnonzero(octave == size)
        found = cKDTree(others[some]).query_ball_point(places, reach + radii[some].max())
        i, j = np.repeat(np.arange(len(places)), [len(part) for part in found]), some[np.concatenate(found).astype(np.intp)]
        near = np.linalg.norm(places[i] - others[j], axis=1) <= reach[i] + radii[j]
        pairs.append((i[near], j[near]))
    i, j = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return i, j


def course(body: Body, boundary: str, argument: str) -> Integers:
    """Nodes of a boundary in the plane in their order, the body on the left of the way; error messages call it `argument`.

    Raises
    ------
    ModelError
        Unknown, inside the body, in several pieces, or touching itself.
    """
    mesh, start = body.mesh, f"{argument}: boundary {boundary!r}"
    (line, closed), *others = lines_along(mesh, body.boundary(boundary, argument), start)
    if others:
        one, other = (place(mesh.p[:, nodes[0]]) for nodes in (line, others[0][0]))
        raise ModelError(f"{start} is in several pieces, one at {one}, another at {other}; make a contact of each piece")
    nodes = line[::-1]
    return np.roll(nodes, -int(nodes.argmin())) if closed else nodes


def lines_along(mesh: Mesh, facets: Integers, argument: str) -> list[tuple[Integers, bool]]:
    """Nodes of facets of a plane outline, line by line, the body on the right of the way, and whether the line is closed: it begins leftmost then.

    Raises
    ------
    ModelError
        A node that more than two facets share; the message calls the outline `argument`.
    """
    end, start = facets_around(mesh, facets).T
    for nodes in (start, end):
        if (np.bincount(nodes) > 1).any():
            raise ModelError(f"{argument} touches itself at {place(mesh.p[:, np.bincount(nodes).argmax()])}; make a contact of each part")
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    inner, lines = np.isin(start, end), []
    for i in np.lexsort((*mesh.p[::-1, start], inner)):  # ends of open lines come first
        node, line = int(start[i]), []
        while node in onward:
            line.append(node)
            node = onward.pop(node)
        if line:
            lines.append((np.array(line if inner[i] else [*line, node]), bool(inner[i])))
    return lines
