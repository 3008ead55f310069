"""The one place that runs solvers: their options, their order, those of programs as arrays, and those of programs that cvxpy solves as they stand."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol, TypeVar

import clarabel
import cvxpy as cp
import highspy
import numpy as np
from scipy.sparse import csc_array

from ..base import Array, Attempt, shown
from ..errors import ModelError, SolverError
from .arrays import Arrays
from .interior_point import interior_point

# Of a mixed-integer program only the status is taken, so that tolerances matter little. HiGHS 1.15
# calls feasible ones infeasible when they are much
# tighter than these, and crashes on infeasible ones without presolve.
_HIGHS_MIP = {
    "mip_feasibility_tolerance": 1e-8,
    "primal_feasibility_tolerance": 1e-8,
    "mip_rel_gap": 0.0,
    "mip_abs_gap": 0.5,
    "time_limit": 600.0,
}
_CLARABEL = {
    "tol_gap_abs": 1e-10,
    "tol_gap_rel": 1e-10,
    "tol_feas": 1e-10,
    "max_iter": 200,
    "max_threads": 1,
    "time_limit": 600.0,
}
_OPTIONS: MappingProxyType[str, Mapping[str, object]] = MappingProxyType(
    {
        "CLARABEL": _CLARABEL,
        "CLARABEL_DIRECT": {
            **_CLARABEL,
            "equilibrate_enable": False,
        },  # ends more exactly on condensed contacts: fewer need the polish
        # three digits, for Newton's method to go on from
        "OSQP": {
            "eps_abs": 1e-3,
            "eps_rel": 1e-3,
            "max_iter": 4000,
            "polishing": False,
            "scaling": 0,
        },
        "HIGHS_MIP": {"highs_options": _HIGHS_MIP},
    }
)
# Primal simplex without presolve: v = 0 is often feasible and the rows are dense, which makes it 2
# to 4 times faster here than the default.
_HIGHS = {
    "output_flag": False,
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 600.0,
    "small_matrix_value": 1e-12,
    "presolve": "off",
}
_METHODS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "HIGHS": {"solver": "simplex", "simplex_strategy": 4},
        "HIGHS_IPM": {"solver": "ipm", "ipm_iteration_limit": 200},
    }
)
OPTIMAL, INFEASIBLE, UNBOUNDED, NONE = (
    "optimal",
    "infeasible",
    "unbounded",
    "infeasible or unbounded",
)
_SAID = {
    highspy.HighsModelStatus.kOptimal: OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: UNBOUNDED,
    highspy.HighsModelStatus.kUnboundedOrInfeasible: NONE,
    "Solved": OPTIMAL,
    "AlmostSolved": OPTIMAL,
    # whether it is good enough is for our own residual to say, as with every optimum
    "InsufficientProgress": OPTIMAL,
    "PrimalInfeasible": INFEASIBLE,
    "AlmostPrimalInfeasible": INFEASIBLE,
    "DualInfeasible": UNBOUNDED,
    "AlmostDualInfeasible": UNBOUNDED,
}
LP_SOLVERS = ("HIGHS", "CLARABEL", "HIGHS_IPM")
"""Solvers of the linear programs, in the order in which they are tried.

Of 637 programs of hard contacts in the plane (friction from 1e-6 to 16, thin bodies, graded meshes)
the first answers 603, and the other two 17 each.
"""
MILP_SOLVERS = ("HIGHS_MIP",)
"""Solver of the mixed-integer programs, whose objectives count, so that a gap of 0.5 is none."""

LP, MILP, QP = (
    "linear program",
    "mixed-integer program",
    "quadratic program",
)  # kinds, each with its own solvers
SOCP, LARGE_SOCP = "cone program", "large cone program"
_SOLVERS = {
    LP: LP_SOLVERS,
    MILP: MILP_SOLVERS,
    QP: ("OSQP", "CLARABEL_DIRECT", "CLARABEL"),  # whose answer is where another method begins
    # convex quadratic programs among them: the first one takes the rows as they stand; of 106 of
    # such contacts in space it answers 71, the second 34
    SOCP: ("CLARABEL_DIRECT", "CLARABEL", "INTERIOR_POINT"),
    LARGE_SOCP: ("INTERIOR_POINT", "CLARABEL_DIRECT", "CLARABEL"),  # with a linear objective
}


class NoOptimum(SolverError):
    """All solvers that were asked report that there is no optimum."""


_OPTIMAL = (
    cp.OPTIMAL,
    cp.OPTIMAL_INACCURATE,
)  # whether it is good enough is for our own residual to say, as with every optimum
_NO_OPTIMUM = (
    cp.INFEASIBLE,
    cp.UNBOUNDED,
    cp.settings.INFEASIBLE_OR_UNBOUNDED,
)  # every other outcome is a failure


class Claim(Protocol):
    """What a solution claims, with its residual."""

    @property
    def residual(self) -> float:
        """Largest violation of what is claimed."""


C = TypeVar("C", bound=Claim)


def solve(problem: cp.Problem, residual: Callable[[], float], kind: str) -> tuple[Attempt, ...]:
    """Solve a program of a kind by cvxpy as it stands, with the first solver that finds an optimum: how it was found.

    `residual` is that of what then stands in the problem's variables; any number passes. A
    `NoOptimum` where all solvers agree that there is none.
    """
    attempts, agreed = list[Attempt](), True
    for name in _SOLVERS[kind]:
        if name not in _OPTIONS:  # it takes arrays alone
            continue
        outcome = _run(problem, name)
        found = outcome in _OPTIMAL
        attempts.append(Attempt(name, outcome, residual() if found else np.inf))
        if found and not np.isnan(attempts[-1].residual):
            return tuple(attempts)
        agreed = agreed and outcome in _NO_OPTIMUM
    raise failed(kind, np.inf, attempts, agreed)


def failed(kind: str, tolerance: float, attempts: Sequence[Attempt], agreed: bool) -> SolverError:
    """The error where no answer passes; a `NoOptimum` where all solvers agreed that there is none."""
    tried = "; ".join(f"{a.solver}: {a.outcome}, residual {a.residual:.1e}" for a in attempts)
    return (NoOptimum if agreed else SolverError)(
        f"{kind}: no answer within the tolerance {tolerance:g} ({tried}); check for reactions of very different sizes, "
        "for nodes without pressure under the mean load, for friction close to the critical value or so little that rounding hides its bounds, and "
        "for a coupling so weak that the limit is millions of times the mean load"
    )


def solver_order(solver: str | None, kind: str = LP) -> Sequence[str]:
    """The solvers to try for a kind of problem: all of them, or the one that is asked for."""
    solvers = _SOLVERS[kind]
    if solver is None:
        return solvers
    if not isinstance(solver, str) or solver not in solvers:
        raise ModelError(
            f"solver: {shown(solver)}; give one of {[*solvers]}, or None to try them in this order"
        )
    return (solver,)


def _run(problem: cp.Problem, name: str) -> str:
    """The status with which a solver ends, or its error."""
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
            # cvxpy warns of inaccurate answers; here the residual decides, and the status is recorded
        )
        try:
            problem.solve(
                solver=name.split("_")[0], warm_start=False, enforce_dpp=True, **_OPTIONS[name]
            )
        except (cp.SolverError, ValueError, ArithmeticError) as error:
            return str(error).split("\n")[0]
    # the solver with its copies of the program, which cvxpy keeps for a warm start, takes more than
    # all else
    problem._solver_cache = {}
    return str(problem.status)


def run(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    """Status, x and multipliers with which a solver ends; it may end once it knows that the largest objective is not `above` a number."""
    if solver in _METHODS:
        return _by_highs(program, solver)
    status, x, y = (
        interior_point(program, above)
        if solver == "INTERIOR_POINT"
        else _by_clarabel(program, solver)
    )
    return _SAID.get(status, status), x, y


def _by_highs(program: Arrays, solver: str) -> tuple[str, Array, Array]:
    engine, rows = highspy.Highs(), program.matrix
    for name, value in {**_HIGHS, **_METHODS[solver]}.items():
        engine.setOptionValue(name, value)
    (m, n), by_row = rows.shape, int(highspy.MatrixFormat.kRowwise)
    least, free = (
        np.r_[program.right[: program.zero], np.full(m - program.zero, -np.inf)],
        np.full(n, np.inf),
    )
    columns, sides, kinds = (
        (program.cost, -free, free),
        (least, program.right),
        np.zeros(n, dtype=np.int32),
    )
    engine.passModel(
        n,
        m,
        rows.nnz,
        by_row,
        int(highspy.ObjSense.kMinimize),
        0.0,
        *columns,
        *sides,
        rows.indptr,
        rows.indices,
        rows.data,
        kinds,
    )
    engine.run()
    status, found = engine.getModelStatus(), engine.getSolution()
    return (
        _SAID.get(status, engine.modelStatusToString(status)),
        np.array(found.col_value),
        -np.array(found.row_dual),
    )


def _by_clarabel(program: Arrays, solver: str) -> tuple[str, Array, Array]:
    wide, settings = program.widened, clarabel.DefaultSettings()
    for name, value in {"verbose": False, **_OPTIONS[solver]}.items():
        setattr(settings, name, value)
    linear = int((wide.sizes == 1).sum())
    cones = [
        clarabel.ZeroConeT(wide.zero),
        clarabel.NonnegativeConeT(linear),
        *map(clarabel.SecondOrderConeT, wide.sizes[linear:].tolist()),
    ]
    found = clarabel.DefaultSolver(
        csc_array((len(wide.cost),) * 2),
        wide.cost,
        csc_array(wide.sparse),
        wide.right,
        cones,
        settings,
    ).solve()
    return (
        str(found.status),
        np.array(found.x)[: len(program.cost)],
        np.array(found.z)[len(program.block) :],
    )
