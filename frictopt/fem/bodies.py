"""The bodies of a contact model, of their own meshes or of one that is split."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from skfem import Mesh

from ..base import Array, Integers, check_text, choice, first_of, shown
from ..errors import ModelError
from .elasticity import (
    ELEMENT_NAMES,
    KINEMATICS,
    QUADRATIC,
    ElementName,
    Kinematics,
    Material,
    facet_nodes,
    functions_of,
    parts_of,
    points_from,
    quadratic,
    through_corners,
)

_UNITS_APART = 2e5  # Pa and MPa differ by 1e6, rubber and steel by up to 1e5
_THOUSANDFOLD = (
    500.0,
    5000.0,
    # GPa and MPa differ by 1000, and metals by up to 5; polymers on steel by less, rubber on steel by
    # more
)
_SIZES_APART = 500.0  # mm and m differ by 1000, a pad and a half-plane by some hundred


@dataclass(frozen=True, eq=False)
class Body:
    """One elastic body: a scikit-fem mesh with named boundaries, and its material.

    Parameters
    ----------
    mesh
        The mesh, lengths in any unit: `MeshTri` or `MeshQuad` in the plane, `MeshTet` or `MeshHex`
        in space; or with curved sides `MeshTri2`, `MeshQuad2`, `MeshTet2` or `MeshHex2`, the
        elements of which are quadratic.
    material
        Its material.
    element
        "linear"; "quadratic": displacements are quadratic in each element, and `mesh` becomes the
        mesh with nodes amid its sides; or "mean_dilatation": linear quadrilaterals and hexahedra
        that do not lock as nu approaches 0.5. Linear triangles and tetrahedra always lock,
        quadratic ones do not. None: as the mesh is.

    Raises
    ------
    ModelError
        Elements that are not convex, turned inside out or without area or volume, others than
        these, a quadratic mesh with linear elements, a mesh of several parts that share no edge (in
        space no face), nodes that belong to no element.

    Examples
    --------
    >>> from skfem import MeshHex, MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[1] == 0})
    >>> fo.Body(mesh, fo.Material(E=70e9, nu=0.33)).boundary_nodes("contact", "interface").size
    3
    >>> mesh = MeshHex.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0], [0.0, 1.0]).with_boundaries({"contact": lambda x: x[2] == 0})
    >>> fo.Body(mesh)
    Body(MeshHex1, 12 nodes, 2 elements, boundaries=['contact'], element='linear', Material(E=1.0,
    nu=0.3, density=None))
    >>> fo.Body(mesh).boundary_nodes("contact", "interface").size
    6
    >>> fo.Body(mesh, element="quadratic").boundary_nodes("contact", "interface").size
    15
    """

    mesh: Mesh
    material: Material = Material()
    element: ElementName | None = None

    def __post_init__(self) -> None:
        check_kind(self.mesh)
        straight = type(self.mesh) in QUADRATIC
        element = choice(
            "element",
            ("linear" if straight else "quadratic") if self.element is None else self.element,
            ELEMENT_NAMES,
        )
        if element != "quadratic" and not straight:
            raise ModelError(
                f"element: {element!r}, but the mesh is a {type(self.mesh).__name__} with quadratic elements; leave `element` out"
            )
        if not isinstance(self.material, Material):
            raise ModelError(f"material: a {type(self.material).__name__}; give a Material")
        vars(self).update(
            element=element,
            mesh=quadratic(self.mesh) if element == "quadratic" and straight else self.mesh,
        )
        _check_elements(self.mesh)

    def __repr__(self) -> str:
        mesh, names = self.mesh, sorted(self.mesh.boundaries or {})
        parts = f"{type(mesh).__name__}, {mesh.p.shape[1]} nodes, {mesh.nelements} elements, boundaries={names}, element={self.element!r}"
        return f"Body({parts}, {self.material})"

    def boundary(self, name: str, argument: str) -> Integers:
        """Facets of the boundary of that name, which lie on the outline of the mesh; error messages call it `argument`."""
        boundaries = self.mesh.boundaries or {}
        if not isinstance(name, str) or name not in boundaries:
            hint = (
                "; a Contact takes the boundary 'contact' of both bodies unless others are named"
                if shown(name) == "'contact'"
                else ""
            )
            raise ModelError(
                f"{argument}: boundary {shown(name)} is unknown; this mesh names {sorted(boundaries)}{hint}"
            )
        facets = np.unique(boundaries[name])
        if not len(facets) or np.any(self.mesh.f2t[1, facets] >= 0):
            hint = "name facets of its outline (`split_bodies` gives bodies that share nodes their own)"
            raise ModelError(
                f"{argument}: boundary {name!r} has no facets, or facets inside the body; {hint}"
            )
        return facets

    def boundary_nodes(self, name: str, argument: str) -> Integers:
        """Nodes on the boundary of that name; error messages call it `argument`."""
        return facet_nodes(self.mesh, self.boundary(name, argument))

    @property
    def through_corners(self) -> Body:
        """The body with linear elements through its corner nodes, which keep their numbers: contacts see it so."""
        if self.element != "quadratic":
            return self
        linear = copy(self)  # one body still where a bolt cuts it
        object.__setattr__(linear, "mesh", through_corners(self.mesh))
        return linear


def check_kind(mesh: Mesh) -> None:
    """Check that a mesh has elements of a kind that bodies may have."""
    kinds = [*QUADRATIC, *QUADRATIC.values()]
    if type(mesh) not in kinds:
        names = ", ".join(kind.__name__ for kind in kinds)
        raise ModelError(
            f"mesh: a {type(mesh).__name__}; give one of scikit-fem with elements of one shape, linear or quadratic: {names}"
        )


def _check_elements(mesh: Mesh) -> None:
    """Check that all elements are convex and have a size, that they hang together by their facets, and that every node belongs to one."""
    if (i := first_of(~np.isfinite(mesh.p).all(axis=0))) is not None:
        raise ModelError(f"mesh: node {i} has coordinates that are not finite")
    sizes = _sizes(mesh)
    bad = ~((sizes > 0).all(axis=0) | (sizes < 0).all(axis=0))
    if (i := first_of(bad)) is not None:
        repair = (
            "repair the mesh"
            if type(mesh) in QUADRATIC
            else "mesh finer, or with straight sides (gmsh: Mesh.SecondOrderLinear = 1)"
        )
        size = "area" if mesh.dim() == 2 else "volume"
        raise ModelError(
            f"mesh: {bad.sum()} elements are not convex or have no {size}, the first is {i}; {repair}"
        )
    if parts := parts_of(mesh.f2t[:, mesh.f2t[1] >= 0], mesh.t.shape[1]).max():
        share = "edge" if mesh.dim() == 2 else "face"
        raise ModelError(
            f"mesh: {parts + 1} parts that share no {share}; give one connected body (merge nodes that coincide)"
        )
    if loose := mesh.p.shape[1] - len(np.unique(mesh.dofs.element_dofs)):
        raise ModelError(f"mesh: {loose} nodes belong to no element; remove them")


def _sizes(mesh: Mesh) -> Array:
    """(nodes, elements) signed area or volume of the elements as it is at each of their nodes."""
    element, nodes = mesh.elem(), mesh.dofs.element_dofs
    slopes = functions_of(element, len(nodes), element.doflocs.T)[1]
    return np.asarray(np.linalg.det(np.einsum("aie,ibk->keab", mesh.p[:, nodes], slopes)))


def split_bodies(
    mesh: Mesh, materials: Mapping[str, Material], *, element: ElementName | None = None
) -> dict[str, Body]:
    """Split a mesh with a named subdomain for each body into bodies with nodes of their own.

    Each body keeps the named boundaries of the mesh that it has facets on. The facets that it
    shares with another body become one more boundary, of the name of that body: between a pin and a
    plate that share nodes the contact is `Contact("pin", "plate", "plate", "pin")`.

    Parameters
    ----------
    mesh
        The mesh, of a kind that a `Body` has, for example of `read_mesh("model.msh")`.
    materials
        Name of a subdomain -> material of the body; every element is in one of them.
    element
        Element of all bodies, see `Body`.

    Returns
    -------
    dict
        Name of the subdomain -> body.

    Raises
    ------
    ModelError
        Another kind of mesh, a subdomain that is unknown, elements in none or in two of the
        subdomains, a boundary called as another body, or what `Body` refuses.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 1.0], [-1.0, 0.0, 1.0])
    >>> mesh = mesh.with_subdomains({"punch": lambda x: x[1] > 0, "block": lambda x: x[1] < 0})
    >>> bodies = fo.split_bodies(mesh, {"punch": fo.Material(E=2.0), "block": fo.Material()})
    >>> sorted(bodies["punch"].mesh.boundaries)
    ['block']
    """
    check_kind(mesh)
    owner = _owners(mesh, materials)
    inner = np.flatnonzero(mesh.f2t[1] >= 0)
    sides, bodies = owner[mesh.f2t[:, inner]], {}
    for number, (name, material) in enumerate(materials.items()):
        elements, boundaries = np.flatnonzero(owner == number), dict(mesh.boundaries or {})
        own = (sides == number).any(axis=0)
        for other, neighbour in enumerate(materials):
            shared = inner[own & (sides == other).any(axis=0)]
            if other != number and len(shared):
                if neighbour in boundaries:
                    raise ModelError(
                        f"mesh: boundary {neighbour!r} has the name of a body that {name!r} shares facets with; call it otherwise"
                    )
                boundaries[neighbour] = shared
        part = replace(mesh, _boundaries=boundaries).restrict(elements, skip_subdomains=True)
        kept = {boundary: facets for boundary, facets in part.boundaries.items() if len(facets)}
        try:
            bodies[name] = Body(
                replace(part, doflocs=points_from(mesh, elements, part), _boundaries=kept),
                material,
                element,
            )
        except ModelError as error:
            raise ModelError(f"body {name!r}: {error}") from error
    return bodies


def _owners(mesh: Mesh, materials: Mapping[str, Material]) -> Integers:
    """(elements,) number of the subdomain that each element is in, in the order of the materials."""
    if not isinstance(materials, Mapping) or not materials:
        raise ModelError(
            f"materials: {shown(materials)}; give a mapping, name of a subdomain -> Material"
        )
    subdomains, owner = mesh.subdomains or {}, np.full(mesh.t.shape[1], -1)
    for number, name in enumerate(materials):
        if name not in subdomains:
            hint = (
                ""
                if subdomains
                else "; name each body in the mesh (gmsh: a physical group of its volumes, in the plane of its surfaces)"
            )
            raise ModelError(
                f"materials: subdomain {name!r} is unknown; this mesh names {sorted(subdomains)}{hint}"
            )
        elements = np.asarray(subdomains[name])
        if np.any(owner[elements] >= 0):
            raise ModelError(
                f"materials: subdomain {name!r} shares elements with {list(materials)[owner[elements].max()]!r}; give each to one body"
            )
        owner[elements] = number
    if owner.min() < 0:
        raise ModelError(
            f"materials: {int((owner < 0).sum())} elements are in none of {list(materials)}; name all subdomains, or remove these"
        )
    return owner


def checked_kinematics(kinematics: Kinematics | None, bodies: Mapping[str, Body]) -> Kinematics:
    """Check the bodies, and the kinematics by their dimension."""
    for name, body in bodies.items():
        check_text("bodies: name", name, "a printable text")
        if not isinstance(body, Body):
            raise ModelError(
                f"bodies[{name!r}]: a {type(body).__name__}; give a Body(mesh, material)"
            )
    named = {body.mesh.dim(): name for name, body in reversed(list(bodies.items()))}
    if len(named) > 1:
        raise ModelError(
            f"bodies: {named[2]!r} is plane, {named[3]!r} in space; give meshes of one dimension"
        )
    usual: Kinematics = "space" if 3 in named else "plane_strain"
    found = choice("kinematics", usual if kinematics is None else kinematics, KINEMATICS)
    if (found == "space") != (3 in named):
        raise ModelError(
            f"kinematics: {found!r} with bodies {'in space' if 3 in named else 'in the plane'}; leave it out, or give other meshes"
        )
    for name, body in bodies.items() if found == "axisymmetric" else ():
        radius = body.mesh.p[0]
        if radius.min() < 0:
            raise ModelError(
                f"bodies[{name!r}]: x = {radius.min():g} at node {int(radius.argmin())}; of an axisymmetric body x is the radius, >= 0"
            )
        if body.element == "mean_dilatation":
            raise ModelError(
                f"bodies[{name!r}]: element {body.element!r}; axisymmetric bodies have linear or quadratic elements"
            )
    return found


def units_apart(names: Sequence[str], bodies: Sequence[Body]) -> Iterator[str]:
    """Warnings of moduli or sizes of two bodies that may be in different units."""
    E, sizes = (
        [body.material.E for body in bodies],
        [float(np.ptp(body.mesh.p, axis=1).max()) for body in bodies],
    )
    for what, (a, b), most, units in (
        ("E", E, _UNITS_APART, "Pa or MPa"),
        ("size", sizes, _SIZES_APART, "mm or m"),
    ):
        if max(a, b) >= most * min(a, b):
            yield f"bodies: {what} = {a:g} of {names[0]!r} and {b:g} of {names[1]!r}; are both in the same unit ({units})?"
    ratio = max(E) / min(E)
    if _THOUSANDFOLD[0] <= ratio <= _THOUSANDFOLD[1]:
        soft, stiff = (names[E.index(value)] for value in (min(E), max(E)))
        yield (
            f"bodies: E = {min(E):g} of {soft!r} and {max(E):g} of {stiff!r}, {ratio:.4g} times as much; are both in the same unit (MPa or GPa)? "
            "Steel is 20,000 times as stiff as rubber and more, and less than 500 times as stiff as a hard polymer"
        )
