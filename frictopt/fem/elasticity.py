"""Elasticity of one body on a scikit-fem mesh: material, stiffness, and nodal forces.

A body is plane, axisymmetric or in space. A mesh of scikit-fem counts its corner nodes first, as in
`mesh.t` and `mesh.facets`, then the midside nodes of edges, facets and elements. The functions at
the end of the file find nodes, facets and parts of such meshes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from skfem import Basis, Element, LinearForm, Mesh
from skfem.quadrature import get_quadrature

from ..base import SAME_POINT, Array, Booleans, Integers, finite_number, first_of, place
from ..errors import ModelError
from .mixed import MeshMixed, MeshMixed2, MeshMixedPlane, MeshMixedPlane2

ElementName: TypeAlias = Literal["linear", "mean_dilatation", "quadratic"]
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric", "space"]
ELEMENT_NAMES = get_args(ElementName)
KINEMATICS = get_args(Kinematics)
Amount: TypeAlias = float | Callable[..., ArrayLike]
"""A number, or a function of the coordinates x and y, and z in space (arrays).

The function returns an array of their shape.
"""

# Integral of an amount, given at the points of integration, times the function of each node.
MOMENTS = LinearForm(lambda v, w: w.amount * v)

QUADRATIC = {
    skfem.MeshTri1: skfem.MeshTri2,
    skfem.MeshQuad1: skfem.MeshQuad2,
    skfem.MeshTet1: skfem.MeshTet2,
    skfem.MeshHex1: skfem.MeshHex2,
    MeshMixedPlane: MeshMixedPlane2,
    MeshMixed: MeshMixed2,
}
_LINEAR = {second: first for first, second in QUADRATIC.items()} | {
    first: first for first in QUADRATIC
}
# Elements on facets, by the number of corners.
_FACETS = {2: skfem.ElementLineP1, 3: skfem.ElementTriP1, 4: skfem.ElementQuad1}
# Order of integration where it is not the default of scikit-fem. Three points per direction are
# exact for uniform stress in curved elements, and for any stress in straight elements.
_ORDERS = {skfem.MeshQuad2: 5, skfem.MeshHex2: 5, MeshMixedPlane2: 5, MeshMixed2: 5}
# Largest distance of a midside node from the middle of its corners, relative to the distance
# between the corners: some 45 degrees of arc.
_OFF = 0.1


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material.

    Parameters
    ----------
    E
        Young's modulus, > 0, force per area.
    nu
        Poisson's ratio, -1 < nu < 0.5.
    density
        Mass per volume, > 0, in the unit of E times time^2 / length^2: tonne/mm^3 beside MPa, mm
        and s (steel: 7.85e-9), kg/m^3 beside Pa, m and s. None: unknown; modes need it.

    Raises
    ------
    ModelError
        E or density not positive, nu outside (-1, 0.5).

    Examples
    --------
    >>> import frictopt as fo
    >>> steel = fo.fem.Material(E=210e9, nu=0.3)
    >>> round(steel.plane_modulus / 1e9, 2)
    230.77
    >>> steel == fo.fem.Material(210e9)
    True
    """

    E: float = 1.0
    nu: float = 0.3
    density: float | None = None

    def __post_init__(self) -> None:
        vars(self).update(
            E=finite_number("E", self.E, above=0.0),
            nu=finite_number("nu", self.nu, above=-1.0, below=0.5),
        )
        if self.density is not None:
            vars(self).update(density=finite_number("density", self.density, above=0.0))

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants `(lambda, mu)`."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)), self.E / (2 * (1 + self.nu))

    def _plane_lame(self, kinematics: Kinematics) -> tuple[float, float]:
        """Lame's constants between strains and stresses in the plane.

        In plane stress, lambda is E nu / (1 - nu^2).
        """
        if kinematics == "plane_stress":
            return self.E * self.nu / (1 - self.nu**2), self.lame[1]
        return self.lame

    @property
    def plane_modulus(self) -> float:
        """`E / (1 - nu^2)`: two bodies have `1/E* = 1/plane_modulus_1 + 1/plane_modulus_2`."""
        return self.E / (1 - self.nu**2)


def basis_of(mesh: Mesh) -> Basis:
    """The functions of a displacement component of a body, with the points of integration."""
    return Basis(mesh, mesh.elem(), intorder=_ORDERS.get(type(mesh)))


def element_means(dx: Array, values: Array) -> Array:
    """Replace values (elements, ..., integration points) by their means over each element.

    `dx` (elements, integration points) are volumes.
    """
    dx = np.expand_dims(dx, tuple(range(1, values.ndim - 1)))
    means = (values * dx).sum(axis=-1) / dx.sum(axis=-1)
    return np.broadcast_to(means[..., None], values.shape)


def circumference(x: Array, kinematics: Kinematics) -> Array:
    """Length around the axis at each point, `2 pi x`; in the plane the depth 1, in space 1."""
    return 2 * np.pi * x if kinematics == "axisymmetric" else np.ones_like(x)


def functions_at(basis: Basis) -> tuple[Array, Array]:
    """(elements, nodes, points) values of the functions, and (elements, nodes, d, points) slopes.

    The points are the points of integration.
    """
    fields = [field for (field,) in basis.basis]
    functions = [np.broadcast_to(field, basis.dx.shape) for field in fields]
    slopes = np.array([field.grad for field in fields])
    return np.stack(functions, axis=1), slopes.transpose(2, 0, 1, 3)


def assembled(mesh: Mesh, weights: Array, functions: Array, rates: Array) -> csr_matrix:
    """(nodes, nodes) weighted integrals of the function of one node times the rate of another.

    Functions and rates are (elements, nodes, points).
    """
    return _sum(mesh, (functions * weights[:, None]) @ rates.swapaxes(1, 2), 1)


def _sum(mesh: Mesh, matrices: Array, d: int) -> csr_matrix:
    """(nodes d, nodes d) sum of the matrices (elements, nodes d, nodes d) of all elements."""
    nodes = mesh.dofs.element_dofs.T.astype(np.int32)
    unknowns = (d * nodes[:, :, None] + np.arange(d, dtype=np.int32)).reshape(len(nodes), -1)
    rows = np.broadcast_to(unknowns[:, :, None], matrices.shape)
    columns = np.broadcast_to(unknowns[:, None], matrices.shape)
    entries = (matrices.ravel(), (rows.ravel(), columns.ravel()))
    return csr_matrix(entries, shape=(d * mesh.p.shape[1],) * 2)


def body_stiffness(
    mesh: Mesh,
    material: Material,
    element: ElementName | None = None,
    kinematics: Kinematics = "plane_strain",
) -> csr_matrix:
    """Stiffness matrix of one body, in the plane per unit depth.

    The unknowns are the displacements along x, y (and z) of the first node, then those of the next.

    An axisymmetric body has the radius x and the axis x = 0; its stiffness refers to the whole
    circumference. The radial displacement u makes the hoop strain u / x.

    With "mean_dilatation" the first Lame constant resists the mean of div u over an element instead
    of div u itself (selective integration; Nagtegaal, Parks & Rice 1974, Hughes 1980). So an
    element can keep its volume without locking. There are no zero-energy modes, because the second
    constant acts in full. In triangles and tetrahedra div u is uniform, so nothing changes there.
    """
    lam, mu = material._plane_lame(kinematics)
    basis = basis_of(mesh)
    functions, slopes = functions_at(basis)
    count, n, d, _ = slopes.shape
    x = np.asarray(basis.global_coordinates())[0]
    weights = basis.dx * circumference(x, kinematics)

    def products(functions: Array) -> Array:
        """(element, function, function) integrals of products of two functions."""
        rows = functions.reshape(count, -1, functions.shape[-1])
        return np.asarray((rows * weights[:, None]) @ rows.swapaxes(1, 2))

    # K_iajb = int (lambda div_ia div_jb + mu N_i,b N_j,a + mu delta_ab sum_c N_i,c N_j,c)
    dilatation = slopes
    if element == "mean_dilatation":
        dilatation = element_means(basis.dx, slopes)
    if kinematics == "axisymmetric":
        hoop = functions / x[:, None]
        dilatation = slopes.copy()
        dilatation[:, :, 0] += hoop
    stiffness = lam * products(dilatation).reshape(count, n, d, n, d)
    shears = mu * products(slopes).reshape(stiffness.shape)
    stiffness += shears.transpose(0, 1, 4, 3, 2)
    same_direction = np.einsum("eibjb->eij", shears)
    for a in range(d):
        stiffness[:, :, a, :, a] += same_direction
    if kinematics == "axisymmetric":
        stiffness[:, :, 0, :, 0] += 2 * mu * products(hoop)
    return _sum(mesh, stiffness.reshape(count, n * d, n * d), d)


def boundary_forces(
    mesh: Mesh,
    facets: Integers,
    traction: Callable[[Array, Array], ArrayLike],
    kinematics: Kinematics,
) -> Array:
    """(components, nodes) nodal forces of a traction on facets of the outline.

    The traction is a function of points and outward unit normals.
    """
    points, normals, sizes, nodes, values = integration_points(mesh, facets)
    amounts = np.array(traction(points, normals)) * circumference(points[0], kinematics) * sizes
    forces = np.einsum("cmq,kmq->ckm", amounts, values)
    count = mesh.p.shape[1]
    return np.array([np.bincount(nodes.ravel(), part.ravel(), minlength=count) for part in forces])


def node_areas(mesh: Mesh, facets: Integers, kinematics: Kinematics) -> Array:
    """(nodes,) share of each node in the area of some facets; in the plane, in their length."""

    def one(_: Array, normals: Array) -> Array:
        return np.ones_like(normals[:1])

    return np.asarray(boundary_forces(mesh, facets, one, kinematics)[0])


def integration_points(mesh: Mesh, facets: Integers) -> tuple[Array, Array, Array, Integers, Array]:
    """Points (d, m, q) on facets of the outline, outward unit normals, and sizes (m, q).

    The other results are the nodes (k, m) of the elements at the facets, and the functions (k, m,
    q) of these nodes at the points. Integration is done on the facets themselves, because
    scikit-fem would have to invert the map of very thin elements.
    """
    element = mesh.elem()
    elements, number = places_of(mesh, facets)
    corner_numbers = np.array(element.refdom.facets)[number].T  # (corners, m)
    facet_element = _FACETS[len(corner_numbers)]()
    on_facet, weights = get_quadrature(facet_element.refdom, 5)
    shapes, slopes = functions_of(facet_element, len(corner_numbers), on_facet)

    # Points and tangents in the reference element.
    corners = element.refdom.p[:, corner_numbers]
    reference_points = np.einsum("dkm,kq->dmq", corners, shapes)
    reference_tangents = np.einsum("dkm,keq->edmq", corners, slopes)

    nodes = mesh.dofs.element_dofs[:, elements]
    x = mesh.p[:, nodes]
    values, gradients = functions_of(element, len(nodes), reference_points)
    values = values * on_facets(type(mesh))[number].T[:, :, None]
    points = np.einsum("akm,kmq->amq", x, values)
    jacobian = np.einsum("akm,kbmq->abmq", x, gradients)
    tangents = np.einsum("abmq,ebmq->eamq", jacobian, reference_tangents)
    if len(tangents) == 1:
        normals = np.array([tangents[0, 1], -tangents[0, 0]])
    else:
        normals = np.cross(tangents[0], tangents[1], axis=0)
    middle_of_facet = mesh.p[:, mesh.facets[:, facets]].mean(axis=1)
    inward = mesh.p[:, mesh.t[:, elements]].mean(axis=1) - middle_of_facet
    normals = normals * -np.sign(np.sum(normals.sum(axis=2) * inward, axis=0))[:, None]
    sizes = np.linalg.norm(normals, axis=0)
    if (m := first_of(~(sizes > 0).all(axis=1))) is not None:
        raise ModelError(
            f"mesh: the facet at {place(points[:, m].mean(axis=1))} has no size; repair it"
        )
    return points, normals / sizes, sizes * weights, nodes, values


def volume_forces(mesh: Mesh, force: Callable[[Array], Array], kinematics: Kinematics) -> Array:
    """(d, nodes) nodal forces of a force per volume, a function of points (d, ...)."""
    basis = basis_of(mesh)
    points = np.asarray(basis.global_coordinates())
    amounts = force(points) * circumference(points[0], kinematics)
    return np.array([MOMENTS.assemble(basis, amount=amount) for amount in amounts])


def gradient_forces(basis: Basis, stress: Array, kinematics: Kinematics) -> Array:
    """(d, nodes) nodal forces of a tension that is equal in all directions.

    The tension `stress` is given at the integration points.
    """
    x = np.asarray(basis.global_coordinates())[0]
    amount = stress * circumference(x, kinematics)
    forces = []
    for a in range(basis.mesh.dim()):
        form = LinearForm(lambda v, w, a=a: w.amount * v.grad[a])
        forces.append(form.assemble(basis, amount=amount))
    if kinematics == "axisymmetric":
        forces[0] += MOMENTS.assemble(basis, amount=amount / x)
    return np.array(forces)


def quadratic(mesh: Mesh) -> Mesh:
    """The mesh with midside nodes added, and with straight edges as before.

    The new nodes are in the middle of each edge, in quadrilaterals and hexahedra also of each facet
    and element.
    """
    return replace(
        QUADRATIC[type(mesh)].from_mesh(mesh),
        _boundaries=mesh.boundaries,
        _subdomains=mesh.subdomains,
    )


def nodes_from(mesh: Mesh, elements: Any, other: Mesh, of_other: Any) -> Integers:
    """For each node of another mesh, the node of a mesh at the same place of the same element.

    `elements` are the numbers of the elements in the mesh, and `of_other` in the other mesh. The
    result is 0 at nodes outside these elements. This function is needed because scikit-fem keeps
    only corners when it restricts or cuts a mesh.
    """
    nodes = np.zeros(other.dofs.N, dtype=np.intp)
    nodes[other.dofs.element_dofs[:, of_other]] = mesh.dofs.element_dofs[:, elements]
    return nodes


def functions_of(element: Element, count: int, points: Array) -> tuple[Array, Array]:
    """Values (count, ...) and slopes (count, d, ...) of the first functions of an element.

    Both are evaluated at points (d, ...) of the reference element.
    """
    values = []
    slopes = []
    for i in range(count):
        value, slope = element.lbasis(points, i)
        values.append(np.broadcast_to(value, points.shape[1:]))
        slopes.append(np.broadcast_to(slope, points.shape))
    return np.array(values), np.array(slopes)


def corner_weights(kind: type[Mesh]) -> Array:
    """(nodes, corners) weights that make each node of a straight element a mean of its corners."""
    linear = _LINEAR[kind].elem()
    return functions_of(linear, linear.refdom.nnodes, kind.elem.doflocs.T)[0].T


def on_facets(kind: type[Mesh]) -> Booleans:
    """(facets, nodes) whether a node of an element lies on a facet of the element."""
    weights = corner_weights(kind)
    facets = kind.elem.refdom.facets
    return np.array([(np.delete(weights, facet, axis=1) == 0).all(axis=1) for facet in facets])


def places_of(mesh: Mesh, facets: Integers) -> tuple[Integers, Integers]:
    """(m,) the elements at some facets, and the number of each facet within its element."""
    elements = mesh.f2t[0, facets]
    return elements, (mesh.t2f[:, elements] == facets).argmax(axis=0)


def facet_nodes(mesh: Mesh, facets: Integers) -> Integers:
    """All nodes on some facets, each once."""
    return np.asarray(mesh.dofs.get_facet_dofs(facets).flatten())


def parts_of(links: Sequence[Integers] | Integers, size: int) -> Integers:
    """(size,) number of the connected part of each item; `links` (2, m) connect items."""
    graph = coo_matrix((np.ones(len(links[0])), tuple(links)), shape=(size, size))
    return np.asarray(connected_components(graph, directed=False)[1])


def element_parts(mesh: Mesh, cuts: ArrayLike = ()) -> Integers:
    """(elements,) number of the part of each element; facets join parts, unless they are cuts."""
    inside = np.setdiff1d(np.flatnonzero(mesh.f2t[1] >= 0), cuts)
    return parts_of(mesh.f2t[:, inside], mesh.t.shape[1])


def in_space(vectors: Array) -> Array:
    """(..., 3) vectors in space from vectors (..., d); vectors of the plane get a zero."""
    return vectors @ np.eye(vectors.shape[-1], 3)


def midside_ties(mesh: Mesh, facets: Integers, argument: str) -> csr_matrix:
    """(nodes d, nodes d) matrix by which midside nodes on some facets follow their corners.

    Displacements are counted node by node; the rows of all other nodes are empty. A midside node
    follows the mean of its corners: two of an edge, or four of a facet. On a curved face it is off
    the middle of its corners by a vector a. Then it also turns with the corners x_c of the facet,
    by the rotation that fits their displacements best:

        u_m = sum_c weight_c u_c + rotation x a,
        J rotation = sum_c r_c x u_c,    J = sum_c |r_c|^2 1 - r_c r_c^T,    r_c = x_c - their mean

    So rigid motions stay rigid, and forces and moments are passed on. A node on several facets
    moves by the mean of the motions that they give it.
    """
    d = mesh.dim()
    node, ends, weights = _midside_nodes(mesh, facets)
    points = in_space(mesh.p[:, ends].transpose(1, 2, 0))
    middle = np.einsum("nc,ncd->nd", weights, points)
    off = in_space(mesh.p[:, node].T) - middle  # (n, 3), the vectors a
    from_middle = np.linalg.norm(points - middle[:, None], axis=2)
    size = 2 * np.where(weights > 0, from_middle, 0.0).max(axis=1, initial=0.0)
    distance = np.linalg.norm(off, axis=1)
    if (i := first_of(distance > _OFF * size, distance)) is not None:
        raise ModelError(
            f"{argument}: the midside node at {place(mesh.p[:, node[i]])} lies {distance[i]:.3g} "
            f"off the middle of its corners, which are {size[i]:.3g} apart; contact faces are "
            f"linear between corners: mesh the face finer than {_OFF:g} of that distance, or "
            "straighten it"
        )
    off[distance <= SAME_POINT * size] = 0.0

    arms = _cross_matrices(points - points.mean(axis=1)[:, None])  # of the vectors r_c
    J = np.einsum("ncki,nckj->nij", arms, arms)
    turn = _cross_matrices(off)[:, None] @ np.linalg.pinv(J, hermitian=True)[:, None] @ arms
    blocks = (weights[:, :, None, None] * np.eye(3) - turn)[:, :, :d, :d]  # (n, corners, d, d)
    row = d * node[:, None, None, None] + np.arange(d)[:, None]
    column = d * ends[:, :, None, None] + np.arange(d)
    indices = [np.broadcast_to(index, blocks.shape).ravel() for index in (row, column)]
    total = csr_matrix((blocks.ravel(), indices), shape=(mesh.p.size,) * 2)
    facets_of_node = np.repeat(np.bincount(node, minlength=mesh.p.shape[1]), d)
    ties = csr_matrix(diags(1 / np.maximum(facets_of_node, 1)) @ total)
    ties.eliminate_zeros()
    return ties


def _midside_nodes(mesh: Mesh, facets: Integers) -> tuple[Integers, Integers, Array]:
    """Midside nodes (n,) on each facet, corners (n, c) of the facet, and weights (n, c).

    The weights make the node a mean of these corners, in a straight element.
    """
    weights = corner_weights(type(mesh))
    elements, number = places_of(mesh, facets)
    corners = weights.shape[1]
    local, which = np.nonzero(on_facets(type(mesh))[number].T[corners:])
    local = local + corners  # corners come first in an element
    elements = elements[which]
    facet = np.array(mesh.elem.refdom.facets)[number[which]]
    node = mesh.dofs.element_dofs[local, elements]
    ends = mesh.t[facet.T, elements].T
    shares = weights[local[:, None], facet]
    # If the corners coincide, there is no midside node between them.
    last = np.where(shares > 0, ends, -1).max(axis=1, initial=-1)
    is_between = ((shares > 0) & (ends != last[:, None])).any(axis=1)
    return node[is_between], ends[is_between], shares[is_between]


def _cross_matrices(vectors: Array) -> Array:
    """(..., 3, 3) matrices of the cross products with vectors (..., 3)."""
    return np.cross(np.eye(3), vectors[..., None, :])
