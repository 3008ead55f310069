"""Products with elastic bodies in contact, by one factorisation and without a dense stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import LinearOperator, cg

from ..base import SAME_POINT, Array, progress_bar
from ..contact.components import null_space
from ..errors import ModelError
from .condense import checked_motions, eliminated, fronts
from .recovery import Recovery
from .rigid import Glued
from .schur import solve

# Number of rows of the operator `pressing` that are computed at once; one after the other, they
# would take twelve times as long.
_AT_ONCE = 128
# Residual of an exact product, relative to the load, and the largest number of steps that refine
# it.
_EXACT, _STEPS = 1e-13, 50


def products_of(glued: Glued, F: Array) -> tuple[dict[str, Any], Array, Array]:
    """Arguments of `ContactProducts`, bonded reactions (k, loads), and compliance.

    See `condensed`. The bonded bodies are factorised separately, and this factorisation is not
    kept.
    """
    relative = checked_motions(glued)
    u, reactions = Recovery(glued).displacements(F, np.zeros((len(relative), F.shape[1])))
    bodies = SlidingBodies(glued, relative)
    n, size = bodies.K_w.shape[0], bodies.slides.shape[0]
    parts = {
        "pressing": LinearOperator((n, size), bodies.pressures, bodies.openings, dtype=float),
        "slipping": LinearOperator((size, size), bodies.slips, bodies.slips, dtype=float),
        "rough": bodies.rough(),
        "slides": bodies.slides,
    }
    return parts, reactions, F.T @ u


class SlidingBodies:
    """The bodies, in contact at all pairs and free to slip there: `K y = load`.

    The unknowns y are the displacements inside the bodies, and then the slips v (t N,). The factors
    of K have single precision; further steps refine products to double precision.
    """

    def __init__(self, glued: Glued, relative: Array) -> None:
        n, d = glued.interface.frames.shape[:2]
        size = (d - 1) * n
        T, front = fronts(glued)
        K = csr_matrix(T.T @ glued.K @ T)
        inside = np.flatnonzero(front >= 0)
        slips, normals = np.split(np.flatnonzero(front < 0), [size])
        y = np.r_[inside, slips]
        self.first_slip = len(inside)

        # A slip is eliminated in the last front that eliminates one of its neighbours inside the
        # bodies.
        neighbours = csr_matrix(K[slips][:, inside])
        neighbours.data = front[inside][neighbours.indices] + 1.0
        last = neighbours.max(axis=1).toarray().ravel().astype(np.intp) - 1
        front = np.r_[front[inside], last.clip(0)]

        self.slides = _slides(relative, size)
        extra = np.zeros(len(y))
        K_y = csr_matrix(K[y][:, y])
        stiffness = K_y.diagonal()
        # Free slides, and slips across a plane of symmetry, need no force, so any stiffness may
        # hold them.
        pinned = qr(self.slides.T, pivoting=True, mode="r")[1][: self.slides.shape[1]]
        held = self.first_slip + np.r_[pinned, np.flatnonzero(stiffness[self.first_slip :] == 0)]
        extra[held] = stiffness[self.first_slip :].mean()
        self.K = csr_matrix(K_y + diags(extra))
        self.K_w = csr_matrix(K[normals][:, y])
        _, self._factors = eliminated(glued, self.K, T[:, y], front, keep=np.float32)

    def pressures(self, shear: Array) -> Array:
        """(N,) pressures due to shear forces (t N,)."""
        pressures: Array = self.K_w @ self._exact(self._load(shear))
        return pressures

    def openings(self, lifts: Array) -> Array:
        """(t N,) the transpose of `pressures`: minus the slips due to openings (N,)."""
        return self._exact(self.K_w.T @ lifts.ravel())[self.first_slip :]

    def slips(self, shear: Array) -> Array:
        """(t N,) slips due to shear forces (t N,)."""
        slips = self._exact(self._load(shear))[self.first_slip :]
        return slips - self.slides @ (self.slides.T @ slips)

    def rough(self) -> Array:
        """(N, t N) the matrix of `pressures` in single precision, by blocks of solutions."""
        lifts = csr_matrix(self.K_w.T)
        n, size = self.K_w.shape[0], self.slides.shape[0]
        matrix = np.empty((n, size), dtype=np.float32)
        with progress_bar(True, "products", "node", total=n) as bar:
            for first in range(0, n, _AT_ONCE):
                part = slice(first, first + _AT_ONCE)
                loads = lifts[:, part].toarray()
                matrix[part] = solve(self._factors, loads)[self.first_slip :].T
                bar.update(loads.shape[1])
        return matrix

    def _load(self, shear: Array) -> Array:
        return np.concatenate([np.zeros(self.first_slip), shear.ravel()])

    def _exact(self, load: Array) -> Array:
        """Displacements, by conjugate gradients that the single-precision factors precondition."""

        def by_factors(load: Array) -> Array:
            return solve(self._factors, load.reshape(-1, 1)).ravel().astype(float)

        inverse = LinearOperator(self.K.shape, by_factors, dtype=float)
        y, failed = cg(self.K, load, rtol=_EXACT, maxiter=_STEPS, M=inverse)
        if failed:
            raise ModelError(
                f"stiffness: {_STEPS} steps leave products with the bodies inexact; condense the "
                "model, or reduce the ratio of stiffnesses or of the sizes of elements"
            )
        return np.asarray(y)


def _slides(relative: Array, size: int) -> Array:
    """(t N, r) orthonormal slips of the rigid motions that open no pair.

    `relative` (d N, m) are the relative motions of the pairs in free rigid motions of single
    bodies.
    """
    rigid = np.linalg.qr(relative)[0]
    return np.linalg.qr(rigid[:size] @ null_space(rigid[size:], SAME_POINT))[0]
