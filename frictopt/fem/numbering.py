"""Bodies of a model in one numbering, body after body, and what their supports hold; in any number of dimensions."""

import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..contact.checks import Array, shown
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError, ModelWarning
from .ordering import Integers

__all__ = ["NumberedBodies", "check_one_piece", "described", "linear_mesh", "outline_facets", "warn_of_contrast"]

UNITS_APART = 2e5  # Pa and MPa differ by 1e6, rubber and steel by up to 1e5

B = TypeVar("B", bound=Any)  # a body: its `mesh` of scikit-fem, and `boundary_nodes`


@dataclass(frozen=True, eq=False)
class NumberedBodies(Generic[B]):
    """The nodes and unknowns of all bodies: of each body all x displacements, then all y, and so on.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports, each with the name of its `body`, `where` it holds it and in which `directions`.
    """

    bodies: Mapping[str, B]
    supports: Sequence[Any]

    @cached_property
    def first_node(self) -> dict[str, int]:
        """Number of the first node of each body, when all nodes are counted body after body."""
        sizes = [body.mesh.p.shape[1] for body in self.bodies.values()]
        return dict(zip(self.bodies, (np.cumsum(sizes) - sizes).tolist(), strict=True))

    @cached_property
    def points(self) -> Array:
        """(nodes, d) coordinates."""
        return np.concatenate([body.mesh.p.T for body in self.bodies.values()])

    @cached_property
    def rows(self) -> Integers:
        """(nodes, d) unknowns of all nodes."""
        return np.concatenate([self.unknowns(name) for name in self.bodies])

    def body(self, argument: str, name: str) -> B:
        """The body of that name."""
        if name not in self.bodies:
            raise ModelError(f"{argument}: body {name!r} is unknown; this model has {sorted(self.bodies)}")
        return self.bodies[name]

    def bodies_of(self, contact: Any) -> tuple[B, B]:
        """The two bodies of a contact."""
        for name in (contact.body_1, contact.body_2):
            if owners := [owner for owner, body in self.bodies.items() if name not in self.bodies and name in (body.mesh.boundaries or {})]:
                raise ModelError(
                    f"contacts: body {name!r} is unknown, but it is a boundary of {owners[0]!r}; the order is "
                    "Contact(body_1, body_2, boundary_1, boundary_2)"
                )
        return self.body("contacts", contact.body_1), self.body("contacts", contact.body_2)

    def unknowns(self, name: str) -> Integers:
        """(nodes, d) unknowns of a body."""
        d, nodes = self.bodies[name].mesh.p.shape
        return np.asarray(d * self.first_node[name] + np.arange(nodes)[:, None] + nodes * np.arange(d))

    def held(self) -> Integers:
        """Unknowns that the supports hold."""
        held = [np.zeros(0, dtype=np.intp)]
        for support in self.supports:
            nodes = self.nodes("supports", support)
            held += [self.unknowns(support.body)[nodes, "xyz".index(direction)] for direction in support.directions]
        return np.unique(np.concatenate(held))

    def nodes(self, argument: str, support: Any) -> Integers:
        """Nodes of its body that a support holds, or a displacement moves."""
        body = self.body(argument, support.body)
        if isinstance(support.where, str):
            return np.asarray(body.boundary_nodes(support.where, f"support of body {support.body!r}"))
        distance = np.linalg.norm(body.mesh.p - np.array(support.where)[:, None], axis=0)
        if distance.min() > SAME_POINT * np.ptp(body.mesh.p):
            nearest = tuple(float(value) for value in body.mesh.p[:, distance.argmin()])
            raise ModelError(f"support of body {support.body!r}: no node at {support.where}; the nearest is at {nearest}")
        return np.array([distance.argmin()])


def linear_mesh(argument: str, mesh: Any, kinds: Collection[type], words: str) -> None:
    """Check that a mesh is of one of some kinds; error messages call it `argument`, and the kinds in `words`.

    Raises
    ------
    ModelError
        It is not.
    """
    if type(mesh) not in kinds:
        quadratic = hasattr(mesh, "doflocs") and type(mesh).__name__.endswith("2")
        remedy = "; its elements are quadratic: mesh with linear ones (gmsh: Mesh.ElementOrder = 1)" if quadratic else " of straight-sided elements"
        raise ModelError(f"{argument}: a {type(mesh).__name__}; give a {words}{remedy}")


def warn_of_contrast(bodies: Mapping[str, Any], contacts: Sequence[Any]) -> None:
    """Warn of two bodies in contact whose moduli of elasticity are as far apart as those of two units; for the constructor of a model."""
    for contact in contacts:
        moduli = [bodies[name].material.E for name in (contact.body_1, contact.body_2)]
        if max(moduli) >= UNITS_APART * min(moduli):
            warnings.warn(
                f"bodies: E = {moduli[0]:g} of {contact.body_1!r} and {moduli[1]:g} of {contact.body_2!r}; are both in the same unit (Pa or MPa)?",
                ModelWarning,
                stacklevel=4,
            )
            return


def described(bodies: Mapping[str, Any]) -> dict[str, str]:
    """Material, extents and number of nodes of each body, as a text."""

    def text(body: Any) -> str:
        extents = " x ".join(f"{extent:.4g}" for extent in np.ptp(body.mesh.p, axis=1))
        return f"E={body.material.E:g}, nu={body.material.nu:g}, {extents}, {body.mesh.p.shape[1]} nodes"

    return {name: text(body) for name, body in bodies.items()}


def check_one_piece(mesh: Any) -> None:
    """Check that the elements of a mesh hang together by their facets, and that every node belongs to one.

    Raises
    ------
    ModelError
        They do not.
    """
    inner, elements = mesh.f2t[:, mesh.f2t[1] >= 0], mesh.t.shape[1]
    parts, _ = connected_components(coo_matrix((np.ones(inner.shape[1]), inner), shape=(elements, elements)), directed=False)
    if parts != 1:
        facet = "edge" if mesh.dim() == 2 else "face"
        raise ModelError(f"mesh: {parts} parts that share no {facet}; give one connected body (merge nodes that coincide)")
    if loose := mesh.p.shape[1] - len(np.unique(mesh.t)):
        raise ModelError(f"mesh: {loose} nodes belong to no element; remove them")


def outline_facets(mesh: Any, name: str, argument: str) -> Integers:
    """Facets of the boundary of that name, which lie on the outline of the mesh; error messages call it `argument`."""
    boundaries = mesh.boundaries or {}
    if not isinstance(name, str) or name not in boundaries:
        hint = (
            "; a Contact takes the boundary 'contact' of both bodies unless others are named" if isinstance(name, str) and name == "contact" else ""
        )
        raise ModelError(f"{argument}: boundary {shown(name)} is unknown; this mesh names {sorted(boundaries)}{hint}")
    facets = np.asarray(boundaries[name])
    if not len(facets) or np.any(mesh.f2t[1, facets] >= 0):
        outline = "the outline" if mesh.dim() == 2 else "its surface"
        raise ModelError(f"{argument}: boundary {name!r} has no facets, or facets inside the body; name facets of {outline}")
    return facets
