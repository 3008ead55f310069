"""Pressures and gaps along a load cycle as functions of the load factor.

If the load factor scales normal loads, events change their places with it. A *piece* is an interval
of load factors at which nodes open and close in one order. There pressures and gaps at the instants
are affine in the load factor, and so is the place of each event times the load factor (theory,
"Normal loads that are scaled, too"). The next piece begins where a pressure or a gap of an instant
comes to zero, or where two instants meet.

The *rim* are the nodes of an uncoupled contact that are open at some time. Without pressure a node
carries no shear force, and its slip follows the other nodes. While it presses, in a state of rest,
it keeps its slip. So with the slip of all other nodes at zero, the slip y of the rim obeys linear
equations (theory, "Contact areas that move")::

    z = q + A y,   z = 0 at nodes without pressure,   y constant from closing to opening

They have at most one solution. Friction, mean pressure and the other nodes do not occur in them. If
there is no solution, some node slips in every cycle: its shear load when it closes is not the shear
load when it opens.
"""

from dataclasses import dataclass

import numpy as np

from ...base import ROUNDING, Array, Booleans, Integers
from .normal_path import NoPath, NormalPath, follow, normal_path, states


@dataclass(frozen=True, eq=False)
class Statuses:
    """Which of N nodes press around each of M instants; the last interval ends at the first."""

    before: Booleans  # (M, N) in the interval that ends at the instant
    after: Booleans  # (M, N) in the interval that begins there

    @classmethod
    def of(cls, path: NormalPath) -> "Statuses":
        """The statuses of a normal path."""
        presses = path.presses
        return cls(np.roll(presses, 1, axis=0), presses)

    @property
    def free(self) -> Booleans:
        """(M, N) nodes without pressure before and after."""
        return ~self.before & ~self.after

    @property
    def touching(self) -> Booleans:
        """(M, N) nodes that open or close at the instant."""
        return self.before ^ self.after

    @property
    def rim(self) -> Booleans:
        """(N,) nodes without pressure in some interval."""
        return np.asarray(~self.after.all(axis=0))

    def episodes(self, nodes: Integers) -> tuple[Integers, int]:
        """(M, R) number of the closed episode of some rim nodes at each instant, and their count.

        The number is -1 where a node has no pressure before and after. An episode may go on across
        the end of the cycle.
        """
        pressed = (self.before | self.after)[:, nodes]
        closes = (self.after & ~self.before)[:, nodes]
        counts = closes.sum(axis=0)
        # Before its first closing in the cycle a node is in its last episode.
        of_node = (closes.cumsum(axis=0) - 1) % np.maximum(counts, 1)
        numbers = np.where(pressed, of_node + counts.cumsum() - counts, -1)
        return numbers, int(counts.sum())


@dataclass(frozen=True, eq=False)
class Rim:
    """Slips and shear forces of R rim nodes with t tangents at M instants, all others held.

    Index 0 is the part at load factor 0, index 1 the rate with the load factor. `residual` are the
    shear forces at nodes that open or close; they are zero in a state of rest.
    """

    nodes: Integers  # (R,)
    motion: Array  # (2, M, t, R) length
    shear: Array  # (2, M, t, R) force
    residual: Array  # (2, M, t, R) force


def rim_of(A: Array, shear: Array, statuses: Statuses) -> Rim:
    """The least squares solution of the equations of the rim.

    A (t N, t N) is the tangential stiffness; `shear` (2, M, t, N) are the shear forces without any
    slip. NoPath if the open nodes of some instant are not held.
    """
    tangents, count = shear.shape[2:]
    nodes = np.flatnonzero(statuses.rim)
    entries = (np.arange(tangents)[:, None] * count + nodes).ravel()
    loads = shear[..., nodes]
    stiffness = A[np.ix_(entries, entries)]
    equations = _Equations(stiffness, loads, statuses, nodes)
    slips = equations.solved()
    motion = np.zeros_like(loads)
    for m in range(len(statuses.after)):
        motion[:, m] = equations.motion(m, slips).reshape(motion[:, m].shape)
    flat = motion.reshape(*motion.shape[:2], -1)
    forces = loads + (flat @ stiffness).reshape(motion.shape)
    forces *= ~statuses.free[:, None, nodes]
    residual = forces * statuses.touching[:, None, nodes]
    return Rim(nodes, motion, forces, residual)


class _Equations:
    """The equations of the rim, for the slips of the closed episodes alone.

    Nodes that never press follow the others. They are eliminated once for all instants.
    """

    def __init__(self, A: Array, loads: Array, statuses: Statuses, nodes: Integers) -> None:
        tangents = loads.shape[2]
        numbers, count = statuses.episodes(nodes)
        # Columns of the slips: the episodes of each tangent follow each other.
        columns = [np.where(numbers < 0, -1, axis * count + numbers) for axis in range(tangents)]
        column = np.concatenate(columns, axis=1)
        self._count = tangents * count
        # (t R,) the entries of nodes that press at some time.
        self._presses: Booleans = np.asarray((column >= 0).any(axis=0))
        self._column = column[:, self._presses]
        self._touching = np.tile(statuses.touching[:, nodes], tangents)[:, self._presses]

        flat = loads.reshape(*loads.shape[:2], -1)
        presses, never = self._presses, ~self._presses
        across = A[np.ix_(never, presses)]
        given = flat[..., never]
        forces = np.hstack([across, given.reshape(2 * given.shape[1], -1).T])
        follows = follow(A[np.ix_(never, never)], forces)
        # Slips of the nodes that never press: by those of the others, and by loads.
        self._by_slip = follows[:, : across.shape[1]]
        self._by_load = follows[:, across.shape[1] :].T.reshape(given.shape)
        self._A = A[np.ix_(presses, presses)] - across.T @ self._by_slip
        self._loads = flat[..., presses] - self._by_load @ across

    def solved(self) -> Array:
        """(episodes, 2) slips of the episodes, at load factor 0 and per load factor."""
        rows = [np.zeros((0, self._count))]
        right = [np.zeros((0, 2))]
        for m, touching in enumerate(self._touching):
            if touching.any():
                row, force = self._forces(m, touching)
                rows.append(row)
                right.append(-force)
        return np.asarray(np.linalg.lstsq(np.vstack(rows), np.vstack(right), rcond=ROUNDING)[0])

    def _forces(self, m: int, touching: Booleans) -> tuple[Array, Array]:
        """Forces at the touching nodes of an instant: rows of the slips, and (rows, 2) constants.

        The nodes without pressure follow the nodes with pressure.
        """
        closed = self._column[m] >= 0
        motions = self._follow(m, self._A[np.ix_(~closed, touching)]).T
        coupling = self._A[touching] - motions @ self._A[~closed]
        force = (self._loads[:, m, touching] - self._loads[:, m, ~closed] @ motions.T).T
        row = np.zeros((len(force), self._count))
        row[:, self._column[m, closed]] = coupling[:, closed]
        return row, force

    def motion(self, m: int, slips: Array) -> Array:
        """(2, t R) slips of the rim at an instant, from the slips of the episodes."""
        closed = self._column[m] >= 0
        slip = np.zeros((2, len(closed)))
        slip[:, closed] = slips[self._column[m, closed]].T
        forces = self._loads[:, m, ~closed] + slip @ self._A[:, ~closed]
        slip[:, ~closed] = -self._follow(m, forces.T).T
        motion = np.zeros((2, len(self._presses)))
        motion[:, self._presses] = slip
        motion[:, ~self._presses] = -(self._by_load[:, m] + slip @ self._by_slip.T)
        return motion

    def _follow(self, m: int, forces: Array) -> Array:
        """Slips of the nodes without pressure under given forces on them."""
        opened = self._column[m] < 0
        return follow(self._A[np.ix_(opened, opened)], forces)


@dataclass(frozen=True, eq=False)
class PathPiece:
    """Pressures and gaps at the M instants of a load cycle, for an interval of load factors.

    Index 0 of `place`, `pressure` and `gap` is the part at load factor 0, index 1 the rate with the
    load factor.
    """

    leg: Integers  # (M,) the corner at which the leg of the instant begins
    place: Array  # (2, M) load factor times part of the leg
    pressure: Array  # (2, M, N) force
    gap: Array  # (2, M, N) length
    at_instant: Statuses
    low: float  # the load factors between which nodes open and close in this order
    high: float

    @property
    def at_corner(self) -> Booleans:
        """(M,) which instants are corners."""
        return np.asarray((self.place == 0).all(axis=0))

    @property
    def presses(self) -> Booleans:
        """(M, N) nodes with pressure at the instants."""
        return np.asarray((self.pressure != 0).any(axis=0))

    def part(self, load_factor: float) -> Array:
        """(M,) place of each instant on its leg at a load factor, 0 at the first corner."""
        return np.asarray(self.place[0] / (load_factor or 1.0) + self.place[1])

    def loads(self, at_zero: Array, scaled: Array) -> Array:
        """(2, M, ...) loads at the instants, of loads (K, ...) at the corners.

        If the place of an event changes with the load factor, loads at load factor 0 are the same
        at all corners.
        """
        shape = (2, -1, *[1] * (scaled.ndim - 1))
        constant, rate = self.place.reshape(shape)
        last = (self.leg + 1) % len(scaled)
        held = at_zero[last] - at_zero[self.leg]
        change = scaled[last] - scaled[self.leg]
        zero = at_zero[self.leg] + rate * held + constant * change
        return np.stack([zero, scaled[self.leg] + rate * change])


def piece_of_path(path: NormalPath) -> PathPiece:
    """The piece of a path that is the same at all load factors, or is asked at one alone."""
    return PathPiece(
        path.leg,
        np.stack([np.zeros_like(path.part), path.part]),
        np.stack([path.pressure, np.zeros_like(path.pressure)]),
        np.stack([path.gap, np.zeros_like(path.gap)]),
        Statuses.of(path),
        0.0,
        np.inf,
    )


def piece_at(C: Array, at_zero: Array, scaled: Array, load_factor: float) -> PathPiece:
    """The piece around a load factor above 0.

    `at_zero` (N,) and `scaled` (K, N) are normal reactions with all gaps pressed shut, C (N, N) is
    the normal stiffness. NoPath if a free body lifts off.
    """
    path = normal_path(C, at_zero + load_factor * scaled)
    statuses = Statuses.of(path)
    # Between its neighbours an instant without event is linear.
    kept = (path.part == 0) | statuses.touching.any(axis=1)
    path = NormalPath(path.leg[kept], path.part[kept], path.pressure[kept], path.gap[kept])
    statuses = Statuses(statuses.before[kept], statuses.after[kept])

    instants = len(path.leg)
    place = np.zeros((2, instants))
    pressure = np.zeros((2, *path.pressure.shape))
    gap = np.zeros_like(pressure)
    following = np.roll(scaled, -1, axis=0)
    for m, k in enumerate(path.leg.tolist()):
        rows = np.stack([at_zero, scaled[k], following[k] - scaled[k]])
        pressures, gaps = states(C, rows, statuses.free[m])
        if path.part[m] > 0:
            place[:, m] = _place_of_event(pressures, statuses.touching[m])
        pressure[:, m] = pressures[:2] + place[:, [m]] * pressures[2]
        gap[:, m] = gaps[:2] + place[:, [m]] * gaps[2]
    pressure *= statuses.before & statuses.after
    gap *= statuses.free
    # A rate that is rounding must not bound a load factor that grows without limit.
    for rate in (pressure[1], gap[1]):
        rate[np.abs(rate) <= ROUNDING * np.abs(rate).max(initial=0.0)] = 0.0
    low, high = _ends(path, place, pressure, gap, load_factor)
    return PathPiece(path.leg, place, pressure, gap, statuses, low, high)


def _place_of_event(pressures: Array, touching: Booleans) -> Array:
    """Load factor times place, at which a node that opens or closes has no pressure.

    `pressures` are those at load factor 0, their rate with the load factor at the first corner of
    the leg, and their change along the leg. Nodes that touch together have the same place.
    """
    node = int((touching * np.abs(pressures[2])).argmax())
    change = float(pressures[2, node])
    if not abs(change) > 0:
        raise NoPath("a node opens or closes without a change of its pressure")
    return -pressures[:2, node] / change


def _ends(
    path: NormalPath, place: Array, pressure: Array, gap: Array, load_factor: float
) -> tuple[float, float]:
    """The load factors between which all positive pressures, gaps and distances stay positive."""
    last = np.roll(path.part == 0, -1)
    # The distance to the next instant, of the last one of a leg to the end of the leg.
    distance = np.roll(place, -1, axis=1) * ~last + np.outer((0.0, 1.0), last) - place
    low = 0.0
    high = np.inf
    for values in (pressure, gap, distance):
        constant, rate = values.reshape(2, -1)
        value = constant + load_factor * rate
        rounding = ROUNDING * float(np.abs(rate).max(initial=0.0))
        falls = (value > 0) & (rate < -rounding)
        rises = (value > 0) & (rate > rounding)
        zeros = load_factor - value / np.where(falls | rises, rate, 1.0)
        high = min(high, float(zeros[falls].min(initial=np.inf)))
        low = max(low, float(zeros[rises].max(initial=0.0)))
    return low, high
