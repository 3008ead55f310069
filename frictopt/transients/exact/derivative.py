"""A cycle of a path: how its end and its work change with the state at its beginning.

Between two events a set `a` of motions changes: the slips of slipping nodes, where
`q + sense f p = 0`, and the slips and gaps of open nodes, where q = p = 0. The set `b` of all other
motions stays as it is. So the end of a cycle is piecewise linear in the state at its beginning.

On each stretch between two events the rows b of the derivative D stay as they are. The rows a solve
`K_aa D_a = -K_ab D_b`, where K has the rows of the equations above. A motion that stops within a
segment stops at an event, and the time of the event changes with the state.

The work of friction of a cycle is the work of the loads less the elastic energy gained. Integration
by parts yields its derivative: if the state `u = [v, w - g0]` changes by du, the work changes in
first order by the integral of `du . dr^w` over the cycle, less `r . du` at the end of the cycle,
plus `r . du` at its beginning.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...base import CONDENSATION, ROUNDING, Array, Booleans, Integers, frozen
from ...errors import NoContinuation
from .kernel import OPEN, STICK
from .path import ExactPath

_CRITICAL = (
    "derivative of a cycle: friction is critical at a node that slips, so that its rates are not "
    "unique"
)


@dataclass(frozen=True, eq=False)
class ReturnMap:
    """A cycle of a transient with its derivative, on the exact path or in increments.

    Attributes
    ----------
    before
        (M,) `u = [v, w - g0]` at its beginning, length.
    derivative
        (M, M) derivative of u at its end with respect to `before`. If several events of the exact
        path happen at once and stop a motion, the derivative may differ from direction to
        direction. Then it is computed from one of these events alone.
    work_gradient
        (M,) derivative of the work of friction with respect to `before`, force (per depth).
    status
        (E, N) statuses on each stretch between two events, or after each increment: 0 stick, +1 and
        -1 slip along +x and against it, 2 open.
    r
        (E, 2, M) reactions `[q, p]` at the beginning and at the end of each stretch, (E, 1, M)
        after each increment, force (per depth).
    motions
        (E, M, M) derivative of u on each stretch with respect to `before`.

    Examples
    --------
    >>> import frictopt as fo
    >>> from frictopt.transients.exact import ExactPath, return_map
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> path = ExactPath(
    ...     rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    ... ).start()
    >>> path.follow(path.segments)
    []
    >>> one = return_map(path)
    >>> one.locked.tolist(), (one.derivative.diagonal()[:4].round(6) + 0.0).tolist()
    ([False, True, True, True], [0.0, 1.0, 1.0, 1.0])
    """

    before: Array
    derivative: Array
    work_gradient: Array
    status: NDArray[np.int8]
    r: Array
    motions: list[Array]

    @property
    def locked(self) -> Booleans:
        """(N,) whether each node sticks throughout the cycle, so that its slip does not change."""
        return np.asarray((self.status == STICK).all(axis=0))


def return_map(path: ExactPath) -> ReturnMap:
    """Follow one cycle of a path from its corner, and differentiate it; the path is not changed.

    Raises
    ------
    NoContinuation
        The path ends.

    Examples
    --------
    >>> import frictopt as fo
    >>> from frictopt.transients.exact import ExactPath, return_map
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> path = ExactPath(
    ...     rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    ... ).start()
    >>> return_map(path).status.shape, path.visited
    ((4, 4), 0)
    """
    path = path.recorded()
    n = path.nodes
    u_before = path.state.u.copy()
    r_before = path.state.r.copy()
    status = path.state.status.copy()

    # The gap of a closed node cannot be chosen.
    D = np.diag(np.concatenate([np.ones(n), status == OPEN]))
    integral = np.zeros(2 * n)
    statuses = list[NDArray[np.int8]]()
    reactions = list[Array]()
    motions = list[Array]()
    for corner, name in path.segments:
        drive = corner - path.bonded
        # Slipping nodes stick at a corner. The new direction of the load decides which nodes slip.
        status = np.where(status == OPEN, OPEN, STICK)
        for length, next_status, r in _follow_segment(path, corner, name):
            D = _after_event(path, D, status, next_status, drive)
            status = next_status
            integral += length * (drive @ D)
            statuses.append(status)
            reactions.append(r)
            motions.append(D)
    return ReturnMap(
        before=frozen(u_before),
        derivative=frozen(D),
        work_gradient=frozen(integral + r_before - path.state.r @ D),
        status=np.array(statuses).reshape(-1, n),
        r=frozen(np.reshape(reactions, (-1, 2, 2 * n))),
        motions=motions,
    )


def _follow_segment(
    path: ExactPath, corner: Array, name: str
) -> list[tuple[float, NDArray[np.int8], Array]]:
    """Follow a path to a corner. Return length, status (N,) and reactions (2, 2N) of stretches.

    The length is a share of the segment. Stretches between events that happen at once are left out.
    """
    begin = path.visited
    path.history.clear()
    path.follow_to(corner, name)
    time, _, r, status, _ = path.states()
    lengths = np.diff(time - begin)
    # A stretch shorter than this share of its segment lies between events that happen at once.
    instant = ROUNDING / 10
    return [(lengths[k], status[k], r[k : k + 2]) for k in np.flatnonzero(lengths > instant)]


def _flexibility(path: ExactPath, status: NDArray[np.int8]) -> tuple[Integers, Array]:
    """The m motions under some statuses, and their flexibility (m, 2N).

    If the bonded reactions change by dr, the motions change by `flexibility @ dr`.
    """
    n, S = path.nodes, path.system.S
    is_open = status == OPEN
    motions = np.flatnonzero(np.concatenate([status != STICK, is_open]))
    # A slip has the equation `q + sense f p = 0`; the motions of an open node have q = 0 or p = 0.
    factor = np.concatenate([status * path.friction * ~is_open, np.zeros(n)])[motions]
    equations = np.eye(2 * n)[motions]
    equations[np.arange(len(motions)), n + motions % n] += factor
    K = equations @ S[:, motions]
    try:
        inverse = np.linalg.inv(K)
    except np.linalg.LinAlgError as error:
        raise NoContinuation(_CRITICAL) from error
    # A motion has no unique rate if the other motions make it much softer than its own stiffness.
    if not np.abs(inverse * np.diag(S)[motions]).max(initial=0.0) < 1 / CONDENSATION:
        raise NoContinuation(_CRITICAL)
    return motions, -inverse @ equations


def _after_event(
    path: ExactPath,
    D: Array,
    before: NDArray[np.int8],
    status: NDArray[np.int8],
    drive: Array,
) -> Array:
    """(2N, 2N) derivative of the state on the stretch after an event that changes some statuses.

    D is the derivative before the event, and `drive` (2N,) the change of the bonded reactions on
    the segment. A motion stops when some node begins to slip, opens or closes. Where the motion
    stops depends on the time of this event.
    """
    n = path.nodes
    moved, moved_by = _flexibility(path, before)
    moves, moves_by = _flexibility(path, status)
    stops = np.setdiff1d(moved, moves)
    begins = (before == STICK) & (status != STICK)
    opens_or_closes = (status == OPEN) != (before == OPEN)
    causes = np.flatnonzero(opens_or_closes | begins)
    after = D.copy()
    if len(stops) and len(causes):
        row, load_rate = _condition(path, int(causes[0]), before, status, drive)
        rate = np.zeros(2 * n)
        rate[moved] = moved_by @ drive
        delay = -(row @ D) / (row @ rate + load_rate)  # (2N,) per change of the first state
        after[stops] += np.outer(rate[stops], delay)
    after[n:][status != OPEN] = 0.0
    after[moves] = 0.0
    after[moves] = moves_by @ path.system.S @ after
    return after


def _condition(
    path: ExactPath,
    node: int,
    before: NDArray[np.int8],
    status: NDArray[np.int8],
    drive: Array,
) -> tuple[Array, float]:
    """Gradient (2N,) of the quantity that vanishes at the event of a node, and its rate by loads.

    The quantity is the gap of a node that closes, the pressure of a node that opens, or the
    distance `q + sense f p` of a node from the bound at which it begins to slip.
    """
    n = path.nodes
    weights = np.zeros(2 * n)
    if before[node] == OPEN:
        weights[n + node] = 1.0
        return weights, 0.0
    if status[node] == OPEN:
        weights[n + node] = 1.0
    else:
        weights[node] = 1.0
        weights[n + node] = status[node] * path.friction[node]
    return weights @ path.system.S, float(weights @ drive)
