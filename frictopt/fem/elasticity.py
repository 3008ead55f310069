"""Elasticity of one body on a scikit-fem mesh: plane, axisymmetric or in space."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from scipy.sparse import bmat, csr_matrix, diags, hstack
from skfem import (
    Basis,
    BilinearForm,
    ElementHex0,
    ElementQuad0,
    ElementTetP0,
    ElementTriP0,
    Mesh,
    MeshHex1,
    MeshQuad1,
    MeshTet1,
    MeshTri1,
)

from ..contact.checks import Array, finite_number
from .elements import basis_of

__all__ = ["ELEMENT_NAMES", "KINEMATICS", "ElementName", "Kinematics", "Material", "body_stiffness", "circumference", "element_means"]

_UNIFORM = {MeshTri1: ElementTriP0, MeshQuad1: ElementQuad0, MeshTet1: ElementTetP0, MeshHex1: ElementHex0}

ELEMENT_NAMES = ("linear", "mean_dilatation", "quadratic")
ElementName: TypeAlias = Literal["linear", "mean_dilatation", "quadratic"]

KINEMATICS = ("plane_strain", "plane_stress", "axisymmetric", "space")
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric", "space"]


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


def element_means(basis: Basis, values: Array) -> Array:
    """Values at the integration points of a basis, each replaced by the mean of its element."""
    return np.broadcast_to(((values * basis.dx).sum(axis=1) / basis.dx.sum(axis=1))[:, None], values.shape)


def circumference(x: Array, kinematics: Kinematics) -> Array:
    """Length around the axis at each point, `2 pi x`; 1 in space and, as unit depth, in the plane."""
    return 2 * np.pi * x if kinematics == "axisymmetric" else np.ones_like(x)


def body_stiffness(mesh: Mesh, material: Material, element: ElementName | None = None, kinematics: Kinematics = "plane_strain") -> csr_matrix:
    """Stiffness matrix of one body, in the plane per unit depth; unknowns are all x displacements by node, then all y, then all z ones.

    An axisymmetric body has the radius x and the axis x = 0; its stiffness is that of the whole circumference. The radial displacement u makes the
    hoop strain u / x.

    Scalar products of derivatives give all blocks, which is several times faster than one vector-valued form. With "mean_dilatation" the first
    Lame constant resists the mean of div u over an element instead of div u itself (selective integration; Nagtegaal, Parks & Rice 1974, Hughes
    1980): an element can then keep its volume without locking. There are no zero-energy modes, because the second constant acts in full. In
    triangles and tetrahedra div u is uniform, so nothing changes there.
    """
    basis, d = basis_of(mesh), mesh.dim()
    around = circumference(np.asarray(basis.global_coordinates())[0], kinematics)
    lam, mu = material._plane_lame(kinematics)

    def assembled(product: Any) -> Any:
        return BilinearForm(lambda u, v, w: product(u, v, w) * w.around).assemble(basis, around=around)

    slopes = {(a, b): assembled(lambda u, v, _, a=a, b=b: u.grad[a] * v.grad[b]) for a in range(d) for b in range(a + 1)}
    volume, hoop = dict(slopes), 0.0
    if kinematics == "axisymmetric":
        hoop = assembled(lambda u, v, w: u * v / w.x[0] ** 2)
        x_value, y_value = (assembled(lambda u, v, w, a=a: u.grad[a] * v / w.x[0]) for a in (0, 1))
        volume[0, 0] = slopes[0, 0] + x_value + x_value.T + hoop
        volume[1, 0] = slopes[1, 0] + y_value
    pointwise = 0.0 if element == "mean_dilatation" else lam
    blocks: list[list[Any]] = [[None] * d for _ in range(d)]
    for a in range(d):
        blocks[a][a] = pointwise * volume[a, a] + mu * (sum(slopes[b, b] for b in range(d)) + slopes[a, a] + 2 * (a == 0) * hoop)
        for b in range(a):
            blocks[b][a] = pointwise * volume[a, b] + mu * slopes[a, b].T
            blocks[a][b] = blocks[b][a].T
    K = bmat(blocks, format="csr")
    if element != "mean_dilatation":
        return K
    uniform = basis.with_element(_UNIFORM[type(mesh)]())
    mean = hstack([BilinearForm(lambda u, v, _, a=a: u.grad[a] * v).assemble(basis, uniform) for a in range(d)])
    return csr_matrix(K + lam * (mean.T @ diags(1 / basis.dx.sum(axis=1)) @ mean))
