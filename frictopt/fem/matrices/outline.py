"""Facets of the outline of a job: those between some nodes, what acts on them, and the nodes amid their edges, which follow the corners."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix, diags
from skfem import Mesh

from ...contact.checks import Array
from ...errors import ModelError
from ..elements import facet_nodes
from ..faces import lines_along
from ..forms import boundary_forces
from ..midside import midside_ties
from ..ordering import Integers
from .deck import Deck

__all__ = ["along", "between", "check_midsides", "integrals", "normals_at", "tied"]


def between(mesh: Mesh, nodes: Integers) -> Integers:
    """Facets of the outline all corners of which are among some nodes.

    Raises
    ------
    ModelError
        There is none.
    """
    facets = mesh.boundary_facets()
    inside = facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]
    if not len(inside):
        raise ModelError(f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face")
    return np.asarray(inside)


def along(mesh: Mesh, nodes: Integers, numbers: Integers) -> Integers:
    """The corner nodes of a face in the order of the outline.

    Raises
    ------
    ModelError
        A node that lies on no facet between them.
    """
    order = np.concatenate([line for line, _ in lines_along(mesh, between(mesh, nodes), "nodes: the outline")])
    if len(order) != len(nodes):
        number = int(numbers[np.setdiff1d(nodes, order)[0]])
        raise ModelError(f"nodes: node {number} lies on no facet of the outline between these nodes; give the nodes of a face")
    return order


def integrals(mesh: Mesh, facets: Integers) -> tuple[Array, Array]:
    """Integrals over facets of each node's shape function times the outward normal, (nodes, d), and times 1, (nodes, 1)."""
    parts = boundary_forces(mesh, facets, lambda _, normals: np.concatenate([normals, np.ones((1, *normals.shape[1:]))]), "space").T
    return parts[:, :-1], parts[:, -1:]


def normals_at(mesh: Mesh, nodes: Integers, numbers: Integers) -> Array:
    """(N, d) unit normals out of the body at the corner nodes of a face.

    Raises
    ------
    ModelError
        A node that lies on no facet between them.
    """
    sums = integrals(mesh, between(mesh, nodes))[0][nodes]
    length = np.linalg.norm(sums, axis=1)
    if not length.all():
        number = int(numbers[nodes[length.argmin()]])
        raise ModelError(f"nodes: node {number} lies on no facet of the outline between these nodes; give all nodes of a face")
    return np.asarray(sums / length[:, None])


def check_midsides(whole: Mesh, origin: csr_matrix, facets: Integers, deck: Deck, unknowns: Integers) -> None:
    """Check that the nodes amid the edges of facets of contact faces follow others; arguments as in `tied`.

    Raises
    ------
    ModelError
        One of them moves on its own, or K has no row of it.
    """
    rows = np.intersect1d(origin[facet_nodes(whole, facets)].indices, deck.midsides)
    free, gone = rows[(unknowns[rows] >= 0).any(axis=1)], rows[(unknowns[rows] < -1).any(axis=1)]
    if len(lost := np.setdiff1d(gone, [node for (node, _, _), *_ in deck.constraints.equations])):
        raise ModelError(
            f"faces: node {int(deck.numbers[lost[0]])} is amid an edge of a contact face and has no row in the matrix; retain such nodes when you "
            "reduce a model, then go on with job.with_linear_faces()"
        )
    if len(free):
        raise ModelError(
            f"faces: node {int(deck.numbers[free[0]])} is amid an edge of a contact face and moves on its own; a contact has corner nodes alone: go "
            "on with job.with_linear_faces(), or name the faces of all contacts in it"
        )


def tied(
    K: csr_matrix, labels: Integers, deck: Deck, unknowns: Integers, whole: Mesh, origin: csr_matrix, faces: Sequence[Integers]
) -> tuple[csr_matrix, Integers, Deck]:
    """Stiffness, labels and deck of a job in which the nodes amid the edges of some facets follow the corners, `u = T y`: `T^T K T`.

    The deck says so by equations, which take forces on these nodes to the corners.

    Parameters
    ----------
    K, labels, deck, unknowns
        Those of the job.
    whole, origin
        Its mesh with the nodes amid edges, and the (its nodes, nodes of the deck) matrix of its nodes.
    faces
        Facets of each face.

    Raises
    ------
    ModelError
        Corners that follow other nodes, and what `midside_ties` refuses.
    """
    facets = np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *faces]))
    links, d = midside_ties(whole, facets, "with_linear_faces").tocoo(), whole.dim()
    given = np.full(whole.p.shape[1], -1)
    ends = origin.tocoo()
    own = (np.diff(origin.indptr) == 1)[ends.row]  # the others are added to complete elements, and follow of themselves
    given[ends.row[own]] = ends.col[own]
    node, axis = given[links.row // d], links.row % d
    own = (node >= 0) & (unknowns[node, axis] >= 0)
    node, axis, corner, other, weight = node[own], axis[own], links.col[own] // d, links.col[own] % d, links.data[own]
    rows, columns = unknowns[node, axis], unknowns[corner, other]
    if (columns < -1).any():
        number = int(deck.numbers[corner[columns < -1][0]])
        raise ModelError(f"with_linear_faces: corner node {number} follows others; take that constraint out, or let the others follow it")
    follows = np.zeros(len(labels))
    follows[rows] = 1.0
    free = columns >= 0
    T = diags(1 - follows) + csr_matrix((weight[free], (rows[free], columns[free])), shape=K.shape)
    T = csr_matrix(T)[:, np.flatnonzero(follows == 0)]
    terms: dict[tuple[int, int], list[tuple[int, int, float]]] = {}
    for i in range(len(node)):
        terms.setdefault((int(node[i]), int(axis[i])), []).append((int(corner[i]), int(other[i]), -float(weight[i])))
    equations = tuple(((*end, 1.0), *rest) for end, rest in terms.items())
    constraints = replace(deck.constraints, equations=(*deck.constraints.equations, *equations))
    return csr_matrix(T.T @ K @ T), labels[follows == 0], replace(deck, constraints=constraints)
