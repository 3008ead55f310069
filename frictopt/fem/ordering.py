"""Numbers of nodes: parts that hang together, and an order of elimination by nested dissection on coordinates."""

from collections.abc import Sequence
from itertools import count
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from ..contact.checks import Array

_LEAF = 64  # parts of at most this many nodes are not cut further
_FAR, _NEAR, _SEPARATOR = 0, 1, 2  # sides of a cut

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
    crossed edge separate the halves and are a front, eliminated after both. Parts that are not cut further are fronts.

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
    pattern, front, side = graph.tocoo(), np.zeros(graph.shape[0], dtype=np.intp), np.zeros(graph.shape[0], dtype=np.int8)
    once, numbers = pattern.row < pattern.col, count()

    def divide(nodes: Integers, edges: Integers) -> None:
        """Number the fronts of a part, which has its edges, after those that are numbered."""
        cuts, middle = [], (len(nodes) - 1) // 2
        for x in points if len(nodes) > _LEAF else ():
            near = x[nodes] <= np.partition(x[nodes], middle)[middle]
            side[nodes] = near
            if not near.all():
                cuts.append((np.count_nonzero(side[edges[0]] != side[edges[1]]), near))
        if cuts:
            side[nodes] = min(cuts, key=lambda cut: cut[0])[1]
            ends = edges[:, side[edges[0]] != side[edges[1]]]
            side[ends[side[ends] == _NEAR]] = _SEPARATOR
            own, joined = side[nodes], side[edges]
            for half in (_NEAR, _FAR):
                divide(nodes[own == half], edges[:, (joined == half).all(axis=0)])
            nodes = nodes[own == _SEPARATOR]
        front[nodes] = next(numbers)

    divide(np.arange(graph.shape[0]), np.array([pattern.row[once], pattern.col[once]]))
    return np.asarray(np.unique(front, return_inverse=True)[1])
