"""Solvers of programs as arrays: their order, their options, and what they report."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Protocol, TypeVar

import clarabel
import numpy as np
from scipy.sparse import csc_array, csr_array

from ..base import Array, Attempt, Integers, shown
from ..errors import ModelError, SolverError
from .arrays import Arrays
from .interior_point import interior_point

try:
    import highspy
except ImportError as error:
    raise ImportError(
        f"highspy cannot be loaded ({error}); if another package, such as ortools, brings another "
        "HiGHS library, import frictopt before it or in another process; else reinstall highspy"
    ) from error

# Clarabel goes on until rounding stops it. If many cones meet at the optimum, the ratios of
# multiplier to slack separate active from inactive cones only at this accuracy, see
# `arrays.polish`.
_CLARABEL = {
    "tol_gap_abs": 1e-14,
    "tol_gap_rel": 1e-14,
    "tol_feas": 1e-14,
    "max_iter": 200,
    "max_threads": 1,
    "time_limit": 600.0,
}
OPTIONS: MappingProxyType[str, Mapping[str, object]] = MappingProxyType(
    {
        "CLARABEL": _CLARABEL,
        # For condensed contacts this variant ends with smaller errors, so fewer answers need the
        # polish.
        "CLARABEL_DIRECT": {**_CLARABEL, "equilibrate_enable": False},
        # The last steps of this variant have more digits, but it takes more steps.
        "CLARABEL_FINE": {**_CLARABEL, "static_regularization_constant": 1e-10},
    }
)
# Primal simplex without presolve is 2 to 4 times faster here than the default, because the rows are
# dense, and v = 0 (no slip) is often feasible.
_HIGHS = {
    "output_flag": False,
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 600.0,
    "small_matrix_value": 1e-12,
    "presolve": "off",
}
_DUAL = 1
_PRIMAL = 4

# The largest number of steps of the simplex method: the first number times the count of rows and
# unknowns, plus the second number. Without it, a method that goes round in a circle would last
# until the time limit. Of some 500 programs of random contacts, a punch and fir trees, the programs
# that ended with an answer took at most 0.73 steps for each row and unknown.
_STEPS = (1, 100)

_METHODS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "HIGHS": {"solver": "simplex", "simplex_strategy": _PRIMAL},
        "HIGHS_IPM": {"solver": "ipm", "ipm_iteration_limit": 200},
    }
)

OPTIMAL = "optimal"
INFEASIBLE = "infeasible"
UNBOUNDED = "unbounded"
NONE = "infeasible or unbounded"
CUT_OFF = "not below the cutoff"
# Optima that a solver calls inaccurate count too: the answer is checked anyway.
_OUTCOMES = {
    highspy.HighsModelStatus.kOptimal: OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: UNBOUNDED,
    highspy.HighsModelStatus.kUnboundedOrInfeasible: NONE,
    highspy.HighsModelStatus.kObjectiveBound: CUT_OFF,
    "Solved": OPTIMAL,
    "AlmostSolved": OPTIMAL,
    "InsufficientProgress": OPTIMAL,
    "PrimalInfeasible": INFEASIBLE,
    "AlmostPrimalInfeasible": INFEASIBLE,
    "DualInfeasible": UNBOUNDED,
    "AlmostDualInfeasible": UNBOUNDED,
}
LP_SOLVERS = ("HIGHS", "CLARABEL", "HIGHS_IPM")
"""Solvers of the linear programs, in the order in which they are tried.

Of 637 programs of hard contacts in the plane (friction from 1e-6 to 16, thin bodies, graded meshes)
the first solver answers 603, and each of the other two answers 17 more.
"""

LP = "linear program"
SOCP = "cone program"
LARGE_SOCP = "large cone program"
SOLVERS = {
    LP: LP_SOLVERS,
    SOCP: ("CLARABEL_DIRECT", "CLARABEL_FINE", "CLARABEL", "INTERIOR_POINT"),
    # Large cone programs have a linear objective.
    LARGE_SOCP: ("INTERIOR_POINT", "CLARABEL_DIRECT", "CLARABEL"),
}


class NoOptimum(SolverError):
    """All solvers that were tried report that there is no optimum."""


class Claim(Protocol):
    """The answer that a solution claims, with its residual."""

    @property
    def residual(self) -> float:
        """Largest violation of what is claimed."""


C = TypeVar("C", bound=Claim)


def failed(kind: str, tolerance: float, attempts: Sequence[Attempt], agreed: bool) -> SolverError:
    """The error if no answer passes: a `NoOptimum` if all solvers agreed that there is none."""
    tried = "; ".join(f"{a.solver}: {a.outcome}, residual {a.residual:.1e}" for a in attempts)
    error = NoOptimum if agreed else SolverError
    return error(
        f"{kind}: no answer within the tolerance {tolerance:g} ({tried}); check for reactions of "
        "very different sizes, for nodes without pressure under the mean load, for friction close "
        "to the critical value or so small that rounding hides the friction bounds, for a coupling "
        "so weak that the limit is millions of times the mean load, and for bodies that would "
        "slide or turn freely if rounding did not bend their faces, as in a mesh of few digits "
        "that was rotated or scaled after it was read"
    )


def solver_order(solver: str | None, kind: str = LP) -> Sequence[str]:
    """The solvers to try for a kind of problem: all of them, or the requested one."""
    solvers = SOLVERS[kind]
    if solver is None:
        return solvers
    if not isinstance(solver, str) or solver not in solvers:
        raise ModelError(
            f"solver: {shown(solver)}; give one of {[*solvers]}, or None to try them in this order"
        )
    return (solver,)


def run(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    """Status, x and multipliers with which a solver ends.

    The solver may stop once it has proven that `-cost @ x` is at most `above` for all x.
    """
    if solver in _METHODS:
        return _by_highs(program, solver)
    if solver == "INTERIOR_POINT":
        status, x, y = interior_point(program, above)
    else:
        status, x, y = _by_clarabel(program, solver)
    return _OUTCOMES.get(status, status), x, y


def _by_highs(program: Arrays, solver: str) -> tuple[str, Array, Array]:
    """Status, x and multipliers of a linear program by HiGHS."""
    engine = _engine(program, _METHODS[solver])
    engine.run()
    return _answer(engine)


def _engine(program: Arrays, method: Mapping[str, object]) -> Any:
    """An instance of HiGHS that holds a linear program."""
    engine = highspy.Highs()
    rows = csr_array(program.matrix)
    m, n = rows.shape
    each, least_steps = _STEPS
    steps = each * (m + n) + least_steps
    for name, value in {**_HIGHS, **method, "simplex_iteration_limit": steps}.items():
        engine.setOptionValue(name, value)
    free = np.full(n, np.inf)
    engine.passModel(
        n,
        m,
        rows.nnz,
        int(highspy.MatrixFormat.kRowwise),
        int(highspy.ObjSense.kMinimize),
        0.0,  # constant of the objective
        program.cost,
        -free,
        free,
        np.where(np.arange(m) < program.zero, program.right, -np.inf),
        program.right,
        rows.indptr,
        rows.indices,
        rows.data,
        np.zeros(n, dtype=np.int32),  # no integers
    )
    return engine


def _answer(engine: Any) -> tuple[str, Array, Array]:
    """Status, x and multipliers with which HiGHS ended."""
    status, solution = engine.getModelStatus(), engine.getSolution()
    outcome = _OUTCOMES.get(status, engine.modelStatusToString(status))
    return outcome, np.array(solution.col_value), -np.array(solution.row_dual)


class WarmProgram:
    """A linear program that HiGHS keeps: each solution starts from the basis of the last one.

    Between two solutions, the cost and the bounds of rows and unknowns may be changed.
    """

    def __init__(self, program: Arrays) -> None:
        self._engine = _engine(program, {"solver": "simplex", "simplex_strategy": _DUAL})

    def price(self, cost: Array) -> None:
        """Change the cost of all unknowns."""
        self._engine.changeColsCost(len(cost), np.arange(len(cost), dtype=np.int32), cost)

    def bound_rows(self, rows: Integers, least: Array, most: Array) -> None:
        """Change the bounds of some rows."""
        self._engine.changeRowsBounds(len(rows), rows.astype(np.int32), least, most)

    def bound_columns(self, columns: Integers, lower: Array, upper: Array) -> None:
        """Change the bounds of some unknowns."""
        self._engine.changeColsBounds(len(columns), columns.astype(np.int32), lower, upper)

    def solve(self, cutoff: float = np.inf) -> tuple[str, Array, Array]:
        """Status, x, and the multipliers of the rows: above 0 at `most`, below 0 at `least`.

        HiGHS may stop with the status `CUT_OFF` as soon as its multipliers prove that the cost is
        above the cutoff. If the program is infeasible, the multipliers prove it.
        """
        engine = self._engine
        engine.setOptionValue("objective_bound", cutoff)
        engine.run()
        if engine.getModelStatus() not in _OUTCOMES:
            # Where the dual simplex gives up, the primal one, started afresh, often finds an end.
            engine.clearSolver()
            engine.setOptionValue("simplex_strategy", _PRIMAL)
            engine.run()
            engine.setOptionValue("simplex_strategy", _DUAL)
        outcome, x, y = _answer(engine)
        if outcome == INFEASIBLE:
            _, exists, ray = engine.getDualRay()
            y = -np.array(ray) if exists else np.zeros(len(y))
        return outcome, x, y


def _by_clarabel(program: Arrays, solver: str) -> tuple[str, Array, Array]:
    """Clarabel's own status, x and multipliers."""
    settings = clarabel.DefaultSettings()
    for name, value in {"verbose": False, **OPTIONS[solver]}.items():
        setattr(settings, name, value)
    wide = program.widened
    linear = wide.linear - wide.zero
    cones = [
        clarabel.ZeroConeT(wide.zero),
        clarabel.NonnegativeConeT(linear),
        *map(clarabel.SecondOrderConeT, wide.sizes[linear:].tolist()),
    ]
    no_curvature = csc_array((len(wide.cost),) * 2)
    solution = clarabel.DefaultSolver(
        no_curvature, wide.cost, csc_array(wide.sparse), wide.right, cones, settings
    ).solve()
    x = np.array(solution.x)[: len(program.cost)]
    y = np.array(solution.z)[len(program.block) :]
    return str(solution.status), x, y
