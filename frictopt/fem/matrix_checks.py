"""Checks of the arguments of `condense`: matrix, numbering, pairs, their sides, and gap."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix, diags, identity, issparse
from scipy.sparse.csgraph import connected_components

from ..base import (
    CONDENSATION,
    SAME_POINT,
    Array,
    Booleans,
    Integers,
    choice,
    finite_array,
    first_of,
    frozen,
    listed,
    place,
    whole_array,
)
from ..errors import ModelError
from .coincidence import coincide, coincident, coordinate_errors, error_along, measured
from .elasticity import parts_of
from .interface import Interface


class NumberedPoints(NDArray[np.float64]):
    """Coordinates (nodes, d) of the nodes of a deck, with their `numbers` (nodes,) in the deck.

    Slices and results of arithmetic have no numbers, because their rows may be other nodes.
    """

    numbers: Integers | None = None


def checked_stiffness(K: object) -> csr_matrix:
    """Check that K is a symmetric matrix with finite entries, and return it sparse."""
    matrix = _checked_matrix("K", K)
    matrix.sum_duplicates()
    skew = abs(matrix - matrix.T).tocoo()
    # Largest asymmetry of a stiffness, relative to its largest entry: other codes write ten digits.
    largest_asymmetry = 10 * CONDENSATION
    if skew.nnz and skew.max() > largest_asymmetry * np.abs(matrix.data).max():
        worst = skew.data.argmax()
        i = int(skew.row[worst])
        j = int(skew.col[worst])
        raise ModelError(
            f"K: not symmetric, K[{i}, {j}] = {matrix[i, j]:g} but "
            f"K[{j}, {i}] = {matrix[j, i]:g}; give both triangles of a symmetric matrix, "
            "and write it in a step without friction and follower forces"
        )
    return matrix


def _checked_matrix(name: str, matrix: object, shape: tuple[int, int] | None = None) -> csr_matrix:
    """Check that a matrix, sparse or dense, is finite and has the `shape` (None: is square)."""
    entries = matrix if issparse(matrix) else finite_array(name, matrix, (None, None))
    sparse = csr_matrix(entries)
    expected = shape or (max(sparse.shape[0], 1),) * 2
    if sparse.dtype.kind not in "fiu" or sparse.shape != expected:
        raise ModelError(
            f"{name}: shape {sparse.shape}, type {sparse.dtype}; give a real matrix of shape "
            f"{expected}"
        )
    finite_array(f"{name}: entries", sparse.data)
    return sparse.astype(np.float64)


def checked_rows(
    unknowns: ArrayLike,
    held: ArrayLike,
    generalised: ArrayLike,
    shape: tuple[int, ...],
    K: csr_matrix,
    numbers: Integers,
) -> tuple[Integers, Integers]:
    """Rows of K of the displacements, of `shape` (nodes, d), and generalised rows with stiffness.

    In this file, `numbers` (nodes,) are the numbers of the nodes in error messages.

    A row is -1 if `unknowns` or `held` holds the displacement, and -2 if the displacement follows
    others. Every row of K must be given once.
    """
    size = K.shape[0]
    rows = whole_array("unknowns", unknowns, shape, least=-2, most=size - 1)
    held_rows = _checked_indices("held", held, size)
    generalised_rows = _checked_indices("generalised", generalised, size)

    listed_rows = [rows[rows >= 0], np.setdiff1d(held_rows, rows), generalised_rows]
    times = np.bincount(np.concatenate(listed_rows), minlength=size)
    if (row := first_of(times > 1)) is not None:
        nodes = numbers[np.argwhere(rows == row)[:, 0]].tolist()
        raise ModelError(
            f"unknowns, generalised: row {row} of K is given twice, to nodes {nodes}; give it "
            "once: to a node, in held or generalised"
        )
    if (row := first_of(times < 1)) is not None:
        raise ModelError(
            f"unknowns: row {row} of K belongs to no node; assign it to a node, or name it in "
            "held if it is zero, in generalised if it is free"
        )

    has_stiffness = np.diff(K.indptr)[generalised_rows] > 0
    generalised_rows = generalised_rows[has_stiffness]
    if (i := first_of(K.diagonal()[generalised_rows] <= 0)) is not None:
        row = generalised_rows[i]
        raise ModelError(
            f"generalised: row {row} of K has {K[row, row]:g} on the diagonal, so it may be the "
            "multiplier of a constraint; eliminate it"
        )
    return np.where(np.isin(rows, held_rows), -1, rows), generalised_rows


def _checked_indices(name: str, rows: ArrayLike, size: int) -> Integers:
    """Check a list of rows of a matrix with `size` rows; it may be empty."""
    if len(listed(name, rows)) == 0:
        rows = np.zeros(0)
    return whole_array(name, rows, (None,), least=0, most=size - 1)


def checked_pairs(
    pairs: ArrayLike, projection: object, rows: Integers, points: Array, numbers: Integers
) -> tuple[Integers, csr_matrix]:
    """Nodes (N,) of body 1, and matrix P (N, nodes) of their places on body 2.

    `rows` is the first result of `checked_rows`.
    """
    size = len(points)
    shape = (None, 2) if projection is None else (None,)
    ends = whole_array("pairs", pairs, shape, least=0, most=size - 1)
    if not len(ends):
        raise ModelError("pairs: none; a contact needs at least one node pair")

    if projection is None:
        nodes, partners = ends.T
        if (i := first_of(nodes == partners)) is not None:
            raise ModelError(
                f"pairs: pair {i} is node {numbers[nodes[i]]} at {place(points[nodes[i]])} twice, "
                "so both bodies share it and nothing slips there; write the stiffness of bodies "
                "with nodes of their own (`split_bodies` gives them to a mesh)"
            )
        P = csr_matrix(identity(size, format="csr")[partners])
    else:
        nodes = ends
        P = _checked_matrix("projection", projection, (len(nodes), size))
        P.eliminate_zeros()
        sums = np.asarray(P.sum(axis=1)).ravel()
        if (i := first_of(np.abs(sums - 1) > SAME_POINT)) is not None:
            raise ModelError(
                f"projection: row {i} adds up to {sums[i]:g}; its weights of the nodes of body 2 "
                "must add up to 1"
            )

    on_contact = np.union1d(nodes, P.indices)
    if (i := first_of((rows[on_contact] < -1).any(axis=1))) is not None:
        raise ModelError(
            f"pairs: node {numbers[on_contact[i]]} at {place(points[on_contact[i]])} follows other "
            "nodes, by an equation or a tie (-2 in unknowns); on a contact let the others follow "
            "it (in *EQUATION by exchanging the first term), or take the constraint out"
        )
    return nodes, P


def check_forgotten(
    graph: csr_matrix, interface: Interface, rows: Integers, points: Array, numbers: Integers
) -> None:
    """Check that no pair of a contact is left out.

    A pair is missing on three conditions: a node of one body coincides with a node of another body;
    other pairs join these two bodies; and next to the two nodes, more nodes of the two bodies
    coincide. Nodes that other pairs join indirectly need no pair, and neither do nodes that are
    held in both bodies.
    """
    neighbours = graph - diags(graph.diagonal())
    is_ground = np.asarray(neighbours.sum(axis=1)).ravel() == 0  # held nodes without stiffness
    count, body = connected_components(graph, directed=False)
    body = np.where(is_ground, count, body)  # the ground is one more body
    membership = identity(count + 1, format="csr")[body]

    links = interface.opening.tocoo()
    nodes_1 = interface.nodes[links.row]
    joined = parts_of((nodes_1, links.col), len(body))
    in_contact = membership[nodes_1].T @ membership[links.col]
    in_contact = in_contact + in_contact.T  # (bodies, bodies)

    i, j = coincident(points, coordinate_errors(points))
    ends = (np.r_[i, j], np.r_[j, i])
    coincidences = csr_matrix((np.ones(2 * len(i)), ends), shape=graph.shape)
    # (nodes, bodies) whether a neighbour of a node coincides with a node of a body
    beside = neighbours @ coincidences @ membership

    is_free = np.asarray((rows >= 0).all(axis=1))
    is_lone = (joined[i] != joined[j]) & (is_free[i] | is_free[j]) & (body[i] != body[j])
    for node_1, node_2 in zip(i[is_lone].tolist(), j[is_lone].tolist(), strict=True):
        next_to_contact = (is_ground[node_1] or beside[node_1, body[node_2]]) and (
            is_ground[node_2] or beside[node_2, body[node_1]]
        )
        if next_to_contact and in_contact[body[node_1], body[node_2]]:
            raise ModelError(
                f"pairs: nodes {numbers[node_1]} and {numbers[node_2]} lie on each other at "
                f"{place(points[node_1])}, next to the contact of their bodies, in no pair, so "
                "that the bodies would pass through each other there; add the pair"
            )


def checked_normals(normals: ArrayLike, shape: tuple[int, ...]) -> Array:
    """(N, d) direction of each pair; a single direction (d,) is given to all pairs."""
    directions = finite_array("normals", normals)
    if directions.shape not in (shape[1:], shape):
        raise ModelError(
            f"normals: shape {directions.shape}, expected {shape}, or {shape[1:]} for one direction"
        )
    return frozen(np.broadcast_to(directions, shape))


def checked_gap(
    gap: ArrayLike | None, points: Array, opening: Array, normals: Array, errors: Array
) -> Array:
    """(N,) initial gap: as given, or measured.

    Arguments are the places (N, d) of the nodes of body 1, the vectors `opening` (N, d) from their
    places on body 2 to these nodes, unit normals, and the errors of the vectors.
    """
    if gap is not None and not isinstance(gap, str):
        return finite_array("gap", gap, (len(points),))

    if gap is None:
        distance = np.linalg.norm(opening, axis=1)
        if (i := first_of(~coincide(opening, errors), distance)) is not None:
            raise ModelError(
                f"pairs: the nodes of pair {i}, at {place(points[i])} and "
                f"{place(points[i] - opening[i])}, lie {distance[i]:g} apart; let them coincide, "
                'or say gap="measured" if the bodies are apart there before loading'
            )
        return np.zeros(len(points))

    choice("gap", gap, ("measured",))
    distance = np.sum(opening * normals, axis=1)
    error = error_along(normals, errors)
    if (i := first_of(distance < -error, -distance)) is not None:
        raise ModelError(
            f"gap: the bodies overlap by {-distance[i]:g} at pair {i}, {place(points[i])}; move "
            "them apart, and give an interference"
        )
    return measured(distance, error)


# Tolerances of `check_sides`.

# A neighbour lies in the plane of the contact if its height, relative to its distance, is below
# this number.
_IN_PLANE = 1e3 * CONDENSATION
# If all nodes shift together, clamped neighbours pull a node back. A force counts as a pull if it
# exceeds this share of the stiffness of the node. Smaller forces are rounding.
_PULLED = 1e3 * CONDENSATION
# A body of one element has at most this many nodes, all connected to each other.
_ELEMENT_NODES = 8
# A body is a reduced model if more than this share of its pairs of nodes are connected.
_REDUCED = 0.75


def check_order(points: Array, frames: Array, names: Sequence[str]) -> None:
    """Check that the pairs of each contact in the plane run along their tangents, without flips.

    `points` (N, 2) are the places of the pairs, `frames` their directions, and `names` their
    contacts.
    """
    contact = np.array(names)
    inside = contact[1:] == contact[:-1]  # steps (N - 1,) within one contact

    def step(k: int) -> str:
        return f"from pair {k} at {place(points[k])} to pair {k + 1} at {place(points[k + 1])}"

    normals = frames[:, 1]
    flips = inside & (np.sum(normals[1:] * normals[:-1], axis=1) <= 0)
    if (k := first_of(flips)) is not None:
        raise ModelError(
            f"normals: they turn by 90 degrees or more {step(k)}; let all point into body 1, and "
            "give each side of a corner a contact"
        )

    tangents = frames[:, 0]
    steps = np.diff(points, axis=0)
    progress = np.minimum(
        np.sum(tangents[1:] * steps, axis=1), np.sum(tangents[:-1] * steps, axis=1)
    )
    backwards = inside & (progress <= 0)
    if (k := first_of(backwards)) is not None:
        hint = "order the pairs along the contact"
        if backwards[inside & (contact[1:] == contact[k])].all():
            hint = "reverse the pairs (or the normals, and exchange the bodies)"
        raise ModelError(
            f"pairs: {step(k)} they go against the tangent, which is the normal turned by -90 "
            f"degrees; {hint}"
        )


def check_sides(
    K: csr_matrix, unknowns: Integers, graph: csr_matrix, interface: Interface, points: Array
) -> None:
    """Check that the normals point from body 2 into body 1.

    Along the normal, neighbours of a pair that are not on the contact lie ahead of the pair in body
    1 and behind it in body 2. A normal is rejected if neighbours in both bodies contradict it, or
    if some contradict it and none agrees. At a re-entrant corner, neighbours in one body may
    contradict it.
    """
    links = interface.opening.tocoo()  # `row` is the pair, `col` the node, `data` its weight
    is_telling = _telling(K, unknowns, graph)[links.col]
    pair = links.row[is_telling]
    node = links.col[is_telling]
    side = np.sign(links.data[is_telling])  # 1 in body 1, -1 in body 2

    # Each entry is a neighbour of a node. The height of the neighbour is positive if it agrees with
    # the normal.
    neighbours = graph[node].tocoo()
    neighbour_pair = pair[neighbours.row]
    neighbour_side = side[neighbours.row]
    arms = points[neighbours.col] - points[node[neighbours.row]]
    normals = interface.frames[:, -1]
    heights = neighbour_side * np.sum(normals[neighbour_pair] * arms, axis=1)
    off_plane = np.abs(heights) > _IN_PLANE * np.linalg.norm(arms, axis=1)
    counts = off_plane & ~np.isin(neighbours.col, links.col)

    def any_neighbour(flags: Booleans) -> Booleans:
        """(2, N) whether any counted neighbour of a pair in body 1, and in body 2, has a flag."""
        number = neighbour_pair + len(normals) * (neighbour_side < 0)
        flagged = np.bincount(number[counts & flags], minlength=2 * len(normals)) > 0
        return flagged.reshape(2, -1)

    agree = any_neighbour(heights > 0)
    contradict = any_neighbour(heights < 0)
    is_wrong = contradict.all(axis=0) | (contradict.any(axis=0) & ~agree.any(axis=0))
    if (i := first_of(is_wrong)) is not None:
        raise ModelError(
            f"normals: that of pair {i} at {place(points[interface.nodes[i]])} does not point "
            "from body 2 into body 1, judging by their nodes; reverse it, or exchange the nodes "
            "of the pair (if all normals are reversed, in the plane also reverse the order of the "
            "pairs)"
        )


def _telling(K: csr_matrix, unknowns: Integers, graph: csr_matrix) -> Booleans:
    """(nodes,) nodes whose neighbours show the side on which their body lies.

    Two kinds of nodes do not show this side. The first kind are nodes connected to clamped nodes:
    they lack neighbours, because the matrix does not contain clamped nodes. If all nodes shift
    together along an axis, clamped nodes pull them back, and this force shows that they are of this
    kind. The second kind are nodes of reduced models: each is connected to all others.
    """
    listed = unknowns >= 0
    shifts = np.zeros((K.shape[0], unknowns.shape[1]))  # column a: all nodes move along axis a
    shifts[unknowns[listed], np.nonzero(listed)[1]] = 1.0
    is_pulled = np.abs(K @ shifts) > _PULLED * np.abs(K.diagonal())[:, None]
    # (nodes, d, d): displacement of a node, axis of the shift
    pulled = is_pulled[unknowns] & listed[..., None]
    is_pulled_always = pulled.any(axis=1).all(axis=1)

    _, body = connected_components(graph, directed=False)
    size = np.bincount(body)
    connections = np.bincount(body, np.diff(graph.indptr))
    is_mesh = (size <= _ELEMENT_NODES) | (connections < _REDUCED * size**2)
    return np.asarray(is_mesh[body] & ~is_pulled_always)
