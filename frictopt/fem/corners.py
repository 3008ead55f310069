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


def shares(
    contacts: Sequence[Contact], contact: Integers, nodes: Integers, others: Integers, points: Array, widths: Array, near: float
) -> tuple[Integers, csr_matrix]:
    """The pairs that are kept of N, and the (kept, N) matrix of the means that their relative motions stand for: so none follows from others.

    Where three bodies meet in a point, the relative motion of two of them follows from that of each to the third one, and so it does for two contacts
    of the same two bodies. Of such a circle the pair of the last contact is dissolved: the next pair of its contact stands for both, for the mean of
    their relative motions weighted by their widths. So a uniform traction still passes through (as for the multipliers at cross points of the mortar
    method, Wohlmuth 2000). A node that both faces have, at the tip of a crack, is no pair: what moves it relative to its place, where the faces do
    not match, counts with the next pair, of which the width stays.

    Parameters
    ----------
    contacts, contact
        The contacts, with names and bodies, and the (N,) number of the contact of each pair, increasing.
    nodes, others
        (N,) nodes of body 1, and the nodes of body 2 that they lie on, -1 where they lie on none.
    points, widths
        (N, d) places of the pairs, and their tributary widths or areas.
    near
        Distance up to which two places are one.

    Raises
    ------
    ModelError
        A contact of which no node is its own.
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
    heir = np.arange(n)
    for k in np.flatnonzero(~kept).tolist():
        free = np.flatnonzero(kept & (contact == contact[k]))
        if not len(free):
            raise ModelError(
                f"contacts: all nodes of {contacts[contact[k]].name!r} are corners that contacts before it have, the first at {place(points[k])}; "
                "mesh its faces with two elements or more, or list it first"
            )
        heir[k] = free[np.linalg.norm(points[free] - points[k], axis=1).argmin()]
    whole = np.bincount(heir, np.where(still, 0.0, widths), minlength=n)
    return np.flatnonzero(kept), csr_matrix((widths / whole[heir], (heir, np.arange(n))), shape=(n, n))[kept]
