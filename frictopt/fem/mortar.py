"""Joining the nodes of two faces by the dual mortar method.

If a face of body 1 reaches beyond the face of body 2, the part without an opposite face is free. If
more than half of a facet is free, some nodes of the facet lie beyond the edge of body 2. Such nodes
have no pair: the next pair of the contact represents them, see `independent_pairs`. So the pressure
on the part of the facet that lies opposite body 2 acts at this pair.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..base import COUNTS, ROUNDING, Array, Booleans, Integers, choice, first_of, place
from ..errors import ModelError
from .bodies import Body
from .coincidence import error_along, measured
from .contacts import Contact, Tie
from .elasticity import Kinematics, circumference
from .faces import (
    FACED,
    Face,
    Overlaps,
    areas_of,
    facet_overlaps,
    facets_around,
    mortar_projection,
    ordered_nodes,
    unit_vectors,
)
from .loads import values_at
from .normals import Planes, normals_of_faces

# Numbers for faces that reach beyond each other.

# If less than this share of a facet lies opposite body 2, it counts as facing nothing. The dual
# functions of a smaller part would lose six digits.
_LEAST_SHARE = 1e-3
# If less than this share of a flat facet lies beyond the other face, the cause is rounding in the
# drawing.
_DRAWN = 1e-3


@dataclass(frozen=True, eq=False)
class Joint:
    """The nodes of body 1 on a contact, and the places on body 2 that they are joined to."""

    # (n,) nodes of body 1, in the plane in the order of its face
    nodes: Integers
    # (n, d) normals into body 1, of any length
    normals: Array
    # (n,) tributary lengths; areas in axisymmetric models and in space
    widths: Array
    # (n, nodes of body 2) matrix of the places
    projection: csr_matrix
    # (n,) initial gap
    gap: Array
    # (n,) False if the node lies beyond the edge of body 2, so that another pair represents it
    inside: Booleans
    # nodes of facets of body 1 that lie, at least partly, opposite body 2
    opposite: Integers
    # length or area of the part of face 1 that lies opposite nothing, and its share of the face
    beyond: float
    share_beyond: float
    # mean length of the edges of body 1, divided by the mean length of the edges of body 2 that
    # face them
    coarser: float
    # largest distance by which facets may miss the curved faces that they approximate; 0 if no gap
    # was measured, or if all nodes touch up to rounding
    missed: float


def normals_into(contacts: Sequence[Contact], faces: Sequence[tuple[Face, Face]]) -> list[Array]:
    """(nodes of body 1, d) normals into body 1, for each contact with its two faces.

    Faces between the same two bodies that continue smoothly are treated as one face.
    """
    contacts_of_bodies = defaultdict[tuple[str, str], list[int]](list)
    for number, contact in enumerate(contacts):
        contacts_of_bodies[contact.body_1, contact.body_2].append(number)
    normals = dict[int, Array]()
    planes = Planes(faces[0][0].points.shape[1])
    for numbers in contacts_of_bodies.values():
        of_faces = normals_of_faces([faces[number][0] for number in numbers], planes)
        normals.update(zip(numbers, of_faces, strict=True))
    return [normals[number] for number in range(len(contacts))]


def join_faces(
    contact: Contact,
    face_1: Face,
    face_2: Face,
    normals: Array,
    touching: Integers,
    kinematics: Kinematics,
) -> Joint:
    """Join the nodes of the face of body 1 of a contact to places on the face of body 2.

    If the faces match, the places are nodes. `normals` (nodes of body 1, d) point into body 1, see
    `normals_into`; `touching` are nodes of body 1 that have been moved onto body 2.
    """
    nodes = np.unique(face_1.facets)
    if kinematics != "space":
        title = f"{contact.title}, body {contact.body_1!r}: boundary {contact.boundary_1!r}"
        nodes = ordered_nodes(face_1, title)
    overlaps, share = facing(face_1, face_2, contact)
    opposite = face_1.facets[share > 0]
    beyond, share_beyond = _part_beyond(share, face_1)
    overlaps, face_1, share = without_slivers(overlaps, face_1, share)

    is_joined = np.isin(nodes, face_1.facets)
    nodes = nodes[is_joined]
    inward = normals[nodes]
    inside = np.isin(nodes, face_1.facets[share >= FACED])
    _check_neighbours(nodes[inside], face_1, contact)

    # Axisymmetric faces are integrated around the axis, so their widths are areas.
    x = np.sum(overlaps.phi * face_1.points[overlaps.nodes_1, 0], axis=1)
    weights = overlaps.weights * circumference(x, kinematics)
    P, widths = mortar_projection(replace(overlaps, weights=weights), nodes, len(face_2.points))

    points = face_1.points[nodes]
    unit = unit_vectors(inward)
    error = error_along(unit, face_1.errors[nodes] + abs(P) @ face_2.errors)
    distance = np.sum((points - P @ face_2.points) * unit, axis=1)
    distance[np.isin(nodes, touching)] = 0.0
    allowed = error + sags(face_1, face_2, nodes, P)
    _check_overlap(points, distance, allowed, contact)
    missed = 0.0
    if contact.gap == "measured" or (contact.adjust is not None and not contact.gap):
        gap = measured(distance, error)
        # If all nodes touch, facets miss nothing: the gap of the curved faces is zero, too.
        if (np.abs(distance) > error).any():
            missed = float((allowed - error).max())
    else:
        gap = _checked_gap(points, distance, allowed, contact)

    is_opposite = np.isin(face_2.facets, P.indices).all(axis=1)
    length_1 = edge_length(face_1.corners)
    length_2 = edge_length(face_2.corners[is_opposite])
    return Joint(
        nodes=nodes,
        normals=inward,
        widths=widths,
        projection=P,
        gap=gap,
        inside=inside,
        opposite=np.unique(opposite),
        beyond=beyond,
        share_beyond=share_beyond,
        coarser=length_1 / length_2,
        missed=missed,
    )


def faces_of(part: Contact | Tie, bodies: Mapping[str, Body]) -> tuple[Face, Face]:
    """The faces of a contact or tie of two bodies, in facets through their corner nodes."""

    def face(name: str, boundary: str) -> Face:
        body = bodies[choice("contacts: body", name, bodies)]
        facets = body.boundary(boundary, f"{part.title}, body {name!r}")
        return Face(facets_around(body.mesh, facets), body.mesh.p.T, body.errors)

    return face(part.body_1, part.boundary_1), face(part.body_2, part.boundary_2)


def resultants(face: Face, nodes: Integers, forces: Array) -> Array:
    """(3, m) normal force, and sizes of shear and moment, of m forces (n, d, m) on n nodes.

    The normal force is the sum of the components along the normals into the body. The shear is the
    resultant of what remains. The moment is about the middle of the area of the nodes.
    """
    areas = np.zeros(face.points.shape)
    np.add.at(areas, face.facets, areas_of(face.corners)[:, None])
    areas, points = areas[nodes], face.points[nodes]
    normals = unit_vectors(areas)[..., None]
    along = (normals * forces).sum(axis=1)
    shear = (forces - normals * along[:, None]).sum(axis=0)
    arms = points - np.average(points, axis=0, weights=np.linalg.norm(areas, axis=1))
    products = np.einsum("na,nbm->abm", arms, forces)
    # Each component of the moment occurs twice in the products.
    moment = (products - products.swapaxes(0, 1)) / np.sqrt(2)
    sizes = np.linalg.norm(shear, axis=0), np.linalg.norm(moment, axis=(0, 1))
    found = np.array([along.sum(axis=0), *sizes])
    # A sum of forces that is only rounding counts as zero.
    rounding = ROUNDING * np.abs(forces).sum(axis=(0, 1))
    return np.where(np.abs(found) > np.outer([1.0, 1.0, np.abs(arms).max()], rounding), found, 0.0)


def sags(face_1: Face, face_2: Face, nodes: Integers, P: csr_matrix) -> Array:
    """(n,) distance by which both faces may miss each other at nodes of face 1.

    P (n, nodes of body 2) are the places of the nodes on face 2.
    """
    largest_2 = np.maximum.reduceat(face_2.sag()[P.indices], P.indptr[:-1])
    return face_1.sag()[nodes] + largest_2


def facing(face_1: Face, face_2: Face, part: Contact | Tie) -> tuple[Overlaps, Array]:
    """The overlaps of two faces, and how much (facets,) of each facet of face 1 faces face 2."""
    overlaps = facet_overlaps(face_1, face_2)
    share = _sums(overlaps, overlaps.weights, face_1) / face_1.sizes
    _check_faced(share, face_1, part)
    return overlaps, share


def _sums(overlaps: Overlaps, values: Array, face_1: Face) -> Array:
    """(facets,) sums of the values (m,) at points of integration over each facet of face 1."""
    return np.bincount(overlaps.facet, values, len(face_1.facets)).astype(float)


def edge_length(corners: Array) -> float:
    """Mean length of the edges of facets (facets, corners, d)."""
    return float(np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).mean())


def _around(corners: Array, part: Contact | Tie) -> str:
    """The face of body 1 around a facet (corners, d), in words."""
    return f"{part.title}: the face of body {part.body_1!r} around {place(corners.mean(axis=0))}"


def _check_faced(share: Array, face_1: Face, part: Contact | Tie) -> None:
    """Check, by the share (facets,) of each facet, that body 1 faces body 2, and only once."""
    corners = face_1.corners
    if share.max() < FACED:
        raise ModelError(
            f"{_around(corners[share.argmax()], part)} has no opposite part of body "
            f"{part.body_2!r}, or less than half of each facet has one; name the part that "
            "touches, exchange the bodies, or mesh body 1 finer; the elements of the two bodies "
            "must lie on opposite sides"
        )
    if share.max() > 1 + COUNTS:
        raise ModelError(
            f"{_around(corners[share.argmax()], part)} faces body {part.body_2!r} more than once; "
            "name only the part that touches, or mesh its curves finer"
        )


def _part_beyond(share: Array, face_1: Face) -> tuple[float, float]:
    """Length or area of the part of face 1 that lies opposite nothing, and its share of the face.

    Facets of round faces may miss each other by their sag: this does not count.
    """
    areas = face_1.sizes
    is_flat = face_1.sag()[face_1.facets].max(axis=1) == 0
    counts = (share < FACED) | (is_flat & (share < 1 - _DRAWN))
    beyond = float(np.sum((1 - share) * areas * counts))
    return beyond, beyond / float(areas.sum())


def without_slivers(overlaps: Overlaps, face_1: Face, share: Array) -> tuple[Overlaps, Face, Array]:
    """Overlaps, face 1 and shares, without facets of which only a sliver faces body 2."""
    faces_2 = share >= _LEAST_SHARE
    number = np.cumsum(faces_2) - 1
    counts = faces_2[overlaps.facet]
    kept = Overlaps(*(values[counts] for values in vars(overlaps).values()))
    facets = face_1.facets[faces_2]
    return replace(kept, facet=number[kept.facet]), replace(face_1, facets=facets), share[faces_2]


def _check_neighbours(inside: Integers, face_1: Face, part: Contact | Tie) -> None:
    """Check that each facet has at least one node that lies opposite body 2."""
    has_node = np.isin(face_1.facets, inside).any(axis=1)
    if (i := first_of(~has_node)) is not None:
        raise ModelError(
            f"{_around(face_1.corners[i], part)} has facets too large for the part of "
            f"body {part.body_2!r} that lies opposite; mesh body 1 finer there, or exchange the "
            "bodies"
        )


def _check_overlap(points: Array, distance: Array, allowed: Array, contact: Contact) -> None:
    """Check that nodes at points (n, d) lie at distances (n,) of at least `-allowed` (n,)."""
    if (i := first_of(distance < -allowed, -distance)) is not None:
        raise ModelError(
            f"{contact.title}, at {place(points[i])}: the bodies overlap by {-distance[i]:g}; move "
            "them apart, and give an Interference load (in a deck *CLEARANCE); or, if it is "
            "rounding or noise, give the Contact adjust= (in a deck *CONTACT PAIR, ADJUST=0)"
        )


def _checked_gap(points: Array, distance: Array, allowed: Array, contact: Contact) -> Array:
    """(n,) the given gap, after a check that nodes touch: distances are at most `allowed` (n,)."""
    if (i := first_of(distance > allowed, distance)) is not None:
        raise ModelError(
            f"{contact.title}, at {place(points[i])}: the faces do not touch, they are "
            f'{distance[i]:g} apart; move them, or give gap="measured" (in a deck no *CLEARANCE); '
            "or, if it is rounding or noise, give the Contact adjust= (in a deck *CONTACT PAIR, "
            "ADJUST)"
        )
    amount = contact.gap if callable(contact.gap) else 0.0
    gap = values_at(f"{contact.title}: gap", amount, points.T)
    if (i := first_of(gap < 0, -gap)) is not None:
        raise ModelError(
            f"{contact.title}, at {place(points[i])}: gap {gap[i]:g}; give gaps >= 0, and an "
            "Interference load for bodies that overlap"
        )
    return gap


def check_touching(
    bodies: Mapping[str, Body], joined: Mapping[tuple[str, str], list[Integers]]
) -> None:
    """Check that a contact joins two bodies wherever a facet of one lies on a facet of the other.

    `joined` maps the names of two bodies to the nodes of the first body that contacts join to the
    second. Facets of joined nodes are not checked, and neither are facets that meet in a point or
    at an edge. Curved faces count as touching only if their nodes coincide.
    """
    no_nodes = np.zeros(0, int)
    for name_1, name_2 in combinations(bodies, 2):
        both = bodies[name_1], bodies[name_2]
        near = sum(float(body.errors.max()) for body in both)
        # The box that both bodies have in common.
        low = np.max([body.mesh.p.min(axis=1) for body in both], axis=0) - near
        high = np.min([body.mesh.p.max(axis=1) for body in both], axis=0) + near
        faces = []
        for body, pair in zip(both, ((name_1, name_2), (name_2, name_1)), strict=True):
            nodes = np.concatenate([*joined.get(pair, []), no_nodes])
            facets = _free_facets(body.mesh, nodes, low, high)
            faces.append(Face(facets, body.mesh.p.T, body.errors))
        if not all(len(face.facets) for face in faces):
            continue
        middles = _touching(*faces)
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


def _touching(face_1: Face, face_2: Face) -> Array:
    """(m, d) middles of the parts of facets of face 1 that lie on facets of face 2."""
    overlaps = facet_overlaps(face_1, face_2)

    def at_points(of_1: Array, of_2: Array) -> tuple[Array, Array]:
        """(m, d) values of nodes of both faces at the points of integration."""
        return (
            np.einsum("mk,mkd->md", overlaps.phi, of_1[overlaps.nodes_1]),
            np.einsum("mk,mkd->md", overlaps.chi, of_2[overlaps.nodes_2]),
        )

    points_1, points_2 = at_points(face_1.points, face_2.points)
    difference = points_1 - points_2
    errors_1, errors_2 = at_points(face_1.errors, face_2.errors)
    error = error_along(unit_vectors(difference), errors_1 + errors_2)
    is_apart = measured(np.linalg.norm(difference, axis=1), error) > 0
    weights = np.where(is_apart, 0.0, overlaps.weights)
    sizes = _sums(overlaps, weights, face_1)
    touching = sizes > COUNTS * face_1.sizes
    moments = np.column_stack([_sums(overlaps, weights * x, face_1) for x in points_1.T])
    return moments[touching] / sizes[touching, None]
