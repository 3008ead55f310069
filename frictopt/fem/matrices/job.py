"""A stiffness matrix that another code wrote, with the deck that says where its nodes are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from skfem import Mesh

from ...contact.checks import Array, frozen, shown
from ...contact.result import Shown
from ...errors import ModelError
from ..given import checked_stiffness
from ..ordering import Integers
from ..rigid import node_graph
from .constraints import checked_labels, displaced, rows_of_nodes
from .deck import Deck, deck_of_points
from .meshes import file_path, mesh_of, with_midsides
from .modes import printed_modes
from .outline import acting, along, between, bodies_of, check_midsides, integrals, matching_faces, normals_at, paired, tied


@dataclass(frozen=True, eq=False, repr=False)
class MatrixJob(Shown):
    """Stiffness matrix of another code, with labels, and the nodes and sets of its deck: what `condense` asks for.

    Lengths and forces have the units of the deck; a plane job is per unit depth: stiffness and forces are divided by the thickness of its section.

    Parameters
    ----------
    K
        (n, n) stiffness, symmetric and sparse, without displacements that the job holds, or that follow others.
    labels
        (n, 2) number of the node, and direction, of each unknown: 1, 2 and 3 are its displacements. Any other one, or a number that is not positive,
        is that of a generalised coordinate.
    deck
        Nodes, sets, elements and constraints, as a reader finds them; or number of a node -> its coordinates; None: not known.
    M
        (n, n) mass matrix, symmetric and sparse, for `modal_load`; None: not known.

    Raises
    ------
    ModelError
        K or M that is not symmetric or not of the size of the labels, labels that are given twice or are none of displacements.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job
    MatrixJob(unknowns=964, directions=2, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'])
    >>> round(float(job.force("N_TOP", pressure=1.0).sum()), 9)  # on a face 10 wide
    -10.0

    A matrix of your own, of two nodes and a rotation:

    >>> import numpy as np
    >>> own = fo.MatrixJob(np.eye(5), [[7, 1], [7, 2], [7, 6], [9, 1], [9, 2]], {7: (0.0, 0.0), 9: (1.0, 0.0)})
    >>> own.unknowns.tolist(), own.generalised.tolist()
    ([[0, 1], [3, 4]], [2])
    """

    K: csr_matrix
    labels: Integers
    deck: Deck | Mapping[int, Sequence[float]] | None = None
    M: csr_matrix | None = None

    def __post_init__(self) -> None:
        labels = checked_labels(self.labels)
        if isinstance(self.deck, Mapping):
            object.__setattr__(self, "deck", deck_of_points(self.deck))
        if self.deck is not None and not isinstance(self.deck, Deck):
            raise ModelError(f"deck: {shown(self.deck)}; give the deck of another job, a mapping number of a node -> its coordinates, or None")
        object.__setattr__(self, "labels", labels)
        for name in ("K",) if self.M is None else ("K", "M"):
            matrix = checked_stiffness(getattr(self, name), name)
            if matrix.shape[0] != len(labels):
                raise ModelError(f"{name}: {shown(matrix)}; give a real sparse matrix of the size of the labels, {len(labels)}")
            object.__setattr__(self, name, csr_matrix((matrix + matrix.T) / 2))

    def _answer(self) -> Mapping[str, object]:
        others = {"generalised": len(self.generalised)} if len(self.generalised) else {}
        return {"unknowns": len(self.labels), "directions": self._directions, **others, "sets": sorted(self._known.sets) if self.deck else None}

    @property
    def _directions(self) -> int:
        return max(2, int(self.labels[displaced(self.labels), 1].max()))

    @property
    def _known(self) -> Deck:
        if not isinstance(self.deck, Deck):
            raise ModelError("deck: this job has none; read it with deck='NAME.inp' to use its nodes and sets")
        return self.deck

    @cached_property
    def points(self) -> Array:
        """(nodes, d) coordinates of the nodes of the deck; d = 2 for a plane job."""
        return frozen(self._known.points[:, : self._directions])

    @cached_property
    def unknowns(self) -> Integers:
        """(nodes, d) row of K of each node's displacements, -1 where `*BOUNDARY` holds them, -2 where K has none else: they follow others.

        Where the job has no deck that tells held displacements (-1), those that K lacks are -2 too: such a node carries no contact until you say -1.

        Raises
        ------
        ModelError
            The matrix has labels of nodes that are not in the deck.
        """
        return rows_of_nodes(self.labels, self._known.numbers, self._known.constraints)[:, : self._directions]

    @property
    def generalised(self) -> Integers:
        """(m,) rows of K that are no displacement of a node, which `condense` eliminates: rotations, modal unknowns, scalar points."""
        return np.flatnonzero(~displaced(self.labels))

    @cached_property
    def bodies(self) -> Integers:
        """(nodes,) number of the body that each node belongs to: what K joins is one body. -1 for nodes without a row in K."""
        return bodies_of(node_graph(self.K, self.unknowns, self.generalised), self.unknowns)

    def matching_faces(self) -> list[Integers]:
        """Pairs (N, 2) of each connected face at which two bodies lie on each other, node by node: proposals for `pairs` of `condense`.

        The body of the lower number is body 1. In the plane the pairs are in the order of the face, body 1 on the left. Bodies that only touch at a
        point or an edge have no face there. Without elements (those of a reduced model are gone) the nodes alone tell, in space.

        Raises
        ------
        ModelError
            A node that lies on several of one other body, nodes amid edges that move on their own; in the plane a deck without elements.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> [face.shape for face in job.matching_faces()], [int((job.bodies == i).sum()) for i in (0, 1)]
        ([(26, 2)], [275, 207])
        """
        for pairs in (faces := self._matching()):
            self._check_midsides(pairs.ravel())
        return faces

    def _matching(self) -> list[Integers]:
        return matching_faces(self.points, self.bodies, self.mesh if self._known.elements or self._directions == 2 else None)

    @cached_property
    def mesh(self) -> Mesh:
        """scikit-fem mesh of the deck through the corners of its elements, nodes in the order of `points`; see `Deck.shaped` for the errors."""
        return mesh_of(self._known, self._directions)

    @cached_property
    def _whole(self) -> tuple[Mesh, csr_matrix]:
        """The mesh with the nodes amid edges, and the (its nodes, nodes of the deck) matrix of its nodes."""
        return with_midsides(self.mesh, self._known.shaped()[2], self._known.points)

    def with_linear_faces(self, *faces: str | ArrayLike) -> "MatrixJob":
        """The job in which nodes amid edges of contact faces follow the corners, and only these make pairs; see theory, "Quadratic elements".

        Parameters
        ----------
        *faces
            The nodes of each face, both sides of each contact, see `nodes`; none: all faces that match.

        Raises
        ------
        ModelError
            Nodes without a facet between them, corners that follow others, a node more than a tenth of its edge off the middle.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> job.with_linear_faces().K.shape == job.K.shape  # its elements are linear
        True
        """
        facets = [between(self.mesh, self.nodes(side)) for side in faces or [side for pairs in self._matching() for side in pairs.T]]
        T, labels, deck = tied(self.labels, self._known, self.unknowns, *self._whole, facets)
        return MatrixJob(csr_matrix(T.T @ self.K @ T), labels, deck, M=None if self.M is None else csr_matrix(T.T @ self.M @ T))

    def _check_midsides(self, corners: Integers) -> None:
        if len(self._known.midsides):
            check_midsides(*self._whole, between(self.mesh, corners), self._known, self.unknowns)

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Nodes as rows of `points`, each once.

        Parameters
        ----------
        where
            Name of a node set; or the rows themselves, such as `np.flatnonzero(job.points[:, 1] == 0)`.

        Raises
        ------
        ModelError
            The deck names no such set, or it is empty; numbers that are no rows of `points`.
        """
        return self._known.nodes(where)

    def _corners(self, where: str | ArrayLike) -> Integers:
        return np.setdiff1d(self.nodes(where), self._known.midsides, assume_unique=True)

    def _over(self, nodes: Integers) -> tuple[Array, Array]:
        forces, shares = integrals(self._whole[0], between(self.mesh, nodes))
        return self._whole[1].T @ forces, self._whole[1].T @ shares

    def pairs(self, first: str | ArrayLike, second: str | ArrayLike) -> Integers:
        """(N, 2) pairs of corner nodes on two faces, each with the nearest one; in a plane job in the order of the face, body 1 on the left.

        Parameters
        ----------
        first, second
            Nodes on body 1 and on body 2, see `nodes`.

        Raises
        ------
        ModelError
            Faces of different numbers of nodes or with nodes in common, a node that is nearest to two others, nodes amid edges that move on their
            own; see `nodes`.
        """
        one, two = self._corners(first), self._corners(second)
        self._check_midsides(np.r_[one, two])
        if self._directions == 2:
            two = along(self.mesh, two, self._known.numbers)
        return paired(self.points, one, two, self._known.numbers, f"faces {shown(first)} and {shown(second)}")

    def normals(self, face: str | ArrayLike) -> Array:
        """(N, d) unit normals that point out of the body at the corner nodes on a face, the mean over the facets weighted by their size.

        Parameters
        ----------
        face
            The nodes of the whole face, see `nodes`: of body 2, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins; see `nodes`.
        """
        return frozen(normals_at(self.mesh, self._corners(face), self._known.numbers))

    def modes(self, path: str | Path) -> tuple[Array, Array]:
        """Natural frequencies (m,), cycles per unit of time, and shapes (m, n) of the modes that CalculiX printed, for `modal_load`.

        The file `NAME.dat` is that of a step of `*FREQUENCY` with `*NODE PRINT` of the displacements U of all nodes. Its deck has the nodes of this
        job, with the contact glued: by `*TIE`, by equations, or by nodes that the bodies share.

        Raises
        ------
        ModelError
            A file that is missing or holds no modes, or none of a node of the matrix; unknowns that are no displacements.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> frequencies, shapes = job.modes("tests/data/flat_glued.dat")
        >>> frequencies.tolist(), shapes.shape
        ([24757.59, 47452.97], (2, 964))
        """
        return printed_modes(file_path("modes", path), self.labels, self.deck if isinstance(self.deck, Deck) else None)

    def force(self, where: str | ArrayLike, *, traction: object = None, pressure: object = None, total: object = None, nodal: object = None) -> Array:
        """(n,) nodal forces of one load, said in one of four ways; on displacements that follow others they go to these, on held ones to the ground.

        Parameters
        ----------
        where
            The nodes, see `nodes`: of a face for the first three, any for the last one.
        traction
            (d,) components of a uniform traction on the outline between the nodes, force per area.
        pressure
            A number: uniform pressure on that outline, force per area.
        total
            (d,) components of the sum of all forces, spread over that outline as a uniform traction; in a plane job force per depth.
        nodal
            (d,) components of the force on each of the nodes, or (m, d) of m nodes; in a plane job force per depth.

        Raises
        ------
        ModelError
            None or several of the four, nodes that no facet of the outline joins, values that are not finite, axisymmetric elements (in which codes
            count forces per angle in ways of their own); a force on a displacement of which neither the matrix nor the deck says where it goes, such
            as that of a tied node. See `nodes` too.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> float(job.force("N_TOP", traction=[0.0, -1.0]).sum().round(9)), float(job.force("N_TOP", total=[0.0, -1.0]).sum().round(9))
        (-10.0, -1.0)
        """
        given = {name: v for name, v in (("traction", traction), ("pressure", pressure), ("total", total), ("nodal", nodal)) if v is not None}
        return frozen(acting(given, self.nodes(where), self._known, self.labels, self._directions, self._over))
