"""Normals at the nodes of faces: those of the curve or surface that the facets stand for, also at its free ends and rims."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..base import ROUNDING, Array, Booleans, Integers
from .faces import areas_of, normals_of

# least cosine between the normal of a node and those of its facets, where they stand for one smooth
# face
SMOOTH = 0.9
_THROUGH, _ONWARD = (
    0.8,
    0.5,
)  # least cosines between two edges of one line: through a node of the rim, and in the face
_BENDS_ON = (
    1 / 3
    # least share of its curvature that a curve keeps to the next node; at a corner of two flat faces
    # none is left
)
_PASSES = 40  # over the rim, whose nodes have angles with each other, at most
_STEPS = 6  # to the normal, in each of which what is left of an angle is squared
_SPANNED = 0.05  # least share of a second direction among the tangents at a node
# distance over the length of an edge up to which nodes lie on one surface: coordinates of five
# digits
_ON_SURFACE = 1e-4
# times this distance over the length: a lean of normals that is more than the places of the nodes
# leave open
_LEANS = 10.0
_ANGLES = 4  # nodes on so many generators tell a round face from two flat ones
_TURNED = 1e-3  # angles about an axis that differ by less of their range are those of one generator


def node_normals(facets: Integers, points: Array) -> Array:
    """(nodes, d) normals of facets (facets, corners) at their nodes (nodes, d), of any length.

    They are weighted as by Max (1999), which is exact on circles and spheres where facets surround
    a node. At free ends and rims they follow from the lines of nodes that end or go through there,
    as if these were arcs. Where the nodes lie on a cylinder or a cone and these normals lean from
    its own, as on free triangles, they are those of this surface.
    """
    weighted = _weighted(facets, points)
    length = np.linalg.norm(weighted, axis=1)
    length[length == 0] = 1.0
    normals = weighted / length[:, None]
    of_facets = normals_of(points[facets])
    leans = (np.einsum("fcd,fd->fc", normals[facets], of_facets) < SMOOTH).ravel()
    smooth = np.bincount(facets.ravel(), leans, minlength=len(points)) == 0
    if np.ptp(of_facets, axis=0).max() <= ROUNDING:
        return weighted
    found = normals.copy()
    nodes = np.flatnonzero(_rim(facets, len(points)) & smooth)
    if len(nodes):
        found[nodes] = _at_rim(nodes, facets, points, found)
    parts = _parts(facets, of_facets) if points.shape[1] == 3 else []
    uses = np.bincount(
        np.concatenate([np.zeros(0, int), *map(np.unique, parts)]), minlength=len(points)
    )
    for part in parts:
        nodes = np.unique(part)
        nodes = nodes[uses[nodes] == 1]  # those at a sharp edge are of several parts
        surface = _of_surface(part, nodes, points, found[nodes])
        if surface is not None:
            found[nodes] = surface
    changed = np.abs(found - normals).max(axis=1) > ROUNDING  # flat faces keep their zeros
    weighted[changed] = found[changed] * length[changed, None]
    return weighted


def normals_of_faces(faces: Sequence[Integers], points: Array) -> list[Array]:
    """(nodes, d) normals at the nodes of each of several faces of one body; faces that go on smoothly into each other are one."""
    weighted = [_weighted(facets, points) for facets in faces]
    units = [
        normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        for normals in weighted
    ]
    groups: list[list[int]] = []
    for i in range(len(faces)):
        group = [i]
        for other in list(groups):
            cosines = [_cosines(units[one], units[two]) for one in group for two in other]
            if any(len(cosine) for cosine in cosines) and all(
                (cosine > SMOOTH).all() for cosine in cosines
            ):
                groups.remove(other)
                group += other
        groups.append(group)
    found = {}
    for group in groups:
        facets = np.concatenate([faces[i] for i in group])
        _, once = np.unique(np.sort(facets, axis=1), axis=0, return_index=True)
        normals = node_normals(facets[np.sort(once)], points)
        found.update(dict.fromkeys(group, normals))
    return [found[i] for i in range(len(faces))]


def _cosines(one: Array, two: Array) -> Array:
    """Cosines between the unit normals of two faces at the nodes that both have."""
    shared = one.any(axis=1) & two.any(axis=1)
    return np.asarray(np.sum(one[shared] * two[shared], axis=1))


def _weighted(facets: Integers, points: Array) -> Array:
    """(nodes, d) sums of the normals of facets, weighted by the sine of the angle at the node over the lengths of its two edges.

    Weighted by areas they would lean where sizes, or the diagonals of triangles, differ from side
    to side: round fits would wedge as they turn.
    """
    corners, normals = points[facets], np.zeros_like(points)
    ahead, back = (np.roll(corners, step, axis=1) - corners for step in (-1, 1))
    turned, beside = (
        (np.cross(ahead, back), np.sum(back**2, axis=2))
        if points.shape[1] == 3
        else (areas_of(corners)[:, None], 1.0)
    )
    np.add.at(normals, facets, turned / (np.sum(ahead**2, axis=2) * beside)[..., None])
    return normals


def _parts(facets: Integers, of_facets: Array) -> list[Integers]:
    """Facets of each part of a face in space that no sharp edge divides."""
    count, corners = facets.shape
    edges = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    facet = np.repeat(np.arange(count), corners)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    one, two = facet[order[:-1][same]], facet[order[1:][same]]
    goes_on = (
        np.sum(of_facets[one] * of_facets[two], axis=1) > 2 * SMOOTH**2 - 1
    )  # twice the angle of a facet and a node
    graph = csr_matrix((goes_on[goes_on], (one[goes_on], two[goes_on])), shape=(count, count))
    total, part = connected_components(graph, directed=False)
    return [facets[part == number] for number in range(total)]


def _of_surface(facets: Integers, asked: Integers, points: Array, found: Array) -> Array | None:
    """(n, 3) unit normals at some of the nodes of facets that lie on one cylinder or cone; None if they do not.

    Those found (n, 3) stay where they lean from it by no more than the places of the nodes can
    tell.
    """
    nodes = np.unique(facets)
    arms = points[nodes] - points[nodes].mean(axis=0)
    edge = np.linalg.norm(points[np.roll(facets, 1, axis=1)] - points[facets], axis=2).min()
    spread = np.linalg.svd(arms, full_matrices=False)
    if len(nodes) < 2 * _ANGLES or np.abs(arms @ spread[2][2]).max() <= _ON_SURFACE * edge:
        return None  # flat
    of_facets = normals_of(points[facets])
    basis = np.linalg.svd(of_facets - of_facets.mean(axis=0), full_matrices=False)[
        2
    ]  # these normals have one angle with the axis

    def placed(unknowns: Array) -> tuple[Array, Array, Array, Array]:
        """Axis, heights along it, vectors from it, and radii."""
        axis = basis[2] + unknowns[:2] @ basis[:2]
        axis = axis / np.linalg.norm(axis)
        away = arms - edge * unknowns[2:4] @ basis[:2]
        height = away @ axis
        away = away - height[:, None] * axis
        return axis, height, away, np.linalg.norm(away, axis=1)

    def distances(unknowns: Array) -> Array:
        """Distances from the surface along radii, in edges."""
        _, height, _, radius = placed(unknowns)
        return np.asarray((radius - unknowns[5] * height) / edge - unknowns[4])

    flat = arms @ basis[:2].T / edge
    square = np.sum(flat**2, axis=1)
    *middle, rest = np.linalg.lstsq(
        np.column_stack([2 * flat, np.ones(len(flat))]), square, rcond=None
    )[0]
    begin = np.r_[0.0, 0.0, middle, np.sqrt(max(rest + np.square(middle).sum(), 0.0)), 0.0]
    fit = least_squares(distances, begin, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    if not np.abs(fit.fun).max() <= _ON_SURFACE:
        return None
    axis, _, away, radius = placed(fit.x)
    if not radius.min() > 0:  # the tip of a cone has no normal
        return None
    outward = away / radius[:, None]
    mean = outward.mean(axis=0)
    mean = mean if np.linalg.norm(mean) > SMOOTH / 2 else basis[0]
    angle = np.arctan2(outward @ np.cross(axis, mean), outward @ mean)
    generators = np.unique(
        np.round((angle - angle.min()) / (_TURNED * max(np.ptp(angle), ROUNDING)))
    )
    if len(generators) < _ANGLES:
        return None
    normals = (outward - fit.x[5] * axis)[np.searchsorted(nodes, asked)]
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    normals = normals * np.sign(np.sum(normals * found, axis=1))[:, None]
    leans = np.linalg.norm(normals - found, axis=1).max(initial=0.0)
    return np.asarray(normals) if leans > _LEANS * np.abs(fit.fun).max() else None


def _rim(facets: Integers, count: int) -> Booleans:
    """(count,) nodes at the free ends of a chain of edges, or on the rim of a face in space."""
    if facets.shape[1] == 2:
        return np.asarray(np.bincount(facets.ravel(), minlength=count) == 1)
    edges = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    each, uses = np.unique(edges, axis=0, return_counts=True)
    return np.asarray(np.isin(np.arange(count), each[uses == 1]))


def _at_rim(nodes: Integers, facets: Integers, points: Array, normals: Array) -> Array:
    """(n, d) unit normals at nodes of the rim, from lines of nodes there and the unit normals (nodes, d) of all nodes.

    A line that goes through a node has the tangent of the circle through its neighbours. A line
    that ends there is an arc to the next node: its chord has the same angle with both normals. If
    it does not bend on beyond that node, as at a corner of two flat faces, it is straight.
    """
    edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
    tail, head = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0).T  # by their tails
    ways = points[head] - points[tail]
    size = np.linalg.norm(ways, axis=1)
    along = ways / size[:, None]

    def onward(start: Integers, direction: Array, least: float) -> tuple[Integers, Booleans]:
        """The edge from each start that goes on in a direction best, and whether the cosine between them is large enough."""
        first = np.searchsorted(tail, start)
        count = np.searchsorted(tail, start, side="right") - first
        row = np.repeat(np.arange(len(start)), count)
        candidate = np.arange(len(row)) + np.repeat(first - np.cumsum(count) + count, count)
        cosine = np.sum(direction[row] * along[candidate], axis=1)
        best = np.lexsort((cosine, row))[np.cumsum(count) - 1]
        return candidate[best], cosine[best] > least

    def bend(one: Integers, two: Integers) -> Array:
        """Curvature, along the normal, of the line of two edges."""
        return np.asarray(
            2
            * np.sum((along[two] - along[one]) * normals[head[one]], axis=1)
            / (size[one] + size[two])
        )

    own = np.flatnonzero(np.isin(tail, nodes))
    opposite, through = onward(tail[own], -along[own], _THROUGH)
    second, goes_on = onward(head[own], along[own], _ONWARD)
    third, goes_far = onward(head[second], along[second], _ONWARD)
    circles = [
        ways[part] / size[part, None] ** 2 for part in (own, opposite)
    ]  # through the node: inverted, they are lines
    tangents = np.where(through[:, None], circles[0] - circles[1], ways[own])
    tangents = tangents / np.linalg.norm(tangents, axis=1)[:, None]
    place = np.searchsorted(nodes, tail[own])
    normals = normals.copy()
    for _ in range(_PASSES):
        near, far = bend(own, second), bend(second, third)
        curved = (
            ~through
            & goes_on
            & goes_far
            & (near * far > 0)
            & (np.abs(far) >= _BENDS_ON * np.abs(near))
        )
        leans = np.where(curved, -np.sum(tangents * normals[head[own]], axis=1), 0.0)
        told = through | curved
        told |= ~_spans(tangents[told], place[told], normals[nodes])[
            place
        ]  # else lines that do not bend on are straight
        before = normals[nodes]
        normals[nodes] = _with_angles(before, tangents[told], leans[told], place[told])
        if np.abs(normals[nodes] - before).max() <= ROUNDING:
            break
    return normals[nodes]


def _with_angles(normals: Array, tangents: Array, leans: Array, place: Integers) -> Array:
    """(n, d) unit normals near others whose cosines with unit tangents, each at the place of its node, are `leans`, in the mean of their squares."""
    for _ in range(_STEPS):
        cosines = np.sum(tangents * normals[place], axis=1)
        across = tangents - cosines[:, None] * normals[place]
        squares, wanted = np.zeros((*normals.shape, normals.shape[1])), np.zeros_like(normals)
        np.add.at(squares, place, across[:, :, None] * across[:, None])
        np.add.at(wanted, place, across * (leans - cosines)[:, None])
        normals = normals + np.einsum(
            "nab,nb->na", np.linalg.pinv(squares, rcond=_SPANNED, hermitian=True), wanted
        )
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    return normals


def _spans(tangents: Array, place: Integers, normals: Array) -> Booleans:
    """(n,) nodes at which the tangents of some lines determine the normal; each is at the place of its node."""
    squares = np.zeros((*normals.shape, normals.shape[1]))
    np.add.at(squares, place, tangents[:, :, None] * tangents[:, None])
    sizes = np.linalg.eigvalsh(squares)
    return np.asarray(sizes[:, 1] > _SPANNED * sizes[:, -1])
