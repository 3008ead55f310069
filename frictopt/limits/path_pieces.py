"""Pressures and gaps along a load cycle as functions of the load factor.

If the load factor scales normal loads, events change their places with it. A *piece* is an interval
of load factors at which nodes open and close in one order. There pressures and gaps at the instants
are affine in the load factor, and so is the place of each event times the load factor (theory,
"Normal loads that are scaled, too"). The next piece begins where a pressure or a gap of an instant
comes to zero, or where two instants meet.
"""

from dataclasses import dataclass

import numpy as np

from ..base import ROUNDING, Array, Booleans, Integers
from .normal_path import NoPath, NormalPath, normal_path, states
from .rim import Statuses


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
    return np.asarray(-pressures[:2, node] / change)


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
