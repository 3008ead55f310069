"""Contacts of a model: which faces of which bodies meet, and how their nodes are joined."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, identity
from scipy.spatial import cKDTree

from ..contact.checks import Array, check_text, finite_number, place, shown
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics, circumference
from .faces import Face, face
from .forms import boundary_forces, values_at
from .mortar import foot_points, mortar_projection
from .ordering import Integers

__all__ = ["Contact", "Interference", "Joint", "joined"]

_ASKEW = 0.1  # share of a measured gap in space by which a node may lie aside of the normal: curved faces turn it


@dataclass(frozen=True)
class Contact:
    """A contact: a face of body 1 that meets a face of body 2.

    The faces may be straight or curved, of any direction, closed or not. In the plane each is one chain of edges, and the nodes need not match: the
    face of body 1 lies within that of body 2; its nodes are those of the contact, and it should be the finer one. In space each node of body 1 lies
    on a node of body 2, or opposite one, along the normal, where the bodies are apart.

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
        a rounded body. "measured": the distance of the meshes along the normal is the initial gap. On curved faces it has the error of the facets: in
        the plane overlaps up to their sag count as touching, so mesh finely enough that the sag is small beside the gap.

    Raises
    ------
    ModelError
        A name that is no text, a contact of a face with itself, a gap of another kind.

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


@dataclass(frozen=True)
class Interference:
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
        check_text("contact", self.contact, "the name of a contact of the model")
        object.__setattr__(self, "amount", finite_number("amount", self.amount, least=0.0))


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
    """

    nodes: Integers
    normals: Array
    widths: Array
    projection: csr_matrix
    gap: Array
    coarser: float


def joined(contact: Contact, body_1: Body, body_2: Body, kinematics: Kinematics) -> Joint:
    """Join the nodes of two faces: pairs where they match, else, in the plane, by the dual mortar method.

    Raises
    ------
    ModelError
        A face that is unknown or, in the plane, in pieces; faces that do not face each other, do not touch or overlap, a face of body 1 that is
        longer than that of body 2, nodes in space that do not match, a gap that is negative.
    """
    first, second = (f"contact {contact.name!r}, body {name!r}" for name in (contact.body_1, contact.body_2))
    facets = body_1.boundary(contact.boundary_1, first)
    inward = boundary_forces(body_1.mesh, facets, lambda _, normals: -normals, "space").T
    widths = boundary_forces(body_1.mesh, facets, lambda points, _: np.ones((1, *points.shape[1:])), kinematics)[0]
    coarser, own = 1.0, identity(body_2.mesh.p.shape[1], format="csr")
    if kinematics == "space":
        nodes = body_1.boundary_nodes(contact.boundary_1, first)
        others = body_2.boundary_nodes(contact.boundary_2, second)
        allowed = np.full(len(nodes), SAME_POINT * np.ptp(body_1.mesh.p))
        P = own[others[cKDTree(body_2.mesh.p[:, others].T).query(body_1.mesh.p[:, nodes].T)[1]]]
    else:
        one, two = face(body_1, contact.boundary_1, first), face(body_2, contact.boundary_2, second).reversed()
        nodes, near = one.nodes, SAME_POINT * float(one.lengths.sum())
        allowed = np.full(len(nodes), near)
        where = _matched(one, two, near)
        if where is not None:
            P = own[two.nodes[where]]
        else:
            facing, s = _facing(one, two, near, contact)
            P = mortar_projection(one, two.nodes[facing], s, body_2.mesh.p.shape[1], circumference(one.points[:, 0], kinematics), widths[nodes])
            allowed = near + one.sag + two.sag.max()
            coarser = float(one.lengths.mean() / np.hypot(*np.diff(two.points[facing], axis=0).T).mean())
    points = body_1.mesh.p[:, nodes].T
    gap = _initial_gap(contact, points, points - P @ body_2.mesh.p.T, inward[nodes], allowed)
    return Joint(nodes, inward[nodes], widths[nodes], P, gap, coarser)


def _initial_gap(contact: Contact, points: Array, opening: Array, normals: Array, allowed: Array) -> Array:
    """(n,) initial gap at nodes of body 1 that are away from their places on body 2 by `opening` (n, d); `allowed` (n,) counts as nothing."""
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    distance = np.sum(opening * unit, axis=1)
    aside = np.linalg.norm(opening - distance[:, None] * unit, axis=1) if points.shape[1] == 3 else np.zeros(len(points))
    start, measured = f"contact {contact.name!r}, at", contact.gap == "measured"
    if np.any(lost := aside > allowed + _ASKEW * measured * np.abs(distance)):
        i = int((aside * lost).argmax())
        raise ModelError(
            f"{start} {place(points[i])}: the next node of body {contact.body_2!r} is {aside[i]:g} aside of the normal; in space the nodes of both "
            "faces lie opposite each other: mesh the faces with the same nodes"
        )
    if np.any(distance < -allowed):
        i = int(distance.argmin())
        raise ModelError(f"{start} {place(points[i])}: the bodies overlap by {-distance[i]:g}; move them apart, and give an Interference load")
    if not measured and np.any(distance > allowed):
        i = int(distance.argmax())
        raise ModelError(
            f'{start} {place(points[i])}: the faces do not touch, they are {distance[i]:g} apart; move the bodies together, or say gap="measured"'
        )
    if measured:
        return np.where(distance > SAME_POINT * np.ptp(points), distance, 0.0)
    gap = values_at(f"contact {contact.name!r}: gap", contact.gap if callable(contact.gap) else 0.0, points.T)
    if gap.min() < 0:
        i = int(gap.argmin())
        raise ModelError(
            f"contact {contact.name!r}: gap {gap[i]:g} at {place(points[i])}; the bodies cannot overlap before loading, give gaps >= 0, and an "
            "Interference load"
        )
    return gap


def _matched(one: Face, two: Face, near: float) -> Integers | None:
    """Place of each node of face 1 in face 2, if the nodes match one by one."""
    distance, where = cKDTree(two.points).query(one.points)
    ahead = np.diff(where[one.chain])
    if two.closed:
        ahead %= len(two.nodes)
    return np.asarray(where) if distance.max() <= near and np.all(ahead == 1) else None


def _facing(one: Face, two: Face, near: float, contact: Contact) -> tuple[Integers, Array]:
    """Places in face 2 that face all of face 1, in order, and the arc lengths of face 1 that they face."""
    s, height = foot_points(one, two.points)
    length, chain = float(one.lengths.sum()), two.chain
    step = np.diff(s[chain])
    if one.closed:
        step -= length * np.round(step / length)
        meets = np.full(len(step), True)
    else:
        begins, ends = np.minimum(s[chain[:-1]], s[chain[1:]]), np.maximum(s[chain[:-1]], s[chain[1:]])
        meets = (begins < length - near) & (ends > near)
    meets &= step >= -near
    edges = np.flatnonzero(meets)
    if not len(edges):
        raise ModelError(
            f"contact {contact.name!r}: bodies {contact.body_1!r} and {contact.body_2!r} lie on the same side of it, they overlap, or their "
            "faces look away from each other; the elements of body 1 and of body 2 belong on opposite sides"
        )
    if two.closed and not one.closed:  # begin where it faces nothing
        begin = int(np.argmin(meets))
        edges = begin + np.flatnonzero(np.roll(meets, -begin))
    places = np.r_[edges, edges[-1] + 1] % len(two.nodes)
    arc = s[places]
    if one.closed:
        covered = two.closed and len(edges) == len(step) and round(step.sum() / length) == 1
        first = int(s.argmin())
        places = np.r_[first - 1, first + np.arange(len(s) + 1)] % len(s)
        arc = s[places] + length * np.r_[-1.0, np.zeros(len(s)), 1.0]
    else:
        slack = near + np.abs(height[places[[0, -1]]])  # across a gap, a foot point may move along by no more than the gap
        covered = bool(np.all(np.diff(edges) == 1) and arc[0] <= slack[0] and arc[-1] >= length - slack[1])
    if not covered:
        raise ModelError(
            f"contact {contact.name!r}: part of the face of body {contact.body_1!r}, from {place(one.points[0])} to {place(one.points[-1])}, "
            f"faces nothing of body {contact.body_2!r}; name only the part that touches, or exchange the bodies"
        )
    return places, np.maximum.accumulate(np.r_[min(arc[0], 0.0), arc[1:-1], max(arc[-1], length)])
