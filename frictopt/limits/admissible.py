"""Slips that the contact can hold under one load, the furthest ones in given directions: starts of transients.

A slip is admissible under a load if every node stays closed and within its bound there::

    max direction v    s.t.   |q| <= f p,  p >= 0   where   q = q0 + A v,   p = p0 + B v

A slide of the whole body, where nothing resists one, has no part in it; a bound `abs(v) <= slip_bound` counts with its slide.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.solvers import NoOptimum, solve
from .loads import Loads
from .plane import PlaneQuestion
from .safe_set import SafeProblem, SafeSymbols

__all__ = ["AdmissibleSlips", "admissible_problem"]


def admissible_problem(v: SafeSymbols) -> SafeProblem:
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

    def __init__(self, task: PlaneQuestion) -> None:
        self._task = replace(task, simplify=False)
        self._model = admissible_problem(self._task.symbols())

    @property
    def problem(self) -> cp.Problem:
        """The cvxpy problem, with the values of the last load and direction."""
        return self._model.problem

    def furthest(self, q: Array, p: Array, directions: Mapping[str, Array]) -> dict[str, Array]:
        """For each direction, (N,), the slip (N,) that is admissible under the closed reactions q, p (N,) and goes furthest in it, length.

        Directions in which the admissible slips have no end are left out, and all where no slip is admissible.

        Raises
        ------
        SolverError
            No solver gave an answer that passes the checks.
        """
        none = np.zeros((1, len(q)))
        loads = Loads(q, p, none, none)
        self._task.with_data(self._model, loads)
        found = {}
        for name, direction in directions.items():
            along = direction @ self._model.scaled.slip
            self._model.problem.param_dict["direction"].value = along / (np.abs(along).max(initial=0.0) or 1.0)
            vertex = _Vertex(self._model, self._task, loads)
            try:
                found[name] = solve(vertex, vertex.claim).claim.slip
            except NoOptimum:
                continue
        return found


@dataclass(frozen=True, eq=False)
class _Claim:
    slip: Array
    residual: float


@dataclass(frozen=True, eq=False)
class _Vertex:
    """The problem with its load and direction set."""

    model: SafeProblem
    task: PlaneQuestion
    loads: Loads

    @property
    def problem(self) -> cp.Problem:
        return self.model.problem

    def refine(self) -> None:
        self.model.refine()

    def claim(self) -> _Claim:
        """The slip that stands in the problem, and by how much it is not admissible or the furthest."""
        slip = self.task.within_bound(self.model.slip)
        q, p = self.loads.q0 + self.task.system.A @ slip, self.loads.p0 + self.task.system.B @ slip
        excess = float((np.abs(q) - self.task.friction * p).max()) / self.task.force
        return _Claim(slip, max(excess, self.task.beyond(slip)))
