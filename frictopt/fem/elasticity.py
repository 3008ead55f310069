"""Elasticity of one body on a scikit-fem mesh, its stiffness and load vectors: plane, axisymmetric or in space."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from skfem import Basis, ElementLineP1, ElementQuad1, ElementTriP1, LinearForm, Mesh
from skfem.quadrature import get_quadrature

from ..contact import Array, Integers, check_text, finite_number, place, real_array, shown
from ..errors import ModelError
from .elements import basis_of, functions_of, on_facets, places_of

ElementName: TypeAlias = Literal["linear", "mean_dilatation", "quadratic"]
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric", "space"]
ELEMENT_NAMES, KINEMATICS = get_args(ElementName), get_args(Kinematics)
Amount: TypeAlias = float | Callable[..., ArrayLike]
"""A number, or a function of the coordinates x and y, and z in space (arrays), that returns an array of their shape."""
_FACETS = {2: ElementLineP1, 3: ElementTriP1, 4: ElementQuad1}  # by the number of corners
_ORDER = 5  # of the integration over facets
MOMENTS = LinearForm(lambda v, w: w.amount * v)  # of an amount at the points of integration with the function of each node


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
        vars(self).update(E=finite_number("E", self.E, above=0.0), nu=finite_number("nu", self.nu, above=-1.0, below=0.5))

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


class Part:
    """Base of loads: their texts are names, their amounts finite numbers or functions, and of x, y and z at least one is given."""

    def __post_init__(self) -> None:
        if all(getattr(self, axis, 0.0) is None for axis in "xyz"):
            raise ModelError(f"{type(self).__name__}: neither x nor y nor z; give one of them")
        for field in fields(self):  # type: ignore[arg-type]
            name, value = field.name, getattr(self, field.name)
            if field.type is str:
                check_text(name, value, "a name of the model or its mesh")
            elif field.type is float or (field.type in (Amount, Amount | None) and value is not None and not callable(value)):
                object.__setattr__(self, name, finite_number(name, value))
            elif isinstance(value, type):
                raise ModelError(f"{name}: {shown(value)}; give a number or a function of x and y, and z in space")


def components(load: Any, points: Array) -> Array:
    """(d, ...) values of x, y and z of a load at points (d, ...)."""
    kind = type(load).__name__
    if len(points) == 2 and load.z != 0:
        raise ModelError(f"{kind} z: {shown(load.z)}; body {load.body!r} is plane, give x and y alone")
    return np.array([values_at(f"{kind} {axis}", getattr(load, axis), points) for axis in "xyz"[: len(points)]])


def values_at(name: str, amount: Amount, points: Array) -> Array:
    """Values of a number or a function at points (d, ...); error messages call it `name`."""
    shape = points.shape[1:]
    if not callable(amount):
        return np.full(shape, float(amount))
    try:
        given = amount(*points)
    except Exception as error:  # whatever a function of the user's raises
        axes = "two arrays, x and y" if len(points) == 2 else "three arrays, x, y and z"
        raise ModelError(f"{name}: the function raised {type(error).__name__}: {error}; it gets {axes}") from error
    values = real_array(name, given)
    if values.shape not in ((), shape):
        raise ModelError(f"{name}: the function gave shape {values.shape} at points of shape {shape}; give one value for each point")
    if not np.isfinite(values).all():
        raise ModelError(f"{name}: the function is not finite everywhere")
    return np.broadcast_to(values, shape)


def boundary_forces(mesh: Mesh, facets: Integers, traction: Callable[[Array, Array], ArrayLike], kinematics: Kinematics) -> Array:
    """(components, nodes) integrals over facets of the outline, times the function of each node, of a traction: of points and outward normals.

    The integration is on the facets themselves: scikit-fem would invert the map of very thin elements, in vain.
    """
    element, (elements, number) = mesh.elem(), places_of(mesh, facets)
    local = np.array(element.refdom.facets)[number].T
    flat = _FACETS[len(local)]()
    on_flat, weights = get_quadrature(flat.refdom, _ORDER)
    corners = element.refdom.p[:, local]
    shapes, slopes = functions_of(flat, len(local), on_flat)
    at, ways = np.einsum("dkm,kq->dmq", corners, shapes), np.einsum("dkm,keq->edmq", corners, slopes)
    nodes = mesh.dofs.element_dofs[:, elements]
    values, gradients = functions_of(element, len(nodes), at)
    values = values * on_facets(type(mesh))[number].T[:, :, None]
    points = np.einsum("akm,kmq->amq", mesh.p[:, nodes], values)
    along = np.einsum("abmq,ebmq->eamq", np.einsum("akm,kbmq->abmq", mesh.p[:, nodes], gradients), ways)
    normals = np.array([along[0, 1], -along[0, 0]]) if len(along) == 1 else np.cross(along[0], along[1], axis=0)
    inward = mesh.p[:, mesh.t[:, elements]].mean(axis=1) - mesh.p[:, mesh.facets[:, facets]].mean(axis=1)
    normals = normals * -np.sign(np.sum(normals.sum(axis=2) * inward, axis=0))[:, None]
    sizes = np.linalg.norm(normals, axis=0)
    if not sizes.min(initial=1.0) > 0:
        m = int(sizes.min(axis=1).argmin())
        raise ModelError(f"mesh: the facet at {place(points[:, m].mean(axis=1))} has no size; repair it")
    amounts = np.array(traction(points, normals / sizes)) * circumference(points[0], kinematics) * sizes * weights
    return np.array([np.bincount(nodes.ravel(), part.ravel(), minlength=mesh.p.shape[1]) for part in np.einsum("cmq,kmq->ckm", amounts, values)])


def volume_forces(mesh: Mesh, force: Callable[[Array], Array], kinematics: Kinematics) -> Array:
    """(d, nodes) nodal forces of a force per volume, a function of points (d, ...)."""
    basis = basis_of(mesh)
    points = np.asarray(basis.global_coordinates())
    return np.array([MOMENTS.assemble(basis, amount=part) for part in force(points) * circumference(points[0], kinematics)])


def gradient_forces(basis: Basis, stress: Array, kinematics: Kinematics) -> Array:
    """(d, nodes) nodal forces that a tension of the same size in all directions, given at the integration points, exerts on the nodes."""
    x = np.asarray(basis.global_coordinates())[0]
    amount = stress * circumference(x, kinematics)
    axes = range(basis.mesh.dim())
    forces = np.array([LinearForm(lambda v, w, a=a: w.amount * v.grad[a]).assemble(basis, amount=amount) for a in axes])
    if kinematics == "axisymmetric":
        forces[0] += MOMENTS.assemble(basis, amount=amount / x)
    return forces
