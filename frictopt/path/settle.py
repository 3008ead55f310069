"""The statuses of the nodes of a path, and how they are made to agree with the rates (compiled)."""

from typing import NamedTuple

import numpy as np
from numba import njit

from .active import OPEN, STICK, activate, clear, deactivate, pivot_share, solve_rates

__all__ = ["AT_BOUND", "SETTLED", "TWOFOLD", "UNSETTLED", "State", "at_bound", "impose", "refresh", "settle", "slacks", "turn"]

SETTLED, UNSETTLED, TWOFOLD = 0, 1, 2
"""How `settle` ends: with rates that agree with the statuses; without; with rates that may not be the only ones."""

AT_BOUND = 1e-11
"""Slack of a node, over its friction bound and a thousandth of the force scale, that counts as none."""

_RATE = 1e-11  # rates of slack and slip below this share of the drive count as none
_BLOCK = 12  # iterations that change all wrong nodes at once; later ones change only the first wrong node (Murty 1974)
_SINGLE = 200


class State(NamedTuple):
    """Where a path is. All arrays are changed in place.

    Attributes
    ----------
    u, r
        (2N,) slip and gap over initial gap `[v, w - g0]`, reactions `[q, p]`.
    gap
        (N,) initial gap.
    status
        (N,) 0 stick, +1 and -1 slip, 2 open.
    work
        (N,) work of friction so far.
    trace
        (3,) number of events, hash of the statuses at the events, number of events whose rates are not proven to be the only ones.
    """

    u: np.ndarray
    r: np.ndarray
    gap: np.ndarray
    status: np.ndarray
    work: np.ndarray
    trace: np.ndarray


@njit(cache=True)
def slacks(f, r, node, nodes):
    """Distances of a node from forward and from backward slip."""
    bound = f[node] * r[nodes + node]
    return bound + r[node], bound - r[node]


@njit(cache=True)
def at_bound(f, state, node, force):
    """Whether a node is at its bound against forward slip, against backward slip, and without both pressure and gap."""
    nodes = len(f)
    p, gap = state.r[nodes + node], state.u[nodes + node] + state.gap[node]
    forward, backward = slacks(f, state.r, node, nodes)
    small = AT_BOUND * (f[node] * p + 1e-3 * force)
    return forward <= small, backward <= small, p <= AT_BOUND * 1e-3 * force and gap <= 0.0


@njit(cache=True)
def _wanted(f, state, u_rate, r_rate, node, force, least_r, least_u):
    """Status that a node's rates ask for; its own if they agree with it."""
    nodes = len(f)
    status = state.status[node]
    p, p_rate = state.r[nodes + node], r_rate[nodes + node]
    if status == OPEN:
        touching = state.u[nodes + node] + state.gap[node] <= 0.0
        return STICK if touching and u_rate[nodes + node] < -least_u else OPEN
    if p <= AT_BOUND * 1e-3 * force and p_rate < -least_r:
        return OPEN
    if status != STICK:
        return STICK if f[node] > 0.0 and status * u_rate[node] < -least_u else status
    forward, backward, _ = at_bound(f, state, node, force)
    if forward and f[node] * p_rate + r_rate[node] < -least_r:
        return 1
    if backward and f[node] * p_rate - r_rate[node] < -least_r:
        return -1
    return STICK


@njit(cache=True)
def _change(S, f, state, active, node, wanted):
    """Give a node another status; returns its pivot share (1 where it comes to stick, 0 where it cannot slip or open and sticks)."""
    if state.status[node] != STICK:
        deactivate(active, node)
    share = activate(S, f, active, node, wanted) if wanted != STICK else 1.0
    state.status[node] = wanted if share != 0.0 else STICK
    return share


@njit(cache=True)
def settle(S, f, drive, state, active, force, u_rate, r_rate):
    """Iterate on the signs of the rates until the statuses of all nodes at a bound agree with them."""
    nodes = len(f)
    largest = np.abs(drive).max()
    least_r = _RATE * largest
    least_u = least_r / (np.trace(S) / (2 * nodes))
    wanted = np.empty(nodes, dtype=np.int8)
    twofold = False
    for iteration in range(_BLOCK + _SINGLE):
        solve_rates(S, active, drive, u_rate, r_rate)
        wrong = 0
        for node in range(nodes):
            wanted[node] = _wanted(f, state, u_rate, r_rate, node, force, least_r, least_u)
            if wanted[node] != state.status[node]:
                wrong += 1
                if iteration >= _BLOCK and wrong > 1:
                    wanted[node] = state.status[node]
        if wrong == 0:
            return TWOFOLD if twofold or _may_be_twofold(S, f, state, active, force) else SETTLED
        for leaving in (True, False):  # first those that come to stick, so that the others meet a smaller set
            for node in range(nodes):
                if wanted[node] != state.status[node] and (wanted[node] == STICK) == leaving:
                    share = _change(S, f, state, active, node, wanted[node])
                    if share == 0.0:
                        return UNSETTLED
                    twofold = twofold or share < 0.0
    return UNSETTLED


@njit(cache=True)
def _may_be_twofold(S, f, state, active, force):
    """Whether a sticking node at its bound could slip as well: a pivot that is not positive."""
    for node in range(len(f)):
        if state.status[node] == STICK:
            forward, backward, _ = at_bound(f, state, node, force)
            if forward and pivot_share(S, f, active, node, 1) <= 0.0:
                return True
            if backward and pivot_share(S, f, active, node, -1) <= 0.0:
                return True
    return False


@njit(cache=True)
def turn(S, f, state, active):
    """At a load corner: let all slipping nodes stick, for the new direction to say which slip; rebuild the inverse for those that stay free."""
    clear(active)
    for node in range(len(f)):
        status = state.status[node]
        if status == OPEN or (status != STICK and f[node] == 0.0):
            state.status[node] = STICK
            _change(S, f, state, active, node, status)
        else:
            state.status[node] = STICK


@njit(cache=True)
def refresh(S, f, bonded, state, active):
    """Recompute the reactions from slip and gap, and take rounding off the bounds of slipping and open nodes by one correction of their slip."""
    nodes, n = len(f), active.size[0]
    state.r[:] = bonded + S @ state.u
    error = np.empty(n)
    for a in range(n):
        unknown = active.unknown[a]
        error[a] = state.r[unknown] + (active.weight[a] * state.r[nodes + unknown] if active.weight[a] != 0.0 else 0.0)
    for a in range(n):
        total = 0.0
        for b in range(n):
            total -= active.inverse[a, b] * error[b]
        state.u[active.unknown[a]] += total
    state.r[:] = bonded + S @ state.u
    for node in range(nodes):
        if state.status[node] == OPEN:
            state.r[node] = state.r[nodes + node] = 0.0
        elif state.status[node] != STICK:
            state.r[node] = -state.status[node] * f[node] * state.r[nodes + node]


@njit(cache=True)
def impose(S, f, state, active, status):
    """Give all nodes the statuses of a solved rate problem; returns whether they have unique rates."""
    clear(active)
    state.status[:] = STICK
    unique = True
    for node in range(len(f)):
        if status[node] != STICK and _change(S, f, state, active, node, status[node]) == 0.0:
            unique = False
    return unique
