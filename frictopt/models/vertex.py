"""The exact solution of a linear program whose active rows a solver has found."""

import numpy as np

from ..contact.checks import Array

__all__ = ["on_vertex"]


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
