"""Joining the nodes of two faces by the dual mortar method.

If a face of body 1 reaches beyond the face of body 2, the part without an opposite face is free. A
facet that does so by more than half would have nodes beyond the edge. Such nodes have no pair: the
next pair of the contact represents them, see `independent_pairs`. So the pressure on the part of
the facet that lies opposite body 2 acts there.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from ..base import COUNTS, Array, Booleans, Integers, first_of, place
from ..errors import ModelError
from .coincidence import error_along, measured
from .elasticity import Kinematics, circumference
from .faces import FACED, Overlaps, areas_of, faced, facet_overlaps, mortar_projection, sag

# Numbers for faces that reach beyond each other.

# A facet faces nothing if less than this share of it does not. The dual functions of a smaller
# part, which has the size of its square in a corner, would lose six digits.
_LEAST_SHARE = 1e-3
# A smaller share of a flat facet beyond the other face is rounding of its drawing.
_DRAWN = 1e-3
NO_NODES: Integers = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True)
class FaceNames:
    """Names of a contact, of its face of body 1 and of its body 2, for error messages."""

    contact: str
    face_1: str
    body_2: str


@dataclass(frozen=True, eq=False)
class Face:
    """A face of a body: nodes (facets, corners) of its facets, and all points with errors."""

    facets: Integers
    points: Array
    errors: Array

    @property
    def corners(self) -> Array:
        """(facets, corners, d) places of the corners of the facets."""
        return np.asarray(self.points[self.facets])

    def sag(self) -> Array:
        """(nodes,) distances by which facets may miss the curved face."""
        return sag(self.facets, self.points, self.errors)


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
    # (n,) False: the node lies beyond the edge of body 2, and another pair represents it
    inside: Booleans
    # nodes of facets of body 1 that lie, at least partly, opposite body 2
    opposite: Integers
    # length or area of the face of body 1 opposite nothing, and its share of the face
    beyond: float
    share_beyond: float
    # mean length of the edges of body 1, divided by that of the edges of body 2 that face them
    coarser: float
    # largest distance by which facets may miss the curved faces that they stand for; 0 if no gap
    # was measured, or if all nodes touch up to rounding
    missed: float


def joined(
    face_1: Face,
    face_2: Face,
    nodes: Integers,
    normals: Array,
    given_gap: Callable[[Array], Array] | None,
    names: FaceNames,
    kinematics: Kinematics,
    touching: Integers = NO_NODES,
) -> Joint:
    """Join the nodes (n,) of face 1, with normals (n, d) into body 1, to places on face 2.

    If the faces match, the places are nodes. `given_gap` is the initial gap at points (n, d) of
    faces that touch; None: it is measured. Some nodes are `touching`, whatever their distance.
    """
    overlaps, share = facing(face_1, face_2, names)
    opposite = face_1.facets[share > 0]
    beyond, share_beyond = _part_beyond(share, face_1)
    overlaps, face_1, share = without_slivers(overlaps, face_1, share)

    is_joined = np.isin(nodes, face_1.facets)
    nodes = nodes[is_joined]
    inward = normals[is_joined]
    inside = np.isin(nodes, face_1.facets[share >= FACED])
    _check_neighbours(nodes[inside], face_1, names)

    # Axisymmetric faces are integrated around the axis, so their widths are areas.
    x = np.sum(overlaps.phi * face_1.points[overlaps.nodes_1, 0], axis=1)
    weights = overlaps.weights * circumference(x, kinematics)
    P, widths = mortar_projection(replace(overlaps, weights=weights), nodes, len(face_2.points))

    points = face_1.points[nodes]
    unit = inward / np.linalg.norm(inward, axis=1)[:, None]
    error = error_along(unit, face_1.errors[nodes] + abs(P) @ face_2.errors)
    distance = np.sum((points - P @ face_2.points) * unit, axis=1)
    distance[np.isin(nodes, touching)] = 0.0
    largest_sag_2 = np.maximum.reduceat(face_2.sag()[P.indices], P.indptr[:-1])
    allowed = error + face_1.sag()[nodes] + largest_sag_2
    _check_overlap(points, distance, allowed, names)
    missed = 0.0
    if given_gap is None:
        gap = measured(distance, error)
        # Nodes that touch need no facets: there the gap of the curved faces is zero, too.
        if (np.abs(distance) > error).any():
            missed = float((allowed - error).max())
    else:
        gap = _checked_gap(given_gap(points), points, distance, allowed, names)

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


def facing(face_1: Face, face_2: Face, names: FaceNames) -> tuple[Overlaps, Array]:
    """The overlaps of two faces, and the share (facets,) of each facet of face 1 that faces 2."""
    overlaps = facet_overlaps(face_1.facets, face_1.points, face_2.facets, face_2.points)
    share = faced(overlaps, face_1.corners)
    _check_faced(share, face_1, names)
    return overlaps, share


def edge_length(corners: Array) -> float:
    """Mean length of the edges of facets (facets, corners, d)."""
    return float(np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).mean())


def _around(corners: Array, names: FaceNames) -> str:
    """The face of body 1 around a facet (corners, d), in words."""
    return f"{names.contact}: {names.face_1} around {place(corners.mean(axis=0))}"


def _check_faced(share: Array, face_1: Face, names: FaceNames) -> None:
    """Check that facets of body 1 face body 2, by a share (facets,) of each, and only once."""
    corners = face_1.corners
    if share.max() < FACED:
        raise ModelError(
            f"{_around(corners[share.argmax()], names)} has no opposite part of {names.body_2}, "
            "or less than half of each facet has one; name the part that touches, exchange the "
            "bodies, or "
            "mesh body 1 finer; the elements of the two bodies must lie on opposite sides"
        )
    if share.max() > 1 + COUNTS:
        raise ModelError(
            f"{_around(corners[share.argmax()], names)} faces {names.body_2} more than once; "
            "name only the part that touches, or mesh its curves finer"
        )


def _part_beyond(share: Array, face_1: Face) -> tuple[float, float]:
    """Length or area of the face of body 1 that lies opposite nothing, and its share of the face.

    Facets of round faces may miss each other by their sag: this does not count.
    """
    areas = np.linalg.norm(areas_of(face_1.corners), axis=1)
    is_flat = face_1.sag()[face_1.facets].max(axis=1) == 0
    counts = (share < FACED) | (is_flat & (share < 1 - _DRAWN))
    beyond = float(np.sum((1 - share) * areas * counts))
    return beyond, beyond / float(areas.sum())


def without_slivers(overlaps: Overlaps, face_1: Face, share: Array) -> tuple[Overlaps, Face, Array]:
    """Overlaps, face 1 and shares without the facets that face nothing but a sliver."""
    faces_2 = share >= _LEAST_SHARE
    number = np.cumsum(faces_2) - 1
    counts = faces_2[overlaps.facet]
    return (
        Overlaps(
            facet=number[overlaps.facet[counts]],
            weights=overlaps.weights[counts],
            nodes_1=overlaps.nodes_1[counts],
            phi=overlaps.phi[counts],
            nodes_2=overlaps.nodes_2[counts],
            chi=overlaps.chi[counts],
        ),
        replace(face_1, facets=face_1.facets[faces_2]),
        share[faces_2],
    )


def _check_neighbours(inside: Integers, face_1: Face, names: FaceNames) -> None:
    """Check that each facet has one of the nodes that lie opposite body 2."""
    has_node = np.isin(face_1.facets, inside).any(axis=1)
    if (i := first_of(~has_node)) is not None:
        raise ModelError(
            f"{_around(face_1.corners[i], names)} has facets too large for the part of "
            f"{names.body_2} that lies opposite; mesh body 1 finer there, or exchange the bodies"
        )


def _check_overlap(points: Array, distance: Array, allowed: Array, names: FaceNames) -> None:
    """Check that nodes at points (n, d) lie at distances (n,) of at least `-allowed` (n,)."""
    if (i := first_of(distance < -allowed, -distance)) is not None:
        raise ModelError(
            f"{names.contact}, at {place(points[i])}: the bodies overlap by {-distance[i]:g}; move "
            "them apart, and give an Interference load (in a deck *CLEARANCE); or, if it is "
            "rounding or noise, give the Contact adjust= (in a deck *CONTACT PAIR, ADJUST=0)"
        )


def _checked_gap(
    gap: Array, points: Array, distance: Array, allowed: Array, names: FaceNames
) -> Array:
    """(n,) given gap, checked, of nodes that touch: their distances are at most `allowed` (n,)."""
    if (i := first_of(distance > allowed, distance)) is not None:
        raise ModelError(
            f"{names.contact}, at {place(points[i])}: the faces do not touch, they are "
            f'{distance[i]:g} apart; move them, or give gap="measured" (in a deck no *CLEARANCE); '
            "or, if it is rounding or noise, give the Contact adjust= (in a deck *CONTACT PAIR, "
            "ADJUST)"
        )
    if (i := first_of(gap < 0, -gap)) is not None:
        raise ModelError(
            f"{names.contact}, at {place(points[i])}: gap {gap[i]:g}; give gaps >= 0, and an "
            "Interference load for bodies that overlap"
        )
    return gap
