"""The one place that runs solvers: options, order of fall-back, and a record of every attempt."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar

import cvxpy as cp

from ..errors import ModelError, SolverError
from .safe import SafeProblem

__all__ = ["LP_SOLVERS", "TOLERANCE", "Answer", "Attempt", "Claim", "Status", "solve", "solver_order"]

TOLERANCE = 1e-9
"""Largest residual with which an answer of a linear program leaves the package."""

# Primal simplex without presolve: v = 0 is often feasible and the rows are dense, which makes it 2 to 4 times faster here than the default.
_HIGHS = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "time_limit": 600.0, "small_matrix_value": 1e-12}
_OPTIONS: MappingProxyType[str, dict[str, Any]] = MappingProxyType(
    {
        "HIGHS": {"highs_options": {"solver": "simplex", "simplex_strategy": 4, "presolve": "off", **_HIGHS}},
        "HIGHS_IPM": {"highs_options": {"solver": "ipm", **_HIGHS}},
        "CLARABEL": {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10, "max_iter": 200, "max_threads": 1, "time_limit": 600.0},
    }
)
LP_SOLVERS = ("HIGHS", "CLARABEL", "HIGHS_IPM")
"""Solvers of the linear programs, in the order in which they are tried."""


class Status(Enum):
    """What a solver says, in our words."""

    OPTIMAL = "the solver reports an optimum"
    NO_OPTIMUM = "the solver reports that the problem is infeasible or unbounded"
    FAILED = "the solver stopped without an answer"


_STATUS = {
    cp.OPTIMAL: Status.OPTIMAL,
    cp.OPTIMAL_INACCURATE: Status.OPTIMAL,  # whether it is good enough is for our own residual to say, as with every optimum
    cp.INFEASIBLE: Status.NO_OPTIMUM,
    cp.UNBOUNDED: Status.NO_OPTIMUM,
    cp.settings.INFEASIBLE_OR_UNBOUNDED: Status.NO_OPTIMUM,
}  # every other status is a failure


class Claim(Protocol):
    """What a solution says, with its residual."""

    @property
    def residual(self) -> float:
        """Largest violation of what is claimed."""


C = TypeVar("C", bound=Claim)


@dataclass(frozen=True)
class Attempt:
    """One run of one solver: its name, what came of it, and the residual of its answer (inf without one)."""

    solver: str
    outcome: str
    residual: float


@dataclass(frozen=True)
class Answer(Generic[C]):
    """The claim that passed, the solver that made it, and all attempts in order."""

    claim: C
    solver: str
    attempts: tuple[Attempt, ...]


def solve(model: SafeProblem, judged: Callable[[], C], solver: str | None = None, no_optimum: Callable[[], C | None] | None = None) -> Answer[C]:
    """Solve with the first solver whose answer passes, refined if need be; fall back to the next one otherwise.

    Parameters
    ----------
    model
        A linear program with its parameters set.
    judged
        Turns what now stands in the problem's variables into a claim with its residual, recomputed independently of the solver.
    solver
        Use this one alone.
    no_optimum
        Proves why there is no optimum, where a solver says so, and makes a claim of it; None where it finds no proof. Without it there always is an
        optimum.

    Returns
    -------
    Answer
        With a claim of residual at most `TOLERANCE`.

    Raises
    ------
    ModelError
        Unknown solver.
    SolverError
        No solver gave an answer that passes.
    """
    attempts: list[Attempt] = []
    for name in solver_order(solver):
        status, text = _run(model.problem, name)
        if status is not Status.OPTIMAL:
            reason = no_optimum() if status is Status.NO_OPTIMUM and no_optimum else None
            attempts.append(Attempt(name, text, reason.residual if reason else float("inf")))
            if reason:
                return Answer(reason, name, tuple(attempts))
            continue
        claim = judged()
        attempts.append(Attempt(name, text, claim.residual))
        if not claim.residual <= TOLERANCE:
            model.refine()
            claim = judged()
            attempts.append(Attempt(name, "refined on the vertex", claim.residual))
        if claim.residual <= TOLERANCE:
            return Answer(claim, name, tuple(attempts))
    tried = "; ".join(f"{a.solver}: {a.outcome}, residual {a.residual:.1e}" for a in attempts)
    raise SolverError(
        f"linear program: no answer within the tolerance {TOLERANCE:g} ({tried}); check for reactions of very different sizes, "
        "for nodes without pressure under the mean load, and for friction close to the critical value"
    )


def solver_order(solver: str | None) -> Sequence[str]:
    """The solvers to try: all, or the one that is asked for.

    Raises
    ------
    ModelError
        Unknown solver.
    """
    if solver is None:
        return LP_SOLVERS
    if not isinstance(solver, str) or solver not in LP_SOLVERS:
        raise ModelError(f"solver: {solver!r}; give one of {LP_SOLVERS}, or None to try them in this order")
    return (solver,)


def _run(problem: cp.Problem, name: str) -> tuple[Status, str]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # cvxpy warns of inaccurate answers; here the residual decides, and the status is recorded
        try:
            problem.solve(solver=name.removesuffix("_IPM"), warm_start=False, enforce_dpp=True, **_OPTIONS[name])
        except (cp.SolverError, ValueError, ArithmeticError) as error:
            return Status.FAILED, str(error).split("\n")[0]
    return _STATUS.get(problem.status, Status.FAILED), str(problem.status)
