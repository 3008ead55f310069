"""Numbers of nodes: parts that hang together, and an order of elimination by nested dissection on coordinates."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from ..contact.checks import Array

_LEAF = 64  # parts of at most this many nodes are not cut further
_NEAR, _FAR, _SEPARATOR = 0, 1, 2  # elimination order within a part

Integers: TypeAlias = NDArray[np.intp]
Flags: TypeAlias = NDArray[np.bool_]

NO_ROWS: Integers = np.zeros(0, dtype=np.intp)


def whole(values: ArrayLike) -> Integers:
    """A read-only copy of whole numbers."""
    array = np.array(values, dtype=np.intp)
    array.flags.writeable = False
    return array


def parts_of(links: Sequence[Integers] | Integers, size: int) -> Integers:
    """(size,) number of the part that each of some things belongs to, by links (2, m) of them."""
    return np.asarray(connected_components(coo_matrix((np.ones(len(links[0])), tuple(links)), shape=(size, size)), directed=False)[1])


def places_among(rows: Integers, others: Integers) -> Integers:
    """(m,) place of each row of numbers (m, k) among others (n, k), in whatever order they stand in a row; -1 where it is none of them."""
    _, number = np.unique(np.sort(np.concatenate([others, rows]), axis=1), axis=0, return_inverse=True)
    place = np.full(len(number), -1)
    place[number.ravel()[: len(others)]] = np.arange(len(others))
    return np.asarray(place[number.ravel()[len(others) :]])


def nested_dissection(graph: csr_matrix, points: Array) -> Integers:
    """Divide the nodes of a mesh into fronts, so that the elimination of one front after the other makes little fill (George 1973).

    Every part is cut in two at the median of one coordinate, the one whose cut crosses fewest edges; the nodes on the near side of a
    crossed edge separate the halves and are a front, eliminated after both. Parts that are not cut further are fronts. All parts of one level are
    cut at once.

    Parameters
    ----------
    graph
        (n, n) matrix whose pattern is the adjacency of the nodes.
    points
        (d, n) coordinates, d = 2 or 3.

    Returns
    -------
    (n,) integers
        The number of the front of each node, in the order of elimination.
    """
    n = graph.shape[0]
    pattern = graph.tocoo()
    once = pattern.row < pattern.col
    edges = np.array([pattern.row[once], pattern.col[once]])
    sorted_nodes = np.argsort(points, axis=1, kind="stable")
    key = np.zeros(n, dtype=np.int64)  # path of the node from the root, digits in base 3
    part = np.zeros(n, dtype=np.intp)  # number of the part that the node is in; -1 once it has its place
    while (sizes := np.bincount(part[part >= 0], minlength=1)).max() > _LEAF:
        part[(part >= 0) & (sizes[part] <= _LEAF)] = -1
        names, labels = np.unique(part[part >= 0], return_inverse=True)
        part[part >= 0] = labels
        edges = edges[:, (part[edges[0]] >= 0) & (part[edges[0]] == part[edges[1]])]
        near, crossing, stuck = _best_cut(part, edges, points, sorted_nodes, len(names))
        digit = np.where(near, _NEAR, _FAR)
        ends = edges[:, crossing].ravel()
        digit[ends[near[ends]]] = _SEPARATOR
        digit[part < 0] = 0
        key = 3 * key + digit
        part = np.where((part < 0) | (digit == _SEPARATOR) | stuck, -1, 2 * part + digit)
    return np.asarray(np.unique(key, return_inverse=True)[1])


def _best_cut(part: Integers, edges: Integers, points: Array, sorted_nodes: Integers, parts: int) -> tuple[Flags, Flags, Flags]:
    """Cut every part across each axis and keep, part by part, the cut that crosses fewest edges.

    Returns, for each node, whether it is on the near side; for each edge, whether it is cut; for each node, whether its part cannot be cut.
    """
    sides, costs = [], []
    for axis in range(len(points)):
        nodes = sorted_nodes[axis][part[sorted_nodes[axis]] >= 0]
        by_part = nodes[np.argsort(part[nodes].astype(np.uint16 if parts < 2**16 else np.intp), kind="stable")]
        sizes = np.bincount(part[nodes], minlength=parts)
        median = points[axis, by_part[np.cumsum(sizes) - sizes + (sizes - 1) // 2]]
        near = points[axis] <= median[part]
        cut = near[edges[0]] != near[edges[1]]
        uncut = np.bincount(part[nodes], weights=~near[nodes], minlength=parts) == 0
        costs.append(np.where(uncut, np.inf, np.bincount(part[edges[0, cut]], minlength=parts)))
        sides.append(near)
    best = np.argmin(costs, axis=0)
    near = np.choose(best[part], sides)
    return near, near[edges[0]] != near[edges[1]], np.isinf(np.min(costs, axis=0))[part]
