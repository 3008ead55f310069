"""Meshes of the elements of decks, of one shape or several, with their midside nodes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import skfem
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..base import ROUNDING, Array, Booleans, Integers, place
from ..base.files import library
from ..errors import ModelError
from ..fem.elasticity import QUADRATIC, corner_weights, functions_of
from ..fem.mixed import COLLAPSED, HEXAHEDRON, MIXED, MeshMixed, MeshMixedPlane, places_among
from .deck import CORNERS, Deck, Elements, corner_shape, is_linear

# Corners of the faces S1, S2, ... of an element, as decks number them.
FACE_CORNERS: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}
# Elements of scikit-fem with the functions of the quadratic shapes; it has no quadratic wedge.
_QUADRATIC_ELEMENTS = {
    "triangle6": skfem.ElementTriP2,
    "tetra10": skfem.ElementTetP2,
    "quad8": skfem.ElementQuadS2,
    "quad9": skfem.ElementQuad2,
    "hexahedron20": skfem.ElementHexS2,
    "hexahedron27": skfem.ElementHex2,
}
_PLAIN = {
    "triangle": skfem.MeshTri1,
    "quad": skfem.MeshQuad1,
    "tetra": skfem.MeshTet1,
    "hexahedron": skfem.MeshHex1,
}


def mesh_through_corners(parts: Sequence[Elements], points: Array) -> Mesh:
    """Mesh through the corners of elements of any shapes, its nodes in the order of the points.

    If all elements have one shape apart from midside nodes, such as linear and quadratic hexahedra,
    the result is a mesh of this shape.
    """
    shapes = {corner_shape(part.kind) for part in parts}
    kind = MeshMixedPlane if points.shape[1] == 2 else MeshMixed
    if len(shapes) == 1:
        kind = _PLAIN.get(min(shapes), kind)
    x = np.ascontiguousarray(points.T)
    return kind(x, np.ascontiguousarray(_corners_of(kind, parts).T))


def _corners_of(kind: type[Mesh], parts: Sequence[Elements]) -> Integers:
    """(elements, corners) nodes of elements, as a mesh of scikit-fem orders them."""
    corners = [part.nodes[:, _at_corners(kind, part.kind)] for part in parts]
    return np.concatenate(corners)


def _at_corners(kind: type[Mesh], shape: str) -> Integers:
    """For each corner of a scikit-fem element, the corner of the shape that lies there."""
    if kind in MIXED:
        corners = np.array(COLLAPSED[corner_shape(shape)])
    else:
        corners = np.arange(CORNERS[shape])
    return corners[HEXAHEDRON] if len(corners) == len(HEXAHEDRON) else corners


def with_midsides(mesh: Mesh, deck: Deck) -> tuple[Mesh, csr_matrix]:
    """The quadratic mesh of the elements of a deck, from the mesh through their corners.

    If all elements are linear, it is the given mesh. A linear element beside quadratic elements
    gets midside nodes on its straight edges. The second result is the (nodes of the mesh, points of
    the deck) matrix whose rows give each node as a mean of points.
    """
    parts = deck.by_shape()
    mesh_nodes = np.unique(mesh.t)
    rows, corner_places = np.unique(_corners_of(type(mesh), parts), return_inverse=True)
    if deck.is_linear:
        shape = (mesh.p.shape[1], len(deck.points))
        return mesh, csr_matrix((np.ones(len(rows)), (mesh_nodes, rows)), shape=shape)
    t = mesh_nodes[corner_places.reshape(mesh.t.shape[::-1])].T
    pieces = []
    for part in parts:
        corners = np.tile(_at_corners(type(mesh), part.kind), (len(part.numbers), 1))
        pieces.append(_Pieces(part, np.arange(len(corners)), corners))
    straight = replace(mesh, t=np.ascontiguousarray(t), sort_t=False)
    return _curved(straight, pieces, deck)


class _Pieces(NamedTuple):
    """Elements of a mesh, each of which is an element of a part of a deck, or a piece of it.

    `parent` (n,) is the deck's element from which each element of the mesh is made, by its index in
    the part. `corners` (n, k) are the corners of each element of the mesh, by their numbers in its
    parent.
    """

    part: Elements
    parent: Integers
    corners: Integers


def _curved(straight: Mesh, pieces: Sequence[_Pieces], deck: Deck) -> tuple[Mesh, csr_matrix]:
    """The quadratic mesh of pieces with the corners of a linear mesh, and the matrix of its nodes.

    The rows of this matrix give each node as a mean of points of the deck.
    """
    kind = QUADRATIC[type(straight)]
    mesh = kind(straight.p, straight.t, straight.boundaries, straight.subdomains)
    of_linear = [np.full(len(parent), is_linear(part.kind)) for part, parent, _ in pieces]
    _check_edges_are_alike(mesh, np.concatenate(of_linear))
    weights = corner_weights(kind)
    # Each node is placed in the first element that has it.
    nodes, first = np.unique(mesh.dofs.element_dofs, return_index=True)
    place_in_element, element = np.divmod(first, mesh.nelements)
    entries = []
    start = 0
    for part, parent, corners in pieces:
        here = np.flatnonzero((element >= start) & (element < start + len(parent)))
        piece = element[here] - start
        start += len(parent)
        w = np.zeros((CORNERS[part.kind], len(here)))
        np.add.at(w, (corners[piece].T, np.arange(len(here))), weights[place_in_element[here]].T)
        entries.append((_functions(part.kind, w.T), nodes[here], part.nodes[parent[piece]]))
    return _placed(mesh, entries, deck)


def _check_edges_are_alike(mesh: Mesh, of_linear: Booleans) -> None:
    """Check that no edge has elements of both orders; `of_linear` (elements,) marks linear ones."""
    ends = mesh.facets if mesh.dim() == 2 else mesh.edges
    nodes = mesh.dofs.element_dofs[mesh.t.shape[0] :]
    # An edge without length has both ends at one corner.
    no_edges = mesh.nvertices + np.flatnonzero(ends[0] == ends[1])
    common = np.intersect1d(nodes[:, of_linear], nodes[:, ~of_linear])
    common = np.setdiff1d(common, no_edges)
    if len(common):
        middle = mesh.p[:, ends[:, common[0] - mesh.nvertices]].mean(axis=1)
        raise ModelError(
            f"mesh: the edge at {place(middle)} belongs to linear and to quadratic elements; give "
            "both one order"
        )


def _placed(
    mesh: Mesh, entries: Sequence[tuple[Array, Integers, Integers]], deck: Deck
) -> tuple[Mesh, csr_matrix]:
    """The mesh with its nodes at means of nodes of the deck, and the matrix of these means.

    Each entry has weights (n, k), nodes (n,) of the mesh, and the nodes (n, k) of the deck.
    """
    weights = np.concatenate([values.ravel() for values, _, _ in entries])
    rows = np.concatenate([np.repeat(node, values.shape[1]) for values, node, _ in entries])
    columns = np.concatenate([nodes.ravel() for _, _, nodes in entries])
    origin = csr_matrix((weights, (rows, columns)), shape=(mesh.dofs.N, len(deck.points)))
    origin.data[np.abs(origin.data) < ROUNDING / 10] = 0.0
    origin.eliminate_zeros()
    nodes_of_elements = np.concatenate([part.nodes.ravel() for part in deck.by_shape()])
    unused = np.setdiff1d(nodes_of_elements, origin.indices)
    if len(unused):
        raise ModelError(
            f"mesh: the midside node at {place(deck.points[unused[0]])} is on an edge that has "
            "another one; merge nodes that coincide"
        )
    coordinates = np.ascontiguousarray((origin @ deck.points[:, : mesh.dim()]).T)
    return replace(mesh, doflocs=coordinates), origin


def _functions(shape: str, w: Array) -> Array:
    """(n, nodes) functions of the nodes of a shape, at points with weights (n, corners).

    The weights are the values of the functions of the corners of the linear shape.
    """
    if is_linear(shape):
        return w
    if shape == "wedge15":
        return _wedge_functions(w)
    element = _QUADRATIC_ELEMENTS[shape]()
    count = int(shape.removeprefix(corner_shape(shape)))
    order = np.arange(count)
    corners = np.arange(w.shape[1])
    if w.shape[1] == len(HEXAHEDRON):
        # Imported here, because it imports meshio. Without it `library` says how to install it.
        library()
        from skfem.io.meshio import INV_HEX_MAPPING

        order = np.array(INV_HEX_MAPPING[:count])
        corners = HEXAHEDRON
    values = functions_of(element, count, element.refdom.p @ w[:, corners].T)[0]
    functions = np.zeros((len(w), count))
    functions[:, order] = values.T
    return functions


def _wedge_functions(w: Array) -> Array:
    """(n, 15) functions of the quadratic wedge, from the functions (n, 6) of the linear wedge.

    The wedge is C3D15. Its functions are quadratic in the triangle times linear along the height,
    and linear in the triangle times the bubble along the height.
    """
    across = w[:, :3] + w[:, 3:]
    up = w[:, 3:].sum(axis=1)
    bubble = (4 * up * (1 - up))[:, None] * across
    along = np.stack([1 - up, up])
    corners = [share[:, None] * across * (2 * across - 1) - bubble / 2 for share in along]
    edges = [
        (share * 4 * across[:, a] * across[:, b])[:, None]
        for share in along
        for a, b in FACE_CORNERS["triangle"]
    ]
    return np.column_stack([*corners, *edges, bubble])


def in_tetrahedra(mesh: Mesh, deck: Deck) -> tuple[Mesh, csr_matrix]:
    """Quadratic tetrahedra, in the plane triangles, in place of quadratic elements of a deck.

    `mesh` has the corners of the elements and the sets. Each element is cut from its corner with
    the lowest number, and each of its quadrilaterals likewise (Dompierre et al. 1999), so that both
    sides of a facet are cut alike. The displacements of a body stay quadratic. The second result
    is the matrix that gives the nodes of the mesh as means of points of the deck.
    """
    d = mesh.dim()
    pieces = []
    owner = []
    first = 0
    for part in deck.by_shape():
        parent, corners = _cut(corner_shape(part.kind), part.nodes[:, : CORNERS[part.kind]], d)
        pieces.append(_Pieces(part, parent, corners))
        owner.append(first + parent)
        first += len(part.numbers)
    t = np.concatenate([part.nodes[parent[:, None], corners] for part, parent, corners in pieces])
    subdomains = {
        name: np.flatnonzero(np.isin(np.concatenate(owner), elements))
        for name, elements in (mesh.subdomains or {}).items()
    }
    linear = skfem.MeshTri1 if d == 2 else skfem.MeshTet1
    straight = linear(mesh.p, np.ascontiguousarray(t.T), sort_t=False)
    facets = np.array(straight.facets.T)
    boundaries = {
        name: np.setdiff1d(places_among(_simplices(mesh.facets[:, members].T), facets), [-1])
        for name, members in (mesh.boundaries or {}).items()
    }
    straight = straight.with_boundaries(boundaries).with_subdomains(subdomains)
    return _curved(straight.remove_unused_nodes(), pieces, deck)


def _simplices(facets: Integers) -> Integers:
    """The edges, or the triangles between three corners, of facets (m, corners)."""
    if facets.shape[1] < 4:
        return facets
    triples = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    return np.concatenate([facets[:, triple] for triple in triples])


def _cut(shape: str, corners: Integers, d: int) -> tuple[Integers, Integers]:
    """The simplices of cut elements: the element (n,) of each, and its corners (n, d + 1) there."""
    faces = FACE_CORNERS[shape] if d == 3 else (tuple(range(CORNERS[shape])),)
    lowest = corners.argmin(axis=1)
    parents = []
    pieces = []
    for top in range(CORNERS[shape]) if d == 3 else [-1]:
        members = np.flatnonzero(lowest == top) if d == 3 else np.arange(len(corners))
        for face in faces:
            if top in face:
                continue
            # The corners of the face, from the lowest one on.
            start = corners[members][:, face].argmin(axis=1)
            ring = np.array(face)[(start[:, None] + np.arange(len(face))) % len(face)]
            for k in range(1, len(face) - 1):
                simplex = ring[:, [0, k, k + 1]]
                if d == 3:
                    simplex = np.insert(simplex, 0, top, axis=1)
                parents.append(members)
                pieces.append(simplex)
    return np.concatenate(parents), np.concatenate(pieces)
