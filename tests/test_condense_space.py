"""The inner parts of a condensation in three dimensions: two blocks of hexahedra against the equations with multipliers, by dense algebra."""

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_matrix
from skfem import Basis, ElementHex1, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo
from frictopt.fem.condense import condensed
from frictopt.fem.interface import Interface
from frictopt.fem.rigid import node_graph


def problem(held=slice(None)):
    """A free block on one that is held below, turned in space; rows of K, loads and frames of the 9 pairs."""
    rng = np.random.default_rng(5)
    x = np.linspace(-1, 1, 3)
    bases = [Basis(MeshHex.init_tensor(x, x, z), ElementVector(ElementHex1())) for z in ([0.0, 0.7], [-1.0, 0.0])]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    K = block_diag([linear_elasticity(*lame_parameters(1.0, nu)).assemble(basis) for nu, basis in zip((0.3, 0.2), bases, strict=True)]).tocsr()
    unknowns = np.concatenate([bases[0].nodal_dofs.T, bases[0].N + bases[1].nodal_dofs.T])
    flat = np.concatenate([basis.mesh.p for basis in bases], axis=1).T
    spin = np.zeros(K.shape)
    for rows in unknowns:
        spin[np.ix_(rows, rows)] = turn
    nodes = [np.flatnonzero((flat[:, 2] == 0) & (np.arange(len(flat)) // bases[0].mesh.p.shape[1] == side)) for side in (0, 1)]
    one, two = (face[np.lexsort(flat[face].T)] for face in nodes)
    P = csr_matrix((np.ones(9), (np.arange(9), two)), shape=(9, len(flat)))
    interface = Interface(one, P, np.tile(turn.T, (9, 1, 1)))
    fixed = unknowns[flat[:, 2] == -1.0][held].ravel()
    rows = np.where(np.isin(unknowns, fixed), -1, unknowns)
    return csr_matrix(spin @ K.toarray() @ spin.T), rng.normal(size=(K.shape[0], 2)), interface, rows, flat @ turn.T, fixed


def test_a_free_block_on_a_held_one():
    K, F, interface, unknowns, points, held = problem()
    S, R = condensed(K, F, interface, unknowns, points, node_graph(K, unknowns))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    G = interface.relative(unknowns, K.shape[0]).toarray()[:, free]
    n, k = len(free), 27
    whole = np.block([[K.toarray()[np.ix_(free, free)], -G.T], [G, np.zeros((k, k))]])
    r = np.linalg.solve(whole, np.block([[np.zeros((n, k)), F[free]], [np.eye(k), np.zeros((k, 2))]]))[n:]
    assert np.allclose(S, r[:, :k], atol=1e-12) and np.allclose(R, r[:, k:], atol=1e-11)
    assert (np.linalg.eigvalsh(S) < 1e-12).sum() == 6


@pytest.mark.parametrize(("held", "left"), [(slice(0), 6), (slice(1), 3), (slice(2), 1)])
def test_rigid_motions_in_space(held, left):
    K, F, interface, unknowns, points, _ = problem(held)
    with pytest.raises(fo.ModelError, match=f"supports: {left} rigid motions"):
        condensed(K, F, interface, unknowns, points, node_graph(K, unknowns))
