"""The interface of glued bodies: pairs of nodes, and the unknowns that let each pair move apart.

A pair consists of a node of a body 1 and a place of a body 2, which is a weighted mean of nodes.
The relative motions of all pairs along the axes are `Z = M u`, with the displacements u of all
nodes. To make these motions unknowns, one node of each pair becomes dependent: its displacement
follows from Z and from the displacements of the independent nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import qr
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix, diags, hstack, identity, kron
from scipy.sparse.linalg import inv

from ..base import ROUNDING, SAME_POINT, Array, Booleans, Integers, first_of
from ..contact.components import frames_of, null_space
from ..errors import ModelError

# Squared sine of the largest angle between two normals that are treated as one normal.
ASKEW = 1e-6

# A rigid motion slides along a face if no node moves along the normal by more than this share of
# the slip. Coordinates of five digits cause such lifts; a wedge causes larger lifts.
SLIDES = 1e-4


@dataclass(frozen=True, eq=False)
class Interface:
    """N pairs, each of a node of body 1 and a place on body 2, with directions of relative motion.

    The relative motion of pair i is `sum_r frames[i, r] z_ri = sum_j M_ij u_j`. It is zero if the
    contact is glued. A node may be in several pairs.

    Attributes
    ----------
    nodes
        (N,) nodes of body 1.
    opening
        (N, all nodes) matrix M; each row adds up to 0.
    frames
        (N, d, d) orthonormal directions, `frames[i, r]` for pair i: tangents first, normal last.
    candidates
        (N, all nodes) the entries of M at the candidates: nodes that can be the dependent node of
        their pair, see `interface_of`.
    numbers
        (all nodes,) numbers of the nodes in error messages.
    """

    nodes: Integers
    opening: csr_matrix
    frames: Array
    candidates: csr_matrix
    numbers: Integers

    @cached_property
    def dependent_nodes(self) -> tuple[Integers, csr_matrix, csr_matrix]:
        """Dependent nodes (N,), one for each pair, and matrices W (N, N) and Q (N, all nodes).

        The dependent nodes move by `W Z + Q u`. Here `Z = M u` are the relative motions along the
        axes. The dependent node of a pair is its node of body 1, unless that node is in several
        pairs or is not a candidate.
        """
        M = self.opening
        pairs_of_node = np.bincount(M.indices, minlength=M.shape[1])
        is_candidate = np.isin(self.nodes, self.candidates.indices)
        undecided = np.flatnonzero((pairs_of_node[self.nodes] != 1) | ~is_candidate)
        dependent = self.nodes.copy()
        if len(undecided):
            dependent[undecided] = self._independent_columns(undecided)

        M_dependent = csc_matrix(M[:, dependent])
        if len(undecided):
            W = csr_matrix(inv(M_dependent))
        else:
            W = csr_matrix(diags(1 / M_dependent.diagonal()))
        Q = csr_matrix(-(W @ M) @ _all_but(dependent, M.shape[1]))
        Q.eliminate_zeros()
        return dependent, W, Q

    def _independent_columns(self, pairs: Integers) -> Integers:
        """A candidate for each of some pairs: the columns of M of these nodes are independent."""
        nodes = np.unique(self.candidates[pairs].indices)
        M = self.candidates[pairs][:, nodes].toarray()
        # A small diagonal entry of R shows a row that depends on the rows before it.
        sizes = np.abs(np.diag(qr(M.T, mode="r")[0])) if len(nodes) else np.zeros(0)
        is_dependent = np.r_[sizes <= SAME_POINT, np.full(len(pairs) - len(sizes), True)]
        if (k := first_of(is_dependent)) is not None:
            pair = int(pairs[k])
            number = self.numbers[self.nodes[pair]]
            raise ModelError(
                f"pairs: the relative motion of pair {pair}, of node {number} of body 1, "
                "follows from other pairs or from supports; leave the pair out if its nodes are "
                "in other pairs, otherwise hold the bodies elsewhere; on a plane of symmetry hold "
                "both bodies across it"
            )
        pivots = qr(M, mode="r", pivoting=True)[1]
        return np.asarray(nodes[pivots[: len(pairs)]])

    @cached_property
    def spread(self) -> csr_matrix:
        """(all nodes, all nodes) displacements of all nodes due to independent nodes."""
        dependent, _, Q = self.dependent_nodes
        size = Q.shape[1]
        return csr_matrix(
            _all_but(dependent, size) + identity(size, format="csr")[:, dependent] @ Q
        )

    @cached_property
    def frames_to_axes(self) -> csr_matrix:
        """(N d, d N) matrix from z, direction by direction, to Z along the axes, pair by pair."""
        n, d, _ = self.frames.shape
        by_pairs = blocks_of(self.frames.swapaxes(1, 2))
        return csr_matrix(by_pairs[:, np.arange(n * d).reshape(n, d).T.ravel()])

    def motion(self, unknowns: Integers, size: int) -> tuple[csr_matrix, Integers]:
        """Matrix T of `u = T y`, and the column of T for each displacement, (nodes, d).

        The unknowns y are the free displacements of independent nodes, followed by the relative
        motions z, direction by direction. The column is -1 if a displacement is held, or if
        relative motions replace the displacement.

        `unknowns` (nodes, d) are the rows of the stiffness, -1 if a displacement is held at zero,
        and `size` is the number of all rows.
        """
        dependent, W, _ = self.dependent_nodes
        free = unknowns >= 0
        free[dependent] = False
        columns = np.where(free, np.cumsum(free).reshape(free.shape) - 1, -1)

        axes = identity(unknowns.shape[1])
        by_independent = kron(self.spread, axes, format="csr")
        drives = identity(len(unknowns), format="csr")[:, dependent] @ W
        by_relative = kron(drives, axes) @ self.frames_to_axes
        by_y = hstack([by_independent[:, np.flatnonzero(free)], by_relative])
        return csr_matrix(_rows(unknowns, size).T @ by_y), columns

    def relative(self, u: csr_matrix, unknowns: Integers) -> Array:
        """(d N, k) relative motions, direction by direction, of displacements u (size, k)."""
        dependent = self.dependent_nodes[0]
        d = unknowns.shape[1]
        # A pair does not move along the axes along which its dependent node is held.
        is_free = diags((unknowns[dependent] >= 0).astype(float).ravel())
        Z = is_free @ kron(self.opening, identity(d)) @ (_rows(unknowns, u.shape[0]) @ u)
        return np.asarray((self.frames_to_axes.T @ Z).toarray())

    def sliding(self, motions: csr_matrix, unknowns: Integers) -> Interface:
        """Correct the normals so that free rigid motions `motions` (size, k) slide exactly.

        Rigid motions that slide along the contact up to rounding of the coordinates then open no
        pair at all. If there are no such motions, the normals stay as they are.
        """
        n, d = self.frames.shape[:2]
        rigid = np.linalg.qr(self.relative(motions, unknowns))[0]  # (d n, k), orthonormal
        rigid = rigid.reshape(d, n, -1)
        lean = lean_to_slide(rigid[:-1], rigid[-1])
        if lean is None:
            return self
        normals = self.frames[:, -1] - np.sum(lean[..., None] * self.frames[:, :-1], axis=1)
        return replace(self, frames=frames_of(normals))


def lean_to_slide(slips: Array, lifts: Array) -> Array | None:
    """The lean (n, t) of the normals with which rigid motions slide without any lift.

    Only motions that nearly slide count. None if no normal has to lean, or if one would lean by
    more than `SLIDES`. At n nodes, k orthonormal rigid motions have the components `slips`
    (t, n, k) along t directions, towards which the normals may lean, and `lifts` (n, k) along the
    normals.
    """
    slides = null_space(lifts, SLIDES)
    slip = slips @ slides
    lift = lifts @ slides

    # The lean times the slip is the lift, in least squares over the motions. If a body turns about
    # the node, there is no slip, and the lean is zero.
    square = np.einsum("ain,bin->iab", slip, slip) + ROUNDING * np.eye(len(slip))
    lean = np.linalg.solve(square, np.einsum("ain,in->ia", slip, lift)[..., None])[..., 0]
    # A smaller lean is rounding. With a larger lean, a few of the many nodes form a real wedge.
    return lean if ROUNDING < np.abs(lean).max() <= SLIDES else None


def _all_but(nodes: Integers, size: int) -> csr_matrix:
    """(size, size) diagonal matrix with 0 at some nodes and 1 at all others."""
    diagonal = np.ones(size)
    diagonal[nodes] = 0.0
    return diags(diagonal)


def _rows(unknowns: Integers, size: int) -> csr_matrix:
    """(nodes d, size) matrix that takes the displacements of the nodes from all unknowns.

    The displacement of node i along axis a is row `unknowns[i, a]`; zero if this row is negative.
    """
    listed = np.flatnonzero(unknowns.ravel() >= 0)
    entries = (np.ones(len(listed)), (listed, unknowns.ravel()[listed]))
    return csr_matrix(entries, shape=(unknowns.size, size))


def blocks_of(blocks: Array) -> csr_matrix:
    """(n d, n d) matrix with blocks (n, d, d) on its diagonal."""
    n = len(blocks)
    return csr_matrix(bsr_matrix((blocks, np.arange(n), np.arange(n + 1))))


def openings(nodes: Integers, projection: csr_matrix) -> csr_matrix:
    """(N, all nodes) matrix of the motions of nodes relative to their places `sum_j P_ij u_j`."""
    opening = csr_matrix(identity(projection.shape[1], format="csr")[nodes] - projection)
    opening.eliminate_zeros()
    return opening


def interface_of(
    nodes: Integers,
    opening: csr_matrix,
    unknowns: Integers,
    normals: Array,
    points: Array,
    errors: Array,
    numbers: Integers,
) -> Interface:
    """The interface of pairs, some of which cannot slip along some axes.

    The normals lose their parts along these axes.

    A pair cannot slip along an axis if supports hold all its nodes along that axis. A pair on a
    plane (or an axis) of symmetry cannot slip across it either, on two conditions. Supports hold
    nodes of the pair there, in both bodies. All other nodes of the pair lie on one side, so that
    the motion of the mirror image cancels the motion of the pair. The normal is then put into the
    plane, because it was computed from facets on one side only.

    A node can be dependent if it is held along exactly the axes along which its pairs cannot slip.
    Then no other node depends on its motion along these axes.

    Parameters
    ----------
    nodes, opening
        (N,) nodes of body 1 of the pairs, and (N, all nodes) matrix M of the relative motions.
    unknowns
        (all nodes, d) unknowns, negative if held.
    normals
        (N, d) normals of the pairs, of any length.
    points, errors, numbers
        (all nodes, d) coordinates and their errors, and (all nodes,) numbers of the nodes in error
        messages.
    """
    links = opening.tocoo()  # one link for each node of a pair: `row` is the pair, `col` the node
    held = (unknowns < 0)[links.col]

    def any_link(flags: Booleans) -> Booleans:
        """(N, d) whether flags (links, d) hold for any node of a pair."""
        count = len(nodes)
        return np.column_stack(
            [np.bincount(links.row, flag, minlength=count) > 0 for flag in flags.T]
        )

    # Distance (links, d) of each node from the planes through the node of body 1, one plane across
    # each axis.
    first = nodes[links.row]
    distance = points[links.col] - points[first]
    error = 2 * (errors[links.col] + errors[first])
    on_plane = held & (np.abs(distance) <= error)
    below = any_link(~on_plane & (distance <= error))
    above = any_link(~on_plane & (distance >= -error))
    of_body_2 = (links.data < 0)[:, None]
    is_symmetric = ~(below & above) & any_link(on_plane & of_body_2)
    across = ~any_link(~held) | is_symmetric

    lengths_in_plane = np.linalg.norm(np.where(across, 0.0, normals), axis=1)
    # Least share of a normal's length that must lie in a plane of symmetry. On a curved face, the
    # normal at a node on the plane comes from facets on one side only, and may lean out of the
    # plane by half the angle that such a facet spans.
    least_share = 0.5
    across &= (lengths_in_plane > least_share * np.linalg.norm(normals, axis=1))[:, None]

    slips = ~across[links.row]
    held_against_slip = links.col[(held & slips).any(axis=1)]
    is_candidate = (held != slips).all(axis=1) & ~np.isin(links.col, held_against_slip)
    entries = (links.data[is_candidate], (links.row[is_candidate], links.col[is_candidate]))
    candidates = csr_matrix(entries, shape=opening.shape)
    return Interface(nodes, opening, frames_of(np.where(across, 0.0, normals)), candidates, numbers)
