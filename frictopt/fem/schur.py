"""Elimination of all but the last unknowns of a sparse stiffness, with one factorisation."""

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

from ..contact.checks import Array
from ..errors import ModelError

__all__ = ["Elimination"]


class Elimination:
    """One factorisation that eliminates all but the last `kept` unknowns of `K u = F`, in the order in which they stand.

    With the kept unknowns last, the trailing blocks of the factors are the factors of the Schur complement,
    `S = K_rr - K_ri K_ii^-1 K_ir = L_rr U_rr`: no right-hand side per kept unknown is needed. S may be singular (a body that its
    supports do not hold), so the factorisation shifts the trailing diagonal, and the shift is removed afterwards.

    Parameters
    ----------
    K
        Symmetric stiffness, positive definite in the eliminated unknowns.
    kept
        Number of kept unknowns.

    Attributes
    ----------
    S
        (kept, kept) stiffness.
    rounding
        Error of S over its largest entry: what is left of it has the rounding of the stiffness from which the elimination subtracts.

    Raises
    ------
    ModelError
        The eliminated part is singular.
    """

    def __init__(self, K: csr_matrix, kept: int) -> None:
        n = K.shape[0]
        own = K.diagonal()[n - kept :]
        shift = np.where(own > 0, own, own.max())  # each by its own size: soft contacts keep their digits beside stiff ones
        shifted = K + diags(np.r_[np.zeros(n - kept), shift], format="csr")
        columns = csc_matrix((shifted.data, shifted.indices, shifted.indptr), shape=K.shape)  # its rows: it is symmetric
        try:
            factors = splu(columns, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise ModelError(f"stiffness: its interior part is singular ({error}); support the bodies and check the materials") from error
        tail = np.arange(n - kept, n)
        if not (np.array_equal(factors.perm_c[tail], tail) and np.array_equal(factors.perm_r[tail], tail)):
            raise ModelError("stiffness: its factorisation had to reorder the interface, so it is far from positive definite; check the materials")
        self._factors, self._kept = factors, kept
        self._trailing = factors.L[n - kept :, n - kept :].toarray() @ factors.U[n - kept :, n - kept :].toarray()
        S = self._trailing - np.diag(shift)
        self.S: Array = (S + S.T) / 2
        largest = np.abs(S).max()
        self.rounding = float(np.finfo(float).eps * own.max() / largest) if largest > 0 else 0.0

    def reactions(self, F: Array) -> Array:
        """(kept, m) reactions `-(F_r - K_ri K_ii^-1 F_i)` that hold the kept unknowns at zero under the loads F (unknowns, m)."""
        return np.asarray(-self._trailing @ self._factors.solve(F)[-self._kept :])

    def unknowns(self, F: Array, R: Array, z: Array) -> Array:
        """(unknowns,) all unknowns under a load F (unknowns,), its reactions R (kept,), and values z (kept,) of the kept ones: one solve."""
        right = F.copy()
        right[-self._kept :] += self._trailing @ z + R  # the forces on the kept unknowns that make them z
        return np.asarray(self._factors.solve(right))
