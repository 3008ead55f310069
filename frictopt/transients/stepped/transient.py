"""A transient in three dimensions, from increment to increment."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...contact import LoadCycle
from ...contact.checks import Array, finite_array, finite_number, whole_number
from ...contact.cycle import checked_cycle
from ...contact.parts import joined, parted
from ...contact.system import ContactSystem
from ...contact.tolerances import ROUNDING
from ...errors import ModelError
from ..increments.increments import Increments3D
from ..increments.projected import OPEN
from .sliding import check_sliding

__all__ = ["Point3D", "Transient3D", "doubts", "step_counts"]


@dataclass(frozen=True, eq=False)
class Point3D:
    """One state of a transient: load, slip, gap, reactions, status, and since the state before the work of friction and the way slid against it."""

    bonded: Array
    slip: Array
    gap: Array
    q: Array
    p: Array
    status: np.ndarray[Any, np.dtype[np.int8]]
    work: Array
    way: Array


class Transient3D:
    """States from an initial slip on, a number of increments from corner to corner.

    It starts at an artificial load that carries the initial slip with q = 0 and, at every node, p equal to the mean of |p^w| under the mean load.

    Parameters
    ----------
    system, cycle, friction, load_factor, initial_slip
        See `frictopt.march`.
    engine
        "newton" or "socp".
    steps
        Number of increments from corner to corner.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: Any, initial_slip: Any, engine: str, steps: int) -> None:
        self._increments = Increments3D(system, friction, engine=engine)
        self.system, self.friction, self.steps = system, self._increments.friction, steps
        factor = finite_number("load_factor", load_factor, least=0.0)
        slip = np.zeros((system.nodes, 2)) if initial_slip is None else finite_array("initial_slip", initial_slip, (system.nodes, 2))
        self.mean = joined(*system.reaction(checked_cycle(cycle).mean))
        self._cyclic = joined(*cycle.corner_reactions(system))
        self.corners = self.corners_at(factor)
        check_sliding(system, self.friction, {"the mean load": self.mean} | {f"the load at corner {k}": r for k, r in enumerate(self.corners)})
        self.pressure = pressure = float(np.abs(parted(self.mean, 3)[1]).mean())
        if not pressure > 0:
            raise ModelError("mean: the mean load has no normal reactions, and a transient starts from it; give `cycle.mean` a load that presses")
        self.force = max(pressure, *(float(np.abs(corner).max()) for corner in self.corners))
        q, p = np.zeros((system.nodes, 2)), np.full(system.nodes, pressure)
        load = joined(q, p) - system.S @ joined(slip, -system.gap)
        none = np.zeros(system.nodes)
        self.state = Point3D(load, slip, none, q, p, np.zeros(system.nodes, dtype=np.int8), none, none)

    @property
    def length(self) -> float:
        """Scale of slips: that of forces over that of the stiffness."""
        return self.force / self.system.stiffness_scale

    def corners_at(self, load_factor: float) -> list[Array]:
        """Bonded reactions (3N,) at the corners at another load factor."""
        return [self.mean + load_factor * corner for corner in self._cyclic]

    def follow_to(self, load: Array) -> Iterator[Point3D]:
        """The states on the straight way to other bonded reactions; the last one stays.

        Raises
        ------
        SolverError
            An increment has no valid answer.
        """
        start = self.state.bonded
        for step in range(1, self.steps + 1):
            before, bonded = self.state, start + step / self.steps * (load - start) if step < self.steps else load
            new = self._increments.solve(before.slip, parted(bonded, 3))
            moved = np.linalg.norm(new.slip - before.slip, axis=1) * (new.status != OPEN)
            bound = self.friction * (before.p + new.p) / 2
            way = np.where(bound > ROUNDING * self.force, moved, 0.0)
            self.state = Point3D(bonded, new.slip, new.gap, new.q, new.p, new.status, bound * moved, way)
            yield self.state

    def moved_to(self, slip: Array) -> None:
        """Put the contact at another slip, under the load at hand; where that is beyond the law, it slips at once."""
        new = self._increments.solve(slip, parted(self.state.bonded, 3))
        self.state = Point3D(self.state.bonded, new.slip, new.gap, new.q, new.p, new.status, *[np.zeros(self.system.nodes)] * 2)


def step_counts(steps: Any) -> list[int]:
    """The numbers of increments from corner to corner that tell the error of the first one: itself, a half and a quarter of it."""
    whole_number("steps", steps, least=2)
    return sorted({steps, steps // 2, max(1, steps // 4)}, reverse=True)


def doubts(friction: Array, slip: Array, q: Array, p: Array, status: np.ndarray) -> tuple[Array, Array, Array]:
    """Two works (T - 1, N) that the ends of increments leave in doubt, and the mean friction bound, from states (T, ...) and statuses (T - 1, N).

    The first one is what the loads lack for the work of friction: a node that sticks in a part of an increment, or slips to and fro, is below its
    bound there. The second one is the change of the bound along the way. Both are zero where a node slips all the time, or its bound stays: there
    the increment is exact. They see events that lie so close to a corner that no number of increments parts them.
    """
    moved, closed = np.diff(slip, axis=0), status != OPEN
    way, bound = np.linalg.norm(moved, axis=-1) * closed, friction * p
    mean = (bound[1:] + bound[:-1]) / 2
    lacking = mean * way + ((q[1:] + q[:-1]) / 2 * moved).sum(axis=-1) * closed
    return np.maximum(lacking, 0.0), np.abs(np.diff(bound, axis=0)) * way, mean
