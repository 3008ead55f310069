"""Loads of a body: tractions, forces per volume, free expansion, displacements of supports.

`_forces` of a load are the nodal forces (d, nodes) on its body: per unit depth in the plane, and
for the whole circumference in an axisymmetric model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_type_hints

import numpy as np
from skfem import Basis

from ..base import Array, check_text, finite_array, finite_number, shown
from ..errors import ModelError
from .bodies import Body
from .elasticity import (
    Amount,
    Kinematics,
    basis_of,
    boundary_forces,
    element_means,
    gradient_forces,
    volume_forces,
)
from .supports import Place, axis_of, checked_axis, checked_place


class Part:
    """Base of loads, which checks their names, places, and amounts: numbers or functions.

    A load with components x, y and z needs at least one component, or a moment.
    """

    def __post_init__(self) -> None:
        has_no_component = all(getattr(self, axis, 0.0) is None for axis in "xyz")
        if has_no_component and getattr(self, "moment", None) is None:
            raise ModelError(
                f"{type(self).__name__}: x, y and z are all missing; give at least one"
            )
        for name, kind in get_type_hints(type(self)).items():
            value = getattr(self, name)
            if kind is str:
                check_text(name, value, "a name of the model or its mesh")
            elif kind == Place:
                object.__setattr__(self, name, checked_place(value))
            elif kind in (Amount, Amount | None) and callable(value):
                if isinstance(value, type):
                    raise ModelError(
                        f"{name}: {shown(value)}; give a number or a function of x and y, and z in "
                        "space"
                    )
            elif kind is float or (
                kind in (float | None, Amount, Amount | None) and value is not None
            ):
                object.__setattr__(self, name, finite_number(name, value))


def components(load: Any, points: Array) -> Array:
    """(d, ...) values of x, y and z of a load at points (d, ...)."""
    kind = type(load).__name__
    if len(points) == 2 and load.z != 0:
        raise ModelError(
            f"{kind} z: {shown(load.z)}; body {load.body!r} is plane, give x and y alone"
        )
    axes = "xyz"[: len(points)]
    return np.array([values_at(f"{kind} {axis}", getattr(load, axis), points) for axis in axes])


def values_at(name: str, amount: Amount, points: Array) -> Array:
    """Values of a number or a function at points (d, ...); error messages call it `name`."""
    shape = points.shape[1:]
    if not callable(amount):
        return np.full(shape, float(amount))
    try:
        returned = amount(*points)
    except Exception as error:  # a function of the user may raise any error
        axes = "two arrays, x and y" if len(points) == 2 else "three arrays, x, y and z"
        raise ModelError(
            f"{name}: the function raised {type(error).__name__}: {error}; it gets {axes}"
        ) from error
    values = finite_array(f"{name}, of the function", returned)
    if values.shape not in ((), shape):
        raise ModelError(
            f"{name}: the function gave shape {values.shape} at points of shape {shape}; give one "
            "value for each point"
        )
    return np.broadcast_to(values, shape)


class ForceLoad(Part):
    """Base of loads with components x, y and z, which are zero by default."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for axis in "xyz":
            if getattr(self, axis) is None:
                object.__setattr__(self, axis, 0.0)


class _OnFace(Part):
    """Base of loads on a named boundary, with the traction `_on_face` at points and normals."""

    def _forces(self: Any, body: Body, kinematics: Kinematics) -> Array:
        facets = body.boundary(self.boundary, type(self).__name__.lower())
        return boundary_forces(body.mesh, facets, self._on_face, kinematics)

    def _size(self: Any, body: Body, kinematics: Kinematics) -> float:
        def strength(points: Array, normals: Array) -> Array:
            return np.asarray(np.linalg.norm(self._on_face(points, normals), axis=0)[None])

        facets = body.boundary(self.boundary, "loads")
        return float(boundary_forces(body.mesh, facets, strength, kinematics).sum())


@dataclass(frozen=True)
class Traction(_OnFace, ForceLoad):
    """Traction (x, y), in space (x, y, z), force per area, on a named boundary of one body.

    Each component is a number or a function of the coordinates (arrays), and zero by default.

    Raises
    ------
    ModelError
        The body or the boundary is not a string, no component is given, or a component is neither a
        finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Traction("punch", "top", y=-1e6)  # a pressure
    Traction(body='punch', boundary='top', x=0.0, y=-1000000.0, z=0.0)
    >>> ramp = fo.fem.Traction("punch", "top", y=lambda x, y: -x)
    """

    body: str
    boundary: str
    x: Amount | None = None
    y: Amount | None = None
    z: Amount | None = None

    def _on_face(self, points: Array, _normals: Array) -> Array:
        return components(self, points)


@dataclass(frozen=True)
class Pressure(_OnFace):
    """Pressure on a named boundary of one body, against its outward normal, force per area.

    The amount is a number or a function of the coordinates (arrays).

    Raises
    ------
    ModelError
        The body or the boundary is not a string, or the amount is neither a finite number nor a
        function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Pressure("collar", "bore", 2.5)
    Pressure(body='collar', boundary='bore', amount=2.5)
    """

    body: str
    boundary: str
    amount: Amount = 1.0

    def _on_face(self, points: Array, normals: Array) -> Array:
        return -values_at("pressure", self.amount, points) * normals


@dataclass(frozen=True)
class BodyForce(ForceLoad):
    """Force per volume (x, y), in space (x, y, z), on one body: gravity is (0, -density g).

    Each component is a number or a function of the coordinates (arrays), and zero by default.

    Raises
    ------
    ModelError
        The body is not a string, no component is given, or a component is neither a finite number
        nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.BodyForce("block", y=-7850 * 9.81)
    BodyForce(body='block', x=0.0, y=-77008.5, z=0.0)
    """

    body: str
    x: Amount | None = None
    y: Amount | None = None
    z: Amount | None = None

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        return volume_forces(body.mesh, lambda points: components(self, points), kinematics)

    def _size(self, body: Body, kinematics: Kinematics) -> float:
        def strength(points: Array) -> Array:
            return np.asarray(np.linalg.norm(components(self, points), axis=0)[None])

        return float(volume_forces(body.mesh, strength, kinematics).sum())


@dataclass(frozen=True)
class Centrifugal(Part):
    """Centrifugal force of a spinning body: density times angular speed squared times distance.

    The distance is measured from the axis of the spin. In the plane the axis is normal to the
    plane, through the centre. In an axisymmetric model it is the axis x = 0. The amplitude of the
    load case multiplies the force, which is proportional to the square of the speed.

    Parameters
    ----------
    body
        Name of the body in its model.
    density
        Mass per volume, >= 0.
    speed
        Angular speed, radians per time.
    centre
        Point (x, y), in space (x, y, z), of the axis; None: the origin.
    axis
        Direction (x, y, z) of the axis of a body in space, of any length.

    Raises
    ------
    ModelError
        The body is not a string, a number is not finite, the density is negative, or the axis has
        length zero.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Centrifugal("disc", density=7850.0, speed=300.0, centre=(0.0, 1.0))
    Centrifugal(body='disc', density=7850.0, speed=300.0, centre=(0.0, 1.0), axis=(0.0, 0.0, 1.0))
    """

    body: str
    density: float
    speed: float = 1.0
    centre: tuple[float, ...] | None = None
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        finite_number("density", self.density, least=0.0)
        checked_axis(self)

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        d = body.mesh.dim()
        centre, axis = axis_of(self, d)
        if kinematics == "axisymmetric" and centre[0] != 0:
            raise ModelError(
                f"centre: {self.centre}; axisymmetric bodies spin about their axis, x = 0"
            )
        along = np.array([0.0, 1.0]) if kinematics == "axisymmetric" else axis[:d]

        def force(points: Array) -> Array:
            arm = points - centre.reshape(-1, 1, 1)
            arm_along = np.multiply.outer(along, np.einsum("a,a...->...", along, arm))
            return self.density * self.speed**2 * np.asarray(arm - arm_along)

        return volume_forces(body.mesh, force, kinematics)


@dataclass(frozen=True)
class Expansion(Part):
    """Free expansion of one body, a strain that is equal in all directions.

    For a change of temperature, it is the change times the expansion coefficient. The strain is a
    number or a function of the coordinates (arrays).

    Raises
    ------
    ModelError
        The body is not a string, or the strain is neither a finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Expansion("collar", 12e-6 * 100.0).body
    'collar'
    """

    body: str
    strain: Amount = 1.0

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        basis = basis_of(body.mesh)
        return gradient_forces(basis, self._tension(body, kinematics, basis), kinematics)

    def _strain(self, basis: Basis) -> Array:
        """The expansion at the integration points of a basis."""
        return values_at("strain", self.strain, np.asarray(basis.global_coordinates()))

    def _tension(self, body: Body, kinematics: Kinematics, basis: Basis) -> Array:
        """Tension that the expansion subtracts from the stress, at the integration points.

        With mean dilatation, the first Lame constant resists the mean of div u over an element, so
        the mean of the expansion is subtracted there.
        """
        lam, mu = body.material._plane_lame(kinematics)
        strain = self._strain(basis)
        mean_strain = strain
        if body.element == "mean_dilatation":
            mean_strain = element_means(basis.dx, strain)
        free_directions = 2 if kinematics == "plane_stress" else 3
        return free_directions * lam * mean_strain + 2 * mu * strain


@dataclass(frozen=True, eq=False)
class NodalForces(Part):
    """Forces on the nodes of one body, (d, nodes): part of the load of a mode, see `Modes.load`."""

    body: str
    forces: Array

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        if np.shape(self.forces) != body.mesh.p.shape:
            raise ModelError(
                f"forces: shape {np.shape(self.forces)}, and body {self.body!r} has (d, nodes) = "
                f"{body.mesh.p.shape}; give the load of a mode to the model whose modes were "
                "computed, with the same bolts"
            )
        return finite_array("forces", self.forces)


@dataclass(frozen=True)
class Displacement(Part):
    """Prescribed displacement (x, y), in space (x, y, z), of the nodes of a support.

    A support must hold the nodes in the directions of the displacement. Displacements of one load
    case do not add up: if several contain the same node, they must move it equally.

    Parameters
    ----------
    body, where
        Body and place of the nodes, as in a `Support`.
    x, y, z
        Displacements, each a number or a function of the coordinates (arrays); None: zero, or free
        if no support holds the nodes.

    Raises
    ------
    ModelError
        No displacement is given, or one is neither a finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Displacement("block", "bottom", y=0.01)
    Displacement(body='block', where='bottom', x=None, y=0.01, z=None)
    """

    body: str
    where: Place
    x: Amount | None = None
    y: Amount | None = None
    z: Amount | None = None
