"""Elasticity of one body on a scikit-fem mesh, plane, axisymmetric or in space: its material, elements, stiffness and load vectors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from skfem import Basis, Element, LinearForm, Mesh
from skfem.quadrature import get_quadrature

from ..base import SAME_POINT, Array, Booleans, Integers, finite_number, first_of, place
from ..errors import ModelError

ElementName: TypeAlias = Literal["linear", "mean_dilatation", "quadratic"]
Kinematics: TypeAlias = Literal["plane_strain", "plane_stress", "axisymmetric", "space"]
ELEMENT_NAMES, KINEMATICS = get_args(ElementName), get_args(Kinematics)
Amount: TypeAlias = float | Callable[..., ArrayLike]
"""A number, or a function of the coordinates x and y, and z in space (arrays), that returns an array of their shape."""
_FACETS = {
    2: skfem.ElementLineP1,
    3: skfem.ElementTriP1,
    4: skfem.ElementQuad1,
}  # by the number of corners
_ORDER = 5  # of the integration over facets
MOMENTS = LinearForm(
    lambda v, w: w.amount * v
)  # of an amount at the points of integration with the function of each node

# A mesh of scikit-fem counts its corner nodes first, as `mesh.t` and `mesh.facets` have them, then
# those amid edges, facets and elements.
QUADRATIC = {
    skfem.MeshTri1: skfem.MeshTri2,
    skfem.MeshQuad1: skfem.MeshQuad2,
    skfem.MeshTet1: skfem.MeshTet2,
    skfem.MeshHex1: skfem.MeshHex2,
}
_LINEAR = {second: first for first, second in QUADRATIC.items()} | {
    first: first for first in QUADRATIC
}
_SERENDIPITY = {8: skfem.ElementQuadS2, 20: skfem.ElementHexS2}  # by the number of their nodes
_POINTS = {
    skfem.MeshQuad2: 5,
    skfem.MeshHex2: 5,
}  # three points a direction: exact for uniform stress in curved elements, and for straight ones
# the most that a node may lie off the middle of its corners, over their distance: some 45 degrees
# of arc
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
        and s (steel: 7.85e-9), kg/m^3 beside Pa, m and s. None: not known; modes need it.

    Raises
    ------
    ModelError
        E or density not positive, nu outside (-1, 0.5).

    Examples
    --------
    >>> import frictopt as fo
    >>> steel = fo.Material(E=210e9, nu=0.3)
    >>> round(steel.plane_modulus / 1e9, 2)
    230.77
    >>> steel == fo.Material(210e9)
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
        """Lame's constants that join the stresses in the plane to the strains in it: in plane stress, lambda is E nu / (1 - nu^2)."""
        return (
            (self.E * self.nu / (1 - self.nu**2), self.lame[1])
            if kinematics == "plane_stress"
            else self.lame
        )

    @property
    def plane_modulus(self) -> float:
        """`E / (1 - nu^2)`: two bodies have `1/E* = 1/plane_modulus_1 + 1/plane_modulus_2`."""
        return self.E / (1 - self.nu**2)


def element_means(basis: Basis, values: Array) -> Array:
    """Values (elements, ..., integration points) of a basis, each replaced by the mean of its element."""
    dx = np.expand_dims(basis.dx, tuple(range(1, values.ndim - 1)))
    return np.broadcast_to(((values * dx).sum(axis=-1) / dx.sum(axis=-1))[..., None], values.shape)


def circumference(x: Array, kinematics: Kinematics) -> Array:
    """Length around the axis at each point, `2 pi x`; 1 in space and, as unit depth, in the plane."""
    return 2 * np.pi * x if kinematics == "axisymmetric" else np.ones_like(x)


def body_stiffness(
    mesh: Mesh,
    material: Material,
    element: ElementName | None = None,
    kinematics: Kinematics = "plane_strain",
) -> csr_matrix:
    """Stiffness matrix of one body, in the plane per unit depth; unknowns are all x displacements by node, then all y, then all z ones.

    An axisymmetric body has the radius x and the axis x = 0; its stiffness is that of the whole
    circumference. The radial displacement u makes the hoop strain u / x.

    With "mean_dilatation" the first Lame constant resists the mean of div u over an element instead
    of div u itself (selective integration; Nagtegaal, Parks & Rice 1974, Hughes 1980): an element
    can then keep its volume without locking. There are no zero-energy modes, because the second
    constant acts in full. In triangles and tetrahedra div u is uniform, so nothing changes there.
    """
    basis, (lam, mu) = basis_of(mesh), material._plane_lame(kinematics)
    x = np.asarray(basis.global_coordinates())[0]
    weights = basis.dx * circumference(x, kinematics)
    slopes = np.ascontiguousarray(
        np.moveaxis(np.array([field.grad for (field,) in basis.basis]), 2, 0).swapaxes(1, 2)
    )
    count, d, n, _ = slopes.shape  # element, direction, node, point of integration
    dilatation, hoop = slopes, np.zeros(0)
    if element == "mean_dilatation":
        dilatation = element_means(basis, slopes)
    if kinematics == "axisymmetric":
        hoop = np.stack([np.broadcast_to(field, x.shape) / x for (field,) in basis.basis], axis=1)
        dilatation = slopes.copy()
        dilatation[:, 0] += hoop

    def products(functions: Array) -> Array:
        """(element, function, function) integrals of the products of functions (element, ..., point)."""
        own = functions.reshape(count, -1, functions.shape[-1])
        return np.asarray((own * weights[:, None]) @ own.swapaxes(1, 2))

    shears = products(slopes)
    whole = lam * (shears if dilatation is slopes else products(dilatation)).reshape(
        count, d, n, d, n
    )
    shears = mu * shears.reshape(whole.shape)
    whole += shears.transpose(0, 3, 2, 1, 4)
    for a in range(d):
        whole[:, a, :, a] += np.einsum("ebibj->eij", shears)
    if len(hoop):
        whole[:, 0, :, 0] += 2 * mu * products(hoop)
    unknowns = (
        (np.arange(d)[:, None, None] * mesh.p.shape[1] + basis.element_dofs).reshape(d * n, count).T
    )
    rows, columns = np.repeat(unknowns, d * n, axis=1), np.tile(unknowns, d * n)
    return csr_matrix((whole.ravel(), (rows.ravel(), columns.ravel())), shape=(mesh.p.size,) * 2)


def boundary_forces(
    mesh: Mesh,
    facets: Integers,
    traction: Callable[[Array, Array], ArrayLike],
    kinematics: Kinematics,
) -> Array:
    """(components, nodes) integrals over facets of the outline, times the function of each node, of a traction: of points and outward normals."""
    points, normals, sizes, nodes, values = integration_points(mesh, facets)
    amounts = np.array(traction(points, normals)) * circumference(points[0], kinematics) * sizes
    return np.array(
        [
            np.bincount(nodes.ravel(), part.ravel(), minlength=mesh.p.shape[1])
            for part in np.einsum("cmq,kmq->ckm", amounts, values)
        ]
    )


def integration_points(mesh: Mesh, facets: Integers) -> tuple[Array, Array, Array, Integers, Array]:
    """Points (d, m, q) on facets of the outline, outward unit normals, sizes (m, q); nodes (k, m) of their elements, functions (k, m, q) of these.

    The integration is on the facets themselves: scikit-fem would invert the map of very thin
    elements, in vain.
    """
    element, (elements, number) = mesh.elem(), places_of(mesh, facets)
    local = np.array(element.refdom.facets)[number].T
    flat = _FACETS[len(local)]()
    on_flat, weights = get_quadrature(flat.refdom, _ORDER)
    corners = element.refdom.p[:, local]
    shapes, slopes = functions_of(flat, len(local), on_flat)
    at, ways = (
        np.einsum("dkm,kq->dmq", corners, shapes),
        np.einsum("dkm,keq->edmq", corners, slopes),
    )
    nodes = mesh.dofs.element_dofs[:, elements]
    values, gradients = functions_of(element, len(nodes), at)
    values = values * on_facets(type(mesh))[number].T[:, :, None]
    points = np.einsum("akm,kmq->amq", mesh.p[:, nodes], values)
    along = np.einsum(
        "abmq,ebmq->eamq", np.einsum("akm,kbmq->abmq", mesh.p[:, nodes], gradients), ways
    )
    normals = (
        np.array([along[0, 1], -along[0, 0]])
        if len(along) == 1
        else np.cross(along[0], along[1], axis=0)
    )
    inward = mesh.p[:, mesh.t[:, elements]].mean(axis=1) - mesh.p[:, mesh.facets[:, facets]].mean(
        axis=1
    )
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
    return np.array(
        [
            MOMENTS.assemble(basis, amount=part)
            for part in force(points) * circumference(points[0], kinematics)
        ]
    )


def gradient_forces(basis: Basis, stress: Array, kinematics: Kinematics) -> Array:
    """(d, nodes) nodal forces that a tension of the same size in all directions, given at the integration points, exerts on the nodes."""
    x = np.asarray(basis.global_coordinates())[0]
    amount = stress * circumference(x, kinematics)
    axes = range(basis.mesh.dim())
    forces = np.array(
        [
            LinearForm(lambda v, w, a=a: w.amount * v.grad[a]).assemble(basis, amount=amount)
            for a in axes
        ]
    )
    if kinematics == "axisymmetric":
        forces[0] += MOMENTS.assemble(basis, amount=amount / x)
    return forces


def basis_of(mesh: Mesh) -> Basis:
    """The functions of one displacement of a body, and points of integration."""
    return Basis(mesh, mesh.elem(), intorder=_POINTS.get(type(mesh)))


def quadratic(mesh: Mesh) -> Mesh:
    """The mesh with a node amid each edge (of quadrilaterals and hexahedra each facet and element too), straight as it is."""
    return replace(
        QUADRATIC[type(mesh)].from_mesh(mesh),
        _boundaries=mesh.boundaries,
        _subdomains=mesh.subdomains,
    )


def through_corners(mesh: Mesh) -> Mesh:
    """The linear mesh of the same elements, facets and names through the corner nodes, which keep their numbers."""
    return _LINEAR[type(mesh)](
        np.ascontiguousarray(mesh.p[:, : mesh.nvertices]),
        mesh.t,
        mesh.boundaries,
        mesh.subdomains,
        sort_t=False,
    )


def points_from(mesh: Mesh, elements: Integers, other: Mesh) -> Array:
    """(d, nodes) coordinates for another mesh, whose elements are some of this mesh: scikit-fem takes along those of corners alone."""
    points = np.zeros((mesh.dim(), other.dofs.N))
    points[:, other.dofs.element_dofs] = mesh.p[:, mesh.dofs.element_dofs[:, elements]]
    return points


def functions_of(element: Element, count: int, at: Array) -> tuple[Array, Array]:
    """Values (count, ...) and slopes (count, d, ...) of the first functions of an element at points (d, ...) of its reference."""
    found = [element.lbasis(at, i) for i in range(count)]
    return np.array([np.broadcast_to(value, at.shape[1:]) for value, _ in found]), np.array(
        [np.broadcast_to(slope, at.shape) for _, slope in found]
    )


def corner_weights(kind: type[Mesh]) -> Array:
    """(nodes, corners) the functions of the corners of a linear element at the nodes of a reference element of this kind: each node as their mean."""
    linear = _LINEAR[kind].elem()
    return functions_of(linear, linear.refdom.nnodes, kind.elem.doflocs.T)[0].T


def completion(kind: type[Mesh], given: int) -> Array:
    """(nodes, given) the nodes of a quadratic element by its first ones: those amid facets and elements by serendipity, where only edges have one."""
    return (
        functions_of(_SERENDIPITY[given](), given, kind.elem.doflocs.T)[0].T
        if given in _SERENDIPITY
        else np.eye(given)
    )


def on_facets(kind: type[Mesh]) -> Booleans:
    """(facets, nodes) which nodes of an element lie on each of its facets."""
    weights, facets = corner_weights(kind), kind.elem.refdom.facets
    return np.array([(np.delete(weights, facet, axis=1) == 0).all(axis=1) for facet in facets])


def places_of(mesh: Mesh, facets: Integers) -> tuple[Integers, Integers]:
    """(m,) elements that some facets bound, and the numbers of the facets in them."""
    elements = mesh.f2t[0, facets]
    return elements, (mesh.t2f[:, elements] == facets).argmax(axis=0)


def facet_nodes(mesh: Mesh, facets: Integers) -> Integers:
    """All nodes on some facets, each once."""
    return np.asarray(mesh.dofs.get_facet_dofs(facets).flatten())


def parts_of(links: Sequence[Integers] | Integers, size: int) -> Integers:
    """(size,) number of the part that each of some things belongs to, by links (2, m) of them."""
    return np.asarray(
        connected_components(
            coo_matrix((np.ones(len(links[0])), tuple(links)), shape=(size, size)), directed=False
        )[1]
    )


def places_among(rows: Integers, others: Integers) -> Integers:
    """(m,) place of each row of numbers (m, k) among others (n, k), in whatever order they stand in a row; -1 where it is none of them."""
    _, number = np.unique(
        np.sort(np.concatenate([others, rows]), axis=1), axis=0, return_inverse=True
    )
    place = np.full(len(number), -1)
    place[number.ravel()[: len(others)]] = np.arange(len(others))
    return np.asarray(place[number.ravel()[len(others) :]])


def midside_ties(mesh: Mesh, facets: Integers, argument: str) -> csr_matrix:
    """(nodes d, nodes d) matrix of the midside nodes on some facets by their corners, displacements node by node; all other rows are empty.

    A node follows the mean of its corners, two of an edge or four of a facet. Where it is off their
    middle by `a`, on a curved face, it also turns with the corners x_c of the facet, by the
    rotation that fits their displacements best:

        u_m = sum_c weight_c u_c + rotation x a,    J rotation = sum_c r_c x u_c,    J = sum_c
        |r_c|^2 1 - r_c r_c^T,    r_c = x_c - their mean

    So rigid motions remain what they are, and forces and moments are handed over as such. A node on
    several facets follows their mean.
    """
    means, (elements, number), d = corner_weights(type(mesh)), places_of(mesh, facets), mesh.dim()
    corners = means.shape[1]
    local, which = np.nonzero(on_facets(type(mesh))[number].T[corners:])
    local, elements, facet = (
        local + corners,
        elements[which],
        np.array(mesh.elem.refdom.facets)[number[which]],
    )
    node, ends = mesh.dofs.element_dofs[local, elements], mesh.t[facet.T, elements].T
    shares = means[local[:, None], facet]
    points = np.pad(mesh.p[:, ends].transpose(1, 2, 0), ((0, 0), (0, 0), (0, 3 - d)))
    middle = np.einsum("nc,ncd->nd", shares, points)
    off = np.pad(mesh.p[:, node].T, ((0, 0), (0, 3 - d))) - middle
    size = 2 * np.where(shares > 0, np.linalg.norm(points - middle[:, None], axis=2), 0.0).max(
        axis=1, initial=0.0
    )
    distance = np.linalg.norm(off, axis=1)
    if (i := first_of(distance > _OFF * size, distance)) is not None:
        raise ModelError(
            f"{argument}: the midside node at {place(mesh.p[:, node[i]])} lies {distance[i]:.3g} off the middle of its corners, which are "
            f"{size[i]:.3g} apart; contact faces are linear between corners: mesh the face finer than {_OFF:g} of that distance, or straighten it"
        )
    off[distance <= SAME_POINT * size] = 0.0
    arms = _crossing(points - points.mean(axis=1)[:, None])
    turn = (
        _crossing(off)[:, None]
        @ np.linalg.pinv(np.einsum("ncki,nckj->nij", arms, arms), hermitian=True)[:, None]
        @ arms
    )
    blocks = (shares[:, :, None, None] * np.eye(3) - turn)[:, :, :d, :d]
    row, column = (
        d * node[:, None, None, None] + np.arange(d)[:, None],
        d * ends[:, :, None, None] + np.arange(d),
    )
    total = csr_matrix(
        (blocks.ravel(), [np.broadcast_to(index, blocks.shape).ravel() for index in (row, column)]),
        shape=(mesh.p.size,) * 2,
    )
    ties = csr_matrix(
        diags(1 / np.maximum(np.repeat(np.bincount(node, minlength=mesh.p.shape[1]), d), 1)) @ total
    )
    ties.eliminate_zeros()
    return ties


def _crossing(vectors: Array) -> Array:
    """(..., 3, 3) matrices of the vector products with vectors (..., 3)."""
    return np.asarray(np.cross(np.eye(3), vectors[..., None, :]))
