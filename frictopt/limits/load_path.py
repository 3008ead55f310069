"""The path of a load cycle: on a line or around an area, and where nodes can open and close.

If all corners lie on a line, the states of rest along one leg between its two ends are a function
of the load (theory, "Nodes that open and close in each cycle"). So the two ends represent all
turning points between them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from ..base import RESIDUAL, ROUNDING, Array, Booleans
from ..contact import LoadCycle
from .corners import outer_corners
from .question import Question

# Two legs are one line if their distance is below this share of their length.
_SAME_LINE = 1e-9


@dataclass(frozen=True)
class LoadPath:
    """The corners that the load visits, in order: `stops`.

    A path on a line goes from one end to the other, and comes back the same way: it has two stops.
    Another path visits all corners, and returns to the first one.
    """

    stops: tuple[int, ...]

    @property
    def closed(self) -> bool:
        """Whether the path returns to its first corner along another path."""
        return self.stops[0] == self.stops[-1]

    @property
    def legs(self) -> list[tuple[int, int]]:
        """First and last corner of each straight leg."""
        return list(pairwise(self.stops))


def path_of(cycle: LoadCycle) -> LoadPath | None:
    """The path of a load cycle; None for a static load."""
    corners = outer_corners(cycle)
    if len(corners) == 1:
        return None
    if len(corners) == 2:
        return LoadPath(tuple(corners))
    return LoadPath((*range(len(cycle.corners)), 0))


def ends_of(cycle: LoadCycle, path: LoadPath) -> LoadCycle:
    """The load cycle to and fro between the stops of a path on a line."""
    fixed = None
    if cycle.fixed is not None:
        fixed = [cycle.fixed[k] for k in path.stops]
    return LoadCycle(cycle.mean, [cycle.corners[k] for k in path.stops], fixed)


def places_on(question: Question, path: LoadPath) -> Array:
    """(K,) places of the corners on a path, see `LiftOff.way`."""
    if path.closed:
        return np.arange(len(question.r1), dtype=float)
    first, last = path.stops
    load = np.hstack([part for part in question.bonded if len(part) > 1])
    along = load[last] - load[first]
    return np.asarray((load - load[first]) @ along / (along @ along))


def meets_mean_load(question: Question, path: LoadPath) -> bool:
    """Whether the load goes through the mean load on a line, at every load factor.

    Then the states of rest at a load factor contain the states of rest at every smaller load
    factor.
    """
    if path.closed or question.fixed:
        return False
    first, last = (question.bonded[1][k] for k in path.stops)
    sizes = np.linalg.norm(first), np.linalg.norm(last)
    return bool(np.abs(sizes[1] * first + sizes[0] * last).max() <= ROUNDING * sizes[0] * sizes[1])


def has_static_shear(question: Question, load_factor: float) -> bool:
    """Whether the shear force of each node is the same at all corners."""
    static = question.r0[:, :-1]
    cyclic = load_factor * question.r1[:, :-1]
    largest = max(np.abs(static).max(), np.abs(cyclic).max())
    return bool(np.ptp(static + cyclic, axis=0).max() <= RESIDUAL * largest)


def may_open_and_close(question: Question, path: LoadPath | None) -> bool:
    """Whether some node can open and close in a state of rest, other than by chance.

    The bonded reactions of a node are equal at its closing and at its opening, if nothing else
    opens or closes in between (theory, "Where events can gain"). So they must return along the same
    path: on a line, or on two legs. This assumes that no other node is open.
    """
    if path is None:
        return False
    if not path.closed:
        return True
    return any(bool(_retraced(a, b, c, d).any()) for a, b, c, d in _pairs_of_legs(question, path))


def _pairs_of_legs(
    question: Question, path: LoadPath
) -> Iterator[tuple[Array, Array, Array, Array]]:
    """Bonded reactions (t + 1, N) at the ends of two legs, for each pair of legs."""
    system = question.system
    loads = question.bonded[0] + question.load_unit * question.bonded[1]
    at_corner = loads.reshape(len(question.bonded[1]), system.tangents + 1, system.nodes)
    for (a, b), (c, d) in combinations(path.legs, 2):
        yield at_corner[a], at_corner[b], at_corner[c], at_corner[d]


def _retraced(a: Array, b: Array, c: Array, d: Array) -> Booleans:
    """(N,) at which nodes the legs a to b and c to d run along each other for a while."""
    along = b - a
    size = (along**2).sum(axis=0)
    unit = np.where(size > 0, size, 1.0)
    off = np.zeros_like(size)
    places = []
    for point in (c, d):
        place = ((point - a) * along).sum(axis=0) / unit
        off = np.maximum(off, ((point - a - place * along) ** 2).sum(axis=0))
        places.append(place)
    low, high = np.minimum(*places), np.maximum(*places)
    common = np.minimum(high, 1.0) - np.maximum(low, 0.0)
    return np.asarray((size > 0) & (off <= _SAME_LINE**2 * size) & (common > _SAME_LINE))
