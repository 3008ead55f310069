"""Faces of meshed bodies: facets and their order, overlaps of two faces, and mortar projection."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree
from skfem import Mesh

from ..base import ROUNDING, Array, Integers, place
from ..contact.components import frames_of
from ..errors import ModelError

# The nodes of a facet are nodes of the contact if at least this share of the facet faces the other
# face. It is below 1, because ends and rims of round faces miss each other by their sag.
FACED = 0.5


# Numbers of the search for facets that face each other.

# Largest cosine of the angle between the normals of two facets: the normals may deviate by up to 60
# degrees from opposite directions.
_OPPOSITE = -0.5
# Steps towards the place where a normal meets the other face. If the faces deviate by 30
# degrees, each step reduces the distance to a quarter.
_STEPS = 10


def facets_around(mesh: Mesh, facets: Integers) -> Integers:
    """(facets, corners) nodes of facets of the outline, ordered so that normals point inward."""
    nodes = np.array(mesh.facets[:, facets].T)
    corners = mesh.p.T[nodes]
    inward = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1).T - corners[:, 0]
    points_outward = np.sum(normals_of(corners) * inward, axis=1) < 0
    nodes[points_outward] = nodes[points_outward][:, ::-1]
    return nodes


def normals_of(corners: Array) -> Array:
    """(facets, d) unit normals of facets (facets, corners, d), see `areas_of`."""
    return unit_vectors(areas_of(corners))


def unit_vectors(vectors: Array) -> Array:
    """Vectors (..., d) of length one; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, np.finfo(float).tiny))


def areas_of(corners: Array) -> Array:
    """(facets, d) normals of facets (facets, corners, d), as long as the edge or the area.

    The normal of an edge is the edge turned by 90 degrees; the normal of a polygon is its vector
    area.
    """
    arms = corners - corners[:, :1]
    if corners.shape[2] == 2:
        return np.column_stack([-arms[:, 1, 1], arms[:, 1, 0]])
    return np.asarray(np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1) / 2)


@dataclass(frozen=True, eq=False)
class Face:
    """A face of a body: nodes (facets, corners) of its facets, and all points with errors."""

    facets: Integers
    points: Array
    errors: Array

    @property
    def corners(self) -> Array:
        """(facets, corners, d) places of the corners of the facets."""
        return self.points[self.facets]

    @property
    def sizes(self) -> Array:
        """(facets,) lengths or areas of the facets."""
        return np.asarray(np.linalg.norm(areas_of(self.corners), axis=1))

    def sag(self) -> Array:
        """(nodes,) distance by which facets at a node may miss the curved face.

        This distance follows from the angle between the facets at the node. The errors of the
        coordinates cause such an angle in flat faces, too; their part is subtracted.
        """
        facets, points, corners = self.facets, self.points, self.corners
        normals = normals_of(corners)[:, None]
        edges = corners[:, :, None] - corners[:, None]
        longest = np.linalg.norm(edges, axis=3).max(axis=(1, 2))

        total = np.zeros_like(points)
        np.add.at(total, facets, normals)
        half_chord = np.linalg.norm(unit_vectors(total)[facets] - normals, axis=2) / 2
        turn = np.zeros(len(points))
        np.maximum.at(turn, facets, 4 * np.arcsin(np.minimum(half_chord, 1.0)))

        error = np.linalg.norm(self.errors[facets], axis=2).max(axis=1)
        flat = error * longest ** (points.shape[1] - 1) / self.sizes
        of_facets = np.maximum(turn[facets].max(axis=1) * longest / 8 - flat, 0.0)
        of_nodes = np.zeros(len(points))
        np.maximum.at(of_nodes, facets, of_facets[:, None])
        return of_nodes


def neighbours(
    places: Array, reach: Array, centres: Array, radii: Array
) -> tuple[Integers, Integers]:
    """Pairs i, j of places (n, d) and centres (m, d) at most `reach[i] + radii[j]` apart.

    Centres of similar radii (up to a factor of two) are searched together.
    """
    octave = np.ceil(np.log2(radii))
    pairs = []
    for size in np.unique(octave):
        group = np.flatnonzero(octave == size)
        tree = cKDTree(centres[group])
        hits = tree.query_ball_point(places, reach + radii[group].max())
        i = np.repeat(np.arange(len(places)), [len(hit) for hit in hits])
        j = group[np.concatenate(hits).astype(np.intp)]
        near = np.linalg.norm(places[i] - centres[j], axis=1) <= reach[i] + radii[j]
        pairs.append((i[near], j[near]))
    i, j = np.hstack(pairs)
    return i, j


def ordered_nodes(face: Face, argument: str) -> Integers:
    """Nodes of a face in the plane, in order, with the body on the left.

    The facets form one line. `argument` is their name in error messages.
    """
    lines = lines_along(face.facets, face.points, argument)
    if len(lines) > 1:
        place_1, place_2 = (place(face.points[nodes[0]]) for nodes, _ in lines[:2])
        raise ModelError(
            f"{argument} is in several pieces, one at {place_1}, another at {place_2}; make a "
            "contact of each piece"
        )
    line, is_closed = lines[0]
    nodes = line[::-1]
    return np.roll(nodes, -int(nodes.argmin())) if is_closed else nodes


def lines_along(facets: Integers, points: Array, argument: str) -> list[tuple[Integers, bool]]:
    """Nodes of facets of `facets_around` in the plane, line by line, and whether it is closed.

    The body is on the right of the line. A closed line begins at its leftmost node.
    """
    end, start = facets.T
    for nodes in (start, end):
        uses = np.bincount(nodes)
        if uses.max() > 1:
            raise ModelError(
                f"{argument} touches itself at {place(points[uses.argmax()])}; make a contact "
                "of each part"
            )
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    is_inner = np.isin(start, end)  # all other nodes begin an open line
    lines = []
    for i in np.lexsort((*points[start].T[::-1], is_inner)):
        line = []
        node = int(start[i])
        while node in onward:
            line.append(node)
            node = onward.pop(node)
        if line:
            is_closed = bool(is_inner[i])
            lines.append((np.array(line if is_closed else [*line, node]), is_closed))
    return lines


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Points of integration on the overlaps of the facets of two faces."""

    # (m,) facet of body 1 on which each point lies
    facet: Integers
    # (m,) length or area of each point
    weights: Array
    # (m, k) nodes of this facet, and their hat functions at the point
    nodes_1: Integers
    phi: Array
    # (m, l) nodes of the facet of body 2 that the point faces, and their hat functions there
    nodes_2: Integers
    chi: Array


def mortar_projection(overlaps: Overlaps, nodes: Integers, count: int) -> tuple[csr_matrix, Array]:
    """Dual mortar projection of displacements from body 2 to n nodes of body 1 (Wohlmuth 2000).

    The results are the (n, count) matrix `P = D^-1 M` and the diagonal (n,) of D. Here phi are the
    hat functions of face 1, chi the hat functions of face 2, and psi the dual functions: over the
    overlaps of a facet, `int psi_a phi_b` is `int phi_a` for a = b, else zero. Then `D = diag(int
    phi_a)` and `M_aj = int psi_a chi_j`. Linear displacements along the face are reproduced, and a
    uniform traction is passed on.
    """
    phi = overlaps.phi
    m, k = phi.shape
    integral = csr_matrix((overlaps.weights, (overlaps.facet, np.arange(m))))  # over each facet
    gram = (integral @ (phi[:, :, None] * phi[:, None]).reshape(m, -1)).reshape(-1, k, k)
    duals = (integral @ phi)[:, :, None] * np.linalg.inv(gram)
    psi = np.einsum("mab,mb->ma", duals[overlaps.facet], phi)

    weighted_psi = _by_points(
        overlaps.weights[:, None] * psi, overlaps.nodes_1, int(nodes.max()) + 1
    )[:, nodes]
    D = np.asarray(weighted_psi.sum(axis=0)).ravel()
    M = weighted_psi.T @ _by_points(overlaps.chi, overlaps.nodes_2, count)
    P = csr_matrix(diags(1 / D) @ M)
    P.data[np.abs(P.data) < ROUNDING / 10] = 0.0  # rounding at neighbours, if faces match
    P.eliminate_zeros()
    return P, D


def _by_points(values: Array, columns: Integers, size: int) -> csr_matrix:
    """(m, size) matrix with values (m, k) of each point, in columns (m, k)."""
    starts = np.arange(0, values.size + 1, values.shape[1])
    return csr_matrix((values.ravel(), columns.ravel(), starts), shape=(len(values), size))


def facet_overlaps(face_1: Face, face_2: Face) -> Overlaps:
    """The overlaps of the facets of two faces, seen along the normals of the first face.

    Faces that look away from each other do not overlap. Facets are edges, triangles or
    quadrilaterals, ordered so that their normals point into the body.

    A quadrilateral is divided into four triangles around its middle, which moves by the mean of its
    corners. A uniform traction then loads the corners as with bilinear functions, and all integrals
    are exact.
    """
    corners = face_1.corners
    frames = frames_of(normals_of(corners))
    middles = corners.mean(axis=1)
    facet, hats_1 = _parts_of(face_1.facets)
    facet_2, hats_2 = _parts_of(face_2.facets)
    parts_1 = np.einsum("mck,mkd->mcd", hats_1, corners[facet])
    parts_2 = np.einsum("mck,mkd->mcd", hats_2, face_2.corners[facet_2])
    i, j = _facing(parts_1, frames[facet, -1], parts_2)
    e = facet[i]

    # Project both parts onto the plane of the facet of body 1. The corners of body 2 are in the
    # opposite order.
    a = np.einsum("mxd,mcd->mcx", frames[e, :-1], parts_1[i] - middles[e, None])
    b = np.einsum("mxd,mcd->mcx", frames[e, :-1], parts_2[j, ::-1] - middles[e, None])
    pair, common = common_parts(a, b)
    part, points, weights = integration_points_of(common)
    pair = pair[part]
    phi = np.einsum("mc,mck->mk", hat_functions(a[pair], points), hats_1[i[pair]])
    chi = np.einsum("mc,mck->mk", hat_functions(b[pair], points), hats_2[j[pair], ::-1])
    return Overlaps(
        facet=e[pair],
        weights=weights,
        nodes_1=face_1.facets[e[pair]],
        phi=phi,
        nodes_2=face_2.facets[facet_2[j[pair]]],
        chi=chi,
    )


def _parts_of(facets: Integers) -> tuple[Integers, Array]:
    """The edges or triangles that make up facets (m, corners): the facet (n,) of each, and hats.

    The hats (n, 2 or 3, corners) are the hat functions of the facet at the corners of the part. If
    a corner of a quadrilateral is repeated, the triangle at this side has no area and is left out.
    """
    count, corners = facets.shape
    hats = np.eye(corners)
    if corners <= 3:
        return np.arange(count), np.tile(hats, (count, 1, 1))
    middle = np.full_like(hats, 1 / corners)
    hats = np.stack([hats, np.roll(hats, -1, axis=0), middle], axis=1)
    facet, part = np.nonzero(facets != np.roll(facets, -1, axis=1))
    return facet, hats[part]


def _facing(parts_1: Array, normals: Array, parts_2: Array) -> tuple[Integers, Integers]:
    """Pairs of edges or triangles (m, d, d) of two faces that may overlap along the normals.

    The search begins at the middle of a part of face 1. In each step, the nearest middle of face 2
    is projected onto the normal. The foot approaches the place where the normal meets face 2.
    """
    middle_1, radius_1 = _circles_around(parts_1)
    middle_2, radius_2 = _circles_around(parts_2)
    tree = cKDTree(middle_2)
    foot = middle_1
    for _ in range(_STEPS):
        distance, nearest = tree.query(foot)
        height = np.sum((middle_2[nearest] - middle_1) * normals, axis=1)
        foot = middle_1 + height[:, None] * normals
    # An inclined part reaches further along the normal: by one over the cosine of its angle.
    reach = (np.minimum(distance, radius_2.max()) + radius_1) / abs(_OPPOSITE)
    i, j = neighbours(foot, reach, middle_2, radius_2)
    is_opposite = np.sum(normals[i] * normals_of(parts_2)[j], axis=1) < _OPPOSITE
    i = i[is_opposite]
    j = j[is_opposite]
    arm = middle_2[j] - middle_1[i]
    along = np.sum(arm * normals[i], axis=1)[:, None] * normals[i]
    near = np.linalg.norm(arm - along, axis=1) <= radius_1[i] + radius_2[j]
    return i[near], j[near]


def _circles_around(parts: Array) -> tuple[Array, Array]:
    """Middles (m, d) of parts, and their largest distances (m,) from a corner."""
    middles = parts.mean(axis=1)
    return middles, np.linalg.norm(parts - middles[:, None], axis=2).max(axis=1)


# Barycentric coordinates of points of integration of equal weight, on an interval and on a
# triangle, by the number of corners. The integrals are exact for products of two hat functions, and
# on an interval also for such a product times a linear depth.
_NEAR = (1 - np.sqrt(1 / 3)) / 2
_POINTS = {
    2: np.array([[1 - _NEAR, _NEAR], [_NEAR, 1 - _NEAR]]),
    3: np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6,
}


def common_parts(a: Array, b: Array) -> tuple[Integers, Array]:
    """The pieces that make up the overlaps of pairs of parts, and the pair (m,) of each piece.

    The corners of triangles are counterclockwise, and intervals begin at their smaller end.
    """
    if a.shape[1] == 2:
        common = np.stack([np.maximum(a[:, 0], b[:, 0]), np.minimum(a[:, 1], b[:, 1])], axis=1)
        pair = np.arange(len(a))
    else:
        pair, common = _common_triangles(a, b)
    overlap = np.flatnonzero(_sizes(common) > 0)
    return pair[overlap], common[overlap]


def integration_points_of(parts: Array) -> tuple[Integers, Array, Array]:
    """Integration points (n, 1 or 2) of m parts, with the part (n,) of each and its weight (n,)."""
    rule = _POINTS[parts.shape[1]]
    points = np.concatenate([np.einsum("c,mcx->mx", weights, parts) for weights in rule])
    sizes = np.tile(_sizes(parts) / len(rule), len(rule))
    return np.tile(np.arange(len(parts)), len(rule)), points, sizes


def hat_functions(parts: Array, points: Array) -> Array:
    """(m, corners) hat functions of the corners of parts, at one point (m, 1 or 2) in each."""
    opposite = []
    for corner in range(parts.shape[1]):
        part = parts.copy()
        part[:, corner] = points
        opposite.append(_sizes(part))
    return np.asarray(np.column_stack(opposite) / np.sum(opposite, axis=0)[:, None])


def _common_triangles(a: Array, b: Array) -> tuple[Integers, Array]:
    """Triangles (m, 3, 2), some of size zero, of the overlaps of pairs of triangles (pairs, 3, 2).

    Each overlap is a convex polygon: triangle a, clipped by the three sides of triangle b.
    """
    polygons = a
    for corner in range(3):
        polygons = _clipped(polygons, b[:, corner], b[:, (corner + 1) % 3])
    fans = [
        np.stack([polygons[:, 0], polygons[:, c], polygons[:, c + 1]], axis=1)
        for c in range(1, polygons.shape[1] - 1)
    ]
    return np.tile(np.arange(len(a)), len(fans)), np.concatenate([a[:0], *fans])


def _clipped(polygons: Array, start: Array, end: Array) -> Array:
    """The parts of convex polygons (m, corners, 2) to the left of lines from `start` to `end`.

    The ends of the lines are (m, 2). All polygons have the same number of corners: the first corner
    is repeated.
    """
    height = _areas(start[:, None], end[:, None], polygons)
    next_height = np.roll(height, -1, axis=1)
    inside = height >= 0
    crosses = inside != (next_height >= 0)
    share = height / np.where(crosses, height - next_height, 1.0)
    cuts = polygons + share[:, :, None] * (np.roll(polygons, -1, axis=1) - polygons)

    # Each corner is followed by the point where the side after it is cut. Points that stay come
    # first.
    m, count = inside.shape
    corners = np.stack([polygons, cuts], axis=2).reshape(m, 2 * count, 2)
    remains = np.stack([inside, crosses], axis=2).reshape(m, 2 * count)
    largest = remains.sum(axis=1).max(initial=1)
    order = np.argsort(~remains, axis=1, kind="stable")[:, :largest]
    corners = np.take_along_axis(corners, order[:, :, None], axis=1)
    remains = np.take_along_axis(remains, order, axis=1)
    return np.where(remains[:, :, None], corners, corners[:, :1])


def _sizes(parts: Array) -> Array:
    """Signed lengths of intervals or areas of triangles."""
    if parts.shape[1] == 2:
        return parts[:, 1, 0] - parts[:, 0, 0]
    return _areas(parts[:, 0], parts[:, 1], parts[:, 2])


def _areas(a: Array, b: Array, c: Array) -> Array:
    """Signed areas of triangles with corners (..., 2)."""
    return ((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]) / 2
