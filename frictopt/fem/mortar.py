"""Nodes that do not match: the dual mortar projection between two faces (Wohlmuth 2000)."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags

from ..contact.checks import Array
from ..contact.tolerances import ROUNDING
from .ordering import Integers


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
