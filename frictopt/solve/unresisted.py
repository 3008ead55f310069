"""Null vectors of a stiffness, and its inverse on all other vectors.

The matrices may be as large as the stiffness of a contact, so they are changed in place.
"""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import cholesky, lu_factor, lu_solve
from scipy.linalg.lapack import dpotri

from ..base import RIGID, Array


def unresisted(square: Array, others: Array, along: Array, across: Array) -> tuple[Array, Array]:
    """Null vectors of a symmetric, positive semi-definite matrix (t, t), and its inverse.

    The null vectors are orthonormal x (t, k) for which the products with the matrix and with
    `others` (o, t) vanish. The inverse (t, t) is taken on all vectors normal to them. The entries
    of x are scaled by 1 / `along` (t,) and the rows of `others` by `across` (o,), so that a soft
    unknown beside stiff ones is not mistaken for a free one. An x with a product with `others`
    above rounding is no null vector.
    """
    t = len(along)
    scaled = square / along[:, None]
    scaled /= along
    pressure = np.abs(others)
    pressure /= across[:, None]
    pressing = pressure.max(axis=0, initial=0.0) / along
    del pressure
    # An unknown without entries is a null vector by itself, so that the other vectors stay exact.
    idle = ~(scaled.any(axis=0) | (pressing > RIGID))
    scaled[idle, idle] = 1.0
    values, soft = _soft_vectors(scaled)
    soft[idle] = 0.0
    pressed = others @ (soft / along[:, None]) / across[:, None]
    held = (values > 0) & (np.abs(pressed).max(axis=0, initial=0.0) > RIGID)
    # With the soft vectors added the matrix is well conditioned: their stiffness becomes 1 + value.
    _add_product(scaled, soft, soft.T)
    root = cholesky(scaled.T, lower=True, overwrite_a=True, check_finite=False)
    inverse = _symmetric(dpotri(root, lower=1, overwrite_c=1)[0].T)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    _add_product(inverse, soft * share, soft.T)
    inverse /= along[:, None]
    inverse /= along
    rigid = np.hstack([np.linalg.qr(soft[:, ~held] / along[:, None])[0], np.eye(t)[:, idle]])
    _add_product(inverse, rigid, -(rigid.T @ inverse))
    _add_product(inverse, -(inverse @ rigid), rigid.T)
    return rigid, inverse


def _parts(count: int) -> Iterator[slice]:
    """The rows of a large matrix, some of them at once."""
    at_once = 250
    for start in range(0, count, at_once):
        yield slice(start, start + at_once)


def _add_product(matrix: Array, left: Array, right: Array) -> None:
    """Add `left @ right` to a matrix in place."""
    for rows in _parts(len(matrix)):
        matrix[rows] += left[rows] @ right


def _symmetric(matrix: Array) -> Array:
    """The symmetric matrix of an upper triangle, in place."""
    for rows in _parts(len(matrix)):
        corner = np.triu(matrix[rows, rows])
        matrix[rows, rows] = corner + np.triu(corner, 1).T
        matrix[rows.stop :, rows] = matrix[rows, rows.stop :].T
    return matrix


def _soft_vectors(matrix: Array) -> tuple[Array, Array]:
    """Eigenvalues up to `RIGID` and their orthonormal eigenvectors (t, k) of a matrix (t, t).

    They are found by four steps of inverse iteration with more vectors than there are soft ones, so
    that many small eigenvalues do not slow it. The iteration begins with eight vectors. If all of
    them are soft, their number is doubled.
    """
    t = len(matrix)
    shifted = matrix.copy()
    np.fill_diagonal(shifted, shifted.diagonal() + RIGID)
    factor = lu_factor(shifted.T, overwrite_a=True, check_finite=False)
    rng = np.random.default_rng(0)
    count = 0
    stiffest = 0.0
    while stiffest <= RIGID and count < t:
        count = min(2 * count or 8, t)
        vectors = rng.normal(size=(t, count))
        for _ in range(4):
            vectors = np.linalg.qr(lu_solve(factor, vectors))[0]
        values, turn = np.linalg.eigh(vectors.T @ matrix @ vectors)
        stiffest = values[-1]
    is_soft = values <= RIGID
    return values[is_soft], (vectors @ turn)[:, is_soft]
