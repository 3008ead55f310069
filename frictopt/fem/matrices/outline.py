"""Facets of the outline of a job: what acts on them, the nodes amid their edges, and faces of several bodies that lie on each other node by node."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import Mesh

from ...contact.checks import Array, finite_array, finite_number, place, real_array
from ...errors import ModelError
from ..elasticity import boundary_forces
from ..elements import facet_nodes, midside_ties
from ..faces import lines_along
from ..given import same_point
from ..ordering import Integers, parts_of, places_among, whole
from .constraints import rows_of_nodes
from .deck import Deck


def between(mesh: Mesh, nodes: Integers, numbers: Integers | None = None) -> Integers:
    """Facets of the outline all corners of which are among some nodes; with the numbers of all nodes, each of these is a corner of one.

    Raises
    ------
    ModelError
        There is none, or a node is no corner of one.
    """
    facets = mesh.boundary_facets()
    inside = facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]
    if not len(inside):
        raise ModelError(f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face")
    if numbers is not None and len(lost := np.setdiff1d(nodes, mesh.facets[:, inside])):
        raise ModelError(f"nodes: node {numbers[lost[0]]} lies on no facet of the outline between these nodes; give the nodes of a face")
    return np.asarray(inside)


def along(mesh: Mesh, nodes: Integers, numbers: Integers) -> Integers:
    """The corner nodes of a face in the order of the outline."""
    return np.concatenate([line for line, _ in lines_along(mesh, between(mesh, nodes, numbers), "nodes: the outline")])


def integrals(mesh: Mesh, facets: Integers) -> tuple[Array, Array]:
    """Integrals over facets of each node's shape function times the outward normal, (nodes, d), and times 1, (nodes, 1)."""
    parts = boundary_forces(mesh, facets, lambda _, normals: np.concatenate([normals, np.ones((1, *normals.shape[1:]))]), "space").T
    return parts[:, :-1], parts[:, -1:]


def acting(
    given: Mapping[str, object],
    nodes: Integers,
    deck: Deck,
    labels: Integers,
    d: int,
    over: Callable[[Integers], tuple[Array, Array]],
) -> Array:
    """(labels,) nodal forces of a load that is said in one of four ways, see `MatrixJob.force`; `over` has the integrals between some nodes.

    Raises
    ------
    ModelError
        None or several of the four, values that are not finite, axisymmetric elements, forces of which it is not known where they go.
    """
    if len(given) != 1:
        raise ModelError(f"force: {' and '.join(given) or 'no load'}; give one of traction, pressure (force per area), total, nodal (force)")
    if axisymmetric := sorted({kind for kind, _, _ in deck.elements if kind.startswith("CAX")}):
        raise ModelError(f"force: elements {axisymmetric[0]} are axisymmetric; give condense the nodal forces that belong to the code's matrix")
    ((name, value),), rows = given.items(), rows_of_nodes(labels, deck.numbers, deck.constraints)
    forces = np.zeros(rows.shape)
    if name == "nodal":
        forces[nodes, :d] = finite_array("nodal", value, (d,) if real_array("nodal", value).ndim == 1 else (len(nodes), d))
    elif name == "pressure":
        forces[:, :d] = -finite_number("pressure", value) * over(nodes)[0]
    else:
        share = over(nodes)[1]
        forces[:, :d] = share * finite_array(name, value, (d,)) / (share.sum() if name == "total" else 1.0)
    present, values = rows >= 0, np.zeros(len(labels))
    values[rows[present]] = deck.constraints.passed_on(forces, present, deck.numbers)[present]
    return values


def normals_at(mesh: Mesh, nodes: Integers, numbers: Integers) -> Array:
    """(N, d) unit normals out of the body at the corner nodes of a face."""
    sums = integrals(mesh, between(mesh, nodes, numbers))[0][nodes]
    return np.asarray(sums / np.linalg.norm(sums, axis=1)[:, None])


def check_midsides(whole: Mesh, origin: csr_matrix, facets: Integers, deck: Deck, unknowns: Integers) -> None:
    """Check that the nodes amid the edges of facets of contact faces follow others; arguments as in `tied`.

    Raises
    ------
    ModelError
        One of them moves on its own, or K has no row of it.
    """
    rows = np.intersect1d(origin[facet_nodes(whole, facets)].indices, deck.midsides)
    free, gone = rows[(unknowns[rows] >= 0).any(axis=1)], rows[(unknowns[rows] < -1).any(axis=1)]
    if len(lost := np.setdiff1d(gone, deck.constraints.ends[:, 0] // 6)):
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
    labels: Integers, deck: Deck, unknowns: Integers, whole: Mesh, origin: csr_matrix, faces: Sequence[Integers]
) -> tuple[csr_matrix, Integers, Deck]:
    """(n, m) matrix T, labels and deck of a job in which the nodes amid the edges of some facets follow the corners: `u = T y`, `T^T K T`.

    The deck says so too, which takes forces on these nodes to the corners.

    Parameters
    ----------
    labels, deck, unknowns
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
    T = diags(1 - follows) + csr_matrix((weight[free], (rows[free], columns[free])), shape=(len(labels),) * 2)
    constraints = deck.constraints.following(np.column_stack([6 * node + axis, 6 * corner + other]), weight)
    return csr_matrix(T)[:, np.flatnonzero(follows == 0)], labels[follows == 0], replace(deck, constraints=constraints)


def bodies_of(graph: csr_matrix, unknowns: Integers) -> Integers:
    """(nodes,) number of the body that each node belongs to, by a graph of the nodes; -1 for those without a row in K."""
    _, body = connected_components(graph, directed=False)
    present = (unknowns >= 0).any(axis=1)
    bodies = np.full(len(body), -1)
    bodies[present] = np.unique(body[present], return_inverse=True)[1]
    return whole(bodies)


def paired(points: Array, one: Integers, two: Integers, numbers: Integers, argument: str) -> Integers:
    """(N, 2) the nodes of a face, each with the nearest one of another, in the order of the second.

    Raises
    ------
    ModelError
        Different numbers of nodes, nodes in common, or one that is nearest to several; messages begin with `argument`.
    """
    if len(one) != len(two) or np.isin(one, two).any():
        problem = f"{len(one)} and {len(two)} nodes" if len(one) != len(two) else "nodes in common"
        raise ModelError(f"{argument}: {problem}; mesh both with the same nodes, each with its own")
    nearest = one[cKDTree(points[one]).query(points[two])[1]]
    taken, count = np.unique(nearest, return_counts=True)
    if len(taken) != len(one):
        raise ModelError(f"{argument}: node {int(numbers[taken[count.argmax()]])} is the nearest one to several; mesh both with the same nodes")
    return np.column_stack([nearest, two])


def matching_faces(points: Array, body: Integers, mesh: Mesh | None) -> list[Integers]:
    """(N, 2) pairs of each connected face at which two bodies have their nodes, and the facets between them, in the same places.

    Parameters
    ----------
    points
        (nodes, d) coordinates.
    body
        (nodes,) number of the body that each node belongs to, -1 for none.
    mesh
        Its facets; None: nodes alone tell, and what two bodies share is one face.

    Raises
    ------
    ModelError
        A node that lies on several nodes of one other body.
    """
    i, j = cKDTree(points).query_pairs(same_point(points), output_type="ndarray").T
    i, j = np.where(body[i] < body[j], (i, j), (j, i))
    found: list[Integers] = []
    for a, b in combinations(np.unique(body[body >= 0]), 2):
        own = (body[i] == a) & (body[j] == b)
        one, two = i[own], j[own]
        for nodes in (one, two):
            if len(nodes) and (times := np.bincount(nodes)).max() > 1:
                raise ModelError(f"matching_faces: the node at {place(points[times.argmax()])} lies on several of one other body; merge these nodes")
        image = np.full(len(points), -1)
        image[two] = one
        faces = [np.sort(two)] if mesh is None and len(two) else [] if mesh is None else _faces(mesh, image)
        found += [np.column_stack([image[nodes], nodes]) for nodes in faces]
    return found


def _faces(mesh: Mesh, image: Integers) -> list[Integers]:
    """Nodes of each connected face of facets of the outline whose images, where they are no less than 0, are facets of the outline too."""
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    here = (image[nodes] >= 0).all(axis=0)
    here[here] = places_among(image[nodes[:, here]].T, nodes.T) >= 0
    if mesh.dim() == 2:
        return [line for line, _ in lines_along(mesh, outline[here], "matching_faces: the outline")] if here.any() else []
    ends = nodes[:, here]
    part = parts_of((np.tile(ends[0], len(ends) - 1), ends[1:].ravel()), len(image))
    return [np.unique(ends[:, part[ends[0]] == number]) for number in dict.fromkeys(part[ends[0]].tolist())]
