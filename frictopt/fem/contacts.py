"""Contacts of a model: the faces that meet, and how their nodes are joined."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ..base import COUNTS, Array, Integers, check_text, finite_number, first_of, place, shown
from ..contact import checked_springs
from ..errors import ModelError
from .bodies import Body
from .coincidence import error_along, measured, mesh_errors
from .elasticity import Kinematics, circumference
from .faces import (
    FACED,
    Overlaps,
    faced,
    facet_overlaps,
    facets_around,
    mortar_projection,
    ordered_nodes,
    sag,
)
from .loads import Part, values_at
from .normals import normals_of_faces


@dataclass(frozen=True)
class Contact:
    """A contact: a face of body 1 that meets a face of body 2.

    The faces may be straight or curved, of any direction, closed or not. Their nodes need not
    match. In the plane the face of body 1 is one chain of edges; in space facets are triangles or
    quadrilaterals.

    The face of body 1 lies within the face of body 2. Its nodes are the nodes of the contact, so it
    should have the finer mesh. For round faces whose meshes do not match, body 1 should be the
    rotating body, and its mesh should not be finer. At least half of the length or area of each
    facet of body 1 must face body 2 along its normal: ends and rims of round faces may miss each
    other by their sag.

    Quadratic bodies meet in linear facets through their corner nodes, and the midside nodes follow
    the corners. The two faces of a crack are faces of one body; the node at its tip, which both
    share, is in no pair. If a body is free to slide, a taper below 1e-4 is treated as rounding of
    the coordinates, see `normals` of `condense`.

    Parameters
    ----------
    body_1, body_2
        Names of the bodies in the model. Slips and gaps are motions of body 1 relative to body 2;
        reactions are forces of body 2 on body 1.
    boundary_1, boundary_2
        Names of the two faces, each a boundary of the mesh of its body.
    name
        Name of the contact; None: the name of `boundary_1`.
    gap
        None: the faces touch. A function of the coordinates (arrays): the initial gap at the nodes
        of faces that touch in the mesh, such as the gap of a rounded body. "measured": the distance
        of the meshes along the normal is the initial gap. On curved faces the measured gap has the
        error of the facets, and overlaps up to their sag are treated as touching. So mesh finely
        enough that the sag is small relative to the gap; otherwise a `ModelWarning` is issued. A
        distance below the last digit of the coordinates is no gap.
    tangential_stiffness, normal_stiffness
        Stiffness of the rough surfaces between the bodies, force per length^3, see
        `ContactSystem.with_contact_stiffness`; inf: rigid.

    Raises
    ------
    ModelError
        A name is no text, a face is in contact with itself, the gap is of another kind, or a
        stiffness is not positive.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Contact("blade", "disc", "left flank", "left flank").name
    'left flank'
    """

    body_1: str
    body_2: str
    boundary_1: str = "contact"
    boundary_2: str = "contact"
    name: str | None = None
    gap: Literal["measured"] | Callable[..., ArrayLike] | None = None
    tangential_stiffness: float = np.inf
    normal_stiffness: float = np.inf

    def __post_init__(self) -> None:
        body = "the name of a body of the model"
        boundary = "the name of a boundary of the mesh"
        check_text("body_1", self.body_1, body)
        check_text("boundary_1", self.boundary_1, boundary)
        check_text("body_2", self.body_2, body)
        check_text("boundary_2", self.boundary_2, boundary)
        if (self.body_1, self.boundary_1) == (self.body_2, self.boundary_2):
            raise ModelError(
                f"boundary_2: {self.boundary_2!r} is also the face of body_1; a face cannot touch "
                "itself, name two faces"
            )
        if self.name is None:
            object.__setattr__(self, "name", self.boundary_1)
        check_text("name", self.name, "a printable text")
        is_measured = isinstance(self.gap, str) and self.gap == "measured"
        if self.gap is not None and not callable(self.gap) and not is_measured:
            raise ModelError(
                f"gap: {shown(self.gap)}; give 'measured' or a function of x and y, and z in space"
            )
        for name in ("tangential_stiffness", "normal_stiffness"):
            stiffness = checked_springs(name, getattr(self, name), 1)[0]
            object.__setattr__(self, name, float(stiffness))


@dataclass(frozen=True)
class Interference(Part):
    """Interference as a load: the bodies overlap along a whole contact before assembly.

    Parameters
    ----------
    contact
        Name of the contact.
    amount
        Overlap, length, >= 0.

    Raises
    ------
    ModelError
        The contact is no text, or the amount is negative or not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Interference("bore", 0.02)
    Interference(contact='bore', amount=0.02)
    """

    contact: str = "contact"
    amount: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        finite_number("amount", self.amount, least=0.0)


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
    # mean length of the edges of body 1, divided by that of the edges of body 2 that face them
    coarser: float
    # largest distance by which facets may miss the curved faces that they stand for, divided by
    # the widest measured gap; 0 without a measured gap
    missed: float


def normals_into(contacts: Sequence[Contact], bodies: Mapping[str, Body]) -> list[Array]:
    """(nodes of body 1, d) normals into body 1 of each contact.

    Faces between the same two bodies that continue smoothly are treated as one face.
    """
    contacts_of_bodies = defaultdict[tuple[str, str], list[int]](list)
    for number, contact in enumerate(contacts):
        contacts_of_bodies[contact.body_1, contact.body_2].append(number)
    normals = dict[int, Array]()
    for (name, _), numbers in contacts_of_bodies.items():
        mesh = bodies[name].mesh
        faces = []
        for number in numbers:
            argument = f"contact {contacts[number].name!r}, body {name!r}"
            facets = bodies[name].boundary(contacts[number].boundary_1, argument)
            faces.append(facets_around(mesh, facets))
        normals.update(zip(numbers, normals_of_faces(faces, mesh.p.T), strict=True))
    return [normals[number] for number in range(len(contacts))]


@dataclass(frozen=True, eq=False)
class _Face:
    """A face of a body: nodes (facets, corners) of its facets, and all points with errors."""

    facets: Integers
    points: Array
    errors: Array

    @classmethod
    def from_boundary(cls, body: Body, boundary: str, argument: str) -> _Face:
        facets = facets_around(body.mesh, body.boundary(boundary, argument))
        return cls(facets, body.mesh.p.T, mesh_errors(body.mesh))

    def sag(self) -> Array:
        return sag(self.facets, self.points, self.errors)


def join_faces(
    contact: Contact, body_1: Body, body_2: Body, normals: Array, kinematics: Kinematics
) -> Joint:
    """Join the nodes of two faces by the dual mortar method.

    If the faces match, it makes pairs of nodes. `normals` (nodes of body 1, d) point into body 1,
    see `normals_into`.
    """
    argument = f"contact {contact.name!r}, body {contact.body_1!r}"
    face_1 = _Face.from_boundary(body_1, contact.boundary_1, argument)
    face_2 = _Face.from_boundary(
        body_2, contact.boundary_2, f"contact {contact.name!r}, body {contact.body_2!r}"
    )
    if kinematics == "space":
        nodes = np.unique(face_1.facets)
    else:
        nodes = ordered_nodes(body_1, contact.boundary_1, argument)
    overlaps = facet_overlaps(face_1.facets, face_1.points, face_2.facets, face_2.points)
    _check_faced(contact, overlaps, face_1.points[face_1.facets])

    # Axisymmetric faces are integrated around the axis, so their widths are areas.
    x = np.sum(overlaps.phi * face_1.points[overlaps.nodes_1, 0], axis=1)
    weights = overlaps.weights * circumference(x, kinematics)
    P, widths = mortar_projection(replace(overlaps, weights=weights), nodes, len(face_2.points))

    points = face_1.points[nodes]
    inward = normals[nodes]
    unit = inward / np.linalg.norm(inward, axis=1)[:, None]
    error = error_along(unit, face_1.errors[nodes] + abs(P) @ face_2.errors)
    distance = np.sum((points - P @ face_2.points) * unit, axis=1)
    largest_sag_2 = np.maximum.reduceat(face_2.sag()[P.indices], P.indptr[:-1])
    allowed = error + face_1.sag()[nodes] + largest_sag_2
    gap = _initial_gap(contact, points, distance, error, allowed)
    missed = 0.0
    if contact.gap == "measured":
        missed = float((allowed - error).max()) / max(float(gap.max()), float(error.min()))

    facing = np.isin(face_2.facets, P.indices).all(axis=1)
    length_1 = _edge_length(face_1.points[face_1.facets])
    length_2 = _edge_length(face_2.points[face_2.facets[facing]])
    return Joint(nodes, inward, widths, P, gap, length_1 / length_2, missed)


def _edge_length(corners: Array) -> float:
    """Mean length of the edges of facets (facets, corners, d)."""
    return float(np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).mean())


def _check_faced(contact: Contact, overlaps: Overlaps, corners: Array) -> None:
    """Check that each facet (facets, corners, d) of body 1 faces body 2, and only once."""
    share = faced(overlaps, corners)

    def face_around(i: int) -> str:
        return (
            f"contact {contact.name!r}: the face of body {contact.body_1!r} around "
            f"{place(corners[i].mean(axis=0))}"
        )

    if share.min() < FACED:
        raise ModelError(
            f"{face_around(int(share.argmin()))} faces nothing of body {contact.body_2!r}; name "
            "only the part that touches, or exchange the bodies; the elements of body 1 and of "
            "body 2 belong on opposite sides"
        )
    if share.max() > 1 + COUNTS:
        raise ModelError(
            f"{face_around(int(share.argmax()))} faces body {contact.body_2!r} more than once; "
            "name only the part that touches, or mesh its curves finer"
        )


def _initial_gap(
    contact: Contact, points: Array, distance: Array, error: Array, allowed: Array
) -> Array:
    """(n,) initial gap at nodes of body 1, from their distances (n,) to their places on body 2.

    Nodes at distances up to `allowed` (n,) touch. A measured gap below the error (n,) of the
    coordinates is zero.
    """
    name = f"contact {contact.name!r}"
    if (i := first_of(distance < -allowed, -distance)) is not None:
        raise ModelError(
            f"{name}, at {place(points[i])}: the bodies overlap by {-distance[i]:g}; move them "
            "apart, and give an Interference load"
        )
    if contact.gap == "measured":
        return measured(distance, error)
    if (i := first_of(distance > allowed, distance)) is not None:
        raise ModelError(
            f"{name}, at {place(points[i])}: the faces do not touch, they are {distance[i]:g} "
            'apart; move them, or give gap="measured"'
        )
    gap = values_at(f"{name}: gap", contact.gap if callable(contact.gap) else 0.0, points.T)
    if (i := first_of(gap < 0, -gap)) is not None:
        raise ModelError(
            f"{name}, at {place(points[i])}: gap {gap[i]:g}; give gaps >= 0, and an Interference "
            "load for bodies that overlap"
        )
    return gap
