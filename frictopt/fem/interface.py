"""Pairs of nodes that can move relative to each other, each in its own directions, in any number of dimensions."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, identity

from ..contact.checks import Array
from .ordering import Integers

__all__ = ["Interface", "glued"]


@dataclass(frozen=True, eq=False)
class Interface:
    """N nodes of bodies 1, the places of bodies 2 that they are glued to, and the directions of the relative motion.

    A node i of body 1 moves by `u1_i = sum_j P_ij u2_j + sum_r frames[i, r] z_ri`, with z the relative motion: `z = 0` is the glued contact.

    Parameters
    ----------
    nodes
        (N,) nodes of bodies 1.
    projection
        (N, all nodes) matrix P: the rows add up to 1, and no column is that of a node of bodies 1 on the interface.
    frames
        (N, d, d) orthonormal directions: `frames[i, r]` is direction r at pair i, the tangents first, the normal last.
    """

    nodes: Integers
    projection: csr_matrix
    frames: Array

    @property
    def kept(self) -> int:
        """Number of relative motions, d N."""
        return int(self.frames[..., 0].size)

    def eliminated(self, unknowns: Integers) -> Integers:
        """(nodes, d) columns of `motion` that stand for the displacements, -1 for those that are held or replaced by relative motions."""
        columns = np.full(unknowns.shape, -1)
        free = unknowns >= 0
        free[self.nodes] = False
        columns[free] = np.arange(np.count_nonzero(free))
        return columns

    def motion(self, unknowns: Integers, size: int) -> csr_matrix:
        """Matrix T of `u = T y`; y are the free displacements off bodies 1's side, numbered by `eliminated`, then z, direction by direction.

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
        (pairs, directions, axes), links = self._frames, self.projection.tocoo()
        entries = [
            (unknowns[own], columns[own], np.ones(others)),
            (unknowns[self.nodes[pairs], axes], others + directions * len(self.nodes) + pairs, self.frames.ravel()),
        ]
        for axis in range(unknowns.shape[1]):
            free = columns[links.col, axis] >= 0
            entries.append((unknowns[self.nodes[links.row[free]], axis], columns[links.col[free], axis], links.data[free]))
        row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return csr_matrix((value, (row, column)), shape=(size, others + self.kept))

    def relative(self, unknowns: Integers, size: int) -> csr_matrix:
        """Matrix of `z = B u`, (d N, size)."""
        pairs, directions, axes = self._frames
        to_pairs = csr_matrix((self.frames.ravel(), (directions * len(self.nodes) + pairs, pairs * unknowns.shape[1] + axes)))
        opening = identity(len(unknowns), format="csr")[self.nodes] - self.projection
        links = opening.tocoo()
        entries = []
        for axis in range(unknowns.shape[1]):
            free = unknowns[links.col, axis] >= 0
            entries.append((links.row[free] * unknowns.shape[1] + axis, unknowns[links.col[free], axis], links.data[free]))
        row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        return to_pairs @ csr_matrix((value, (row, column)), shape=(self.kept, size))

    def glued_graph(self, graph: csr_matrix) -> csr_matrix:
        """Adjacency of the nodes when bodies 1 hang on bodies 2, from that of the bodies."""
        keeps = np.ones(graph.shape[0])
        keeps[self.nodes] = 0.0
        links = self.projection.tocoo()
        own = np.flatnonzero(keeps)
        rows, columns = np.r_[own, self.nodes[links.row]], np.r_[own, links.col]
        image = csr_matrix((np.ones(len(rows)), (rows, columns)), shape=graph.shape)
        return image.T @ graph @ image

    @property
    def _frames(self) -> tuple[Integers, Integers, Integers]:
        """Pair, direction and axis of each entry of the frames."""
        pairs, directions, axes = (index.ravel() for index in np.indices(self.frames.shape))
        return pairs, directions, axes


def glued(K: csr_matrix, T: csr_matrix) -> csr_matrix:
    """Stiffness `T^T K T` in the unknowns y of `u = T y`."""
    return csr_matrix(T.T @ K @ T)
