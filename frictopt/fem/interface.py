"""Pairs of nodes that can move relative to each other, their directions, their sides, and their order and widths along contacts in the plane."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_matrix, diags, identity

from ..contact.checks import Array, place
from ..contact.course import runs
from ..contact.tolerances import CONDENSATION, SAME_POINT
from ..errors import ModelError
from .ordering import Integers

_ASIDE = 1e3 * CONDENSATION  # share of its distance by which the neighbourhood of a node may lie on the wrong side: rounding of the coordinates
_LIES = 0.5  # least share of a normal in a plane of symmetry: it may lean by half the angle of an edge beside it
_ALONG = 0.9  # share of x in a normal from which on the first tangent is taken from y


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


def frames_of(normals: Array) -> Array:
    """(N, d, d) tangents and unit normals, from (N, d) normals of any length.

    In the plane the tangent is the normal turned by -90 degrees. In space the first tangent is x less its part along the normal (y where the normal
    is nearly x), and the second one is normal times first tangent: normal z has the tangents x and y.
    """
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.min() > 0:
        raise ModelError(f"normals: zero at pair {int(lengths.argmin())}; give the direction from body 2 into body 1")
    n = normals / lengths[:, None]
    if n.shape[1] == 2:
        return np.stack([np.column_stack([n[:, 1], -n[:, 0]]), n], axis=1)
    axis = np.where(np.abs(n[:, :1]) < _ALONG, np.eye(3)[0], np.eye(3)[1])
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)


def guided(opening: csr_matrix, unknowns: Integers, normals: Array) -> tuple[Array, Integers]:
    """(N, d) normals of the pairs `sum_j M_ij u_j`, and the nodes that supports keep from following others.

    On a plane of symmetry, and on the axis of axisymmetric bodies, supports hold all nodes of a pair alike: it cannot slip across the plane. Its
    normal, of facets on one side alone, lies in the plane, and its nodes may follow others as they do elsewhere.
    """
    held, sizes = unknowns < 0, np.diff(opening.indptr)[:, None]
    counts = (opening != 0) @ held.astype(np.intp)
    within = np.where(counts > 0, 0.0, normals)
    lies = np.linalg.norm(within, axis=1) > _LIES * np.linalg.norm(normals, axis=1)
    alike = ((counts == 0) | (counts == sizes)).all(axis=1) & lies
    others = np.isin(np.arange(len(unknowns)), opening[~alike].indices)
    return np.where(alike[:, None], within, normals), np.flatnonzero(held.any(axis=1) & others)


def check_course(points: Array, frames: Array, names: Sequence[str]) -> None:
    """Check that the pairs of each contact follow each other along their tangents, and that normals of neighbours do not flip.

    Raises
    ------
    ModelError
        They do not.
    """
    for run in runs(names):
        t, n, p = frames[run, 0], frames[run, 1], points[run]
        step = np.diff(p, axis=0)
        flips = np.sum(n[1:] * n[:-1], axis=1) <= 0
        if flips.any():
            i = run.start + int(flips.argmax())
            raise ModelError(
                f"normals: they turn by 90 degrees or more from pair {i} at {place(points[i])} to pair {i + 1} at {place(points[i + 1])}; "
                "let all point from body 2 into body 1, and make a contact of its own of each side of a sharp corner"
            )
        back = np.minimum(np.sum(t[1:] * step, axis=1), np.sum(t[:-1] * step, axis=1)) <= 0
        if back.any():
            i = run.start + int(back.argmax())
            hint = "reverse the pairs (or the normals, and exchange the bodies)" if back.all() else "order the pairs along the contact"
            raise ModelError(
                f"pairs: from pair {i} at {place(points[i])} to pair {i + 1} at {place(points[i + 1])} they go against the tangent, "
                f"which is the normal turned by -90 degrees; {hint}"
            )


def check_sides(graph: csr_matrix, interface: Interface, points: Array, names: Sequence[str]) -> None:
    """Check that the normals point into body 1: the nodes next to the contact lie ahead in body 1, behind in body 2.

    At a re-entrant corner one of the two bodies may seem to lie on the wrong side, but not both.

    Raises
    ------
    ModelError
        They point the other way.
    """
    pattern = (graph > 0).astype(np.float64)
    neighbours = np.asarray(pattern.sum(axis=1))
    inward = np.where(neighbours > 0, (pattern @ points) / np.maximum(neighbours, 1) - points, 0.0)
    normals = interface.frames[:, -1]
    one = np.sum(normals * inward[interface.nodes], axis=1)
    ahead = np.sum(normals * (interface.opening @ inward), axis=1)
    for run in runs(names):
        if ahead[run].sum() < 0:
            i = run.start
            raise ModelError(
                f"normals: those of contact {names[i]!r} point from body 1 into body 2, the first at {place(points[interface.nodes[i]])}; turn them "
                "round, or exchange the columns of the pairs, and in the plane reverse the order of the pairs"
            )
    near = _ASIDE * np.linalg.norm(interface.opening @ inward, axis=1)
    around = pattern[interface.nodes].tocoo()
    heights = np.abs(np.sum(normals[around.row] * (points[around.col] - points[interface.nodes[around.row]]), axis=1))
    seen = np.bincount(around.row, heights, minlength=len(near)) > near  # springs along the face alone tell nothing
    wrong = seen & (ahead <= near) & (np.maximum(one, ahead - one) <= near) & (near > 0)
    if wrong.any():
        i = int(wrong.argmax())
        raise ModelError(
            f"normals: that of pair {i} at {place(points[interface.nodes[i]])} does not point from body 2 into body 1, as their elements lie there; "
            "turn it, or exchange the two nodes of the pair"
        )


def half_widths(points: Array, names: Sequence[str]) -> Array | None:
    """(N,) half the distances to the neighbours on the same contact; None if a contact has a single pair."""
    width = np.zeros(len(points))
    for run in runs(names):
        half = np.hypot(*np.diff(points[run], axis=0).T) / 2
        width[run] += np.r_[half, 0.0] + np.r_[0.0, half]
    return width if width.min() > 0 else None
