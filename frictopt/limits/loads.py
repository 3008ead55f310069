"""Reactions of a load cycle on a closed contact."""

from dataclasses import dataclass

import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.coulomb import lengths
from ..contact.cycle import checked_cycle
from ..contact.symmetry import Part
from ..contact.system import checked_system

__all__ = ["Loads", "cycle_loads", "load_factor_unit"]


@dataclass(frozen=True, eq=False)
class Loads:
    """Closed reactions of a load cycle, force: mean `q0` (N,) or (N, 2) and `p0` (N,), corners at load factor 1 `q1`, `p1` with K in front."""

    q0: Array
    p0: Array
    q1: Array
    p1: Array

    @property
    def corners(self) -> int:
        """Number of corners, K."""
        return len(self.q1)

    def of(self, part: Part) -> "Loads":
        """The reactions of the nodes of a part of the contact."""
        return Loads(part.of(self.q0), part.of(self.p0), part.of(self.q1), part.of(self.p1))

    @property
    def force(self) -> float:
        """Mean normal force of the mean load (or a force of the same size where there is none)."""
        sizes = lengths(self.q0, self.p0), lengths(self.q1, self.p1), np.abs(self.p1)
        return float(np.abs(self.p0).mean() or max(size.mean() for size in sizes) or 1.0)


def cycle_loads(system: ContactSystem, cycle: LoadCycle) -> Loads:
    """Reactions of a load cycle on a system.

    Raises
    ------
    ModelError
        Wrong types, or load cases that the system does not have.
    """
    checked_system(system)
    checked_cycle(cycle)
    return Loads(*cycle.mean_reaction(system), *cycle.corner_reactions(system))


def load_factor_unit(loads: Loads, friction: Array, force: float) -> float:
    """Load factor at which the cyclic reactions reach the size of the mean friction bound (of the force scale where there is none)."""
    demand = float(lengths(loads.q1, loads.p1).mean() + (friction * np.abs(loads.p1)).mean())
    demand += float(np.abs(loads.p1[:, friction == 0]).sum()) / len(friction)
    bound = float((friction * np.abs(loads.p0)).mean()) or force
    return bound / demand if demand > 0 else 1.0
