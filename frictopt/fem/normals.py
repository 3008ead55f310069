"""Normals at the nodes of faces: estimates for the curve or surface that the facets approximate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ..base import ROUNDING, Array, Booleans, Integers
from .coincidence import error_along
from .elasticity import parts_of
from .faces import Face, areas_of, normals_of, unit_vectors
from .interface import ASKEW
from .mixed import polygons

# Smallest cosine between the normal of a node and the normals of its facets in a smooth face.
SMOOTH = 0.9


# Numbers of the normals at rims, and on cylinders and cones.

# Smallest cosine between two edges of a line through a node of the rim.
_THROUGH = 0.8
# Smallest cosine between two edges of a line that continues from the rim into the face.
_ONWARD = 0.5
# Smallest ratio of the curvature of a curve at the next node to its curvature at the node. At a
# corner of two flat faces the curvature at the next node is zero.
_BENDS_ON = 1 / 3
# Largest number of passes over the rim; the normals of its nodes depend on each other.
_PASSES = 40
# Number of Newton steps to a normal; each step squares the error of an angle.
_STEPS = 6
# The tangents at a node determine two directions if the ratio of their two eigenvalues is at least
# this.
_SPANNED = 0.05
# Largest distance of a node from its surface, relative to the shortest edge: coordinates have
# five digits.
_ON_SURFACE = 1e-4
# Normals lean if they differ from the normals of the surface by more than this many times the error
# of the fit, which is measured in edges. A smaller difference may be an error of the coordinates.
_LEANS = 10.0
# Nodes on at least this number of generators show that a face is round, and not two flat faces.
_GENERATORS = 4
# Nodes are on one generator if their angles differ by less than this share of the range.
_SAME_ANGLE = 1e-3


class Planes:
    """The normals of flat faces: faces in parallel planes get exactly the same normal.

    Coordinates have errors, so the facets of a flat face have normals that differ a little. If the
    coordinates allow it, a face gets an axis as normal, or the normal of an earlier face. So the
    largest faces, whose normals have the smallest errors, should come first.
    """

    def __init__(self, dimension: int) -> None:
        self._normals = list(np.eye(dimension))

    def normal_of(self, face: Face, askew: float = ASKEW) -> Array | None:
        """(d,) unit normal of a face whose facets lie in one plane, else None.

        `askew` is the squared sine of the largest allowed angle between the mean normal of the
        facets and the normal of the plane.
        """
        points = face.points
        areas = areas_of(face.corners)
        mean = unit_vectors(areas.sum(axis=0))
        nodes = np.unique(face.facets)
        for known in [*self._normals, mean]:
            normal = known if known @ mean > 0 else -known
            error = error_along(normal[None], face.errors[nodes]).max()
            # Both the nodes and the plane have this error, on either side.
            is_flat = np.ptp(points[nodes] @ normal) <= 4 * error
            is_one_normal = np.sum((normal - mean) ** 2) <= askew
            if is_flat and is_one_normal and (areas @ normal > 0).all():
                if known is mean:
                    self._normals.append(mean)
                return normal
        return None


def node_normals(face: Face, planes: Planes) -> Array:
    """(nodes, d) normals of a face at its nodes, of any length.

    Facets that lie in one plane within the `errors` of the coordinates have the normal of this
    plane, see `Planes`. Other normals are weighted as by Max (1999). On circles and spheres this is
    exact at nodes that facets surround. At free ends and rims, normals follow from lines of nodes
    that end at the node or pass through it. These lines are treated as arcs. If the nodes lie on a
    cylinder or a cone, the normals are the normals of this surface, because normals from facets
    lean, for instance on unstructured triangles.
    """
    facets, points = face.facets, face.points
    weighted = _weighted(facets, points)
    length = np.linalg.norm(weighted, axis=1)
    plane = planes.normal_of(face)
    if plane is not None:
        return np.asarray(length[:, None] * plane)
    of_facets = normals_of(points[facets])
    length[length == 0] = 1.0
    normals = weighted / length[:, None]
    corrected = normals.copy()

    cosines = np.einsum("fcd,fd->fc", normals[facets], of_facets)
    rim = np.setdiff1d(_rim(facets), facets[cosines < SMOOTH])
    if len(rim):
        corrected[rim] = _at_rim(rim, facets, points, corrected)
    if points.shape[1] == 3:
        _put_on_surfaces(corrected, facets, points, of_facets)

    # Normals that need no correction stay as they are: normals of flat faces have exact zeros.
    changed = np.abs(corrected - normals).max(axis=1) > ROUNDING
    weighted[changed] = corrected[changed] * length[changed, None]
    return weighted


def normals_of_faces(faces: Sequence[Face], planes: Planes) -> list[Array]:
    """(nodes, d) normals at the nodes of each of several faces of one body, see `node_normals`.

    Faces that continue smoothly are treated as one face.
    """
    units = [unit_vectors(_weighted(face.facets, face.points)) for face in faces]

    groups: list[list[int]] = []
    for i in range(len(faces)):
        group = [i]
        for before in list(groups):
            cosines = [_cosines(units[k], units[m]) for k in group for m in before]
            is_smooth = all((cosine > SMOOTH).all() for cosine in cosines)
            if is_smooth and any(len(cosine) for cosine in cosines):
                groups.remove(before)
                group += before
        groups.append(group)

    of_faces = {}
    for group in groups:
        facets = np.concatenate([faces[i].facets for i in group])
        _, once = np.unique(np.sort(facets, axis=1), axis=0, return_index=True)
        normals = node_normals(replace(faces[0], facets=facets[np.sort(once)]), planes)
        of_faces.update(dict.fromkeys(group, normals))
    return [of_faces[i] for i in range(len(faces))]


def _cosines(normals_1: Array, normals_2: Array) -> Array:
    """Cosines between the unit normals of two faces at the nodes that both have."""
    shared = normals_1.any(axis=1) & normals_2.any(axis=1)
    return np.asarray(np.sum(normals_1[shared] * normals_2[shared], axis=1))


def _weighted(facets: Integers, points: Array) -> Array:
    """(nodes, d) weighted sums of the normals of facets.

    The weight is the sine of the angle at the node, divided by the lengths of its two edges. With
    areas as weights, normals would lean if sizes, or diagonals of triangles, differ between the
    sides of a node. Round fits would then wedge as they rotate.
    """
    normals = np.zeros_like(points)
    for polygon in polygons(facets):
        corners = points[polygon]
        ahead = np.roll(corners, -1, axis=1) - corners
        squares = np.sum(ahead**2, axis=2)
        if points.shape[1] == 3:
            back = np.roll(corners, 1, axis=1) - corners
            turned = np.cross(ahead, back)
            squares = squares * np.sum(back**2, axis=2)
        else:
            turned = areas_of(corners)[:, None]
        np.add.at(normals, polygon, turned / squares[..., None])
    return normals


def _put_on_surfaces(normals: Array, facets: Integers, points: Array, of_facets: Array) -> None:
    """Replace normals on cylinders and cones by the normals of the surface, if the two differ."""
    parts = _smooth_parts(facets, of_facets)
    nodes_of_parts = [np.unique(part) for part in parts]
    uses = np.bincount(np.concatenate(nodes_of_parts), minlength=len(points))
    for part, nodes in zip(parts, nodes_of_parts, strict=True):
        nodes = nodes[uses[nodes] == 1]  # nodes at a sharp edge are in several parts
        surface = _surface_normals(part, nodes, points, normals[nodes])
        if surface is not None:
            normals[nodes] = surface


def _smooth_parts(facets: Integers, of_facets: Array) -> list[Integers]:
    """Facets of each of the parts into which sharp edges divide a face in space."""
    edges, facet = _edges(facets)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    facet_1 = facet[order[:-1][same]]
    facet_2 = facet[order[1:][same]]
    # The angle between two facets may be twice the angle between a facet and a node.
    smooth = np.sum(of_facets[facet_1] * of_facets[facet_2], axis=1) > 2 * SMOOTH**2 - 1
    part = parts_of((facet_1[smooth], facet_2[smooth]), len(facets))
    return [facets[part == number] for number in range(part.max() + 1)]


def _edges(facets: Integers) -> tuple[Integers, Integers]:
    """(edges, 2) sorted ends of the edges of facets in space, and the facet (edges,) of each."""
    ends = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2)
    facet, side = np.nonzero(ends[:, :, 0] != ends[:, :, 1])
    return np.sort(ends[facet, side], axis=1), facet


@dataclass(frozen=True, eq=False)
class _Cone:
    """A cone or cylinder to be fitted to nodes.

    Its six unknowns are two tilts of the axis, two shifts of the axis, the radius, and the change
    of radius per height. Shifts and radius are in units of `edge`.
    """

    arms: Array  # (n, 3) nodes, from their mean
    basis: Array  # (3, 3) two directions across the axis, and a direction near it
    edge: float  # length of the shortest edge

    def placed(self, unknowns: Array) -> tuple[Array, Array, Array, Array]:
        """Axis, heights along it, vectors from it, and radii of the nodes."""
        axis = self.basis[2] + unknowns[:2] @ self.basis[:2]
        axis = axis / np.linalg.norm(axis)
        away = self.arms - self.edge * unknowns[2:4] @ self.basis[:2]
        height = away @ axis
        away = away - height[:, None] * axis
        return axis, height, away, np.linalg.norm(away, axis=1)

    def distances(self, unknowns: Array) -> Array:
        """(n,) distances of the nodes from the surface along radii, in units of `edge`."""
        _, height, _, radius = self.placed(unknowns)
        return np.asarray((radius - unknowns[5] * height) / self.edge - unknowns[4])

    def start(self) -> Array:
        """(6,) the unknowns of the cylinder along `basis[2]` that fits in linear least squares."""
        flat = self.arms @ self.basis[:2].T / self.edge
        columns = np.column_stack([2 * flat, np.ones(len(flat))])
        *middle, constant = np.linalg.lstsq(columns, np.sum(flat**2, axis=1), rcond=None)[0]
        radius = np.sqrt(max(constant + np.square(middle).sum(), 0.0))
        return np.asarray(np.r_[0.0, 0.0, middle, radius, 0.0])


def _surface_normals(
    facets: Integers, nodes: Integers, points: Array, normals: Array
) -> Array | None:
    """(n, 3) unit normals at some nodes of facets that all lie on one cylinder or cone.

    None if there is no such surface, or if `normals` (n, 3) differ from its normals by no more than
    the errors of the places of the nodes.
    """
    all_nodes = np.unique(facets)
    if len(all_nodes) < 2 * _GENERATORS:
        return None
    arms = points[all_nodes] - points[all_nodes].mean(axis=0)
    ends = points[_edges(facets)[0]]
    edge = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min()
    height = arms @ np.linalg.svd(arms, full_matrices=False)[2][2]
    if np.abs(height).max() <= _ON_SURFACE * edge:
        return None  # flat

    # The normals of the facets of a cone have the same angle with its axis, so they vary only
    # across it.
    of_facets = normals_of(points[facets])
    basis = np.linalg.svd(of_facets - of_facets.mean(axis=0), full_matrices=False)[2]
    cone = _Cone(arms, basis, edge)
    fit = least_squares(
        cone.distances, cone.start(), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    error = np.abs(fit.fun).max()
    axis, _, away, radius = cone.placed(fit.x)
    if not error <= _ON_SURFACE or not radius.min() > 0:
        return None  # no such surface, or a node is the tip of a cone, where there is no normal
    outward = away / radius[:, None]
    if _count_generators(outward, axis, basis) < _GENERATORS:
        return None

    surface = (outward - fit.x[5] * axis)[np.searchsorted(all_nodes, nodes)]
    surface = unit_vectors(surface)
    surface = surface * np.sign(np.sum(surface * normals, axis=1))[:, None]
    largest_lean = np.linalg.norm(surface - normals, axis=1).max(initial=0.0)
    return surface if largest_lean > _LEANS * error else None


def _count_generators(outward: Array, axis: Array, basis: Array) -> int:
    """Number of generators of a cone that have nodes, from unit vectors (n, 3) off its axis."""
    mean = outward.mean(axis=0)
    if np.linalg.norm(mean) <= SMOOTH / 2:
        mean = basis[0]  # the nodes are all around
    angle = np.arctan2(outward @ np.cross(axis, mean), outward @ mean)
    same = _SAME_ANGLE * max(np.ptp(angle), ROUNDING)
    return len(np.unique(np.round((angle - angle.min()) / same)))


def _rim(facets: Integers) -> Integers:
    """Nodes at the free ends of a chain of edges, or on the rim of a face in space."""
    ends = facets.reshape(-1, 1) if facets.shape[1] == 2 else _edges(facets)[0]
    ends, uses = np.unique(ends, axis=0, return_counts=True)
    return np.asarray(ends[uses == 1]).ravel()


class _HalfEdges:
    """The edges of facets in both directions, sorted by their tails."""

    def __init__(self, facets: Integers, points: Array) -> None:
        edges = _edges(facets)[0]
        self.tail, self.head = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0).T
        self.vector = points[self.head] - points[self.tail]
        self.length = np.linalg.norm(self.vector, axis=1)
        self.direction = self.vector / self.length[:, None]

    def onward(
        self, nodes: Integers, direction: Array, least_cosine: float
    ) -> tuple[Integers, Booleans]:
        """From each node, the edge closest to a direction (n, d).

        The second result is whether the cosine between edge and direction exceeds `least_cosine`.
        """
        first = np.searchsorted(self.tail, nodes)
        count = np.searchsorted(self.tail, nodes, side="right") - first
        # All edges of all nodes are listed one after the other: `row` is the index of their node.
        row = np.repeat(np.arange(len(nodes)), count)
        edge = np.arange(len(row)) + np.repeat(first - np.cumsum(count) + count, count)
        cosine = np.sum(direction[row] * self.direction[edge], axis=1)
        best = np.lexsort((cosine, row))[np.cumsum(count) - 1]
        return edge[best], cosine[best] > least_cosine

    def curvature(self, first: Integers, second: Integers, normals: Array) -> Array:
        """(n,) curvature of the lines through two edges, along the normal at their common node."""
        bend = (self.direction[second] - self.direction[first]) * normals[self.head[first]]
        length = self.length[first] + self.length[second]
        return np.asarray(2 * np.sum(bend, axis=1) / length)


def _at_rim(nodes: Integers, facets: Integers, points: Array, normals: Array) -> Array:
    """(n, d) unit normals at nodes of the rim, from the lines of nodes that reach them.

    A line that goes through a node has the tangent of the circle through its neighbours. A line
    that ends at the node is taken as an arc from the next node: its chord has the same angle with
    the normals at both nodes. If the line is not curved beyond the next node, as at a corner of two
    flat faces, it is taken as straight.

    `normals` (nodes, d) are the unit normals of all nodes.
    """
    edges = _HalfEdges(facets, points)
    first = np.flatnonzero(np.isin(edges.tail, nodes))  # all edges from these nodes
    node = np.searchsorted(nodes, edges.tail[first])  # index of their node
    neighbour = edges.head[first]
    opposite, through = edges.onward(edges.tail[first], -edges.direction[first], _THROUGH)
    second, goes_on = edges.onward(neighbour, edges.direction[first], _ONWARD)
    third, goes_far = edges.onward(edges.head[second], edges.direction[second], _ONWARD)

    # An inversion at the node turns the circle through its neighbours into a line along the
    # tangent.
    inverse, inverse_opposite = (
        edges.vector[edge] / edges.length[edge, None] ** 2 for edge in (first, opposite)
    )
    tangents = np.where(through[:, None], inverse - inverse_opposite, edges.vector[first])
    tangents = unit_vectors(tangents)

    normals = normals.copy()
    for _ in range(_PASSES):
        near = edges.curvature(first, second, normals)
        far = edges.curvature(second, third, normals)
        bends_on = (near * far > 0) & (np.abs(far) >= _BENDS_ON * np.abs(near))
        curved = ~through & goes_on & goes_far & bends_on
        cosines = np.where(curved, -np.sum(tangents * normals[neighbour], axis=1), 0.0)
        # Straight lines are used if the other lines do not determine the normal.
        counts = through | curved
        counts |= ~_determine(tangents[counts], node[counts], normals[nodes])[node]
        before = normals[nodes]
        normals[nodes] = _with_cosines(before, tangents[counts], cosines[counts], node[counts])
        if np.abs(normals[nodes] - before).max() <= ROUNDING:
            break
    return normals[nodes]


def _with_cosines(normals: Array, tangents: Array, cosines: Array, node: Integers) -> Array:
    """(n, d) unit normals near `normals` that have given cosines with unit tangents.

    The cosines are fitted in least squares; `node` has the node of each tangent.
    """
    for _ in range(_STEPS):
        present = np.sum(tangents * normals[node], axis=1)
        across = tangents - present[:, None] * normals[node]
        change = np.zeros_like(normals)
        np.add.at(change, node, across * (cosines - present)[:, None])
        squares = _squares(across, node, normals.shape)
        inverse = np.linalg.pinv(squares, rcond=_SPANNED, hermitian=True)
        normals = unit_vectors(normals + np.einsum("nab,nb->na", inverse, change))
    return normals


def _determine(tangents: Array, node: Integers, normals: Array) -> Booleans:
    """(n,) nodes at which the tangents of lines determine the normal."""
    sizes = np.linalg.eigvalsh(_squares(tangents, node, normals.shape))
    return sizes[:, 1] > _SPANNED * sizes[:, -1]


def _squares(vectors: Array, node: Integers, shape: tuple[int, ...]) -> Array:
    """(n, d, d) sums of the outer products of the vectors of each node; `shape` is (n, d)."""
    squares = np.zeros((*shape, shape[1]))
    np.add.at(squares, node, vectors[:, :, None] * vectors[:, None])
    return squares
