"""Checks of what the user of another code gives to a condensation: matrices, numbering, pairs."""

import numpy as np
from numpy.typing import ArrayLike
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
from .coincidence import along, coincident, coordinate_errors, measured, one_point
from .elasticity import parts_of
from .interface import Interface

_SYMMETRY = (
    10 * CONDENSATION
)  # asymmetry of a given stiffness, over its largest entry: other codes write ten digits or more


def checked_matrix(name: str, matrix: object, shape: tuple[int, int] | None = None) -> csr_matrix:
    """A finite matrix, sparse or not, of a shape; None: square."""
    found = csr_matrix(matrix if issparse(matrix) else finite_array(name, matrix, (None, None)))
    expected = shape or (max(found.shape[0], 1),) * 2
    if found.dtype.kind not in "fiu" or found.shape != expected:
        raise ModelError(
            f"{name}: shape {found.shape}, type {found.dtype}; give a real matrix of shape {expected}"
        )
    finite_array(f"{name}: entries", found.data)
    return found.astype(np.float64)


def checked_stiffness(K: object, name: str = "K") -> csr_matrix:
    """A symmetric matrix, of which error messages say its name."""
    matrix = checked_matrix(name, K)
    matrix.sum_duplicates()
    skew = abs(matrix - matrix.T).tocoo()
    if skew.nnz and skew.max() > _SYMMETRY * np.abs(matrix.data).max():
        i, j = (int(ends[skew.data.argmax()]) for ends in (skew.row, skew.col))
        raise ModelError(
            f"{name}: not symmetric, {name}[{i}, {j}] = {matrix[i, j]:g} but {name}[{j}, {i}] = {matrix[j, i]:g}; give both triangles of a symmetric "
            "matrix, without friction, follower forces and the like in the step that writes it"
        )
    return matrix


def checked_rows(
    unknowns: ArrayLike,
    held: ArrayLike,
    generalised: ArrayLike,
    shape: tuple[int, ...],
    K: csr_matrix,
) -> tuple[Integers, Integers]:
    """Rows of K, of the shape of the points, -1 for those that are held too, -2 for those that follow others; and generalised ones with stiffness."""
    most = K.shape[0] - 1
    rows = whole_array("unknowns", unknowns, shape, least=-2, most=most)
    fixed, others = (
        whole_array(
            name,
            np.zeros(0) if len(listed(name, given)) == 0 else given,
            (None,),
            least=0,
            most=most,
        )
        for name, given in (("held", held), ("generalised", generalised))
    )
    times = np.bincount(
        np.concatenate([rows[rows >= 0], np.setdiff1d(fixed, rows), others]), minlength=most + 1
    )
    if (row := first_of(times > 1)) is not None:
        nodes = np.argwhere(rows == row)[:, 0].tolist()
        raise ModelError(
            f"unknowns, generalised: row {row} of K is given twice, to nodes {nodes}; give it once: to a node, in held or generalised"
        )
    if (row := first_of(times < 1)) is not None:
        raise ModelError(
            f"unknowns: row {row} of K is no node's; give it to one, or name it in held if it is zero, in generalised if it is free"
        )
    others = others[np.diff(K.indptr)[others] > 0]
    if (i := first_of(K.diagonal()[others] <= 0)) is not None:
        row = others[i]
        raise ModelError(
            f"generalised: row {row} of K has {K[row, row]:g} on the diagonal, as the multiplier of a constraint has; eliminate it"
        )
    return np.where(np.isin(rows, fixed), -1, rows), others


def checked_pairs(
    pairs: ArrayLike, projection: object, rows: Integers, points: Array
) -> tuple[Integers, csr_matrix]:
    """Nodes of body 1, and the matrix of the places on body 2 that they are glued to; `rows` as `checked_rows` gives them."""
    size, own = (
        len(points),
        whole_array(
            "pairs",
            pairs,
            (None, 2) if projection is None else (None,),
            least=0,
            most=len(points) - 1,
        ),
    )
    if not len(own):
        raise ModelError("pairs: none; a contact needs at least one node pair")
    if projection is None:
        nodes, other = own.T
        if (i := first_of(nodes == other)) is not None:
            raise ModelError(
                f"pairs: pair {i} is node {nodes[i]} at {place(points[nodes[i]])} twice, so both bodies share it and nothing slips there; write the "
                "stiffness of bodies with nodes of their own (`split_bodies` gives them to a mesh)"
            )
        P = csr_matrix(identity(size, format="csr")[other])
    else:
        nodes, P = own, checked_matrix("projection", projection, (len(own), size))
        P.eliminate_zeros()
        sums = np.asarray(P.sum(axis=1)).ravel()
        if (i := first_of(np.abs(sums - 1) > SAME_POINT)) is not None:
            raise ModelError(
                f"projection: row {i} adds up to {sums[i]:g}; its weights of the nodes of body 2 must add up to 1"
            )
    both = np.union1d(nodes, P.indices)
    if (i := first_of((rows[both] < -1).any(axis=1))) is not None:
        raise ModelError(
            f"pairs: node {both[i]} at {place(points[both[i]])} follows other nodes, by an equation or a tie (-2 in unknowns); on a contact let the "
            "others follow it (in *EQUATION by exchanging the first term), or take the constraint out"
        )
    return nodes, P


def check_forgotten(graph: csr_matrix, interface: Interface, rows: Integers, points: Array) -> None:
    """Check that no pair is left out: that of nodes of two bodies that lie on each other, next to others that do, where other pairs join the bodies.

    Nodes that pairs join by way of other nodes, or that are held on both sides, make no pair.
    """
    step = graph - diags(graph.diagonal())
    rigid = (
        np.asarray(step.sum(axis=1)).ravel() == 0
    )  # nodes of the ground, with no stiffness of their own
    count, body = connected_components(graph, directed=False)
    body = np.where(rigid, count, body)
    links = interface.opening.tocoo()
    own = interface.nodes[links.row]
    joined = parts_of((own, links.col), len(body))
    i, j = coincident(points, coordinate_errors(points))
    of = csr_matrix(
        (np.ones(len(body)), (np.arange(len(body)), body)), shape=(len(body), count + 1)
    )
    beside = (
        step @ csr_matrix((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=graph.shape) @ of
    )
    meet = of[own].T @ of[links.col]
    lone = (
        (joined[i] != joined[j])
        & ((rows[i] >= 0).all(axis=1) | (rows[j] >= 0).all(axis=1))
        & (body[i] != body[j])
    )
    for one, two in zip(i[lone].tolist(), j[lone].tolist(), strict=True):
        near = [rigid[a] or beside[a, body[b]] for a, b in ((one, two), (two, one))]
        if all(near) and (meet + meet.T)[body[one], body[two]]:
            raise ModelError(
                f"pairs: nodes {one} and {two} lie on each other at {place(points[one])}, next to the contact of their bodies, in no pair; add the "
                "pair, for there the bodies would pass through each other"
            )


def checked_normals(normals: ArrayLike, shape: tuple[int, ...]) -> Array:
    """A direction for each pair, from one for each or one for all; not zero."""
    directions = finite_array("normals", normals)
    if directions.shape not in (shape[1:], shape):
        raise ModelError(
            f"normals: shape {directions.shape}, expected {shape}, or {shape[1:]} for one direction"
        )
    return frozen(np.broadcast_to(directions, shape))


def checked_gap(
    gap: ArrayLike | None, points: Array, opening: Array, normals: Array, errors: Array
) -> Array:
    """(N,) initial gap, as given or from the openings (N, d) of the pairs at some points, which have these errors (N, d)."""
    if gap is not None and not isinstance(gap, str):
        return finite_array("gap", gap, (len(points),))
    distance = np.linalg.norm(opening, axis=1)
    if gap is None and (i := first_of(~one_point(opening, errors), distance)) is not None:
        raise ModelError(
            f"pairs: the nodes of pair {i}, at {place(points[i])} and {place(points[i] - opening[i])}, lie {distance[i]:g} apart; "
            'let them coincide, or say gap="measured" if the bodies are apart there before loading'
        )
    if gap is None:
        return np.zeros(len(points))
    choice("gap", gap, ("measured",))
    distance, error = np.sum(opening * normals, axis=1), along(normals, errors)
    if (i := first_of(distance < -error, -distance)) is not None:
        raise ModelError(
            f"gap: the bodies overlap by {-distance[i]:g} at pair {i}, {place(points[i])}; move them apart, and give an interference"
        )
    return measured(distance, error)
