"""Motions that a stiffness does not resist, and its inverse on all other motions.

The matrices may be as large as the stiffness of a contact, so they are changed in place.
"""

from typing import NamedTuple

import numpy as np

from .checks import Array, Integers
from .tolerances import COUNTS, FREE_MOTION, ROUNDING


def free_motions(stiffness: Array, sizes: Array) -> Array:
    """The orthonormal motions (t, k) that a positive semi-definite stiffness does not resist.

    `sizes` (t,) are the sizes of the stiffness at its nodes. The resistance of a motion is compared
    with them, so that a soft body beside a stiff one does not count as free.
    """
    root = np.sqrt(sizes)
    soft = _factored(stiffness / np.outer(root, root)).soft
    return np.asarray(np.linalg.qr(soft / root[:, None])[0])


def unresisted(square: Array, sizes: Array, pressing: Array | None = None) -> tuple[Array, Array]:
    """The motions (t, k) that a stiffness (t, t) does not resist, and the inverse of the stiffness.

    The motions are orthonormal, and the inverse (t, t) is taken on all motions normal to them.
    `sizes` (t,) are the sizes of the stiffness at its nodes, see `free_motions`. `pressing` (o, t)
    are the normal forces due to unit motions, divided by the roots of their own sizes: a soft
    motion that presses counts as resisted.
    """
    from scipy.linalg.lapack import dpotri

    along = np.sqrt(sizes)
    scaled = square / along[:, None]
    scaled /= along
    first, leading, soft, left = _factored(scaled)
    del scaled
    # Along these motions the resistances are independent: some motions may be resisted, and others
    # not.
    values, independent = np.linalg.eigh(left)
    soft = soft @ independent
    held = np.zeros(len(values), dtype=bool)
    if pressing is not None:
        pressed = np.abs(pressing @ (soft / along[:, None])).max(axis=0, initial=0.0)
        # In a semi-definite stiffness the square of the pressing is at most the resistance. If it
        # is nearly that large, a small resistance is real. If both are mere rounding, the pressing
        # is of the size of the resistance, and its square is far smaller.
        held = (values > 0) & (pressed > ROUNDING) & (pressed**2 > COUNTS * values)

    inverse = np.zeros_like(square)
    if first.size:  # LAPACK refuses an empty matrix.
        inverse[np.ix_(first, first)] = _symmetric(dpotri(leading, lower=1)[0].T)
    _add_product(inverse, soft[:, held] / values[held], soft[:, held].T)
    inverse /= along[:, None]
    inverse /= along
    rigid = np.linalg.qr(soft[:, ~held] / along[:, None])[0]
    _add_product(inverse, rigid, -(rigid.T @ inverse))
    _add_product(inverse, -(inverse @ rigid), rigid.T)
    return rigid, inverse


class _Factored(NamedTuple):
    """The Cholesky factor of a matrix (M, M), and the motions that it hardly resists."""

    first: Integers  # the entries with a resisted pivot, largest first
    leading: Array  # their factor
    soft: Array  # (M, k) motions: one of the other entries is 1, those of `first` follow freely
    left: Array  # (k, k) the stiffness of these motions, which is rounding or small


def _factored(scaled: Array) -> _Factored:
    """See `_Factored`. The factor overwrites the matrix."""
    # Imported here, because it is not needed if the closed contact bears the loads.
    from scipy.linalg import solve_triangular
    from scipy.linalg.lapack import dpstrf

    factor, order, done, _ = dpstrf(scaled.T, tol=0.0, lower=1, overwrite_a=1)
    order = order - 1
    rank = _rank(np.diag(factor)[:done] ** 2)
    leading, beside = factor[:rank, :rank], factor[rank:, :rank]
    soft = np.zeros((len(order), len(beside)))
    soft[order[:rank]] = -solve_triangular(leading, beside.T, trans="T", lower=True)
    soft[order[rank:]] = np.eye(len(beside))
    last = np.tril(factor[rank:, rank:done])
    return _Factored(order[:rank], leading, soft, last @ last.T)


def _rank(pivots: Array) -> int:
    """The number of pivots that are stiffness; all others are rounding.

    The pivots are relative to the stiffness of the nodes. The rounding depends on the digits of the
    data and on the mesh, so no fixed number divides free motions from soft ones. The two are
    divided at the widest gap of the pivots whose lower end is at most `FREE_MOTION`.
    """
    falling = np.sort(pivots)[::-1].clip(ROUNDING)
    above = np.concatenate([[1.0], falling])
    below = np.concatenate([falling, [ROUNDING]])
    gaps = np.where(below <= FREE_MOTION, above / below, 0.0)
    return int((pivots >= above[gaps.argmax()]).sum())


# Number of rows of a large matrix that are changed at once.
_AT_ONCE = 250


def _add_product(matrix: Array, left: Array, right: Array) -> None:
    """Add `left @ right` to a matrix in place."""
    for start in range(0, len(matrix), _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        matrix[rows] += left[rows] @ right


def _symmetric(matrix: Array) -> Array:
    """The symmetric matrix of an upper triangle, in place."""
    for start in range(0, len(matrix), _AT_ONCE):
        rows = slice(start, start + _AT_ONCE)
        corner = np.triu(matrix[rows, rows])
        matrix[rows, rows] = corner + np.triu(corner, 1).T
        matrix[rows.stop :, rows] = matrix[rows, rows.stop :].T
    return matrix
