"""The active set of the rate problem: slipping and open nodes, with the inverse of their stiffness kept up to date (compiled).

A node that slips has one unknown, the rate of its slip, and one equation, `q' + sense f p' = 0` (sense +1 along +x). An open node has two, the
rates of slip and gap, and two equations, `q' = 0` and `p' = 0`. As nodes change status, rows and columns are added to the inverse and taken off
it at a cost of n^2 instead of the n^3 of a new factorisation: these few functions take most of the time of a path.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

__all__ = [
    "OPEN",
    "SLIP_BACKWARD",
    "SLIP_FORWARD",
    "STICK",
    "ActiveSet",
    "activate",
    "clear",
    "deactivate",
    "new_active_set",
    "pivot_share",
    "solve_rates",
]

STICK, SLIP_FORWARD, SLIP_BACKWARD, OPEN = 0, 1, -1, 2

_SINGULAR = 1e-10  # pivots below this share of the stiffness of the unknown alone mean that no unique rates exist


class ActiveSet(NamedTuple):
    """Unknowns of the rate problem, n of them, and the inverse of their stiffness.

    Attributes
    ----------
    size
        (1,) n.
    unknown
        (2N,) of which the first n count: index of each unknown in `[v, w]`.
    weight
        (2N,) factor of p' in the equation of each unknown: `sense * f` of a slipping node, 0 for the unknowns of an open one.
    place
        (2N,) position of each index of `[v, w]` among the unknowns, -1 if it is none.
    inverse
        (2N, 2N) of which the leading (n, n) counts.
    """

    size: np.ndarray
    unknown: np.ndarray
    weight: np.ndarray
    place: np.ndarray
    inverse: np.ndarray


def new_active_set(nodes: int) -> ActiveSet:
    """An empty active set."""
    whole = 2 * nodes
    return ActiveSet(
        np.zeros(1, dtype=np.int64), np.zeros(whole, dtype=np.int64), np.zeros(whole), np.full(whole, -1, dtype=np.int64), np.zeros((whole, whole))
    )


@njit(cache=True)
def _equation(S, row, factor, column):
    """Entry of the stiffness: the equation of unknown `row` with its factor, at unknown `column`."""
    nodes = S.shape[0] // 2
    return S[row, column] + (factor * S[nodes + row, column] if factor != 0.0 else 0.0)


@njit(cache=True)
def _border(S, active, new, factor, left, right):
    """Row and column that a new unknown adds, times the inverse; returns its pivot."""
    n = active.size[0]
    inverse = active.inverse
    for a in range(n):
        left[a] = 0.0
        right[a] = 0.0
    for a in range(n):
        entry = _equation(S, new, factor, active.unknown[a])
        for b in range(n):
            left[b] += entry * inverse[a, b]
    pivot = _equation(S, new, factor, new)
    for a in range(n):
        total = 0.0
        for b in range(n):
            total += inverse[a, b] * _equation(S, active.unknown[b], active.weight[b], new)
        right[a] = total
    for a in range(n):
        pivot -= left[a] * _equation(S, active.unknown[a], active.weight[a], new)
    return pivot


@njit(cache=True)
def _append(S, active, new, factor):
    n = active.size[0]
    left, right = np.empty(n), np.empty(n)
    pivot = _border(S, active, new, factor, left, right)
    share = pivot / S[new, new] if S[new, new] > 0.0 else 0.0
    if abs(share) <= _SINGULAR:
        return 0.0
    inverse = active.inverse
    for a in range(n):
        scaled = right[a] / pivot
        for b in range(n):
            inverse[a, b] += scaled * left[b]
        inverse[a, n] = -scaled
        inverse[n, a] = -left[a] / pivot
    inverse[n, n] = 1.0 / pivot
    active.unknown[n], active.weight[n], active.place[new] = new, factor, n
    active.size[0] = n + 1
    return share


@njit(cache=True)
def _remove(active, old):
    """Take one unknown off; its pivot is the reciprocal of its entry in the inverse."""
    last = active.size[0] - 1
    inverse, place = active.inverse, active.place[old]
    if place != last:
        for a in range(last + 1):
            inverse[place, a], inverse[last, a] = inverse[last, a], inverse[place, a]
        for a in range(last + 1):
            inverse[a, place], inverse[a, last] = inverse[a, last], inverse[a, place]
        moved = active.unknown[last]
        active.unknown[place], active.weight[place], active.place[moved] = moved, active.weight[last], place
    corner = inverse[last, last]
    for a in range(last):
        scaled = inverse[a, last] / corner
        for b in range(last):
            inverse[a, b] -= scaled * inverse[last, b]
    active.place[old] = -1
    active.size[0] = last


@njit(cache=True)
def clear(active):
    """Make every node stick."""
    for a in range(active.size[0]):
        active.place[active.unknown[a]] = -1
    active.size[0] = 0


@njit(cache=True)
def activate(S, f, active, node, status):
    """Let a sticking node slip or open.

    Returns the smallest pivot in units of the stiffness of the unknown alone; 0 if the rates are not unique, and then the node still sticks.
    """
    nodes = S.shape[0] // 2
    if status != OPEN:
        return _append(S, active, node, status * f[node])
    first = _append(S, active, nodes + node, 0.0)
    if first == 0.0:
        return 0.0
    second = _append(S, active, node, 0.0)
    if second == 0.0:
        _remove(active, nodes + node)
        return 0.0
    return min(first, second)


@njit(cache=True)
def deactivate(active, node):
    """Make a slipping or open node stick."""
    nodes = len(active.unknown) // 2
    _remove(active, node)
    if active.place[nodes + node] >= 0:
        _remove(active, nodes + node)


@njit(cache=True)
def pivot_share(S, f, active, node, status):
    """Pivot that a sticking node would bring if it slipped, in units of its own stiffness; not positive: slip and stick may both be possible."""
    n = active.size[0]
    left, right = np.empty(n), np.empty(n)
    return _border(S, active, node, status * f[node], left, right) / S[node, node] if S[node, node] > 0.0 else 0.0


@njit(cache=True)
def solve_rates(S, active, drive, u_rate, r_rate):
    """Rates of `[v, w]` and `[q, p]` under the rate of the bonded reactions `drive`, written into `u_rate` and `r_rate`."""
    n, nodes = active.size[0], S.shape[0] // 2
    right = np.empty(n)
    for a in range(n):
        unknown = active.unknown[a]
        right[a] = drive[unknown] + (active.weight[a] * drive[nodes + unknown] if active.weight[a] != 0.0 else 0.0)
    u_rate[:] = 0.0
    r_rate[:] = drive
    for a in range(n):
        total = 0.0
        for b in range(n):
            total -= active.inverse[a, b] * right[b]
        unknown = active.unknown[a]
        u_rate[unknown] = total
        for k in range(2 * nodes):
            r_rate[k] += total * S[unknown, k]
