"""Pressures and gaps of an uncoupled contact along its load cycle, from the normal problem alone.

If slip changes no pressure (B = 0), pressures p and gaps w solve ``p = b + C w``, ``p >= 0``, ``w
>= 0``, ``p w = 0``. Here b are the normal reactions of the load with all gaps pressed shut.
Pressures and gaps are piecewise linear along the cycle. Their path goes from one *instant* to the
next. An instant is a corner, or an *event*: the place at which a pressure or a gap comes to zero.
Nodes that reach zero together, as in symmetric contacts, are one event. At an event, the rates of
pressures and gaps solve a small problem of the same kind, which decides which of the nodes open.

If the load factor scales normal loads, the places of events change with the load factor. A *piece*
is an interval of load factors in which nodes open and close in the same order. In a piece,
pressures and gaps at the instants are affine in the load factor, and so is the place of each event
times the load factor (theory, "Normal loads that are scaled, too"). A piece ends where a pressure
or a gap at an instant comes to zero, or where two instants meet.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from ...base import CONDENSATION, ROUNDING, SIMULTANEOUS, Array, Booleans, Integers

# Numbers of the path.

# Pressures up to this share of the largest reaction count as zero, and gaps up to this share of the
# largest gap that the loads could make: the data are accurate to about this share.
_ZERO = CONDENSATION
# An event counts as an event at the corner if it is nearer to the end of its segment than this
# share of the segment.
_AT_CORNER = SIMULTANEOUS
# Largest number of events on a segment, and of pivots of a normal problem, each divided by the
# number of nodes.
_STEPS = 20
# All wrong nodes are pivoted at once. After this number of pivots without improvement, single nodes
# are pivoted.
_PATIENCE = 10


@dataclass(frozen=True, eq=False)
class NormalPath:
    """Pressures and gaps at the M instants of a load cycle, in their order."""

    segment: Integers  # (M,) the corner at which the segment of the instant begins
    part: Array  # (M,) place on the segment, 0 at its first corner, below 1
    pressure: Array  # (M, N) force
    gap: Array  # (M, N) length

    @property
    def presses(self) -> Booleans:
        """(M, N) whether a node has pressure between an instant and the next one."""
        following = np.roll(self.pressure, -1, axis=0)
        return self.pressure + following > 0


class NoPath(Exception):
    """The normal problem has no solution, or many: nothing holds the bodies together."""


def normal_path(C: Array, corners: Array) -> NormalPath:
    """The path of pressures and gaps around a load cycle, from the reactions (K, N) at its corners.

    C (N, N) is the normal stiffness. NoPath if a free body lifts off.
    """
    problem = _NormalProblem(C, corners)
    instants = list[tuple[int, float, Array, Array]]()
    opened = _open_nodes(C, corners[0], problem.force, problem.length)
    for k, first in enumerate(corners):
        change = corners[(k + 1) % len(corners)] - first
        part = 0.0
        for _ in range(_STEPS * len(first) + 1):
            pressure, gap = problem.clean(*states(C, first + part * change, opened))
            instants.append((k, part, pressure, gap))
            # Up to the next event, pressures and gaps are linear.
            opened = problem.following(pressure, gap, opened, change)
            pressure_rate, gap_rate = states(C, change, opened)
            part += _to_next_event((pressure, pressure_rate), (gap, gap_rate))
            if part >= 1 - _AT_CORNER:
                break
        else:
            raise NoPath("the events of a segment do not end")
    return NormalPath(*(np.array(part) for part in zip(*instants, strict=True)))


def _to_next_event(*states: tuple[Array, Array]) -> float:
    """The part of a segment after which the first of some positive values has fallen to zero."""
    nearest = np.inf
    for values, rates in states:
        falling = (values > 0) & (rates < 0)
        nearest = min(nearest, float((values[falling] / -rates[falling]).min(initial=np.inf)))
    return nearest


class _NormalProblem:
    """The normal problem for one stiffness; values that are only rounding of reactions are zero."""

    def __init__(self, C: Array, corners: Array) -> None:
        self._C = C
        self.force, self.length = _rounding(C, corners)

    def clean(self, pressure: Array, gap: Array) -> tuple[Array, Array]:
        """Pressures and gaps, with values that are only rounding set to zero."""
        pressed = np.where(pressure > self.force, pressure, 0.0)
        return pressed, np.where(gap > self.length, gap, 0.0)

    def following(self, pressure: Array, gap: Array, opened: Booleans, change: Array) -> Booleans:
        """The open nodes from an instant on, while the reactions begin to change by `change`.

        Pressures and gaps belong to the instant, and `opened` are the open nodes before it. If
        nodes have neither, the rates of their pressures and gaps solve a normal problem, too.
        """
        touching = (pressure == 0) & (gap == 0)
        if not touching.any():
            return opened
        opened = gap > 0
        across = self._C[np.ix_(opened, touching)]
        motions = follow(self._C[np.ix_(opened, opened)], np.c_[across, change[opened]])
        C = self._C[np.ix_(touching, touching)] - across.T @ motions[:, :-1]
        rates = change[touching] - across.T @ motions[:, -1]
        opened[touching] = _open_nodes(C, rates, *_rounding(C, change))
        return opened


def _rounding(C: Array, reactions: Array) -> tuple[float, float]:
    """The force and the length that count as zero, for a stiffness and reactions."""
    force = _ZERO * (float(np.abs(reactions).max()) or 1.0)
    return force, force / (float(C.diagonal().max()) or 1.0)


def follow(stiffness: Array, forces: Array) -> Array:
    """Motions of open nodes, with the stiffness of these nodes, under given forces.

    NoPath if nothing holds the open nodes.
    """
    if not len(stiffness):
        return np.zeros_like(forces)
    factor, motions, failed = dposv(stiffness, forces)
    if failed:
        raise NoPath("open nodes are not held")
    pivots = factor.diagonal() ** 2
    if pivots.min() <= CONDENSATION * stiffness.diagonal().max():
        raise NoPath("open nodes are hardly held")
    return np.asarray(motions.reshape(forces.shape))


def states(C: Array, reactions: Array, opened: Booleans) -> tuple[Array, Array]:
    """Pressures and gaps (or their rates) with given open nodes, whatever their signs.

    Reactions (..., N) give pressures and gaps of the same shape.
    """
    gap = np.zeros_like(reactions)
    pressure = reactions.copy()
    if opened.any():
        rows = C[opened]
        gap[..., opened] = -follow(rows[:, opened], reactions[..., opened].T).T
        pressure += gap[..., opened] @ rows
        pressure[..., opened] = 0.0
    return pressure, gap


def _open_nodes(C: Array, reactions: Array, force: float, length: float) -> Booleans:
    """The open nodes of a normal problem, by principal pivots.

    At first all wrong nodes change at once. If this does not converge, only the last wrong node
    changes (Murty's rule); this ends if C is positive definite. After `_STEPS` N pivots it fails.
    """
    count = len(reactions)
    opened = np.zeros(count, dtype=bool)
    fewest = count + 1
    patience = _PATIENCE
    for _ in range(_STEPS * count):
        pressure, gap = states(C, reactions, opened)
        wrong = np.where(opened, gap < -length, pressure < -force)
        wrongs = int(wrong.sum())
        if not wrongs:
            return opened
        if wrongs < fewest:
            fewest = wrongs
            patience = _PATIENCE
        else:
            patience -= 1
        flipped = wrong
        if patience < 0 or (opened ^ wrong).all():
            flipped = np.zeros(count, dtype=bool)
            flipped[np.flatnonzero(wrong)[-1]] = True
        opened = opened ^ flipped
    raise NoPath("no pressures and gaps found")


@dataclass(frozen=True, eq=False)
class Statuses:
    """Which of N nodes press before and after each of M instants of a closed cycle."""

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


@dataclass(frozen=True, eq=False)
class PathPiece:
    """Pressures and gaps at the M instants of a load cycle, for an interval of load factors.

    Index 0 of `place`, `pressure` and `gap` is the part at load factor 0, index 1 the rate with the
    load factor.
    """

    segment: Integers  # (M,) the corner at which the segment of the instant begins
    place: Array  # (2, M) load factor times part of the segment
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
        """(M,) place of each instant on its segment at a load factor, 0 at the first corner."""
        return np.asarray(self.place[0] / (load_factor or 1.0) + self.place[1])

    def loads(self, at_zero: Array, scaled: Array) -> Array:
        """(2, M, ...) loads at the instants, from loads (K, ...) at the corners.

        If places of events change with the load factor, the loads at load factor 0 have to be the
        same at all corners.
        """
        shape = (2, -1, *[1] * (scaled.ndim - 1))
        constant, rate = self.place.reshape(shape)
        last = (self.segment + 1) % len(scaled)
        held = at_zero[last] - at_zero[self.segment]
        change = scaled[last] - scaled[self.segment]
        zero = at_zero[self.segment] + rate * held + constant * change
        return np.stack([zero, scaled[self.segment] + rate * change])


def piece_of_path(path: NormalPath) -> PathPiece:
    """A path as a piece, if it holds at all load factors, or is needed at one load factor only."""
    return PathPiece(
        path.segment,
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
    # Instants that are neither corners nor events are dropped: pressures and gaps are linear there.
    kept = (path.part == 0) | statuses.touching.any(axis=1)
    segment, part = path.segment[kept], path.part[kept]
    statuses = Statuses(statuses.before[kept], statuses.after[kept])

    place = np.zeros((2, len(segment)))
    pressure = np.zeros((2, len(segment), len(at_zero)))
    gap = np.zeros_like(pressure)
    following = np.roll(scaled, -1, axis=0)
    for m, k in enumerate(segment.tolist()):
        rows = np.stack([at_zero, scaled[k], following[k] - scaled[k]])
        pressures, gaps = states(C, rows, statuses.free[m])
        if part[m] > 0:
            place[:, m] = _place_of_event(pressures, statuses.touching[m])
        pressure[:, m] = pressures[:2] + place[:, [m]] * pressures[2]
        gap[:, m] = gaps[:2] + place[:, [m]] * gaps[2]
    pressure *= statuses.before & statuses.after
    gap *= statuses.free
    # Rates that are only rounding are zero: otherwise they would end a piece that has no end.
    for rate in (pressure[1], gap[1]):
        rate[np.abs(rate) <= ROUNDING * np.abs(rate).max(initial=0.0)] = 0.0
    low, high = _ends(part, place, pressure, gap, load_factor)
    return PathPiece(segment, place, pressure, gap, statuses, low, high)


def _place_of_event(pressures: Array, touching: Booleans) -> Array:
    """Load factor times the place of an event, where a node that opens or closes has no pressure.

    `pressures` (3, N) are the pressures at load factor 0, their rate with the load factor at the
    first corner of the segment, and their change along the segment.
    """
    node = int((touching * np.abs(pressures[2])).argmax())
    change = float(pressures[2, node])
    if not abs(change) > 0:
        raise NoPath("a node opens or closes without a change of its pressure")
    return -pressures[:2, node] / change


def _ends(
    part: Array, place: Array, pressure: Array, gap: Array, load_factor: float
) -> tuple[float, float]:
    """The load factors between which all positive pressures, gaps and distances stay positive."""
    last = np.roll(part == 0, -1)
    # The distance to the next instant; for the last instant of a segment, to the end of the
    # segment.
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
