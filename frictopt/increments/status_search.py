"""Programs whose solution is read as a status of every node: the state that is claimed, and its correction."""

from collections.abc import Callable
from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from .increment import PosedIncrement
from .newton import State, Status, settle

__all__ = ["StateClaim", "StatusSearch"]

_CORRECTIONS = 3  # of statuses that a solver's tolerance gets wrong


@dataclass(frozen=True)
class StateClaim:
    """A state and its largest violation of the law."""

    state: State
    residual: float


class StatusSearch:
    """A program posed for one increment.

    Parameters
    ----------
    problem, posed
        The program with its parameters set, and the increment.
    status
        Reads the status of every node from the solution.
    separation
        Whether nodes may open.
    """

    def __init__(self, problem: cp.Problem, posed: PosedIncrement, status: Callable[[], Status], separation: bool = True) -> None:
        self.problem = problem
        self._posed, self._status, self._separation, self._corrections = posed, status, separation, 0

    def refine(self) -> None:
        """Let a status that its own state contradicts be corrected."""
        self._corrections = _CORRECTIONS

    def claim(self) -> StateClaim:
        """The exact state of the status that the solution shows, and what the referee says of it."""
        law = self._posed.law
        state = settle(law.S, law.friction, np.zeros(law.nodes), self._posed.trial, self._status(), self._corrections, self._separation)
        return StateClaim(state, self._posed.residual(state))
