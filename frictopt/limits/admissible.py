"""Slips that the contact can hold under one load, the furthest ones in given directions: starts of transients.

A slip is admissible under a load if every node stays closed and within its bound there::

    max direction v    s.t.   |q| <= f p,  p >= 0   where   q = q0 + A v,   p = p0 + B v

A slide of the whole body, where nothing resists one, has no part in it; a bound `abs(v) <= slip_bound` counts with its slide.
"""

from collections.abc import Mapping
from dataclasses import replace

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.solvers import NoOptimum, solve
from .program import SafeProgram, SlipClaim
from .question import LimitQuestion, Loads
from .safe_set import Intervals

__all__ = ["AdmissibleSlips", "admissible_problem"]


def admissible_problem(v: Intervals) -> cp.Problem:
    """The slip admissible under one load that goes furthest in a direction, in dimensionless tractions."""
    along = cp.Parameter(v.traction.size, name="direction") @ v.traction
    rows = {"no_forward_slip": v.q + v.fp >= 0, "no_backward_slip": v.fp - v.q >= 0, "no_opening": v.p >= 0}
    return v.problem(cp.Maximize(along), rows)


class AdmissibleSlips:
    """The furthest admissible slips of one contact, compiled once for all loads and directions.

    Parameters
    ----------
    task
        The contact, its load cycle, friction and slip bound.
    """

    def __init__(self, task: LimitQuestion) -> None:
        self._task, self._v = task, Intervals(task)
        self.problem = admissible_problem(self._v)

    def furthest(self, q: Array, p: Array, directions: Mapping[str, Array]) -> dict[str, Array]:
        """For each direction, (N,), the slip (N,) that is admissible under the closed reactions q, p (N,) and goes furthest in it, length.

        Directions in which the admissible slips have no end are left out, and all where no slip is admissible.

        Raises
        ------
        SolverError
            No solver gave an answer that passes the checks.
        """
        none = np.zeros((1, len(q)))
        task = replace(self._task, loads=Loads(q[None], p[None], none, none))
        self._v.ask(task)
        found = {}
        for name, direction in directions.items():
            along = direction @ self._v.scaled.slip
            self.problem.param_dict["direction"].value = along / (np.abs(along).max(initial=0.0) or 1.0)
            vertex = _Vertex(task, self._v, self.problem)
            try:
                found[name] = solve(vertex, vertex.claim).claim.slip
            except NoOptimum:
                continue
        return found


class _Vertex(SafeProgram):
    """The problem with its load and direction set."""

    def claim(self) -> SlipClaim:
        """The slip that stands in the problem, and by how much it is not admissible or the furthest."""
        slip = self.slip
        q, p = self.task.reactions(0.0, slip)
        excess = float((np.abs(q) - self.task.friction * p).max()) / self.task.force
        return SlipClaim(slip, max(excess, self.task.beyond(slip)))
