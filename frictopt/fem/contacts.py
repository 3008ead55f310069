"""Contacts of a model: which faces of which bodies meet, how their nodes are joined, and that no face is forgotten."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..contact import COUNTS, SAME_POINT, Array, Integers, check_text, finite_number, place, shown
from ..contact.parts import checked_springs
from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics, Part, circumference, values_at
from .faces import Overlaps, areas_of, course, facet_overlaps, facets_around, mortar_projection, node_normals, sag
from .given import same_point

_FACED = 0.5  # least share of a facet of body 1 that faces body 2: the ends and rims of round faces miss each other by their sag


@dataclass(frozen=True)
class Contact:
    """A contact: a face of body 1 that meets a face of body 2.

    The faces may be straight or curved, of any direction, closed or not, and their nodes need not match. The face of body 1 lies within that of
    body 2; its nodes are those of the contact, and it should be the finer one; of round faces that do not match, the one that turns, and not finer.
    In the plane that of body 1 is one chain of edges, in space facets are triangles or quadrilaterals. Each facet of body 1 faces body 2 along its
    normal with half of its length or area or more: round ends and rims may miss each other by their sag. Quadratic bodies meet in linear facets
    through their corner nodes, which the nodes amid edges follow. The two faces of a crack are faces of one body; the node at its tip, which both
    have, is in no pair. A taper below 1e-4 of a body that is free to slide is taken for rounding of the coordinates, see `normals` of `condense`.

    Parameters
    ----------
    body_1, body_2
        Names of the bodies in the model. Slips, gaps and reactions are those of body 1 relative to, or by, body 2.
    boundary_1, boundary_2
        Names of the two faces, each a boundary of the mesh of its body.
    name
        Name of the contact; None: that of `boundary_1`.
    gap
        None: the faces touch. A function of the coordinates (arrays): the initial gap at the nodes of faces that touch in the mesh, such as that of
        a rounded body. "measured": the distance of the meshes along the normal is the initial gap. On curved faces it has the error of the facets:
        overlaps up to their sag count as touching, so mesh finely enough that the sag is small beside the gap; a `ModelWarning` says
        where it is not.
    tangential_stiffness, normal_stiffness
        Stiffness of the rough surfaces between the bodies, force per length^3, see `ContactSystem.with_contact_stiffness`; inf: rigid.

    Raises
    ------
    ModelError
        A name that is no text, a contact of a face with itself, a gap of another kind, a stiffness that is not positive.

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
        for side in ("1", "2"):
            check_text(f"body_{side}", getattr(self, f"body_{side}"), "the name of a body of the model")
            check_text(f"boundary_{side}", getattr(self, f"boundary_{side}"), "the name of a boundary of the mesh")
        if (self.body_1, self.boundary_1) == (self.body_2, self.boundary_2):
            raise ModelError(f"boundary_2: {self.boundary_2!r} is that of body_1 too; a face cannot touch itself, name two faces")
        if self.name is None:
            object.__setattr__(self, "name", self.boundary_1)
        check_text("name", self.name, "a printable text")
        if self.gap is not None and not callable(self.gap) and not (isinstance(self.gap, str) and self.gap == "measured"):
            raise ModelError(f"gap: {shown(self.gap)}; give 'measured' or a function of x and y, and z in space")
        for side in ("tangential_stiffness", "normal_stiffness"):
            object.__setattr__(self, side, float(checked_springs(side, getattr(self, side), 1)[0]))


@dataclass(frozen=True)
class Interference(Part):
    """Interference as a load: the bodies overlap by `amount`, length, along the whole of a contact before they are assembled.

    Raises
    ------
    ModelError
        A contact that is no text, an amount that is negative or not finite.

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
    """The nodes of body 1 on a contact, where they are joined to body 2, and what is known of each.

    Parameters
    ----------
    nodes
        (n,) nodes of body 1, in the plane in the order of its face.
    normals
        (n, d) normals into body 1, of any length.
    widths
        (n,) tributary lengths; axisymmetric and in space areas.
    projection
        (n, nodes of body 2) matrix of the places that the nodes are joined to.
    gap
        (n,) initial gap.
    coarser
        Mean length of the edges of body 1 over that of the edges of body 2 that face them; 1 where the nodes match.
    missed
        Largest distance by which facets may miss the curved faces that they stand for, over the widest measured gap; 0 if none is measured.
    """

    nodes: Integers
    normals: Array
    widths: Array
    projection: csr_matrix
    gap: Array
    coarser: float
    missed: float


def joined(contact: Contact, body_1: Body, body_2: Body, kinematics: Kinematics) -> Joint:
    """Join the nodes of two faces by the dual mortar method, which makes pairs of nodes where the faces match.

    Raises
    ------
    ModelError
        A face that is unknown, one of body 1 in the plane in pieces; faces that do not face each other, do not touch or overlap, a face of body 1
        that reaches beyond that of body 2, a gap that is negative.
    """
    start, other = (f"contact {contact.name!r}, body {name!r}" for name in (contact.body_1, contact.body_2))
    facets, others = body_1.boundary(contact.boundary_1, start), body_2.boundary(contact.boundary_2, other)
    one, two, x, y = facets_around(body_1.mesh, facets), facets_around(body_2.mesh, others), body_1.mesh.p.T, body_2.mesh.p.T
    nodes, near = np.unique(one) if kinematics == "space" else course(body_1, contact.boundary_1, start), same_point(x)
    inward = node_normals(one, x)[nodes]
    overlaps = facet_overlaps(one, x, two, y)
    _check_faced(contact, overlaps, x[one])
    depth = circumference(np.sum(overlaps.phi * x[overlaps.own, 0], axis=1), kinematics)
    P, widths = mortar_projection(replace(overlaps, weights=overlaps.weights * depth), nodes, len(y))
    allowed = near + sag(one, x)[nodes] + np.maximum.reduceat(sag(two, y)[P.indices], P.indptr[:-1])
    coarser = _edge(x[one]) / _edge(y[two[np.isin(two, P.indices).all(axis=1)]])
    gap = _initial_gap(contact, x[nodes], x[nodes] - P @ y, inward, allowed)
    missed = float(allowed.max() - near) / max(float(gap.max()), near) if contact.gap == "measured" else 0.0
    return Joint(nodes, inward, widths, P, gap, coarser, missed)


def _edge(corners: Array) -> float:
    """Mean length of the edges of facets."""
    return float(np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).mean())


def _initial_gap(contact: Contact, points: Array, opening: Array, normals: Array, allowed: Array) -> Array:
    """(n,) initial gap at nodes of body 1 that are away from their places on body 2 by `opening` (n, d); `allowed` (n,) counts as nothing."""
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    distance = np.sum(opening * unit, axis=1)
    start, measured = f"contact {contact.name!r}, at", contact.gap == "measured"
    if np.any(distance < -allowed):
        i = int(distance.argmin())
        raise ModelError(f"{start} {place(points[i])}: the bodies overlap by {-distance[i]:g}; move them apart, and give an Interference load")
    if not measured and np.any(distance > allowed):
        i = int(distance.argmax())
        raise ModelError(f'{start} {place(points[i])}: the faces do not touch, they are {distance[i]:g} apart; move them, or say gap="measured"')
    if measured:
        return np.where(distance > SAME_POINT * np.ptp(points), distance, 0.0)
    gap = values_at(f"contact {contact.name!r}: gap", contact.gap if callable(contact.gap) else 0.0, points.T)
    if gap.min() < 0:
        i = int(gap.argmin())
        raise ModelError(f"{start} {place(points[i])}: gap {gap[i]:g}; give gaps >= 0, and an Interference load for bodies that overlap")
    return gap


def _check_faced(contact: Contact, overlaps: Overlaps, one: Array) -> None:
    """Check that facets (m, corners, 3) of body 1 face those of body 2, once, and each with half of its area or more."""
    middles = one.mean(axis=1)
    share = np.bincount(overlaps.facet, overlaps.weights, minlength=len(one)) / np.linalg.norm(areas_of(one), axis=1)
    if share.min() < _FACED:
        i = int(share.argmin())
        raise ModelError(
            f"contact {contact.name!r}: the face of body {contact.body_1!r} around {place(middles[i])} faces nothing of body {contact.body_2!r}; "
            "name only the part that touches, or exchange the bodies; the elements of body 1 and of body 2 belong on opposite sides"
        )
    if share.max() > 1 + COUNTS:
        i = int(share.argmax())
        raise ModelError(
            f"contact {contact.name!r}: the face of body {contact.body_1!r} around {place(middles[i])} faces body {contact.body_2!r} more than once, "
            "one place behind the other; name only the part that touches, or mesh its curves finer"
        )


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
