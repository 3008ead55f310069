"""Midside nodes on contact faces: they follow the corners of the face, so that the contact has corner nodes alone and forces of linear faces."""

import numpy as np
from scipy.sparse import csr_matrix, diags
from skfem import Mesh

from ..contact.checks import Array, place
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from .elements import corner_weights, on_facets, places_of
from .ordering import Integers

_OFF = 0.1  # the most that a node may lie off the middle of its corners, over their distance: some 45 degrees of arc


def midside_ties(mesh: Mesh, facets: Integers, argument: str) -> csr_matrix:
    """(nodes d, nodes d) matrix of the midside nodes on some facets by their corners, displacements node by node; all other rows are empty.

    A node follows the mean of its corners, two of an edge or four of a facet. Where it is off their middle by `a`, on a curved face, it also turns
    with the corners x_c of the facet, by the rotation that fits their displacements best:

        u_m = sum_c weight_c u_c + rotation x a,    J rotation = sum_c r_c x u_c,    J = sum_c |r_c|^2 1 - r_c r_c^T,    r_c = x_c - their mean

    So rigid motions remain what they are, and forces and moments are handed over as such. A node on several facets follows their mean.

    Raises
    ------
    ModelError
        A node too far off the middle of its corners; the message calls the face `argument`.
    """
    means, (elements, number), d = corner_weights(type(mesh)), places_of(mesh, facets), mesh.dim()
    corners = means.shape[1]
    local, which = np.nonzero(on_facets(type(mesh))[number].T[corners:])
    local, elements, facet = local + corners, elements[which], np.array(mesh.elem.refdom.facets)[number[which]]
    node, ends = mesh.dofs.element_dofs[local, elements], mesh.t[facet.T, elements].T
    shares = means[local[:, None], facet]
    points = np.pad(mesh.p[:, ends].transpose(1, 2, 0), ((0, 0), (0, 0), (0, 3 - d)))
    middle = np.einsum("nc,ncd->nd", shares, points)
    off = np.pad(mesh.p[:, node].T, ((0, 0), (0, 3 - d))) - middle
    size = 2 * np.where(shares > 0, np.linalg.norm(points - middle[:, None], axis=2), 0.0).max(axis=1, initial=0.0)
    distance = np.linalg.norm(off, axis=1)
    if (distance > _OFF * size).any():
        i = int((distance / size).argmax())
        raise ModelError(
            f"{argument}: the midside node at {place(mesh.p[:, node[i]])} lies {distance[i]:.3g} off the middle of its corners, which are "
            f"{size[i]:.3g} apart; contact faces are linear between corners, and {_OFF:g} of that distance is the most: mesh the face finer, or "
            "straighten it"
        )
    off[distance <= SAME_POINT * size] = 0.0
    arms = _crossing(points - points.mean(axis=1)[:, None])
    turn = _crossing(off)[:, None] @ np.linalg.pinv(np.einsum("ncki,nckj->nij", arms, arms), hermitian=True)[:, None] @ arms
    blocks = (shares[:, :, None, None] * np.eye(3) - turn)[:, :, :d, :d]
    row, column = d * node[:, None, None, None] + np.arange(d)[:, None], d * ends[:, :, None, None] + np.arange(d)
    total = csr_matrix((blocks.ravel(), [np.broadcast_to(index, blocks.shape).ravel() for index in (row, column)]), shape=(mesh.p.size,) * 2)
    ties = csr_matrix(diags(1 / np.maximum(np.repeat(np.bincount(node, minlength=mesh.p.shape[1]), d), 1)) @ total)
    ties.eliminate_zeros()
    return ties


def _crossing(vectors: Array) -> Array:
    """(..., 3, 3) matrices of the vector products with vectors (..., 3)."""
    return np.asarray(np.cross(np.eye(3), vectors[..., None, :]))
