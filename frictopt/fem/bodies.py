"""The bodies of a contact model: each with its mesh, or parts of one mesh."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from skfem import Mesh
from skfem.quadrature import get_quadrature

from ..base import Array, Booleans, Integers, check_text, choice, first_of, shown
from ..errors import ModelError
from .coincidence import coordinate_errors
from .elasticity import (
    ELEMENT_NAMES,
    KINEMATICS,
    QUADRATIC,
    ElementName,
    Kinematics,
    Material,
    element_parts,
    facet_nodes,
    functions_of,
    nodes_from,
    quadratic,
)
from .mixed import MIXED, MIXED_QUADRATIC, with_wedges

# Ratios of moduli and sizes of two bodies that suggest different units.

# Pa and MPa differ by 1e6, rubber and steel by up to 1e5.
_MODULI_APART = 2e5
# mm and m differ by 1000, a pad and a half-plane by some hundred.
_SIZES_APART = 500.0
# MPa and GPa differ by 1000, and metals by up to 5. The modulus of steel over the modulus of a
# polymer is below this range, and over the modulus of rubber it is above.
_THOUSANDFOLD = (500.0, 5000.0)


@dataclass(frozen=True, eq=False)
class Body:
    """An elastic body: a scikit-fem mesh with named boundaries, and its material.

    Parameters
    ----------
    mesh
        The mesh, lengths in any unit: `MeshTri` or `MeshQuad` in the plane; `MeshTet`, `MeshHex` or
        `MeshWedge1` in space. Meshes with curved sides are `MeshTri2`, `MeshQuad2`, `MeshTet2` or
        `MeshHex2`; their elements are quadratic. `read_mesh` also makes meshes of linear elements
        of several shapes, which stay linear.
    material
        Its material.
    element
        "linear"; "quadratic": displacements are quadratic in each element, and `mesh` becomes the
        mesh with midside nodes; or "mean_dilatation": linear quadrilaterals and hexahedra that do
        not lock as nu approaches 0.5. Linear triangles and tetrahedra always lock near 0.5;
        quadratic elements do not. None: as in the mesh.

    Raises
    ------
    ModelError
        Elements are not convex, have no area or volume, or are of another kind. A quadratic mesh is
        combined with another `element`. The mesh has several parts that share no edge (in space no
        face), or nodes that belong to no element.

    Examples
    --------
    >>> from skfem import MeshHex, MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0])
    >>> mesh = mesh.with_boundaries({"contact": lambda x: x[1] == 0})
    >>> fo.fem.Body(mesh, fo.fem.Material(E=70e9, nu=0.33)).boundary_nodes(
    ...     "contact", "interface"
    ... ).size
    3
    >>> mesh = MeshHex.init_tensor([0.0, 0.5, 1.0], [0.0, 1.0], [0.0, 1.0])
    >>> mesh = mesh.with_boundaries({"contact": lambda x: x[2] == 0})
    >>> fo.fem.Body(mesh)  # doctest: +NORMALIZE_WHITESPACE
    Body(MeshHex1, 12 nodes, 2 elements, boundaries=['contact'], element='linear', Material(E=1.0,
    nu=0.3, density=None))
    >>> fo.fem.Body(mesh).boundary_nodes("contact", "interface").size
    6
    >>> fo.fem.Body(mesh, element="quadratic").boundary_nodes("contact", "interface").size
    15
    """

    mesh: Mesh
    material: Material = Material()
    element: ElementName | None = None

    def __post_init__(self) -> None:
        mesh = with_wedges(self.mesh)
        check_kind(mesh)
        kind = type(mesh)
        is_straight = kind in QUADRATIC
        usual = "linear" if is_straight else "quadratic"
        element = choice("element", usual if self.element is None else self.element, ELEMENT_NAMES)
        if element != "quadratic" and not is_straight:
            raise ModelError(
                f"element: {element!r}, but the mesh is a {kind.__name__} with quadratic "
                "elements; leave `element` out"
            )
        if not isinstance(self.material, Material):
            raise ModelError(f"material: a {type(self.material).__name__}; give a Material")
        if element == "quadratic" and isinstance(mesh, MIXED):
            raise ModelError(
                f"element: {element!r}, but the mesh has wedges, or elements of several shapes; "
                "leave `element` out, or mesh the body with quadratic elements"
            )
        if element == "quadratic" and is_straight:
            mesh = quadratic(mesh)
        vars(self).update(element=element, mesh=mesh)
        check_elements(mesh)

    def __repr__(self) -> str:
        mesh = self.mesh
        return (
            f"Body({type(mesh).__name__}, {mesh.p.shape[1]} nodes, {mesh.nelements} elements, "
            f"boundaries={sorted(mesh.boundaries or {})}, element={self.element!r}, "
            f"{self.material})"
        )

    def boundary(self, name: str, argument: str) -> Integers:
        """Facets of a boundary, which lie on the outline; error messages call it `argument`."""
        boundaries = self.mesh.boundaries or {}
        if not isinstance(name, str) or name not in boundaries:
            hint = "; name it in the mesh, or with mesh.with_boundaries"
            if shown(name) == "'contact'":
                hint = (
                    "; a Contact takes the boundary 'contact' of both bodies unless others are "
                    "named"
                )
            raise ModelError(
                f"{argument}: boundary {shown(name)} is unknown; this mesh names "
                f"{sorted(boundaries)}{hint}"
            )
        facets = np.unique(boundaries[name])
        if not len(facets) or np.any(self.mesh.f2t[1, facets] >= 0):
            raise ModelError(
                f"{argument}: boundary {name!r} has no facets, or facets inside the body; name "
                "facets of its outline (`split_bodies` gives bodies that share nodes their own)"
            )
        return facets

    def boundary_nodes(self, name: str, argument: str) -> Integers:
        """Nodes on a boundary; error messages call the boundary `argument`."""
        return facet_nodes(self.mesh, self.boundary(name, argument))

    @cached_property
    def errors(self) -> Array:
        """(nodes, d) error of each coordinate, from the digits with which the mesh was written."""
        return coordinate_errors(self.mesh.p.T, np.unique(self.mesh.t))

    @cached_property
    def written(self) -> Array:
        """(d, nodes) coordinates before any node moves; supports and loads refer to them."""
        return np.asarray(self.mesh.p)

    @cached_property
    def deck_node(self) -> Integers | None:
        """(nodes,) number of each node in the deck, -1 if it has none; None if there is no deck.

        Error messages and tables use these numbers.
        """
        return None

    @property
    def numbers(self) -> Integers:
        """(nodes,) numbers of the nodes in error messages, from the deck or from the mesh."""
        return np.arange(self.mesh.p.shape[1]) if self.deck_node is None else self.deck_node

    def with_mesh(self, mesh: Mesh, **known: Array) -> Body:
        """The body with another mesh, and with its `errors` and `written` if they are known.

        The new body is not checked, because the check would refuse a body that a bolt cuts in two.
        """
        body = copy(self)
        for name in ("errors", "written"):
            vars(body).pop(name, None)
        vars(body).update(mesh=mesh, **known)
        return body

    def moved(self, points: Array) -> Body:
        """The body with its nodes at other points (d, nodes); their errors and names stay."""
        mesh = replace(self.mesh, doflocs=np.ascontiguousarray(points))
        return self.with_mesh(mesh, errors=self.errors, written=self.written)


def numbered_nodes(bodies: Mapping[str, Body]) -> dict[str, Integers]:
    """Name of each body -> numbers of its nodes in a model, which numbers nodes body by body."""
    ends = np.cumsum([body.mesh.p.shape[1] for body in bodies.values()])
    return dict(zip(bodies, np.split(np.arange(ends[-1]), ends[:-1]), strict=True))


def check_kind(mesh: Mesh) -> None:
    """Check that a mesh has elements of a kind that bodies may have."""
    kinds = [*QUADRATIC, *QUADRATIC.values()]
    if type(mesh) not in kinds or type(mesh) in MIXED_QUADRATIC:
        names = ", ".join(kind.__name__ for kind in kinds if kind not in (*MIXED, *MIXED_QUADRATIC))
        raise ModelError(
            f"mesh: a {type(mesh).__name__}; give one of scikit-fem with elements of one shape, "
            f"linear or quadratic: {names}"
        )


def check_elements(mesh: Mesh) -> None:
    """Check that elements are convex, have a size and are connected, and use all nodes."""
    is_plane = mesh.dim() == 2
    if (i := first_of(~np.isfinite(mesh.p).all(axis=0))) is not None:
        raise ModelError(f"mesh: node {i} has coordinates that are not finite")
    sizes = _sizes(mesh)
    bad = ~((sizes > 0).all(axis=0) | (sizes < 0).all(axis=0))
    if (i := first_of(bad)) is not None:
        repair = "repair the mesh"
        if type(mesh) not in QUADRATIC:
            repair = "mesh finer, or with straight sides (gmsh: Mesh.SecondOrderLinear = 1)"
        size = "area" if is_plane else "volume"
        raise ModelError(
            f"mesh: elements that are not convex or have no {size}: {bad.sum()}, the first is {i}; "
            f"{repair}"
        )
    part = element_parts(mesh)
    if part.max() > 0:
        share = "edge" if is_plane else "face"
        raise ModelError(
            f"mesh: {part.max() + 1} parts that share no {share}; give one connected body: merge "
            "nodes that coincide, or let split_bodies(mesh, material) make a body of each part"
        )
    unused = mesh.p.shape[1] - len(np.unique(mesh.dofs.element_dofs))
    if unused:
        raise ModelError(f"mesh: nodes that belong to no element: {unused}; remove them")


def _sizes(mesh: Mesh) -> Array:
    """(places, elements) signed area or volume, from the Jacobian of the elements at their nodes.

    At corners that coincide the Jacobian is zero, so meshes of several shapes are measured at the
    points of integration.
    """
    element = mesh.elem()
    nodes = mesh.dofs.element_dofs
    places = element.doflocs.T
    if isinstance(mesh, MIXED):
        places = get_quadrature(element.refdom, 2 * element.maxdeg)[0]
    slopes = functions_of(element, len(nodes), places)[1]
    return np.asarray(np.linalg.det(np.einsum("aie,ibk->keab", mesh.p[:, nodes], slopes)))


def split_bodies(
    mesh: Mesh, materials: Mapping[str, Material] | Material, *, element: ElementName | None = None
) -> dict[str, Body]:
    """Split a mesh into bodies with separate nodes: its subdomains, or its connected parts.

    Each body keeps the named boundaries of the mesh on which it has facets. The facets that it
    shares with another body become a boundary with the name of that body. So the contact of a pin
    and a plate that share nodes is `Contact("pin", "plate", "plate", "pin")`.

    Parameters
    ----------
    mesh
        The mesh, for example from `read_mesh("model.msh")`; `Body` lists the kinds of meshes.
    materials
        Name of a subdomain -> material of the body; every element is in one of these subdomains. Or
        one Material: each part of the mesh that shares no edge (in space no face) with the others
        is a body. The body has the name of the first subdomain with exactly its elements. Without
        such a subdomain it is called "body 1", "body 2" and so on, in the order of the first
        elements.
    element
        Element of all bodies, see `Body`.

    Returns
    -------
    dict
        Name of the body -> body.

    Raises
    ------
    ModelError
        The mesh is of another kind. A subdomain is unknown. Elements are in no subdomain, or in
        two. A boundary of a body has the name of a neighbouring body. `Body` refuses a part.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 1.0], [-1.0, 0.0, 1.0])
    >>> mesh = mesh.with_subdomains({"punch": lambda x: x[1] > 0, "block": lambda x: x[1] < 0})
    >>> bodies = fo.fem.split_bodies(
    ...     mesh, {"punch": fo.fem.Material(E=2.0), "block": fo.fem.Material()}
    ... )
    >>> sorted(bodies["punch"].mesh.boundaries)
    ['block']

    Two blocks in one mesh that do not touch each other:

    >>> apart = MeshQuad.init_tensor([0.0, 1.0, 2.0, 3.0], [0.0, 1.0])
    >>> apart = apart.remove_elements([1])
    >>> list(fo.fem.split_bodies(apart, fo.fem.Material()))
    ['body 1', 'body 2']
    """
    mesh = with_wedges(mesh)
    check_kind(mesh)
    if isinstance(materials, Material):
        mesh = with_parts(mesh)
        materials = dict.fromkeys(mesh.subdomains, materials)
    owner = _owners(mesh, materials)
    bodies = {}
    for number, (name, material) in enumerate(materials.items()):
        elements = np.flatnonzero(owner == number)
        boundaries = {**(mesh.boundaries or {}), **_shared_facets(mesh, owner, number, materials)}
        part = replace(mesh, _boundaries=boundaries).restrict(elements, skip_subdomains=True)
        named = {boundary: facets for boundary, facets in part.boundaries.items() if len(facets)}
        points = np.take(mesh.p, nodes_from(mesh, elements, part, slice(None)), axis=1)
        try:
            bodies[name] = Body(replace(part, doflocs=points, _boundaries=named), material, element)
        except ModelError as error:
            raise ModelError(f"body {name!r}: {error}") from error
    return bodies


def with_parts(mesh: Mesh) -> Mesh:
    """The mesh with its connected parts as its only subdomains."""
    part = element_parts(mesh)
    subdomains = {}
    for number, which in enumerate(dict.fromkeys(part.tolist()), 1):
        elements = np.flatnonzero(part == which)
        names = (
            name
            for name, members in (mesh.subdomains or {}).items()
            if np.array_equal(np.unique(members), elements)
        )
        subdomains[next(names, f"body {number}")] = elements
    return replace(mesh, _subdomains=subdomains)


def _shared_facets(
    mesh: Mesh, owner: Integers, number: int, names: Iterable[str]
) -> dict[str, Integers]:
    """Name of each neighbour of a body -> facets that both share."""
    inner = np.flatnonzero(mesh.f2t[1] >= 0)
    sides = owner[mesh.f2t[:, inner]]
    of_body = (sides == number).any(axis=0)
    facets = {}
    for number_2, neighbour in enumerate(names):
        shared = inner[of_body & (sides == number_2).any(axis=0)]
        if number_2 == number or not len(shared):
            continue
        if neighbour in (mesh.boundaries or {}):
            name = list(names)[number]
            raise ModelError(
                f"mesh: boundary {neighbour!r} has the name of a body that {name!r} shares facets "
                "with; call it otherwise"
            )
        facets[neighbour] = shared
    return facets


def _owners(mesh: Mesh, materials: Mapping[str, Material]) -> Integers:
    """(elements,) number of the subdomain of each element, in the order of the materials."""
    if not isinstance(materials, Mapping) or not materials:
        raise ModelError(
            f"materials: {shown(materials)}; give a mapping, name of a subdomain -> Material, or "
            "one Material for a body of each connected part"
        )
    subdomains = mesh.subdomains or {}
    owner = np.full(mesh.t.shape[1], -1)
    for number, name in enumerate(materials):
        if name not in subdomains:
            hint = ""
            if not subdomains:
                hint = (
                    "; name each body in the mesh (gmsh: a physical group of its volumes, in the "
                    "plane of its surfaces)"
                )
            raise ModelError(
                f"materials: subdomain {name!r} is unknown; this mesh names "
                f"{sorted(subdomains)}{hint}"
            )
        elements = np.asarray(subdomains[name])
        if np.any(owner[elements] >= 0):
            before = list(materials)[owner[elements].max()]
            raise ModelError(
                f"materials: subdomain {name!r} shares elements with {before!r}; give each to one "
                "body"
            )
        owner[elements] = number
    if owner.min() < 0:
        raise ModelError(
            f"materials: elements that are in none of {list(materials)}: {int((owner < 0).sum())}; "
            "name all subdomains, or remove these elements"
        )
    return owner


def check_names(part: object, *fields: str) -> None:
    """Check that fields of a part of a model are names of its bodies or their boundaries."""
    for field in fields:
        kind = "body of the model" if field.startswith("body") else "boundary of the mesh"
        check_text(field, getattr(part, field), f"the name of a {kind}")


def checked_kinematics(kinematics: Kinematics | None, bodies: Mapping[str, Body]) -> Kinematics:
    """Check the bodies, and that the kinematics suits their dimension."""
    for name, body in bodies.items():
        check_text("bodies: name", name, "a printable text")
        if not isinstance(body, Body):
            raise ModelError(
                f"bodies[{name!r}]: a {type(body).__name__}; give a Body(mesh, material)"
            )
    first_of_dimension = {body.mesh.dim(): name for name, body in reversed(list(bodies.items()))}
    if len(first_of_dimension) > 1:
        raise ModelError(
            f"bodies: {first_of_dimension[2]!r} is plane, {first_of_dimension[3]!r} in space; give "
            "meshes of one dimension"
        )
    is_spatial = 3 in first_of_dimension
    usual: Kinematics = "space" if is_spatial else "plane_strain"
    chosen = choice("kinematics", usual if kinematics is None else kinematics, KINEMATICS)
    if (chosen == "space") != is_spatial:
        dimension = "in space" if is_spatial else "in the plane"
        raise ModelError(
            f"kinematics: {chosen!r} with bodies {dimension}; leave it out, or give other meshes"
        )
    if chosen == "axisymmetric":
        for name, body in bodies.items():
            _check_axisymmetric(name, body)
    return chosen


def _check_axisymmetric(name: str, body: Body) -> None:
    radius = body.mesh.p[0]
    if radius[~on_axis(radius)].min(initial=0.0) < 0:
        raise ModelError(
            f"bodies[{name!r}]: x = {radius.min():g} at node {int(radius.argmin())}; of an "
            "axisymmetric body x is the radius, >= 0"
        )
    if body.element == "mean_dilatation":
        raise ModelError(
            f"bodies[{name!r}]: element {body.element!r}; axisymmetric bodies have linear or "
            "quadratic elements"
        )


def on_axis(radius: Array) -> Booleans:
    """(n,) whether nodes of these radii are on the axis, up to rounding.

    Meshers round: gmsh may turn the radius 0 of a point into 1e-17, or into -1e-17.
    """
    rounding = 1e-9 * np.abs(radius).max()
    return np.asarray(np.abs(radius) <= rounding)


def units_apart(names: Sequence[str], bodies: Sequence[Body]) -> Iterator[str]:
    """Warnings if moduli or sizes of two bodies suggest that they are in different units."""
    name_1, name_2 = names
    E_1, E_2 = (body.material.E for body in bodies)
    if max(E_1, E_2) >= _MODULI_APART * min(E_1, E_2):
        yield (
            f"bodies: E = {E_1:g} of {name_1!r} and {E_2:g} of {name_2!r}; are both in the same "
            "unit (Pa or MPa)?"
        )
    size_1, size_2 = (float(np.ptp(body.mesh.p, axis=1).max()) for body in bodies)
    if max(size_1, size_2) >= _SIZES_APART * min(size_1, size_2):
        yield (
            f"bodies: size = {size_1:g} of {name_1!r} and {size_2:g} of {name_2!r}; are both in "
            "the same unit (mm or m)?"
        )
    (soft, name_of_soft), (stiff, name_of_stiff) = sorted([(E_1, name_1), (E_2, name_2)])
    lower, upper = _THOUSANDFOLD
    if lower <= stiff / soft <= upper:
        yield (
            f"bodies: E = {soft:g} of {name_of_soft!r} and {stiff:g} of {name_of_stiff!r}, "
            f"{stiff / soft:.4g} times as much; are both in the same unit (MPa or GPa)? Steel is "
            "20,000 times as stiff as rubber and more, and less than 500 times as stiff as a hard "
            "polymer"
        )
