"""Elimination of unknowns from a sparse stiffness, front after front.

The fronts are found by nested dissection on coordinates. The elimination leaves the Schur
complement of the kept unknowns.
"""

from collections.abc import Sequence
from enum import IntEnum
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.linalg import LinAlgError, blas, lapack
from scipy.sparse import csr_matrix, triu

from ..base import ROUNDING, Array, Integers, progress_bar

Factor: TypeAlias = tuple[Integers, Integers, Array, Array]
"""Factor of a front, for `solve`.

It has the unknowns of the front, the later unknowns that they are connected to, the triangular
factor of the front, and the rows of the later unknowns.
"""
_Update: TypeAlias = tuple[Integers, Array]  # later unknowns, and the matrix that a front left them


# Numbers of the elimination.

# Parts of at most this many nodes are not cut further.
_LEAF = 64
# An unknown has no stiffness left if less than this share of its first stiffness remains.
_NO_STIFFNESS = ROUNDING / 10


def nested_dissection(graph: csr_matrix, points: Array) -> Integers:
    """Divide the nodes of a mesh into fronts whose elimination makes little fill (George 1973).

    Every part is cut in two at the median of the coordinate whose cut crosses the fewest edges. The
    nodes on the near side of a crossed edge separate the halves: they are a front, eliminated after
    both halves. Parts that are not cut further are fronts.

    The (n, n) pattern of the graph is the adjacency of the nodes, and the points are (d, n).
    The result is the front (n,) of each node, numbered in the order of elimination.
    """
    pattern = graph.tocoo()
    once = pattern.row < pattern.col
    edges = np.array([pattern.row[once], pattern.col[once]])
    n = graph.shape[0]
    front = np.zeros(n, dtype=np.intp)
    parts = _dissected(np.arange(n), edges, points, side=np.zeros(n, dtype=np.int8))
    for number, nodes in enumerate(part for part in parts if len(part)):
        front[nodes] = number
    return front


class _Side(IntEnum):
    """Where a node lies relative to a cut."""

    FAR = 0
    NEAR = 1
    SEPARATOR = 2


def _dissected(nodes: Integers, edges: Integers, points: Array, side: Array) -> list[Integers]:
    """The fronts of a part with its edges (2, m), in the order of elimination.

    `side` (all nodes,) is work space.
    """
    cut = _cut(nodes, edges, points, side)
    if cut is None:
        return [nodes]
    side[nodes] = cut
    crossed = edges[:, side[edges[0]] != side[edges[1]]]
    side[crossed[side[crossed] == _Side.NEAR]] = _Side.SEPARATOR
    of_nodes = side[nodes]
    of_edges = side[edges]
    fronts = []
    for half in (_Side.NEAR, _Side.FAR):
        inside = edges[:, (of_edges == half).all(axis=0)]
        fronts += _dissected(nodes[of_nodes == half], inside, points, side)
    return [*fronts, nodes[of_nodes == _Side.SEPARATOR]]


def _cut(nodes: Integers, edges: Integers, points: Array, side: Array) -> Array | None:
    """Flags of the nodes of a part that lie on the near side of the cut that crosses fewest edges.

    None if the part is not cut, because it is small or all its nodes coincide.
    """
    if len(nodes) <= _LEAF:
        return None
    best = None
    fewest = len(edges[0]) + 1
    middle = (len(nodes) - 1) // 2
    for x in points:
        near = x[nodes] <= np.partition(x[nodes], middle)[middle]
        side[nodes] = near
        crossed = int(np.count_nonzero(side[edges[0]] != side[edges[1]]))
        if not near.all() and crossed < fewest:
            best = near
            fewest = crossed
    return best


class _Front(NamedTuple):
    """The blocks of a front; only the lower triangle of symmetric blocks is used."""

    later: Integers  # later unknowns that the front is connected to
    pivot: Array  # block of the unknowns of the front
    coupling: Array  # rows of the later unknowns, columns of the front
    contribution: Array  # block of the later unknowns


def eliminate(
    K: csr_matrix, front: Integers, *, keep: type | None = None
) -> tuple[Array, list[Factor]]:
    """Multifrontal Cholesky factorisation of a sparse matrix (Duff & Reid 1983).

    A front is a dense matrix of some unknowns that are eliminated together, and of the later
    unknowns that they are connected to. Its elimination leaves an update of these later unknowns,
    which waits for the front that eliminates the first of them. Fronts are dropped once they are
    eliminated.

    `front` (unknowns,) is the number of the front that eliminates each unknown, from 0 on; -1: the
    unknown is kept. The results are the (kept, kept) Schur complement `K_rr - K_ri K_ii^-1 K_ir`,
    in the order of K, and the factors for `solve` in the precision `keep` (None: no factors). If
    the eliminated part is not positive definite, LinAlgError is raised, with the unknown at which
    this shows.
    """
    count = int(front.max(initial=-1)) + 1
    front = np.where(front < 0, count, front)  # kept unknowns come last
    order = np.argsort(front, kind="stable")
    front = front[order]
    upper = triu(K[order][:, order], format="csr")
    smallest = _NO_STIFFNESS * np.abs(K.diagonal()[order])
    starts = np.r_[np.searchsorted(front, np.arange(count + 1)), len(order)]
    place = np.zeros(len(order), dtype=np.intp)
    waiting: list[list[_Update]] = [[] for _ in range(count + 1)]
    factors: list[Factor] = []
    with progress_bar(True, "elimination", "unknown", total=int(starts[-2])) as bar:
        for k, (first, last) in enumerate(pairwise(starts[:-1])):
            later, pivot, coupling, contribution = _assembled(upper, first, last, waiting[k], place)
            pivot, failed = lapack.dpotrf(pivot, lower=1, overwrite_a=1)
            pivots = np.diag(pivot) ** 2
            if failed:
                pivots[failed - 1 :] = 0.0
            without = pivots <= smallest[first:last]
            if without.any():
                raise LinAlgError(int(order[first + without.argmax()]))
            if len(later):
                coupling = blas.dtrsm(
                    1.0, pivot, coupling, side=1, lower=1, trans_a=1, overwrite_b=1
                )
                update = blas.dsyrk(
                    -1.0, coupling, beta=1.0, c=contribution, lower=1, overwrite_c=1
                )
                waiting[front[later[0]]].append((later, update))
            if keep is not None:
                pivot, coupling = (np.asarray(part, keep, order="F") for part in (pivot, coupling))
                factors.append((order[first:last], order[later], pivot, coupling))
            bar.update(last - first)
    schur = np.tril(_assembled(upper, starts[-2], starts[-1], waiting[-1], place).pivot)
    return schur + np.tril(schur, -1).T, factors


def solve(factors: Sequence[Factor], F: Array) -> Array:
    """(unknowns, n) displacements under n loads F, by the factors of a complete elimination."""
    if not factors:
        return F.copy()
    u: Array = F.astype(factors[0][2].dtype)
    trsm = blas.get_blas_funcs("trsm", (u,))
    for unknowns, later, triangle, coupling in factors:
        if not u[unknowns].any():
            continue  # if loads act at few places, most fronts have no load
        u[unknowns] = trsm(1.0, triangle, u[unknowns], lower=1)
        u[later] -= coupling @ u[unknowns]
    for unknowns, later, triangle, coupling in reversed(factors):
        loads = u[unknowns] - coupling.T @ u[later]
        u[unknowns] = trsm(1.0, triangle, loads, lower=1, trans_a=1)
    return u


def _assembled(
    upper: csr_matrix, first: int, last: int, updates: list[_Update], place: Integers
) -> _Front:
    """The front of the unknowns from `first` to `last`, with the updates from earlier fronts.

    The updates are dropped once they are added. `place` (unknowns,) is work space.
    """
    size = last - first
    ends = upper.indptr[first : last + 1]
    row = upper.indices[ends[0] : ends[-1]]
    value = upper.data[ends[0] : ends[-1]]
    column = np.repeat(np.arange(size), np.diff(ends))
    connected = np.unique(np.concatenate([row, *(unknowns for unknowns, _ in updates)]))
    later = connected[np.searchsorted(connected, last) :]
    place[first:last] = np.arange(size)
    place[later] = np.arange(len(later))

    pivot = np.zeros((size, size), order="F")
    coupling = np.zeros((len(later), size), order="F")
    contribution = np.zeros((len(later), len(later)), order="F")
    inside = row < last
    pivot[place[row[inside]], column[inside]] = value[inside]
    coupling[place[row[~inside]], column[~inside]] = value[~inside]
    while updates:
        unknowns, update = updates.pop()
        index = place[unknowns]
        m = int(np.searchsorted(unknowns, last))
        pivot[np.ix_(index[:m], index[:m])] += update[:m, :m]
        coupling[np.ix_(index[m:], index[:m])] += update[m:, :m]
        contribution[np.ix_(index[m:], index[m:])] += update[m:, m:]
        del update  # frees its memory before the next one is added
    return _Front(later, pivot, coupling, contribution)
