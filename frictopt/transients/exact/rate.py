"""The rate problem at one load: which nodes at a bound slip, stick or open, where the iteration on the signs of the rates does not decide.

Nodes strictly inside their bound stick, and nodes with a gap stay open. A node at a bound has a
non-negative rate z of slip or gap and a non-negative rate `M z + c` of slack or pressure, and one
of the two is zero. Few such pairs are solved by trying all statuses, more by Lemke's method. What
that finds is known to be the only solution where M is positive definite.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, product
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dger

from ...base import CONDENSATION, RESIDUAL, ROUNDING, Array
from .kernel import AT_BOUND, OPEN, STICK, State

_PIVOT = (
    10 * ROUNDING
    # pivots of Lemke's tableau up to this count as zero: a pivot adds its rounding to that of the
    # entries
)
_DISTINCT = (
    1e3 * RESIDUAL
)  # two solutions of a rate problem differ by more: each has errors up to the residual
_TRIED = 8  # number of pairs up to which all statuses are tried
_STARTS = 3  # covering vectors tried by Lemke's method


@dataclass(frozen=True, eq=False)
class RateProblem:
    """`z >= 0, M z + c >= 0, z (M z + c) = 0` over the nodes at a bound, n pairs.

    `node` and `kind` (n,) are the node of each pair and the meaning of z > 0: +1 or -1 slip of that
    sense, 2 opening. `u_rate` (2N, n + 1) has rates of `[v, w]`: in column k for unit z_k, in the
    last column for z = 0. `free` are closed nodes without friction, whose slip rate is not
    restricted. `floating`: the open and the frictionless nodes can move without resistance;
    `sliding`: they can if all nodes at a bound move too.
    """

    M: Array
    c: Array
    node: np.ndarray
    kind: np.ndarray
    u_rate: Array
    free: np.ndarray
    floating: bool
    sliding: bool

    def statuses(self, z: Array, before: np.ndarray) -> np.ndarray:
        """(N,) statuses of the nodes under a solution; nodes that are not at a bound keep theirs."""
        status = before.copy()
        status[self.node] = STICK
        status[self.free] = 1
        moving = z > RESIDUAL * max(float(np.abs(z).max(initial=0.0)), np.finfo(float).tiny)
        for kind in (1, -1, OPEN):  # an open node may have a slip rate as well
            status[self.node[moving & (self.kind == kind)]] = kind
        return status


class Solutions(NamedTuple):
    """Solutions found, each as statuses and rates of `[v, w]`, and whether it is proven that there are no others."""

    found: list[tuple[np.ndarray, Array]]
    complete: bool


def rate_problem(S: Array, f: Array, load_rate: Array, state: State, force: Array) -> RateProblem:
    """Set up the rate problem for the nodes of a state that are at a bound, under a rate of the bonded reactions."""
    nodes, q, p = len(f), *np.split(state.r, 2)
    small, bare = AT_BOUND * (f * p + 1e-3 * force), p <= AT_BOUND * 1e-3 * force
    vertex = bare & (state.u[nodes:] + state.gap <= 0)
    gone = (state.status == OPEN) & ~vertex
    smooth = (f == 0) & ~vertex & ~gone
    node, way = np.nonzero(
        np.column_stack([f * p + q <= small, f * p - q <= small, vertex])
        & ~(gone | smooth)[:, None]
    )
    kind, apart, frictionless = (
        np.array([1, -1, OPEN])[way],
        np.flatnonzero(gone),
        np.flatnonzero(smooth),
    )
    opens, free = (
        kind == OPEN,
        np.r_[apart, nodes + apart, frictionless],
    )  # motions that nothing bounds
    motion, sense = np.where(opens, nodes + node, node), np.where(opens, 1, kind)
    least = CONDENSATION * float(np.abs(S).max())
    parts = (
        S[np.ix_(part, part)] - least * np.eye(len(part))
        for part in (free, np.union1d(free, motion))
    )
    floating, sliding = (not _is_positive_definite(part) for part in parts)
    u_rate, r_rate = (
        np.zeros((2 * nodes, len(node) + 1)),
        np.column_stack([S[:, motion] * sense, load_rate]),
    )
    u_rate[motion, np.arange(len(node))] = sense
    if len(free):
        u_rate[free] = -np.linalg.lstsq(S[np.ix_(free, free)], r_rate[free])[0]
        r_rate += S[:, free] @ u_rate[free]
    slack = (
        np.where(opens, 0, kind)[:, None] * r_rate[node]
        + np.where(opens, 1.0, f[node])[:, None] * r_rate[nodes + node]
    )
    return RateProblem(
        slack[:, :-1],
        slack[:, -1],
        node,
        kind.astype(np.int8),
        u_rate,
        frictionless,
        floating,
        sliding,
    )


def find_rates(problem: RateProblem, before: np.ndarray) -> Solutions:
    """Find at most two different solutions of a rate problem."""
    stiffness, scale = (
        float(np.abs(values).max(initial=0.0)) or 1.0 for values in (np.diag(problem.M), problem.c)
    )
    M, c = problem.M / stiffness, problem.c / scale
    few = len(c) <= _TRIED
    unique = not few and _is_positive_definite(M)
    candidates = _all_statuses(M, c) if few else list(islice(_pivoted(M, c), 1 if unique else None))
    found: list[tuple[np.ndarray, Array]] = []
    for z in candidates:
        rates = problem.u_rate @ np.r_[z * scale / stiffness, 1.0]
        size = max(float(np.abs(rates).max()), scale / stiffness)
        if all(np.abs(rates - other).max() > _DISTINCT * size for _, other in found):
            found.append((problem.statuses(z, before), rates))
    return Solutions(found[:2], few or (unique and bool(candidates)))


def _pivoted(M: Array, c: Array) -> Iterator[Array]:
    """Solutions by Lemke's method from several covering vectors: from another one it may end elsewhere."""
    for cover in (
        np.ones(len(c)),
        *np.random.default_rng(0).uniform(0.2, 1.0, size=(_STARTS - 1, len(c))),
    ):
        z = _lemke(M, c, cover)
        if z is not None and _solves(M, c, z):
            yield z


def _solves(M: Array, c: Array, z: Array) -> bool:
    slack = M @ z + c
    size = 1.0 + float(np.abs(z).max(initial=0.0))
    return bool(
        min(z.min(initial=0.0), slack.min(initial=0.0)) > -RESIDUAL * size
        and np.abs(z * slack).max(initial=0.0) <= RESIDUAL * size
    )


def _all_statuses(M: Array, c: Array) -> list[Array]:
    """All solutions, by trying every choice of positive z."""
    found = []
    for moving in product((False, True), repeat=len(c)):
        z, chosen = np.zeros(len(c)), np.flatnonzero(moving)
        if len(chosen):
            z[chosen] = np.linalg.lstsq(M[np.ix_(chosen, chosen)], -c[chosen])[0]
        found += [z] if _solves(M, c, z) else []
    return found


def _is_positive_definite(M: Array) -> bool:
    return bool(np.linalg.eigvalsh(M + M.T).min(initial=np.inf) > 0)


def _lemke(M: Array, c: Array, cover: Array) -> Array | None:
    """Solution by complementary pivoting (Lemke 1965) with a lexicographic ratio test; None if it ends in a ray."""
    n = len(c)
    if c.min(initial=0.0) >= 0:
        return np.zeros(n)
    tableau = np.asfortranarray(
        np.column_stack([np.eye(n), -M, -cover, c])
    )  # columns: slacks, z, artificial, right-hand side
    basis = np.arange(n)
    row = int(np.argmin(c / cover))
    entering = 2 * n
    for _ in range(50 * (n + 1)):
        tableau[row] /= tableau[row, entering]
        others = tableau[:, entering].copy()
        others[row] = 0.0
        tableau = dger(-1.0, others, tableau[row], a=tableau, overwrite_a=1)
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * n:
            z = np.zeros(2 * n + 1)
            z[basis] = tableau[:, -1]
            return z[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
        positive = np.flatnonzero(tableau[:, entering] > _PIVOT)
        if not len(positive):
            return None
        ratios = tableau[positive, -1] / tableau[positive, entering]
        artificial = [i for i in positive[ratios <= ratios.min() + ROUNDING] if basis[i] == 2 * n]
        least = positive[ratios == ratios.min()]
        order = np.lexsort((tableau[least, :n] / tableau[least, entering][:, None]).T[::-1])
        row = int(artificial[0]) if artificial else int(least[order[0]])
    return None
