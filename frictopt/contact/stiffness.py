"""Checks of the stiffness S of an interface: symmetric, and positive semi-definite."""

import numpy as np

from ..errors import ModelError
from .checks import Array, frozen
from .tolerances import CONDENSATION

__all__ = ["check_semi_definite", "symmetrised"]


def symmetrised(name: str, matrix: Array) -> Array:
    """The symmetric part of a matrix that is symmetric up to rounding."""
    scale = np.abs(matrix).max()
    asymmetry = np.abs(matrix - matrix.T)
    if asymmetry.max() > CONDENSATION * scale:
        i, j = np.unravel_index(int(asymmetry.argmax()), matrix.shape)
        raise ModelError(
            f"{name}: not symmetric, {name}[{i}, {j}] = {matrix[i, j]:g} but {name}[{j}, {i}] = {matrix[j, i]:g}; "
            "give the stiffness of the relative motion, in the same order for rows and columns"
        )
    return frozen(matrix / 2 + matrix.T / 2)


def check_semi_definite(name: str, S: Array) -> None:
    """Check that S has no negative eigenvalue beyond rounding; error messages call it `name`."""
    scale = np.abs(S).max()
    if scale == 0:
        return
    slack = CONDENSATION * len(S)
    try:  # a Cholesky factorisation of the slightly shifted matrix decides at a tenth of the cost of the eigenvalues
        np.linalg.cholesky(S / scale + slack * np.eye(len(S)))
    except np.linalg.LinAlgError:
        lowest = np.linalg.eigvalsh(S / scale)[0]
        raise ModelError(
            f"{name} has the negative eigenvalue {lowest * scale:g} (largest entry {scale:g}); "
            "an elastic interface stores energy, so S must be positive semi-definite: check signs and the order of the nodes"
        ) from None
