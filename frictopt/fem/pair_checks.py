"""Checks of node pairs: their order along contacts in the plane, and the sides of their normals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..base import CONDENSATION, Array, Booleans, Integers, first_of, place
from ..errors import ModelError
from .interface import Interface


@dataclass(frozen=True)
class SideSettings:
    """Tolerances of `check_sides`."""

    # A neighbour lies in the plane of the contact if its height, relative to its distance, is less.
    in_plane: float = 1e3 * CONDENSATION
    # A shift pulls a node if the force exceeds this share of its stiffness. Smaller forces are
    # rounding.
    pulled: float = 1e3 * CONDENSATION
    # A body of one element has at most this many nodes, all connected to each other.
    element_nodes: int = 8
    # A body is a reduced model if more than this share of its pairs of nodes are connected.
    reduced: float = 0.75


SETTINGS = SideSettings()


def check_order(points: Array, frames: Array, names: Sequence[str]) -> None:
    """Check that the pairs of each contact in the plane run along their tangents, without flips.

    `points` (N, 2) are the places of the pairs, `frames` their directions, and `names` their
    contacts.
    """
    contact = np.array(names)
    inside = contact[1:] == contact[:-1]  # steps (N - 1,) within one contact

    def step(k: int) -> str:
        return f"from pair {k} at {place(points[k])} to pair {k + 1} at {place(points[k + 1])}"

    normals = frames[:, 1]
    flips = inside & (np.sum(normals[1:] * normals[:-1], axis=1) <= 0)
    if (k := first_of(flips)) is not None:
        raise ModelError(
            f"normals: they turn by 90 degrees or more {step(k)}; let all point into body 1, and "
            "give each side of a corner a contact"
        )

    tangents = frames[:, 0]
    steps = np.diff(points, axis=0)
    progress = np.minimum(
        np.sum(tangents[1:] * steps, axis=1), np.sum(tangents[:-1] * steps, axis=1)
    )
    backwards = inside & (progress <= 0)
    if (k := first_of(backwards)) is not None:
        hint = "order the pairs along the contact"
        if backwards[inside & (contact[1:] == contact[k])].all():
            hint = "reverse the pairs (or the normals, and exchange the bodies)"
        raise ModelError(
            f"pairs: {step(k)} they go against the tangent, which is the normal turned by -90 "
            f"degrees; {hint}"
        )


def check_sides(
    K: csr_matrix, unknowns: Integers, graph: csr_matrix, interface: Interface, points: Array
) -> None:
    """Check that the normals point from body 2 into body 1.

    Neighbours of a pair that are not on the contact lie ahead of it in body 1 and behind it in
    body 2. A normal is rejected if neighbours in both bodies contradict it, or if some contradict
    it and none agrees. At a re-entrant corner, neighbours in one body may contradict it.
    """
    links = interface.opening.tocoo()  # `row` is the pair, `col` the node, `data` its weight
    is_telling = _telling(K, unknowns, graph)[links.col]
    pair = links.row[is_telling]
    node = links.col[is_telling]
    side = np.sign(links.data[is_telling])  # 1 in body 1, -1 in body 2

    # Each entry is a neighbour of a node. Its height is positive if it agrees with the normal.
    neighbours = graph[node].tocoo()
    neighbour_pair = pair[neighbours.row]
    neighbour_side = side[neighbours.row]
    arms = points[neighbours.col] - points[node[neighbours.row]]
    normals = interface.frames[:, -1]
    heights = neighbour_side * np.sum(normals[neighbour_pair] * arms, axis=1)
    off_plane = np.abs(heights) > SETTINGS.in_plane * np.linalg.norm(arms, axis=1)
    counts = off_plane & ~np.isin(neighbours.col, links.col)

    def any_neighbour(flags: Booleans) -> Booleans:
        """(2, N) whether any counted neighbour of a pair in body 1, and in body 2, has a flag."""
        number = neighbour_pair + len(normals) * (neighbour_side < 0)
        flagged = np.bincount(number[counts & flags], minlength=2 * len(normals)) > 0
        return flagged.reshape(2, -1)

    agree = any_neighbour(heights > 0)
    contradict = any_neighbour(heights < 0)
    is_wrong = contradict.all(axis=0) | (contradict.any(axis=0) & ~agree.any(axis=0))
    if (i := first_of(is_wrong)) is not None:
        raise ModelError(
            f"normals: that of pair {i} at {place(points[interface.nodes[i]])} does not point "
            "from body 2 into body 1, judging by their nodes; reverse it, or exchange the nodes "
            "of the pair (if all normals are reversed, in the plane also reverse the order of the "
            "pairs)"
        )


def _telling(K: csr_matrix, unknowns: Integers, graph: csr_matrix) -> Booleans:
    """(nodes,) nodes whose neighbours show the side on which their body lies.

    Two kinds of nodes do not. Nodes connected to clamped nodes lack neighbours, because the matrix
    no longer contains these; clamped nodes pull them back in every shift. In reduced models every
    node is connected to every other.
    """
    listed = unknowns >= 0
    shifts = np.zeros((K.shape[0], unknowns.shape[1]))  # column a: all nodes move along axis a
    shifts[unknowns[listed], np.nonzero(listed)[1]] = 1.0
    is_pulled = np.abs(K @ shifts) > SETTINGS.pulled * np.abs(K.diagonal())[:, None]
    # (nodes, d, d): displacement of a node, axis of the shift
    pulled = is_pulled[unknowns] & listed[..., None]
    is_pulled_always = pulled.any(axis=1).all(axis=1)

    _, body = connected_components(graph, directed=False)
    size = np.bincount(body)
    connections = np.bincount(body, np.diff(graph.indptr))
    is_mesh = (size <= SETTINGS.element_nodes) | (connections < SETTINGS.reduced * size**2)
    return np.asarray(is_mesh[body] & ~is_pulled_always)
