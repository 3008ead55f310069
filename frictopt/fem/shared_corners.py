"""Corners of several contacts: independent pairs, and pairs that represent other pairs.

If three bodies meet in a point, the relative motion of two of them follows from the motions of both
relative to the third. Two contacts between the same two bodies also make such a circle. In a circle
the pair of the last contact is dissolved.
"""

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse import csr_matrix

from ..base import Array, Booleans, Integers
from ..errors import ModelError
from .coincidence import coincident
from .contacts import Contact
from .elasticity import parts_of
from .normals import SMOOTH


def independent_pairs(
    contacts: Sequence[Contact],
    contact: Integers,
    nodes: Integers,
    partners: Integers,
    points: Array,
    errors: Array,
    normals: Array,
    widths: Array,
    inside: Booleans,
) -> tuple[Integers, csr_matrix, Array]:
    """Find the pairs whose relative motions are independent, of N pairs.

    The next pair of its contact represents a dissolved pair: it has the mean of both relative
    motions, weighted by their widths. So a uniform traction still passes through (as for the
    multipliers at cross points of the mortar method, Wohlmuth 2000).

    A face with two names is one face: if it continues smoothly from one contact of two bodies to
    another, the pair of the first contact represents both, with the sum of their normals.

    A node that both faces share, at the tip of a crack, is no pair. If the faces do not match, the
    motion relative to its place counts with the next pair, whose width does not change.

    The next pair also represents a node that lies beyond the edge of body 2.

    Arguments are, for each pair, the number of the contact, increasing; the node of body 1, and its
    partner, the node of body 2 that coincides with it (-1: none); the point with its errors; the
    normal, of any length; the width; and whether the node lies opposite body 2.

    Returned are the (kept,) independent pairs, the (kept, N) matrix of the means, and the (kept, d)
    normals.
    """
    n = len(nodes)
    kept = _independent(contacts, contact, nodes, partners, points, errors, inside)
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    body_2 = np.array([one_contact.body_2 for one_contact in contacts])[contact]
    heir = np.arange(n)  # the pair that represents each pair
    total = normals.copy()
    for k in np.flatnonzero(~kept).tolist():
        same_contact = np.flatnonzero(kept & (contact == contact[k]))
        if not len(same_contact):
            raise ModelError(
                f"contacts: all nodes of {contacts[contact[k]].name!r} are corners of contacts "
                "that are listed before it; mesh it with two elements, or list it first"
            )
        same_faces = kept & (nodes == nodes[k]) & (body_2 == body_2[k])
        smooth = same_faces & (unit @ unit[k] > SMOOTH)
        if smooth.any():
            heir[k] = smooth.argmax()
            total[heir[k]] += normals[k]
        else:
            distance = np.linalg.norm(points[same_contact] - points[k], axis=1)
            heir[k] = same_contact[distance.argmin()]
    is_tip = nodes == partners
    whole = np.bincount(heir, np.where(is_tip, 0.0, widths), minlength=n)
    means = csr_matrix((widths / whole[heir], (heir, np.arange(n))), shape=(n, n))
    return np.flatnonzero(kept), means[kept], total[kept]


def _independent(
    contacts: Sequence[Contact],
    contact: Integers,
    nodes: Integers,
    partners: Integers,
    points: Array,
    errors: Array,
    inside: Booleans,
) -> Booleans:
    """(N,) whether a pair lies inside, and moves independently of the pairs before it."""
    independent = (nodes != partners) & inside
    spot = parts_of(coincident(points, errors), len(nodes))  # (N,) number of the place of a pair
    is_crowded = (np.bincount(spot)[spot] > 1) & independent

    # Both ends of each pair at a crowded spot: body, spot, and node (-1: none).
    ends = {}
    for k in np.flatnonzero(is_crowded).tolist():
        bodies = contacts[contact[k]].body_1, contacts[contact[k]].body_2
        ends[k] = [
            (bodies[0], int(spot[k]), int(nodes[k])),
            (bodies[1], int(spot[k]), int(partners[k])),
        ]
    node_at = {
        (body, place): node for pair in ends.values() for body, place, node in pair if node >= 0
    }
    # A pair that closes a circle connects ends that are connected already. An end is a node, or a
    # place of a body that has no node there.
    connected = DisjointSet()
    for k, pair in ends.items():
        end_1, end_2 = (
            node if node >= 0 else node_at.get((body, place), (body, place))
            for body, place, node in pair
        )
        connected.add(end_1)
        connected.add(end_2)
        independent[k] = connected.merge(end_1, end_2)
    return np.asarray(independent)
