"""The exact state of a contact whose nodes' status is known, and the correction of a status that its own state contradicts."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from ...contact.checks import Array
from ...contact.tolerances import AT_BOUND, SINGULAR, WRONG

__all__ = ["NodeStatus", "State", "Status", "classified", "guessed", "settle", "solve_status", "sticking"]

Status = np.ndarray[Any, np.dtype[np.int8]]


class NodeStatus(IntEnum):
    """What a node does."""

    STICK = 0
    FORWARD = 1
    """Slips along +x."""
    BACKWARD = -1
    """Slips against +x."""
    OPEN = 2


STICK, FORWARD, BACKWARD, OPEN = NodeStatus.STICK, NodeStatus.FORWARD, NodeStatus.BACKWARD, NodeStatus.OPEN

_LARGE = 1e8  # dimensionless slips of this size come from a singular matrix
_BLOCK = 12  # corrections that change all wrong nodes at once; later ones change only the first (Murty 1974), lest they repeat themselves


@dataclass(frozen=True, eq=False)
class State:
    """A claimed state, dimensionless.

    Attributes
    ----------
    status
        (N,) `NodeStatus` of every node.
    u
        (2N,) slip increment and total gap `[dv, w]`.
    r
        (2N,) reactions `[q, p]`.
    """

    status: Status
    u: Array
    r: Array


def sticking(nodes: int) -> Status:
    """(nodes,) statuses: every node sticks."""
    return np.full(nodes, STICK, dtype=np.int8)


def solve_status(S: Array, friction: Array, bound: Array, trial: Array, status: Status) -> State:
    """Solve the equations of a status: `q = -sense (bound + f p)` where a node slips, `q = p = 0` where it is open, no motion elsewhere.

    Where they are singular (nothing holds the body) the smallest motion that fits best is taken; whether it fits is for the caller to judge.
    """
    n = len(status)
    moving, opened = np.flatnonzero(status != STICK), np.flatnonzero(status == OPEN)
    sense = np.where(status[moving] == OPEN, 0, status[moving]).astype(np.float64)
    unknown = np.r_[moving, n + opened]
    rows, right = S[unknown], -trial[unknown]
    coupling = sense * friction[moving]
    rows[: len(moving)] += coupling[:, None] * S[n + moving]
    right[: len(moving)] -= coupling * trial[n + moving] + sense * bound[moving]
    u = np.zeros(2 * n)
    u[unknown] = _solved(rows[:, unknown], right)
    r = trial + S @ u
    r[opened], r[n + opened] = 0.0, 0.0
    slipping = (status == FORWARD) | (status == BACKWARD)
    r[:n] = np.where(slipping, -status * (bound + friction * r[n:]), r[:n])
    return State(status.copy(), u, r)


def settle(S: Array, friction: Array, bound: Array, trial: Array, status: Status, changes: int, separation: bool = True) -> State:
    """Correct a status where its own state contradicts it, up to `changes` times (a semismooth Newton method).

    Nodes without friction always count as slipping. Without `separation` no node opens.
    """
    free = (friction == 0) & (bound == 0)
    status = np.where(free & (status == STICK), FORWARD, status).astype(np.int8)
    for change in range(changes + 1):
        state = solve_status(S, friction, bound, trial, status)
        wanted = _wanted(friction, bound, free, state, separation)
        wrong = np.flatnonzero(wanted != status)
        if len(wrong) == 0 or change == changes:
            break
        if change >= _BLOCK:
            wrong = wrong[:1]
        status[wrong] = wanted[wrong]
    return state


def guessed(friction: Array, bound: Array, u: Array, r: Array, separation: bool = True) -> Status:
    """Status of an approximate state: of each complementary pair, the larger one counts."""
    (dv, w), (q, p) = np.split(u, 2), np.split(r, 2)
    forward, backward = bound + friction * p + q, bound + friction * p - q
    status = np.where(dv > np.abs(forward), FORWARD, np.where(-dv > np.abs(backward), BACKWARD, STICK))
    return np.where(separation & (w > p), OPEN, status).astype(np.int8)


def classified(friction: Array, state: State) -> Status:
    """Status by the reactions; on both bounds of friction at once, by the direction of slip."""
    (dv, _), (q, p) = np.split(state.u, 2), np.split(state.r, 2)
    forward, backward = friction * p + q <= AT_BOUND, friction * p - q <= AT_BOUND
    status = np.where(forward & backward, np.sign(dv), np.where(forward, FORWARD, np.where(backward, BACKWARD, STICK)))
    return np.where(p <= AT_BOUND, OPEN, status).astype(np.int8)


def _wanted(friction: Array, bound: Array, free: np.ndarray, state: State, separation: bool) -> Status:
    """Status that each node's state asks for; its own where they agree."""
    (dv, w), (q, p), status = np.split(state.u, 2), np.split(state.r, 2), state.status
    forward, backward = bound + friction * p + q, bound + friction * p - q
    stuck = np.where(forward < -WRONG, FORWARD, np.where(backward < -WRONG, BACKWARD, STICK))
    slipping = np.where((status * dv < -WRONG) & ~free, STICK, status)
    wanted = np.where(status == STICK, stuck, slipping)
    if separation:
        wanted = np.where((status != OPEN) & (p < -WRONG), OPEN, wanted)
    return np.where((status == OPEN) & (w < -WRONG), np.where(free, FORWARD, STICK), np.where(status == OPEN, OPEN, wanted)).astype(np.int8)


def _solved(matrix: Array, right: Array) -> Array:
    try:
        solution = np.linalg.solve(matrix, right)
        if np.abs(solution).max(initial=0.0) < _LARGE:
            return np.asarray(solution)
    except np.linalg.LinAlgError:
        pass
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=SINGULAR)[0])
