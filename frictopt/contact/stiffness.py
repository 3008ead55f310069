"""Algebra of the stiffness of a contact: checks, springs in series, overlaps."""

import numpy as np

from ..base import CONDENSATION, ROUNDING, Array
from ..errors import ModelError


def symmetrised(name: str, matrix: Array) -> Array:
    """The symmetric part of a matrix that is symmetric up to rounding; else a ModelError.

    If the matrix is exactly symmetric, it is returned itself; so it must be read-only.
    """
    # Row by row, as a transposed copy of a large matrix would fill the memory.
    asymmetry = [
        float(np.abs(row - column).max()) for row, column in zip(matrix, matrix.T, strict=True)
    ]
    if max(asymmetry) > CONDENSATION * max(matrix.max(), -matrix.min()):
        i = int(np.argmax(asymmetry))
        j = int(np.abs(matrix[i] - matrix[:, i]).argmax())
        raise ModelError(
            f"{name}: not symmetric, {name}[{i}, {j}] = {matrix[i, j]:g} but {name}[{j}, {i}] = "
            f"{matrix[j, i]:g}; give the stiffness of the relative motion, in the same order for "
            "rows and columns"
        )
    if not max(asymmetry):
        return matrix
    mean = matrix + matrix.T
    mean /= 2
    mean.flags.writeable = False
    return mean


def check_semi_definite(S: Array) -> None:
    """Check that S has no negative eigenvalue beyond rounding.

    A Cholesky factorisation of the slightly shifted matrix decides at a tenth of the cost of the
    eigenvalues. Only the part of each column below the diagonal is kept, as whole copies of S would
    fill the memory.
    """
    scale = max(S.max(), -S.min())
    if scale == 0:
        return
    shift = CONDENSATION * len(S)
    # Number of columns that are factored at once.
    size = 256
    done = list[tuple[int, Array]]()  # factored columns, and the number of their first row
    try:
        for start in range(0, len(S), size):
            columns = S[start:, start : start + size] / scale
            count = columns.shape[1]
            columns[np.diag_indices(count)] += shift
            for first, factored in done:
                below = factored[start - first :]
                columns -= below @ below[:count].T
            diagonal = np.linalg.cholesky(columns[:count])
            columns[:count] = diagonal
            columns[count:] = np.linalg.solve(diagonal, columns[count:].T).T
            done.append((start, columns))
    except np.linalg.LinAlgError:
        lowest = np.linalg.eigvalsh(S / scale)[0]
        raise ModelError(
            f"S has the negative eigenvalue {lowest * scale:g} (largest entry {scale:g}); an "
            "elastic interface stores energy, so S must be positive semi-definite: check signs, "
            "the order of the nodes, and that it was computed with 16 digits (float32 has 7)"
        ) from None


def in_series(S: Array, sizes: Array, R: Array, compliance: Array) -> tuple[Array, Array, Array]:
    """Stiffness and reactions with a spring in series with each motion, and the added compliance.

    S is (M, M) and R (M, k). `compliance` (M,) are the compliances of the springs, the diagonal of
    G, and `sizes` (M,) > 0 the size of S at each motion. Returned are `(1 + S G)^-1 S`, `(1 + S
    G)^-1 R` and the added compliance of the load cases `R^T (G^-1 + S)^-1 R`. This compliance is
    twice the strain energy of bodies and springs, which a least-squares problem minimises.

    With `S = F F^T` only `1 + F^T G F` is inverted. So no spring is too stiff or too soft, and
    rigid motions stay free.
    """
    root = np.sqrt(sizes)
    values, vectors = np.linalg.eigh(S / np.outer(root, root))
    strained = values > ROUNDING
    F = root[:, None] * vectors[:, strained] * np.sqrt(values[strained])

    spring = np.sqrt(compliance)[:, None]
    count = F.shape[1]
    rows = np.vstack([spring * F, np.eye(count)])
    loads = np.vstack([spring * R, np.zeros((count, R.shape[1]))])
    # With the largest rows first the orthogonal factors lose the fewest digits.
    falling = np.argsort(-np.abs(rows).max(axis=1, initial=0.0), kind="stable")
    Q, factor = np.linalg.qr(rows[falling])
    strain = np.linalg.solve(factor, Q.T @ loads[falling])
    half = np.linalg.solve(factor.T, F.T)
    residual = loads - rows @ strain
    return half.T @ half, R - F @ strain, residual.T @ residual


def overlapping(S: Array, R: Array, L: Array, D: Array) -> tuple[Array, Array]:
    """Bonded reactions R (M, k) and compliance L (k, k) of load cases with overlaps D (N, k).

    An overlap stores elastic energy, because the closed contact presses it shut. The displacement
    of its load case is defined so that unloading returns this energy.
    """
    normal = S[:, -len(D) :]
    held = normal @ D
    # The overlap of a body that is free to leave presses nothing: its forces are rounding.
    held[np.abs(held) <= ROUNDING * (np.abs(normal) @ np.abs(D))] = 0.0
    p = R[-len(D) :]
    return R + held, L - D.T @ p - p.T @ D - D.T @ held[-len(D) :]
