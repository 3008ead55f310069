"""Pairs of nodes that can move relative to each other, their directions, their sides, and their order and widths along contacts in the plane."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csc_matrix, csr_matrix, diags, hstack, identity, kron
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import inv

from ..base import CONDENSATION, ROUNDING, SAME_POINT, Array, Booleans, Integers, first_of, place
from ..contact import runs
from ..contact.frames import frames_of
from ..errors import ModelError

_ASIDE = (
    1e3 * CONDENSATION
    # share of its distance by which a node may be aside, and of its stiffness by which it may be
    # pulled: rounding
)
_ONE, _ALL = (
    8,
    0.75,
    # nodes of one element, which are all joined; share of all nodes that are joined in models that are
    # reduced
)
# least share of a normal in a plane of symmetry: it may lean by half the angle of an edge beside it
_LIES = 0.5
# a rigid motion that opens no pair by more of its slip slides along them: so do coordinates of five
# digits, and no wedge
_NEARLY = 1e-4
_APART = 1e-4  # sine of the angle between two normals from which on a node is held along both
ASKEW = 1e-6  # squared sine of the angle up to which two nodes are held along one normal


@dataclass(frozen=True, eq=False)
class Interface:
    """N pairs of a node of a body 1 and a place of a body 2, and the directions of their relative motion.

    The relative motion of pair i, `sum_r frames[i, r] z_ri = sum_j M_ij u_j`, is zero where the
    contact is glued. A node may belong to several pairs.
    """

    nodes: Integers  # (N,) of bodies 1
    opening: csr_matrix  # (N, all nodes) matrix M; its rows add up to 0
    # (N, d, d) orthonormal directions: `frames[i, r]` is direction r at pair i, the tangents first,
    # the normal last
    frames: Array
    # (N, all nodes) entries of M at the nodes that may follow the others of their pair, see
    # `guided`
    able: csr_matrix
    directions: Array | None = (
        # (all nodes, d, d) orthonormal directions of the unknowns of each node, its rows; None: the
        # axes
        None
    )

    @cached_property
    def followers(self) -> tuple[Integers, csr_matrix, csr_matrix]:
        """(N,) nodes that follow all others, W (N, N) and Q (N, all nodes): they move by `W Z + Q u`, with the relative motions `Z = M u` in space.

        That of a pair is its node of body 1; where it belongs to more pairs, or may not follow,
        others do.
        """
        M = self.opening
        uses = np.bincount(M.indices, minlength=M.shape[1])
        shared = np.flatnonzero((uses[self.nodes] != 1) | ~np.isin(self.nodes, self.able.indices))
        following = self.nodes.copy()
        if len(shared):
            following[shared] = self._independent(shared)
        own = csc_matrix(M[:, following])
        W = csr_matrix(inv(own) if len(shared) else diags(1 / own.diagonal()))
        others = np.ones(M.shape[1])
        others[following] = 0.0
        Q = csr_matrix(-(W @ M) @ diags(others))
        Q.eliminate_zeros()
        return following, W, Q

    def _independent(self, rows: Integers) -> Integers:
        """Nodes that can follow in some pairs, one for each pair."""
        columns = np.unique(self.able[rows].indices)
        part = self.able[rows][:, columns].toarray()
        sizes = np.abs(np.diag(qr(part.T, mode="r")[0])) if len(columns) else np.zeros(0)
        stuck = np.r_[sizes <= SAME_POINT, np.full(len(rows) - len(sizes), True)]
        if (k := first_of(stuck)) is not None:
            i = int(rows[k])
            raise ModelError(
                f"pairs: the relative motion of pair {i}, of node {self.nodes[i]} of body 1, follows from those of other pairs or from supports; "
                "leave it out if its nodes are in other pairs, else hold the bodies elsewhere; on a plane of symmetry hold both across it"
            )
        return np.asarray(columns[qr(part, mode="r", pivoting=True)[1][: len(rows)]])

    @cached_property
    def spread(self) -> csr_matrix:
        """(all nodes, all nodes) matrix of the displacements of all nodes by those of nodes that do not follow."""
        following, _, Q = self.followers
        others = np.ones(Q.shape[1])
        others[following] = 0.0
        return csr_matrix(diags(others) + identity(len(others), format="csr")[:, following] @ Q)

    @cached_property
    def _by_directions(self) -> csr_matrix:
        """(nodes d, nodes d) matrix of the displacements of all nodes along the axes by those in their directions."""
        n, d = self.opening.shape[1], self.frames.shape[1]
        return (
            identity(n * d, format="csr")
            if self.directions is None
            else blocks_of(self.directions.swapaxes(1, 2))
        )

    @cached_property
    def _turned(self) -> csr_matrix:
        """(N d, d N) matrix of the relative motions in space, pair by pair, by those in the directions, direction by direction."""
        n, d, _ = self.frames.shape
        columns = np.arange(n)[:, None, None] + n * np.arange(
            d
        )  # in the order of pair, axis, direction
        return csr_matrix(
            (
                self.frames.swapaxes(1, 2).ravel(),
                np.broadcast_to(columns, (n, d, d)).ravel(),
                d * np.arange(n * d + 1),
            )
        )

    def motion(self, unknowns: Integers, size: int) -> tuple[csr_matrix, Integers]:
        """Matrix T of `u = T y`; y are the free displacements of nodes that do not follow, then z, direction by direction.

        And which of the y each displacement is, (nodes, d), -1 for those that are held or replaced
        by relative motions.

        The (nodes, d) rows of the stiffness are -1 where a displacement is held at zero, and `size`
        is the number of all rows.
        """
        (following, W, _), each, free = self.followers, identity(unknowns.shape[1]), unknowns >= 0
        free[following] = False
        columns = np.where(free, np.cumsum(free).reshape(free.shape) - 1, -1)
        drives = identity(len(unknowns), format="csr")[:, following] @ W
        own = csr_matrix(kron(self.spread, each, format="csr") @ self._by_directions)[
            :, np.flatnonzero(free)
        ]
        T = csr_matrix(
            _rows(unknowns, size).T
            @ self._by_directions.T
            @ hstack([own, kron(drives, each) @ self._turned])
        )
        if (
            self.directions is not None
        ):  # across an oblique plane nothing moves, and rounding is no motion
            T.data[np.abs(T.data) <= ROUNDING] = 0.0
            T.eliminate_zeros()
        return T, columns

    def relative(self, u: csr_matrix, unknowns: Integers) -> Array:
        """(d N, k) relative motions, direction by direction, of displacements u (size, k)."""
        following, d = self.followers[0], unknowns.shape[1]
        moves = diags(
            (unknowns[following] >= 0).astype(float).ravel()
        )  # no pair moves across a plane of symmetry
        own = (
            identity(len(following) * d)
            if self.directions is None
            else blocks_of(self.directions[following])
        )
        apart = (
            own.T
            @ moves
            @ own
            @ kron(self.opening, identity(d))
            @ (self._by_directions @ (_rows(unknowns, u.shape[0]) @ u))
        )
        return np.asarray((self._turned.T @ apart).toarray())

    def sliding(self, motions: csr_matrix, unknowns: Integers) -> "Interface":
        """The same, with normals that rigid motions (size, k) slide along exactly where they do so up to the last digits of coordinates."""
        n, d = self.frames.shape[:2]
        rigid = np.linalg.qr(self.relative(motions, unknowns))[0]
        _, opens, turn = np.linalg.svd(np.linalg.qr(rigid[-n:], mode="r"))
        slides = (rigid @ turn[np.pad(opens, (0, len(turn) - len(opens))) <= _NEARLY].T).reshape(
            d, n, -1
        )
        along, lift = slides[:-1], slides[-1]
        square = np.einsum("ain,bin->iab", along, along) + ROUNDING * np.eye(
            d - 1
        )  # where a body turns about the node, no normal changes
        lean = np.linalg.solve(square, np.einsum("ain,in->ia", along, lift)[..., None])
        if (
            not ROUNDING < np.abs(lean).max() <= _NEARLY
        ):  # they slide, and zeros stay exact; or a few nodes of many wedge them
            return self
        normals = self.frames[:, -1] - np.sum(lean * self.frames[:, :-1], axis=1)
        return replace(
            self, frames=frames_of(normals, None if self.directions is None else self.frames[:, 0])
        )


def _rows(unknowns: Integers, size: int) -> csr_matrix:
    """(nodes d, size) matrix of the displacements of all nodes, node by node, by the rows of a stiffness; nothing where it has none."""
    listed = np.flatnonzero(unknowns.ravel() >= 0)
    return csr_matrix(
        (np.ones(len(listed)), (listed, unknowns.ravel()[listed])), shape=(unknowns.size, size)
    )


def own_directions(held: Iterable[Array]) -> tuple[Array, int]:
    """(d, d) orthonormal directions of a node, those first that span the directions in which it is held, and the number of these."""
    spanned: list[Array] = []
    for one in held:
        rest = one - sum((found * (found @ one) for found in spanned), np.zeros(len(one)))
        if (size := float(np.linalg.norm(rest))) > _APART:
            spanned.append(rest / size)
    return np.asarray(np.linalg.qr(np.transpose(spanned), mode="complete")[0].T), len(spanned)


def blocks_of(blocks: Array) -> csr_matrix:
    """(n d, n d) matrix with blocks (n, d, d) on its diagonal."""
    n, d, _ = blocks.shape
    columns = np.broadcast_to(d * np.arange(n)[:, None, None] + np.arange(d), blocks.shape)
    return csr_matrix(
        (blocks.ravel(), columns.ravel(), d * np.arange(n * d + 1)), shape=(n * d,) * 2
    )


def openings(nodes: Integers, projection: csr_matrix) -> csr_matrix:
    """(N, all nodes) matrix of the relative motions of some nodes and the places `sum_j P_ij u_j`."""
    opening = csr_matrix(identity(projection.shape[1], format="csr")[nodes] - projection)
    opening.eliminate_zeros()
    return opening


def guided(
    nodes: Integers,
    opening: csr_matrix,
    unknowns: Integers,
    normals: Array,
    points: Array,
    errors: Array,
    directions: Array | None = None,
) -> tuple[Array, Array, csr_matrix]:
    """(N, d) normals of the pairs `sum_j M_ij u_j` of nodes of bodies 1; ways; and the entries of M at nodes that may follow others of their pair.

    A pair cannot slip along an axis in which supports hold all its nodes, or hold those of both
    bodies on a plane of symmetry, or on the axis of axisymmetric bodies, where the others lie on
    one side: what these would add is taken away by their mirror images. Its normal, of facets on
    one side alone, lies in the plane. A node may follow that is held where its pair cannot slip,
    and nowhere else in any of its pairs: then no other node depends on what it does along the axes
    in which it is held. Axes are those of the pair, where a node of it has directions of its own.
    Its way (N, d) is then the one along which it cannot slip, else zero.
    """
    links = opening.tocoo()
    own, fixed = _held(links, unknowns < 0, directions, points[nodes])
    aside = np.einsum("lka,la->lk", own[links.row], points[links.col] - points[nodes[links.row]])
    near = np.einsum(
        "lka,la->lk", np.abs(own[links.row]), errors[links.col] + errors[nodes[links.row]]
    )
    normals = np.einsum("nka,na->nk", own, normals)
    on = fixed & (np.abs(aside) <= near)

    def some(found: Booleans) -> Booleans:
        return np.column_stack(
            [np.bincount(links.row, column, minlength=len(nodes)) > 0 for column in found.T]
        )

    astride = some(~on & (aside <= near)) & some(~on & (aside >= -near))
    across = ~some(~fixed) | (~astride & some(on & (links.data < 0)[:, None]))
    within = np.where(across, 0.0, normals)
    across &= (np.linalg.norm(within, axis=1) > _LIES * np.linalg.norm(normals, axis=1))[:, None]
    slips = ~across[links.row]
    follows = (fixed != slips).all(axis=1) & ~np.isin(
        links.col, links.col[(fixed & slips).any(axis=1)]
    )
    within, ways = (
        np.einsum("nk,nka->na", np.where(across, 0.0, normals), own),
        np.einsum("nk,nka->na", across * 1.0, own),
    )
    ways[(across.sum(axis=1) != 1) | np.all(own == np.eye(own.shape[1]), axis=(1, 2))] = 0.0
    return (
        within,
        ways,
        csr_matrix(
            (links.data[follows], (links.row[follows], links.col[follows])), shape=opening.shape
        ),
    )


def _held(
    links: Any, held: Booleans, directions: Array | None, places: Array
) -> tuple[Array, Booleans]:
    """(N, d, d) directions of the pairs, and (links, d) in which of them the nodes of a pair are held."""
    n, d = places.shape
    own = np.tile(np.eye(d), (n, 1, 1))
    if directions is None:
        return own, held[links.col]
    oblique = (directions != np.eye(d)).any(axis=(1, 2))[links.col]
    for i in np.unique(links.row[oblique]).tolist():
        nodes = links.col[links.row == i]
        own[i] = own_directions(directions[nodes][held[nodes]])[0]
    share = np.einsum(
        "lm,lmk->lk",
        held[links.col],
        np.einsum("lma,lka->lmk", directions[links.col], own[links.row]) ** 2,
    )
    if (k := first_of((np.abs(share - 0.5) < 0.5 - ASKEW).any(axis=1))) is not None:
        raise ModelError(
            f"supports: the nodes of the contact at {place(places[links.row[k]])} are held along different normals; give the faces of both bodies "
            "that lie in one plane, or on one cylinder, supports of the same kind"
        )
    return own, share > 0.5


def check_course(points: Array, frames: Array, names: Sequence[str]) -> None:
    """Check that the pairs of each contact follow each other along their tangents, and that normals of neighbours do not flip."""
    t, n, step, contact = frames[:, 0], frames[:, 1], np.diff(points, axis=0), np.array(names)
    inside = contact[1:] == contact[:-1]
    flips = inside & (np.sum(n[1:] * n[:-1], axis=1) <= 0)
    back = inside & (np.minimum(np.sum(t[1:] * step, axis=1), np.sum(t[:-1] * step, axis=1)) <= 0)
    if (k := first_of(flips)) is None and (k := first_of(back)) is None:
        return
    way = f"from pair {k} at {place(points[k])} to pair {k + 1} at {place(points[k + 1])}"
    if flips[k]:
        raise ModelError(
            f"normals: they turn by 90 degrees or more {way}; let all point into body 1, and give each side of a corner a contact"
        )
    every = back[inside & (contact[1:] == contact[k])].all()
    hint = (
        "reverse the pairs (or the normals, and exchange the bodies)"
        if every
        else "order the pairs along the contact"
    )
    raise ModelError(
        f"pairs: {way} they go against the tangent, which is the normal turned by -90 degrees; {hint}"
    )


def check_sides(
    K: csr_matrix, unknowns: Integers, graph: csr_matrix, interface: Interface, points: Array
) -> None:
    """Check that the normals point into body 1: nodes off the contact that are joined to those of a pair lie ahead in body 1, behind in body 2.

    A normal is wrong where some of them contradict it and none agrees, or some of either body do:
    at a re-entrant corner those of one body may do so. A node that is joined to clamped ones too,
    which the matrix does not have and which pull it back in any shift, says nothing, and neither do
    reduced models, in which all are joined.
    """
    shifts, listed = np.zeros((K.shape[0], points.shape[1])), unknowns >= 0
    shifts[unknowns[listed], np.nonzero(listed)[1]] = 1.0
    # of node and row, in the shift along each axis
    pulled = (np.abs(K @ shifts) > _ASIDE * np.abs(K.diagonal())[:, None])[unknowns] & listed[
        ..., None
    ]
    _, body = connected_components(graph, directed=False)
    size, joined = np.bincount(body), np.bincount(body, np.diff(graph.indptr))
    telling = ((size <= _ONE) | (joined < _ALL * size**2))[body] & ~pulled.any(axis=1).all(axis=1)
    links, normals = interface.opening.tocoo(), interface.frames[:, -1]
    own = telling[links.col]
    pair, node, side = links.row[own], links.col[own], np.sign(links.data[own])
    seen = graph[node].tocoo()
    arms, of = points[seen.col] - points[node[seen.row]], pair[seen.row]
    heights = side[seen.row] * np.sum(normals[of] * arms, axis=1)
    sure = (np.abs(heights) > _ASIDE * np.linalg.norm(arms, axis=1)) & ~np.isin(seen.col, links.col)
    number = of + len(normals) * (side[seen.row] < 0)  # of body 1, then of body 2
    agree, contradict = (
        np.bincount(number[sure & part], minlength=2 * len(normals)).reshape(2, -1) > 0
        for part in (heights > 0, heights < 0)
    )
    if (
        i := first_of(contradict.all(axis=0) | (contradict.any(axis=0) & ~agree.any(axis=0)))
    ) is not None:
        raise ModelError(
            f"normals: that of pair {i} at {place(points[interface.nodes[i]])} does not point from body 2 into body 1, as their nodes lie there; "
            "turn it, or exchange the nodes of the pair (if all are so, in the plane also reverse the order of the pairs)"
        )


def half_widths(points: Array, names: Sequence[str]) -> Array | None:
    """(N,) half the distances to the neighbours on the same contact; None if a contact has a single pair."""
    width = np.zeros(len(points))
    for run in runs(names):
        half = np.hypot(*np.diff(points[run], axis=0).T) / 2
        width[run] += np.r_[half, 0.0] + np.r_[0.0, half]
    return width if width.min() > 0 else None
