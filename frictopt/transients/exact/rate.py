"""The rate problem at one load: which nodes at a bound slip, stick or open.

The problem is solved only if the iteration on the signs of the rates does not decide. Nodes
strictly inside their bound stick, and nodes with a gap stay open. A node at a bound has a
non-negative rate z of slip or gap and a non-negative rate `M z + c` of slack or pressure, and one
of the two is zero. If there are few such pairs, all statuses are tried; if there are many, Lemke's
method finds a solution. If M is positive definite, this solution is the only one.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, product
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dger

from ...base import CONDENSATION, RESIDUAL, ROUNDING, Array
from .kernel import AT_BOUND, OPEN, STICK, State

# The numbers of the search for solutions of a rate problem.

# Largest number of pairs for which all statuses are tried.
_TRIED_PAIRS = 8
# Number of covering vectors with which Lemke's method begins in turn.
_COVERS = 3
# Two solutions count as different if their difference, relative to their size, is larger than this:
# each has errors up to the residual.
_DISTINCT = 1e3 * RESIDUAL
# Pivots of Lemke's tableau up to this size count as zero: each pivot adds its rounding to the rest.
_ZERO_PIVOT = 10 * ROUNDING


@dataclass(frozen=True, eq=False)
class RateProblem:
    """`z >= 0, M z + c >= 0, z (M z + c) = 0` over the nodes at a bound, n pairs.

    `node` and `kind` (n,) are the node of each pair and the meaning of z > 0: +1 or -1 slip of that
    sense, 2 opening. `u_rate` (2N, n + 1) has rates of `[v, w]`: in column k for unit z_k, in the
    last column for z = 0. `free` are closed nodes without friction, whose slip rate is not
    restricted. `floating`: the open and the frictionless nodes can move without resistance.
    `sliding`: they can do so together with all nodes at a bound.
    """

    M: Array
    c: Array
    node: np.ndarray
    kind: np.ndarray
    u_rate: Array
    free: np.ndarray
    floating: bool
    sliding: bool

    @property
    def numbers(self) -> list[int]:
        """The nodes at a bound."""
        return sorted(set(self.node.tolist()))

    def statuses(self, z: Array, before: np.ndarray) -> np.ndarray:
        """(N,) statuses under a solution; nodes that are not at a bound keep their status."""
        status = before.copy()
        status[self.node] = STICK
        status[self.free] = 1
        moving = z > RESIDUAL * max(float(np.abs(z).max(initial=0.0)), np.finfo(float).tiny)
        # Opening comes last, because an open node may have a slip rate as well.
        for kind in (1, -1, OPEN):
            status[self.node[moving & (self.kind == kind)]] = kind
        return status


class Solutions(NamedTuple):
    """Solutions, each as statuses and rates of `[v, w]`; `complete`: proven to be all solutions."""

    found: list[tuple[np.ndarray, Array]]
    complete: bool


def rate_problem(S: Array, f: Array, load_rate: Array, state: State, force: Array) -> RateProblem:
    """Set up the rate problem of a state under a rate of the bonded reactions (2N,)."""
    nodes = len(f)
    q, p = np.split(state.r, 2)

    # Nodes at their bounds, by the same tolerances as `look`.
    small = AT_BOUND * (f * p + 1e-3 * force)
    unpressed = p <= AT_BOUND * 1e-3 * force
    touching = unpressed & (state.u[nodes:] + state.gap <= 0)
    gapped = (state.status == OPEN) & ~touching
    frictionless = (f == 0) & ~touching & ~gapped
    # (N, 3): whether a node may begin to slip along +x, to slip against +x, to open.
    may_move = np.column_stack([f * p + q <= small, f * p - q <= small, touching])
    node, column = np.nonzero(may_move & ~(gapped | frictionless)[:, None])
    kind = np.array([1, -1, OPEN])[column]
    opens = kind == OPEN

    # Motions `[v, w]` of the pairs, and motions that nothing restricts.
    motion = np.where(opens, nodes + node, node)
    sense = np.where(opens, 1, kind)
    gaps = np.flatnonzero(gapped)
    smooth = np.flatnonzero(frictionless)
    free = np.r_[gaps, nodes + gaps, smooth]

    # Rates for unit z_k, and for z = 0 in the last column. The free motions follow.
    u_rate = np.zeros((2 * nodes, len(node) + 1))
    u_rate[motion, np.arange(len(node))] = sense
    r_rate = np.column_stack([S[:, motion] * sense, load_rate])
    if len(free):
        u_rate[free] = -np.linalg.lstsq(S[np.ix_(free, free)], r_rate[free])[0]
        r_rate += S[:, free] @ u_rate[free]

    # Rates of the slack `f p + sense q` of a slip, and of the pressure of an opening.
    of_shear = np.where(opens, 0, kind)
    of_pressure = np.where(opens, 1.0, f[node])
    slack = of_shear[:, None] * r_rate[node] + of_pressure[:, None] * r_rate[nodes + node]
    return RateProblem(
        M=slack[:, :-1],
        c=slack[:, -1],
        node=node,
        kind=kind.astype(np.int8),
        u_rate=u_rate,
        free=smooth,
        floating=_has_free_motion(S, free),
        sliding=_has_free_motion(S, np.union1d(free, motion)),
    )


def _has_free_motion(S: Array, motions: np.ndarray) -> bool:
    """Whether these motions can take place without resistance."""
    block = S[np.ix_(motions, motions)]
    least = CONDENSATION * float(np.abs(S).max())
    return not _is_positive_definite(block - least * np.eye(len(block)))


def find_rates(problem: RateProblem, before: np.ndarray) -> Solutions:
    """Find at most two different solutions of a rate problem."""
    stiffness = float(np.abs(np.diag(problem.M)).max(initial=0.0)) or 1.0
    load = float(np.abs(problem.c).max(initial=0.0)) or 1.0
    M = problem.M / stiffness
    c = problem.c / load

    if len(c) <= _TRIED_PAIRS:
        candidates = _all_solutions(M, c)
        complete = True
    else:
        unique = _is_positive_definite(M)
        candidates = list(islice(_pivoted(M, c), 1 if unique else None))
        complete = unique and bool(candidates)

    found: list[tuple[np.ndarray, Array]] = []
    for z in candidates:
        rates = problem.u_rate @ np.r_[z * load / stiffness, 1.0]
        size = max(float(np.abs(rates).max()), load / stiffness)
        if all(np.abs(rates - known).max() > _DISTINCT * size for _, known in found):
            found.append((problem.statuses(z, before), rates))
    return Solutions(found[:2], complete)


def _all_solutions(M: Array, c: Array) -> list[Array]:
    """All solutions, by trying every choice of positive z."""
    solutions = []
    for moving in product((False, True), repeat=len(c)):
        chosen = np.flatnonzero(moving)
        z = np.zeros(len(c))
        if len(chosen):
            z[chosen] = np.linalg.lstsq(M[np.ix_(chosen, chosen)], -c[chosen])[0]
        if _solves(M, c, z):
            solutions.append(z)
    return solutions


def _pivoted(M: Array, c: Array) -> Iterator[Array]:
    """Solutions by Lemke's method, which may differ from one covering vector to the next."""
    shape = _COVERS - 1, len(c)
    random = np.random.default_rng(0).uniform(0.2, 1.0, size=shape)
    for cover in (np.ones(len(c)), *random):
        z = _lemke(M, c, cover)
        if z is not None and _solves(M, c, z):
            yield z


def _solves(M: Array, c: Array, z: Array) -> bool:
    slack = M @ z + c
    tolerance = RESIDUAL * (1.0 + float(np.abs(z).max(initial=0.0)))
    lowest = min(z.min(initial=0.0), slack.min(initial=0.0))
    largest_product = np.abs(z * slack).max(initial=0.0)
    return bool(lowest > -tolerance and largest_product <= tolerance)


def _is_positive_definite(M: Array) -> bool:
    return bool(np.linalg.eigvalsh(M + M.T).min(initial=np.inf) > 0)


def _lemke(M: Array, c: Array, cover: Array) -> Array | None:
    """Solution by complementary pivoting (Lemke 1965); None if it ends in a ray."""
    n = len(c)
    if c.min(initial=0.0) >= 0:
        return np.zeros(n)
    # Columns: n slacks, n of z, the artificial unknown, and the right-hand side.
    tableau = np.asfortranarray(np.column_stack([np.eye(n), -M, -cover, c]))
    artificial = 2 * n
    basis = np.arange(n)
    row = int(np.argmin(c / cover))
    entering = artificial
    for _ in range(50 * (n + 1)):
        tableau[row] /= tableau[row, entering]
        factors = tableau[:, entering].copy()
        factors[row] = 0.0
        tableau = dger(-1.0, factors, tableau[row], a=tableau, overwrite_a=1)
        leaving = basis[row]
        basis[row] = entering
        if leaving == artificial:
            z = np.zeros(2 * n + 1)
            z[basis] = tableau[:, -1]
            return z[n : 2 * n]
        # The unknown that enters is the complement of the unknown that leaves.
        entering = leaving + n if leaving < n else leaving - n
        positive = np.flatnonzero(tableau[:, entering] > _ZERO_PIVOT)
        if not len(positive):
            return None
        row = _pivot_row(tableau, basis, positive, entering)
    return None


def _pivot_row(tableau: Array, basis: np.ndarray, positive: np.ndarray, entering: int) -> int:
    """The row of the least ratio.

    Among rows of equal ratio, the row of the artificial unknown is taken, or else the
    lexicographically least row.

    `positive` are the rows with a positive entry in the column that enters.
    """
    n = len(basis)
    ratios = tableau[positive, -1] / tableau[positive, entering]
    nearly_least = positive[ratios <= ratios.min() + ROUNDING]
    artificial = nearly_least[basis[nearly_least] == 2 * n]
    if len(artificial):
        return int(artificial[0])
    least = positive[ratios == ratios.min()]
    scaled = tableau[least, :n] / tableau[least, entering][:, None]
    # `lexsort` takes the last key first.
    return int(least[np.lexsort(scaled.T[::-1])[0]])
