"""Faces of several bodies of one deck that lie on each other node by node."""

from itertools import combinations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import Mesh

from ...contact.checks import Array, place
from ...errors import ModelError
from ..faces import lines_along
from ..given import same_point
from ..ordering import Integers, parts_of, places_among, whole


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
