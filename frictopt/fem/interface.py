"""Pairs of nodes that can move relative to each other, each in its own directions, in any number of dimensions."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_matrix, diags, identity

from ..contact.checks import Array
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from .ordering import Integers


@dataclass(frozen=True, eq=False)
class Interface:
    """N pairs of a node of a body 1 and a place of a body 2, and the directions of their relative motion.

    The relative motion of pair i, `sum_r frames[i, r] z_ri = sum_j M_ij u_j`, is zero where the contact is glued. A node may belong to several pairs.

    Parameters
    ----------
    nodes
        (N,) nodes of bodies 1.
    opening
        (N, all nodes) matrix M; its rows add up to 0.
    frames
        (N, d, d) orthonormal directions: `frames[i, r]` is direction r at pair i, the tangents first, the normal last.
    held
        Nodes that supports keep from following others.
    """

    nodes: Integers
    opening: csr_matrix
    frames: Array
    held: Integers

    @property
    def kept(self) -> int:
        """Number of relative motions, d N."""
        return int(self.frames[..., 0].size)

    @cached_property
    def followers(self) -> tuple[Integers, csr_matrix, csr_matrix]:
        """(N,) nodes that follow all others, W (N, N) and Q (N, all nodes): they move by `W Z + Q u`, with the relative motions `Z = M u` in space.

        That of a pair is its node of body 1; where it belongs to more pairs, or is held, others that can follow do.

        Raises
        ------
        ModelError
            The relative motion of a pair follows from those of others, or from supports.
        """
        M = self.opening
        uses = np.bincount(M.indices, minlength=M.shape[1])
        shared = np.flatnonzero((uses[self.nodes] != 1) | np.isin(self.nodes, self.held))
        following = self.nodes.copy()
        following[shared] = self._independent(shared)
        alone = np.ones(len(following))
        alone[shared] = 0.0
        own = np.asarray(M[np.arange(len(following)), following]).ravel()
        inverse = diags(alone / np.where(alone > 0, own, 1.0))
        if len(shared):
            pick = identity(len(following), format="csr")[:, shared]
            turned = pick @ csr_matrix(np.linalg.inv(M[shared][:, following[shared]].toarray()))
            inverse = inverse + (turned - inverse @ (M[:, following[shared]] @ turned[shared])) @ pick.T
        W = csr_matrix(inverse)
        others = np.ones(M.shape[1])
        others[following] = 0.0
        Q = csr_matrix(-(W @ M) @ diags(others))
        Q.eliminate_zeros()
        return following, W, Q

    def _independent(self, rows: Integers) -> Integers:
        """Nodes that are not held and can follow in some pairs, one for each pair."""
        if not len(rows):
            return rows
        columns = np.setdiff1d(self.opening[rows].indices, self.held)
        part = self.opening[rows][:, columns].toarray()
        sizes = np.abs(np.diag(qr(part.T, mode="r")[0])) if len(columns) else np.zeros(0)
        stuck = np.r_[sizes <= SAME_POINT, np.full(len(rows) - len(sizes), True)]
        if stuck.any():
            i = int(rows[stuck.argmax()])
            raise ModelError(
                f"pairs: the relative motion of pair {i}, of node {self.nodes[i]} of body 1, follows from those of other pairs or from supports; "
                "leave it out if its nodes are in other pairs, else hold the bodies elsewhere; on a plane of symmetry, or on the axis of "
                "axisymmetric bodies, let the nodes of both match"
            )
        return np.asarray(columns[qr(part, mode="r", pivoting=True)[1][: len(rows)]])

    def eliminated(self, unknowns: Integers) -> Integers:
        """(nodes, d) columns of `motion` that stand for the displacements, -1 for those that are held or replaced by relative motions."""
        columns = np.full(unknowns.shape, -1)
        free = unknowns >= 0
        free[self.followers[0]] = False
        columns[free] = np.arange(np.count_nonzero(free))
        return columns

    def motion(self, unknowns: Integers, size: int) -> csr_matrix:
        """Matrix T of `u = T y`; y are the free displacements of nodes that do not follow, numbered by `eliminated`, then z, direction by direction.

        Parameters
        ----------
        unknowns
            (nodes, d) rows of the stiffness, -1 where a displacement is held at zero.
        size
            Number of rows of the stiffness.
        """
        columns = self.eliminated(unknowns)
        others = int(columns.max(initial=-1)) + 1
        own = columns >= 0
        following, W, Q = self.followers
        entries = [(unknowns[own], columns[own], np.ones(others))]
        links, drives = Q.tocoo(), W.tocoo()
        for axis in range(unknowns.shape[1]):
            free = columns[links.col, axis] >= 0
            entries.append((unknowns[following[links.row[free]], axis], columns[links.col[free], axis], links.data[free]))
            for direction in range(unknowns.shape[1]):
                moves = others + direction * len(following) + drives.col
                entries.append((unknowns[following[drives.row], axis], moves, drives.data * self.frames[drives.col, direction, axis]))
        row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        moves = row >= 0
        return csr_matrix((value[moves], (row[moves], column[moves])), shape=(size, others + self.kept))

    def relative(self, u: csr_matrix, unknowns: Integers) -> Array:
        """(d N, k) relative motions, direction by direction, of displacements u (size, k)."""
        used = np.unique(self.opening.indices)
        rows = unknowns[used]
        moved = np.where(rows[..., None] >= 0, u[rows.ravel()].toarray().reshape(*rows.shape, -1), 0.0)
        apart = (self.opening[:, used] @ moved.reshape(len(used), -1)).reshape(len(self.nodes), *moved.shape[1:])
        return np.asarray(np.einsum("nra,nak->rnk", self.frames, apart).reshape(self.kept, -1))

    def glued_graph(self, graph: csr_matrix) -> csr_matrix:
        """Adjacency of the nodes when some follow others, from that of the bodies."""
        following, _, Q = self.followers
        keeps = np.ones(graph.shape[0])
        keeps[following] = 0.0
        links = Q.tocoo()
        own = np.flatnonzero(keeps)
        rows, columns = np.r_[own, following[links.row]], np.r_[own, links.col]
        image = csr_matrix((np.ones(len(rows)), (rows, columns)), shape=graph.shape)
        return image.T @ graph @ image


def openings(nodes: Integers, projection: csr_matrix) -> csr_matrix:
    """(N, all nodes) matrix of the relative motions of some nodes and the places `sum_j P_ij u_j`."""
    opening = csr_matrix(identity(projection.shape[1], format="csr")[nodes] - projection)
    opening.eliminate_zeros()
    return opening
