"""The arrays that the compiled path changes in place: the state, and the active set."""

from typing import NamedTuple

import numpy as np


class State(NamedTuple):
    """State of a path. All arrays are changed in place.

    `u` (2N,) is slip and opening `[v, w - g0]`, `r` (2N,) the reactions `[q, p]`, `gap` (N,) the
    initial gap, `status` (N,) 0 stick, +1 and -1 slip, 2 open. `work` and `slid` (N,) are the work
    of friction and the path of slip while closed, both so far. `supplied` (1,) is the work of the
    loads: minus the integral of the bonded reactions over u. `u_rate`, `r_rate`, `load_rate` (2N,)
    are rates of u and r, and of the bonded reactions.

    `wanted` (N,) are statuses that agree with the signs of the rates, `counted` (N,) those at the
    last update of the signature, `touch` (N,) the bounds at which a node is, see `look`.

    `trace` (4,) holds the number of events; a signature of the changes of status, which does not
    depend on their order within a segment; the number of events whose rates are not proven to be
    unique; and the number of states in the record.
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

    A proof that the rates are unique has the same fields; its `inverse` holds the Cholesky factor
    of the symmetric part of the stiffness instead.

    `size` (1,) is n, `unknown` (2N,) the index of each unknown in `[v, w]`, `weight` (2N,) the
    factor of p' in its equation: `sense * f` for a slipping node, 0 for an open one. `place` (2N,)
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
        trace=np.zeros(4, dtype=np.int64),
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
