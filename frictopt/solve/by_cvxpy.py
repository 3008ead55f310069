"""Problems that cvxpy itself compiles and solves, with the solvers of this folder."""

from collections.abc import Callable

import cvxpy as cp
import numpy as np

from ..base import Attempt
from ..errors import SolverError
from .solvers import OPTIONS, SOCP, SOLVERS

# Statuses that cvxpy reports for an optimum.
_OPTIMAL = (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)


def solve(problem: cp.Problem, residual: Callable[[], float]) -> tuple[Attempt, ...]:
    """Solve an unreduced cone program by cvxpy, with the first solver that finds an optimum.

    Returns all attempts. `residual` returns the residual of the values of the problem's variables.
    It is recorded and not compared with a tolerance. SolverError if no solver finds an optimum.
    """
    attempts = list[Attempt]()
    for name in SOLVERS[SOCP]:
        if name not in OPTIONS:  # this solver takes only arrays
            continue
        outcome = _run(problem, name)
        is_optimal = outcome in _OPTIMAL
        attempts.append(Attempt(name, outcome, residual() if is_optimal else np.inf))
        if is_optimal and not np.isnan(attempts[-1].residual):
            return tuple(attempts)
    raise SolverError("no solver of cvxpy finds an optimum")


def _run(problem: cp.Problem, name: str) -> str:
    """The status with which a solver ends, or its error.

    `Problem.solve` is not called, because it warns of inaccurate answers, and a filter for its
    warnings would act in all threads. Here the status and the residual are recorded instead.
    """
    options = dict(OPTIONS[name])
    try:
        data, chain, inverse = problem.get_problem_data(
            name.split("_")[0],
            enforce_dpp=True,
            canon_backend=backend(problem),
            solver_opts=options,
        )
        raw = chain.solve_via_data(
            problem, data, warm_start=False, verbose=False, solver_opts=options
        )
        solution = chain.invert(raw, inverse)
        if solution.status in cp.settings.ERROR:
            return f"{name}: {solution.status}"
        problem.unpack(solution)
    except (cp.SolverError, ValueError, ArithmeticError) as error:
        return str(error).split("\n")[0]
    return str(problem.status)


def backend(problem: cp.Problem) -> str | None:
    """The backend with which cvxpy compiles a problem. If cvxpy chose it itself, it would warn."""
    usual = problem._supports_cpp() and problem._max_ndim() <= 2
    return None if usual else str(cp.SCIPY_CANON_BACKEND)
