"""The stiffness S of an interface: symmetric, positive semi-definite, and which slips it resists."""

import numpy as np

from ..errors import ModelError
from .checks import Array, frozen
from .tolerances import CONDENSATION, RIGID


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
            "an elastic interface stores energy, so S must be positive semi-definite: check signs, the order of the nodes, and that it was computed "
            "with 16 digits (float32 has 7)"
        ) from None


def in_series(S: Array, own: Array, R: Array, give: Array) -> tuple[Array, Array, Array]:
    """Stiffness `(1 + S G)^-1 S` and reactions `(1 + S G)^-1 R` of an interface with a spring in series with each motion, and the new compliance.

    That is what the springs add to the compliance of the loads, `R^T (G^-1 + S)^-1 R`.

    In the factors of `S = F F^T` the inverse is that of `1 + F^T G F`: no spring is too stiff or too soft for it, and rigid motions stay free. The
    strains of bodies and springs under the reactions are least squares: the energy that is left is half the new compliance.

    Parameters
    ----------
    S, own
        (M, M) stiffness of the bodies and (M,) sizes of the own stiffness of each motion, > 0.
    R
        (M, k) bonded reactions.
    give
        (M,) compliances of the springs, the diagonal of G, >= 0.
    """
    root = np.sqrt(own)
    values, vectors = np.linalg.eigh(S / np.outer(root, root))
    strained = values > RIGID
    sizes, V = np.sqrt(values[strained]), vectors[:, strained]
    F = root[:, None] * V * sizes
    spring = np.sqrt(give)[:, None]
    rows, loads = np.vstack([spring * F, np.eye(F.shape[1])]), np.vstack([spring * R, np.zeros((F.shape[1], R.shape[1]))])
    falling = np.argsort(-np.abs(rows).max(axis=1, initial=0.0), kind="stable")  # so the factors lose least
    Q, factor = np.linalg.qr(rows[falling])
    strain = np.linalg.solve(factor, Q.T @ loads[falling])
    half, left = np.linalg.solve(factor.T, F.T), loads - rows @ strain
    return half.T @ half, R - F @ strain, left.T @ left


def overlapping(S: Array, R: Array, L: Array, D: Array) -> tuple[Array, Array]:
    """Bonded reactions and compliance of load cases in which the bodies overlap, too.

    An overlap stores the energy of the closed contact that holds it; the displacement of its load case is the one that gives this energy back.

    Parameters
    ----------
    S
        (M, M) stiffness.
    R, L
        (M, k) bonded reactions and (k, k) compliance without the overlaps.
    D
        (N, k) overlaps.
    """
    held, p = S[:, -len(D) :] @ D, R[-len(D) :]
    return R + held, L - D.T @ p - p.T @ D - D.T @ held[-len(D) :]
