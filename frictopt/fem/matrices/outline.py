"""The outline of a mesh between some of its nodes."""

from typing import Any

import numpy as np

from ...errors import ModelError
from ..ordering import Integers

__all__ = ["outline", "walk"]


def outline(mesh: Any, nodes: Integers) -> Integers:
    """Facets of the outline all nodes of which are among some nodes.

    Raises
    ------
    ModelError
        There is none.
    """
    facets = mesh.boundary_facets()
    inside = np.asarray(facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)])
    if not len(inside):
        raise ModelError(f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face")
    return inside


def walk(mesh: Any, facets: Integers) -> Integers:
    """Nodes of a plane outline in order, the body on the right of the way: line by line, a closed one from its leftmost node.

    Parameters
    ----------
    mesh
        Plane mesh.
    facets
        Facets of its outline.

    Raises
    ------
    ModelError
        A node that more than two facets share.
    """
    start, end = mesh.facets[:, facets]
    along, inward = mesh.p[:, end] - mesh.p[:, start], mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1) - mesh.p[:, start]
    left = along[0] * inward[1] - along[1] * inward[0] > 0
    start, end = np.where(left, end, start), np.where(left, start, end)
    if (np.bincount(start) > 1).any():
        fork = tuple(map(float, mesh.p[:, np.bincount(start).argmax()]))
        raise ModelError(f"nodes: the outline forks at {fork}; give the nodes of one face")
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    inner = np.isin(start, end)
    order: list[int] = []
    for i in np.lexsort((*mesh.p[::-1, start], inner)):  # ends of open lines come first
        node = int(start[i])
        while node in onward:
            order.append(node)
            node = onward.pop(node)
        if not inner[i]:
            order.append(node)
    return np.array(order, dtype=np.intp)
