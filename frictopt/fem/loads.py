"""Loads of a body besides a uniform traction: pressure, forces per volume, free expansion, displacements of supports."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from skfem import Basis

from ..contact.checks import Array, check_text, finite_number, shown
from ..errors import ModelError
from .bodies import Body
from .elasticity import ELEMENTS, element_means
from .forms import Amount, Kinematics, boundary_forces, checked_amount, gradient_forces, values_at, volume_forces

__all__ = ["BodyForce", "Centrifugal", "Displacement", "Expansion", "Pressure"]


@dataclass(frozen=True)
class Pressure:
    """Pressure on a named boundary of one body, against its outward normal: a number or a function of x and y (arrays), force per area.

    Raises
    ------
    ModelError
        A body or a boundary that is no text, an amount that is neither a finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Pressure("collar", "bore", 2.5)
    Pressure(body='collar', boundary='bore', amount=2.5)
    """

    body: str
    boundary: str
    amount: Amount = 1.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        check_text("boundary", self.boundary, "the name of a boundary of the mesh")
        object.__setattr__(self, "amount", checked_amount("amount", self.amount))

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """(2, nodes) nodal forces on the body, force per depth (axisymmetric: of the whole circumference)."""

        def traction(x: Array, y: Array, normal: Array) -> list[Array]:
            pressure = values_at("pressure", self.amount, x, y)
            return [-pressure * normal[0], -pressure * normal[1]]

        return boundary_forces(body.mesh, self.boundary, traction, kinematics)


@dataclass(frozen=True)
class BodyForce:
    """Force per volume (x, y) on one body: gravity is (0, -density g). Each is a number or a function of x and y (arrays).

    Raises
    ------
    ModelError
        A body that is no text, forces that are neither finite numbers nor functions.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.BodyForce("block", y=-7850 * 9.81)
    BodyForce(body='block', x=0.0, y=-77008.5)
    """

    body: str
    x: Amount = 0.0
    y: Amount = 0.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        for name in ("x", "y"):
            object.__setattr__(self, name, checked_amount(f"body force {name}", getattr(self, name)))

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """(2, nodes) nodal forces on the body, force per depth (axisymmetric: of the whole circumference)."""

        def force(x: Array, y: Array) -> list[Array]:
            return [values_at("body force x", self.x, x, y), values_at("body force y", self.y, x, y)]

        return volume_forces(body.mesh, force, kinematics)


@dataclass(frozen=True)
class Centrifugal:
    """Centrifugal force of a body that spins: density times the square of the angular speed times the distance from a centre.

    The axis of the spin is normal to the plane and goes through the centre; of an axisymmetric model it is the axis, x = 0. An amplitude of the
    load case multiplies the force, which goes with the square of the speed.

    Parameters
    ----------
    body
        Name of the body in its model.
    density
        Mass per volume, >= 0.
    speed
        Angular speed, radians per time.
    centre
        Point (x, y) of the axis.

    Raises
    ------
    ModelError
        A body that is no text, numbers that are not finite, a negative density.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Centrifugal("disc", density=7850.0, speed=300.0)
    Centrifugal(body='disc', density=7850.0, speed=300.0, centre=(0.0, 0.0))
    """

    body: str
    density: float
    speed: float = 1.0
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        object.__setattr__(self, "density", finite_number("density", self.density, least=0.0))
        object.__setattr__(self, "speed", finite_number("speed", self.speed))
        if not isinstance(self.centre, tuple | list) or len(self.centre) != 2:
            raise ModelError(f"centre: {shown(self.centre)}; give one point (x, y)")
        object.__setattr__(self, "centre", tuple(finite_number("centre", value) for value in self.centre))

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """(2, nodes) nodal forces on the body, force per depth (axisymmetric: of the whole circumference)."""
        if kinematics == "axisymmetric" and self.centre[0] != 0:
            raise ModelError(f"centre: {self.centre}; axisymmetric bodies spin about their axis, x = 0")
        pull = self.density * self.speed**2

        def force(x: Array, y: Array) -> list[Array]:
            return [pull * (x - self.centre[0]), 0 * y if kinematics == "axisymmetric" else pull * (y - self.centre[1])]

        return volume_forces(body.mesh, force, kinematics)


@dataclass(frozen=True)
class Expansion:
    """Free expansion of one body, the same in all directions: a strain, for a change of temperature its product with the expansion coefficient.

    A number or a function of x and y (arrays).

    Raises
    ------
    ModelError
        A body that is no text, a strain that is neither a finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Expansion("collar", 12e-6 * 100.0).body
    'collar'
    """

    body: str
    strain: Amount = 1.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        object.__setattr__(self, "strain", checked_amount("strain", self.strain))

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """(2, nodes) nodal forces of the tension that would hold the body back, force per depth (axisymmetric: of the whole circumference)."""
        basis = Basis(body.mesh, ELEMENTS[type(body.mesh)]())
        return gradient_forces(basis, self._tension(body, kinematics, basis), kinematics)

    def _strain(self, basis: Any) -> Array:
        """The expansion at the integration points of a basis."""
        return values_at("strain", self.strain, *(np.asarray(part) for part in basis.global_coordinates()))

    def _tension(self, body: Body, kinematics: Kinematics, basis: Any) -> Array:
        """The tension in the plane that the expansion takes off the stress of the strains, at the integration points of a basis.

        Where the first Lame constant resists the mean dilatation of an element, it is the mean expansion that takes off its part.
        """
        lam, mu = body.material._plane_lame(kinematics)
        strain = self._strain(basis)
        dilatation = strain if body.element == "linear" else element_means(basis, strain)
        return (2 if kinematics == "plane_stress" else 3) * lam * dilatation + 2 * mu * strain


@dataclass(frozen=True)
class Displacement:
    """Prescribed displacement of a support: its nodes move by (x, y) in the directions in which the support holds them.

    Displacements of one load case do not add up: those that share a node move it alike.

    Parameters
    ----------
    body, where
        Body and place of the nodes, as in a `Support`; a support holds them in every direction that is given here.
    x, y
        Displacements, each a number or a function of x and y (arrays); None: zero, or free if no support holds the nodes.

    Raises
    ------
    ModelError
        No displacement, or one that is neither a finite number nor a function.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Displacement("block", "bottom", y=0.01)
    Displacement(body='block', where='bottom', x=None, y=0.01)
    """

    body: str
    where: str | tuple[float, float]
    x: Amount | None = None
    y: Amount | None = None

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        if not isinstance(self.where, str):
            if not isinstance(self.where, tuple | list) or len(self.where) != 2:
                raise ModelError(f"where: {shown(self.where)}; give the name of a boundary or one point (x, y)")
            object.__setattr__(self, "where", tuple(finite_number("where", value) for value in self.where))
        if self.x is None and self.y is None:
            raise ModelError("displacement: neither x nor y; give one of them")
        for name in ("x", "y"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, checked_amount(f"displacement {name}", getattr(self, name)))

    def _values(self, points: Array) -> dict[str, Array]:
        """Displacements of points (2, n) in the directions that are given."""
        given = {"x": self.x, "y": self.y}
        return {name: values_at(f"displacement {name}", amount, *np.asarray(points)) for name, amount in given.items() if amount is not None}
