"""Elements of bodies: the linear and the quadratic ones of scikit-fem, their nodes, and which of these lie on their facets."""

from dataclasses import replace

import numpy as np
from skfem import Basis, Mesh, MeshHex1, MeshHex2, MeshQuad1, MeshQuad2, MeshTet1, MeshTet2, MeshTri1, MeshTri2

from ..contact.checks import Array
from .ordering import Flags, Integers

# A mesh of scikit-fem counts its corner nodes first, as `mesh.t` and `mesh.facets` have them, then those amid edges, facets and elements.
QUADRATIC = {MeshTri1: MeshTri2, MeshQuad1: MeshQuad2, MeshTet1: MeshTet2, MeshHex1: MeshHex2}
_LINEAR = {second: first for first, second in QUADRATIC.items()} | {first: first for first in QUADRATIC}
_ORDER = {MeshQuad2: 5, MeshHex2: 5}  # three points a direction: exact for uniform stress in curved elements, and for straight ones


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


def corner_weights(kind: type[Mesh]) -> Array:
    """(nodes, corners) the functions of the corners of a linear element at the nodes of a reference element of this kind: each node as their mean."""
    at, linear = kind.elem.doflocs.T, _LINEAR[kind].elem()
    return np.array([np.broadcast_to(linear.lbasis(at, i)[0], at.shape[1:]) for i in range(linear.refdom.nnodes)]).T


def completion(kind: type[Mesh], given: int) -> Array:
    """(nodes, given) the nodes of a quadratic element by its first ones: those amid facets and elements by serendipity, where only edges have one."""
    weights = corner_weights(kind)
    inside, corners = weights > 0, weights.shape[1]
    nodes = np.eye(len(weights), given)
    for i in range(given, len(weights)):
        edges = corners + np.flatnonzero((inside[corners:given] <= inside[i]).all(axis=1))
        nodes[i, :corners] = np.where(inside[i], -0.25, 0.0)
        nodes[i, edges] = (1 + inside[i].sum() / 4) / len(edges)
    return nodes


def on_facets(kind: type[Mesh]) -> Flags:
    """(facets, nodes) which nodes of an element lie on each of its facets."""
    weights, facets = corner_weights(kind), kind.elem.refdom.facets
    return np.array([(np.delete(weights, facet, axis=1) == 0).all(axis=1) for facet in facets])


def places_of(mesh: Mesh, facets: Integers) -> tuple[Integers, Integers]:
    """(m,) elements that some facets bound, and the numbers of the facets in them."""
    elements = mesh.f2t[0, facets]
    return elements, (mesh.t2f[:, elements] == facets).argmax(axis=0)


def facet_nodes(mesh: Mesh, facets: Integers) -> Integers:
    """All nodes on some facets, each once."""
    elements, number = places_of(mesh, facets)
    return np.unique(mesh.dofs.element_dofs[:, elements].T[on_facets(type(mesh))[number]])
