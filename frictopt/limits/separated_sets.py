"""Sets of nodes that may stay open, tried outward from none and from those that the mean load opens: one linear program for each."""

import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..errors import FrictoptError
from .open_sets import Booleans, OpenSetLimit, open_set_limit, opened_by

__all__ = ["OpenSets"]

_FURTHER = 16  # sets tried outward from one that no load factor keeps


class OpenSets:
    """The search for the open nodes with the largest limit.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle and (N,) coefficients of friction.

    Attributes
    ----------
    best
        The limit of the best set; None if no load factor keeps one of those tried.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, friction: Array) -> None:
        self._task = system, cycle, friction
        self.best: OpenSetLimit | None = None
        self._values: dict[bytes, float] = {}

    @property
    def value(self) -> float:
        """Largest load factor of all sets tried; -inf if there is none."""
        return -np.inf if self.best is None else self.best.load_factor

    def run(self) -> None:
        """Try sets until no neighbour is better or some set has no limit."""
        system, cycle, _ = self._task
        for first in (np.zeros(system.nodes, dtype=bool), opened_by(system, cycle.mean)):
            self._outward(first)

    def _outward(self, opened: Booleans) -> None:
        """From a set to the best of its neighbours, as long as one is better; from a set without a limit to sets further off."""
        value, waiting = self._try(opened), [opened]
        for _ in range(_FURTHER):
            if not waiting:
                return
            opened = waiting.pop(0)
            others = [other for other in _neighbours(opened) if other.tobytes() not in self._values]
            for other in others:
                if self._try(other) > value:
                    value, waiting = self._values[other.tobytes()], [other]
            if value == -np.inf:
                waiting += others

    def _try(self, opened: Booleans) -> float:
        """Largest load factor with these nodes open and no others; -inf if there is none, or no answer that passes the checks."""
        key = opened.tobytes()
        if key not in self._values and self.value < np.inf:
            try:
                limit = open_set_limit(*self._task, opened)
            except FrictoptError:
                limit = None
            self._values[key] = -np.inf if limit is None else limit.load_factor
            if limit is not None and limit.load_factor > self.value:
                self.best = limit
        return self._values.get(key, -np.inf)


def _neighbours(opened: Booleans) -> list[Booleans]:
    """Sets whose border lies one node further, on one side or on both."""
    edges, others = np.flatnonzero(np.diff(opened.astype(int))), []
    for node in sorted({*edges.tolist(), *(edges + 1).tolist()}):
        for flipped in ([node, -1 - node], [node]):
            other = opened.copy()
            other[flipped] = ~opened[node]
            others.append(other)
    return others
