"""The solvers that take a program as arrays: HiGHS, Clarabel, and the interior point of large cone programs."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import clarabel
import highspy
import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, hstack, vstack

from ..contact import Array
from .arrays import Arrays
from .interior_point import interior_point

# Primal simplex without presolve: v = 0 is often feasible and the rows are dense, which makes it 2 to 4 times faster here than the default.
_HIGHS = {
    "output_flag": False,
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 600.0,
    "small_matrix_value": 1e-12,
    "presolve": "off",
}
_METHODS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {"HIGHS": {"solver": "simplex", "simplex_strategy": 4}, "HIGHS_IPM": {"solver": "ipm", "ipm_iteration_limit": 200}}
)
_CLARABEL = {
    "verbose": False,
    "tol_gap_abs": 1e-10,
    "tol_gap_rel": 1e-10,
    "tol_feas": 1e-10,
    "max_iter": 200,
    "max_threads": 1,
    "time_limit": 600.0,
}
OPTIMAL, INFEASIBLE, UNBOUNDED, NONE = "optimal", "infeasible", "unbounded", "infeasible or unbounded"
_SAID = {
    highspy.HighsModelStatus.kOptimal: OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: UNBOUNDED,
    highspy.HighsModelStatus.kUnboundedOrInfeasible: NONE,
    "Solved": OPTIMAL,
    "AlmostSolved": OPTIMAL,
    "InsufficientProgress": OPTIMAL,  # whether it is good enough is for a residual to say, as with every optimum
    "PrimalInfeasible": INFEASIBLE,
    "AlmostPrimalInfeasible": INFEASIBLE,
    "DualInfeasible": UNBOUNDED,
    "AlmostDualInfeasible": UNBOUNDED,
}


def run(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    """Status, x and multipliers with which a solver ends; it may end once it knows that the largest objective is not `above` a number."""
    return _ENGINES[solver](program, solver, above)


def _by_highs(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    engine, rows = highspy.Highs(), program.matrix
    for name, value in {**_HIGHS, **_METHODS[solver]}.items():
        engine.setOptionValue(name, value)
    (m, n), by_row = rows.shape, int(highspy.MatrixFormat.kRowwise)
    least, free = np.r_[program.right[: program.zero], np.full(m - program.zero, -np.inf)], np.full(n, np.inf)
    columns, sides, kinds = (program.cost, -free, free), (least, program.right), np.zeros(n, dtype=np.int32)
    engine.passModel(n, m, rows.nnz, by_row, int(highspy.ObjSense.kMinimize), 0.0, *columns, *sides, rows.indptr, rows.indices, rows.data, kinds)
    engine.run()
    status, found = engine.getModelStatus(), engine.getSolution()
    return _SAID.get(status, engine.modelStatusToString(status)), np.array(found.col_value), -np.array(found.row_dual)


def _by_clarabel(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    wide, settings = _Wide(program), clarabel.DefaultSettings()
    for name, value in {**_CLARABEL, "equilibrate_enable": solver == "CLARABEL"}.items():  # without, fewer answers need the polish
        setattr(settings, name, value)
    cones = [clarabel.ZeroConeT(wide.zero), clarabel.NonnegativeConeT(wide.nonneg), *(clarabel.SecondOrderConeT(size) for size in wide.soc)]
    found = clarabel.DefaultSolver(csc_array((wide.matrix.shape[1],) * 2), wide.cost, csc_array(wide.matrix), wide.right, cones, settings).solve()
    return _SAID.get(str(found.status), str(found.status)), *wide.back(np.array(found.x), np.array(found.z))


def _by_interior_point(program: Arrays, solver: str, above: float) -> tuple[str, Array, Array]:
    status, x, y = interior_point(program, above)
    return _SAID.get(status, status), x, y


_ENGINES: Mapping[str, Callable[[Arrays, str, float], tuple[str, Array, Array]]] = MappingProxyType(
    {
        "HIGHS": _by_highs,
        "HIGHS_IPM": _by_highs,
        "CLARABEL": _by_clarabel,
        "CLARABEL_DIRECT": _by_clarabel,
        "INTERIOR_POINT": _by_interior_point,
    }
)


class _Wide:
    """The program with `block @ x` as unknowns of their own, defined by equations, so that all other rows are sparse."""

    def __init__(self, program: Arrays) -> None:
        (parts, width), zero = program.block.shape, program.zero
        define = hstack([csr_array(program.block), -eye_array(parts)]) if parts else csr_array((0, width))
        self.matrix = csr_array(vstack([define, program.sparse]))
        self.right, self.cost = np.r_[np.zeros(parts), program.right], np.r_[program.cost, np.zeros(parts)]
        self._parts, self._width, self.zero = parts, width, parts + zero
        self.nonneg, self.soc = int((program.sizes == 1).sum()), program.sizes[program.sizes > 1].tolist()

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        return x[: self._width], y[self._parts :]
