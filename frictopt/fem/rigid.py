"""Rigid motions that nothing prevents: how they are found in a stiffness matrix, and what they say of a condensation."""

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, hstack, identity
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from ..base import CONDENSATION, EQUILIBRIUM, SAME_POINT, Array, Integers, place
from ..errors import ModelError
from .interface import Interface

NO_ROWS: Integers = np.zeros(0, dtype=np.intp)
_FREE_MOTION = (
    10 * CONDENSATION
    # a rigid motion is free if its forces, over the stiffness of the nodes it moves, are smaller: DMIG
    # has ten digits
)


def node_graph(K: csr_matrix, unknowns: Integers, generalised: Integers = NO_ROWS) -> csr_matrix:
    """(nodes, nodes) pattern of the nodes that the stiffness joins; of parts that generalised coordinates alone join, one node each is joined."""
    node, axis = np.nonzero(unknowns >= 0)
    of_node = csr_matrix(
        (np.ones(len(node)), (node, unknowns[node, axis])), shape=(len(unknowns), K.shape[0])
    )
    pattern = csr_matrix((np.ones(K.nnz), K.indices, K.indptr), shape=K.shape)
    graph = csr_matrix(of_node @ pattern @ of_node.T)
    if not len(generalised):
        return graph
    count, group = connected_components(K[generalised][:, generalised], directed=False)
    of_group = csr_matrix((np.ones(len(group)), (group, generalised)), shape=(count, K.shape[0]))
    of, ends = (of_group @ pattern @ of_node.T).nonzero()
    _, part = connected_components(graph, directed=False)
    _, few = np.unique([of, part[ends]], axis=1, return_index=True)
    of, ends = of[few], ends[few]
    first = np.full(count, -1)
    first[of] = ends
    links = csr_matrix((np.ones(len(ends)), (first[of], ends)), shape=graph.shape)
    return csr_matrix(graph + links + links.T)


def free_motions(
    K: csr_matrix,
    unknowns: Integers,
    points: Array,
    body: Integers,
    generalised: Integers = NO_ROWS,
    directions: Array | None = None,
) -> csr_matrix:
    """(size, k) rigid motions, of one body each, that need no force; orthonormal.

    Arguments are those of `Glued` and `Interface`, and the (nodes,) number of the body of each
    node. Generalised coordinates follow without force.
    """
    rigid = _rigid_motions(points, body, directions)
    listed = unknowns >= 0
    u = np.zeros((K.shape[0], rigid.shape[2]))
    u[unknowns[listed]] = rigid[listed]
    if len(generalised):
        u[generalised] = _followed(K, generalised, u)
    own_stiffness = np.abs(K.diagonal())
    resistance = (
        rigid * (unknowns > -2)[..., None]
    )  # over the stiffness of each displacement by itself; that of a held one is the displacement
    resistance[listed] = (K @ u / np.where(own_stiffness > 0, own_stiffness, 1.0)[:, None])[
        unknowns[listed]
    ]
    found = [csr_matrix((K.shape[0], 0))]
    order = np.argsort(body, kind="stable")
    for own in np.split(order, np.flatnonzero(np.diff(body[order])) + 1):
        if not listed[own].any():
            continue
        shapes, triangle = np.linalg.qr(rigid[own].reshape(-1, rigid.shape[2]))
        turned, sizes, mixed = np.linalg.svd(triangle, full_matrices=False)
        real = sizes > SAME_POINT * sizes[0]  # a single node cannot turn
        forces = np.linalg.qr(
            resistance[own].reshape(-1, rigid.shape[2]) @ (mixed[real].T / sizes[real]), mode="r"
        )
        _, force, turn = np.linalg.svd(forces)
        free = turn[np.pad(force, (0, len(turn) - len(force))) <= _FREE_MOTION].T
        motions = (shapes @ (turned[:, real] @ free))[listed[own].ravel()]
        where = (
            np.repeat(unknowns[own][listed[own]], motions.shape[1]),
            np.tile(np.arange(motions.shape[1]), len(motions)),
        )
        found.append(csr_matrix((motions.ravel(), where), shape=(K.shape[0], motions.shape[1])))
    motions = csr_matrix(hstack(found))
    if not len(generalised):
        return motions
    return csr_matrix(
        motions
        + identity(K.shape[0], format="csr")[:, generalised]
        @ _followed(K, generalised, motions.toarray())
    )


def _followed(K: csr_matrix, generalised: Integers, u: Array) -> Array:
    """(m, k) generalised coordinates that need no force under displacements u (size, k)."""
    G = K[generalised]
    try:
        return np.asarray(-splu(csc_matrix(G[:, generalised])).solve(G @ u))
    except RuntimeError as error:
        rows = (
            f"the stiffness of these {len(generalised)} rows is singular while all nodes are still"
        )
        raise ModelError(
            f"generalised: {rows} ({error}); hold what moves freely, or leave it out"
        ) from error


def assemblies(graph: csr_matrix, interface: Interface) -> Integers:
    """(nodes,) number of the bodies that contacts glue together, to which each node belongs."""
    links = interface.opening.tocoo()
    ties = csr_matrix(
        (np.ones(len(links.row)), (interface.nodes[links.row], links.col)), shape=graph.shape
    )
    return np.asarray(connected_components(graph + ties, directed=False)[1])


def check_supports(
    K: csr_matrix,
    unknowns: Integers,
    points: Array,
    graph: csr_matrix,
    interface: Interface,
    generalised: Integers,
) -> None:
    """Check that no rigid motion is left to bodies that are glued together."""
    assembly = assemblies(graph, interface)
    left = free_motions(K, unknowns, points, assembly, generalised, interface.directions)
    if left.shape[1]:
        node = int(np.flatnonzero((unknowns == left.tocoo().row[0]).any(axis=1))[0])
        group = assembly == assembly[node]
        free = _in_words(
            left,
            unknowns[group],
            points[group],
            None if interface.directions is None else interface.directions[group],
        )
        raise ModelError(
            f"supports: the body at {place(points[node])}, with all that contacts glue to it, can still {free}; "
            "add a Support (or rows in `held`) against it, and leave out what touches nothing"
        )


def balanced(
    S: Array, R: Array, F: Array, motions: csr_matrix, relative: Array
) -> tuple[Array, Array]:
    """S and R without the rounding errors of the elimination in the rigid motions of the bodies.

    S must have no stiffness against a rigid motion of one body that its supports allow, and the
    reactions of a load case must do the work of the load in it, with the opposite sign. The
    deviation measures the accuracy of the elimination.

    S (k, k), R (k, loads) and F (size, loads) are the stiffness, the reactions, and the loads
    before the elimination.
    """
    if not motions.shape[1]:
        return S, R
    rigid, to_unit = np.linalg.qr(relative)
    work = np.linalg.solve(to_unit.T, motions.T @ F)
    excess = rigid.T @ R + work
    scale = np.abs(R).sum(axis=0) + np.abs(F).sum(axis=0)
    errors = [
        *(np.abs(excess) / np.where(scale > 0, scale, 1.0)).ravel(),
        *(np.abs(S @ rigid) / np.abs(S).max()).ravel(),
    ]
    error = float(max(errors, default=0.0))
    if not error <= EQUILIBRIUM:
        raise ModelError(
            f"stiffness: elimination leaves equilibrium of the bodies with errors of {error:.1e}; bring stiffness, lengths, elements closer together"
        )
    S = S - rigid @ (rigid.T @ S)
    return np.asarray(S - (S @ rigid) @ rigid.T), np.asarray(R - rigid @ excess)


def _in_words(
    motions: csr_matrix, unknowns: Integers, points: Array, directions: Array | None
) -> str:
    """The rigid motions of some glued nodes, as what they can still do."""
    d, names = points.shape[1], "xyz"
    rows = motions[unknowns.ravel()].toarray() * (unknowns >= 0).ravel()[:, None]
    rows = rows[:, np.abs(rows).max(axis=0) > 0]
    basis = _rigid_motions(points, np.zeros(len(points), dtype=np.intp), directions).reshape(
        -1, d * (d + 1) // 2
    )
    known = (unknowns > -2).ravel()  # the others follow
    parts = np.linalg.lstsq(basis[known], rows[known])[0]
    turns, sizes, mixed = np.linalg.svd(parts[d:] / np.linalg.norm(parts, axis=0))
    turning = sizes > np.sqrt(_FREE_MOTION)
    turns, still = (
        turns[:, : len(sizes)][:, turning],
        np.pad(~turning, (0, len(mixed) - len(sizes)), constant_values=True),
    )
    shifts = np.linalg.qr((parts[:d] / np.linalg.norm(parts, axis=0)) @ mixed[still].T)[0]
    words = [f"move along {_axes(shifts, names[:d])}"] if shifts.shape[1] else []
    if turns.shape[1]:  # of the turns, the basis has those in xy, xz and yz
        words.append(
            "turn" if d == 2 else f"turn about {_axes(turns[::-1] * [[1.0], [-1.0], [1.0]], names)}"
        )
    return " and ".join(words)


def _axes(basis: Array, names: str) -> str:
    """The directions that an orthonormal basis spans: axes where it can, else its vectors."""
    inside = np.linalg.norm(basis, axis=1) > 1 - np.sqrt(_FREE_MOTION)
    if inside.sum() == basis.shape[1]:
        return " and ".join(name for name, free in zip(names, inside, strict=True) if free)
    return " and ".join(
        place((vector * np.sign(vector[np.abs(vector).argmax()])).round(6) + 0.0)
        for vector in basis.T
    )


def _rigid_motions(points: Array, body: Integers, directions: Array | None) -> Array:
    """(nodes, d, k) displacements in the translations and turns about the middle of each body, at most 1; in the directions of each node, if any."""
    count, d = np.bincount(body), points.shape[1]
    centre = np.column_stack([np.bincount(body, weights=column) / count for column in points.T])
    arm = points - centre[body]
    size = np.zeros(len(count))
    np.maximum.at(size, body, np.abs(arm).max(axis=1))
    arm = arm / np.where(size > 0, size, 1.0)[body][:, None]
    columns = [np.broadcast_to(direction, points.shape) for direction in np.eye(d)]
    for a in range(d):
        for b in range(a + 1, d):
            turn = np.zeros(points.shape)
            turn[:, a], turn[:, b] = -arm[:, b], arm[:, a]
            columns.append(turn)
    motions = np.stack(columns, axis=-1)
    return motions if directions is None else np.asarray(directions @ motions)
