"""What both engines of increments share: what is left out before a program is solved, and how its solution becomes a state."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import IO, Any, ClassVar

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem
from ..contact.checks import flag
from ..contact.mirror import EXACT, EXACT_LOAD, MirrorHalf, is_mirror_symmetric, mirror_half
from ..errors import NoContinuation, SolverError
from ..solve.explain import explain
from ..solve.solvers import TOLERANCE
from .increment import Increment, Law, PosedIncrement
from .newton import State, Status, settle, sticking

__all__ = ["CORRECTIONS", "IncrementEngine", "Program", "StateClaim", "status_program"]

CORRECTIONS = 3
"""Corrections of a status where a solver's tolerance left it wrong."""


@dataclass(frozen=True)
class StateClaim:
    """A state and its largest violation of what is claimed."""

    state: State
    residual: float


@dataclass
class Program:
    """A problem with its parameters set, and how its solution is read, with so many corrections of the status."""

    problem: cp.Problem
    read: Callable[[int], StateClaim]
    corrections: int = 0

    def refine(self) -> None:
        """Let a status that its own state contradicts be corrected."""
        self.corrections = CORRECTIONS

    def claim(self) -> StateClaim:
        """Judge what stands in the variables."""
        return self.read(self.corrections)


def status_program(problem: cp.Problem, posed: PosedIncrement, status: Callable[[], Status]) -> Program:
    """A program whose solution is read as the status of every node: the claim is the exact state of that status, judged by the referee."""

    def read(corrections: int) -> StateClaim:
        state = settle(posed.law.S, posed.law.friction, posed.law.no_bound, posed.trial, status(), corrections)
        return StateClaim(state, posed.residual(state))

    return Program(problem, read)


class IncrementEngine(ABC):
    """One friction increment after another of the same contact, by a problem that is compiled once."""

    _title: ClassVar[str]

    def __init__(self, system: ContactSystem, friction: Any, simplify: bool, **options: Any) -> None:
        self._law, self._simplify, self._options = Law(system, friction), flag("simplify", simplify), options

    @property
    @abstractmethod
    def problem(self) -> cp.Problem:
        """The cvxpy problem."""

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the problem by its names."""
        explain(self._title, self.problem, None, {}, (), pd.DataFrame(), file)

    def solve(self, slip: Any, bonded: Any) -> Increment:
        """A state to which a slip can move under a load.

        Parameters
        ----------
        slip
            (N,) slip before the increment, length.
        bonded
            `(q^w, p^w)`, (N,) bonded reactions of the load after it, force per depth.

        Raises
        ------
        ModelError
            Arrays that do not fit.
        NoContinuation
            ExactIncrement only: no state obeys the law within its `reach`.
        SolverError
            No answer that passes.
        """
        posed = self._law.pose(slip, bonded)
        if self._simplify and posed.stuck:
            return posed.closed_form(self._title)
        halved = self._solve_half(posed) if self._simplify else None
        return self._solve_program(posed) if halved is None else halved

    @abstractmethod
    def _solve_program(self, posed: PosedIncrement) -> Increment: ...

    @cached_property
    def _half(self) -> "tuple[MirrorHalf, IncrementEngine] | None":
        """Half of a mirror-symmetric contact, and the engine of its increments."""
        half = mirror_half(self._law.system, self._law.friction)
        return None if half is None else (half, type(self)(half.system, half.nodal(self._law.friction), **self._options))

    def _solve_half(self, posed: PosedIncrement) -> Increment | None:
        """A mirror-symmetric state, from the half; None where slip or load are not symmetric, or the half has no answer: the whole may have one."""
        slip, bonded = posed.slip, (posed.bonded_q, posed.bonded_p)
        if self._half is None or np.abs(slip + slip[::-1]).max() > EXACT * np.abs(slip).max():
            return None
        if not is_mirror_symmetric(self._law.system, [bonded], self._law.friction, EXACT_LOAD):
            return None
        half, engine = self._half
        before = half.odd(slip)
        try:
            found = engine.solve(before, np.split(half.forces(np.concatenate(bonded)), 2))
        except (NoContinuation, SolverError):
            return None
        u = half.whole_motion(np.r_[found.slip - before, found.gap]) / posed.length
        r = half.whole_forces(np.r_[found.q, found.p]) / posed.force
        text = f"mirror symmetry: v is odd, {half.nodes} of {self._law.nodes} nodes are in the program"
        state = State(sticking(self._law.nodes), u, r)
        result = posed.result(self._title, state, found.sweeps, found.solver, found.attempts, (text, *found.left_out), found.problem)
        return replace(result, _units=found._units) if result.residual <= TOLERANCE else None
