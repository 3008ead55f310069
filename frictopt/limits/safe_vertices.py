"""Extreme residual slips among the safe ones."""

from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_array, finite_number, frozen
from ..solve.solvers import NoOptimum, solve
from .posed import Task, cycle_loads
from .safe_set import safe_rows
from .scaling import Interface

__all__ = ["safe_vertices"]

_CYCLIC = ("forward", "backward", "opening")  # parameters that the load factor multiplies


def safe_vertices(system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, directions: Any) -> Array:
    """Vertices of the safe slips at a load factor: for each direction, the safe slip whose tractions go furthest along it.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    directions
        (D, N) directions in the space of the nodal tractions over the mean pressures. Where the body may slide as a whole, as many nodes carry no
        traction of their own as there are such slides, and their components do not count.

    Returns
    -------
    Array
        (d, N) slips, length. d = 0 where no slip is safe; directions in which the safe slips have no end give none.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    loads, factor = cycle_loads(system, cycle), finite_number("load_factor", load_factor, least=0.0)
    task = Task(system, cycle, loads, friction, False)
    interface = task.interface()
    rows = task.rows(interface)
    directions = finite_array("directions", directions, (None, system.nodes))[:, interface.loaded]
    problem = _vertex_problem(interface, task.opening)
    for name in problem.param_dict.keys() - {"direction"}:
        problem.param_dict[name].value = getattr(rows, name) * (factor / rows.load_unit if name in _CYCLIC else 1.0)
    found = []
    for direction in directions:
        problem.param_dict["direction"].value = direction / (np.abs(direction).max(initial=0.0) or 1.0)
        model = _Vertex(problem, interface, task, factor)
        try:
            found.append(solve(model, model.claim).claim.slip)
        except NoOptimum:
            continue
    return frozen(np.array(found).reshape(-1, system.nodes))


@dataclass(frozen=True, eq=False)
class _Claim:
    slip: Array
    residual: float


@dataclass(frozen=True, eq=False)
class _Vertex:
    """The problem with its direction set."""

    problem: cp.Problem
    interface: Interface
    task: Task
    load_factor: float

    def refine(self) -> None:
        """Nothing: any safe slip will do, a vertex or not."""

    def claim(self) -> _Claim:
        """The slip that stands in the problem, and by how much it is not safe."""
        slip = self.interface.slip @ self.problem.var_dict["traction"].value
        return _Claim(slip, self.task.violation(self.load_factor, slip))


def _vertex_problem(interface: Interface, opening: bool) -> cp.Problem:
    constraints = safe_rows(interface, opening, 1.0)
    (traction,) = constraints[0].variables()
    direction = cp.Parameter(traction.size, name="direction")
    return cp.Problem(cp.Maximize(direction @ traction), constraints)
