"""Nodes that do not match: the dual mortar projection between two faces in the plane (Wohlmuth 2000)."""

import numpy as np
from scipy.sparse import csr_matrix

from ..contact.checks import Array
from .faces import Face
from .ordering import Integers

__all__ = ["foot_points", "mortar_projection"]

_GAUSS = (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12))  # points of two on the unit interval, of equal weight


def foot_points(face: Face, points: Array) -> tuple[Array, Array]:
    """Arc length of the point of the face that is closest to each of some points, and their signed distance, positive inside the body.

    The first and last edges of an open face go on for ever: arc lengths below 0 or above the length lie beyond its ends.
    """
    starts, steps, lengths = face.points[face.chain[:-1]], face.steps, face.lengths
    arc = np.cumsum(lengths) - lengths
    along = steps / lengths[:, None]
    best, s, height = np.full(len(points), np.inf), np.zeros(len(points)), np.zeros(len(points))
    for i in range(len(steps)):  # one edge at a time: faces have hundreds of nodes
        arm = points - starts[i]
        t = arm @ along[i]
        low = -np.inf if i == 0 and not face.closed else 0.0
        high = np.inf if i == len(steps) - 1 and not face.closed else lengths[i]
        t = np.clip(t, low, high)
        miss = arm - t[:, None] * along[i]
        distance = np.hypot(*miss.T)
        nearer = distance < best
        best[nearer], s[nearer] = distance[nearer], arc[i] + t[nearer]
        height[nearer] = np.copysign(distance, along[i, 0] * miss[:, 1] - along[i, 1] * miss[:, 0])[nearer]
    return s, height


def mortar_projection(face: Face, other: Integers, s: Array, nodes: int, around: Array, widths: Array) -> csr_matrix:
    """(n, nodes) matrix `P = D^-1 M` that gives the n nodes of the face the displacements of nodes on the other side.

    With phi the hat functions of the face, psi the dual ones (over an edge, `int psi_a phi_b` is `int phi_a` for a = b, else zero) and chi those of
    the other side, `D = diag(int phi_a)` and `M_aj = int psi_a chi_j` over the face, which is an area where it goes around an axis. Linear
    displacements along it are reproduced, and a uniform traction is handed over as such.

    Parameters
    ----------
    face
        The face of body 1.
    other, s
        Nodes of body 2 and the arc lengths at which they face body 1, increasing, at least from 0 to its length.
    nodes
        Number of columns of P.
    around, widths
        (n,) depth of the face at its nodes, 1 in the plane, the circumference of an axisymmetric body, linear along each edge; and `int phi_a`.
    """
    chain = face.chain
    own = np.r_[0.0, np.cumsum(face.lengths)]
    cuts = np.unique(np.clip(np.r_[own, s], 0.0, own[-1]))
    size = np.diff(cuts)
    entries = []
    for share in _GAUSS:
        at = cuts[:-1] + share * size
        a, j = (np.clip(np.searchsorted(knots, at) - 1, 0, len(knots) - 2) for knots in (own, s))
        phi, chi = (at - own[a]) / (own[a + 1] - own[a]), (at - s[j]) / (s[j + 1] - s[j])
        first, last = around[chain[a]], around[chain[a + 1]]
        depth, mixed = size / 2 * (first * (1 - phi) + last * phi), first + last
        own_first, own_last = 3 * first + last, first + 3 * last  # with `mixed`, 12 times the mass matrix of phi on an edge of length 1
        scale = 2 / (own_first * own_last - mixed**2)
        psi_first = (2 * first + last) * scale * (own_last * (1 - phi) - mixed * phi)
        psi_last = (first + 2 * last) * scale * (own_first * phi - mixed * (1 - phi))
        for node, psi in ((chain[a], psi_first), (chain[a + 1], psi_last)):
            entries += [(node, other[j], depth * psi * (1 - chi)), (node, other[j + 1], depth * psi * chi)]
    row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    return csr_matrix((value / widths[row], (row, column)), shape=(len(face.nodes), nodes))
