"""A rigid punch on an elastic half-space as products: an example of operators that a user supplies.

Convolutions (fast Fourier transforms) turn forces on the cells of a square grid into motions of the
surface. Conjugate gradients find the pressures that keep the contact closed. 65,536 nodes then need
about 100 MB.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.fft import irfft2, rfft2
from scipy.sparse.linalg import LinearOperator, cg

import frictopt as fo
from frictopt.base import Array
from frictopt.reference.half_spaces import influence

_ALL, _SHEAR, _NORMAL = slice(0, 3), slice(0, 2), slice(2, 3)


CYCLE = fo.LoadCycle({"approach": 1.0}, [{"stretch": -1.0}, {"stretch": 1.0}])


def punch_on_half_space(cells: int, nu: float = 0.3) -> fo.ContactProducts:
    """A square punch of side 1 on a half-space of modulus 1, with `cells` cells along a side.

    Its load cases move the punch towards the half-space and along x and y by a unit length, or
    stretch the surface of the half-space along x by a unit strain.
    """
    size = 1 / cells
    line = (np.arange(cells) + 0.5) * size - 0.5
    x, y = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    n = len(x)
    exact, rough = (HalfSpace(cells, size, nu, kind) for kind in (np.float64, np.float32))
    one, none = np.ones(n), np.zeros(n)
    moved = {"approach": (none, none, one), "x": (-one, none, none), "y": (none, -one, none)}
    moved["stretch"] = x, none, none
    return fo.ContactProducts(
        np.column_stack([x, y, none]),
        {case: exact.forces(np.concatenate(motion)) for case, motion in moved.items()},
        pressing=exact.operator(n, exact.pressures, exact.openings),
        rough=rough.operator(n, rough.pressures, rough.openings),
        slipping=exact.operator(2 * n, exact.slips, exact.slips),
    )


class HalfSpace:
    """Motions of the punch relative to the surface due to forces on cells, by convolutions.

    Boussinesq and Cerruti; Johnson 1985, sections 3.2 to 3.6: tractions are uniform on each cell,
    and displacements are taken at its middle. `kind` is the precision.
    """

    def __init__(self, cells: int, size: float, nu: float, kind: type) -> None:
        self._cells, self._kind = cells, kind
        self._tolerance = 1e-12 if kind is np.float64 else 1e-4
        distance = np.r_[0:cells, -cells:0] * size
        x, y = np.meshgrid(distance, distance, indexing="ij")
        normal, along, across, mixed = influence(x, y, size / 2)
        beside = (0.5 - nu) * np.array([_beside(x, y, size / 2), _beside(y, x, size / 2)])
        rows = [
            [(1 - nu) * normal + nu * along, nu * mixed, beside[0]],
            [nu * mixed, (1 - nu) * normal + nu * across, beside[1]],
            [-beside[0], -beside[1], (1 - nu) * normal],
        ]
        compliance = (1 + nu) / (np.pi * size**2) * np.array(rows)
        # The forces that were found last, from which the next search begins.
        self._last = dict[str, Array]()
        self._spectra = rfft2(compliance.astype(kind))
        # The inverse of the operator on a periodic surface preconditions the operator on this
        # surface.
        wrapped = compliance[2, 2].reshape(2, cells, 2, cells).sum(axis=(0, 2))
        self._stiffness = 1 / rfft2(wrapped.astype(kind)).real

    def motions(self, forces: Array, rows: slice, columns: slice) -> Array:
        """Motions along some axes due to forces (axes, cells, cells) along others."""
        n = self._cells
        spectra = rfft2(forces.reshape(-1, n, n).astype(self._kind), (2 * n, 2 * n))
        spectra = np.einsum("rcij,cij->rij", self._spectra[rows, columns], spectra)
        return np.asarray(irfft2(spectra, (2 * n, 2 * n))[:, :n, :n].ravel())

    def forces(self, motions: Array, axes: slice = _ALL, search: str = "") -> Array:
        """Forces along some axes that cause motions along them; `search` names the search."""
        n = self._cells

        def nearly(motions: Array) -> Array:
            spectra = rfft2(motions.reshape(-1, n, n)) * self._stiffness
            return np.asarray(irfft2(spectra, (n, n)).ravel())

        shape = (motions.size, motions.size)
        A = LinearOperator(shape, lambda r: self.motions(r, axes, axes), dtype=self._kind)
        M = LinearOperator(shape, nearly, dtype=self._kind)
        # The squares of small motions would be zero in single precision.
        size = float(np.linalg.norm(motions)) or 1.0
        first = self._last.get(search)
        r, failed = cg(
            A,
            (motions / size).astype(self._kind),
            None if first is None else (first / size).astype(self._kind),
            rtol=self._tolerance,
            maxiter=500,
            M=M,
        )
        assert not failed
        self._last[search] = np.asarray(r, dtype=float) * size
        return self._last[search]

    def pressures(self, shear: Array) -> Array:
        """(N,) pressures due to shear forces (2 N,) on the closed contact."""
        return self.forces(-self.motions(shear, _NORMAL, _SHEAR), _NORMAL, "p")

    def openings(self, lifts: Array) -> Array:
        """(2 N,) the transpose of `pressures`."""
        return -self.motions(self.forces(lifts, _NORMAL, "w"), _SHEAR, _NORMAL)

    def slips(self, shear: Array) -> Array:
        """(2 N,) slips due to shear forces on the closed contact."""
        forces = np.concatenate([shear, self.pressures(shear)])
        return self.motions(forces, _SHEAR, _ALL)

    def operator(
        self, rows: int, there: Callable[[Array], Array], back: Callable[[Array], Array]
    ) -> LinearOperator:
        """The operator on shear forces, with its product and the product with its transpose."""
        return LinearOperator((rows, 2 * self._cells**2), there, back, dtype=self._kind)


def _beside(x: Array, y: Array, half: float) -> Array:
    """Integral of x/r^2 over a square cell around the origin, r the distance from (x, y)."""
    total = np.zeros_like(x)
    for sx in (-1, 1):
        for sy in (-1, 1):
            X, Y = x + sx * half, y + sy * half
            total += sx * sy * (Y * np.log(np.hypot(X, Y)) + X * np.arctan(Y / X))
    return total
