"""Elements of bodies: the linear and the quadratic ones of scikit-fem, their nodes on facets, which of them hang together, and midside nodes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from skfem import Basis, Element, ElementHexS2, ElementQuadS2, Mesh, MeshHex1, MeshHex2, MeshQuad1, MeshQuad2, MeshTet1, MeshTet2, MeshTri1, MeshTri2

from ..contact import SAME_POINT, Array, Booleans, Integers, first_of, place
from ..errors import ModelError

# A mesh of scikit-fem counts its corner nodes first, as `mesh.t` and `mesh.facets` have them, then those amid edges, facets and elements.
QUADRATIC = {MeshTri1: MeshTri2, MeshQuad1: MeshQuad2, MeshTet1: MeshTet2, MeshHex1: MeshHex2}
_LINEAR = {second: first for first, second in QUADRATIC.items()} | {first: first for first in QUADRATIC}
_SERENDIPITY = {8: ElementQuadS2, 20: ElementHexS2}  # by the number of their nodes
_ORDER = {MeshQuad2: 5, MeshHex2: 5}  # three points a direction: exact for uniform stress in curved elements, and for straight ones
_OFF = 0.1  # the most that a node may lie off the middle of its corners, over their distance: some 45 degrees of arc


def basis_of(mesh: Mesh) -> Basis:
    """The functions of one displacement of a body, and points of integration."""
    return Basis(mesh, mesh.elem(), intorder=_ORDER.get(type(mesh)))


def quadratic(mesh: Mesh) -> Mesh:
    """The mesh with a node amid each edge (of quadrilaterals and hexahedra each facet and element too), straight as it is."""
    return replace(QUADRATIC[type(mesh)].from_mesh(mesh), _boundaries=mesh.boundaries, _subdomains=mesh.subdomains)


def through_corners(mesh: Mesh) -> Mesh:
    """The linear mesh of the same elements, facets and names through the corner nodes, which keep their numbers."""
    return _LINEAR[type(mesh)](np.ascontiguousarray(mesh.p[:, : mesh.nvertices]), mesh.t, mesh.boundaries, mesh.subdomains, sort_t=False)


def points_from(mesh: Mesh, elements: Integers, other: Mesh) -> Array:
    """(d, nodes) coordinates for another mesh, whose elements are some of this mesh: scikit-fem takes along those of corners alone."""
    points = np.zeros((mesh.dim(), other.dofs.N))
    points[:, other.dofs.element_dofs] = mesh.p[:, mesh.dofs.element_dofs[:, elements]]
    return points


def functions_of(element: Element, count: int, at: Array) -> tuple[Array, Array]:
    """Values (count, ...) and slopes (count, d, ...) of the first functions of an element at points (d, ...) of its reference."""
    found = [element.lbasis(at, i) for i in range(count)]
    return np.array([np.broadcast_to(value, at.shape[1:]) for value, _ in found]), np.array([np.broadcast_to(slope, at.shape) for _, slope in found])


def corner_weights(kind: type[Mesh]) -> Array:
    """(nodes, corners) the functions of the corners of a linear element at the nodes of a reference element of this kind: each node as their mean."""
    linear = _LINEAR[kind].elem()
    return functions_of(linear, linear.refdom.nnodes, kind.elem.doflocs.T)[0].T


def completion(kind: type[Mesh], given: int) -> Array:
    """(nodes, given) the nodes of a quadratic element by its first ones: those amid facets and elements by serendipity, where only edges have one."""
    return functions_of(_SERENDIPITY[given](), given, kind.elem.doflocs.T)[0].T if given in _SERENDIPITY else np.eye(given)


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
    return np.asarray(connected_components(coo_matrix((np.ones(len(links[0])), tuple(links)), shape=(size, size)), directed=False)[1])


def places_among(rows: Integers, others: Integers) -> Integers:
    """(m,) place of each row of numbers (m, k) among others (n, k), in whatever order they stand in a row; -1 where it is none of them."""
    _, number = np.unique(np.sort(np.concatenate([others, rows]), axis=1), axis=0, return_inverse=True)
    place = np.full(len(number), -1)
    place[number.ravel()[: len(others)]] = np.arange(len(others))
    return np.asarray(place[number.ravel()[len(others) :]])


def midside_ties(mesh: Mesh, facets: Integers, argument: str) -> csr_matrix:
    """(nodes d, nodes d) matrix of the midside nodes on some facets by their corners, displacements node by node; all other rows are empty.

    A node follows the mean of its corners, two of an edge or four of a facet. Where it is off their middle by `a`, on a curved face, it also turns
    with the corners x_c of the facet, by the rotation that fits their displacements best:

        u_m = sum_c weight_c u_c + rotation x a,    J rotation = sum_c r_c x u_c,    J = sum_c |r_c|^2 1 - r_c r_c^T,    r_c = x_c - their mean

    So rigid motions remain what they are, and forces and moments are handed over as such. A node on several facets follows their mean.
    """
    means, (elements, number), d = corner_weights(type(mesh)), places_of(mesh, facets), mesh.dim()
    corners = means.shape[1]
    local, which = np.nonzero(on_facets(type(mesh))[number].T[corners:])
    local, elements, facet = local + corners, elements[which], np.array(mesh.elem.refdom.facets)[number[which]]
    node, ends = mesh.dofs.element_dofs[local, elements], mesh.t[facet.T, elements].T
    shares = means[local[:, None], facet]
    points = np.pad(mesh.p[:, ends].transpose(1, 2, 0), ((0, 0), (0, 0), (0, 3 - d)))
    middle = np.einsum("nc,ncd->nd", shares, points)
    off = np.pad(mesh.p[:, node].T, ((0, 0), (0, 3 - d))) - middle
    size = 2 * np.where(shares > 0, np.linalg.norm(points - middle[:, None], axis=2), 0.0).max(axis=1, initial=0.0)
    distance = np.linalg.norm(off, axis=1)
    if (i := first_of(distance > _OFF * size, distance)) is not None:
        raise ModelError(
            f"{argument}: the midside node at {place(mesh.p[:, node[i]])} lies {distance[i]:.3g} off the middle of its corners, which are "
            f"{size[i]:.3g} apart; contact faces are linear between corners: mesh the face finer than {_OFF:g} of that distance, or straighten it"
        )
    off[distance <= SAME_POINT * size] = 0.0
    arms = _crossing(points - points.mean(axis=1)[:, None])
    turn = _crossing(off)[:, None] @ np.linalg.pinv(np.einsum("ncki,nckj->nij", arms, arms), hermitian=True)[:, None] @ arms
    blocks = (shares[:, :, None, None] * np.eye(3) - turn)[:, :, :d, :d]
    row, column = d * node[:, None, None, None] + np.arange(d)[:, None], d * ends[:, :, None, None] + np.arange(d)
    total = csr_matrix((blocks.ravel(), [np.broadcast_to(index, blocks.shape).ravel() for index in (row, column)]), shape=(mesh.p.size,) * 2)
    ties = csr_matrix(diags(1 / np.maximum(np.repeat(np.bincount(node, minlength=mesh.p.shape[1]), d), 1)) @ total)
    ties.eliminate_zeros()
    return ties


def _crossing(vectors: Array) -> Array:
    """(..., 3, 3) matrices of the vector products with vectors (..., 3)."""
    return np.asarray(np.cross(np.eye(3), vectors[..., None, :]))
