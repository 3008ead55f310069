"""Slips that the contact can hold under one load, the furthest ones in given directions: starts of transients.

A slip is admissible under a load if every node stays closed and within its bound there::

    max direction v    s.t.   |q| <= f p,  p >= 0   where   q = q0 + A v,   p = p0 + B v

A slide of the whole body, where nothing resists one, has no part in it; a bound `abs(v) <= slip_bound` counts with its slide.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np

from ..contact import LoadCycle
from ..contact.checks import Array
from ..contact.coulomb import lengths
from ..solve.solvers import NoOptimum, solve
from .question import LimitQuestion
from .safe_model import safe_set
from .safe_set import SafeSet


def admissible_problem(v: SafeSet) -> cp.Problem:
    """The slip admissible under the load of `v` at load factor 0 that goes furthest in a direction, in dimensionless tractions."""
    along = cp.Parameter(v.traction.size, name="direction") @ v.traction
    return v.program(cp.Maximize(along), v.stuck(None))


class AdmissibleSlips:
    """The furthest admissible slips of one contact under one load after the other.

    Parameters
    ----------
    task
        The contact, its load cycle, friction and slip bound.

    Attributes
    ----------
    problem
        The program of the last load; None before there is one.
    """

    def __init__(self, task: LimitQuestion) -> None:
        self._task, self._v = replace(task, cycle=LoadCycle(task.cycle.mean, [{}]), simplify=False), safe_set(task)
        self.problem: cp.Problem | None = None

    def furthest(self, q: Array, p: Array, directions: Mapping[str, Array]) -> dict[str, Array]:
        """For each direction, (N,) or (N, 2), the slip that is admissible under the closed reactions q, p and goes furthest in it, length.

        Directions in which the admissible slips have no end are left out, and all where no slip is admissible.

        Raises
        ------
        SolverError
            No solver gave an answer that passes the checks.
        """
        task = replace(self._task, q0=q[None], p0=p[None], q1=np.zeros_like(q)[None], p1=np.zeros_like(p)[None], fixed=False)
        self._v.ask(task, 0.0)
        if self.problem is None or task.system.tangents > 1:  # in the plane the loads are parameters
            self.problem = admissible_problem(self._v)
        found = {}
        for name, direction in directions.items():
            along = direction.T.ravel() @ self._v.to_slip
            self.problem.param_dict["direction"].value = along / (np.abs(along).max(initial=0.0) or 1.0)
            try:
                found[name] = solve(self.problem, lambda: _vertex(self._v))[0].slip
            except NoOptimum:
                continue
        return found


@dataclass(frozen=True, eq=False)
class SlipClaim:
    """A slip that stands in a program, and by how much it is not what was asked for."""

    slip: Array
    residual: float


def _vertex(v: SafeSet) -> SlipClaim:
    """The slip that stands in the problem, and by how much it is not admissible."""
    task, slip = v.task, v.solved_slip
    _, _, q, p = task.states(0.0, slip)
    excess = float((lengths(q, p) - task.friction * p).max()) / task.force
    return SlipClaim(slip, max(excess, task.beyond(slip)))
