"""A job of another code: the faces of its bodies, the pairs of nodes on them, and what acts there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree

from ..base import Array, Integers, finite_array, finite_number, frozen, real_array, shown
from ..errors import ModelError
from ..fem.elasticity import boundary_forces, facet_nodes, midside_ties
from ..fem.faces import facets_around, lines_along
from ..fem.normals import node_normals
from .deck import SHAPES, rows_of_nodes
from .labelled import LabelledMatrix
from .meshes import between


@dataclass(frozen=True, eq=False, repr=False)
class MatrixJob(LabelledMatrix):
    """Stiffness matrix of another code, with labels, and the nodes and sets of its deck: what `condense` asks for.

    Lengths and forces have the units of the deck; a plane job is per unit depth: stiffness and
    forces are divided by the thickness of its section.

    Parameters
    ----------
    K
        (n, n) stiffness, symmetric and sparse, without displacements that the job holds, or that
        follow others.
    labels
        (n, 2) number of the node, and direction, of each unknown: 1, 2 and 3 are its displacements.
        Any other one, or a number that is not positive, is that of a generalised coordinate.
    deck
        Nodes, sets, elements and constraints, as a reader finds them; or number of a node -> its
        coordinates; None: not known.
    M
        (n, n) mass matrix, symmetric and sparse, for `modal_load`; None: not known.

    Raises
    ------
    ModelError
        K or M that is not symmetric or not of the size of the labels, labels that are given twice
        or are none of displacements.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job
    MatrixJob(unknowns=964, directions=2, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK',
    'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'])
    >>> round(float(job.force("N_TOP", pressure=1.0).sum()), 9)  # on a face 10 wide
    -10.0

    A matrix of your own, of two nodes and a rotation:

    >>> import numpy as np
    >>> own = fo.MatrixJob(np.eye(5), [[7, 1], [7, 2], [7, 6], [9, 1], [9, 2]], {7: (0.0, 0.0), 9: (1.0, 0.0)})
    >>> own.unknowns.tolist(), own.generalised.tolist()
    ([[0, 1], [3, 4]], [2])
    """

    def matching_faces(self) -> list[Integers]:
        """Pairs (N, 2) of each connected face at which two bodies lie on each other, node by node: proposals for `pairs` of `condense`.

        The body of the lower number is body 1. In the plane the pairs are in the order of the face,
        body 1 on the left. Bodies that only touch at a point or an edge have no face there. Without
        elements (those of a reduced model are gone) the nodes alone tell, in space.

        Raises
        ------
        ModelError
            A node that lies on several of one other body, nodes amid edges that move on their own;
            in the plane a deck without elements.

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

    def with_linear_faces(self, *faces: str | ArrayLike) -> MatrixJob:
        """The job in which nodes amid edges of contact faces follow the corners, and only these make pairs; see theory, "Quadratic elements".

        Parameters
        ----------
        *faces
            The nodes of each face, both sides of each contact, see `nodes`; none: all faces that
            match.

        Raises
        ------
        ModelError
            Nodes without a facet between them, corners that follow others, a node more than a tenth
            of its edge off the middle.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> job.with_linear_faces().K.shape == job.K.shape  # its elements are linear
        True
        """
        sides = faces or [side for pairs in self._matching() for side in pairs.T]
        facets = np.unique(
            np.concatenate(
                [
                    np.zeros(0, dtype=np.intp),
                    *(between(self.mesh, self.nodes(side)) for side in sides),
                ]
            )
        )
        deck, (whole, origin) = self._known, self._whole
        links, d = midside_ties(whole, facets, "with_linear_faces").tocoo(), whole.dim()
        given = np.full(whole.p.shape[1], -1)
        ends = origin.tocoo()
        own = (np.diff(origin.indptr) == 1)[
            ends.row
        ]  # the others are added to complete elements, and follow of themselves
        given[ends.row[own]] = ends.col[own]
        node, axis = given[links.row // d], links.row % d
        own = (node >= 0) & (self.unknowns[node, axis] >= 0)
        node, axis, corner, other, weight = (
            node[own],
            axis[own],
            links.col[own] // d,
            links.col[own] % d,
            links.data[own],
        )
        rows, columns = self.unknowns[node, axis], self.unknowns[corner, other]
        if (columns < -1).any():
            number = int(deck.numbers[corner[columns < -1][0]])
            raise ModelError(
                f"with_linear_faces: corner node {number} follows others; take that constraint out, or let the others follow it"
            )
        follows = np.zeros(len(self.labels))
        follows[rows] = 1.0
        free, left = columns >= 0, np.flatnonzero(follows == 0)
        T = csr_matrix(
            diags(1 - follows)
            + csr_matrix((weight[free], (rows[free], columns[free])), shape=self.K.shape)
        )[:, left]
        constraints = deck.constraints.following(
            np.column_stack([6 * node + axis, 6 * corner + other]), weight
        )
        M = None if self.M is None else csr_matrix(T.T @ self.M @ T)
        return MatrixJob(
            csr_matrix(T.T @ self.K @ T),
            self.labels[left],
            replace(deck, constraints=constraints),
            M=M,
        )

    def _check_midsides(self, corners: Integers) -> None:
        """Check that the nodes amid the edges of contact faces, on facets between some corners, follow others."""
        deck, unknowns = self._known, self.unknowns
        for kind, nodes in deck.unclear:
            if len(common := np.intersect1d(corners, nodes)):
                known = ", ".join(
                    name
                    for name in SHAPES
                    if name.startswith("C3D" if self._directions == 3 else "CPE")
                )
                raise ModelError(
                    f"faces: node {deck.numbers[common[0]]} is one of an element {kind}, and which of its nodes lie amid edges "
                    f"is not known; mesh this body with {known} in the code that writes the matrix"
                )
        if not len(deck.midsides):
            return
        whole, origin = self._whole
        rows = np.intersect1d(
            origin[facet_nodes(whole, between(self.mesh, corners))].indices, deck.midsides
        )
        free, gone = (
            rows[(unknowns[rows] >= 0).any(axis=1)],
            rows[(unknowns[rows] < -1).any(axis=1)],
        )
        if len(lost := np.setdiff1d(gone, deck.constraints.ends[:, 0] // 6)):
            raise ModelError(
                f"faces: node {deck.numbers[lost[0]]}, amid an edge of a contact face, has no row in the matrix; retain such nodes"
            )
        if len(free):
            raise ModelError(
                f"faces: node {deck.numbers[free[0]]}, amid an edge of a contact face, moves on its own; use job.with_linear_faces()"
            )

    def _corners(self, where: str | ArrayLike) -> Integers:
        return np.setdiff1d(self.nodes(where), self._known.midsides, assume_unique=True)

    def pairs(self, first: str | ArrayLike, second: str | ArrayLike) -> Integers:
        """(N, 2) pairs of corner nodes on two faces, each with the nearest one; in a plane job in the order of the face, body 1 on the left.

        Parameters
        ----------
        first, second
            Nodes on body 1 and on body 2, see `nodes`.

        Raises
        ------
        ModelError
            Faces of different numbers of nodes or with nodes in common, a node that is nearest to
            two others, nodes amid edges that move on their own, quadratic elements of other types
            than `Deck.shaped` takes; see `nodes`.
        """
        one, two, points, numbers = (
            self._corners(first),
            self._corners(second),
            self.points,
            self._known.numbers,
        )
        self._check_midsides(np.r_[one, two])
        if self._directions == 2:
            two = np.concatenate(
                [
                    line
                    for line, _ in lines_along(
                        self.mesh, between(self.mesh, two, numbers), "nodes: the outline"
                    )
                ]
            )
        argument = f"faces {shown(first)} and {shown(second)}"
        if len(one) != len(two) or np.isin(one, two).any():
            problem = (
                f"{len(one)} and {len(two)} nodes" if len(one) != len(two) else "nodes in common"
            )
            raise ModelError(
                f"{argument}: {problem}; mesh both with the same nodes, each with its own"
            )
        nearest = one[cKDTree(points[one]).query(points[two])[1]]
        taken, count = np.unique(nearest, return_counts=True)
        if len(taken) != len(one):
            raise ModelError(
                f"{argument}: node {int(numbers[taken[count.argmax()]])} is the nearest one to several; mesh both with the same nodes"
            )
        return np.column_stack([nearest, two])

    def normals(self, face: str | ArrayLike) -> Array:
        """(N, d) unit normals that point out of the body at the corner nodes on a face: of the circle or sphere through nodes around, Max (1999).

        Parameters
        ----------
        face
            The nodes of the whole face, see `nodes`: of body 2, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins; see `nodes`.
        """
        nodes = self._corners(face)
        facets = facets_around(self.mesh, between(self.mesh, nodes, self._known.numbers))
        inward = node_normals(facets, self.mesh.p.T)[nodes]
        return frozen(-inward / np.linalg.norm(inward, axis=1)[:, None])

    def areas(self, face: str | ArrayLike) -> Array:
        """(N,) area that belongs to each of the corner nodes on a face, in the plane length: the `width` of `condense`, such as of wear.

        That of its part of the facets through the corners, as contact faces are linear between
        them.

        Parameters
        ----------
        face
            The nodes of one whole face, see `nodes`, in the order of the areas: for `condense`
            those of the pairs, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins, axisymmetric elements; see `nodes`.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> round(float(job.areas(job.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")[:, 1]).sum()), 9)  # a face 10 wide
        10.0
        """
        self._check_not_axisymmetric("areas", "the areas of whole circumferences as `width`")
        nodes = self._corners(face)
        facets = between(self.mesh, nodes, self._known.numbers)
        (areas,) = boundary_forces(
            self.mesh, facets, lambda points, _: np.ones((1, *points.shape[1:])), "space"
        )
        return frozen(areas[nodes])

    def _check_not_axisymmetric(self, argument: str, instead: str) -> None:
        if axisymmetric := sorted(
            {kind for kind, _, _ in self._known.elements if kind.startswith("CAX")}
        ):
            raise ModelError(
                f"{argument}: elements {axisymmetric[0]} are axisymmetric; give condense {instead}"
            )

    def force(
        self,
        where: str | ArrayLike,
        *,
        traction: object = None,
        pressure: object = None,
        total: object = None,
        nodal: object = None,
    ) -> Array:
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
            (d,) components of the sum of all forces, spread over that outline as a uniform
            traction; in a plane job force per depth.
        nodal
            (d,) components of the force on each of the nodes, or (m, d) of m nodes; in a plane job
            force per depth.

        Raises
        ------
        ModelError
            None or several of the four, nodes that no facet of the outline joins, values that are
            not finite, axisymmetric elements (in which codes count forces per angle in ways of
            their own); a force on a displacement of which neither the matrix nor the deck says
            where it goes, such as that of a tied node. See `nodes` too.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> float(job.force("N_TOP", traction=[0.0, -1.0]).sum().round(9)), float(job.force("N_TOP", total=[0.0, -1.0]).sum().round(9))
        (-10.0, -1.0)
        """
        given = {
            name: v
            for name, v in (
                ("traction", traction),
                ("pressure", pressure),
                ("total", total),
                ("nodal", nodal),
            )
            if v is not None
        }
        nodes, deck, d = self.nodes(where), self._known, self._directions
        if len(given) != 1:
            raise ModelError(
                f"force: {' and '.join(given) or 'no load'}; give one of traction, pressure (force per area), total, nodal (force)"
            )
        self._check_not_axisymmetric("force", "the nodal forces that belong to the code's matrix")
        ((name, value),), rows = (
            given.items(),
            rows_of_nodes(self.labels, deck.numbers, deck.constraints),
        )
        forces = np.zeros(rows.shape)
        if name == "nodal":
            forces[nodes, :d] = finite_array(
                "nodal", value, (d,) if real_array("nodal", value).ndim == 1 else (len(nodes), d)
            )
        elif name == "pressure":
            forces[:, :d] = -finite_number("pressure", value) * self._integrals(nodes)[:, :-1]
        else:
            share = self._integrals(nodes)[:, -1:]
            forces[:, :d] = (
                share * finite_array(name, value, (d,)) / (share.sum() if name == "total" else 1.0)
            )
        present, values = rows >= 0, np.zeros(len(self.labels))
        values[rows[present]] = deck.constraints.passed_on(forces, present, deck.numbers)[present]
        return frozen(values)

    def _integrals(self, nodes: Integers) -> Array:
        """(nodes, d + 1) integrals over the outline between some nodes of each node's shape function times the outward normal, and times 1."""
        facets = between(self.mesh, nodes)
        parts = boundary_forces(
            self._whole[0],
            facets,
            lambda _, normals: np.concatenate([normals, np.ones((1, *normals.shape[1:]))]),
            "space",
        )
        return np.asarray(self._whole[1].T @ parts.T)
