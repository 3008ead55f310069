"""Load vectors of a body on its scikit-fem mesh, in the plane, around an axis or in space."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from skfem import Basis, ElementLineP1, ElementQuad1, ElementTriP1, LinearForm, Mesh
from skfem.quadrature import get_quadrature

from ..contact.checks import Array, check_text, finite_number, place, real_array, shown
from ..errors import ModelError
from .elasticity import Kinematics, circumference
from .elements import basis_of, on_facets, places_of
from .ordering import Integers

Amount: TypeAlias = float | Callable[..., ArrayLike]
"""A number, or a function of the coordinates x and y, and z in space (arrays), that returns an array of their shape."""

_FACETS = {2: ElementLineP1, 3: ElementTriP1, 4: ElementQuad1}  # by the number of corners
_ORDER = 5  # of the integration over facets
MOMENTS = LinearForm(lambda v, w: w.amount * v)  # of an amount at the points of integration with the function of each node


class Part:
    """Base of loads: their texts are names, their amounts finite numbers or functions."""

    def __post_init__(self) -> None:
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
        values = real_array(name, amount(*points))
    except ModelError:
        raise
    except Exception as error:  # whatever a function of the user's raises
        axes = "two arrays, x and y" if len(points) == 2 else "three arrays, x, y and z"
        raise ModelError(f"{name}: the function raised {type(error).__name__}: {error}; it gets {axes}") from error
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
    shapes, slopes = _functions(flat, len(local), on_flat)
    at, ways = np.einsum("dkm,kq->dmq", corners, shapes), np.einsum("dkm,keq->edmq", corners, slopes)
    nodes = mesh.dofs.element_dofs[:, elements]
    values, gradients = _functions(element, len(nodes), at)
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


def _functions(element: Any, count: int, at: Array) -> tuple[Array, Array]:
    """Values (count, ...) and slopes (count, d, ...) of the functions of an element at points (d, ...) of its reference."""
    found = [element.lbasis(at, i) for i in range(count)]
    return np.array([np.broadcast_to(value, at.shape[1:]) for value, _ in found]), np.array([np.broadcast_to(slope, at.shape) for _, slope in found])


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
