"""States of rest, proven by the exact path: nothing slips through a whole cycle, though nodes may open and close."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.answers import Outcome
from ..contact.checks import Array, frozen
from ..contact.tolerances import RESIDUAL, TOUCHING
from ..errors import FrictoptError
from ..transients import steady_state
from ..transients.march import march

__all__ = ["Question", "Rest"]

_MOST_CYCLES = 200  # that a transient gets to come to rest

Booleans = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


@dataclass(frozen=True, eq=False)
class Rest:
    """A state of rest at a load factor.

    Attributes
    ----------
    load_factor
        The load factor.
    slip, gap
        (K, N) at the corners, length.
    state
        The state at the last corner.
    residual
        Largest violation of the contact law, and of the balance of energy along the path.
    followed
        Whether the exact path from it rests; else it is proven at the corners, where no node changes its status between them.
    """

    load_factor: float
    slip: Array
    gap: Array
    state: ContactState
    residual: float
    followed: bool = True

    @property
    def open(self) -> Booleans:
        """(K, N) which nodes are open at the corners."""
        return self.gap > 0


@dataclass(frozen=True, eq=False)
class Question:
    """A contact, its load cycle and (N,) coefficients of friction, of which states of rest are asked."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array

    def load(self, load_factor: float, corner: int) -> tuple[Array, Array]:
        """Bonded reactions `q, p` (N,) at a corner."""
        (q0, p0), (q1, p1) = self.system.reaction(self.cycle.mean), self.cycle.corner_reactions(self.system)
        return q0 + load_factor * q1[corner], p0 + load_factor * p1[corner]

    def reactions(self, rest: Rest) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners, by the balance alone: those of open nodes are zero up to rounding."""
        both = self._bonded(rest) + np.hstack([rest.slip, rest.gap - self.system.gap]) @ self.system.S
        return both[:, : self.system.nodes], both[:, self.system.nodes :]

    def touching(self, rest: Rest) -> Booleans:
        """(K, N) which nodes are at the corners neither open nor pressed by more than what could be rounding."""
        _, p = self.reactions(rest)
        force = float(np.abs(self._bonded(rest)).max()) or 1.0
        return np.maximum(rest.gap * self.system.stiffness_scale, np.abs(p)) < TOUCHING * force

    def _bonded(self, rest: Rest) -> Array:
        """(K, 2N) bonded reactions at the corners."""
        return np.array([np.concatenate(self.load(rest.load_factor, corner)) for corner in range(len(rest.gap))])

    def state(self, load_factor: float, slip: Array, gap: Array) -> ContactState:
        """The state with slip and gap (N,) at the last corner."""
        return ContactState(slip, gap, *self.load(load_factor, -1))

    def proven_at_corners(self, load_factor: float, slip: Array, gap: Array, residual: float) -> Rest:
        """A state of rest whose nodes are open at all corners or at none."""
        return Rest(load_factor, frozen(slip), frozen(gap), self.state(load_factor, slip[-1], gap[-1]), residual, followed=False)

    def rest(self, load_factor: float, **begin: Any) -> Rest | None:
        """The state of rest that the transient from a start comes to; None if it does not, or its path is not proven."""
        asked = self.system, self.cycle, self.friction, load_factor
        try:
            steady = steady_state(*asked, **begin, most_cycles=_MOST_CYCLES)
            if steady.outcome is not Outcome.SHAKEDOWN:
                return None
            path = march(*asked, initial_state=steady.state, cycles=1)
        except FrictoptError:  # the path ends, is not proven, or the start obeys the law too little
            return None
        forces = float(np.abs(np.r_[path.bonded_q, path.bonded_p]).max())
        if path.cycle_work.max() > RESIDUAL * forces**2 / self.system.stiffness_scale:
            return None
        rows = [int(np.flatnonzero(path.time == corner)[-1]) for corner in range(1, path.corners + 1)]
        slip, gap = frozen(path.slip[rows]), frozen(np.maximum(path.gap[rows], 0.0))
        return Rest(load_factor, slip, gap, path.state_at(-1), max(steady.residual, path.residual))
