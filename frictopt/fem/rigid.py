"""Rigid motions that nothing prevents, found from a stiffness matrix, and checks with them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, hstack, identity
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from ..base import (
    EQUILIBRIUM,
    FREE_MOTION,
    SAME_POINT,
    Array,
    Integers,
    place,
)
from ..contact.components import null_space, rigid_displacements
from ..errors import ModelError
from .elasticity import parts_of
from .interface import Interface

NO_ROWS: Integers = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Glued:
    """Bodies that are glued together at their contacts.

    Attributes
    ----------
    K
        Stiffness of the separate bodies.
    unknowns
        (nodes, d) rows of K, -1 if a displacement is held, -2 if it follows others.
    points
        (nodes, d) coordinates.
    graph
        Pattern (nodes, nodes) of the nodes that K connects.
    interface
        Pairs and their directions.
    motions
        Free rigid motions of single bodies, see `free_motions`.
    name_of_node
        Function that names a node in error messages.
    generalised
        Rows of K that are generalised coordinates.
    """

    K: csr_matrix
    unknowns: Integers
    points: Array
    graph: csr_matrix
    interface: Interface
    motions: csr_matrix
    name_of_node: Callable[[int], str]
    generalised: Integers


def glued_bodies(
    K: csr_matrix,
    unknowns: Integers,
    points: Array,
    interface: Interface,
    name_of_node: Callable[[int], str],
    generalised: Integers = NO_ROWS,
) -> Glued:
    """The bodies with their free rigid motions; arguments are those of `Glued`.

    The normals of the pairs are corrected so that free bodies can slide.
    """
    graph = node_graph(K, unknowns, generalised)
    _, body = connected_components(graph, directed=False)
    motions = free_motions(K, unknowns, points, body, generalised)
    interface = interface.sliding(motions, unknowns)
    return Glued(K, unknowns, points, graph, interface, motions, name_of_node, generalised)


def node_graph(K: csr_matrix, unknowns: Integers, generalised: Integers = NO_ROWS) -> csr_matrix:
    """(nodes, nodes) pattern of the nodes that the stiffness joins.

    Generalised coordinates may join parts that nothing else joins. In this case, one node is chosen
    in each part, and the chosen nodes are joined.
    """
    node, axis = np.nonzero(unknowns >= 0)
    entries = node, unknowns[node, axis]
    of_node = csr_matrix((np.ones(len(node)), entries), shape=(len(unknowns), K.shape[0]))
    pattern = csr_matrix((np.ones(K.nnz), K.indices, K.indptr), shape=K.shape)
    graph = csr_matrix(of_node @ pattern @ of_node.T)
    if not len(generalised):
        return graph
    # Groups of generalised coordinates, and a node of each part that a group joins.
    count, group = connected_components(K[generalised][:, generalised], directed=False)
    entries = group, generalised
    of_group = csr_matrix((np.ones(len(group)), entries), shape=(count, K.shape[0]))
    number, end = (of_group @ pattern @ of_node.T).nonzero()
    _, part = connected_components(graph, directed=False)
    _, once = np.unique([number, part[end]], axis=1, return_index=True)
    number = number[once]
    end = end[once]
    hub = np.full(count, -1)
    hub[number] = end
    links = csr_matrix((np.ones(len(end)), (hub[number], end)), shape=graph.shape)
    return csr_matrix(graph + links + links.T)


def free_motions(
    K: csr_matrix,
    unknowns: Integers,
    points: Array,
    body: Integers,
    generalised: Integers = NO_ROWS,
) -> csr_matrix:
    """(size, k) orthonormal rigid motions that need no force, each of a single body.

    Arguments are those of `Glued`, and `body` (nodes,), the number of the body of each node.
    Generalised coordinates follow without force.
    """
    rigid = _motions_of_bodies(points, body)
    listed = unknowns >= 0
    u = np.zeros((K.shape[0], rigid.shape[2]))
    u[unknowns[listed]] = rigid[listed]
    if len(generalised):
        u[generalised] = _followed(K, generalised, u)
    # Forces divided by the stiffness of each displacement; for a held displacement, the
    # displacement itself.
    own_stiffness = np.abs(K.diagonal())
    forces = K @ u / np.where(own_stiffness > 0, own_stiffness, 1.0)[:, None]
    resistance = rigid * (unknowns > -2)[..., None]
    resistance[listed] = forces[unknowns[listed]]

    blocks = [csr_matrix((K.shape[0], 0))]
    order = np.argsort(body, kind="stable")
    for nodes in np.split(order, np.flatnonzero(np.diff(body[order])) + 1):
        moves = listed[nodes]
        if not moves.any():
            continue
        motions = _without_force(rigid[nodes], resistance[nodes])[moves.ravel()]
        rows = np.repeat(unknowns[nodes][moves], motions.shape[1])
        columns = np.tile(np.arange(motions.shape[1]), len(motions))
        shape = (K.shape[0], motions.shape[1])
        blocks.append(csr_matrix((motions.ravel(), (rows, columns)), shape=shape))
    motions = csr_matrix(hstack(blocks))
    if not len(generalised):
        return motions
    followed = _followed(K, generalised, motions.toarray())
    return csr_matrix(motions + identity(K.shape[0], format="csr")[:, generalised] @ followed)


def _without_force(rigid: Array, resistance: Array) -> Array:
    """(n d, k) orthonormal motions of one body that nothing resists.

    They are combinations of the rigid motions of the body, `rigid` (n, d, m), each of which meets a
    `resistance` (n, d, m).
    """
    shapes, triangle = np.linalg.qr(rigid.reshape(-1, rigid.shape[2]))
    turned, sizes, mixed = np.linalg.svd(triangle, full_matrices=False)
    # Motions that move nothing are left out: a single node cannot turn.
    real = sizes > SAME_POINT * sizes[0]
    to_unit = mixed[real].T / sizes[real]
    free = null_space(resistance.reshape(-1, rigid.shape[2]) @ to_unit, FREE_MOTION)
    return shapes @ (turned[:, real] @ free)


def _followed(K: csr_matrix, generalised: Integers, u: Array) -> Array:
    """(m, k) generalised coordinates that need no force under displacements u (size, k)."""
    G = K[generalised]
    try:
        return np.asarray(-splu(csc_matrix(G[:, generalised])).solve(G @ u))
    except RuntimeError as error:
        raise ModelError(
            f"generalised: the stiffness of these rows ({len(generalised)}) is singular while all "
            f"nodes are still ({error}); hold the unknowns that move freely, or leave them out"
        ) from error


def assemblies(graph: csr_matrix, interface: Interface) -> Integers:
    """(nodes,) number of the assembly of each node: bodies that contacts glue together."""
    links = interface.opening.tocoo()
    ties = interface.nodes[links.row], links.col
    return parts_of(np.hstack([graph.nonzero(), ties]), graph.shape[0])


def check_supports(glued: Glued) -> None:
    """Check that bodies that are glued together have no free rigid motion."""
    unknowns = glued.unknowns
    points = glued.points
    assembly = assemblies(glued.graph, glued.interface)
    left = free_motions(glued.K, unknowns, points, assembly, glued.generalised)
    if not left.shape[1]:
        return
    node = int(np.flatnonzero((unknowns == left.tocoo().row[0]).any(axis=1))[0])
    group = assembly == assembly[node]
    free = _in_words(left, unknowns[group], points[group])
    raise ModelError(
        f"supports: the body at {place(points[node])}, with all that contacts glue to it, can "
        f"still {free}; add a Support (or rows in `held`) against this motion, and leave out "
        "parts without contact"
    )


def balanced(
    S: Array, R: Array, F: Array, motions: csr_matrix, relative: Array
) -> tuple[Array, Array]:
    """S and R without the rounding errors that elimination makes in rigid motions of the bodies.

    If supports allow a rigid motion of one body, S must have no stiffness against it. In such a
    motion the reactions of a load case must do the work of the load, with the opposite sign. The
    deviation from this measures the accuracy of the elimination.

    S (k, k), R (k, loads) and F (size, loads) are the stiffness, the reactions, and the loads
    before the elimination.
    """
    if not motions.shape[1]:
        return S, R
    rigid, to_unit = np.linalg.qr(relative)
    work = np.linalg.solve(to_unit.T, motions.T @ F)
    excess = rigid.T @ R + work
    force = np.abs(R).sum(axis=0) + np.abs(F).sum(axis=0)
    load_error = (np.abs(excess) / np.where(force > 0, force, 1.0)).max(initial=0.0)
    stiffness_error = (np.abs(S @ rigid) / np.abs(S).max()).max(initial=0.0)
    error = float(np.maximum(load_error, stiffness_error))
    if not error <= EQUILIBRIUM:
        raise ModelError(
            f"stiffness: elimination leaves equilibrium of the bodies with errors of {error:.1e}; "
            "stiffnesses, lengths or sizes of elements differ too much"
        )
    S = S - rigid @ (rigid.T @ S)
    return S - (S @ rigid) @ rigid.T, R - rigid @ excess


def _in_words(motions: csr_matrix, unknowns: Integers, points: Array) -> str:
    """The rigid motions of some glued nodes, as words that follow "can still"."""
    d = points.shape[1]
    rows = motions[unknowns.ravel()].toarray() * (unknowns >= 0).ravel()[:, None]
    rows = rows[:, np.abs(rows).max(axis=0) > 0]
    basis = _motions_of_bodies(points, np.zeros(len(points), dtype=np.intp))
    # Unknowns marked -2 follow other unknowns, and their values are not available here.
    known = (unknowns > -2).ravel()
    parts = np.linalg.lstsq(basis.reshape(-1, basis.shape[2])[known], rows[known])[0]
    parts = parts / np.linalg.norm(parts, axis=0)
    turns, shifts = _turns_and_shifts(parts[d:], parts[:d])
    words = []
    if shifts.shape[1]:
        words.append(f"move along {_axes(shifts)}")
    if turns.shape[1] and d == 2:
        words.append("turn")
    elif turns.shape[1]:
        words.append(f"turn about {_axes(turns)}")
    return " and ".join(words)


def _turns_and_shifts(turns: Array, shifts: Array) -> tuple[Array, Array]:
    """Orthonormal turns of some motions, and orthonormal shifts of the motions without a turn."""
    least = np.sqrt(FREE_MOTION)
    basis, sizes, _ = np.linalg.svd(turns, full_matrices=False)
    return basis[:, sizes > least], np.linalg.qr(shifts @ null_space(turns, least))[0]


def _axes(basis: Array) -> str:
    """The directions that an orthonormal basis spans: names of axes if possible, else vectors."""
    inside = np.linalg.norm(basis, axis=1) > 1 - np.sqrt(FREE_MOTION)
    if inside.sum() == basis.shape[1]:
        return " and ".join(name for name, free in zip("xyz", inside, strict=False) if free)
    words = []
    for vector in basis.T:
        positive = vector * np.sign(vector[np.abs(vector).argmax()])
        # Adding 0.0 turns -0.0 into 0.0.
        words.append(place(positive.round(6) + 0.0))
    return " and ".join(words)


def _motions_of_bodies(points: Array, body: Integers) -> Array:
    """(nodes, d, k) displacements of nodes in translations and turns of their bodies, at most 1.

    Turns are about the middle of the body.
    """
    count = np.bincount(body)
    centre = np.column_stack([np.bincount(body, weights=column) / count for column in points.T])
    arm = points - centre[body]
    size = np.zeros(len(count))
    np.maximum.at(size, body, np.abs(arm).max(axis=1))
    return rigid_displacements(arm / np.where(size > 0, size, 1.0)[body][:, None])
