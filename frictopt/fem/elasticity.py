"""Plane and axisymmetric elasticity of one body on a scikit-fem mesh."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from scipy.sparse import bmat, csr_matrix, diags, hstack
from skfem import Basis, BilinearForm, ElementQuad0, ElementQuad1, ElementTriP0, ElementTriP1, MeshQuad1, MeshTri1

from ..contact.checks import Array, finite_number

__all__ = ["ELEMENTS", "ELEMENT_NAMES", "KINEMATICS", "ElementName", "Kinematics", "Material", "body_stiffness", "circumference", "element_means"]

ELEMENTS = {MeshQuad1: ElementQuad1, MeshTri1: ElementTriP1}
_UNIFORM = {MeshQuad1: ElementQuad0, MeshTri1: ElementTriP0}

ELEMENT_NAMES = ("linear", "mean_dilatation")
ElementName: TypeAlias = Literal["linear", "mean_dilatation"]

KINEMATICS = ("plane_strain", "plane_stress", "axisymmetric")
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric"]


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material.

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

    def _plane_lame(self, kinematics: Kinematics) -> tuple[float, float]:
        """Lame's constants that join the stresses in the plane to the strains in it: in plane stress, lambda is E nu / (1 - nu^2)."""
        return (self.E * self.nu / (1 - self.nu**2), self.lame[1]) if kinematics == "plane_stress" else self.lame

    @property
    def plane_modulus(self) -> float:
        """`E / (1 - nu^2)`: two bodies have `1/E* = 1/plane_modulus_1 + 1/plane_modulus_2`."""
        return self.E / (1 - self.nu**2)


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


@BilinearForm
def _value_value(u: Any, v: Any, w: Any) -> Any:
    return u * v / w.x[0] ** 2


@BilinearForm
def _gradient_x_value(u: Any, v: Any, w: Any) -> Any:
    return u.grad[0] * v / w.x[0]


@BilinearForm
def _gradient_y_value(u: Any, v: Any, w: Any) -> Any:
    return u.grad[1] * v / w.x[0]


def element_means(basis: Any, values: Array) -> Array:
    """Values at the integration points of a basis, each replaced by the mean of its element."""
    return np.broadcast_to(((values * basis.dx).sum(axis=1) / basis.dx.sum(axis=1))[:, None], values.shape)


def circumference(x: Array, kinematics: Kinematics) -> Array:
    """Length around the axis at each point, `2 pi x`; in the plane, unit depth."""
    return 2 * np.pi * x if kinematics == "axisymmetric" else np.ones_like(x)


def body_stiffness(mesh: Any, material: Material, element: ElementName = "linear", kinematics: Kinematics = "plane_strain") -> csr_matrix:
    """Stiffness matrix of one body, per unit depth; unknowns are all x displacements by node, then all y displacements.

    An axisymmetric body has the radius x and the axis x = 0; its stiffness is that of the whole circumference. The radial displacement u makes the
    hoop strain u / x.

    Three scalar gradient products give all four blocks, which is several times faster than one vector-valued form. With "mean_dilatation" the
    first Lame constant resists the mean of div u over an element instead of div u itself (selective integration; Nagtegaal, Parks & Rice 1974,
    Hughes 1980): an element can then keep its volume without locking. There are no zero-energy modes, because the second constant acts in full.
    In a triangle div u is uniform, so nothing changes there.
    """
    basis = Basis(mesh, ELEMENTS[type(mesh)]())
    lam, mu = material._plane_lame(kinematics)
    if kinematics == "axisymmetric":
        return _axisymmetric_stiffness(basis, lam, mu)
    xx, yy, yx = (form.assemble(basis) for form in (_gradient_xx, _gradient_yy, _gradient_yx))
    pointwise = 0.0 if element == "mean_dilatation" else lam
    coupling = pointwise * yx + mu * yx.T
    K = bmat([[(pointwise + 2 * mu) * xx + mu * yy, coupling], [coupling.T, (pointwise + 2 * mu) * yy + mu * xx]], format="csr")
    return K if element == "linear" else K + lam * _mean_dilatation(basis)


def _axisymmetric_stiffness(basis: Any, lam: float, mu: float) -> csr_matrix:
    forms = _gradient_xx, _gradient_yy, _gradient_yx, _value_value, _gradient_x_value, _gradient_y_value
    around = circumference(np.asarray(basis.global_coordinates())[0], "axisymmetric")
    weighted = [_weighted(form).assemble(basis, around=around) for form in forms]
    xx, yy, yx, vv, xv, yv = weighted
    radial = (lam + 2 * mu) * (xx + vv) + lam * (xv + xv.T) + mu * yy
    coupling = lam * (yx + yv) + mu * yx.T
    return csr_matrix(bmat([[radial, coupling], [coupling.T, (lam + 2 * mu) * yy + mu * xx]]))


def _weighted(form: Any) -> Any:
    return BilinearForm(lambda u, v, w: form.form(u, v, w) * w.around)


def _mean_dilatation(basis: Any) -> csr_matrix:
    """Product of the element means of div u and div v, times the area, in the unknowns of `body_stiffness`."""
    uniform = basis.with_element(_UNIFORM[type(basis.mesh)]())
    volume_change = hstack([form.assemble(basis, uniform) for form in (_mean_gradient_x, _mean_gradient_y)])
    return csr_matrix(volume_change.T @ diags(1 / basis.dx.sum(axis=1)) @ volume_change)
