"""The compiled kernel of the exact path: it follows one segment of the load path from event to event.

On a segment the bonded reactions change linearly. If the status of every node is known (stick,
slip, open), the rates of slip, gap and reactions solve one small linear system, and the state
changes linearly. This ends at an event: a node reaches its friction bound, loses its pressure or
closes. Then new statuses are found. `tests/helpers/plain_path.py` is the same on one page of numpy:
read that first. The file has four parts:

1. the active set: the inverse of the stiffness of the slipping and open nodes, updated when a node
   joins or leaves;
2. statuses that agree with their rates, found by iteration on the signs of the rates;
3. a proof that these rates are unique;
4. the path along one segment.
"""

# One file because numba decides by the file of the outermost function whether its compiled code is
# still valid. If a function or a constant were
# imported from another file, an edit there would not take effect. For the same reason nothing is
# imported from the package.

import sys
from contextlib import nullcontext
from functools import cache
from multiprocessing import parent_process
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.core.event import Event, Listener, install_listener

STICK, OPEN = 0, 2
"""Statuses of a node; slip along +x is 1, against it -1."""

DONE, UNSETTLED, STALLED, FULL = 0, 1, 2, 3
"""Results of `follow`: end of the segment; no statuses found that agree with their rates, or others may, too; too many events; the record is full."""

_ROUNDING, _CONDENSATION, _NO_DRIVE = (
    1e-12,
    1e-10,
    1e-15,
)  # copies of `frictopt.base.tolerances`; a test compares them
AT_BOUND = 10 * _ROUNDING
"""Slack of a node, over its friction bound and a thousandth of the force scale, below which the node is at its bound."""

_RATE = 10 * _ROUNDING  # rates of slack and slip below this share of the load rate count as zero
# pivots below this share of the unknown's own stiffness may be zero: then rates are not unique, and
# nothing is proven
_PIVOT = _CONDENSATION
_SOLUTIONS = 3  # solutions for the rates by one inverse at most: the first one and its corrections
# iterations that change all wrong nodes at once; later ones change only the first wrong node (Murty
# 1974)
_BLOCK = 12
_SINGLE = 200  # of these later iterations


class State(NamedTuple):
    """State of a path. All arrays are changed in place.

    `u` (2N,) is slip and opening `[v, w - g0]`, `r` (2N,) the reactions `[q, p]`, `gap` (N,) the
    initial gap, `status` (N,) 0 stick, +1 and -1 slip, 2 open. `work` and `slid` (N,) are the work
    of friction and the way slid while closed so far, `supplied` (1,) the work of the loads: minus
    the integral of the bonded reactions over u. `u_rate`, `r_rate`, `load_rate` (2N,) are rates of
    u and r, and of the bonded reactions.

    `wanted` (N,) are statuses that agree with the signs of the rates, `counted` (N,) those at the
    last update of the signature, `touch` (N,) the bounds at which a node is, see `look`. `trace`
    (4,) counts events; holds a signature of the changes of status, which does not depend on their
    order within a segment; counts events whose rates are not proven to be unique, and states in the
    record.
    """

    u: np.ndarray
    r: np.ndarray
    gap: np.ndarray
    status: np.ndarray
    work: np.ndarray
    slid: np.ndarray
    supplied: np.ndarray
    u_rate: np.ndarray
    r_rate: np.ndarray
    load_rate: np.ndarray
    wanted: np.ndarray
    counted: np.ndarray
    touch: np.ndarray
    trace: np.ndarray


class ActiveSet(NamedTuple):
    """Unknowns of the rate problem, n of them, and the inverse of their stiffness; or, as a proof, the Cholesky factor of its symmetric part.

    `size` (1,) is n, `unknown` (2N,) the index of each unknown in `[v, w]`, `weight` (2N,) the
    factor of p' in its equation: `sense * f` for a slipping node, 0 for an open one. `place` (2N,)
    is the position of each entry of `[v, w]` among the unknowns, or -1. `inverse` (2N, 2N) is the
    inverse, or the factor. The leading n, or (n, n), are in use. `left`, `right`, `column` (2N,)
    are room for the border of a new unknown.
    """

    size: np.ndarray
    unknown: np.ndarray
    weight: np.ndarray
    place: np.ndarray
    inverse: np.ndarray
    left: np.ndarray
    right: np.ndarray
    column: np.ndarray


def new_active_set(nodes: int) -> ActiveSet:
    """An empty active set or proof."""
    left, right, column, weight = np.zeros((4, 2 * nodes))
    unknown, none = np.zeros(2 * nodes, dtype=np.int64), np.full(2 * nodes, -1, dtype=np.int64)
    return ActiveSet(
        np.zeros(1, dtype=np.int64),
        unknown,
        weight,
        none,
        np.zeros((2 * nodes, 2 * nodes)),
        left,
        right,
        column,
    )


_OPTIONS = {
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "no_rewrites": True,
    "fastmath": {"reassoc", "contract"},
}
# sums in any order take a tenth of the time


def entry_point(function):
    """Compile a function that Python calls, and keep the machine code on disk if a folder can be written."""
    try:
        return njit(cache=True, **_OPTIONS)(function)
    except RuntimeError:  # numba finds no folder for its cache: package and home are read-only
        return njit(**_OPTIONS)(function)


inner = njit(no_cpython_wrapper=True, **_OPTIONS)
"""Of functions that compiled code alone calls: what would let Python call them takes a fifth of the compilation."""

_once = njit(no_cpython_wrapper=True, inline="always", **_OPTIONS)
"""Of functions that one other calls: each that is compiled by itself is optimised again in all that lead to it, which takes a third of it all."""


# --- 1. The active set ----------------------------------------------------------------------------
# ---------------------------
# A slipping node has one unknown, its slip rate, and one equation, `q' + sense f p' = 0` (sense +1
# along +x). An open node has two unknowns, its
# rates of slip and gap, and two equations, `q' = 0` and `p' = 0`. Adding or removing an unknown
# updates the explicit inverse in n^2 operations; a
# new factorisation would take n^3. `refresh` at the end of each segment corrects the rounding that
# such updates accumulate.


@inner
def _border(S, active, new, factor):
    """Row (`left`) and column (`right`) of a new unknown, multiplied by the inverse; returns the pivot (Schur complement)."""
    n, nodes, unknown, weight, inverse = (
        active.size[0],
        len(S) // 2,
        active.unknown,
        active.weight,
        active.inverse,
    )
    left, right, column = active.left, active.right, active.column
    for a in range(n):  # S is symmetric, and its rows lie together
        left[a] = 0.0
        column[a] = S[new, unknown[a]] + (
            weight[a] * S[new, nodes + unknown[a]] if weight[a] != 0.0 else 0.0
        )
    pivot = S[new, new] + (factor * S[nodes + new, new] if factor != 0.0 else 0.0)
    for a in range(n):
        entry = S[new, unknown[a]] + (factor * S[nodes + new, unknown[a]] if factor != 0.0 else 0.0)
        total = 0.0
        for b in range(n):
            left[b] += entry * inverse[a, b]
            total += inverse[a, b] * column[b]
        right[a] = total
        pivot -= entry * total
    return pivot


@_once
def _append(S, active, new, factor):
    pivot = _border(S, active, new, factor)
    share = pivot / S[new, new] if S[new, new] > 0.0 else 0.0
    if abs(share) <= _PIVOT:
        return 0.0
    n, inverse, left, right = active.size[0], active.inverse, active.left, active.right
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


@inner
def _remove(active, old):
    """Remove one unknown, after a swap with the last one."""
    last = active.size[0] - 1
    inverse, place = active.inverse, active.place[old]
    if place != last:
        for a in range(last + 1):
            inverse[place, a], inverse[last, a] = inverse[last, a], inverse[place, a]
        for a in range(last + 1):
            inverse[a, place], inverse[a, last] = inverse[a, last], inverse[a, place]
        moved = active.unknown[last]
        active.unknown[place], active.weight[place], active.place[moved] = (
            moved,
            active.weight[last],
            place,
        )
    diagonal = inverse[last, last]
    for a in range(last):
        scaled = inverse[a, last] / diagonal
        for b in range(last):
            inverse[a, b] -= scaled * inverse[last, b]
    active.place[old] = -1
    active.size[0] = last


@inner
def _clear(size, unknown, place):
    """Remove all unknowns."""
    for a in range(size[0]):
        place[unknown[a]] = -1
    size[0] = 0


@inner
def change_statuses(S, f, status, active, wanted):
    """Give the nodes the statuses wanted: first those that stick from now on, so that the active set is smaller for the others.

    Returns the smallest pivot over the own stiffness of its unknown. If that is zero, the rates are
    not unique: returns 0, and that node sticks.
    """
    nodes, least, unique = len(f), np.inf, True
    for leaving in range(2):
        for node in range(nodes):
            now = wanted[node]
            if now == status[node] or (now == STICK) != (leaving == 0):
                continue
            for unknown in range(node, 2 * nodes, nodes):
                if active.place[unknown] >= 0:
                    _remove(active, unknown)
            status[node] = now
            if now == STICK:
                continue
            for unknown in range(nodes + node if now == OPEN else node, -1, -nodes):
                share = _append(S, active, unknown, now * f[node] if now != OPEN else 0.0)
                least = min(least, share)
                if share == 0.0:
                    status[node], unique = STICK, False
                    if active.place[nodes + node] >= 0:
                        _remove(active, nodes + node)
                    break
    return least if unique else 0.0


@inner
def solve_rates(S, active, state):
    """Rates of `[v, w]` and `[q, p]` under the rate of the bonded reactions.

    The inverse has the rounding of its updates. If the equations of the active set show it, the
    rates are corrected by the same inverse.
    """
    n, nodes, error, change = active.size[0], len(S) // 2, active.right, active.column
    load_rate, u_rate, r_rate = state.load_rate, state.u_rate, state.r_rate
    u_rate[:] = 0.0
    r_rate[:] = load_rate
    most = _ROUNDING * np.abs(load_rate).max()
    for _ in range(_SOLUTIONS):
        largest = 0.0
        for a in range(n):
            unknown = active.unknown[a]
            error[a] = r_rate[unknown] + (
                active.weight[a] * r_rate[nodes + unknown] if active.weight[a] != 0.0 else 0.0
            )
            largest = max(largest, abs(error[a]))
        if largest <= most:
            break
        for a in range(n):
            total = 0.0
            for b in range(n):
                total -= active.inverse[a, b] * error[b]
            change[a] = total
            u_rate[active.unknown[a]] += total
        for a in range(
            0, n, 4
        ):  # four at once, so that `r_rate` is read and written a fourth as often
            b, c, d = min(a + 1, n - 1), min(a + 2, n - 1), min(a + 3, n - 1)
            i, j, g, h = active.unknown[a], active.unknown[b], active.unknown[c], active.unknown[d]
            x, y, z, w = change[a], change[b] * (b > a), change[c] * (c > b), change[d] * (d > c)
            for k in range(2 * nodes):
                r_rate[k] += x * S[i, k] + y * S[j, k] + z * S[g, k] + w * S[h, k]


# --- 2. Statuses that agree with their rates
# ---------------------------------------------------------------------------------


@inner
def _slacks(f, r, node, nodes):
    """Distances of q from the bound of slip along +x and from that of slip against it."""
    bound = f[node] * r[nodes + node]
    return bound + r[node], bound - r[node]


@inner
def _falls(S, state, node, rate, least, own):
    """Whether a rate of a node is negative beyond rounding.

    Below `least`, a share of the largest load, it still counts if it exceeds that share of the
    loads that reach the node, over its `own` stiffness.
    """
    if rate >= 0.0 or rate < -least:
        return rate < 0.0
    nodes, load_rate, u_rate = len(S) // 2, state.load_rate, state.u_rate
    reached = abs(load_rate[node]) + abs(load_rate[nodes + node])
    for k in range(2 * nodes):
        if u_rate[k] != 0.0:
            reached += abs(u_rate[k]) * (
                abs(S[node, k]) + abs(S[nodes + node, k])
            )  # S is symmetric, and its rows lie together
    return rate < -_RATE * reached / own


@inner
def _wanted(S, f, state, node, least_r, least_u):
    """Status that agrees with the signs of a node's rates, the present one if that does."""
    nodes, u_rate, r_rate, status, touch = (
        len(f),
        state.u_rate,
        state.r_rate,
        state.status[node],
        state.touch[node],
    )
    if status == OPEN:
        return (
            STICK
            if touch & 8
            and _falls(S, state, node, u_rate[nodes + node], least_u, S[nodes + node, nodes + node])
            else OPEN
        )
    if touch & 4 and _falls(S, state, node, r_rate[nodes + node], least_r, 1.0):
        return OPEN
    if status != STICK:
        return (
            STICK
            if f[node] > 0.0
            and _falls(S, state, node, status * u_rate[node], least_u, S[node, node])
            else status
        )
    for bit, sense in ((1, 1), (2, -1)):
        if touch & bit and _falls(
            S, state, node, f[node] * r_rate[nodes + node] + sense * r_rate[node], least_r, 1.0
        ):
            return sense
    return STICK


@inner
def look(f, state, force):
    """Note which nodes are at a bound: 1 at that of slip along +x, 2 at that of slip against it, 4 without pressure, 8 without pressure and gap."""
    nodes, u, r = len(f), state.u, state.r
    for node in range(nodes):
        p = r[nodes + node]
        slack_forward, slack_backward = _slacks(f, r, node, nodes)
        small, bare = (
            AT_BOUND * (f[node] * p + 1e-3 * force[node]),
            p <= AT_BOUND * 1e-3 * force[node],
        )
        bounds = 1 * (slack_forward <= small) + 2 * (slack_backward <= small) + 4 * bare
        state.touch[node] = bounds + 8 * (bare and u[nodes + node] + state.gap[node] <= 0.0)


@_once
def settle(S, f, state, active, known, least_r, least_u):
    """Iterate on the signs of the rates until the statuses of all nodes at a bound agree with them; returns whether they do, and no others may.

    `known`: the rates are those of the statuses; below `least_r` and `least_u` rates count as zero.
    """
    status, wanted, touch, u_rate, not_unique = (
        state.status,
        state.wanted,
        state.touch,
        state.u_rate,
        False,
    )
    wanted[:] = status
    for iteration in range(_BLOCK + _SINGLE):
        if iteration > 0 or not known:
            solve_rates(S, active, state)
        wrong = 0
        for node in range(len(f)):
            if touch[node] == 0 and status[node] == STICK:
                continue
            wanted[node] = status[node]
            if (
                STICK != status[node] != OPEN
                and status[node] * u_rate[node] >= 0.0
                and not touch[node] & 4
            ):
                continue  # it slips the way that it moves; to ask `_wanted` costs more
            wanted[node] = _wanted(S, f, state, node, least_r, least_u)
            if wanted[node] != status[node]:
                wrong += 1
                if iteration >= _BLOCK and wrong > 1:
                    wanted[node] = status[node]
        if wrong == 0:
            return not (not_unique or _may_also_slip(S, f, state, active))
        share = change_statuses(S, f, status, active, wanted)
        if share == 0.0:
            return False
        not_unique = not_unique or share < 0.0
    return False


@_once
def _may_also_slip(S, f, state, active):
    """Whether a sticking node at its bound may also slip: its pivot if it slipped is not positive."""
    for node in range(len(f)):
        if state.status[node] == STICK and state.touch[node]:
            for bit, sense in ((1, 1), (2, -1)):
                if state.touch[node] & bit and _border(S, active, node, sense * f[node]) <= 0.0:
                    return True
    return False


@_once
def _begin(S, f, state, active):
    """At a load corner: all slipping nodes stick until `settle` finds which slip under the new load rate; the inverse is computed anew."""
    status, wanted = state.status, state.wanted
    _clear(active.size, active.unknown, active.place)
    for node in range(len(f)):
        wanted[node] = status[node] if status[node] == OPEN or f[node] == 0.0 else STICK
        status[node] = STICK
    change_statuses(S, f, status, active, wanted)
    state.counted[:] = status
    state.trace[1] *= 1000003


@inner
def _reactions(S, bonded, u, r):
    """Write `bonded + S u` into r (S is symmetric: its rows serve as columns)."""
    r[:] = bonded
    for unknown in range(len(u)):
        if u[unknown] != 0.0:
            for k in range(len(r)):
                r[k] += u[unknown] * S[unknown, k]


@_once
def _refresh(S, f, bonded, state, active):
    """Recompute the reactions from slip and gap; one correction of slip and gap puts slipping and open nodes back on their bounds."""
    nodes, n, u, r, status, error = (
        len(f),
        active.size[0],
        state.u,
        state.r,
        state.status,
        active.right,
    )
    _reactions(S, bonded, u, r)
    for a in range(n):
        unknown = active.unknown[a]
        error[a] = r[unknown] + (
            active.weight[a] * r[nodes + unknown] if active.weight[a] != 0.0 else 0.0
        )
    for a in range(n):
        total = 0.0
        for b in range(n):
            total -= active.inverse[a, b] * error[b]
        u[active.unknown[a]] += total
    _reactions(S, bonded, u, r)
    for node in range(nodes):
        if status[node] == OPEN:
            r[node] = 0.0
            r[nodes + node] = 0.0
        elif status[node] != STICK:
            r[node] = -status[node] * f[node] * r[nodes + node]


@entry_point
def set_statuses(S, f, state, active, status):
    """Give all nodes the statuses of a solution of the rate problem; returns whether its rates are unique."""
    _clear(active.size, active.unknown, active.place)
    state.status[:] = STICK
    return change_statuses(S, f, state.status, active, status) != 0.0


# --- 3. A proof that the rates are unique
# ------------------------------------------------------------------------------------
# Let two sets of rates obey the law, with differences dv, dw, dq, dp. A node that slips, or sticks
# at one bound, has `dv dq <= -sense f dv dp`; an
# open node has dq = dp = 0; all other nodes have dv = dw = 0. So the sum of `dv (dq + sense f dp)`
# over the first group is not positive. If the
# quadratic form of these rows of the stiffness is positive definite, all differences are zero. A
# form that is positive definite for a set of nodes
# is so for each of its subsets: the Cholesky factor only grows when nodes begin to slip, and
# remains valid when they stop.


@inner
def _symmetric_entry(S, one, weight, other, other_weight):
    """Entry of the symmetric part of the rows `q + weight p`."""
    entry = S[one, other] + (0.5 * weight * S[len(S) // 2 + one, other] if weight != 0.0 else 0.0)
    return entry + (
        0.5 * other_weight * S[one, len(S) // 2 + other] if other_weight != 0.0 else 0.0
    )


@inner
def _include(S, proof, unknown, weight):
    """Add an unknown to the factor; returns whether the form is positive definite with it."""
    n, L = proof.size[0], proof.inverse
    left = _symmetric_entry(S, unknown, weight, unknown, weight)
    for a in range(n):
        entry = _symmetric_entry(S, unknown, weight, proof.unknown[a], proof.weight[a])
        for b in range(a):
            entry -= L[n, b] * L[a, b]
        L[n, a] = entry / L[a, a]
        left -= L[n, a] * L[n, a]
    if not left > _PIVOT * S[unknown, unknown]:
        return False
    L[n, n] = np.sqrt(left)
    proof.unknown[n], proof.weight[n], proof.place[unknown] = unknown, weight, n
    proof.size[0] = n + 1
    return True


@_once
def _extend_proof(S, f, state, proof):
    nodes = len(f)
    for node in range(nodes):
        status, touch, place = state.status[node], state.touch[node], proof.place[node]
        if (
            touch & 8
            # closed without pressure: it may open, or slip along +x or against it, which no quadratic
            # form decides
        ):
            return False
        if status == STICK and not touch & 3:
            continue
        if status != OPEN and touch & 3 == 3 and f[node] > 0.0:
            return False
        weight = f[node] * (
            0 if status == OPEN else status if status != STICK else 1 if touch & 1 else -1
        )
        if not (proof.weight[place] == weight if place >= 0 else _include(S, proof, node, weight)):
            return False
        if (
            status == OPEN
            and proof.place[nodes + node] < 0
            and not _include(S, proof, nodes + node, 0.0)
        ):
            return False
    return True


@_once
def prove(S, f, state, proof):
    """Whether the rates at a state are proven to be unique; `proof` is extended in place."""
    for _ in range(2):
        if _extend_proof(S, f, state, proof):
            return True
        _clear(
            proof.size, proof.unknown, proof.place
        )  # unknowns of earlier states may be the reason
    return False


# --- 4. The path along one segment
# -------------------------------------------------------------------------------------------


@_once
def _next_event(f, state):
    """Time to the next event, and its node; infinity and -1 if there is none."""
    nodes, u, r, u_rate, r_rate = len(f), state.u, state.r, state.u_rate, state.r_rate
    first, which = np.inf, -1
    for node in range(nodes):
        status, touch, p, p_rate, time = (
            state.status[node],
            state.touch[node],
            r[nodes + node],
            r_rate[nodes + node],
            np.inf,
        )
        if status == OPEN and u_rate[nodes + node] < 0.0:
            time = max(u[nodes + node] + state.gap[node], 0.0) / -u_rate[nodes + node]
        elif status != OPEN and not touch & 4 and p_rate < 0.0:
            time = p / -p_rate
        if status == STICK:
            slack_forward, slack_backward = _slacks(f, r, node, nodes)
            forward, backward = f[node] * p_rate + r_rate[node], f[node] * p_rate - r_rate[node]
            if not touch & 1 and forward < 0.0:
                time = min(time, slack_forward / -forward)
            if not touch & 2 and backward < 0.0:
                time = min(time, slack_backward / -backward)
        if time < first:
            first, which = time, node
    return first, which


@_once
def _advance(f, bonded, time, state, step):
    """Change the state at constant rates, add up the work of friction and of the loads, and put slipping and open nodes exactly on their bounds."""
    nodes, u, r, u_rate, r_rate = len(f), state.u, state.r, state.u_rate, state.r_rate
    middle = time + 0.5 * step
    for k in range(2 * nodes):
        if u_rate[k] != 0.0:
            state.supplied[0] -= (bonded[k] + middle * state.load_rate[k]) * (step * u_rate[k])
            u[k] += step * u_rate[k]
    for node in range(nodes):
        status, before = state.status[node], r[nodes + node]
        r[node] += step * r_rate[node]
        r[nodes + node] += step * r_rate[nodes + node]
        if status == OPEN:
            r[node] = 0.0
            r[nodes + node] = 0.0
        elif status != STICK:
            slid = abs(step * u_rate[node])
            state.slid[node] += slid
            state.work[node] += f[node] * 0.5 * (before + r[nodes + node]) * slid
            r[node] = -status * f[node] * r[nodes + node]


@_once
def _add_row(row, state, time):
    m, n = len(state.u), len(state.status)
    row[0], row[1 : 1 + m], row[1 + m : 1 + 2 * m] = time, state.u, state.r
    row[1 + 2 * m : 1 + 2 * m + n], row[1 + 2 * m + n :] = state.status, state.work
    state.trace[3] += 1


@_once
def _snap(f, state, node, force):
    """Put the node of an event exactly on its bound, at zero pressure, or at zero gap."""
    nodes, r, status = len(f), state.r, state.status[node]
    if status == OPEN:
        state.u[nodes + node] = -state.gap[node]
    elif status != STICK or r[nodes + node] <= AT_BOUND * 1e-3 * force[node]:
        r[node] = 0.0
        r[nodes + node] = 0.0
    else:
        slack_forward, slack_backward = _slacks(f, r, node, nodes)
        r[node] = (
            -f[node] * r[nodes + node]
            if slack_forward < slack_backward
            else f[node] * r[nodes + node]
        )


@_once
def _count_changes(state):
    """Add the changes of status since the last update to the signature; it is a sum, so that their order does not matter."""
    for node in range(len(state.status)):
        status, before = state.status[node], state.counted[node]
        if status != before:
            mixed = (16 * node + 4 * (status + 1) + before + 1) * 0x5851F42D4C957F2D
            state.trace[1] += mixed ^ (mixed >> 29)
            state.counted[node] = status


@entry_point
def follow(S, f, bonded, ahead, state, active, proof, force, start, begins, record):
    """Follow the path while the bonded reactions (2N,) change from `bonded` to `ahead`, from time `start` on (0 to 1 on the segment).

    `state`, `active` and `proof` are changed in place; `force` (N,) is the scale of the nodal
    forces. If the segment does not begin (`begins`) at the start, the statuses agree with the rates
    there already. `record` (rows, 1 + 6N) takes times, u, r, statuses and work at the events;
    without rows they are not recorded. Returns `DONE` or the reason to stop, and the time of the
    stop.
    """
    load_rate, time = state.load_rate, start
    load_rate[:] = ahead - bonded
    size, stiffness = np.abs(load_rate), np.diag(S).mean()
    largest, settled = size.max(), (size <= _NO_DRIVE * np.concatenate((force, force))).all()
    if begins:
        _begin(S, f, state, active)
    known = settled = settled or not begins
    for _ in range(1000 + 200 * len(f)):
        look(f, state, force)
        if settled:
            solve_rates(S, active, state)
        else:
            if not settle(S, f, state, active, known, _RATE * largest, _RATE * largest / stiffness):
                return UNSETTLED, time
            state.trace[2] += not prove(S, f, state, proof)
        if len(record) > 0:
            if state.trace[3] == len(record):
                return FULL, time
            _add_row(record[state.trace[3]], state, time)
        settled, known = False, True
        _count_changes(state)
        step, node = _next_event(f, state)
        ends = step >= 1.0 - time
        step = min(step, 1.0 - time)
        _advance(f, bonded, time, state, step)
        if ends:
            _refresh(S, f, ahead, state, active)
            return DONE, 1.0
        _snap(f, state, node, force)
        time += step
        state.trace[0] += 1
    return STALLED, time


# --- The first compilation ------------------------------------------------------------------------
# ---------------------------


def new_state(u: np.ndarray, r: np.ndarray, gap: np.ndarray) -> State:
    """The first state of a path, in which every node sticks; it takes over the arrays `u`, `r`, `gap`."""
    nodes = len(gap)
    status, wanted, counted, touch = np.zeros((4, nodes), np.int8)
    work, slid = np.zeros((2, nodes))
    u_rate, r_rate, load_rate = np.zeros((3, 2 * nodes))
    return State(
        u,
        r,
        gap,
        status,
        work,
        slid,
        np.zeros(1),
        u_rate,
        r_rate,
        load_rate,
        wanted,
        counted,
        touch,
        np.zeros(4, dtype=np.int64),
    )


class _Notice(Listener):  # type: ignore[misc]  # numba has no types
    """Says once that the path is compiled."""

    said = False

    def on_start(self, event: Event) -> None:
        """The compilation of a function begins."""
        if not self.said:
            self.said = True
            text = "frictopt: compiling the exact path; this takes some seconds, and only once where its machine code can be kept"
            print(text, file=sys.stderr, flush=True)

    def on_end(self, event: Event) -> None:
        """The compilation of a function ends."""


@cache
def compiled() -> None:
    """Compile what every path needs, or load it from disk; where it is compiled, a notice on stderr says so, but not in a worker."""
    S, f, load = np.eye(2), np.ones(1), np.zeros(2)
    S.flags.writeable = (
        False  # as that of a system: numba compiles once more for an array of another kind
    )
    state = new_state(np.zeros(2), np.array([0.0, 1.0]), np.zeros(1))
    with (
        nullcontext() if parent_process() else install_listener("numba:compile", _Notice())
    ):  # loading is no such event
        follow(
            S,
            f,
            load,
            load,
            state,
            new_active_set(1),
            new_active_set(1),
            np.ones(1),
            0.0,
            True,
            np.zeros((0, 7)),
        )
