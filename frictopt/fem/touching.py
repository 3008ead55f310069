"""Faces of two bodies that lie on each other, in any number of dimensions: each of them belongs to a contact."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from skfem import Mesh

from ..contact.checks import Array, place
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from .bodies import Body
from .faces import facets_around, neighbours, normals_of
from .ordering import Integers


def check_touching(bodies: Mapping[str, Body], joined: Mapping[tuple[str, str], list[Integers]]) -> None:
    """Check that two bodies are joined wherever a flat facet of one lies on a facet of the other.

    Facets that meet in a point or at an edge do not count, nor those whose nodes a contact of the two bodies joins. Curved faces are seen where the
    nodes of both sides coincide.

    Parameters
    ----------
    bodies
        Name -> body, with its `mesh`.
    joined
        Body, other body -> nodes of the body that contacts join to the other one.

    Raises
    ------
    ModelError
        They are not.
    """
    for one, two in combinations(bodies, 2):
        nodes = [np.concatenate([*joined.get(pair, []), np.zeros(0, int)]) for pair in ((one, two), (two, one))]
        sides = list(zip((bodies[one].mesh, bodies[two].mesh), nodes, strict=True))
        near = SAME_POINT * min(float(np.ptp(mesh.p, axis=1).max()) for mesh, _ in sides)
        low, high = (pick([edge(mesh.p, axis=1) for mesh, _ in sides], axis=0) for pick, edge in ((np.max, np.min), (np.min, np.max)))
        P, Q = (_free_facets(mesh, nodes, low - near, high + near) for mesh, nodes in sides)
        if not (P.size and Q.size and len(pairs := _overlapping(P, Q, near))):
            continue
        i, j = pairs[np.lexsort(P[pairs[:, 0]].mean(axis=1).T[::-1])[0]]
        middle = (np.maximum(P[i].min(axis=0), Q[j].min(axis=0)) + np.minimum(P[i].max(axis=0), Q[j].max(axis=0))) / 2
        raise ModelError(
            f"contacts: bodies {one!r} and {two!r} touch around {place(middle)}, and no contact joins them there: they would pass "
            "through each other; add a Contact of these faces, all of them (a corner may belong to several), or move the bodies apart, or merge them"
        )


def _free_facets(mesh: Mesh, joined: Integers, low: Array, high: Array) -> Array:
    """(facets, corners, d) corners of the facets of the outline that reach into a box and are not joined, in the order around the body."""
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    corners = mesh.p[:, nodes]
    free = ~np.isin(nodes, joined).all(axis=0)
    free &= (corners.max(axis=1) >= low[:, None]).all(axis=0) & (corners.min(axis=1) <= high[:, None]).all(axis=0)
    return np.asarray(mesh.p.T[facets_around(mesh, outline[free])])


def _overlapping(P: Array, Q: Array, near: float) -> Integers:
    """(pairs, 2) facets of two bodies, in one plane and with opposite normals, that overlap: by the separating axes of convex polygons."""
    middles = [facets.mean(axis=1) for facets in (P, Q)]
    radii = [np.linalg.norm(facets - middle[:, None], axis=2).max(axis=1) for facets, middle in zip((P, Q), middles, strict=True)]
    i, j = neighbours(middles[0], radii[0] + near, middles[1], radii[1])
    normals = normals_of(P), normals_of(Q)
    opposite = np.sum(normals[0][i] * normals[1][j], axis=1) < 0
    i, j = i[opposite], j[opposite]
    flat = np.abs(np.einsum("mkd,md->mk", P[i] - Q[j, :1], normals[1][j])).max(axis=1) <= near
    i, j = i[flat], j[flat]
    axes = np.concatenate([_edge_normals(P[i], normals[0][i]), _edge_normals(Q[j], normals[0][i])], axis=1)
    (a, b), (c, d) = ((reach.min(axis=2), reach.max(axis=2)) for reach in (np.einsum("mxd,mkd->mxk", axes, facets) for facets in (P[i], Q[j])))
    overlap = (np.minimum(b, d) - np.maximum(a, c) > near).all(axis=1)
    return np.column_stack([i[overlap], j[overlap]])


def _edge_normals(corners: Array, normal: Array) -> Array:
    """(facets, axes, d) directions in the plane of facets across their edges, of unit length; of an edge its own direction."""
    steps = np.roll(corners, -1, axis=1) - corners
    axes = steps[:, :1] if corners.shape[2] == 2 else np.cross(normal[:, None], steps)
    return np.asarray(axes / np.linalg.norm(axes, axis=2)[:, :, None])
