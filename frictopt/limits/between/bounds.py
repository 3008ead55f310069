"""Bounds of the limit that rough states and rough multipliers prove, by a few products each.

From below: the safe points (load factor, residual shear) are convex. On the way from a safe point
to a rough one, the last safe point is found row by row.

From above: multipliers y of the shear and z >= |y| of the bounds prove, for every safe point,

    value - load factor * drive + residual shear . stress >= 0.

They prove a bound if the stress is 0. To make it so, the stress is taken from y, and z is raised to
|y|. This changes the stress by T' dz with |dz| <= |stress|: if the norm of friction times T is
below 1, the stress falls by this factor each time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...base import Array
from ...contact.law import reach
from .cones import Cones, Point, towards

# Shares of the way from the best point to the first one at which a search of a better begins. At
# the best point itself, the rows that limit it may forbid every step.
_BACK = (0.5, 0.1, 0.01, 0.0)
# A load factor above so many units seems to grow without end; the exact program decides it.
_FAR = 1e4
# Share to which rough products reduce a stress before an exact product measures it.
_REFRESH = 1e-3


class SafePoints:
    """The best safe point so far; `grows` if the load factor may grow from it without end."""

    def __init__(self, cones: Cones) -> None:
        self._cones = cones
        self._first: Point | None = None
        self.best: Point | None = None
        self.grows = False

    @property
    def load_factor(self) -> float:
        """The largest load factor that is proven to be safe."""
        return -np.inf if self.best is None else self.best.load_factor

    def try_towards(self, rough: Point) -> None:
        """Go from the safe points towards a rough one as far as the rows allow, and then up."""
        if self._first is None or self.best is None:
            if margins(rough.rows).min() >= 0:
                self.best = rough
                self._rise(rough)
                # A point below the end has room in all directions.
                self._first = towards(rough, self.best, 0.5)
            return
        start = self.best
        for share in _BACK:
            base = towards(start, self._first, share)
            length = _reach(base.rows, rough.rows - base.rows)
            # Beyond the rough point nothing is known to be better.
            self._rise(towards(base, rough, min(length, 1.0)))

    def _rise(self, point: Point) -> None:
        """Keep the point of the same residual shear with the largest load factor, if it is best."""
        rate = self._cones.rate
        more = _reach(point.rows, rate)
        self.grows |= point.load_factor + more > _FAR
        if np.isfinite(more) and point.load_factor + more > self.load_factor:
            self.best = Point(point.load_factor + more, point.shear, point.rows + more * rate)


def margins(rows: Array) -> Array:
    """(K, R) distances of the sides (K, t + 1, R) of rows from their bounds, >= 0 if they obey."""
    return np.asarray(rows[:, -1] - np.linalg.norm(rows[:, :-1], axis=1))


def _reach(rows: Array, direction: Array) -> float:
    """How far one can go from sides that obey all rows in a direction; inf without an end."""
    q0, q1 = (np.moveaxis(sides[:, :-1], 1, -1) for sides in (rows, direction))
    return float(reach(q0, rows[:, -1], q1, direction[:, -1]).min().clip(0.0))


class Multipliers(NamedTuple):
    """Moves (K, t + 1, R) of the rows, of unit drive, and the load factor above which none is safe.

    The bound is inf if they prove none, and below 0 if no load factor is safe.
    """

    moves: Array
    bound: float


def raised(moves: Array) -> Array:
    """Moves (K, t + 1, R) whose lifts are at least the sizes of the slips, as a proof needs."""
    lifts = np.maximum(moves[:, -1], np.linalg.norm(moves[:, :-1], axis=1))
    return np.concatenate([moves[:, :-1], lifts[:, None]], axis=1)


def mechanism(cones: Cones, moves: Array, rounds: int, enough: float, usable: float) -> Multipliers:
    """Rough multipliers as a mechanism, by at most so many rough products.

    `enough` is the sum of the stresses, relative to the largest move, at which the rounds end. With
    more than `usable` they prove nothing, because residual shear may be larger than its unit.
    """
    rough = cones.roughly()
    closed = cones.sheared_parts[0]
    node = cones.node[closed]
    moves = raised(moves)
    stress = cones.stress(moves)
    while rounds > 0 and np.abs(stress).sum() > enough * np.abs(moves).max():
        first, last = moves, stress
        # Of small changes, rough products are exact enough until the stress has fallen.
        while rounds > 0 and np.abs(last).sum() > _REFRESH * np.abs(stress).sum():
            moves = moves.copy()
            moves[:, :-1, closed] -= last[:, node] / len(moves)
            moves = raised(moves)
            last = stress + rough.stress(moves - first)
            rounds -= 1
        stress = cones.stress(moves)
    if np.abs(stress).sum() > usable * np.abs(moves).max():
        return Multipliers(moves, np.inf)
    # The stress does work on residual shear of up to `Question.force` at each node.
    value = float((moves * cones.start).sum() + np.abs(stress).sum())
    drive = -float((moves * cones.rate).sum())
    if drive > 0:
        return Multipliers(moves / drive, value / drive)
    return Multipliers(moves, -np.inf if value < 0 else np.inf)
