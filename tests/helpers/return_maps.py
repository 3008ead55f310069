"""Cycles of known maps, for the tests of steady states."""

from copy import copy
from types import SimpleNamespace

import numpy as np

from frictopt.contact import contact_law
from frictopt.transients.cycles import Run
from frictopt.transients.transient import FollowedCycle, Scales


class Mapped:
    """A transient whose cycles map the slips x by a given function instead of following a contact.

    Slips are in units of the slip scale. Pressures and friction are 1, so slips are safe if all
    shears `x + load` are at most 1.
    """

    steps, far_start, force, largest, length = 0, False, 1.0, 1.0, 1.0

    def __init__(self, cycle_map, start, *, loads=(-2.0, 2.0), events=lambda *x: 0):
        self.x = np.atleast_1d(np.array(start, dtype=float))
        self.nodes = n = len(self.x)
        self.scales, self.unit, self.friction = Scales(*np.ones((3, n))), np.ones(2 * n), np.ones(n)
        self.corners = [np.r_[np.full(n, load), np.ones(n)] for load in loads]
        self.system = SimpleNamespace(
            gap=np.zeros(n),
            nodes=n,
            capped=False,
            units=None,
            S=np.diag(np.r_[np.ones(n), np.zeros(n)]),
            tangents=1,
        )
        self.law = contact_law(self.system, self.friction)
        self._map, self._events = cycle_map, events

    def at(self, place):
        elsewhere = copy(self)
        elsewhere.x = place[: len(self.x)]
        return elsewhere

    def whole(self):
        return np.resize(np.r_[self.x, np.zeros_like(self.x)], 2 * self.nodes)

    def cycle_on(self, count):
        before, events, n, ends = self.whole(), self._events(*self.x), self.nodes, []
        for _ in range(count):
            self.x = np.atleast_1d(self._map(*self.x)).astype(float)
            ends.append(self.whole())
        u, change = np.array(ends), float(np.abs(ends[-1] - before).max())
        r = u @ self.system.S + np.r_[np.zeros(n), np.ones(n)]
        return FollowedCycle(
            before, ends[-1], change, np.ones(n), np.ones(n), [1.0] * count, events, 0 * r, u, r
        )


def settled(path, cycles):
    """Outcome, slips and run of the cycles of a map."""
    run = Run(path, cycles)
    found = run.settled()
    return found.outcome, found.cycle.after[: len(path.x)], run
