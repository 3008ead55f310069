"""Nodes that do not match: the dual mortar projection between two faces (Wohlmuth 2000), and the overlaps of their edges in the plane."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags

from ..contact.checks import Array
from ..contact.tolerances import ROUNDING
from .faces import Face
from .ordering import Integers

_GAUSS = (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12))  # points of two on the unit interval, of equal weight


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Points of integration on the overlaps of the facets of two faces.

    Parameters
    ----------
    facet, weights
        (m,) number of the facet of body 1 that each point lies on, and length or area that it stands for.
    own, phi
        (m, k) nodes of that facet, and their hat functions at the point.
    other, chi
        (m, l) nodes of the facet of body 2 that the point faces, and their hat functions there.
    """

    facet: Integers
    weights: Array
    own: Integers
    phi: Array
    other: Integers
    chi: Array


def mortar_projection(overlaps: Overlaps, nodes: Integers, others: int) -> tuple[csr_matrix, Array]:
    """(n, others) matrix `P = D^-1 M` that gives the n nodes of the face the displacements of nodes on the other side, and the diagonal (n,) of D.

    With phi the hat functions of the face, psi the dual ones (over the overlaps of a facet, `int psi_a phi_b` is `int phi_a` for a = b, else zero)
    and chi those of the other side, `D = diag(int phi_a)` and `M_aj = int psi_a chi_j`. Linear displacements along the face are reproduced, and a
    uniform traction is handed over as such.
    """
    m, phi = len(overlaps.weights), overlaps.phi
    gather = csr_matrix((overlaps.weights, (overlaps.facet, np.arange(m))))
    gram = (gather @ (phi[:, :, None] * phi[:, None]).reshape(m, -1)).reshape(-1, phi.shape[1], phi.shape[1])
    duals = (gather @ phi)[:, :, None] * np.linalg.inv(gram)
    psi = np.einsum("mab,mb->ma", duals[overlaps.facet], phi)

    def rows(values: Array, columns: Integers, size: int) -> csr_matrix:
        return csr_matrix((values.ravel(), columns.ravel(), np.arange(0, values.size + 1, values.shape[1])), shape=(m, size))

    place = np.zeros(int(nodes.max()) + 1, dtype=np.intp)
    place[nodes] = np.arange(len(nodes))
    dual = rows(overlaps.weights[:, None] * psi, place[overlaps.own], len(nodes))
    D = np.asarray(dual.sum(axis=0)).ravel()
    P = csr_matrix(diags(1 / D) @ (dual.T @ rows(overlaps.chi, overlaps.other, others)))
    P.data[np.abs(P.data) < ROUNDING / 10] = 0.0  # neighbours in faces that match
    P.eliminate_zeros()
    return P, D


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


def edge_overlaps(face: Face, other: Integers, s: Array, around: Array) -> Overlaps:
    """The overlaps of the edges of a face in the plane, which is an area where it goes around an axis.

    Parameters
    ----------
    face
        The face of body 1.
    other, s
        Nodes of body 2 and the arc lengths at which they face body 1, increasing, at least from 0 to its length.
    around
        (n,) depth of the face at its nodes, 1 in the plane, the circumference of an axisymmetric body, linear along each edge.
    """
    own = np.r_[0.0, np.cumsum(face.lengths)]
    cuts = np.unique(np.clip(np.r_[own, s], 0.0, own[-1]))
    at, size = np.concatenate([cuts[:-1] + share * np.diff(cuts) for share in _GAUSS]), np.tile(np.diff(cuts), 2)
    (a, phi), (j, chi) = (_hats(knots, at) for knots in (own, s))
    ends = face.edges[a]
    return Overlaps(a, size / 2 * np.sum(phi * around[ends], axis=1), face.nodes[ends], phi, np.column_stack([other[j], other[j + 1]]), chi)


def _hats(knots: Array, at: Array) -> tuple[Integers, Array]:
    """(m,) number of the interval between knots that each point lies in, and the (m, 2) hat functions of its ends."""
    i = np.clip(np.searchsorted(knots, at) - 1, 0, len(knots) - 2)
    share = (at - knots[i]) / (knots[i + 1] - knots[i])
    return i, np.column_stack([1 - share, share])
