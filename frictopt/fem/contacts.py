"""Contacts of a model: which faces of which bodies meet, how their nodes are joined, that no face is forgotten, and corners of several."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..base import COUNTS, Array, Integers, check_text, finite_number, first_of, place, shown
from ..contact import checked_springs
from ..errors import ModelError
from .bodies import Body
from .coincidence import along, coincident, measured, mesh_errors
from .elasticity import Kinematics, circumference, parts_of
from .faces import (
    FACED,
    Overlaps,
    areas_of,
    course,
    faced,
    facet_overlaps,
    facets_around,
    mortar_projection,
    sag,
)
from .loads import Part, values_at
from .normals import SMOOTH, normals_of_faces


@dataclass(frozen=True)
class Contact:
    """A contact: a face of body 1 that meets a face of body 2.

    The faces may be straight or curved, of any direction, closed or not, and their nodes need not
    match. The face of body 1 lies within that of body 2; its nodes are those of the contact, and it
    should be the finer one; of round faces that do not match, the one that turns, and not finer. In
    the plane that of body 1 is one chain of edges, in space facets are triangles or quadrilaterals.
    Each facet of body 1 faces body 2 along its normal with half of its length or area or more:
    round ends and rims may miss each other by their sag. Quadratic bodies meet in linear facets
    through their corner nodes, which the nodes amid edges follow. The two faces of a crack are
    faces of one body; the node at its tip, which both have, is in no pair. A taper below 1e-4 of a
    body that is free to slide is taken for rounding of the coordinates, see `normals` of
    `condense`.

    Parameters
    ----------
    body_1, body_2
        Names of the bodies in the model. Slips, gaps and reactions are those of body 1 relative to,
        or by, body 2.
    boundary_1, boundary_2
        Names of the two faces, each a boundary of the mesh of its body.
    name
        Name of the contact; None: that of `boundary_1`.
    gap
        None: the faces touch. A function of the coordinates (arrays): the initial gap at the nodes
        of faces that touch in the mesh, such as that of a rounded body. "measured": the distance of
        the meshes along the normal is the initial gap. On curved faces it has the error of the
        facets: overlaps up to their sag count as touching, so mesh finely enough that the sag is
        small beside the gap; a `ModelWarning` says where it is not. What the digits of the
        coordinates do not tell is no gap.
    tangential_stiffness, normal_stiffness
        Stiffness of the rough surfaces between the bodies, force per length^3, see
        `ContactSystem.with_contact_stiffness`; inf: rigid.

    Raises
    ------
    ModelError
        A name that is no text, a contact of a face with itself, a gap of another kind, a stiffness
        that is not positive.

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
            check_text(
                f"body_{side}", getattr(self, f"body_{side}"), "the name of a body of the model"
            )
            check_text(
                f"boundary_{side}",
                getattr(self, f"boundary_{side}"),
                "the name of a boundary of the mesh",
            )
        if (self.body_1, self.boundary_1) == (self.body_2, self.boundary_2):
            raise ModelError(
                f"boundary_2: {self.boundary_2!r} is that of body_1 too; a face cannot touch itself, name two faces"
            )
        if self.name is None:
            object.__setattr__(self, "name", self.boundary_1)
        check_text("name", self.name, "a printable text")
        if (
            self.gap is not None
            and not callable(self.gap)
            and not (isinstance(self.gap, str) and self.gap == "measured")
        ):
            raise ModelError(
                f"gap: {shown(self.gap)}; give 'measured' or a function of x and y, and z in space"
            )
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
    """The nodes of body 1 on a contact, where they are joined to body 2, and what is known of each."""

    nodes: Integers  # (n,) of body 1, in the plane in the order of its face
    normals: Array  # (n, d) into body 1, of any length
    widths: Array  # (n,) tributary lengths; axisymmetric and in space areas
    projection: csr_matrix  # (n, nodes of body 2) the places that the nodes are joined to
    gap: Array  # (n,) initial gap
    # mean length of the edges of body 1 over that of the edges of body 2 that face them; 1 where
    # the nodes match
    coarser: float
    # largest distance by which facets may miss the curved faces they stand for, over the widest
    # measured gap; 0 if none is measured
    missed: float


def normals_into(contacts: Sequence[Contact], bodies: Mapping[str, Body]) -> list[Array]:
    """(nodes of body 1, d) normals into body 1 of each contact; faces of the same two bodies that go on smoothly are one."""
    together = defaultdict[tuple[str, str], list[int]](list)
    for number, contact in enumerate(contacts):
        together[contact.body_1, contact.body_2].append(number)
    found = dict[int, Array]()
    for (name, _), numbers in together.items():
        mesh, faces = bodies[name].mesh, []
        for number in numbers:
            contact = contacts[number]
            faces.append(
                facets_around(
                    mesh,
                    bodies[name].boundary(
                        contact.boundary_1, f"contact {contact.name!r}, body {name!r}"
                    ),
                )
            )
        found.update(zip(numbers, normals_of_faces(faces, mesh.p.T), strict=True))
    return [found[number] for number in range(len(contacts))]


def joined(
    contact: Contact, body_1: Body, body_2: Body, normals: Array, kinematics: Kinematics
) -> Joint:
    """Join the nodes of two faces by the dual mortar method, which makes pairs of nodes where the faces match.

    `normals` (nodes of body 1, d) point into body 1, see `normals_into`.
    """
    start, other = (
        f"contact {contact.name!r}, body {name!r}" for name in (contact.body_1, contact.body_2)
    )
    facets, others = (
        body_1.boundary(contact.boundary_1, start),
        body_2.boundary(contact.boundary_2, other),
    )
    one, two, x, y = (
        facets_around(body_1.mesh, facets),
        facets_around(body_2.mesh, others),
        body_1.mesh.p.T,
        body_2.mesh.p.T,
    )
    nodes = np.unique(one) if kinematics == "space" else course(body_1, contact.boundary_1, start)
    errors, others_errors = mesh_errors(body_1.mesh), mesh_errors(body_2.mesh)
    inward = normals[nodes]
    overlaps = facet_overlaps(one, x, two, y)
    _check_faced(contact, overlaps, x[one])
    depth = circumference(np.sum(overlaps.phi * x[overlaps.own, 0], axis=1), kinematics)
    P, widths = mortar_projection(
        replace(overlaps, weights=overlaps.weights * depth), nodes, len(y)
    )
    unit = inward / np.linalg.norm(inward, axis=1)[:, None]
    error = along(unit, errors[nodes] + abs(P) @ others_errors)
    allowed = (
        error
        + sag(one, x, errors)[nodes]
        + np.maximum.reduceat(sag(two, y, others_errors)[P.indices], P.indptr[:-1])
    )
    coarser = _edge(x[one]) / _edge(y[two[np.isin(two, P.indices).all(axis=1)]])
    gap = _initial_gap(contact, x[nodes], np.sum((x[nodes] - P @ y) * unit, axis=1), error, allowed)
    missed = (
        float((allowed - error).max()) / max(float(gap.max()), float(error.min()))
        if contact.gap == "measured"
        else 0.0
    )
    return Joint(nodes, inward, widths, P, gap, coarser, missed)


def _edge(corners: Array) -> float:
    """Mean length of the edges of facets."""
    return float(np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).mean())


def _initial_gap(
    contact: Contact, points: Array, distance: Array, error: Array, allowed: Array
) -> Array:
    """(n,) initial gap at nodes of body 1 that are away from their places on body 2 by a distance (n,); `allowed` (n,) counts as nothing.

    A measured gap counts from the error (n,) of the coordinates on.
    """
    start = f"contact {contact.name!r}, at"
    if (i := first_of(distance < -allowed, -distance)) is not None:
        raise ModelError(
            f"{start} {place(points[i])}: the bodies overlap by {-distance[i]:g}; move them apart, and give an Interference load"
        )
    if contact.gap == "measured":
        return measured(distance, error)
    if (i := first_of(distance > allowed, distance)) is not None:
        raise ModelError(
            f'{start} {place(points[i])}: the faces do not touch, they are {distance[i]:g} apart; move them, or say gap="measured"'
        )
    gap = values_at(
        f"contact {contact.name!r}: gap", contact.gap if callable(contact.gap) else 0.0, points.T
    )
    if (i := first_of(gap < 0, -gap)) is not None:
        raise ModelError(
            f"{start} {place(points[i])}: gap {gap[i]:g}; give gaps >= 0, and an Interference load for bodies that overlap"
        )
    return gap


def _check_faced(contact: Contact, overlaps: Overlaps, one: Array) -> None:
    """Check that facets (m, corners, 3) of body 1 face those of body 2, once, and each with half of its area or more."""
    share = faced(overlaps, one)
    i, few = (int(share.argmin()), True) if share.min() < FACED else (int(share.argmax()), False)
    start = f"contact {contact.name!r}: the face of body {contact.body_1!r} around {place(one[i].mean(axis=0))} faces"
    if few:
        raise ModelError(
            f"{start} nothing of body {contact.body_2!r}; name only the part that touches, or exchange the bodies; the elements of body 1 and of "
            "body 2 belong on opposite sides"
        )
    if share.max() > 1 + COUNTS:
        raise ModelError(
            f"{start} body {contact.body_2!r} more than once; name only the part that touches, or mesh its curves finer"
        )


def check_touching(
    bodies: Mapping[str, Body], joined: Mapping[tuple[str, str], list[Integers]]
) -> None:
    """Check that two bodies are joined, body and other body -> nodes of the body, wherever a facet of one lies on a facet of the other.

    Facets that meet in a point or at an edge do not count, nor those whose nodes a contact of the
    two bodies joins. Curved faces are seen where the nodes of both sides coincide.
    """
    for one, two in combinations(bodies, 2):
        nodes = [
            np.concatenate([*joined.get(pair, []), np.zeros(0, int)])
            for pair in ((one, two), (two, one))
        ]
        meshes = bodies[one].mesh, bodies[two].mesh
        errors = [mesh_errors(mesh) for mesh in meshes]
        near = sum(float(error.max()) for error in errors)
        low, high = (
            pick([edge(mesh.p, axis=1) for mesh in meshes], axis=0)
            for pick, edge in ((np.max, np.min), (np.min, np.max))
        )
        P, Q = (
            _free_facets(mesh, own, low - near, high + near)
            for mesh, own in zip(meshes, nodes, strict=True)
        )
        if (
            len(P)
            and len(Q)
            and len(at := _common(P, meshes[0].p.T, errors[0], Q, meshes[1].p.T, errors[1]))
        ):
            raise ModelError(
                f"contacts: bodies {one!r} and {two!r} touch around {place(at[0])}, and no contact joins them there: they would pass through each "
                "other; add a Contact of these faces, all of them (a corner may belong to several), or move or merge the bodies"
            )


def _free_facets(mesh: Mesh, joined: Integers, low: Array, high: Array) -> Integers:
    """(facets, corners) nodes of the facets of the outline that reach into a box and are not joined, in the order around the body."""
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    corners = mesh.p[:, nodes]
    free = ~np.isin(nodes, joined).all(axis=0)
    free &= (corners.max(axis=1) >= low[:, None]).all(axis=0) & (
        corners.min(axis=1) <= high[:, None]
    ).all(axis=0)
    return facets_around(mesh, outline[free])


def _common(
    P: Integers, x: Array, x_errors: Array, Q: Integers, y: Array, y_errors: Array
) -> Array:
    """(m, d) the middles of what facets of one body have in common with the facets of the other one that they lie on."""
    overlaps = facet_overlaps(P, x, Q, y)
    at, on = (
        np.einsum("mk,mkd->md", overlaps.phi, x[overlaps.own]),
        np.einsum("mk,mkd->md", overlaps.chi, y[overlaps.other]),
    )
    errors = np.einsum("mk,mkd->md", overlaps.phi, x_errors[overlaps.own]) + np.einsum(
        "mk,mkd->md", overlaps.chi, y_errors[overlaps.other]
    )
    distance = np.linalg.norm(at - on, axis=1)
    error = along((at - on) / np.maximum(distance, np.finfo(float).tiny)[:, None], errors)
    weights = np.where(measured(distance, error) > 0, 0.0, overlaps.weights)
    sizes = np.bincount(overlaps.facet, weights, minlength=len(P))
    touching = sizes > COUNTS * np.linalg.norm(areas_of(x[P]), axis=1)
    middles = np.column_stack(
        [np.bincount(overlaps.facet, weights * part, minlength=len(P)) for part in at.T]
    )
    return np.asarray(middles[touching] / sizes[touching, None])


def shares(
    contacts: Sequence[Contact],
    contact: Integers,
    nodes: Integers,
    others: Integers,
    points: Array,
    normals: Array,
    widths: Array,
    errors: Array,
) -> tuple[Integers, csr_matrix, Array]:
    """The pairs that are kept of N, the (kept, N) matrix of the means that their relative motions stand for, and their (kept, d) normals.

    None of these motions follows from others. Where three bodies meet in a point, the relative
    motion of two of them follows from that of each to the third one, and so it does for two
    contacts of the same two bodies. Of such a circle the pair of the last contact is dissolved: the
    next one of its contact stands for both, for the mean of their relative motions weighted by
    their widths. So a uniform traction still passes through (as for the multipliers at cross points
    of the mortar method, Wohlmuth 2000). Where a face goes on smoothly from one contact of two
    bodies to another, that of the first one stands for both, with the sum of their normals: a face
    with two names is one face. A node that both faces have, at the tip of a crack, is no pair: what
    moves it relative to its place, where the faces do not match, counts with the next pair, of
    which the width stays.

    Of each pair are given the number of the contact, increasing, the node of body 1 and the one of
    body 2 that it lies on (-1: none), the place, the normal, of any length, and the width; and the
    errors of the coordinates of the place.
    """
    n, still = len(nodes), nodes == others
    i, j = coincident(points, errors)
    spot = parts_of((i, j), n)
    crowded = np.flatnonzero((np.bincount(spot)[spot] > 1) & ~still).tolist()
    ends = [
        [
            (contacts[contact[k]].body_1, int(nodes[k])),
            (contacts[contact[k]].body_2, int(others[k])),
        ]
        for k in crowded
    ]
    at = {
        (body, int(spot[k])): node
        for k, pair in zip(crowded, ends, strict=True)
        for body, node in pair
        if node >= 0
    }
    joined, kept = DisjointSet(), ~still
    for k, pair in zip(crowded, ends, strict=True):
        one, two = (
            node if node >= 0 else at.get((body, int(spot[k])), (body, int(spot[k])))
            for body, node in pair
        )
        joined.add(one)
        joined.add(two)
        kept[k] = joined.merge(one, two)
    heir, total, unit = (
        np.arange(n),
        normals.copy(),
        normals / np.linalg.norm(normals, axis=1)[:, None],
    )
    opposite = np.array([one.body_2 for one in contacts])[contact]
    for k in np.flatnonzero(~kept).tolist():
        on = kept & (nodes == nodes[k]) & (opposite == opposite[k]) & (unit @ unit[k] > SMOOTH)
        free = np.flatnonzero(kept & (contact == contact[k]))
        if not len(free):
            name = contacts[contact[k]].name
            raise ModelError(
                f"contacts: all nodes of {name!r} are corners that contacts before it have; mesh it with two elements, or list it first"
            )
        if on.any():
            heir[k] = on.argmax()
            total[heir[k]] += normals[k]
        else:
            heir[k] = free[np.linalg.norm(points[free] - points[k], axis=1).argmin()]
    whole = np.bincount(heir, np.where(still, 0.0, widths), minlength=n)
    return (
        np.flatnonzero(kept),
        csr_matrix((widths / whole[heir], (heir, np.arange(n))), shape=(n, n))[kept],
        total[kept],
    )
