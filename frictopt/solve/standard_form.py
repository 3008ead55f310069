"""A linear or cone program as arrays: what its multipliers prove, and its exact solution from one nearby."""

import warnings
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.sparse import block_array, csr_array

from ..contact.checks import Array
from ..contact.tolerances import FLOOR, ROUNDING

_NOT_UNIQUE = ROUNDING / 1e3  # singular directions of these equations, over the largest: there the solution stays as it is
_SOLVED = ROUNDING / 1e3  # errors of these equations that no step makes smaller
_STEPS = 8  # of Newton's method at most; mostly three do

Integers = NDArray[np.intp]


class StandardForm:
    """A program as cvxpy compiled it: `max objective @ z` over the z whose slacks `s = right - matrix @ z` are in cones.

    The first slacks are zero, and the rest are in cones `|s[1:]| <= s[0]`: those of a linear row are of dimension 1.

    Attributes
    ----------
    matrix, right, objective
        Its data.
    variables, rows
        The variables and constraints of the problem, in their order here.
    zero, cones
        How many slacks are zero, and the indices of those of the cones, (n, d) for each dimension d.
    z, y
        The variables and multipliers that stand in a solved problem: `objective = matrix.T @ y`, y free, >= 0 and in cones like s.
    """

    def __init__(self, problem: cp.Problem) -> None:
        data = compiled(problem)
        self.matrix, self.right, self.objective = csr_array(data["A"]), data["b"], -data["c"]
        columns, dims = data["param_prob"].var_id_to_col, data["dims"]
        self.variables = sorted((variable for variable in problem.variables() if variable.size), key=lambda variable: int(columns[variable.id]))
        kinds = ((cp.constraints.Equality, cp.constraints.Zero), (cp.constraints.Inequality, cp.constraints.NonNeg, cp.constraints.NonPos), cp.SOC)
        self.rows = [row for kind in kinds for row in problem.constraints if isinstance(row, kind)]
        self.zero, sizes = int(dims.zero), np.r_[np.ones(dims.nonneg, dtype=int), np.array(dims.soc, dtype=int)]
        starts = dims.zero + np.cumsum(sizes) - sizes
        self.cones: list[Integers] = [starts[sizes == size][:, None] + np.arange(size) for size in np.unique(sizes)]
        if problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
            self.z: Array = np.concatenate([np.ravel(variable.value, order="F") for variable in self.variables])
            self.y: Array = np.concatenate([_multipliers(row) for row in self.rows])

    def admissible(self, y: Array) -> Array:
        """The multipliers nearby that are in their cones."""
        y = y.copy()
        for cone in self.cones:
            y[cone[y[cone[:, 0]] < 0]] = 0.0
            y[cone[:, 0]] = np.maximum(y[cone[:, 0]], np.linalg.norm(y[cone[:, 1:]], axis=1))
        return y

    def product(self, x: Array, equation: float) -> csr_array:
        """The matrix of Jordan's product with x in the cones; with a number in equations."""
        first = np.arange(len(x))
        for cone in self.cones:
            first[cone] = cone[:, :1]
        side = np.flatnonzero(first < np.arange(len(x)))
        entries = np.r_[np.full(self.zero, equation), x[first[self.zero :]], x[side], x[side]]
        at = np.r_[np.arange(len(x)), side, first[side]], np.r_[np.arange(len(x)), first[side], side]
        return csr_array((entries, at), shape=(len(x),) * 2)

    @property
    def defect(self) -> float:
        """By how much the bound of the multipliers may be off because they do not quite balance, for all z of the size of this one, or 1."""
        return float(np.abs(self.matrix.T @ self.admissible(self.y) - self.objective) @ np.maximum(np.abs(self.z), 1.0))

    @property
    def bounds(self) -> tuple[float, float]:
        """The objective of z, and what the multipliers alone prove of the largest objective, with their defect."""
        return float(self.objective @ self.z), float(self.right @ self.admissible(self.y)) + self.defect

    @property
    def gap(self) -> float:
        """Distance of what the multipliers prove from the objective of z, over the latter.

        Their defect counts by itself: no multipliers at all prove that no z of this size has a larger objective, and nothing of larger ones.
        """
        value, bound = self.bounds
        return (abs(bound - self.defect - value) + self.defect) / max(abs(value), FLOOR)


def polish(problem: cp.Problem) -> None:
    """Bring the solution that stands in a problem closer to the exact one, by Newton's method on the conditions of an optimum.

    These are that the multipliers balance, and that their product with the slacks, Jordan's `s o y`, vanishes: near a solution no step has to know
    which rows and cones are active. The point that breaks them and its cones least is the answer; whether it is good enough is for a residual to say.
    """
    form = StandardForm(problem)
    A, z, y, best, least = form.matrix, form.z, form.admissible(form.y), (form.z, form.y), np.inf
    for _ in range(_STEPS):
        s = form.right - A @ z
        by_slack, by_multiplier = form.product(s, 0.0), form.product(y, 1.0)
        lack = np.r_[A.T @ y - form.objective, by_multiplier @ s]
        off = float(np.abs(np.r_[lack, form.admissible(s) - s, form.admissible(y) - y]).max())
        if off < least:
            best, least = (z, y), off
        if not _SOLVED < off < np.inf:
            break
        matrix = block_array([[None, A.T], [-by_multiplier @ A, by_slack]]).toarray()
        rows = _sizes(matrix, axis=1)
        matrix /= rows[:, None]
        columns = _sizes(matrix, axis=0)
        step = lstsq(matrix / columns, -lack / rows, cond=_NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0] / columns
        z, y = z + step[: len(z)], y + step[len(z) :]
    z, y = best
    parts = [*form.variables, *form.rows]
    for part, values in zip(parts, np.split(np.r_[z, form.admissible(y)], np.cumsum([part.size for part in parts])[:-1]), strict=True):
        save = part.save_value if isinstance(part, cp.Variable) else part.save_dual_value
        save(values if isinstance(part, cp.SOC) else values.reshape(part.shape, order="F"))


def _sizes(matrix: Array, axis: int) -> Array:
    """The largest entries of rows or columns, 1 where all are zero."""
    largest = np.abs(matrix).max(axis=axis)
    return np.asarray(np.where(largest > 0, largest, 1.0))


def compiled(problem: cp.Problem) -> dict[str, Any]:
    """What cvxpy makes of a problem for the solver that solved it last, or for any."""
    linear = problem.solver_stats is not None and problem.solver_stats.solver_name == "HIGHS"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the way that cvxpy takes with expressions of three dimensions
        data: dict[str, Any] = problem.get_problem_data("HIGHS" if linear else "CLARABEL", enforce_dpp=True)[0]
    return data


def _multipliers(row: cp.Constraint) -> Array:
    """Multipliers of a constraint in the order of its rows."""
    if not isinstance(row, cp.SOC):
        return np.ravel(row.dual_value, order="F")
    bound, vectors = row.dual_value
    vectors = np.asarray(vectors).reshape(-1, np.size(bound), order="F").T if row.axis == 0 else vectors
    return np.column_stack([np.atleast_1d(bound), vectors]).ravel()
