"""Check that bodies that touch are joined by a contact."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from skfem import Mesh

from ..base import COUNTS, Array, Integers, place
from ..errors import ModelError
from .bodies import Body
from .coincidence import error_along, measured
from .faces import areas_of, facet_overlaps, facets_around, unit_vectors


def check_touching(
    bodies: Mapping[str, Body], joined: Mapping[tuple[str, str], list[Integers]]
) -> None:
    """Check that a contact joins two bodies wherever a facet of one lies on a facet of the other.

    `joined` maps the names of two bodies to the nodes of the first body that contacts of these two
    join. Facets of joined nodes do not count, and neither do facets that meet in a point or at an
    edge. Curved faces are seen if the nodes of both sides coincide.
    """
    no_nodes = np.zeros(0, int)
    for name_1, name_2 in combinations(bodies, 2):
        meshes = bodies[name_1].mesh, bodies[name_2].mesh
        errors = bodies[name_1].errors, bodies[name_2].errors
        near = sum(float(error.max()) for error in errors)
        # The box in which both bodies are.
        low = np.max([mesh.p.min(axis=1) for mesh in meshes], axis=0) - near
        high = np.min([mesh.p.max(axis=1) for mesh in meshes], axis=0) + near
        facets_1, facets_2 = (
            _free_facets(mesh, np.concatenate([*joined.get(pair, []), no_nodes]), low, high)
            for mesh, pair in zip(meshes, ((name_1, name_2), (name_2, name_1)), strict=True)
        )
        if not len(facets_1) or not len(facets_2):
            continue
        middles = _touching(facets_1, meshes[0].p.T, errors[0], facets_2, meshes[1].p.T, errors[1])
        if len(middles):
            raise ModelError(
                f"contacts: bodies {name_1!r} and {name_2!r} touch around {place(middles[0])}, "
                "without a contact there, so they would pass through each other; add a Contact of "
                "all these faces (a corner may belong to several contacts), or move or merge the "
                "bodies"
            )


def _free_facets(mesh: Mesh, joined: Integers, low: Array, high: Array) -> Integers:
    """(facets, corners) nodes of facets of the outline that reach into a box and are not joined."""
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    corners = mesh.p[:, nodes]  # (d, corners, facets)
    is_joined = np.isin(nodes, joined).all(axis=0)
    above = (corners.max(axis=1) >= low[:, None]).all(axis=0)
    below = (corners.min(axis=1) <= high[:, None]).all(axis=0)
    return facets_around(mesh, outline[~is_joined & above & below])


def _touching(
    facets_1: Integers,
    x: Array,
    x_errors: Array,
    facets_2: Integers,
    y: Array,
    y_errors: Array,
) -> Array:
    """(m, d) middles of the parts of facets of body 1 that lie on facets of body 2.

    Facets are given by their nodes, with the coordinates of the bodies and their errors.
    """
    overlaps = facet_overlaps(facets_1, x, facets_2, y)
    points_1 = np.einsum("mk,mkd->md", overlaps.phi, x[overlaps.nodes_1])
    points_2 = np.einsum("mk,mkd->md", overlaps.chi, y[overlaps.nodes_2])
    errors = np.einsum("mk,mkd->md", overlaps.phi, x_errors[overlaps.nodes_1]) + np.einsum(
        "mk,mkd->md", overlaps.chi, y_errors[overlaps.nodes_2]
    )
    difference = points_1 - points_2
    error = error_along(unit_vectors(difference), errors)
    is_apart = measured(np.linalg.norm(difference, axis=1), error) > 0
    weights = np.where(is_apart, 0.0, overlaps.weights)
    count = len(facets_1)
    sizes = np.bincount(overlaps.facet, weights, minlength=count)
    touching = sizes > COUNTS * np.linalg.norm(areas_of(x[facets_1]), axis=1)
    moments = np.column_stack(
        [np.bincount(overlaps.facet, weights * x_i, minlength=count) for x_i in points_1.T]
    )
    return np.asarray(moments[touching] / sizes[touching, None])
