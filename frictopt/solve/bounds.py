"""Bounds of a mixed-integer program within a search tree of limited size: what the solver proves even where it comes to no end."""

import math
import warnings
from dataclasses import dataclass
from enum import Enum

import cvxpy as cp
import numpy as np

# Tolerances at which HiGHS 1.15 still decides rightly, see `solvers`; the gap is that up to which two numbers count as one.
# Heuristics only look for solutions that are known already.
_OPTIONS = {
    "mip_feasibility_tolerance": 1e-8,
    "primal_feasibility_tolerance": 1e-8,
    "mip_rel_gap": 1e-7,
    "mip_abs_gap": 0.0,
    "mip_heuristic_effort": 0.0,
    "threads": 1,
    "time_limit": 600.0,
}
_LINEAR = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "small_matrix_value": 1e-12}


class BoundStatus(Enum):
    """How the search for a bound ends."""

    OPTIMAL = "the program is solved"
    INFEASIBLE = "the program has no solution"
    FOUND = "node limit of the search tree reached, and a solution is found"
    OPEN = "node limit of the search tree reached, and no solution is found"


@dataclass(frozen=True)
class Bounds:
    """Upper bound of a largest objective (-inf where there is no solution, inf where nothing is known), and how it was found."""

    bound: float
    status: BoundStatus


def bounds(problem: cp.Problem, most_nodes: int) -> Bounds:
    """Maximise the objective of a linear program, or of a mixed-integer one with so many nodes in its tree, and say what is proven."""
    whole = problem.is_mixed_integer()
    options = {**_OPTIONS, "mip_max_nodes": most_nodes} if whole else _LINEAR
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # cvxpy warns of answers that are no optimum; here the status says so
        try:
            problem.solve(solver="HIGHS", warm_start=False, highs_options=options)
        except (cp.SolverError, ValueError, ArithmeticError):
            return Bounds(math.inf, BoundStatus.OPEN)
    if problem.status == cp.INFEASIBLE:
        return Bounds(-math.inf, BoundStatus.INFEASIBLE)
    info = problem.solver_stats.extra_stats
    found = info.primal_solution_status == 2 and all(np.isfinite(variable.value).all() for variable in problem.variables())
    if problem.status == cp.OPTIMAL:
        return Bounds(-float(info.mip_dual_bound) if whole else float(problem.value), BoundStatus.OPTIMAL)
    bound = -float(info.mip_dual_bound) if whole else math.inf
    return Bounds(bound if abs(bound) < 1e29 else math.inf, BoundStatus.FOUND if found else BoundStatus.OPEN)
