"""A transient from increment to increment."""

from collections.abc import Iterator, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...contact import ContactState, ContactSystem, LoadCycle
from ...contact.checks import Array, whole_number
from ...contact.parts import joined, parted
from ...contact.tolerances import ROUNDING
from ...errors import ModelError
from ..begin import OPEN, STICK, Transient
from .sliding import check_sliding

__all__ = ["ENGINES", "Point", "SteppedPath", "doubts", "step_counts"]

ENGINES = MappingProxyType({"newton": "NewtonIncrement", "qp": "FrozenBoundIncrement", "milp": "ExactIncrement"})
"""Ways to solve an increment, and the names of their classes."""


class Point(NamedTuple):
    """One state: load, `u = [v, w - g0]`, reactions (M,); status; and since the state before the work of friction and the way slid against it."""

    bonded: Array
    u: Array
    r: Array
    status: np.ndarray[Any, np.dtype[np.int8]]
    work: Array
    way: Array


class SteppedPath(Transient):
    """States of a transient, a number of increments from corner to corner.

    Parameters
    ----------
    system, cycle, friction, load_factor, initial_slip, initial_state
        See `Transient`.
    engine
        A key of `ENGINES`.
    steps
        Number of increments from corner to corner.

    Attributes
    ----------
    state
        The present state.
    events
        Number of changes of status so far.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: ArrayLike,
        load_factor: float,
        initial_slip: ArrayLike | None,
        initial_state: ContactState | None,
        engine: str,
        steps: int,
    ) -> None:
        super().__init__(system, cycle, friction, load_factor, initial_slip, initial_state)
        from .. import increments  # here, because the exact path does not need cvxpy

        self._increment, self.steps = getattr(increments, ENGINES[engine])(system, self.friction), steps
        check_sliding(system, self.friction, {"the mean load": self.mean} | {f"the load at corner {k}": r for k, r in enumerate(self.corners)})
        if not np.abs(self.mean[-self.nodes :]).max() > 0:
            raise ModelError("mean: the mean load has no normal reactions, and a transient starts from it; give `cycle.mean` a load that presses")
        u, r, opened = self._start
        self.state = self._point(self.bonded, u, r, np.where(opened, OPEN, STICK))
        self.events = 0

    def _point(self, bonded: Array, u: Array, r: Array, status: np.ndarray) -> Point:
        return Point(bonded, u, r, status.astype(np.int8), np.zeros(self.nodes), np.zeros(self.nodes))

    def slip(self, point: Point) -> Array:
        """The slip of a state."""
        return parted(point.u, self.system.tangents + 1)[0]

    def follow_to(self, load: Array) -> Iterator[Point]:
        """The states on the straight way to other bonded reactions; the last one stays.

        Raises
        ------
        SolverError
            An increment has no valid answer.
        """
        start = self.state.bonded
        for step in range(1, self.steps + 1):
            before, bonded = self.state, start + step / self.steps * (load - start) if step < self.steps else load
            new = self._moved(bonded, self.slip(before))
            moved = np.linalg.norm((new.u - before.u).reshape(-1, self.nodes)[:-1], axis=0) * (new.status != OPEN)
            self.events += int((new.status != before.status).sum())
            bound = self.friction * (before.r + new.r)[-self.nodes :] / 2
            self.state = new._replace(work=bound * moved, way=np.where(bound > ROUNDING * self.largest, moved, 0.0))
            yield self.state

    def moved_to(self, slip: Array) -> None:
        """Put the contact at another slip, under the load at hand; where that is beyond the law, it slips at once."""
        self.state = self._moved(self.state.bonded, slip)

    def _moved(self, bonded: Array, slip: Array) -> Point:
        new = self._increment.solve(slip, parted(bonded, self.system.tangents + 1))
        return self._point(bonded, joined(new.slip, new.gap - self.system.gap), joined(new.q, new.p), new.status)


def step_counts(steps: int) -> list[int]:
    """The numbers of increments from corner to corner that tell the error of the first one: itself, a half and a quarter of it."""
    whole_number("steps", steps, least=1)
    return sorted({steps, max(1, steps // 2), max(1, steps // 4)}, reverse=True)


def doubts(friction: Array, points: Sequence[Point]) -> tuple[Array, Array, Array]:
    """Two works (T - 1, N) that the ends of increments leave in doubt, and the mean friction bound, from T states.

    The first one is what the loads lack for the work of friction: a node that sticks in a part of an increment, or slips to and fro, is below its
    bound there. The second one is the change of the bound along the way. Both are zero where a node slips all the time, or its bound stays: there
    the increment is exact. They see events that lie so close to a corner that no number of increments parts them.
    """
    u, r = (np.array([getattr(point, name).reshape(-1, len(friction)) for point in points]) for name in ("u", "r"))
    closed = np.array([point.status for point in points[1:]]) != OPEN
    moved, q, bound = np.diff(u[:, :-1], axis=0), r[:, :-1], friction * r[:, -1]
    way, mean = np.linalg.norm(moved, axis=1) * closed, (bound[1:] + bound[:-1]) / 2
    lacking = mean * way + ((q[1:] + q[:-1]) / 2 * moved).sum(axis=1) * closed
    return np.maximum(lacking, 0.0), np.abs(np.diff(bound, axis=0)) * way, mean
