"""Ties: faces of two bodies that move together, also if their nodes do not match."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, diags, identity, kron

from ..base import (
    Array,
    Booleans,
    Integers,
    finite_number,
    first_of,
    flag,
    place,
)
from ..errors import ModelError
from .bodies import Body, check_names


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
        `Contact.adjust`. A node that would move by more than 0.1 of the shortest edge there stays,
        and `ContactModel.notes` counts it. Where faces stay apart, a turn of both bodies strains
        them.

    Raises
    ------
    ModelError
        A name is not a text, or the tolerance is not above 0. In a model: no node lies within the
        tolerance; nodes of face 1 are held, coupled, in a cut, or followed in a circle.

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


@dataclass(frozen=True, eq=False)
class Tied:
    """The nodes of body 1 that a tie joins, and their places, a matrix (n, nodes of body 2).

    Other nodes of the face are farther away than the tolerance.
    """

    nodes: Integers
    places: csr_matrix
    others: int
    tolerance: float


@dataclass(frozen=True, eq=False)
class Followers:
    """The nodes of a model that follow others.

    The matrix `chains` (all nodes, all nodes) has the displacements of all nodes: due to nodes that
    follow no other node, and due to the displacements of followers relative to their places on face
    2, which are zero. `tie` (all nodes,) is the number of the tie of each node, -1 for nodes that
    follow no other node.
    """

    chains: csr_matrix
    tie: Integers

    @property
    def nodes(self) -> Integers:
        """The nodes that follow others."""
        return np.flatnonzero(self.tie >= 0)

    @cached_property
    def matrix(self) -> csr_matrix:
        """(all nodes, all nodes) displacements due to those of the nodes that follow none."""
        return csr_matrix(self.chains @ diags((self.tie < 0).astype(float)))

    @property
    def same(self) -> Integers:
        """(all nodes,) the one node that each node is or follows; itself if it follows several."""
        starts = self.matrix.indptr[:-1]
        follows_one = np.diff(self.matrix.indptr) == 1
        return np.where(follows_one, self.matrix.indices[starts], np.arange(len(starts)))

    def motion(self, held: Booleans, elsewhere: Integers, points: Array) -> csr_matrix:
        """Matrix by which the displacements follow.

        Displacements that are `held` (all nodes, d) stay held, as on a plane of symmetry, where
        nodes of both faces are held. Nodes `elsewhere` cannot follow.
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
    bodies: Mapping[str, Body],
    first_node: Mapping[str, int],
) -> Followers:
    """The nodes of all ties that follow, in the numbers of the model."""
    count = sum(body.mesh.p.shape[1] for body in bodies.values())
    number = np.full(count, -1)
    step = csr_matrix((count, count))
    for k, (tie, of_tie) in enumerate(zip(ties, tied, strict=True)):
        links = of_tie.places.tocoo()
        rows = first_node[tie.body_1] + of_tie.nodes[links.row]
        columns = first_node[tie.body_2] + links.col
        is_first = number[rows] < 0
        entries = links.data[is_first], (rows[is_first], columns[is_first])
        step = step + csr_matrix(entries, shape=step.shape)
        number[rows[is_first]] = k
    # A node may follow nodes that follow others.
    chains = identity(count, format="csr")
    for _ in ties:
        chains = csr_matrix(chains + step @ chains)
        step = csr_matrix(step @ step)
    if step.nnz:
        raise ModelError("ties: faces follow each other in a circle; exchange the faces of one tie")
    return Followers(chains, number)
