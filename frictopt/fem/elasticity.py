"""Plane-strain elasticity of one body on a scikit-fem mesh."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from scipy.sparse import bmat, csr_matrix, diags, hstack
from skfem import Basis, BilinearForm, ElementQuad0, ElementQuad1, ElementTriP0, ElementTriP1, LinearForm, MeshQuad1, MeshTri1

from ..contact.checks import Array, finite_number

__all__ = ["ELEMENTS", "ELEMENT_NAMES", "ElementName", "Material", "body_stiffness", "boundary_weights", "volume_weights"]

ELEMENTS = {MeshQuad1: ElementQuad1, MeshTri1: ElementTriP1}
_UNIFORM = {MeshQuad1: ElementQuad0, MeshTri1: ElementTriP0}

ELEMENT_NAMES = ("linear", "mean_dilatation")
ElementName: TypeAlias = Literal["linear", "mean_dilatation"]


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material in plane strain.

    Parameters
    ----------
    E
        Young's modulus, > 0, force per area.
    nu
        Poisson's ratio, -1 < nu < 0.5.

    Raises
    ------
    ModelError
        E not positive, nu outside (-1, 0.5).

    Examples
    --------
    >>> import frictopt as fo
    >>> steel = fo.Material(E=210e9, nu=0.3)
    >>> round(steel.plane_modulus / 1e9, 2)
    230.77
    >>> steel == fo.Material(210e9)
    True
    """

    E: float = 1.0
    nu: float = 0.3

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", finite_number("E", self.E, above=0.0))
        object.__setattr__(self, "nu", finite_number("nu", self.nu, above=-1.0, below=0.5))

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants `(lambda, mu)`."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)), self.E / (2 * (1 + self.nu))

    @property
    def plane_modulus(self) -> float:
        """`E / (1 - nu^2)`: two bodies have `1/E* = 1/plane_modulus_1 + 1/plane_modulus_2`."""
        return self.E / (1 - self.nu**2)


@LinearForm
def _value(v: Any, _: Any) -> Any:
    return v


@BilinearForm
def _gradient_xx(u: Any, v: Any, _: Any) -> Any:
    return u.grad[0] * v.grad[0]


@BilinearForm
def _gradient_yy(u: Any, v: Any, _: Any) -> Any:
    return u.grad[1] * v.grad[1]


@BilinearForm
def _gradient_yx(u: Any, v: Any, _: Any) -> Any:
    return u.grad[1] * v.grad[0]


@BilinearForm
def _mean_gradient_x(u: Any, v: Any, _: Any) -> Any:
    return u.grad[0] * v


@BilinearForm
def _mean_gradient_y(u: Any, v: Any, _: Any) -> Any:
    return u.grad[1] * v


def body_stiffness(mesh: Any, material: Material, element: ElementName = "linear") -> csr_matrix:
    """Stiffness matrix of one body, per unit depth; unknowns are all x displacements by node, then all y displacements.

    Three scalar gradient products give all four blocks, which is several times faster than one vector-valued form. With "mean_dilatation" the
    first Lame constant resists the mean of div u over an element instead of div u itself (selective integration; Nagtegaal, Parks & Rice 1974,
    Hughes 1980): an element can then keep its volume without locking. There are no zero-energy modes, because the second constant acts in full.
    In a triangle div u is uniform, so nothing changes there.
    """
    basis = Basis(mesh, ELEMENTS[type(mesh)]())
    xx, yy, yx = (form.assemble(basis) for form in (_gradient_xx, _gradient_yy, _gradient_yx))
    lam, mu = material.lame
    pointwise = 0.0 if element == "mean_dilatation" else lam
    coupling = pointwise * yx + mu * yx.T
    K = bmat([[(pointwise + 2 * mu) * xx + mu * yy, coupling], [coupling.T, (pointwise + 2 * mu) * yy + mu * xx]], format="csr")
    return K if element == "linear" else K + lam * _mean_dilatation(basis)


def _mean_dilatation(basis: Any) -> csr_matrix:
    """Product of the element means of div u and div v, times the area, in the unknowns of `body_stiffness`."""
    uniform = basis.with_element(_UNIFORM[type(basis.mesh)]())
    volume_change = hstack([form.assemble(basis, uniform) for form in (_mean_gradient_x, _mean_gradient_y)])
    return csr_matrix(volume_change.T @ diags(1 / basis.dx.sum(axis=1)) @ volume_change)


def boundary_weights(mesh: Any, boundary: str) -> Array:
    """Length that each node collects from a named boundary: half of each of its edges there, (nodes,)."""
    ends = mesh.facets[:, mesh.boundaries[boundary]]
    lengths = np.hypot(*(mesh.p[:, ends[0]] - mesh.p[:, ends[1]]))
    weights: Array = np.bincount(ends.ravel(), weights=np.tile(lengths / 2, 2), minlength=mesh.p.shape[1]).astype(np.float64)
    return weights


def volume_weights(mesh: Any) -> Array:
    """Area that each node collects: the integral of its shape function, (nodes,)."""
    weights: Array = _value.assemble(Basis(mesh, ELEMENTS[type(mesh)]()))
    return weights
