"""Reactions of a load cycle on a closed contact."""

from dataclasses import dataclass, field

import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.coulomb import lengths
from ..contact.cycle import checked_cycle
from ..contact.system import checked_system
from ..contact.tolerances import NO_PRESSURE

__all__ = ["Loads", "change", "cycle_loads"]


@dataclass(frozen=True, eq=False)
class Loads:
    """Closed reactions of a load cycle, force: `q0` (K, N) or (K, N, 2) and `p0` (K, N) at load factor 0; what a load factor of 1 adds, `q1`, `p1`.

    Of a contact without its O open nodes also their gaps where nothing slips, length: `w0` and `w1`, (K, O). Where all corners have the same at load
    factor 0, `q0`, `p0` and `w0` have one row, (1, N) and (1, O).
    """

    q0: Array
    p0: Array
    q1: Array
    p1: Array
    w0: Array = field(default_factory=lambda: np.zeros((1, 0)))
    w1: Array = field(default_factory=lambda: np.zeros((1, 0)))

    @property
    def corners(self) -> int:
        """Number of corners, K."""
        return len(self.q1)

    @property
    def fixed(self) -> bool:
        """Whether the corners differ at load factor 0."""
        return len(self.q0) > 1

    @property
    def force(self) -> float:
        """Mean normal force of the mean load (or a force of the same size where there is none)."""
        sizes = lengths(self.q0, self.p0), lengths(self.q1, self.p1), np.abs(self.p1)
        return float(np.abs(self.p0).mean() or max(size.mean() for size in sizes) or 1.0)

    def units(self, force: float) -> Array:
        """(N,) force unit of each node under loads of the size of `force`: its pressure under the mean load, or what else acts on it."""
        pressure, others = np.abs(self.p0).max(axis=0), np.maximum(lengths(self.q1, self.p1), np.abs(self.p1)).max(axis=0)
        others = np.maximum(lengths(self.q0, self.p0).max(axis=0), others)
        return np.asarray(np.where(pressure > NO_PRESSURE * force, pressure, np.maximum(others, NO_PRESSURE * force)))

    def load_factor_unit(self, friction: Array, force: float) -> float:
        """Load factor at which the cyclic reactions reach the size of the mean friction bound (of the force scale where there is none)."""
        demand = float(lengths(self.q1, self.p1).mean() + (friction * np.abs(self.p1)).mean())
        demand += float(np.abs(self.p1[:, friction == 0]).sum()) / len(friction)
        bound = float((friction * np.abs(self.p0)).mean()) or force
        return bound / demand if demand > 0 else 1.0

    def under_slip(self, system: ContactSystem, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Reactions `q, p` of the closed contact at the corners, with K in front, under a residual slip."""
        q, p = change(system, slip)
        return self.q0 + q + load_factor * self.q1, self.p0 + p + load_factor * self.p1


def change(system: ContactSystem, slip: Array) -> tuple[Array, Array]:
    """Reactions `A v, B v` that a residual slip, (N,) or (N, 2), adds to those of the closed contact."""
    v = slip.T.ravel()
    return (system.A @ v).reshape(slip.T.shape).T, system.B @ v


def cycle_loads(system: ContactSystem, cycle: LoadCycle) -> Loads:
    """Reactions of a load cycle on a system.

    Raises
    ------
    ModelError
        Wrong types, or load cases that the system does not have.
    """
    checked_system(system)
    checked_cycle(cycle)
    return Loads(*cycle.unscaled_reactions(system), *cycle.corner_reactions(system))
