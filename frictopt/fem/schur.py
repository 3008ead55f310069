"""Elimination of all but the last unknowns of a sparse stiffness, front after front, and the fronts, by nested dissection on coordinates."""

from collections.abc import Sequence
from itertools import count, pairwise
from typing import TypeAlias

import numpy as np
from scipy.linalg import LinAlgError, blas, lapack
from scipy.sparse import csr_matrix, triu

from ..base import ROUNDING, Array, Integers, bar_of

_LEAF = 64  # parts of at most this many nodes are not cut further
_FAR, _NEAR, _SEPARATOR = 0, 1, 2  # sides of a cut
_NO_STIFFNESS = (
    ROUNDING / 10
    # stiffness of an unknown, over its own, up to which nothing is left of it when others are
    # eliminated
)
_COLUMNS = 128  # of what an elimination leaves: so many are added to the next front at once

Factor: TypeAlias = tuple[Integers, Integers, Array, Array]
"""The unknowns of a front, the later ones that they are joined to, the triangular factor of its block, and the rows of the later ones."""


def nested_dissection(graph: csr_matrix, points: Array) -> Integers:
    """Divide the nodes of a mesh into fronts, so that the elimination of one front after the other makes little fill (George 1973).

    Every part is cut in two at the median of one coordinate, the one whose cut crosses fewest
    edges; the nodes on the near side of a crossed edge separate the halves and are a front,
    eliminated after both. Parts that are not cut further are fronts.

    The (n, n) pattern of the graph is the adjacency of the nodes, the points are (d, n). Returned
    are the (n,) fronts in the order of elimination.
    """
    pattern, front, side = (
        graph.tocoo(),
        np.zeros(graph.shape[0], dtype=np.intp),
        np.zeros(graph.shape[0], dtype=np.int8),
    )
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


def eliminate(K: csr_matrix, front: Integers, *, keep: bool = False) -> tuple[Array, list[Factor]]:
    """Multifrontal Cholesky factorisation of all but the last unknowns of a sparse matrix (Duff & Reid 1983).

    A front is a dense matrix: some unknowns that are eliminated together, and the later ones that
    they are joined to. What the elimination leaves to these waits for the front of the first of
    them; fronts that are done are dropped. In the end the kept unknowns are left.

    `front` (unknowns,) is the number of the front that eliminates each, from 0 on; -1: kept.
    Returned are the (kept, kept) Schur complement `K_rr - K_ri K_ii^-1 K_ir`, in the order of K,
    and, with `keep`, the factors for `solve`. Raises LinAlgError, with the unknown at which that
    shows, where the eliminated part is not positive definite.
    """
    fronts = int(front.max(initial=-1)) + 1
    front = np.where(front < 0, fronts, front)
    order = np.argsort(front, kind="stable")
    upper = triu(K[order][:, order], format="csr")
    front, least = front[order], _NO_STIFFNESS * np.abs(K.diagonal()[order])
    starts = np.r_[np.searchsorted(front, np.arange(fronts + 1)), len(order)]
    place = np.zeros(len(order), dtype=np.intp)
    waiting: list[list[tuple[Integers, Array]]] = [[] for _ in range(fronts + 1)]
    factors: list[Factor] = []
    with bar_of(True, "elimination", "unknown", total=int(starts[-2])) as bar:
        for k, (first, last) in enumerate(pairwise(starts[:-1])):
            rest, own, below, after = _assembled(upper, first, last, waiting[k], place)
            own, failed = lapack.dpotrf(own, lower=1, overwrite_a=1)
            pivots = np.diag(own) ** 2
            pivots[failed - 1 if failed else len(pivots) :] = 0.0
            if (none := pivots <= least[first:last]).any():
                raise LinAlgError(int(order[first + none.argmax()]))
            if len(rest):
                below = blas.dtrsm(1.0, own, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                waiting[front[rest[0]]].append(
                    (rest, blas.dsyrk(-1.0, below, beta=1.0, c=after, lower=1, overwrite_c=1))
                )
            if keep:
                factors.append((order[first:last], order[rest], own, below))
            bar.update(last - first)
    left = np.tril(_assembled(upper, starts[-2], starts[-1], waiting[-1], place)[1])
    return left + np.tril(left, -1).T, factors


def solve(factors: Sequence[Factor], F: Array) -> Array:
    """(unknowns,) values under the loads F (unknowns,), by the factors of an elimination that kept no unknown."""
    u = F.copy()
    for own, rest, factor, below in factors:
        u[own] = blas.dtrsv(factor, u[own], lower=1)
        u[rest] -= below @ u[own]
    for own, rest, factor, below in reversed(factors):
        u[own] = blas.dtrsv(factor, u[own] - u[rest] @ below, lower=1, trans=1)
    return u


def _assembled(
    upper: csr_matrix, first: int, last: int, left: list[tuple[Integers, Array]], place: Integers
) -> tuple[Integers, Array, Array, Array]:
    """The later unknowns of a front, and its blocks: own, later by own, later by later; of symmetric ones the lower triangle.

    What fronts before left to it, unknowns and matrix, is dropped once it is added; `place`
    (unknowns,) is written anew.
    """
    size, ends = last - first, upper.indptr[first : last + 1]
    row, value, column = (
        upper.indices[ends[0] : ends[-1]],
        upper.data[ends[0] : ends[-1]],
        np.repeat(np.arange(size), np.diff(ends)),
    )
    rest = np.unique(np.concatenate([row, *(unknowns for unknowns, _ in left)]))
    rest = rest[np.searchsorted(rest, last) :]
    place[first:last], place[rest] = np.arange(size), np.arange(len(rest))
    own, below, after = (
        np.zeros(shape, order="F")
        for shape in ((size, size), (len(rest), size), (len(rest), len(rest)))
    )
    inside = row < last
    own[place[row[inside]], column[inside]] = value[inside]
    below[place[row[~inside]], column[~inside]] = value[~inside]
    while left:
        unknowns, update = left.pop()
        to, m = place[unknowns], int(np.searchsorted(unknowns, last))
        _add(own, update[:m, :m], to[:m], to[:m], lower=True)
        _add(below, update[m:, :m], to[m:], to[:m])
        _add(after, update[m:, m:], to[m:], to[m:], lower=True)
        del update
    return rest, own, below, after


def _add(
    A: Array, update: Array, rows: Integers, columns: Integers, *, lower: bool = False
) -> None:
    """Add a matrix to rows and columns of A, all in increasing order; where `lower`, at least the lower triangle."""
    entries = A.reshape(-1, order="F")
    for i in range(0, len(columns), _COLUMNS):
        some, part = slice(i, i + _COLUMNS), slice(i if lower else 0, None)
        np.add.at(
            entries,
            (columns[some, None] * len(A) + rows[part]).ravel(),
            update.T[some, part].ravel(),
        )
