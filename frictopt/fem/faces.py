"""Faces of meshed bodies: facets, in the plane as one chain, their overlaps, and the dual mortar projection between two faces (Wohlmuth 2000)."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree
from skfem import Mesh

from ..base import ROUNDING, Array, Integers, place
from ..contact.frames import frames_of
from ..errors import ModelError
from .bodies import Body

# least share of a facet that faces another face: ends and rims of round faces miss each other by
# their sag
FACED = 0.5
_NEAR = (1 - np.sqrt(1 / 3)) / 2
# of an interval and of a triangle, of equal weight: exact for products of two hat functions, with a
# linear depth in the plane
_POINTS = {
    2: np.array([[1 - _NEAR, _NEAR], [_NEAR, 1 - _NEAR]]),
    3: np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6,
}
# largest cosine of the angle between the normals of facets that face each other: they lean by up to
# 60 degrees
_OPPOSITE = -0.5
# towards the place where a normal meets the other face; each leaves a quarter of the way where the
# faces lean by 30 degrees
_STEPS = 10


def facets_around(mesh: Mesh, facets: Integers) -> Integers:
    """(facets, corners) nodes of facets of the outline, in the order in which their normals point into the body."""
    nodes = np.array(mesh.facets[:, facets].T)
    corners = mesh.p.T[nodes]
    inward = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1).T - corners[:, 0]
    away = np.sum(normals_of(corners) * inward, axis=1) < 0
    nodes[away] = nodes[away][:, ::-1]
    return nodes


def normals_of(corners: Array) -> Array:
    """(facets, d) unit normals of facets (facets, corners, d): of an edge that turned by 90 degrees, of a polygon that of its area."""
    normals = areas_of(corners)
    return np.asarray(normals / np.linalg.norm(normals, axis=1)[:, None])


def areas_of(corners: Array) -> Array:
    """(facets, d) normals of facets (facets, corners, d) with the length of an edge, or with the area of a polygon."""
    arms = corners - corners[:, :1]
    if corners.shape[2] == 2:
        return np.column_stack([-arms[:, 1, 1], arms[:, 1, 0]])
    return np.asarray(np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1) / 2)


def sag(facets: Integers, points: Array, errors: Array) -> Array:
    """(nodes,) distance by which the facets at a node may miss the curved face that they stand for, from the angle that they turn there.

    A flat face turns by the errors (nodes, d) of its coordinates: that is no sag.
    """
    corners = points[facets]
    normals, longest = (
        normals_of(corners)[:, None],
        np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2)),
    )
    mean, turn, worst = np.zeros_like(points), np.zeros(len(points)), np.zeros(len(points))
    np.add.at(mean, facets, normals)
    mean = mean / np.maximum(np.linalg.norm(mean, axis=1), np.finfo(float).tiny)[:, None]
    np.maximum.at(
        turn,
        facets,
        4 * np.arcsin(np.minimum(np.linalg.norm(mean[facets] - normals, axis=2) / 2, 1.0)),
    )
    flat = (
        np.linalg.norm(errors[facets], axis=2).max(axis=1)
        * longest ** (points.shape[1] - 1)
        / np.linalg.norm(areas_of(corners), axis=1)
    )
    np.maximum.at(
        worst, facets, np.maximum(turn[facets].max(axis=1) * longest / 8 - flat, 0.0)[:, None]
    )
    return worst


def neighbours(
    places: Array, reach: Array, others: Array, radii: Array
) -> tuple[Integers, Integers]:
    """Pairs i, j of places and others, (n, d) and (m, d), at a distance of at most `reach[i] + radii[j]`; the search goes by sizes of radii."""
    octave, pairs = np.ceil(np.log2(radii)), []
    for size in np.unique(octave):
        some = np.flatnonzero(octave == size)
        found = cKDTree(others[some]).query_ball_point(places, reach + radii[some].max())
        i, j = (
            np.repeat(np.arange(len(places)), [len(part) for part in found]),
            some[np.concatenate(found).astype(np.intp)],
        )
        near = np.linalg.norm(places[i] - others[j], axis=1) <= reach[i] + radii[j]
        pairs.append((i[near], j[near]))
    i, j = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return i, j


def course(body: Body, boundary: str, argument: str) -> Integers:
    """Nodes of a boundary in the plane in their order, the body on the left of the way; error messages call it `argument`."""
    mesh, start = body.mesh, f"{argument}: boundary {boundary!r}"
    (line, closed), *others = lines_along(mesh, body.boundary(boundary, argument), start)
    if others:
        one, other = (place(mesh.p[:, nodes[0]]) for nodes in (line, others[0][0]))
        raise ModelError(
            f"{start} is in several pieces, one at {one}, another at {other}; make a contact of each piece"
        )
    nodes = line[::-1]
    return np.roll(nodes, -int(nodes.argmin())) if closed else nodes


def lines_along(mesh: Mesh, facets: Integers, argument: str) -> list[tuple[Integers, bool]]:
    """Nodes of facets of a plane outline, line by line, the body on the right of the way, and whether the line is closed: it begins leftmost then."""
    end, start = facets_around(mesh, facets).T
    for nodes in (start, end):
        if (np.bincount(nodes) > 1).any():
            raise ModelError(
                f"{argument} touches itself at {place(mesh.p[:, np.bincount(nodes).argmax()])}; make a contact of each part"
            )
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    inner, lines = np.isin(start, end), []
    for i in np.lexsort((*mesh.p[::-1, start], inner)):  # ends of open lines come first
        node, line = int(start[i]), []
        while node in onward:
            line.append(node)
            node = onward.pop(node)
        if line:
            lines.append((np.array(line if inner[i] else [*line, node]), bool(inner[i])))
    return lines


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Points of integration on the overlaps of the facets of two faces."""

    facet: Integers  # (m,) of body 1 that each point lies on
    weights: Array  # (m,) length or area that it stands for
    own: Integers  # (m, k) nodes of that facet
    phi: Array  # (m, k) their hat functions at the point
    other: Integers  # (m, l) nodes of the facet of body 2 that the point faces
    chi: Array  # (m, l) their hat functions there


def faced(overlaps: Overlaps, corners: Array) -> Array:
    """(facets,) share of each facet (facets, corners, d) of body 1 that faces body 2."""
    return np.asarray(
        np.bincount(overlaps.facet, overlaps.weights, minlength=len(corners))
        / np.linalg.norm(areas_of(corners), axis=1)
    )


def mortar_projection(overlaps: Overlaps, nodes: Integers, others: int) -> tuple[csr_matrix, Array]:
    """(n, others) matrix `P = D^-1 M` that gives the n nodes of the face the displacements of nodes on the other side, and the diagonal (n,) of D.

    With phi the hat functions of the face, psi the dual ones (over the overlaps of a facet, `int
    psi_a phi_b` is `int phi_a` for a = b, else zero) and chi those of the other side, `D = diag(int
    phi_a)` and `M_aj = int psi_a chi_j`. Linear displacements along the face are reproduced, and a
    uniform traction is handed over as such.
    """
    m, phi = len(overlaps.weights), overlaps.phi
    gather = csr_matrix((overlaps.weights, (overlaps.facet, np.arange(m))))
    gram = (gather @ (phi[:, :, None] * phi[:, None]).reshape(m, -1)).reshape(
        -1, phi.shape[1], phi.shape[1]
    )
    duals = (gather @ phi)[:, :, None] * np.linalg.inv(gram)
    psi = np.einsum("mab,mb->ma", duals[overlaps.facet], phi)

    def rows(values: Array, columns: Integers, size: int) -> csr_matrix:
        return csr_matrix(
            (values.ravel(), columns.ravel(), np.arange(0, values.size + 1, values.shape[1])),
            shape=(m, size),
        )

    place = np.zeros(int(nodes.max()) + 1, dtype=np.intp)
    place[nodes] = np.arange(len(nodes))
    dual = rows(overlaps.weights[:, None] * psi, place[overlaps.own], len(nodes))
    D = np.asarray(dual.sum(axis=0)).ravel()
    P = csr_matrix(diags(1 / D) @ (dual.T @ rows(overlaps.chi, overlaps.other, others)))
    P.data[np.abs(P.data) < ROUNDING / 10] = 0.0  # neighbours in faces that match
    P.eliminate_zeros()
    return P, D


def facet_overlaps(one: Integers, points: Array, two: Integers, others: Array) -> Overlaps:
    """The overlaps of the facets of two faces, seen along the normals of those of the first; with none where the faces look away from each other.

    A quadrilateral is four triangles around its middle, which moves by the mean of its corners: a
    uniform traction then loads the corners as with bilinear functions, whatever the shape, and all
    integrals are exact.

    Of each face are given its facets by nodes (facets, corners), edges in the plane, else triangles
    or quadrilaterals, in the order in which their normals point into their body, and the
    coordinates (nodes, d).
    """
    corners, d = points[one], points.shape[1]
    frames, middles = frames_of(normals_of(corners)), corners.mean(axis=1)
    (hats, A), (other_hats, B) = (
        (_parts(facets.shape[1]), places[facets])
        for facets, places in ((one, points), (two, others))
    )
    facet, A = (
        np.repeat(np.arange(len(one)), len(hats)),
        np.einsum("tck,mkd->mtcd", hats, A).reshape(-1, d, d),
    )
    B = np.einsum("tck,mkd->mtcd", other_hats, B).reshape(-1, d, d)
    i, j = _facing(A, frames[facet, -1], B)
    e = facet[i]
    a, b = (
        np.einsum("mxd,mcd->mcx", frames[e, :-1], parts - middles[e, None])
        for parts in (A[i], B[j, ::-1])
    )
    pair, parts = _common(a, b) if d == 2 else _overlaps(a, b)
    at = np.concatenate([np.einsum("c,mcx->mx", share, parts) for share in _POINTS[d]])
    size, pair = (
        np.tile(_sizes(parts) / len(_POINTS[d]), len(_POINTS[d])),
        np.tile(pair, len(_POINTS[d])),
    )
    phi = np.einsum("mc,mck->mk", _shares(a[pair], at), hats[i[pair] % len(hats)])
    chi = np.einsum("mc,mck->mk", _shares(b[pair], at), other_hats[j[pair] % len(other_hats), ::-1])
    return Overlaps(e[pair], size, one[e[pair]], phi, two[j[pair] // len(other_hats)], chi)


def _parts(corners: int) -> Array:
    """(parts, 2 or 3, corners) hat functions of the corners of a facet at those of its edge or triangles."""
    own = np.eye(corners)
    return (
        own[None]
        if corners <= 3
        else np.stack([own, np.roll(own, -1, axis=0), np.full_like(own, 1 / corners)], axis=1)
    )


def _common(a: Array, b: Array) -> tuple[Integers, Array]:
    """(m, 2, 1) what pairs of intervals (pairs, 2, 1) have in common, and the pair that each belongs to."""
    common = np.stack([np.maximum(a[:, 0], b[:, 0]), np.minimum(a[:, 1], b[:, 1])], axis=1)
    some = np.flatnonzero(_sizes(common) > 0)
    return some, common[some]


def _facing(A: Array, normals: Array, B: Array) -> tuple[Integers, Integers]:
    """Pairs of edges or triangles (m, d, d) of two faces that may overlap if seen along the normals of the first.

    Beginning at the middle of a part, the next middle of the other face and its foot on the normal
    lead to where the normal meets that face.
    """
    (a, ra), (b, rb) = (
        (T.mean(axis=1), np.linalg.norm(T - T.mean(axis=1)[:, None], axis=2).max(axis=1))
        for T in (A, B)
    )
    tree, foot = cKDTree(b), a
    for _ in range(_STEPS):
        distance, nearest = tree.query(foot)
        foot = a + np.sum((b[nearest] - a) * normals, axis=1)[:, None] * normals
    i, j = neighbours(foot, (np.minimum(distance, rb.max()) + ra) / abs(_OPPOSITE), b, rb)
    facing = np.sum(normals[i] * normals_of(B)[j], axis=1) < _OPPOSITE
    i, j = i[facing], j[facing]
    arm = b[j] - a[i]
    aside = np.linalg.norm(arm - np.sum(arm * normals[i], axis=1)[:, None] * normals[i], axis=1)
    near = aside <= ra[i] + rb[j]
    return i[near], j[near]


def _overlaps(a: Array, b: Array) -> tuple[Integers, Array]:
    """(m, 3, 2) triangles that make up the overlaps of pairs of triangles (pairs, 3, 2), counterclockwise, and the pair that each belongs to."""
    polygons, pair = a, np.arange(len(a))
    for corner in range(3):
        polygons = _clipped(polygons, b[:, corner], b[:, (corner + 1) % 3])
    fans = [
        np.stack([polygons[:, 0], polygons[:, c], polygons[:, c + 1]], axis=1)
        for c in range(1, polygons.shape[1] - 1)
    ]
    triangles, pair = np.concatenate([a[:0], *fans]), np.tile(pair, len(fans))
    some = _sizes(triangles) > 0
    return pair[some], triangles[some]


def _clipped(polygons: Array, start: Array, end: Array) -> Array:
    """The parts of convex polygons (m, corners, 2) to the left of lines from `start` to `end` (m, 2); the first corner fills up those with fewer."""
    height = _areas(start[:, None], end[:, None], polygons)
    inside, onward = height >= 0, np.roll(height, -1, axis=1)
    crosses = inside != (onward >= 0)
    share = height / np.where(crosses, height - onward, 1.0)
    cuts = polygons + share[:, :, None] * (np.roll(polygons, -1, axis=1) - polygons)
    m, most = inside.shape
    corners, kept = (
        np.stack([polygons, cuts], axis=2).reshape(m, 2 * most, 2),
        np.stack([inside, crosses], axis=2).reshape(m, 2 * most),
    )
    order = np.argsort(~kept, axis=1, kind="stable")[:, : kept.sum(axis=1).max(initial=1)]
    found = np.take_along_axis(corners, order[:, :, None], axis=1)
    return np.where(np.take_along_axis(kept, order, axis=1)[:, :, None], found, found[:, :1])


def _shares(parts: Array, at: Array) -> Array:
    """(m, corners) hat functions of the corners of intervals (m, 2, 1) or triangles (m, 3, 2) at points (m, 1) or (m, 2)."""
    count = parts.shape[1]
    without = [
        _sizes(np.stack([parts[:, c] if c != corner else at for c in range(count)], axis=1))
        for corner in range(count)
    ]
    return np.asarray(np.column_stack(without) / np.sum(without, axis=0)[:, None])


def _sizes(parts: Array) -> Array:
    """Signed lengths of intervals (m, 2, 1) or areas of triangles (m, 3, 2)."""
    return parts[:, 1, 0] - parts[:, 0, 0] if parts.shape[1] == 2 else _areas(*parts.swapaxes(0, 1))


def _areas(a: Array, b: Array, c: Array) -> Array:
    """Signed areas of triangles with corners (..., 2)."""
    return np.asarray(((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]) / 2)
