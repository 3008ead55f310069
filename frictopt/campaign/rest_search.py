"""The search for the largest load factor with a state of rest: over sets of nodes that stay open, and upward along the exact path."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..contact.symmetry import halve
from ..contact.tolerances import GAIN
from ..errors import FrictoptError
from ..limits.open_sets import OpenSetLimit, open_set_limit
from ..limits.separated import CornerStates, SeparatedProblem
from ..transients.march import march
from .rest import Booleans, Question, Rest

__all__ = ["RestSearch"]

_STEPS = (1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4)  # by which the load factor is raised, relative
_FIRST = (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4)  # load factors to begin with, in load units
_HALVINGS = 14  # of the way from a state that rests to one that may not
_FAR = 1e6  # load factor, in load units, above which none is tried
_TOUCHING = 4  # touching nodes that are let go or held one by one
_SETS = 16  # sets that are tried from one that no load factor keeps


class RestSearch:
    """Looks for states of rest at ever larger load factors, with a number of linear programs and transients.

    Attributes
    ----------
    best
        The one with the largest load factor so far; None if there is none.
    left
        Programs and transients that are left.
    endless_set
        The limit of a set of nodes that rests open at every load factor from some on; None if none is known.
    """

    def __init__(self, question: Question, most_programs: int, tell: Callable[[str], None]) -> None:
        self.question, self.left, self.tell = question, most_programs, tell
        self.best: Rest | None = None
        self.endless_set: OpenSetLimit | None = None
        system, cycle = question.system, question.cycle
        mean, cyclic = np.abs(system.reaction(cycle.mean)).sum(), np.abs(cycle.corner_reactions(system)).sum(axis=(0, 2)).max()
        self.unit = float(mean / cyclic) if mean > 0 and cyclic > 0 else 1.0
        loads = cycle.mean_reaction(system), cycle.corner_reactions(system)
        self._mirror = halve(system, question.friction, loads) is not None
        self._known: dict[bytes, OpenSetLimit | None] = {}

    @property
    def over(self) -> bool:
        """Whether all programs are used up, or no larger load factor can be found."""
        return self.unbounded or self.endless or self.left <= 0

    @property
    def unbounded(self) -> bool:
        """Whether some set of nodes rests open at every load factor from some on."""
        return self.endless_set is not None

    @property
    def endless(self) -> bool:
        """Whether the contact rests at the largest load factor that is tried."""
        return self.least > _FAR * self.unit

    @property
    def least(self) -> float:
        """Largest load factor found, 0 if none."""
        return self.best.load_factor if self.best else 0.0

    def run(self) -> None:
        """Search by all means: sets outward from the state under the mean load, then upward from what they gave."""
        self.sets()
        self.tell("upward")
        for share in _FIRST if self.best is None else ():
            if not self.over and self.offer(self._rest(share * self.unit)):
                break
        if self.best is None:
            self.offer(self._rest(0.0))
        self.climb()

    def sets(self) -> None:
        """Search over sets of nodes that stay open, outward from the state under the mean load."""
        self.tell("open sets")
        for opened in self._first_sets():
            self._outward(opened)

    def offer(self, rest: Rest | None) -> bool:
        """Take a state of rest if it is better; returns whether it is."""
        if rest is None or (self.best is not None and rest.load_factor <= self.best.load_factor * (1 + GAIN)):
            return False
        self.best = rest
        self.tell(f"rests at {rest.load_factor:.6g}")
        return True

    def climb(self) -> None:
        """Raise the load factor as long as the transient from the best state, or one without slip, comes to rest again."""
        if self.best is None:
            return
        self._lift(self.best)
        while not self.over and any(self._step(step) for step in _STEPS):
            self._lift(self.best)

    def rise(self, states: CornerStates) -> bool:
        """Try a claimed state; returns whether it rests and is better."""
        return self.offer(self._from(states))

    def _step(self, step: float) -> bool:
        if self.over or self.best is None:
            return False
        load_factor = (self.best.load_factor or 1e-3 * self.unit) * (1 + step)
        begins: tuple[dict[str, Any], ...] = ({"initial_state": self.best.state}, {})
        return any(self.offer(self._rest(load_factor, **begin)) for begin in begins)

    def _lift(self, rest: Rest) -> None:
        """Raise the load factor with the same nodes open, and with those let go that only touch: up to where the corners allow it, or the path."""
        for opened in self._patterns(rest):
            states = None if self.over else self._highest(rest, opened)
            if states is not None and states.load_factor > self.least * (1 + GAIN) and not self.rise(states):
                self._between(rest, states)

    def _between(self, rest: Rest, states: CornerStates) -> None:
        """Rise as far as possible towards states that obey the law at the corners, but do not rest."""
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            share = (low + high) / 2
            slip, gap = (one + share * (other - one) for one, other in ((rest.slip, states.slip), (rest.gap, states.gap)))
            between = CornerStates(rest.load_factor + share * (states.load_factor - rest.load_factor), slip, gap)
            low, high = (share, high) if self.rise(between) else (low, share)

    def _patterns(self, rest: Rest) -> list[Booleans]:
        """The nodes (K, N) that are open at the corners; and with those open or closed that touch without pressure, all of them or one."""
        touching = self.question.touching(rest)
        found = [rest.open]
        for places in (touching, *(touching & (np.cumsum(touching).reshape(touching.shape) == count) for count in range(1, _TOUCHING + 1))):
            for open_ones in (False, True):
                pattern = np.where(places, open_ones, rest.open)
                if not any((pattern == other).all() for other in found):
                    found.append(pattern)
        return found

    def _highest(self, rest: Rest, opened: Booleans) -> CornerStates | None:
        asked = self.question
        try:
            if (opened == opened[0]).all():
                limit = self.limit_of(opened[0])
                return None if limit is None or self.unbounded else CornerStates(limit.load_factor, limit.slip, limit.gap)
            self.left -= 1
            most = 10 * max(rest.load_factor, 1e-3 * self.unit)
            return SeparatedProblem(asked.system, asked.cycle, asked.friction, most).with_open(opened)
        except FrictoptError:  # no answer that passes the checks
            return None

    def _rest(self, load_factor: float, **begin: Any) -> Rest | None:
        self.left -= 1
        return self.question.rest(load_factor, **begin)

    def _from(self, states: CornerStates) -> Rest | None:
        asked = self.question
        return self._rest(states.load_factor, initial_state=asked.state(states.load_factor, states.slip[-1], np.maximum(states.gap[-1], 0.0)))

    def _first_sets(self) -> Iterator[Booleans]:
        """Sets of nodes that may stay open: none, and those that the mean load leaves open."""
        asked = self.question
        yield np.zeros(asked.system.nodes, dtype=bool)
        try:
            yield march(asked.system, asked.cycle, asked.friction, 0.0, cycles=0).gap[-1] > 0
        except FrictoptError:
            return

    def _outward(self, opened: Booleans) -> None:
        """From a set to the best of its neighbours, as long as one is better; from a set without a state to sets further off."""
        value, waiting = self._value(opened), [opened]
        for _ in range(_SETS):
            if self.over or not waiting:
                return
            opened = waiting.pop(0)
            fresh = [other for other in self._neighbours(opened) if other.tobytes() not in self._known]
            for other in fresh:
                if not self.over and self._value(other) > value:
                    value, waiting = self._value(other), [other]
            if value == -np.inf and opened.any():
                waiting += fresh

    def _neighbours(self, opened: Booleans) -> list[Booleans]:
        """Sets whose border lies one node further: on both sides at once where the contact is its own mirror image."""
        edges = np.flatnonzero(np.diff(opened.astype(int)))
        found = []
        for node in sorted({*edges.tolist(), *(edges + 1).tolist()}):
            for flipped in ([node, -1 - node], [node]) if self._mirror else ([node],):
                other = opened.copy()
                other[flipped] = ~opened[node]
                found.append(other)
        return found

    def limit_of(self, opened: Booleans) -> OpenSetLimit | None:
        """The limit with these nodes (N,) open, and no others; None if there is none, or no answer that passes the checks."""
        key, asked = opened.tobytes(), self.question
        if key not in self._known:
            self.left -= 1
            try:
                self._known[key] = open_set_limit(asked.system, asked.cycle, asked.friction, opened)
            except FrictoptError:
                self._known[key] = None
            if (limit := self._known[key]) is not None and np.isinf(limit.load_factor):
                self.endless_set = limit
        return self._known[key]

    def _value(self, opened: Booleans) -> float:
        """Largest load factor with these nodes open, and no others; -inf if there is none. A better one is followed, to prove that it rests."""
        fresh, limit = opened.tobytes() not in self._known, self.limit_of(opened)
        if fresh and limit is not None and not self.unbounded:
            states = CornerStates(limit.load_factor, limit.slip, limit.gap)
            self.offer(self._from(states) or self.question.proven_at_corners(states.load_factor, states.slip, states.gap, limit.residual))
        return -np.inf if limit is None else limit.load_factor
