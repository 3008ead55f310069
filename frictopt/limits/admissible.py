"""Slips that the contact can hold at a load factor, the furthest ones in given directions: starts of transients.

In full, with dimensionless nodal tractions::

    max direction tractions    s.t.   |q_k| <= f p_k,  p_k >= 0   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

A slide of the whole body, where nothing resists one, has no part in it; a bound `abs(v) <= slip_bound` counts with its slide.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.solvers import NoOptimum, solve
from .question import LimitQuestion
from .safe_model import safe_set
from .safe_set import SafeSet


def admissible_problem(v: SafeSet) -> cp.Problem:
    """The slip that is safe at the given load factor of `v` and goes furthest in a direction, in dimensionless tractions."""
    along = cp.Parameter(v.traction.size, name="direction") @ v.traction
    return v.program(cp.Maximize(along), v.stuck(None))


class AdmissibleSlips:
    """The furthest admissible slips of one contact under one load after the other.

    Parameters
    ----------
    task
        The contact, friction and slip bound, and loads of the size of the others.

    Attributes
    ----------
    unknowns
        The unknowns of the programs, see `SafeSet`.
    problem
        The program of the last load; None before there is one.
    """

    def __init__(self, task: LimitQuestion) -> None:
        self.unknowns = safe_set(task)
        self.problem: cp.Problem | None = None

    def furthest(self, task: LimitQuestion, load_factor: float, directions: Iterable[Array]) -> list[Array | None]:
        """For each direction of the tractions, (m,), the slip that is safe for a question at a load factor and goes furthest in it, length.

        None in directions in which these slips have no end, and in all where no slip is safe.

        Raises
        ------
        SolverError
            No solver gave an answer that passes the checks.
        """
        v = self.unknowns
        v.ask(task, load_factor)
        if self.problem is None or task.system.tangents > 1:  # in the plane the loads are parameters
            self.problem = admissible_problem(v)
        found = list[Array | None]()
        for along in directions:
            self.problem.param_dict["direction"].value = along / (np.abs(along).max(initial=0.0) or 1.0)
            try:
                found.append(solve(self.problem, lambda: _Slip(v.solved_slip, task.violation(load_factor, v.solved_slip)))[0].slip)
            except NoOptimum:
                found.append(None)
        return found


@dataclass(frozen=True, eq=False)
class _Slip:
    """A slip that stands in a program, and by how much it is not what was asked for."""

    slip: Array
    residual: float
