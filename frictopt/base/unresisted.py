"""Motions that a stiffness does not resist, and its inverse on all other motions.

The matrices may be as large as the stiffness of a contact, so they are changed in place.
"""

import numpy as np

from .checks import Array, Booleans, Integers
from .tolerances import COUNTS, FREE_MOTION, ROUNDING


def _resisted(stiffness: Array) -> Booleans:
    """Which motions have a stiffness; that of all others is the rounding of a matrix.

    `stiffness` (k,) is relative to that of the nodes. The rounding depends on the digits of the
    data and on the mesh, so no number divides free motions from soft ones. Between the rounding of
    the arithmetic and that of the data, the widest gap between the sizes does.
    """
    falling = np.sort(stiffness)[::-1].clip(ROUNDING)
    above = np.r_[1.0, falling]
    below = np.r_[falling, ROUNDING]
    gaps = np.where(below <= FREE_MOTION, above / below, 0.0)
    return np.asarray(stiffness >= above[gaps.argmax()])


def free_motions(stiffness: Array, sizes: Array) -> Array:
    """The orthonormal motions (t, k) that a positive semi-definite stiffness does not resist.

    `sizes` (t,) are those of the stiffness at its nodes: with them a soft body beside a stiff one
    is not free.
    """
    root = np.sqrt(sizes)
    motions = _Pivoted(stiffness / np.outer(root, root)).following()
    return np.asarray(np.linalg.qr(motions / root[:, None])[0])


def unresisted(square: Array, sizes: Array, pressing: Array | None = None) -> tuple[Array, Array]:
    """The motions (t, k) that a stiffness (t, t) does not resist, and its inverse on all others.

    The motions are orthonormal, and the inverse (t, t) is taken on all motions normal to them.
    `sizes` (t,) are those of the stiffness at its nodes, see `free_motions`. `pressing` (o, t) are
    normal forces over the roots of their own sizes: a soft motion that presses is resisted.
    """
    from scipy.linalg.lapack import dpotri

    along = np.sqrt(sizes)
    scaled = square / along[:, None]
    scaled /= along
    pivoted = _Pivoted(scaled)
    del scaled
    # Their resistances are independent: some may have one, and others none.
    values, independent = np.linalg.eigh(pivoted.left())
    soft = pivoted.following() @ independent
    held = np.zeros(len(values), dtype=bool)
    if pressing is not None:
        pressed = np.abs(pressing @ (soft / along[:, None])).max(axis=0, initial=0.0)
        # In a semi-definite stiffness the square of the pressing is at most the resistance. A small
        # motion that presses by nearly that much is no rounding, which presses as much as it
        # resists.
        held = (values > 0) & (pressed > ROUNDING) & (pressed**2 > COUNTS * values)

    first = pivoted.order[: pivoted.rank]
    inverse = np.zeros_like(square)
    if first.size:  # LAPACK refuses an empty matrix.
        inverse[np.ix_(first, first)] = _symmetric(dpotri(pivoted.leading, lower=1)[0].T)
    _add_product(inverse, soft[:, held] / values[held], soft[:, held].T)
    inverse /= along[:, None]
    inverse /= along
    rigid = np.linalg.qr(soft[:, ~held] / along[:, None])[0]
    _add_product(inverse, rigid, -(rigid.T @ inverse))
    _add_product(inverse, -(inverse @ rigid), rigid.T)
    return rigid, inverse


class _Pivoted:
    """The Cholesky factor of a matrix (M, M), which it overwrites; the largest pivots come first.

    The entries without a resisted pivot come last.
    """

    order: Integers
    rank: int
    leading: Array  # (rank, rank) the factor of the entries with a resisted pivot

    def __init__(self, scaled: Array) -> None:
        # Imported here, because loads that the closed contact bears need no motions.
        from scipy.linalg.lapack import dpstrf

        factor, order, done, _ = dpstrf(scaled.T, tol=0.0, lower=1, overwrite_a=1)
        self._factor = factor
        self._done = done
        self.order = order - 1
        self.rank = int(_resisted(np.diag(factor)[:done] ** 2).sum())
        self.leading = factor[: self.rank, : self.rank]

    def following(self) -> Array:
        """(M, k) motions in which one of the last entries is 1 and the first ones follow freely."""
        from scipy.linalg import solve_triangular

        last = self._factor[self.rank :, : self.rank]
        motions = np.zeros((len(self.order), len(last)))
        motions[self.order[: self.rank]] = -solve_triangular(
            self.leading, last.T, trans="T", lower=True
        )
        motions[self.order[self.rank :]] = np.eye(len(last))
        return motions

    def left(self) -> Array:
        """(k, k) the stiffness of these motions, which is rounding or small."""
        last = np.tril(self._factor[self.rank :, self.rank : self._done])
        return np.asarray(last @ last.T)


# Rows of a large matrix that change at once.
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
