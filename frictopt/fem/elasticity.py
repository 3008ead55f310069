"""Elasticity of one body on a scikit-fem mesh: plane, axisymmetric or in space."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Basis, Mesh

from ..contact.checks import Array, finite_number
from .elements import basis_of

ElementName: TypeAlias = Literal["linear", "mean_dilatation", "quadratic"]
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric", "space"]
ELEMENT_NAMES, KINEMATICS = get_args(ElementName), get_args(Kinematics)


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
    """Values (elements, ..., integration points) of a basis, each replaced by the mean of its element."""
    dx = np.expand_dims(basis.dx, tuple(range(1, values.ndim - 1)))
    return np.broadcast_to(((values * dx).sum(axis=-1) / dx.sum(axis=-1))[..., None], values.shape)


def circumference(x: Array, kinematics: Kinematics) -> Array:
    """Length around the axis at each point, `2 pi x`; 1 in space and, as unit depth, in the plane."""
    return 2 * np.pi * x if kinematics == "axisymmetric" else np.ones_like(x)


def body_stiffness(mesh: Mesh, material: Material, element: ElementName | None = None, kinematics: Kinematics = "plane_strain") -> csr_matrix:
    """Stiffness matrix of one body, in the plane per unit depth; unknowns are all x displacements by node, then all y, then all z ones.

    An axisymmetric body has the radius x and the axis x = 0; its stiffness is that of the whole circumference. The radial displacement u makes the
    hoop strain u / x.

    With "mean_dilatation" the first Lame constant resists the mean of div u over an element instead of div u itself (selective integration;
    Nagtegaal, Parks & Rice 1974, Hughes 1980): an element can then keep its volume without locking. There are no zero-energy modes, because the
    second constant acts in full. In triangles and tetrahedra div u is uniform, so nothing changes there.
    """
    basis, (lam, mu) = basis_of(mesh), material._plane_lame(kinematics)
    x = np.asarray(basis.global_coordinates())[0]
    weights = basis.dx * circumference(x, kinematics)
    slopes = np.ascontiguousarray(np.moveaxis(np.array([field.grad for (field,) in basis.basis]), 2, 0).swapaxes(1, 2))
    count, d, n, _ = slopes.shape  # element, direction, node, point of integration
    dilatation, hoop = slopes, np.zeros(0)
    if element == "mean_dilatation":
        dilatation = element_means(basis, slopes)
    if kinematics == "axisymmetric":
        hoop = np.stack([np.broadcast_to(field, x.shape) / x for (field,) in basis.basis], axis=1)
        dilatation = slopes.copy()
        dilatation[:, 0] += hoop

    def products(functions: Array) -> Array:
        """(element, function, function) integrals of the products of functions (element, ..., point)."""
        own = functions.reshape(count, -1, functions.shape[-1])
        return np.asarray((own * weights[:, None]) @ own.swapaxes(1, 2))

    shears = products(slopes)
    whole = lam * (shears if dilatation is slopes else products(dilatation)).reshape(count, d, n, d, n)
    shears = mu * shears.reshape(whole.shape)
    whole += shears.transpose(0, 3, 2, 1, 4)
    for a in range(d):
        whole[:, a, :, a] += np.einsum("ebibj->eij", shears)
    if len(hoop):
        whole[:, 0, :, 0] += 2 * mu * products(hoop)
    unknowns = (np.arange(d)[:, None, None] * mesh.p.shape[1] + basis.element_dofs).reshape(d * n, count).T
    rows, columns = np.repeat(unknowns, d * n, axis=1), np.tile(unknowns, d * n)
    return csr_matrix((whole.ravel(), (rows.ravel(), columns.ravel())), shape=(mesh.p.size,) * 2)
