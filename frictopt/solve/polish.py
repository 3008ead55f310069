"""The exact solution of a linear program whose active rows a solver has found."""

import cvxpy as cp
import numpy as np

from ..contact.checks import Array

__all__ = ["Program", "on_vertex", "polish", "standard_form"]


class Program:
    """A solved linear program as cvxpy compiled it, `max objective @ z` subject to `matrix @ z >= right`, all constraints being inequalities.

    Attributes
    ----------
    matrix, right, objective
        Its data.
    z, y
        The variables and multipliers that stand in the problem.
    """

    def __init__(self, problem: cp.Problem) -> None:
        data = problem.get_problem_data(problem.solver_stats.solver_name, enforce_dpp=True)[0]
        self.matrix, self.right, self.objective = -data["A"].toarray(), -data["b"], -data["c"]
        columns = data["param_prob"].var_id_to_col
        self._variables = sorted((variable for variable in problem.variables() if variable.size), key=lambda variable: int(columns[variable.id]))
        self._constraints = problem.constraints
        self.z: Array = np.concatenate([np.ravel(variable.value, order="F") for variable in self._variables])
        self.y: Array = np.concatenate([np.ravel(constraint.dual_value, order="F") for constraint in self._constraints])

    @property
    def bounds(self) -> tuple[float, float]:
        """The objective of z, and what the multipliers alone prove of the largest objective (of all z of the size of this one, or 1)."""
        y = np.maximum(self.y, 0.0)
        defect = np.abs(self.matrix.T @ y + self.objective) @ np.maximum(np.abs(self.z), 1.0)
        return float(self.objective @ self.z), float(-self.right @ y + defect)

    def save(self, z: Array, y: Array) -> None:
        """Put variables and multipliers into the problem."""
        for variable, part in zip(self._variables, _split(z, [v.size for v in self._variables]), strict=True):
            variable.save_value(part.reshape(variable.shape, order="F"))
        for constraint, part in zip(self._constraints, _split(y, [c.size for c in self._constraints]), strict=True):
            constraint.dual_variables[0].save_value(part.reshape(constraint.shape, order="F"))


def standard_form(problem: cp.Problem) -> tuple[Array, Array, Array]:
    """Matrix, right-hand side and objective of a linear program, solved or not: `max objective @ z` subject to `matrix @ z >= right`."""
    data = problem.get_problem_data("HIGHS", enforce_dpp=True)[0]
    return -data["A"].toarray(), -data["b"], -data["c"]


def polish(problem: cp.Problem) -> None:
    """Move the solution that stands in a linear program onto its vertex, see `on_vertex`."""
    program = Program(problem)
    program.save(*on_vertex(program.matrix, program.right, program.objective, program.z, program.y))


def on_vertex(matrix: Array, right: Array, objective: Array, z: Array, y: Array) -> tuple[Array, Array]:
    """Move variables z and multipliers y of `max objective @ z, matrix @ z >= right` onto their vertex.

    The rows whose multiplier exceeds their slack become equations, `matrix @ z = right` there and `objective + matrix.T @ y = 0`. The smallest
    corrections that solve these, to rounding, replace what a solver leaves at its own tolerance. Whether that is better is for a residual to say.
    """
    active = y > matrix @ z - right
    equations = matrix[active]
    z = z + np.linalg.lstsq(equations, right[active] - equations @ z)[0]
    y = np.where(active, y, 0.0)
    y[active] -= np.linalg.lstsq(equations.T, objective + equations.T @ y[active])[0]
    return z, y


def _split(values: Array, sizes: list[int]) -> list[Array]:
    return np.split(values, np.cumsum(sizes)[:-1])
