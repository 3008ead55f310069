"""The parts of a contact model: bodies and supports."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh

from ..contact.checks import Array, check_text, choice, finite_numbers, shown
from ..errors import ModelError
from .elasticity import ELEMENT_NAMES, ELEMENTS, ElementName, Material
from .ordering import Integers

__all__ = ["Body", "Place", "Support", "check_kind", "checked_place", "checked_point"]

Place = str | tuple[float, ...]
"""Name of a boundary, or the coordinates of one node."""


@dataclass(frozen=True, eq=False)
class Body:
    """One elastic body: a scikit-fem mesh with named boundaries, and its material.

    Parameters
    ----------
    mesh
        The mesh, lengths in any unit: `MeshTri` or `MeshQuad` in the plane, `MeshTet` or `MeshHex` in space.
    material
        Its material.
    element
        "linear", or "mean_dilatation": quadrilaterals and hexahedra that do not lock as nu approaches 0.5 (linear triangles, tetrahedra always do).

    Raises
    ------
    ModelError
        Elements that are not convex, turned inside out or without area or volume, others than these linear ones, a mesh of several parts that share
        no edge (in space no face), nodes that belong to no element.

    Examples
    --------
    >>> from skfem import MeshHex, MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[1] == 0})
    >>> fo.Body(mesh, fo.Material(E=70e9, nu=0.33)).boundary_nodes("contact", "interface").size
    3
    >>> mesh = MeshHex.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[2] == 0})
    >>> fo.Body(mesh).boundary_nodes("contact", "interface").size
    6
    """

    mesh: Mesh
    material: Material = Material()
    element: ElementName = "linear"

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        check_kind(self.mesh)
        if not isinstance(self.material, Material):
            raise ModelError(f"material: a {type(self.material).__name__}; give a Material")
        _check_elements(self.mesh)

    def boundary(self, name: str, argument: str) -> Integers:
        """Facets of the boundary of that name, which lie on the outline of the mesh; error messages call it `argument`."""
        boundaries = self.mesh.boundaries or {}
        if not isinstance(name, str) or name not in boundaries:
            hint = "; a Contact takes the boundary 'contact' of both bodies unless others are named" if shown(name) == "'contact'" else ""
            raise ModelError(f"{argument}: boundary {shown(name)} is unknown; this mesh names {sorted(boundaries)}{hint}")
        facets = np.unique(boundaries[name])
        if not len(facets) or np.any(self.mesh.f2t[1, facets] >= 0):
            raise ModelError(
                f"{argument}: boundary {name!r} has no facets, or facets inside the body; name facets of its outline, and if two bodies share the "
                "nodes there, let `split_bodies` give each its own"
            )
        return facets

    def boundary_nodes(self, name: str, argument: str) -> Integers:
        """Nodes on the boundary of that name; error messages call it `argument`."""
        return np.unique(self.mesh.facets[:, self.boundary(name, argument)])


@dataclass(frozen=True)
class Support:
    """A support: nodes of one body whose displacements are zero.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        Name of a boundary, or the coordinates (x, y), in space (x, y, z), of one node.
    directions
        The displacements that are zero: "x", "y", "z", or several of them, such as "xy"; None: all that the body has.

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
    where: Place
    directions: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] | None = None

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        if self.directions is not None:
            choice("directions", self.directions, ("x", "y", "z", "xy", "xz", "yz", "xyz"))
        object.__setattr__(self, "where", checked_place(self.where))


def checked_place(where: object) -> Place:
    """Check the name of a boundary or the coordinates of a point."""
    return where if isinstance(where, str) else checked_point("where", where, "the name of a boundary or one point (x, y), in space (x, y, z)")


def checked_point(name: str, point: object, words: str, sizes: tuple[int, ...] = (2, 3)) -> tuple[float, ...]:
    """Check a row of two or three coordinates, which error messages describe in words."""
    if not isinstance(point, tuple | list) or len(point) not in sizes:
        raise ModelError(f"{name}: {shown(point)}; give {words}")
    return tuple(finite_numbers(name, point))


def check_kind(mesh: Mesh) -> None:
    """Check that a mesh has linear elements of a kind that bodies may have.

    Raises
    ------
    ModelError
        It does not.
    """
    if type(mesh) not in ELEMENTS:
        quadratic = hasattr(mesh, "doflocs") and type(mesh).__name__.endswith("2")
        remedy = "; its elements are quadratic: mesh with linear ones (gmsh: Mesh.ElementOrder = 1)" if quadratic else " of straight-sided elements"
        raise ModelError(f"mesh: a {type(mesh).__name__}; give a MeshTri, MeshQuad, MeshTet or MeshHex{remedy}")


def _check_elements(mesh: Mesh) -> None:
    """Check that all elements are convex and have a size, that they hang together by their facets, and that every node belongs to one."""
    if not np.isfinite(mesh.p).all():
        raise ModelError(f"mesh: node {int(np.argwhere(~np.isfinite(mesh.p))[0][1])} has coordinates that are not finite")
    area, edge = ("area", "edge") if mesh.dim() == 2 else ("volume", "face")
    sizes = _sizes(mesh)
    bad = ~((sizes > 0).all(axis=0) | (sizes < 0).all(axis=0))
    if bad.any():
        raise ModelError(
            f"mesh: {int(bad.sum())} elements are not convex or have no {area}, the first is element {int(np.argmax(bad))}; repair the mesh"
        )
    inner, elements = mesh.f2t[:, mesh.f2t[1] >= 0], mesh.t.shape[1]
    parts, _ = connected_components(coo_matrix((np.ones(inner.shape[1]), inner), shape=(elements, elements)), directed=False)
    if parts != 1:
        raise ModelError(f"mesh: {parts} parts that share no {edge}; give one connected body (merge nodes that coincide)")
    if loose := mesh.p.shape[1] - len(np.unique(mesh.t)):
        raise ModelError(f"mesh: {loose} nodes belong to no element; remove them")


def _sizes(mesh: Mesh) -> Array:
    """(corners, elements) signed area or volume of the elements as it is at each of their corners."""
    corners, element = mesh.elem.refdom.p, ELEMENTS[type(mesh)]()
    slopes = np.array([np.broadcast_to(element.lbasis(corners, i)[1], corners.shape) for i in range(len(mesh.t))])
    return np.asarray(np.linalg.det(np.einsum("aie,ibk->keab", mesh.p[:, mesh.t], slopes)))
