"""Bodies glued pair by pair by dense algebra with multipliers, as a reference for condensation."""

import numpy as np
from scipy.sparse import block_diag, csr_matrix
from skfem import Basis, ElementVector, MeshTri
from skfem.models.elasticity import lame_parameters, linear_elasticity

STEEL, ALLOY = lame_parameters(2.0, 0.3), lame_parameters(0.7, 0.2)


def by_multipliers(K, F, G, held):
    """S and the reactions, from `K u = F + G^T r`, `G u = z`."""
    free = np.setdiff1d(np.arange(len(K)), held)
    K, F, G = K[np.ix_(free, free)], F[free], G[:, free]
    k = len(G)
    whole = np.block([[K, -G.T], [G, np.zeros((k, k))]])
    r = np.linalg.solve(
        whole, np.block([[np.zeros((len(K), k)), F], [np.eye(k), np.zeros((k, F.shape[1]))]])
    )[len(K) :]
    return r[:, :k], r[:, k:]


class Assembled:
    """Dense stiffness of bodies by elements of scikit-fem, body after body.

    The unknowns of their nodes are known by place.
    """

    def __init__(self, bodies):
        self.bases = {
            name: Basis(body.mesh, ElementVector(body.mesh.elem())) for name, body in bodies.items()
        }
        parts = [
            linear_elasticity(*body.material.lame).assemble(self.bases[name])
            for name, body in bodies.items()
        ]
        self.K = block_diag(parts).toarray()
        self.first = dict(
            zip(bodies, np.cumsum([0, *(basis.N for basis in self.bases.values())]), strict=False)
        )

    def rows(self, body, point):
        """Unknowns of the node of a body at a point."""
        basis = self.bases[body]
        return (
            self.first[body]
            + basis.nodal_dofs[
                :, np.linalg.norm(basis.mesh.p - np.array(point)[:, None], axis=0).argmin()
            ]
        )

    def on(self, body, axis, at, *directions):
        """Unknowns of all nodes of a body on a plane, in some directions or all."""
        nodes = np.isclose(self.bases[body].mesh.p[axis], at)
        return (
            self.first[body]
            + self.bases[body].nodal_dofs[:, nodes][list(directions) or slice(None)].ravel()
        )

    def motions(self, frames, partners):
        """(d N, size) relative motions along the frames of N nodes.

        Each node has the (body, place, weight) of all nodes of its pair.
        """
        G = np.zeros((frames.shape[0] * frames.shape[1], len(self.K)))
        for i, terms in enumerate(partners):
            for body, place, weight in terms:
                G[i :: len(frames), self.rows(body, place)] += weight * frames[i]
        return G


def glued_pairs(model, *held, others=None):
    """S of a model whose pairs have the nodes of both bodies, by multipliers.

    Nodes are held on planes: (body, axis, place, directions or all). `others` names the body of
    each pair that is not the first body of the model. The default is the second body.
    """
    whole, system, (one, two, *_) = Assembled(model.bodies), model.condense(), model.bodies
    others = others or [two] * system.nodes
    G = whole.motions(
        system.frames,
        [[(one, x, 1.0), (other, x, -1.0)] for x, other in zip(system.points, others, strict=True)],
    )
    return by_multipliers(
        whole.K,
        np.zeros((len(whole.K), 1)),
        G,
        np.concatenate([whole.on(*plane) for plane in held]),
    )[0]


def problem(rng, upper, lower, kind=MeshTri, turn=None, held=True):
    """Two blocks in the form of another code, with given lines across.

    The rows of K may have any order. The contact is at height 0 before the turn.
    """
    blocks = [
        kind.init_tensor(*lines, heights)
        for lines, heights in ((upper, [0.0, 0.6, 1.0]), (lower, [-1.0, -0.3, 0.0]))
    ]
    bases = [Basis(mesh, ElementVector(mesh.elem())) for mesh in blocks]
    size, first, turn = (
        sum(basis.N for basis in bases),
        bases[0].N,
        np.eye(blocks[0].dim()) if turn is None else turn,
    )
    new = rng.permutation(size)
    old = np.argsort(new)
    K = block_diag(
        [
            linear_elasticity(*lame).assemble(basis)
            for lame, basis in zip((STEEL, ALLOY), bases, strict=True)
        ]
    ).tocsr()
    unknowns = new[np.concatenate([bases[0].nodal_dofs.T, first + bases[1].nodal_dofs.T])]
    points = np.concatenate([mesh.p for mesh in blocks], axis=1).T
    spin = np.zeros(K.shape)
    for rows in unknowns:
        spin[np.ix_(rows, rows)] = turn
    height, above = points[:, -1], np.arange(len(points)) < blocks[0].p.shape[1]
    one, two = (
        nodes[np.lexsort(points[nodes].T)]
        for nodes in (np.flatnonzero((height == 0) & side) for side in (above, ~above))
    )
    return {
        # The material is isotropic, so turned points have the turned matrix.
        "K": csr_matrix(spin @ K[old][:, old].toarray() @ spin.T),
        "loads": {"a": rng.normal(size=size), "b": rng.normal(size=size)},
        "one": one,
        "two": two,
        "normals": turn[:, -1],
        "unknowns": unknowns,
        "points": points @ turn.T,
        "held": unknowns[(height == -1) | ((height == 1) & held)].ravel(),
    }
