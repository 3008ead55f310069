"""The exact path between two load corners, from event to event (compiled)."""

from typing import NamedTuple

import numpy as np
from numba import njit

from .active import OPEN, STICK, solve_rates
from .proof import prove
from .settle import AT_BOUND, SETTLED, settle, slacks

__all__ = ["DONE", "FULL", "STALLED", "UNPROVEN", "Record", "follow", "new_record"]

DONE, STALLED, FULL, UNPROVEN = SETTLED, 3, 4, 5
"""How `follow` ends, besides `UNSETTLED` and `TWOFOLD`: at the end of the segment; after too many events; with the record full; where half of a
mirror-symmetric contact is followed, with rates that are not proven to be the only ones."""


class Record(NamedTuple):
    """States at the events: times (T,), `u` and `r` (T, 2N), status and work (T, N), and the number in use (1,)."""

    time: np.ndarray
    u: np.ndarray
    r: np.ndarray
    status: np.ndarray
    work: np.ndarray
    used: np.ndarray


def new_record(rows: int, nodes: int) -> Record:
    """An empty record of that many states."""
    return Record(
        time=np.zeros(rows),
        u=np.zeros((rows, 2 * nodes)),
        r=np.zeros((rows, 2 * nodes)),
        status=np.zeros((rows, nodes), dtype=np.int8),
        work=np.zeros((rows, nodes)),
        used=np.zeros(1, dtype=np.int64),
    )


@njit(cache=True)
def _next_event(f, state, u_rate, r_rate, force):
    """Time to the next event and its node; infinity and -1 if there is none."""
    nodes = len(f)
    first, which = np.inf, -1
    for node in range(nodes):
        status = state.status[node]
        time = np.inf
        if status == OPEN:
            if u_rate[nodes + node] < 0.0:
                time = max(state.u[nodes + node] + state.gap[node], 0.0) / -u_rate[nodes + node]
        elif status != STICK:
            if r_rate[nodes + node] < 0.0 and state.r[nodes + node] > AT_BOUND * 1e-3 * force:
                time = state.r[nodes + node] / -r_rate[nodes + node]
        else:
            forward, backward = slacks(f, state.r, node, nodes)
            small = AT_BOUND * (f[node] * state.r[nodes + node] + 1e-3 * force)
            bound_rate = f[node] * r_rate[nodes + node]
            if state.r[nodes + node] > AT_BOUND * 1e-3 * force and r_rate[nodes + node] < 0.0:  # without friction no bound is met before
                time = state.r[nodes + node] / -r_rate[nodes + node]
            if forward > small and bound_rate + r_rate[node] < 0.0:
                time = min(time, forward / -(bound_rate + r_rate[node]))
            if backward > small and bound_rate - r_rate[node] < 0.0:
                time = min(time, backward / -(bound_rate - r_rate[node]))
        if time < first:
            first, which = time, node
    return first, which


@njit(cache=True)
def _advance(f, state, u_rate, r_rate, step):
    """Move along constant rates, add up the work of friction, and put slipping and open nodes exactly on their bound."""
    nodes = len(f)
    for node in range(nodes):
        status = state.status[node]
        before = state.r[nodes + node]
        state.u[node] += step * u_rate[node]
        state.u[nodes + node] += step * u_rate[nodes + node]
        state.r[node] += step * r_rate[node]
        state.r[nodes + node] += step * r_rate[nodes + node]
        if status == OPEN:
            state.r[node] = state.r[nodes + node] = 0.0
        elif status != STICK:
            state.work[node] += f[node] * 0.5 * (before + state.r[nodes + node]) * abs(step * u_rate[node])
            state.r[node] = -status * f[node] * state.r[nodes + node]


@njit(cache=True)
def _write(record, state, time):
    row = record.used[0]
    record.time[row] = time
    record.u[row] = state.u
    record.r[row] = state.r
    record.status[row] = state.status
    record.work[row] = state.work
    record.used[0] = row + 1


@njit(cache=True)
def _snap(f, state, node, force):
    """Put the node of an event exactly where it happens: at its bound, without pressure, or closed."""
    nodes = len(f)
    status = state.status[node]
    if status == OPEN:
        state.u[nodes + node] = -state.gap[node]
    elif status != STICK or state.r[nodes + node] <= AT_BOUND * 1e-3 * force:
        state.r[node] = state.r[nodes + node] = 0.0
    else:
        forward, backward = slacks(f, state.r, node, nodes)
        state.r[node] = -f[node] * state.r[nodes + node] if forward < backward else f[node] * state.r[nodes + node]


@njit(cache=True)
def follow(S, other, f, drive, state, active, proof, force, start, settled, record):
    """Follow the path while the bonded reactions change by `drive`, from the share `start` of that change on.

    Parameters
    ----------
    S, f
        (2N, 2N) stiffness, (N,) coefficients of friction.
    other
        (2N, 2N) stiffness of half a contact against the motions that leave its symmetry; (0, 0) where the whole is followed.
    drive
        (2N,) change of the bonded reactions over the whole segment.
    state, active
        Where the path is; changed in place.
    proof
        What is proven of the rates; changed in place.
    force
        Scale of the nodal forces.
    start, settled
        Where to start, between 0 and 1, and whether the statuses there agree with the rates already.
    record
        Where to write the states at the events; of length 0 for none.

    Returns
    -------
    code, time
        How it ended, and where.
    """
    u_rate, r_rate = np.empty_like(drive), np.empty_like(drive)
    time = start
    for _ in range(1000 + 200 * len(f)):
        if settled:
            solve_rates(S, active, drive, u_rate, r_rate)
        else:
            code = settle(S, f, drive, state, active, force, u_rate, r_rate)
            if code != SETTLED:
                return code, time
            if not prove(S, other, f, state, force, proof):
                if len(other) > 0:
                    return UNPROVEN, time
                state.trace[2] += 1
        if len(record.time) > 0:
            if record.used[0] == len(record.time):
                return FULL, time
            _write(record, state, time)
        settled = False
        for node in range(len(f)):
            state.trace[1] = 31 * state.trace[1] + state.status[node] + 2
        step, node = _next_event(f, state, u_rate, r_rate, force)
        if step >= 1.0 - time:
            _advance(f, state, u_rate, r_rate, 1.0 - time)
            return DONE, 1.0
        _advance(f, state, u_rate, r_rate, step)
        _snap(f, state, node, force)
        time += step
        state.trace[0] += 1
    return STALLED, time
