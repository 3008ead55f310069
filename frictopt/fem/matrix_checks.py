"""Checks of the arguments of `condense`: matrix, numbering, pairs, normals and gap."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix, diags, identity, issparse
from scipy.sparse.csgraph import connected_components

from ..base import (
    CONDENSATION,
    SAME_POINT,
    Array,
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
    """Coordinates (nodes, d) of the nodes of a deck, which know their numbers (nodes,) in it.

    Slices and results of arithmetic have no numbers, because their rows may be other nodes.
    """

    numbers: Integers | None = None


def checked_stiffness(K: object, name: str = "K") -> csr_matrix:
    """Check that a matrix is symmetric; error messages call it `name`."""
    matrix = _checked_matrix(name, K)
    matrix.sum_duplicates()
    skew = abs(matrix - matrix.T).tocoo()
    # Largest asymmetry of a stiffness, relative to its largest entry. Other codes write ten digits.
    largest_asymmetry = 10 * CONDENSATION
    if skew.nnz and skew.max() > largest_asymmetry * np.abs(matrix.data).max():
        worst = skew.data.argmax()
        i = int(skew.row[worst])
        j = int(skew.col[worst])
        raise ModelError(
            f"{name}: not symmetric, {name}[{i}, {j}] = {matrix[i, j]:g} but "
            f"{name}[{j}, {i}] = {matrix[j, i]:g}; give both triangles of a symmetric matrix, "
            "and write it in a step without friction and follower forces"
        )
    return matrix


def _checked_matrix(name: str, matrix: object, shape: tuple[int, int] | None = None) -> csr_matrix:
    """Check that a matrix, sparse or dense, is finite and of a shape; None: square."""
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

    Here and below, `numbers` (nodes,) are the numbers of the nodes in error messages.

    A row is -1 if its displacement is held, also by `held`, and -2 if it follows others. Every row
    of K must be given once.
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
    """Nodes (N,) of body 1, and matrix P (N, nodes) of the places on body 2 they are glued to.

    `rows` are those of `checked_rows`.
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

    A pair is forgotten if nodes of two bodies coincide, other pairs join these bodies, and further
    nodes of the bodies coincide next to them. Nodes that other pairs join indirectly need no pair,
    and neither do nodes held on both sides.
    """
    neighbours = graph - diags(graph.diagonal())
    is_ground = np.asarray(neighbours.sum(axis=1)).ravel() == 0  # held nodes without stiffness
    count, body = connected_components(graph, directed=False)
    body = np.where(is_ground, count, body)  # the ground is one more body
    membership = csr_matrix(
        (np.ones(len(body)), (np.arange(len(body)), body)), shape=(len(body), count + 1)
    )

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
    """(N, d) direction of each pair; one direction (d,) is that of all pairs."""
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

    Arguments are the places (N, d) of the nodes of body 1, the openings (N, d) from body 2 to them,
    unit normals, and the errors of the openings.
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
