"""A job of another code: faces of its bodies, pairs of nodes on them, and forces on nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, diags, identity
from scipy.spatial import cKDTree

from ..base import ROUNDING, Array, Integers, finite_array, finite_number, frozen, real_array, shown
from ..errors import ModelError
from ..fem.coincidence import coordinate_errors
from ..fem.elasticity import (
    Kinematics,
    boundary_forces,
    facet_nodes,
    midside_ties,
    node_areas,
)
from ..fem.faces import Face, facets_around, lines_along, unit_vectors
from ..fem.normals import Planes, node_normals
from .deck import SHAPES
from .labelled import LabelledMatrix


@dataclass(frozen=True, eq=False, repr=False)
class MatrixJob(LabelledMatrix):
    """Stiffness matrix of another code, with labels, and the nodes and sets of its deck.

    Its attributes and methods give the arguments of `condense`.

    Lengths and forces have the units of the deck. A plane job is per unit depth: stiffness and
    forces are divided by the thickness of its section. An axisymmetric job refers to the whole
    circumference.

    Parameters
    ----------
    K
        (n, n) stiffness, symmetric and sparse. K has no rows of displacements that the job holds or
        that follow other displacements.
    labels
        (n, 2) number of the node and direction of each unknown; the directions 1, 2 and 3 are
        displacements. Any other direction, or a number that is not positive, marks a generalised
        coordinate.
    deck
        Nodes, sets, elements and constraints, as a reader returns them; or a mapping from the
        number of a node to its coordinates; None: unknown.

    Raises
    ------
    ModelError
        K is not symmetric or does not have the size of the labels; a label occurs twice; no
        label is a displacement.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.readers.read_calculix("tests/data/flat")
    >>> job
    MatrixJob(unknowns=964, directions=2, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK',
    'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'])
    >>> round(float(job.force("N_TOP", pressure=1.0).sum()), 9)  # on a face 10 wide
    -10.0

    A matrix of your own, of two nodes and a rotation:

    >>> import numpy as np
    >>> labels = [[7, 1], [7, 2], [7, 6], [9, 1], [9, 2]]
    >>> job = fo.readers.MatrixJob(np.eye(5), labels, {7: (0.0, 0.0), 9: (1.0, 0.0)})
    >>> job.unknowns.tolist(), job.generalised.tolist()
    ([[0, 1], [3, 4]], [2])
    """

    def with_linear_faces(
        self, first: str | ArrayLike, second: str | ArrayLike, *others: str | ArrayLike
    ) -> MatrixJob:
        """The job in which midside nodes of contact faces follow the corners.

        Only corner nodes then have pairs; see theory, "Quadratic elements".

        Parameters
        ----------
        first, second, *others
            The nodes of the faces on both sides of each contact, see `nodes`.

        Raises
        ------
        ModelError
            The nodes span no facet; a corner node follows other nodes; a midside node is further
            from the middle of its edge than a tenth of the edge.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.readers.read_calculix("tests/data/flat")
        >>> linear = job.with_linear_faces("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
        >>> linear.K.shape == job.K.shape  # its elements are linear
        True
        """
        facets = [self._between(self.nodes(face)) for face in (first, second, *others)]
        mesh, origin = self._whole
        d = mesh.dim()
        ties = midside_ties(mesh, np.unique(np.concatenate(facets)), "with_linear_faces").tocoo()
        # Node of the mesh -> node of the deck; -1 for a node that was added to complete elements
        # and is a mean of several.
        single = np.flatnonzero(np.diff(origin.indptr) == 1)
        deck_node = np.full(mesh.p.shape[1], -1)
        deck_node[single] = origin[single].indices
        node = deck_node[ties.row // d]
        rows = np.where(node >= 0, self.unknowns[node, ties.row % d], -1)
        corner = ties.col // d
        columns = self.unknowns[corner, ties.col % d]
        in_matrix = rows >= 0
        follows_others = in_matrix & (columns < -1)
        deck = self._known
        if follows_others.any():
            number = int(deck.numbers[corner[follows_others][0]])
            raise ModelError(
                f"with_linear_faces: corner node {number} follows others; "
                "take that constraint out, or let the others follow it"
            )

        # Unknowns of the job = T @ remaining unknowns. Held corners (-1) do not move.
        follows = np.zeros(len(self.labels))
        follows[rows[in_matrix]] = 1.0
        remaining = np.flatnonzero(follows == 0)
        free = in_matrix & (columns >= 0)
        by_corners = csr_matrix((ties.data[free], (rows[free], columns[free])), shape=self.K.shape)
        T = csr_matrix(diags(1 - follows) + by_corners)[:, remaining]
        linear = MatrixJob(csr_matrix(T.T @ self.K @ T), self.labels[remaining], deck)
        job, by_self = self._origin
        vars(linear).update(_origin=(job, by_self @ T))
        return linear

    @cached_property
    def _origin(self) -> tuple[MatrixJob, csr_matrix]:
        """The job before `with_linear_faces`, and T: its unknowns are T times the unknowns here."""
        return self, identity(len(self.labels), format="csr")

    def pairs(self, first: str | ArrayLike, second: str | ArrayLike) -> Integers:
        """(N, 2) pairs of corner nodes on two faces: each node with the nearest on the other face.

        In a plane job the pairs are in the order of the face, with body 1 on the left.

        Parameters
        ----------
        first, second
            Nodes on body 1 and on body 2, see `nodes`.

        Raises
        ------
        ModelError
            The faces have different numbers of nodes, or common nodes; a node is nearest to two
            other nodes; midside nodes do not follow their corners; quadratic elements have a type
            that `Deck.by_shape` does not accept. See also `nodes`.
        """
        one = self._corners(first)
        two = self._corners(second)
        self._check_midsides(np.r_[one, two])
        numbers = self._known.numbers
        if self._directions == 2:
            facets = self._between(two, numbers)
            around = facets_around(self.mesh, facets)
            lines = lines_along(around, self.mesh.p.T, "nodes: the outline")
            two = np.concatenate([line for line, _ in lines])
        argument = f"faces {shown(first)} and {shown(second)}"
        problem = ""
        if len(one) != len(two):
            problem = f"{len(one)} and {len(two)} nodes"
        elif np.isin(one, two).any():
            problem = "nodes in common"
        if problem:
            raise ModelError(
                f"{argument}: {problem}; mesh both with the same nodes, each with its own"
            )
        nearest = one[cKDTree(self.points[one]).query(self.points[two])[1]]
        nodes, counts = np.unique(nearest, return_counts=True)
        if len(nodes) != len(one):
            raise ModelError(
                f"{argument}: node {int(numbers[nodes[counts.argmax()]])} is the nearest one to "
                "several; mesh both with the same nodes"
            )
        return np.column_stack([nearest, two])

    def normals(self, face: str | ArrayLike) -> Array:
        """(N, d) unit normals that point out of the body at the corner nodes on a face.

        The normals are exact if the node and its neighbours lie on a circle or a sphere (Max 1999).

        Parameters
        ----------
        face
            The nodes of the whole face, see `nodes`; for body 2, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins; see `nodes`.
        """
        nodes = self._corners(face)
        facets = facets_around(self.mesh, self._between(nodes, self._known.numbers))
        errors = coordinate_errors(self.points, self._known.corners)
        inward = node_normals(Face(facets, self.mesh.p.T, errors), Planes(self._directions))[nodes]
        return frozen(-unit_vectors(inward))

    def areas(self, face: str | ArrayLike) -> Array:
        """(N,) area (in the plane, length) of each corner node on a face, for `condense(width=)`.

        The area is the node's part of the area of the facets through the corner nodes, because
        contact faces are linear between corner nodes.

        Parameters
        ----------
        face
            The nodes of one whole face, see `nodes`; the areas are in their order. For `condense`
            use the nodes of the pairs, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins; see `nodes`.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.readers.read_calculix("tests/data/flat")
        >>> pairs = job.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
        >>> round(float(job.areas(pairs[:, 1]).sum()), 9)  # a face 10 wide
        10.0
        """
        nodes = self._corners(face)
        facets = self._between(nodes, self._known.numbers)
        return frozen(node_areas(self.mesh, facets, self._kinematics)[nodes])

    def _corners(self, where: str | ArrayLike) -> Integers:
        return np.setdiff1d(self.nodes(where), self._known.midsides, assume_unique=True)

    def _check_midsides(self, corners: Integers) -> None:
        """Check that midside nodes of contact faces between these corners follow the corners."""
        deck = self._known
        for kind, _, nodes in deck.unclear:
            common = np.intersect1d(corners, nodes)
            if len(common):
                family = "C3D" if self._directions == 3 else "CPE"
                known = ", ".join(name for name in SHAPES if name.startswith(family))
                raise ModelError(
                    f"faces: node {deck.numbers[common[0]]} is one of an element {kind}, whose "
                    f"midside nodes are unknown; mesh this body with {known} "
                    "in the code that writes the matrix"
                )
        if not len(deck.midsides):
            return
        mesh, origin = self._whole
        on_faces = origin[facet_nodes(mesh, self._between(corners))].indices
        rows = np.intersect1d(on_faces, deck.midsides)
        missing = rows[(self._origin[0].unknowns[rows] < -1).any(axis=1)]
        if len(missing):
            raise ModelError(
                f"faces: node {deck.numbers[missing[0]]}, a midside node of a contact face, "
                "has no row in the matrix; retain such nodes"
            )
        free = rows[(self.unknowns[rows] >= 0).any(axis=1)]
        if len(free):
            raise ModelError(
                f"faces: node {deck.numbers[free[0]]}, a midside node of a contact face, does not "
                "follow its corners; name both faces in job.with_linear_faces"
            )

    @property
    def _kinematics(self) -> Kinematics:
        """The kinematics for forces on faces. Forces of plane jobs are per depth."""
        if self._known.is_axisymmetric:
            return "axisymmetric"
        return "space" if self._directions == 3 else "plane_strain"

    def force(
        self,
        where: str | ArrayLike,
        *,
        traction: object = None,
        pressure: object = None,
        total: object = None,
        nodal: object = None,
    ) -> Array:
        """(n,) nodal forces of one load, given in one of four ways.

        Forces on midside nodes of linear faces are passed on to the corners, and forces on held
        displacements are dropped.

        Parameters
        ----------
        where
            The nodes, see `nodes`: nodes of a face for traction, pressure and total, any nodes for
            nodal forces.
        traction
            (d,) components of a uniform traction on the outline between the nodes, force per area.
        pressure
            A number: uniform pressure on the outline between the nodes, force per area.
        total
            (d,) components of the sum of all forces, spread over the outline between the nodes as a
            uniform traction. In a plane job it is a force per depth, in an axisymmetric job the
            total around the circumference.
        nodal
            (d,) components of the force on each of the nodes, or (m, d) for m nodes. In a plane job
            it is a force per depth, in an axisymmetric job the total around the circumference.

        Raises
        ------
        ModelError
            Not exactly one of the four arguments is given; no facet of the outline joins the
            nodes; a value is not finite. Or a force acts on a displacement that is not held and
            that the matrix lacks, such as a displacement of a tied node. See also `nodes`.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.readers.read_calculix("tests/data/flat")
        >>> float(job.force("N_TOP", traction=[0.0, -1.0]).sum().round(9))
        -10.0
        >>> float(job.force("N_TOP", total=[0.0, -1.0]).sum().round(9))
        -1.0
        """
        amounts = {"traction": traction, "pressure": pressure, "total": total, "nodal": nodal}
        loads = {kind: value for kind, value in amounts.items() if value is not None}
        nodes = self.nodes(where)
        if len(loads) != 1:
            raise ModelError(
                f"force: {' and '.join(loads) or 'no load'}; "
                "give one of traction, pressure (force per area), total, nodal (force)"
            )
        ((kind, value),) = loads.items()
        deck = self._known
        job, T = self._origin
        forces = self._nodal_forces(nodes, kind, value)
        on_others = (job.unknowns < -1) & (np.abs(forces) > ROUNDING * np.abs(forces).max())
        if on_others.any():
            node, axis = np.argwhere(on_others)[0]
            reason = "give the deck of the same job"
            if deck.constraints:
                reason = f"the deck has {', '.join(deck.constraints)}"
            raise ModelError(
                f"force: it acts on node {deck.numbers[node]}, direction {axis + 1}, which is "
                f"neither in the matrix nor in *BOUNDARY ({reason}); load nodes that follow no "
                "others, or merge tied nodes"
            )
        values = np.zeros(len(job.labels))
        present = job.unknowns >= 0
        values[job.unknowns[present]] = forces[present]
        return frozen(T.T @ values)

    def _nodal_forces(self, nodes: Integers, kind: str, value: object) -> Array:
        """(nodes, d) forces of a load on some nodes, of one of the kinds that `force` takes."""
        d = self._directions
        if kind == "nodal":
            is_uniform = real_array("nodal", value).ndim == 1
            forces = np.zeros(self.points.shape)
            forces[nodes] = finite_array("nodal", value, (d,) if is_uniform else (len(nodes), d))
            return forces
        if kind == "pressure":
            pressure = finite_number("pressure", value)
            return -pressure * self._integrals(nodes)[:, :-1]
        # (nodes, 1) area of each node
        areas = self._integrals(nodes)[:, -1:]
        traction = areas * finite_array(kind, value, (d,))
        return traction / areas.sum() if kind == "total" else traction

    def _integrals(self, nodes: Integers) -> Array:
        """(nodes, d + 1) integrals of each node's shape function over the outline between nodes.

        The first d columns are integrals of the function times the outward normal; the last column
        is the integral of the function alone.
        """
        facets = self._between(nodes)
        mesh, origin = self._whole
        parts = boundary_forces(mesh, facets, _normals_and_one, self._kinematics)
        return np.asarray(origin.T @ parts.T)


def _normals_and_one(_: Array, normals: Array) -> Array:
    return np.concatenate([normals, np.ones((1, *normals.shape[1:]))])
