"""A stiffness matrix that another code wrote, with the deck that says where its nodes are."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import Mesh

from ...contact.checks import Array, finite_array, finite_number, frozen, real_array, shown
from ...contact.show import Shown
from ...errors import ModelError
from ..faces import lines_along
from ..forms import boundary_forces
from ..given import checked_stiffness
from ..ordering import Integers
from .deck import Deck
from .meshes import mesh_of

__all__ = ["MatrixJob"]


@dataclass(frozen=True, eq=False, repr=False)
class MatrixJob(Shown):
    """Stiffness matrix of another code, with labels, and the nodes and sets of its deck: what `condense` asks for.

    Lengths and forces have the units of the deck; a plane job is per unit depth: stiffness and forces are divided by the thickness of its section.

    Parameters
    ----------
    K
        (n, n) stiffness, symmetric and sparse; displacements that the job holds, or that follow others, are not in it.
    labels
        (n, 2) number of the node, and direction 1, 2 or 3, of each unknown.
    deck
        Nodes, sets, elements and constraints; None if there is no deck.

    Raises
    ------
    ModelError
        K that is not symmetric or not of the size of the labels, labels that are given twice, directions other than 1, 2 and 3.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job
    MatrixJob(unknowns=964, directions=2, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'])
    >>> pairs = job.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    >>> pairs.shape
    (26, 2)
    >>> round(float(job.force("N_TOP", pressure=1.0).sum()), 9)  # on a face 10 wide
    -10.0
    """

    K: csr_matrix
    labels: Integers
    deck: Deck | None = None

    def __post_init__(self) -> None:
        labels = _checked_labels(self.labels)
        if self.deck is not None and not isinstance(self.deck, Deck):
            raise ModelError(f"deck: {shown(self.deck)}; give the deck of another job, or None")
        K = checked_stiffness(self.K)
        if K.shape[0] != len(labels):
            raise ModelError(f"K: {shown(self.K)}; give a real sparse matrix of the size of the labels, {len(labels)}")
        object.__setattr__(self, "K", csr_matrix((K + K.T) / 2))
        object.__setattr__(self, "labels", labels)

    def _answer(self) -> Mapping[str, object]:
        return {"unknowns": len(self.labels), "directions": self._directions, "sets": sorted(self.deck.sets) if self.deck else None}

    @property
    def _directions(self) -> int:
        return max(2, int(self.labels[:, 1].max()))

    @property
    def _known(self) -> Deck:
        if self.deck is None:
            raise ModelError("deck: this job was read without one; read it with deck='NAME.inp' to use its nodes and sets")
        return self.deck

    @cached_property
    def points(self) -> Array:
        """(nodes, d) coordinates of the nodes of the deck; d = 2 for a plane job."""
        return frozen(self._known.points[:, : self._directions])

    @cached_property
    def unknowns(self) -> Integers:
        """(nodes, d) row of K of each node's displacements, -1 where `*BOUNDARY` holds them, -2 where K has none else: they follow others.

        Raises
        ------
        ModelError
            The matrix has labels of nodes that are not in the deck.
        """
        numbers = self._known.numbers
        order = np.argsort(numbers)
        place = np.minimum(np.searchsorted(numbers, self.labels[:, 0], sorter=order), len(numbers) - 1)
        row = order[place]
        if not np.array_equal(numbers[row], self.labels[:, 0]):
            lost = int(self.labels[np.argmax(numbers[row] != self.labels[:, 0]), 0])
            raise ModelError(f"deck: node {lost} of the matrix is not in it; give the deck of the same job")
        unknowns = np.where(self._known.constraints.held[:, : self._directions], -1, -2)
        unknowns[row, self.labels[:, 1] - 1] = np.arange(len(self.labels))
        unknowns.flags.writeable = False
        return unknowns

    @cached_property
    def mesh(self) -> Mesh:
        """scikit-fem mesh of the deck, its nodes in the order of `points`; see `Deck.shaped` for the errors."""
        return mesh_of(self._known, self._directions)

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
        if isinstance(where, str):
            return self._known.nodes(where)
        raw = real_array("nodes", where)
        if raw.ndim != 1 or not raw.size or not np.isin(raw, np.arange(len(self.points))).all() or len(np.unique(raw)) != len(raw):
            raise ModelError(f"nodes: {shown(where)}; give the name of a node set or different rows of `points`")
        return raw.astype(np.intp)

    def pairs(self, first: str | ArrayLike, second: str | ArrayLike) -> Integers:
        """(N, 2) pairs of nodes on two faces, each node with the nearest one; in a plane job in the order of the face, body 1 on the left.

        Parameters
        ----------
        first, second
            Nodes on body 1 and on body 2, see `nodes`.

        Raises
        ------
        ModelError
            Faces of different numbers of nodes or with nodes in common, a node that is nearest to two others; see `nodes`.
        """
        one, two = self.nodes(first), self.nodes(second)
        if len(one) != len(two) or np.isin(one, two).any():
            problem = f"{len(one)} and {len(two)} nodes" if len(one) != len(two) else "nodes in common"
            raise ModelError(f"faces {shown(first)} and {shown(second)}: {problem}; mesh both with the same nodes, each with its own")
        if self._directions == 2:
            two = self._along(two)
        nearest = one[cKDTree(self.points[one]).query(self.points[two])[1]]
        taken, count = np.unique(nearest, return_counts=True)
        if len(taken) != len(one):
            node = int(self._known.numbers[taken[count.argmax()]])
            raise ModelError(f"faces {shown(first)} and {shown(second)}: node {node} is the nearest one to several; mesh both with the same nodes")
        return np.column_stack([nearest, two])

    def _along(self, nodes: Integers) -> Integers:
        """The nodes of a face in the order of the outline."""
        order = np.concatenate([line for line, _ in lines_along(self.mesh, self._outline(nodes), "nodes: the outline")])
        if len(order) != len(nodes):
            number = int(self._known.numbers[np.setdiff1d(nodes, order)[0]])
            raise ModelError(f"nodes: node {number} lies on no facet of the outline between these nodes; give the nodes of a face")
        return order

    def normals(self, face: str | ArrayLike) -> Array:
        """(N, d) unit normals that point out of the body at nodes on a face, the mean over the facets weighted by their size.

        Parameters
        ----------
        face
            The nodes of the whole face, see `nodes`: of body 2, `pairs[:, 1]`.

        Raises
        ------
        ModelError
            Nodes that no facet of the outline joins; see `nodes`.
        """
        rows = self.nodes(face)
        sums = self._over_outline(rows)[0][rows]
        length = np.linalg.norm(sums, axis=1)
        if not length.all():
            number = int(self._known.numbers[rows[length.argmin()]])
            raise ModelError(f"nodes: node {number} lies on no facet of the outline between these nodes; give all nodes of a face")
        return frozen(sums / length[:, None])

    def force(self, where: str | ArrayLike, *, traction: object = None, pressure: object = None, total: object = None, nodal: object = None) -> Array:
        """(n,) nodal forces of one load, said in one of four ways. What acts on displacements that follow others goes to these.

        A force on a held displacement goes to the ground, as it does in the code.

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
        if len(given) != 1:
            raise ModelError(f"force: {' and '.join(given) or 'no load'}; give one of traction, pressure (force per area), total, nodal (force)")
        if axisymmetric := sorted({kind for kind, _, _ in self._known.elements if kind.startswith("CAX")}):
            raise ModelError(f"force: elements {axisymmetric[0]} are axisymmetric; give condense the nodal forces that belong to the code's matrix")
        nodes, d = self.nodes(where), self._directions
        forces = np.zeros((len(self.points), 3))
        if nodal is not None:
            forces[nodes, :d] = finite_array("nodal", nodal, (d,) if real_array("nodal", nodal).ndim == 1 else (len(nodes), d))
        elif pressure is not None:
            forces[:, :d] = -finite_number("pressure", pressure) * self._over_outline(nodes)[0]
        else:
            ((name, value),), share = given.items(), self._over_outline(nodes)[1]
            forces[:, :d] = share * finite_array(name, value, (d,)) / (1.0 if total is None else share.sum())
        present = np.zeros(forces.shape, dtype=bool)
        present[:, :d] = self.unknowns >= 0
        moved, values = self._known.constraints.passed_on(forces, present, self._known.numbers), np.zeros(len(self.labels))
        values[self.unknowns[present[:, :d]]] = moved[present]
        return frozen(values)

    def _outline(self, nodes: Integers) -> Integers:
        """Facets of the outline all nodes of which are among some nodes."""
        facets = self.mesh.boundary_facets()
        inside = facets[np.isin(self.mesh.facets[:, facets], nodes).all(axis=0)]
        if not len(inside):
            raise ModelError(f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face")
        return np.asarray(inside)

    def _over_outline(self, nodes: Integers) -> tuple[Array, Array]:
        """Integrals over the outline between some nodes of each node's shape function times the normal, (nodes, d), and times 1, (nodes, 1)."""
        facets = self._outline(nodes)
        parts = boundary_forces(self.mesh, facets, lambda _, normals: np.concatenate([normals, np.ones((1, *normals.shape[1:]))]), "space")
        columns = np.pad(parts.T, ((0, len(self.points) - parts.shape[1]), (0, 0)))  # without the last nodes if no element has them
        return columns[:, :-1], columns[:, -1:]


def _checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct pairs of a node's number and a direction 1, 2 or 3, and return them read-only."""
    labels = finite_array("labels", values, (None, 2))
    if not len(labels):
        raise ModelError("labels: none; give the node and the direction of each row")
    bad = (labels != np.floor(labels)).any(axis=1) | (labels[:, 0] < 1) | (labels[:, 1] < 1) | (labels[:, 1] > 3)
    if bad.any():
        node, direction = labels[bad.argmax()]
        raise ModelError(
            f"labels: node {node:g}, direction {direction:g}; only displacements 1, 2 and 3 of nodes are supported: "
            "leave out shells, beams, other fields and internal nodes"
        )
    if len(np.unique(labels, axis=0)) != len(labels):
        raise ModelError(f"labels: {len(labels) - len(np.unique(labels, axis=0))} labels are given twice; let the code write the matrix again")
    checked = labels.astype(np.intp)
    checked.flags.writeable = False
    return checked
