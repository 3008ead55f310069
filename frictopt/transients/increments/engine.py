"""What both engines of increments share: what is left out before a program is solved, and how its solution becomes a state."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import IO, Any, ClassVar

import cvxpy as cp
import numpy as np

from ...contact import ContactSystem
from ...contact.checks import flag
from ...contact.symmetry import Part, halve, is_odd, is_symmetric_load
from ...contact.tolerances import RESIDUAL
from ...errors import NoContinuation, SolverError
from ...solve.explain import explain
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
        explain(self._title, self.problem, None, {}, (), None, file)

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
        symmetric = self._simplify and is_odd(posed.slip) and is_symmetric_load(posed.bonded_q, posed.bonded_p)
        expanded = self._solve_half(posed) if symmetric else None
        return self._solve_program(posed) if expanded is None else expanded

    @abstractmethod
    def _solve_program(self, posed: PosedIncrement) -> Increment: ...

    @cached_property
    def _half(self) -> "tuple[Part, IncrementEngine] | None":
        """Half of a mirror-symmetric contact, and the engine of its increments."""
        half = halve(self._law.system, self._law.friction)
        return None if half is None else (half, type(self)(half.system, half.of(self._law.friction), **self._options))

    def _solve_half(self, posed: PosedIncrement) -> Increment | None:
        """A mirror-symmetric state, expanded from the half; None where the half has no answer, because the whole contact may have one."""
        if self._half is None:
            return None
        half, engine = self._half
        before = half.of(posed.slip)
        try:
            found = engine.solve(before, (half.of(posed.bonded_q), half.of(posed.bonded_p)))
        except (NoContinuation, SolverError):
            return None
        u = np.r_[half.odd(found.slip - before), half.gaps(found.gap)] / posed.length
        r = np.r_[half.odd(found.q), half.even(found.p)] / posed.force
        state, record = State(sticking(self._law.nodes), u, r), found.record
        left_out = *half.left_out, *record.left_out
        result = posed.result(self._title, state, found.sweeps, record.solver, record.attempts, left_out, found.problem)
        return replace(result, _units=found._units) if result.residual <= RESIDUAL else None
