"""Contacts of a model, the corners that they share, and ties: faces that move together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import csr_matrix, diags, identity, kron

from ..base import (
    Array,
    Booleans,
    Integers,
    check_text,
    finite_number,
    first_of,
    flag,
    place,
    shown,
)
from ..contact import checked_springs
from ..errors import ModelError
from .bodies import check_names
from .coincidence import coincident
from .elasticity import parts_of
from .faces import unit_vectors
from .loads import Part
from .normals import SMOOTH
from .supports import Place, checked_place


@dataclass(frozen=True)
class Contact:
    """A contact: a face of body 1 that meets a face of body 2.

    The faces may be straight or curved, of any direction, closed or not. Their nodes need not
    match. In the plane the face of body 1 is one chain of edges; in space facets are triangles or
    quadrilaterals.

    The nodes of the face of body 1 are the nodes of the contact, so body 1 should have the finer
    mesh.
    For round faces whose meshes do not match, body 1 should be the rotating body, and its mesh
    should not be finer.

    The face of body 1 may reach beyond the face of body 2. A part of the face without an opposite
    face is free, and a `ModelWarning` reports its size. If at least half of a facet lies opposite
    body 2, its nodes are nodes of the contact, and pressure can act up to half a facet beyond the
    edge of body 2. If less than half of a facet lies opposite body 2, this part is added to the
    nearest node of the contact. Ends and rims of round faces may miss each other by their sag,
    without a warning.

    Quadratic bodies meet in linear facets through their corner nodes, and the midside nodes follow
    the corners. The two faces of a crack are faces of one body; the node at the tip of the crack
    belongs to both faces, and is in no pair. If a body is free to slide, a taper below 1e-4 is
    treated as rounding of the coordinates, see `normals` of `condense`.

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
    adjust
        Position tolerance, length. Before assembly, nodes of body 1 that overlap body 2, or lie at
        most this far from its face, move onto the face along its normal. So noise of coordinates
        neither jams nor parts the bodies. If the face of body 2 lies within the tolerance of a
        plane, its nodes move into the plane first. Nothing is strained, and `ContactModel.notes`
        states the largest move. No node may move by more than a tenth of the shortest edge of its
        elements. Or `adjust` is a place, as in a `Support`: all nodes of body 1 at this place move,
        however far they are from the face. The gap of other nodes is measured, unless `gap` is a
        function. None: nothing moves. Places and amounts of supports and loads refer to the
        coordinates before the moves.
    tangential_stiffness, normal_stiffness
        Stiffness of the rough surfaces between the bodies, force per length^3, see
        `ContactSystem.with_contact_stiffness`; inf: rigid.

    Raises
    ------
    ModelError
        A name is not a text, a face is in contact with itself, `gap` or `adjust` is of another
        kind, or a stiffness is not positive.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Contact("blade", "disc", "left flank", "left flank").name
    'left flank'
    """

    body_1: str
    body_2: str
    boundary_1: str = "contact"
    boundary_2: str = "contact"
    name: str | None = None
    gap: Literal["measured"] | Callable[..., ArrayLike] | None = None
    adjust: float | Place | None = None
    tangential_stiffness: float = np.inf
    normal_stiffness: float = np.inf

    def __post_init__(self) -> None:
        check_names(self, "body_1", "boundary_1", "body_2", "boundary_2")
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
        if isinstance(self.adjust, int | float):
            object.__setattr__(self, "adjust", finite_number("adjust", self.adjust, least=0.0))
        elif self.adjust is not None:
            object.__setattr__(self, "adjust", checked_place(self.adjust, "adjust"))
        for name in ("tangential_stiffness", "normal_stiffness"):
            stiffness = checked_springs(name, getattr(self, name), 1)[0]
            object.__setattr__(self, name, float(stiffness))

    @property
    def title(self) -> str:
        """Words for the contact in messages."""
        return f"contact {self.name!r}"


@dataclass(frozen=True)
class Tie:
    """Two faces that are glued for good: a weld, an adhesive joint, or two meshes of one part.

    The nodes of face 1 follow face 2 by the dual mortar method; matching nodes follow one to one.
    The two bodies are one body for rigid motions and for `gross_slip`. Nothing slips in a tie.

    Face 1 should have the finer mesh, and should not reach beyond face 2. Quadratic faces are
    joined through their corner nodes, which the midside nodes follow. If a node is in two ties, it
    belongs to the first. A contact may reach a tie.

    Parameters
    ----------
    body_1, body_2
        Names of the bodies in the model.
    boundary_1, boundary_2
        Names of the two faces, each a boundary of the mesh of its body.
    tolerance
        Largest distance of a node of face 1 from face 2, length. Nodes that are farther away are
        free, and a `ModelWarning` counts them. None: 2.5 % of the mean edge of face 1.
    adjust
        Whether the tied nodes move onto face 2 before assembly, without strain, as in
        `Contact.adjust`. A node that would move by more than 0.1 of the shortest edge at this node
        stays where it is, and `ContactModel.notes` counts it. Where the faces stay apart, a
        rotation of both bodies strains them.

    Raises
    ------
    ModelError
        A name is not a text, or the tolerance is not above 0. In a model: no node lies within the
        tolerance; nodes of face 1 are held, coupled or in a cut; or faces follow each other in a
        circle.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Tie("rib", "plate", "foot", "top").tolerance
    """

    body_1: str
    body_2: str
    boundary_1: str
    boundary_2: str
    tolerance: float | None = None
    adjust: bool = True

    def __post_init__(self) -> None:
        check_names(self, "body_1", "body_2", "boundary_1", "boundary_2")
        if self.tolerance is not None:
            finite_number("tolerance", self.tolerance, above=0.0)
        flag("adjust", self.adjust)

    @property
    def title(self) -> str:
        """Words for the tie in messages."""
        return f"tie of {self.body_1!r} and {self.body_2!r}"

    @property
    def name(self) -> str:
        """Name of the tie in tables of forces."""
        return f"tie {self.boundary_1}-{self.boundary_2} ({self.body_1}, {self.body_2})"


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
        The name of the contact is not a text, or the amount is negative or not finite.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Interference("bore", 0.02)
    Interference(contact='bore', amount=0.02)
    """

    contact: str = "contact"
    amount: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        finite_number("amount", self.amount, least=0.0)


def contact_names(contacts: Sequence[Contact]) -> list[str]:
    """The names of the contacts, which must differ."""
    names = [str(contact.name) for contact in contacts]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ModelError(f"contacts: two contacts are called {name!r}; give each a name")
    return names


# Nodes at which several contacts meet: independent pairs, and pairs that represent other pairs.
#
# If three bodies meet in a point, their contacts close a circle: the relative motion of two bodies
# follows from the motions of both relative to the third. Two contacts between the same two bodies
# also close a circle. In each circle the pair of the last contact is dissolved: it has no unknowns
# of its own.


def independent_pairs(
    contacts: Sequence[Contact],
    contact: Integers,
    nodes: Integers,
    partners: Integers,
    points: Array,
    errors: Array,
    normals: Array,
    widths: Array,
    inside: Booleans,
) -> tuple[Integers, csr_matrix, Array]:
    """Find the pairs, among N, whose relative motions are independent.

    A dissolved pair is represented by the next pair of its contact. The next pair then has the mean
    of the relative motions of both pairs, weighted by the widths. So a uniform traction still
    passes through (as for the multipliers at cross points of the mortar method, Wohlmuth 2000).

    A face with two names is one face. If such a face continues smoothly from one contact of two
    bodies to another, the pair of the first contact represents both pairs, with the sum of their
    normals.

    A node at the tip of a crack, which both faces share, forms no pair. If the faces do not match,
    the motion of this node relative to its place is added to the next pair, whose width does not
    change.

    The next pair also represents a node that lies beyond the edge of body 2.

    The arguments are, for each pair: the number of its contact, increasing; its node of body 1, and
    the node of body 2 that coincides with this node (`partners`, -1: none); the point of the node,
    with its errors; the normal, of any length; the width; and whether the node lies opposite body 2
    (`inside`).

    The results are the (kept,) independent pairs, the (kept, N) matrix of the means, and the (kept,
    d) normals.
    """
    n = len(nodes)
    kept = _independent(contacts, contact, nodes, partners, points, errors, inside)
    unit = unit_vectors(normals)
    body_2 = np.array([one_contact.body_2 for one_contact in contacts])[contact]
    heir = np.arange(n)  # the pair that represents each pair
    total = normals.copy()
    for k in np.flatnonzero(~kept).tolist():
        same_contact = np.flatnonzero(kept & (contact == contact[k]))
        if not len(same_contact):
            raise ModelError(
                f"contacts: all nodes of {contacts[contact[k]].name!r} are corners of contacts "
                "that are listed before it; mesh it with two elements, or list it first"
            )
        same_faces = kept & (nodes == nodes[k]) & (body_2 == body_2[k])
        smooth = same_faces & (unit @ unit[k] > SMOOTH)
        if smooth.any():
            heir[k] = smooth.argmax()
            total[heir[k]] += normals[k]
        else:
            distance = np.linalg.norm(points[same_contact] - points[k], axis=1)
            heir[k] = same_contact[distance.argmin()]
    is_tip = nodes == partners
    whole = np.bincount(heir, np.where(is_tip, 0.0, widths), minlength=n)
    means = csr_matrix((widths / whole[heir], (heir, np.arange(n))), shape=(n, n))
    return np.flatnonzero(kept), means[kept], total[kept]


def _independent(
    contacts: Sequence[Contact],
    contact: Integers,
    nodes: Integers,
    partners: Integers,
    points: Array,
    errors: Array,
    inside: Booleans,
) -> Booleans:
    """(N,) whether a pair lies opposite body 2 and moves independently of the pairs before it."""
    independent = (nodes != partners) & inside
    spot = parts_of(coincident(points, errors), len(nodes))  # (N,) number of the place of a pair
    is_crowded = (np.bincount(spot)[spot] > 1) & independent

    # For each pair at a place with several pairs, both ends: body, place, and node (-1: none).
    ends = {}
    for k in np.flatnonzero(is_crowded).tolist():
        bodies = contacts[contact[k]].body_1, contacts[contact[k]].body_2
        ends[k] = [
            (bodies[0], int(spot[k]), int(nodes[k])),
            (bodies[1], int(spot[k]), int(partners[k])),
        ]
    node_at = {
        (body, place): node for pair in ends.values() for body, place, node in pair if node >= 0
    }
    # A pair closes a circle if its ends are already connected. An end is a node of a body, or the
    # place if the body has no node there.
    connected = DisjointSet()
    for k, pair in ends.items():
        end_1, end_2 = (
            node if node >= 0 else node_at.get((body, place), (body, place))
            for body, place, node in pair
        )
        connected.add(end_1)
        connected.add(end_2)
        independent[k] = connected.merge(end_1, end_2)
    return np.asarray(independent)


@dataclass(frozen=True, eq=False)
class Tied:
    """The nodes of body 1 that a tie joins, and the matrix (n, nodes of body 2) of their places.

    `others` counts the other nodes of face 1, which are farther from face 2 than the tolerance.
    """

    nodes: Integers
    places: csr_matrix
    others: int
    tolerance: float


@dataclass(frozen=True, eq=False)
class Followers:
    """The nodes of a model that follow others.

    The matrix `chains` (all nodes, all nodes) gives the displacements of all nodes. The column of a
    node that follows no other node multiplies its displacement. The column of a follower multiplies
    its motion relative to its place on face 2; this motion is zero. `tie` (all nodes,) is the
    number of the tie of each node, -1 for nodes that follow no other node.
    """

    chains: csr_matrix
    tie: Integers

    @property
    def nodes(self) -> Integers:
        """The nodes that follow others."""
        return np.flatnonzero(self.tie >= 0)

    @cached_property
    def matrix(self) -> csr_matrix:
        """(all nodes, all nodes) displacements of all nodes due to nodes that follow no other."""
        return csr_matrix(self.chains @ diags((self.tie < 0).astype(float)))

    @property
    def same(self) -> Integers:
        """(all nodes,) the node that each node follows; itself if it follows none or several."""
        starts = self.matrix.indptr[:-1]
        follows_one = np.diff(self.matrix.indptr) == 1
        return np.where(follows_one, self.matrix.indices[starts], np.arange(len(starts)))

    def motion(self, held: Booleans, elsewhere: Integers, points: Array) -> csr_matrix:
        """Matrix by which the displacements of followers follow the displacements of other nodes.

        Displacements that are `held` (all nodes, d) stay held, for instance on a plane of symmetry,
        where nodes of both faces are held. Nodes `elsewhere`, on cuts of sectors, cannot follow.
        """
        nodes = self.nodes
        is_loose = held[nodes] & (self.matrix[nodes] @ held == 0)
        refused = is_loose.any(axis=1) | np.isin(nodes, elsewhere)
        if (i := first_of(refused)) is not None:
            raise ModelError(
                f"ties: the node of face 1 at {place(points[nodes[i]])} is held where face 2 is "
                "not, or lies on the cut of a sector; exchange the faces of the tie, "
                "or hold face 2, too"
            )
        stays = np.zeros(held.shape)
        stays[nodes] = held[nodes]
        follows = diags(1 - stays.ravel())
        by_nodes = kron(self.chains, identity(held.shape[1]))
        return csr_matrix(follows @ by_nodes @ follows + diags(stays.ravel()))


def followers_of(
    ties: Sequence[Tie],
    tied: Sequence[Tied],
    own_nodes: Mapping[str, Integers],
) -> Followers:
    """The nodes of all ties that follow others, in the numbers of the model."""
    count = sum(map(len, own_nodes.values()))
    number = np.full(count, -1)
    step = csr_matrix((count, count))
    for k, (tie, of_tie) in enumerate(zip(ties, tied, strict=True)):
        links = of_tie.places.tocoo()
        rows = own_nodes[tie.body_1][of_tie.nodes[links.row]]
        columns = own_nodes[tie.body_2][links.col]
        is_first = number[rows] < 0
        entries = links.data[is_first], (rows[is_first], columns[is_first])
        step = step + csr_matrix(entries, shape=step.shape)
        number[rows[is_first]] = k
    # A node may follow nodes that in turn follow others.
    chains = identity(count, format="csr")
    for _ in ties:
        chains = csr_matrix(chains + step @ chains)
        step = csr_matrix(step @ step)
    if step.nnz:
        raise ModelError("ties: faces follow each other in a circle; exchange the faces of one tie")
    return Followers(chains, number)
