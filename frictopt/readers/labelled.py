"""A stiffness matrix of another code, with its labels and its deck."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh

from ..base import (
    Booleans,
    Integers,
    Shown,
    frozen,
    number_of,
    shown,
    whole,
    whole_array,
)
from ..errors import ModelError
from ..fem.elasticity import facet_nodes
from ..fem.matrix_checks import NumberedPoints, checked_stiffness
from ..fem.rigid import node_graph
from .deck import SHAPES, SLENDER, Deck
from .listing import deck_of_points
from .meshes import between, mesh_of, with_sets
from .mixed_elements import with_midsides


@dataclass(frozen=True, eq=False, repr=False)
class LabelledMatrix(Shown):
    """Base of `MatrixJob`: its rows, bodies and mesh."""

    K: csr_matrix
    labels: Integers
    deck: Deck | Mapping[int, Sequence[float]] | None = None

    def __post_init__(self) -> None:
        labels = checked_labels(self.labels)
        deck = deck_of_points(self.deck) if isinstance(self.deck, Mapping) else self.deck
        if deck is not None and not isinstance(deck, Deck):
            raise ModelError(
                f"deck: {shown(self.deck)}; give the deck of another job, "
                "a mapping number of a node -> its coordinates, or None"
            )
        matrix = checked_stiffness(self.K)
        if matrix.shape[0] != len(labels):
            raise ModelError(
                f"K: {shown(matrix)}; "
                f"give a real sparse matrix of the size of the labels, {len(labels)}"
            )
        vars(self).update(labels=labels, deck=deck, K=csr_matrix((matrix + matrix.T) / 2))

    def _answer(self) -> Mapping[str, object]:
        answer: dict[str, object] = {
            "unknowns": len(self.labels),
            "directions": self._directions,
        }
        if len(self.generalised):
            answer["generalised"] = len(self.generalised)
        has_deck = self.deck is not None
        answer["sets"] = sorted({*self._known.sets, *self._known.surfaces}) if has_deck else None
        return answer

    @property
    def _directions(self) -> int:
        return max(2, int(self.labels[displaced(self.labels), 1].max()))

    @property
    def _known(self) -> Deck:
        if not isinstance(self.deck, Deck):
            raise ModelError(
                "deck: this job has none; read it with deck='NAME.inp' to use its nodes and sets"
            )
        return self.deck

    @property
    def _shaped(self) -> Deck:
        return self._known.with_known_shapes()

    def _between(self, nodes: Integers, numbers: Integers | None = None) -> Integers:
        """Facets of the outline between some nodes, see `between`.

        No corner of a facet may belong to an element whose faces are not known.
        """
        facets = between(self.mesh, nodes, numbers)
        for kind, _, unknown in self._known.without_faces:
            common = np.intersect1d(self.mesh.facets[:, facets], unknown)
            if len(common) and not kind.startswith(SLENDER):
                raise ModelError(
                    f"deck: elements of type {kind} have node {self._known.numbers[common[0]]} of "
                    f"the face, and their faces are not known; give solids, {', '.join(SHAPES)}"
                )
        return facets

    @cached_property
    def points(self) -> NumberedPoints:
        """(nodes, d) coordinates of the nodes of the deck; d = 2 for a plane job.

        The array also carries the numbers of the nodes, for `condense`.
        """
        points = frozen(self._known.points[:, : self._directions]).view(NumberedPoints)
        points.numbers = self._known.numbers
        return points

    @cached_property
    def unknowns(self) -> Integers:
        """(nodes, d) row of K of each displacement of each node.

        The row is -1 if `*BOUNDARY` holds the displacement, and -2 if K lacks the displacement
        because it follows others. If the deck does not list held displacements, the row of every
        displacement that K lacks is -2. Nodes with such a displacement cannot be in a contact until
        you set the rows of held displacements to -1.

        Raises
        ------
        ModelError
            The matrix has labels of nodes that are not in the deck.
        """
        return rows_of_nodes(self.labels, self._known)[:, : self._directions]

    @property
    def generalised(self) -> Integers:
        """(m,) rows of K that are not displacements of nodes; `condense` eliminates them.

        These rows are rotations, modal unknowns and scalar points.
        """
        return np.flatnonzero(~displaced(self.labels))

    @cached_property
    def bodies(self) -> Integers:
        """(nodes,) number of the body that each node belongs to; -1 for nodes without a row in K.

        A body consists of the nodes that K connects.
        """
        _, body = connected_components(
            node_graph(self.K, self.unknowns, self.generalised), directed=False
        )
        present = (self.unknowns >= 0).any(axis=1)
        body[present] = np.unique(body[present], return_inverse=True)[1]
        return whole(np.where(present, body, -1))

    @cached_property
    def mesh(self) -> Mesh:
        """scikit-fem mesh through the corners of the elements of the deck.

        Its nodes are in the order of `points`; see `Deck.by_shape` for the errors. Elements whose
        faces are not known are left out, if there are other elements.
        """
        return mesh_of(self._shaped, self._directions)

    @cached_property
    def _whole(self) -> tuple[Mesh, csr_matrix]:
        """The mesh with midside nodes, and the matrix that gives them as means of deck nodes."""
        return with_midsides(self.mesh, self._shaped)

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Nodes as rows of `points`, each once.

        Parameters
        ----------
        where
            Name of a node set or surface; or the rows themselves, such as
            `np.flatnonzero(job.points[:, 1] == 0)`.

        Raises
        ------
        ModelError
            The deck has no such set, or it is empty; numbers that are no rows of `points`; a
            surface without faces, or with further facets between its nodes.
        """
        deck = self._known
        name = where.upper() if isinstance(where, str) else ""
        if name in deck.sets or name not in deck.surfaces:
            return deck.nodes(where)
        alone = replace(
            self._shaped, sets={}, element_sets={}, surfaces={name: deck.surfaces[name]}
        )
        facets = with_sets(self.mesh, alone, "of the deck").boundaries[name]
        between_nodes = self._between(np.unique(self.mesh.facets[:, facets]))
        if len(between_nodes) != len(facets):
            raise ModelError(
                f"surface {name!r}: its nodes also span other facets; name flat parts of it"
            )
        whole_mesh, origin = self._whole
        return np.unique(origin[facet_nodes(whole_mesh, facets)].indices)


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct and that some are displacements; return them read-only."""
    labels = whole_array("labels", values, (None, 2), least=-(10**12), most=10**12)
    if not displaced(labels).any():
        raise ModelError(
            "labels: no label names a displacement (a node and direction 1, 2 or 3), so there is "
            "no contact"
        )
    repeated = len(labels) - len(np.unique(labels, axis=0))
    if repeated:
        raise ModelError(
            f"labels: {number_of(repeated, 'label is', 'labels are')} given twice; "
            "write the matrix of solids alone: shells, beams and trusses have several rows"
        )
    return whole(labels)


def displaced(labels: Integers) -> Booleans:
    """(n,) whether a label names a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, deck: Deck) -> Integers:
    """(nodes, 6) row of each displacement and rotation of each node.

    It is -1 if the deck holds the unknown, and -2 if the matrix lacks it for another reason.
    """
    numbers = deck.numbers
    unknown = np.setdiff1d(labels[displaced(labels), 0], numbers)
    if len(unknown):
        remedy = f", and without {', '.join(deck.constraints)}" if deck.constraints else ""
        raise ModelError(
            f"deck: node {unknown[0]} of the matrix is not in it; "
            f"give the deck of the same job, of solids alone, not shells or beams{remedy}"
        )
    of_node = np.isin(labels[:, 0], numbers) & (labels[:, 1] >= 1) & (labels[:, 1] <= 6)
    rows = np.flatnonzero(of_node)
    order = np.argsort(numbers)
    node = order[np.searchsorted(numbers, labels[rows, 0], sorter=order)]
    unknowns = np.where(deck.held, -1, -2)
    unknowns[node, labels[rows, 1] - 1] = rows
    return whole(unknowns)
