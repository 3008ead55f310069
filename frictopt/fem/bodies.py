"""The parts of a contact model: bodies, supports and tractions."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..contact.checks import Array, check_text, choice, finite_number, shown
from ..errors import ModelError
from .elasticity import ELEMENT_NAMES, ELEMENTS, ElementName, Material
from .forms import Amount, Kinematics, boundary_forces, checked_amount, values_at
from .numbering import check_one_piece, linear_mesh, outline_facets
from .ordering import Integers

__all__ = ["Body", "Support", "Traction"]


@dataclass(frozen=True, eq=False)
class Body:
    """One elastic body: a scikit-fem mesh (`MeshTri` or `MeshQuad`) with named boundaries, and its material.

    Parameters
    ----------
    mesh
        The mesh, lengths in any unit.
    material
        Its material.
    element
        "linear", or "mean_dilatation": quadrilaterals that do not lock as nu approaches 0.5 (linear triangles always do).

    Raises
    ------
    ModelError
        Elements that are not convex or have no area, elements other than linear triangles or quadrilaterals, or a mesh of several parts
        that share no edge.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[1] == 0})
    >>> fo.Body(mesh, fo.Material(E=70e9, nu=0.33)).boundary_nodes("contact", "interface").size
    3
    """

    mesh: Any
    material: Material = Material()
    element: ElementName = "linear"

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        linear_mesh("mesh", self.mesh, ELEMENTS, "MeshTri or a MeshQuad")
        if not isinstance(self.material, Material):
            raise ModelError(f"material: a {type(self.material).__name__}; give a Material")
        _check_elements(self.mesh)
        check_one_piece(self.mesh)

    def boundary_nodes(self, name: str, argument: str) -> Integers:
        """Nodes on the boundary of that name; error messages call it `argument`."""
        return np.unique(self.mesh.facets[:, outline_facets(self.mesh, name, argument)])


@dataclass(frozen=True)
class Support:
    """A support: nodes of one body whose displacements are zero.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        Name of a boundary, or the coordinates (x, y) of one node.
    directions
        "x", "y" or "xy": the displacements that are zero.

    Raises
    ------
    ModelError
        No such directions, a body that is no text, a place that is neither a text nor a point.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Support("block", "bottom", "y")
    Support(body='block', where='bottom', directions='y')
    >>> fo.Support("block", (0, -1), "x")
    Support(body='block', where=(0.0, -1.0), directions='x')
    """

    body: str
    where: str | tuple[float, float]
    directions: Literal["x", "y", "xy"] = "xy"

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        choice("directions", self.directions, ("x", "y", "xy"))
        if not isinstance(self.where, str):
            if not isinstance(self.where, tuple | list) or len(self.where) != 2:
                raise ModelError(f"where: {shown(self.where)}; give the name of a boundary or one point (x, y)")
            object.__setattr__(self, "where", tuple(finite_number("where", value) for value in self.where))


@dataclass(frozen=True)
class Traction:
    """Traction (x, y), force per area, on a named boundary of one body; each is a number or a function of x and y (arrays).

    Raises
    ------
    ModelError
        A body or a boundary that is no text, tractions that are neither finite numbers nor functions.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Traction("punch", "top", y=-1e6)  # a pressure
    Traction(body='punch', boundary='top', x=0.0, y=-1000000.0)
    """

    body: str
    boundary: str
    x: Amount = 0.0
    y: Amount = 0.0

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        check_text("boundary", self.boundary, "the name of a boundary of the mesh")
        for name in ("x", "y"):
            object.__setattr__(self, name, checked_amount(f"traction {name}", getattr(self, name)))

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        """(2, nodes) nodal forces on the body, force per depth (axisymmetric: of the whole circumference)."""

        def traction(x: Array, y: Array, _: Array) -> list[Array]:
            return [values_at("traction x", self.x, x, y), values_at("traction y", self.y, x, y)]

        return boundary_forces(body.mesh, self.boundary, traction, kinematics)


def _check_elements(mesh: Any) -> None:
    """Check that all elements are convex and have area."""
    if not np.isfinite(mesh.p).all():
        raise ModelError(f"mesh: node {int(np.argwhere(~np.isfinite(mesh.p))[0][1])} has coordinates that are not finite")
    corners = mesh.p[:, mesh.t]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, corners - np.roll(corners, 1, axis=1)
    turns = behind[0] * ahead[1] - behind[1] * ahead[0]
    bad = ~((turns > 0).all(axis=0) | (turns < 0).all(axis=0))
    if bad.any():
        raise ModelError(
            f"mesh: {int(bad.sum())} elements are not convex or have no area, the first is element {int(np.argmax(bad))}; repair the mesh"
        )
