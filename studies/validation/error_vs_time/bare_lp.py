"""Direct calls of solvers of linear programs."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from studies.validation.error_vs_time.methods import Method, installed

Array = np.ndarray[Any, Any]

_TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
SIMPLEX: dict[str, Any] = {"solver": "simplex", "simplex_strategy": 4, "presolve": "off", **_TIGHT}
"""Options of HiGHS for these programs, whose rows are dense.

They are the primal simplex method without presolve, and tight tolerances.
"""


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """Minimise `cost x` subject to `matrix x <= right` and `x >= lower`.

    For HiGHS alone there is also `matrix x >= floor`.
    """

    cost: Array
    matrix: csc_matrix
    right: Array
    lower: Array
    floor: Array

    @classmethod
    def of(cls, program: Any) -> "LinearProgram":
        """The matrices of a program of states of rest, for the largest value of its goal."""
        arrays = program.arrays()
        none = np.full(len(arrays.right), -np.inf)
        floor = np.r_[arrays.right[: arrays.zero], none[arrays.zero :]]
        return cls(
            program.place.unit * arrays.cost,
            csc_matrix(arrays.matrix),
            arrays.right,
            np.full(len(arrays.cost), -np.inf),
            floor,
        )

    @classmethod
    def maximum(cls, matrix: Array, right: Array) -> "LinearProgram":
        """Maximise the last unknown subject to `matrix z >= right`."""
        cost = -np.eye(matrix.shape[1])[-1]
        return cls(
            cost,
            csc_matrix(-matrix),
            -right,
            np.full(len(cost), -np.inf),
            np.full(len(right), -np.inf),
        )

    @cached_property
    def with_bounds(self) -> tuple[csc_matrix, Array]:
        """Matrix with 32-bit indices, and right-hand side, with the lower bounds as rows."""
        bounded = np.flatnonzero(np.isfinite(self.lower))
        matrix = np.vstack([self.matrix.toarray(), -np.eye(len(self.cost))[bounded]])
        return csc_matrix(matrix), np.r_[self.right, -self.lower[bounded]]


def highs(program: LinearProgram, options: dict[str, Any]) -> Any:
    """HiGHS with its optimum.

    Raises
    ------
    ArithmeticError
        No optimum.
    """
    highspy = installed("highspy")
    model = highspy.HighsModel()
    lp = model.lp_
    lp.num_row_, lp.num_col_ = program.matrix.shape
    lp.col_cost_ = program.cost
    lp.col_lower_ = program.lower
    lp.col_upper_ = np.full(len(program.cost), np.inf)
    lp.row_lower_ = program.floor
    lp.row_upper_ = program.right
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_ = program.matrix.indptr
    lp.a_matrix_.index_ = program.matrix.indices
    lp.a_matrix_.value_ = program.matrix.data
    solver = highspy.Highs()
    for name, value in {"output_flag": False, **options}.items():
        solver.setOptionValue(name, value)
    solver.passModel(model)
    solver.run()
    _accept(solver.getModelStatus() == highspy.HighsModelStatus.kOptimal, solver.getModelStatus())
    return solver


def highs_cost(solver: Any) -> float:
    """Optimal cost of HiGHS."""
    return float(solver.getInfo().objective_function_value)


def highs_vertex(solver: Any) -> Array:
    """Rows that hold as equations at the vertex that HiGHS finds."""
    basic = installed("highspy").HighsBasisStatus.kBasic
    return np.array(
        [row for row, status in enumerate(solver.getBasis().row_status) if status != basic],
        dtype=int,
    )


def clarabel(program: LinearProgram, tolerance: float) -> float:
    """Optimal cost by Clarabel's interior-point method.

    Raises
    ------
    ArithmeticError
        No optimum, not even an inaccurate one.
    """
    matrix, right = program.with_bounds
    return clarabel_cone(
        program.cost, matrix, right, [installed("clarabel").NonnegativeConeT(len(right))], tolerance
    )


def clarabel_cone(
    cost: Array, matrix: csc_matrix, right: Array, cones: list[Any], tolerance: float
) -> float:
    """Optimal cost of a cone program by Clarabel, with one thread and one value for all tolerances.

    Raises
    ------
    ArithmeticError
        No optimum, not even an inaccurate one.
    """
    package = installed("clarabel")
    settings = package.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    answer = package.DefaultSolver(
        csc_matrix((len(cost),) * 2), cost, matrix, right, cones, settings
    ).solve()
    _accept(str(answer.status) in ("Solved", "AlmostSolved"), answer.status)
    return float(answer.obj_val)


def osqp(program: LinearProgram, tolerance: float) -> float:
    """Optimal cost by OSQP's operator splitting with polishing.

    Raises
    ------
    ArithmeticError
        No optimum in 20,000 iterations, not even an inaccurate one.
    """
    matrix, right = program.with_bounds
    solver = installed("osqp").OSQP()
    tolerances = {
        "eps_abs": tolerance,
        "eps_rel": tolerance,
        "max_iter": 20000,
        "polishing": True,
        "verbose": False,
    }
    solver.setup(
        csc_matrix((len(program.cost),) * 2),
        program.cost,
        matrix,
        np.full(len(right), -np.inf),
        right,
        **tolerances,
    )
    answer = solver.solve(raise_error=False)
    _accept(str(answer.info.status).startswith("solved"), answer.info.status)
    return float(program.cost @ answer.x)


def methods(
    program: LinearProgram, tolerances: tuple[float, ...], error: Callable[[float], float]
) -> Iterator[Method]:
    """Direct calls of the solvers at these tolerances; `error` compares the optimal cost.

    HiGHS also runs with its defaults and with `SIMPLEX`.
    """
    settings = {"defaults": {}, "primal simplex": SIMPLEX}
    for tolerance in tolerances:
        settings[f"{tolerance:.0e}"] = {
            "primal_feasibility_tolerance": tolerance,
            "dual_feasibility_tolerance": tolerance,
        }
    for name, options in settings.items():
        yield Method(
            "HiGHS",
            "options or tolerance",
            name,
            partial(highs, program, options),
            lambda made: error(highs_cost(made)),
            rival="highspy",
        )
    for tolerance in tolerances:
        yield Method(
            "Clarabel",
            "tolerance",
            f"{tolerance:.0e}",
            partial(clarabel, program, tolerance),
            error,
            rival="clarabel",
        )
        yield Method(
            "OSQP",
            "tolerance",
            f"{tolerance:.0e}",
            partial(osqp, program, tolerance),
            error,
            rival="osqp",
        )


def _accept(solved: bool, status: Any) -> None:
    """Raise ArithmeticError without an optimum."""
    if not solved:
        raise ArithmeticError(f"no optimum ({status})")
