"""Load vectors and strains of a plane or axisymmetric body on its scikit-fem mesh."""

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np
from skfem import Basis, LinearForm

from ..contact.checks import Array, finite_number, real_array, shown
from ..errors import ModelError
from .elasticity import ELEMENTS, KINEMATICS, Kinematics, circumference

__all__ = ["KINEMATICS", "Amount", "Kinematics", "boundary_forces", "checked_amount", "gradient_forces", "values_at", "volume_forces"]

Amount: TypeAlias = float | Callable[[Array, Array], Any]
"""A number, or a function of the coordinates x and y (arrays) that returns an array of their shape."""

_SHARE, _WEIGHT = (np.polynomial.legendre.leggauss(3) + np.array([[1.0], [0.0]])) / 2  # points of an edge, and their weights

_Form: TypeAlias = Literal["value", "grad_x", "grad_y"]


def checked_amount(name: str, value: Any) -> Amount:
    """Check that `value` is one finite number or a function."""
    if callable(value) and not isinstance(value, type):
        return value  # type: ignore[no-any-return]
    if callable(value):
        raise ModelError(f"{name}: {shown(value)}; give a number or a function of x and y")
    return finite_number(name, value)


def values_at(name: str, amount: Amount, x: Array, y: Array) -> Array:
    """Values of a number or a function at points; error messages call it `name`."""
    if not callable(amount):
        return np.full(x.shape, float(amount))
    try:
        values = real_array(name, amount(x, y))
    except ModelError:
        raise
    except Exception as error:  # whatever a function of the user's raises
        raise ModelError(f"{name}: the function raised {type(error).__name__}: {error}; it gets two arrays, x and y") from error
    if values.shape not in ((), x.shape):
        raise ModelError(f"{name}: the function gave shape {values.shape} at points of shape {x.shape}; give one value for each point")
    if not np.isfinite(values).all():
        raise ModelError(f"{name}: the function is not finite everywhere")
    return np.broadcast_to(values, x.shape)


def boundary_forces(mesh: Any, boundary: str, traction: Callable[[Array, Array, Array], list[Array]], kinematics: Kinematics) -> Array:
    """(2, nodes) nodal forces of a traction on a boundary, a function of x, y and the outward normals (2, ...) there."""
    ends = mesh.facets[:, mesh.boundaries[boundary]]
    start, along = mesh.p[:, ends[0]], mesh.p[:, ends[1]] - mesh.p[:, ends[0]]
    inward = mesh.p[:, mesh.t[:, mesh.f2t[0, mesh.boundaries[boundary]]]].mean(axis=1) - start
    length, normals = np.hypot(*along), np.array([along[1], -along[0]])
    normals = normals / length * -np.sign((normals * inward).sum(axis=0))
    x, y = start[:, :, None] + along[:, :, None] * _SHARE  # on the edge itself: scikit-fem would invert the map of very thin elements, in vain
    force = np.array(traction(x, y, np.broadcast_to(normals[:, :, None], (2, *x.shape)))) * circumference(x, kinematics) * length[:, None] * _WEIGHT
    parts = np.concatenate([(force * shape).sum(axis=2) for shape in (1 - _SHARE, _SHARE)], axis=1)
    return np.array([np.bincount(ends.ravel(), weights=part, minlength=mesh.p.shape[1]) for part in parts])


def volume_forces(mesh: Any, force: Callable[[Array, Array], list[Array]], kinematics: Kinematics) -> Array:
    """(2, nodes) nodal forces of a force per volume, a function of x and y."""
    basis = Basis(mesh, ELEMENTS[type(mesh)]())
    x, y = (np.asarray(part) for part in basis.global_coordinates())
    return _forces(basis, force(x, y), x, kinematics)


def gradient_forces(basis: Any, stress: Array, kinematics: Kinematics) -> Array:
    """(2, nodes) nodal forces that a tension of the same size in all directions, given at the integration points, exerts on the nodes."""
    x = np.asarray(basis.global_coordinates())[0]
    amount = stress * circumference(x, kinematics)
    forces = [_assembled(basis, amount, form) for form in ("grad_x", "grad_y")]
    if kinematics == "axisymmetric":
        forces[0] = forces[0] + _assembled(basis, amount / x, "value")
    return np.array(forces)


def _forces(basis: Any, force: list[Array], x: Array, kinematics: Kinematics) -> Array:
    around = circumference(x, kinematics)
    return np.array([_assembled(basis, part * around, "value") for part in force])


def _assembled(basis: Any, amount: Array, form: _Form) -> Array:
    forms = {"value": lambda v, w: w.amount * v, "grad_x": lambda v, w: w.amount * v.grad[0], "grad_y": lambda v, w: w.amount * v.grad[1]}
    return np.asarray(LinearForm(forms[form]).assemble(basis, amount=amount))
