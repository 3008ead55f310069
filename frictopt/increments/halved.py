"""One friction increment of a mirror-symmetric contact, from the increment of its half."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array
from ..contact.mirror import EXACT, EXACT_LOAD, MirrorHalf, is_mirror_symmetric, mirror_half
from ..errors import NoContinuation, SolverError
from ..solve.solvers import TOLERANCE
from .increment import Increment, Law, PosedIncrement
from .newton import State

__all__ = ["HalvedIncrement"]


class _Engine(Protocol):
    def solve(self, slip: Any, bonded: Any) -> Increment: ...


class HalvedIncrement:
    """Increments of the half, where the contact, its slip and its load are mirror-symmetric.

    Parameters
    ----------
    law
        Stiffness and friction of the whole contact.
    engine
        Makes an engine from system and friction.
    """

    def __init__(self, law: Law, engine: Callable[[ContactSystem, Array], _Engine]) -> None:
        self._law, self._new_engine = law, engine
        self._engine: _Engine | None = None

    def solve(self, title: str, posed: PosedIncrement) -> Increment | None:
        """A mirror-symmetric state after the increment; None where there may be none, or none is found."""
        half = mirror_half(self._law.system, self._law.friction)
        if half is None or not self._is_symmetric(posed):
            return None
        if self._engine is None:
            self._engine = self._new_engine(half.system, half.nodal(self._law.friction))
        slip, load = half.odd(posed.slip), half.forces(np.r_[posed.bonded_q, posed.bonded_p])
        try:
            found = self._engine.solve(slip, (load[: half.nodes], load[half.nodes :]))
        except (NoContinuation, SolverError):  # states that are not symmetric may exist
            return None
        return self._whole(title, posed, half, found, slip)

    def _is_symmetric(self, posed: PosedIncrement) -> bool:
        slip = posed.slip
        if np.abs(slip + slip[::-1]).max() > EXACT * np.abs(slip).max():
            return False
        return is_mirror_symmetric(self._law.system, [(posed.bonded_q, posed.bonded_p)], self._law.friction, EXACT_LOAD)

    def _whole(self, title: str, posed: PosedIncrement, half: MirrorHalf, found: Increment, slip: Array) -> Increment | None:
        u = half.whole_motion(np.r_[found.slip - slip, found.gap]) / posed.length
        r = half.whole_forces(np.r_[found.q, found.p]) / posed.force
        state = State(np.zeros(self._law.nodes, dtype=np.int8), u, r)
        text = f"mirror symmetry: v is odd, {half.nodes} of {self._law.nodes} nodes are in the program"
        result = posed.result(title, state, found.sweeps, found.solver, found.attempts, (text, *found.left_out), found.problem)
        return replace(result, _units=found._units) if result.residual <= TOLERANCE else None
