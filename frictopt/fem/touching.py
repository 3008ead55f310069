"""Faces of two bodies that lie on each other, in any number of dimensions: each of them belongs to a contact."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from skfem import Mesh

from ..contact.checks import Array, place
from ..contact.tolerances import COUNTS, SAME_POINT
from ..errors import ModelError
from .bodies import Body
from .clipping import facet_overlaps
from .faces import areas_of, facets_around
from .ordering import Integers


def check_touching(bodies: Mapping[str, Body], joined: Mapping[tuple[str, str], list[Integers]]) -> None:
    """Check that two bodies are joined wherever a facet of one lies on a facet of the other.

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
        meshes = bodies[one].mesh, bodies[two].mesh
        near = SAME_POINT * min(float(np.ptp(mesh.p, axis=1).max()) for mesh in meshes)
        low, high = (pick([edge(mesh.p, axis=1) for mesh in meshes], axis=0) for pick, edge in ((np.max, np.min), (np.min, np.max)))
        P, Q = (_free_facets(mesh, own, low - near, high + near) for mesh, own in zip(meshes, nodes, strict=True))
        if len(P) and len(Q) and len(at := _common(P, meshes[0].p.T, Q, meshes[1].p.T, near)):
            raise ModelError(
                f"contacts: bodies {one!r} and {two!r} touch around {place(at[0])}, and no contact joins them there: they would pass "
                "through each other; add a Contact of these faces, all of them (a corner may belong to several), or move the bodies apart, or "
                "merge them"
            )


def _free_facets(mesh: Mesh, joined: Integers, low: Array, high: Array) -> Integers:
    """(facets, corners) nodes of the facets of the outline that reach into a box and are not joined, in the order around the body."""
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    corners = mesh.p[:, nodes]
    free = ~np.isin(nodes, joined).all(axis=0)
    free &= (corners.max(axis=1) >= low[:, None]).all(axis=0) & (corners.min(axis=1) <= high[:, None]).all(axis=0)
    return facets_around(mesh, outline[free])


def _common(P: Integers, x: Array, Q: Integers, y: Array, near: float) -> Array:
    """(m, d) the middles of what facets of one body have in common with the facets of the other one that they lie on."""
    overlaps = facet_overlaps(P, x, Q, y)
    at, on = np.einsum("mk,mkd->md", overlaps.phi, x[overlaps.own]), np.einsum("mk,mkd->md", overlaps.chi, y[overlaps.other])
    weights = np.where(np.linalg.norm(at - on, axis=1) <= near, overlaps.weights, 0.0)
    sizes = np.bincount(overlaps.facet, weights, minlength=len(P))
    touching = sizes > COUNTS * np.linalg.norm(areas_of(x[P]), axis=1)
    middles = np.column_stack([np.bincount(overlaps.facet, weights * part, minlength=len(P)) for part in at.T])
    return np.asarray(middles[touching] / sizes[touching, None])
