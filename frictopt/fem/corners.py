"""Corners that belong to several contacts, in any number of dimensions: no relative motion there is counted twice."""

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from ..contact import Array, Integers, place
from ..errors import ModelError
from .contacts import Contact
from .elements import parts_of

_SMOOTH = 0.9  # least cosine between normals of faces that go on as one: sharp corners have less, meshes of curved faces more


def shares(
    contacts: Sequence[Contact], contact: Integers, nodes: Integers, others: Integers, points: Array, normals: Array, widths: Array, near: float
) -> tuple[Integers, csr_matrix, Array]:
    """The pairs that are kept of N, the (kept, N) matrix of the means that their relative motions stand for, and their (kept, d) normals.

    None of these motions follows from others. Where three bodies meet in a point, the relative motion of two of them follows from that of each to the
    third one, and so it does for two contacts of the same two bodies. Of such a circle the pair of the last contact is dissolved: the next one of its
    contact stands for both, for the mean of their relative motions weighted by their widths. So a uniform traction still passes through (as for the
    multipliers at cross points of the mortar method, Wohlmuth 2000). Where a face goes on smoothly from one contact of two bodies to another, that
    of the first one stands for both, with the sum of their normals: a face with two names is one face. A node that both faces have, at the tip of a
    crack, is no pair: what moves it relative to its place, where the faces do not match, counts with the next pair, of which the width stays.

    Parameters
    ----------
    contacts, contact
        The contacts, with names and bodies, and the (N,) number of the contact of each pair, increasing.
    nodes, others
        (N,) nodes of body 1, and the nodes of body 2 that they lie on, -1 where they lie on none.
    points, normals, widths
        (N, d) places and (N, d) normals of the pairs, of any length, and their tributary widths or areas.
    near
        Distance up to which two places are one.
    """
    n, still = len(nodes), nodes == others
    i, j = cKDTree(points).query_pairs(near, output_type="ndarray").T
    spot = parts_of((i, j), n)
    crowded = np.flatnonzero((np.bincount(spot)[spot] > 1) & ~still).tolist()
    ends = [[(contacts[contact[k]].body_1, int(nodes[k])), (contacts[contact[k]].body_2, int(others[k]))] for k in crowded]
    at = {(body, int(spot[k])): node for k, pair in zip(crowded, ends, strict=True) for body, node in pair if node >= 0}
    joined, kept = DisjointSet(), ~still
    for k, pair in zip(crowded, ends, strict=True):
        one, two = (node if node >= 0 else at.get((body, int(spot[k])), (body, int(spot[k]))) for body, node in pair)
        joined.add(one)
        joined.add(two)
        kept[k] = joined.merge(one, two)
    heir, total, unit = np.arange(n), normals.copy(), normals / np.linalg.norm(normals, axis=1)[:, None]
    opposite = np.array([one.body_2 for one in contacts])[contact]
    for k in np.flatnonzero(~kept).tolist():
        on = kept & (nodes == nodes[k]) & (opposite == opposite[k]) & (unit @ unit[k] > _SMOOTH)
        free = np.flatnonzero(kept & (contact == contact[k]))
        if not len(free):
            raise ModelError(
                f"contacts: all nodes of {contacts[contact[k]].name!r} are corners that contacts before it have, the first at {place(points[k])}; "
                "mesh its faces with two elements or more, or list it first"
            )
        if on.any():
            heir[k] = on.argmax()
            total[heir[k]] += normals[k]
        else:
            heir[k] = free[np.linalg.norm(points[free] - points[k], axis=1).argmin()]
    whole = np.bincount(heir, np.where(still, 0.0, widths), minlength=n)
    return np.flatnonzero(kept), csr_matrix((widths / whole[heir], (heir, np.arange(n))), shape=(n, n))[kept], total[kept]
