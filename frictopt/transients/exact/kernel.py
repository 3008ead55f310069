"""The compiled kernel of the exact path: it follows one segment of the load from event to event.

On a segment the bonded reactions change linearly. If the status of every node is known (stick,
slip, open), the rates of slip, gap and reactions solve one small linear system, and the state
changes linearly, up to the next event: a node reaches its friction bound, loses its pressure or
closes. Then new statuses are found. `tests/helpers/plain_path.py` has the same method on one page
of numpy: read that file first. This file has four parts:

1. the active set: the inverse of the stiffness of the slipping and open nodes, updated when a node
   joins or leaves;
2. statuses that agree with their rates, found by iteration on the signs of the rates;
3. a proof that these rates are unique;
4. the path along one segment.
"""


# One file because numba decides by the file of the outermost function whether its compiled code is
# still valid. If a compiled function or a constant were imported from another file, an edit there
# would not take effect.

from functools import cache
from typing import NamedTuple

import numpy as np

from .compilation import in_place, inner_in_place, notice_of_compilation, once

# The arrays that the compiled path changes in place: the state, and the active set.


class State(NamedTuple):
    """State of a path. All arrays are changed in place.

    `u` (2N,) is slip and opening `[v, w - g0]`, `r` (2N,) the reactions `[q, p]`, `gap` (N,) the
    initial gap, `status` (N,) 0 stick, +1 and -1 slip, 2 open. `work` and `slid` (N,) are the work
    of friction and the path of slip while closed, both so far. `supplied` (1,) is the work of the
    loads: minus the integral of the bonded reactions over u. `u_rate`, `r_rate`, `load_rate` (2N,)
    are rates of u and r, and of the bonded reactions.

    `wanted` (N,) are statuses that agree with the signs of the rates, `counted` (N,) the statuses
    at the last update of the signature, `touch` (N,) the bounds at which a node is, see `look`.

    `trace` (3,) holds the number of events; a signature of the changes of status, which does not
    depend on their order within a segment; and the number of events whose rates are not proven to
    be unique.
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
    """The n unknowns of the rate problem, and the inverse of their stiffness.

    The proof that the rates are unique uses the same fields, but its `inverse` holds the Cholesky
    factor of the symmetric part of the stiffness.

    `size` (1,) is n, `unknown` (2N,) the index of each unknown in `[v, w]`, `weight` (2N,) the
    factor of p' in its equation: `sense * f` for a slipping node, 0 for an open node. `place` (2N,)
    is the position of each entry of `[v, w]` among the unknowns, or -1. `inverse` (2N, 2N) has the
    inverse in its leading (n, n) entries. `left`, `right`, `column` (2N,) are room for the border
    of a new unknown.
    """

    size: np.ndarray
    unknown: np.ndarray
    weight: np.ndarray
    place: np.ndarray
    inverse: np.ndarray
    left: np.ndarray
    right: np.ndarray
    column: np.ndarray


def new_state(u: np.ndarray, r: np.ndarray, gap: np.ndarray) -> State:
    """The first state of a path, in which every node sticks; it takes over the arrays."""
    nodes = len(gap)
    status, wanted, counted, touch = np.zeros((4, nodes), np.int8)
    work, slid = np.zeros((2, nodes))
    u_rate, r_rate, load_rate = np.zeros((3, 2 * nodes))
    return State(
        u=u,
        r=r,
        gap=gap,
        status=status,
        work=work,
        slid=slid,
        supplied=np.zeros(1),
        u_rate=u_rate,
        r_rate=r_rate,
        load_rate=load_rate,
        wanted=wanted,
        counted=counted,
        touch=touch,
        trace=np.zeros(3, dtype=np.int64),
    )


def new_active_set(nodes: int) -> ActiveSet:
    """An empty active set or proof."""
    left, right, column, weight = np.zeros((4, 2 * nodes))
    return ActiveSet(
        size=np.zeros(1, dtype=np.int64),
        unknown=np.zeros(2 * nodes, dtype=np.int64),
        weight=weight,
        place=np.full(2 * nodes, -1, dtype=np.int64),
        inverse=np.zeros((2 * nodes, 2 * nodes)),
        left=left,
        right=right,
        column=column,
    )


STICK, OPEN = 0, 2
"""Statuses of a node; slip along +x is 1, against it -1."""

BEGIN, DONE, UNSETTLED, STALLED, EVENT = range(5)
"""Where `follow` stands: before the segment; at its end; where no statuses are found that agree
with their rates, or other statuses may agree, too; after too many events; at an event."""

EVENTS, SIGNATURE, UNPROVEN = range(3)
"""Places of the counts in `State.trace`."""

FORWARD, BACKWARD, UNPRESSED, CLOSED_UNPRESSED = 1, 2, 4, 8
"""Bits of `State.touch`: at the bound of slip along +x, at the bound of slip against +x, without
pressure, without pressure and gap."""

# Copies of numbers in `frictopt.base.tolerances`; a test compares them.
_ROUNDING = 1e-12
_CONDENSATION = 1e-10
_NO_DRIVE = 1e-15


# The numbers of the exact path.

# A node is at its bound up to this slack, relative to the bound plus a thousandth of the force
# scale.
AT_BOUND = 10 * _ROUNDING
# Rates of slack and slip below this share of the load rate count as zero.
_ZERO_RATE = 10 * _ROUNDING
# Pivots below this share of the unknown's stiffness may be zero. Then the rates are not unique.
_ZERO_PIVOT = _CONDENSATION
# Largest number of solutions for the rates by one inverse: the first one and its corrections.
_SOLUTIONS = 3
# Largest number of iterations that change all wrong nodes at once.
_BLOCK_ITERATIONS = 12
# Largest number of later iterations, which change the first wrong node alone (Murty 1974).
_SINGLE_ITERATIONS = 200


# --- Arrays ---------------------------------------------------------------------------------------
# These are loops, not `a[:] = b` or functions of numpy. For such code numba also compiles the texts
# of errors that do not occur, which takes a third of the compilation.


@inner_in_place
def _copy(values, into):
    """Write an array into another one."""
    for k in range(len(values)):
        into[k] = values[k]


@inner_in_place
def _largest(values):
    """The largest size of the entries of an array."""
    largest = 0.0
    for value in values:
        largest = max(largest, abs(value))
    return largest


# --- 1. The active set ----------------------------------------------------------------------------
# A slipping node has one unknown, its slip rate, and one equation, `q' + sense f p' = 0` (sense +1
# along +x). An open node has two unknowns, its rates of slip and gap, and two equations, `q' = 0`
# and `p' = 0`. Adding or removing an unknown updates the explicit inverse in n^2 operations; a new
# factorisation would take n^3. `_refresh` at the end of each segment corrects the rounding that
# such updates accumulate.


@inner_in_place
def _left_side(values, unknown, weight):
    """`q + weight p` of values `[q, p]` (2N,): the left side of the equation of an unknown.

    If the values are a row of S, it is the entry of this equation in the column of this row, as S
    is symmetric.
    """
    normal = 0.0
    if weight != 0.0:
        normal = weight * values[len(values) // 2 + unknown]
    return values[unknown] + normal


@inner_in_place
def _border(S, active, new, factor):
    """Products of the inverse with the row and the column of a new unknown; returns its pivot.

    The products are in `left` and `right`. The pivot is the Schur complement of the new unknown.
    """
    n, unknown, weight, inverse = active.size[0], active.unknown, active.weight, active.inverse
    left, right, column = active.left, active.right, active.column
    for a in range(n):
        left[a] = 0.0
        column[a] = _left_side(S[new], unknown[a], weight[a])
    pivot = _left_side(S[new], new, factor)
    for a in range(n):
        entry = _left_side(S[unknown[a]], new, factor)
        total = 0.0
        for b in range(n):
            left[b] += entry * inverse[a, b]
            total += inverse[a, b] * column[b]
        right[a] = total
        pivot -= entry * total
    return pivot


@inner_in_place
def _append(S, active, new, factor):
    """Add an unknown, and return its pivot over its stiffness. If this is 0, none is added."""
    pivot = _border(S, active, new, factor)
    share = 0.0
    if S[new, new] > 0.0:
        share = pivot / S[new, new]
    if abs(share) <= _ZERO_PIVOT:
        return 0.0
    n, inverse, left, right = active.size[0], active.inverse, active.left, active.right
    for a in range(n):
        scaled = right[a] / pivot
        for b in range(n):
            inverse[a, b] += scaled * left[b]
        inverse[a, n] = -scaled
        inverse[n, a] = -left[a] / pivot
    inverse[n, n] = 1.0 / pivot
    _enter(active, new, factor)
    return share


@inner_in_place
def _enter(active, new, weight):
    """Enter an unknown at the end of an active set or of a proof."""
    n = active.size[0]
    active.unknown[n] = new
    active.weight[n] = weight
    active.place[new] = n
    active.size[0] = n + 1


@inner_in_place
def _remove(active, old):
    """Remove one unknown, after a swap with the last one."""
    inverse, place, last = active.inverse, active.place[old], active.size[0] - 1
    if place != last:
        for a in range(last + 1):
            inverse[place, a], inverse[last, a] = inverse[last, a], inverse[place, a]
        for a in range(last + 1):
            inverse[a, place], inverse[a, last] = inverse[a, last], inverse[a, place]
        moved = active.unknown[last]
        active.unknown[place] = moved
        active.weight[place] = active.weight[last]
        active.place[moved] = place
    diagonal = inverse[last, last]
    for a in range(last):
        scaled = inverse[a, last] / diagonal
        for b in range(last):
            inverse[a, b] -= scaled * inverse[last, b]
    active.place[old] = -1
    active.size[0] = last


@inner_in_place
def _clear(active):
    """Remove all unknowns."""
    for a in range(active.size[0]):
        active.place[active.unknown[a]] = -1
    active.size[0] = 0


@inner_in_place
def _leave(active, node, nodes):
    """Remove the unknowns of a node."""
    for unknown in range(node, 2 * nodes, nodes):
        if active.place[unknown] >= 0:
            _remove(active, unknown)


@once
def _join(S, f, active, node, status):
    """Add the unknowns of a node, and return the least ratio of `_append`. If 0, none is added."""
    nodes = len(f)
    if status != OPEN:
        return _append(S, active, node, status * f[node])
    gap_share = _append(S, active, nodes + node, 0.0)
    if gap_share == 0.0:
        return 0.0
    slip_share = _append(S, active, node, 0.0)
    if slip_share == 0.0:
        _remove(active, nodes + node)
        return 0.0
    return min(gap_share, slip_share)


@inner_in_place
def change_statuses(S, f, status, active, wanted):
    """Give the nodes the statuses `wanted`.

    Returns the smallest pivot, divided by the stiffness of its unknown. If a pivot is zero, the
    rates are not unique: then the function returns 0, and the node of this pivot sticks.
    """
    nodes, smallest, unique = len(f), np.inf, True
    # Nodes that stick from now on leave first, so that the active set is smaller when others join.
    for node in range(nodes):
        if wanted[node] == STICK and status[node] != STICK:
            _leave(active, node, nodes)
            status[node] = STICK
    for node in range(nodes):
        if wanted[node] == status[node] or wanted[node] == STICK:
            continue
        _leave(active, node, nodes)
        status[node] = wanted[node]
        share = _join(S, f, active, node, wanted[node])
        smallest = min(smallest, share)
        if share == 0.0:
            status[node] = STICK
            unique = False
    return smallest if unique else 0.0


@in_place
def set_statuses(S, f, state, active, status):
    """Give all nodes the statuses of a solution of the rate problem.

    Returns whether its rates are unique.
    """
    _clear(active)
    state.status[:] = STICK
    return change_statuses(S, f, state.status, active, status) != 0.0


@inner_in_place
def solve_rates(S, active, state):
    """Rates of `[v, w]` and `[q, p]` under the rate of the bonded reactions.

    The inverse has the rounding of its updates. If the equations of the active set have a residual,
    the rates are corrected with the same inverse.
    """
    load_rate, u_rate, r_rate = state.load_rate, state.u_rate, state.r_rate
    u_rate[:] = 0.0
    _copy(load_rate, r_rate)
    rounding = _ROUNDING * _largest(load_rate)
    for _ in range(_SOLUTIONS):
        if _error(active, r_rate) <= rounding:
            break
        _correct(active, u_rate)
        _reactions(S, load_rate, u_rate, r_rate)


@inner_in_place
def _error(active, r):
    """The largest error of the equations of the active set at reactions r; `right` has all."""
    largest = 0.0
    for a in range(active.size[0]):
        error = _left_side(r, active.unknown[a], active.weight[a])
        active.right[a] = error
        largest = max(largest, abs(error))
    return largest


@inner_in_place
def _correct(active, u):
    """Change the unknowns among motions u so that the errors of their equations vanish."""
    n, error = active.size[0], active.right
    for a in range(n):
        total = 0.0
        for b in range(n):
            total += active.inverse[a, b] * error[b]
        u[active.unknown[a]] -= total


@inner_in_place
def _reactions(S, bonded, u, r):
    """Write `bonded + S u` into r (S is symmetric: its rows are columns)."""
    _copy(bonded, r)
    for unknown in range(len(u)):
        if u[unknown] != 0.0:
            for k in range(len(r)):
                r[k] += u[unknown] * S[unknown, k]


# --- 2. Statuses that agree with their rates ------------------------------------------------------


@inner_in_place
def _slacks(f, r, node, nodes):
    """Distances of q from the bound of slip along +x and from the bound of slip against +x."""
    bound = f[node] * r[nodes + node]
    return bound + r[node], bound - r[node]


@inner_in_place
def _is_unpressed(p, force):
    """Whether a pressure is zero up to rounding, relative to a thousandth of the force scale."""
    return p <= AT_BOUND * 1e-3 * force


@inner_in_place
def look(f, state, force):
    """Note in `touch` at which bounds each node is."""
    nodes, u, r = len(f), state.u, state.r
    for node in range(nodes):
        p = r[nodes + node]
        forward_slack, backward_slack = _slacks(f, r, node, nodes)
        small = AT_BOUND * (f[node] * p + 1e-3 * force[node])
        unpressed = _is_unpressed(p, force[node])
        touch = FORWARD * (forward_slack <= small) + BACKWARD * (backward_slack <= small)
        touch += UNPRESSED * unpressed
        closed = u[nodes + node] + state.gap[node] <= 0.0
        state.touch[node] = touch + CLOSED_UNPRESSED * (unpressed and closed)


@inner_in_place
def _falls(S, state, node, rate, least, stiffness):
    """Whether a rate of a node is negative beyond rounding.

    `least` is a share of the largest load rate. A smaller rate still counts if it exceeds the same
    share of the load rates that reach the node, divided by its `stiffness` (1 for forces).
    """
    if rate >= 0.0 or rate < -least:
        return rate < 0.0
    nodes, load_rate, u_rate = len(S) // 2, state.load_rate, state.u_rate
    reached = abs(load_rate[node]) + abs(load_rate[nodes + node])
    for k in range(2 * nodes):
        if u_rate[k] != 0.0:
            # S is symmetric, and its rows lie together.
            reached += abs(u_rate[k]) * (abs(S[node, k]) + abs(S[nodes + node, k]))
    return rate < -_ZERO_RATE * reached / stiffness


@inner_in_place
def _wanted(S, f, state, node, least_r, least_u):
    """Status that agrees with the signs of a node's rates: the present status if it agrees."""
    nodes, u_rate, r_rate = len(f), state.u_rate, state.r_rate
    status, touch, gap = state.status[node], state.touch[node], len(f) + node
    if status == OPEN:
        if touch & CLOSED_UNPRESSED and _falls(S, state, node, u_rate[gap], least_u, S[gap, gap]):
            return STICK
        return OPEN
    if touch & UNPRESSED and _falls(S, state, node, r_rate[nodes + node], least_r, 1.0):
        return OPEN
    if status != STICK:
        if f[node] > 0.0 and _falls(S, state, node, status * u_rate[node], least_u, S[node, node]):
            return STICK
        return status
    for bit, sense in ((FORWARD, 1), (BACKWARD, -1)):
        slack_rate = f[node] * r_rate[nodes + node] + sense * r_rate[node]
        if touch & bit and _falls(S, state, node, slack_rate, least_r, 1.0):
            return sense
    return STICK


@once
def _find_wrong_statuses(S, f, state, least_r, least_u, only_first):
    """Write the statuses that agree with the rates into `wanted`; returns how many are new.

    `only_first`: only the first new status is written.
    """
    status, wanted, touch = state.status, state.wanted, state.touch
    wrong = 0
    for node in range(len(f)):
        if touch[node] == 0 and status[node] == STICK:
            continue
        wanted[node] = _wanted(S, f, state, node, least_r, least_u)
        if wanted[node] != status[node]:
            wrong += 1
            if only_first and wrong > 1:
                wanted[node] = status[node]
    return wrong


@once
def settle(S, f, state, active, known, least_r, least_u):
    """Iterate on the signs of the rates until the statuses of all nodes at a bound agree with them.

    Returns whether they agree and no other statuses may agree. `known`: the rates of the present
    statuses are known already. Rates below `least_r` and `least_u` count as zero.
    """
    unique = True
    _copy(state.status, state.wanted)
    for iteration in range(_BLOCK_ITERATIONS + _SINGLE_ITERATIONS):
        if iteration > 0 or not known:
            solve_rates(S, active, state)
        only_first = iteration >= _BLOCK_ITERATIONS
        wrong = _find_wrong_statuses(S, f, state, least_r, least_u, only_first)
        if wrong == 0:
            return unique and not _may_also_slip(S, f, state, active)
        share = change_statuses(S, f, state.status, active, state.wanted)
        if share == 0.0:
            return False
        unique = unique and share > 0.0
    return False


@once
def _may_also_slip(S, f, state, active):
    """Whether a sticking node at its bound may slip, too: its pivot is not positive if it slips."""
    for node in range(len(f)):
        if state.status[node] == STICK and state.touch[node]:
            for bit, sense in ((FORWARD, 1), (BACKWARD, -1)):
                if state.touch[node] & bit and _border(S, active, node, sense * f[node]) <= 0.0:
                    return True
    return False


# --- 3. A proof that the rates are unique ---------------------------------------------------------
# Let two sets of rates obey the law, with differences dv, dw, dq, dp. A node that slips, or sticks
# at one bound, has `dv dq <= -sense f dv dp`; an open node has dq = dp = 0; all other nodes have
# dv = dw = 0. So the sum of `dv (dq + sense f dp)` over the nodes that slip, or stick at one bound,
# is not positive. If the quadratic form of these rows of the stiffness is positive definite, all
# differences are zero. A form that is positive definite for a set of nodes is also positive
# definite for each subset: the Cholesky factor only grows when nodes begin to slip, and remains
# valid when they stop.


@once
def prove(S, f, state, proof):
    """Whether the rates at a state are proven to be unique; `proof` is extended in place."""
    for _ in range(2):
        if _extend_proof(S, f, state, proof):
            return True
        # Unknowns of earlier states may be the reason.
        _clear(proof)
    return False


@once
def _extend_proof(S, f, state, proof):
    """Add what moves at a state to the proof; returns whether the form is positive definite."""
    nodes, place, weight_of = len(f), proof.place, proof.weight
    for node in range(nodes):
        status, touch = state.status[node], state.touch[node]
        if _is_undecided(status, touch, f[node]):
            return False
        if status == STICK and not touch & (FORWARD | BACKWARD):
            continue
        weight = f[node] * _sense(status, touch)
        if place[node] >= 0:
            included = weight_of[place[node]] == weight
        else:
            included = _include(S, proof, node, weight)
        if included and status == OPEN and place[nodes + node] < 0:
            included = _include(S, proof, nodes + node, 0.0)
        if not included:
            return False
    return True


@inner_in_place
def _is_undecided(status, touch, friction):
    """Whether a node has more ways to go on than a quadratic form can decide.

    A node without pressure and gap may open, or slip along +x or against it. A closed node at both
    bounds may slip either way.
    """
    if touch & CLOSED_UNPRESSED:
        return True
    at_both_bounds = touch & (FORWARD | BACKWARD) == FORWARD | BACKWARD
    return at_both_bounds and status != OPEN and friction > 0.0


@inner_in_place
def _sense(status, touch):
    """Direction in which a node slips or may begin to slip; 0 for an open node."""
    if status == OPEN:
        return 0
    if status != STICK:
        return status
    return 1 if touch & FORWARD else -1


@inner_in_place
def _include(S, proof, unknown, weight):
    """Add an unknown to the Cholesky factor; returns whether the form stays positive definite."""
    n, L = proof.size[0], proof.inverse
    pivot = _symmetric_entry(S, unknown, weight, unknown, weight)
    for a in range(n):
        entry = _symmetric_entry(S, unknown, weight, proof.unknown[a], proof.weight[a])
        for b in range(a):
            entry -= L[n, b] * L[a, b]
        L[n, a] = entry / L[a, a]
        pivot -= L[n, a] * L[n, a]
    if not pivot > _ZERO_PIVOT * S[unknown, unknown]:
        return False
    L[n, n] = np.sqrt(pivot)
    _enter(proof, unknown, weight)
    return True


@inner_in_place
def _symmetric_entry(S, row, row_weight, column, column_weight):
    """Entry of the symmetric part of the rows `q + weight p`."""
    mirrored = _left_side(S[row], column, column_weight)
    return 0.5 * (_left_side(S[column], row, row_weight) + mirrored)


# --- 4. The path along one segment ----------------------------------------------------------------


@in_place
def follow(S, f, bonded, ahead, state, active, proof, force, stiffness, start, last, stops, most):
    """Follow the path while the bonded reactions (2N,) change from `bonded` to `ahead`.

    The path begins at the time `start`, from 0 to 1 on the segment. `state`, `active` and `proof`
    are changed in place; `force` (N,) is the scale of the nodal forces, and `stiffness` the scale
    of S. `last` is where the path stopped before, or `BEGIN`: if it continues within the segment,
    the statuses already agree with the rates; from an event, the rates are known, too. If it
    `stops`, it does so at each event. It stalls after `most` events. Returns where it stopped, and
    the time.
    """
    load_rate, time = state.load_rate, start
    for k in range(len(load_rate)):
        load_rate[k] = ahead[k] - bonded[k]
    least_r = _ZERO_RATE * _largest(load_rate)
    least_u = least_r / stiffness
    if last == BEGIN:
        _begin(S, f, state, active)
    settled = last != BEGIN or not _is_driven(load_rate, force)
    known = last == EVENT
    for event in range(most):
        if not known:
            look(f, state, force)
            if settled:
                solve_rates(S, active, state)
            elif not settle(S, f, state, active, event > 0, least_r, least_u):
                return UNSETTLED, time
            else:
                state.trace[UNPROVEN] += not prove(S, f, state, proof)
            if stops:
                return EVENT, time
        known, settled = False, False
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
        state.trace[EVENTS] += 1
    return STALLED, time


@once
def _is_driven(load_rate, force):
    """Whether the load changes beyond rounding."""
    for k in range(len(load_rate)):
        if not abs(load_rate[k]) <= _NO_DRIVE * force[k % len(force)]:
            return True
    return False


@once
def _begin(S, f, state, active):
    """At a load corner: let all slipping nodes with friction stick, and compute the inverse anew.

    `settle` finds the nodes that slip under the new load rate.
    """
    status, wanted = state.status, state.wanted
    _clear(active)
    for node in range(len(f)):
        stays = status[node] == OPEN or f[node] == 0.0
        wanted[node] = status[node] if stays else STICK
        status[node] = STICK
    change_statuses(S, f, status, active, wanted)
    _copy(status, state.counted)
    state.trace[SIGNATURE] *= 1000003


@once
def _next_event(f, state):
    """Time to the next event, and its node; infinity and N if there is none."""
    nodes, u, r, u_rate, r_rate = len(f), state.u, state.r, state.u_rate, state.r_rate
    first, first_node = np.inf, nodes
    for node in range(nodes):
        status, touch, time = state.status[node], state.touch[node], np.inf
        p, p_rate = r[nodes + node], r_rate[nodes + node]
        if status == OPEN and u_rate[nodes + node] < 0.0:
            time = max(u[nodes + node] + state.gap[node], 0.0) / -u_rate[nodes + node]
        if status != OPEN and not touch & UNPRESSED and p_rate < 0.0:
            time = p / -p_rate
        if status == STICK:
            forward_slack, backward_slack = _slacks(f, r, node, nodes)
            forward_rate = f[node] * p_rate + r_rate[node]
            backward_rate = f[node] * p_rate - r_rate[node]
            if not touch & FORWARD and forward_rate < 0.0:
                time = min(time, forward_slack / -forward_rate)
            if not touch & BACKWARD and backward_rate < 0.0:
                time = min(time, backward_slack / -backward_rate)
        if time < first:
            first, first_node = time, node
    return first, first_node


@once
def _advance(f, bonded, time, state, step):
    """Change the state at constant rates, and add up the work of friction and of the loads.

    Slipping and open nodes are put exactly on their bounds.
    """
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
        if status == STICK:
            continue
        if status != OPEN:
            slid = abs(step * u_rate[node])
            state.slid[node] += slid
            state.work[node] += f[node] * 0.5 * (before + r[nodes + node]) * slid
        _put_on_bound(f, r, node, status)


@inner_in_place
def _put_on_bound(f, r, node, status):
    """Remove the rounding of the reactions of a slipping or open node."""
    nodes = len(f)
    if status == OPEN:
        r[node] = 0.0
        r[nodes + node] = 0.0
    elif status != STICK:
        r[node] = -status * f[node] * r[nodes + node]


@once
def _snap(f, state, node, force):
    """Put the node of an event exactly on its bound, at zero pressure, or at zero gap."""
    nodes, r, status = len(f), state.r, state.status[node]
    if status == OPEN:
        state.u[nodes + node] = -state.gap[node]
    elif status != STICK or _is_unpressed(r[nodes + node], force[node]):
        r[node] = 0.0
        r[nodes + node] = 0.0
    else:
        forward_slack, backward_slack = _slacks(f, r, node, nodes)
        bound = f[node] * r[nodes + node]
        r[node] = -bound if forward_slack < backward_slack else bound


@once
def _refresh(S, f, bonded, state, active):
    """Recompute the reactions from slip and gap, with one correction of both.

    The correction puts slipping and open nodes back on their bounds.
    """
    u, r = state.u, state.r
    _reactions(S, bonded, u, r)
    _error(active, r)
    _correct(active, u)
    _reactions(S, bonded, u, r)
    for node in range(len(f)):
        _put_on_bound(f, r, node, state.status[node])


@once
def _count_changes(state):
    """Add the changes of status to the signature: a sum, so that their order does not matter."""
    for node in range(len(state.status)):
        status, before = state.status[node], state.counted[node]
        if status != before:
            mixed = (16 * node + 4 * (status + 1) + before + 1) * 0x5851F42D4C957F2D
            state.trace[SIGNATURE] += mixed ^ (mixed >> 29)
            state.counted[node] = status


@cache
def compiled() -> None:
    """Compile what every path needs, or load it from disk; a notice says that it is compiled."""
    S, f, load = np.eye(2), np.ones(1), np.zeros(2)
    # Read-only like the stiffness of a system: numba compiles once more for a writable array.
    S.flags.writeable = False
    state = new_state(np.zeros(2), np.array([0.0, 1.0]), np.zeros(1))
    active, proof = new_active_set(1), new_active_set(1)
    with notice_of_compilation():
        follow(S, f, load, load, state, active, proof, np.ones(1), 1.0, 0.0, BEGIN, False, 1)
