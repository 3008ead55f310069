"""A proof that the rates of a path are the only ones, and of a mirror-symmetric contact so mirror-symmetric as well (compiled).

Let two sets of rates obey the law, with differences dv, dw, dq, dp. A node that slips or sticks at one bound has `dv dq <= -sense f dv dp`, an open
one dq = dp = 0, all others dv = dw = 0. So the sum of `dv (dq + sense f dp)` over the former is not positive, and there is no difference if the
quadratic form of these rows of the stiffness is positive definite. With a symmetry it splits into a form of the motions that keep it and one of
those that leave it. A form that is positive definite for some nodes is so for fewer: the factors (Cholesky) grow as nodes begin to slip, and serve on
when they stop.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .active import OPEN, STICK
from .settle import at_bound

__all__ = ["Proof", "clear_proof", "new_proof", "prove"]

_DEFINITE = 1e-10  # pivots below this share of the stiffness of the unknown alone prove nothing


class Proof(NamedTuple):
    """Factors of the quadratic forms of a contact, or of one half, for n unknowns.

    Attributes
    ----------
    size
        (1,) n.
    unknown, weight
        (2N,) of which the first n count: index of each unknown in `[v, w]`, and the factor `sense f` of dp in its row.
    place
        (2N,) position of each index of `[v, w]` among the unknowns, -1 if it is none.
    factors
        (2, 2N, 2N) Cholesky factors, of motions that keep the symmetry and of those that leave it, or of the whole alone (1, 2N, 2N); the leading
        (n, n) count.
    """

    size: np.ndarray
    unknown: np.ndarray
    weight: np.ndarray
    place: np.ndarray
    factors: np.ndarray


def new_proof(nodes: int, forms: int) -> Proof:
    """An empty proof for that many nodes: 1 form for a whole contact, 2 for a half."""
    whole = 2 * nodes
    index = np.zeros(whole, dtype=np.int64)
    return Proof(np.zeros(1, dtype=np.int64), index, np.zeros(whole), index - 1, np.zeros((forms, whole, whole)))


@njit(cache=True)
def clear_proof(proof):
    """Forget all unknowns."""
    for a in range(proof.size[0]):
        proof.place[proof.unknown[a]] = -1
    proof.size[0] = 0


@njit(cache=True)
def _entry(S, one, weight, other, other_weight):
    """Entry of the symmetric part of the rows `q + weight p`."""
    nodes = S.shape[0] // 2
    entry = S[one, other]
    if weight != 0.0:
        entry += 0.5 * weight * S[nodes + one, other]
    if other_weight != 0.0:
        entry += 0.5 * other_weight * S[nodes + other, one]
    return entry


@njit(cache=True)
def _border(S, proof, L, new, weight):
    """Add the row of an unknown to one of the factors; returns whether it stays positive definite."""
    n = proof.size[0]
    square = 0.0
    for a in range(n):
        entry = _entry(S, new, weight, proof.unknown[a], proof.weight[a])
        for b in range(a):
            entry -= L[n, b] * L[a, b]
        L[n, a] = entry / L[a, a]
        square += L[n, a] ** 2
    alone = _entry(S, new, weight, new, weight)
    if not alone - square > _DEFINITE * S[new, new]:
        return False
    L[n, n] = np.sqrt(alone - square)
    return True


@njit(cache=True)
def _need(S, other, proof, unknown, weight):
    """Make an unknown part of the proof; returns whether it is, with this weight."""
    place = proof.place[unknown]
    if place >= 0:
        return proof.weight[place] == weight
    if not _border(S, proof, proof.factors[0], unknown, weight):
        return False
    if len(other) > 0 and not _border(other, proof, proof.factors[1], unknown, weight):
        return False
    n = proof.size[0]
    proof.unknown[n], proof.weight[n], proof.place[unknown] = unknown, weight, n
    proof.size[0] = n + 1
    return True


@njit(cache=True)
def _need_all(S, other, f, state, force, proof):
    nodes = len(f)
    for node in range(nodes):
        status = state.status[node]
        forward, backward, vertex = at_bound(f, state, node, force)
        if vertex:  # closed without pressure: it may slip either way or open, which no quadratic form decides
            return False
        if status == OPEN:
            if not (_need(S, other, proof, node, 0.0) and _need(S, other, proof, nodes + node, 0.0)):
                return False
        elif status != STICK or forward or backward:
            if forward and backward and f[node] > 0.0:
                return False
            sense = status if status != STICK else (1 if forward else -1)
            if not _need(S, other, proof, node, sense * f[node]):
                return False
    return True


@njit(cache=True)
def prove(S, other, f, state, force, proof):
    """Whether the rates at a state, of the whole contact or of a half, are proven to be the only ones of the whole.

    Parameters
    ----------
    S, other
        (2N, 2N) stiffness, and of a half its stiffness against the motions that leave the symmetry; (0, 0) for the whole.
    f, state, force
        (N,) friction, the state and the scale of the nodal forces.
    proof
        What is proven so far; added to in place.
    """
    if _need_all(S, other, f, state, force, proof):
        return True
    clear_proof(proof)  # what it holds from earlier states may be too much
    return _need_all(S, other, f, state, force, proof)
