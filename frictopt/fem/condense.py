"""Condensation of any sparse stiffness matrix to the contacts of its bodies."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, issparse
from scipy.sparse.csgraph import connected_components

from ..contact import ContactSystem
from ..contact.checks import Array, check_name, checked_contact, checked_overlaps, choice, finite_array, listed, whole_array
from ..errors import ModelError
from .frames import arc_length, check_course, check_sides, half_widths, place, plane_frames
from .interface import Interface, glued
from .ordering import Integers, nested_dissection
from .rigid import balanced, check_supports, free_motions, node_graph
from .schur import schur_complement

__all__ = ["condense", "condensed"]

_SYMMETRY = 1e-9  # asymmetry over the largest entry that still counts as rounding of the code that wrote the matrix
_SAME_POINT = 1e-9  # distance below which the nodes of a pair coincide, as a share of the size of the bodies


def condense(
    K: Any,
    loads: Mapping[str, Any],
    pairs: Any,
    normals: Any,
    unknowns: Any,
    points: Any,
    *,
    held: Any = (),
    projection: Any = None,
    gap: Any = None,
    interference: Mapping[str, Any] | None = None,
    contact: Any = None,
    width: Any = None,
    E_star: float | None = None,
) -> ContactSystem:
    """Condense the stiffness matrix of any finite-element code to the contacts of its bodies, in the plane.

    The stiffness is that of the separate bodies: nothing couples them yet. Pair i glues its node of body 1 to its node of body 2, but for the
    relative motion along the tangent, `v_i`, and along the normal, `w_i`, opening positive. The unknowns that remain are these.

    Parameters
    ----------
    K
        (n, n) sparse symmetric stiffness, force per length and depth.
    loads
        Load case name -> (n,) nodal forces on the unknowns under the unit load, force per depth; may be empty if there is an interference.
    pairs
        (N, 2) nodes of body 1 and body 2, ordered along each contact in the direction of the tangent, one contact after the other: body 1 is on the
        left of the way. With a `projection`: (N,) nodes of body 1.
    normals
        (N, 2) directions from body 2 into body 1, of any length; or one, (2,), for all. The tangent is the normal turned by -90 degrees: normal +y,
        tangent +x.
    unknowns
        (nodes, 2) rows of K that are the displacements of each node in x and in y, -1 where K has none because the displacement is held at zero.
    points
        (nodes, 2) coordinates, length.
    held
        Rows of K whose displacements are zero.
    projection
        (N, nodes) sparse matrix P for nodes that do not match: the node of body 1 in row i is glued to the place `sum_j P_ij u_j` of body 2. The rows
        add up to 1.
    gap
        None: the nodes of a pair coincide. "measured": their distance along the normal is the initial gap. (N,) values >= 0: the gap, whatever the
        coordinates say.
    interference
        Load case name -> overlap of the bodies before assembly, >= 0, one number or (N,), length. It adds to the loads of that name, if any.
    contact
        (N,) names of the contact that each pair belongs to; None: one contact, "contact".
    width
        (N,) tributary lengths; None: half the distances to the neighbours on the same contact.
    E_star
        Contact modulus, see `ContactSystem`.

    Returns
    -------
    ContactSystem
        The contact; `x` is the arc length, one contact after the other. It begins at the first node's coordinate along its tangent, so that a straight
        contact on the x-axis has the coordinates x. Each further contact begins one spacing after the end of the one before.

    Raises
    ------
    ModelError
        K not symmetric, rows of K that no node has, nodes that K does not have, pairs out of order or with a node in common, normals that flip or
        point out of body 1, pairs that do not coincide, negative gaps, a held node of body 1 on the contact, bodies that their supports and contacts do
        not hold, a matrix that cannot be eliminated accurately.

    Examples
    --------
    A square on rigid ground, held by springs against a slide:

    >>> import numpy as np
    >>> from scipy.sparse import csr_matrix
    >>> import frictopt as fo
    >>> spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> K = csr_matrix(np.kron(spring, np.eye(2)) + np.kron(np.diag([1.0, 1.0]), np.diag([1.0, 0.0])))
    >>> system = fo.condense(
    ...     K,
    ...     loads={"P": [0.0, -1.0, 0.0, -1.0]},
    ...     pairs=[[0, 2], [1, 3]],
    ...     normals=[0.0, 1.0],
    ...     unknowns=[[0, 1], [2, 3], [-1, -1], [-1, -1]],
    ...     points=[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
    ... )
    >>> system
    ContactSystem(nodes=2, x=0 .. 1, loads=['P'], gap=False)
    >>> system.bonded["P"][1].tolist()
    [1.0, 1.0]
    """
    K = _checked_stiffness(K)
    where = finite_array("points", points, (None, 2))
    rows = _checked_rows(unknowns, held, len(where), K.shape[0])
    nodes, P = _checked_pairs(pairs, projection, rows, where)
    n = len(nodes)
    names = checked_contact("contact", ["contact"] * n if contact is None else contact, n).tolist()
    frames = plane_frames(_checked_normals(normals, n))
    x, side = where[nodes], frames[:, 1]
    opening = _checked_gap(gap, x - P @ where, side, x, _SAME_POINT * float(np.ptp(where, axis=0).max()))
    F = _checked_forces(loads, K.shape[0])
    overlaps = checked_overlaps("interference", interference or {}, n)
    interface, graph = Interface(nodes, P, frames), node_graph(K, rows)
    check_course(x, frames, names)
    check_sides(graph, interface, where, names)
    S, R = condensed(K, np.reshape([*F.values()], (-1, K.shape[0])).T, interface, rows, where, graph)
    reactions = dict(zip(F, R.T, strict=True))
    for name, d in overlaps.items():
        reactions[name] = reactions.get(name, 0.0) + S[:, n:] @ d
    return ContactSystem(
        A=S[:n, :n],
        B=S[n:, :n],
        C=S[n:, n:],
        x=arc_length(x, frames, names),
        bonded={name: (r[:n], r[n:]) for name, r in reactions.items()},
        gap=opening,
        E_star=E_star,
        points=x,
        normals=side,
        contact=names,
        width=half_widths(x, names) if width is None else width,
    )


def condensed(K: csr_matrix, F: Array, interface: Interface, unknowns: Integers, points: Array, graph: csr_matrix) -> tuple[Array, Array]:
    """Stiffness S (k, k) of the relative motions, direction by direction, and the reactions R (k, loads) that hold them at zero.

    Parameters
    ----------
    K, F
        Stiffness of the bodies and (size, loads) loads.
    interface
        Pairs and directions, in as many dimensions as the points have.
    unknowns, points
        (nodes, d) rows of K, -1 where held, and coordinates.
    graph
        Pattern of the nodes that K joins.

    Raises
    ------
    ModelError
        Rigid motions that nothing prevents, a stiffness that cannot be eliminated, or not accurately enough.
    """
    check_supports(K, unknowns, points, graph, interface)
    T = interface.motion(unknowns, K.shape[0])
    columns = interface.eliminated(unknowns)
    present = np.flatnonzero((columns >= 0).any(axis=1))
    along = present[nested_dissection(interface.glued_graph(graph)[present][:, present], points[present].T)]
    order = columns[along].ravel()
    S, R = schur_complement(glued(K, T), T.T @ F, np.r_[order[order >= 0], np.arange(T.shape[1] - interface.kept, T.shape[1])], interface.kept)
    _, body = connected_components(graph, directed=False)
    return balanced(S, R, K, F, interface, unknowns, free_motions(K, unknowns, points, body))


def _checked_stiffness(K: Any) -> csr_matrix:
    if not issparse(K):
        K = finite_array("K", K, (None, None))
    matrix = csr_matrix(K)
    if matrix.dtype.kind not in "fiu" or matrix.shape[0] != matrix.shape[1] or not matrix.shape[0]:
        raise ModelError(f"K: shape {matrix.shape}, type {matrix.dtype}; give the square, real stiffness matrix")
    matrix = matrix.astype(np.float64)
    finite_array("K: entries", matrix.data)
    matrix.sum_duplicates()
    skew = (matrix - matrix.T).tocoo()
    worst = int(np.abs(skew.data).argmax()) if skew.nnz else 0
    if skew.nnz and np.abs(skew.data[worst]) > _SYMMETRY * np.abs(matrix.data).max():
        i, j = int(skew.row[worst]), int(skew.col[worst])
        raise ModelError(
            f"K: not symmetric, K[{i}, {j}] = {matrix[i, j]:g} but K[{j}, {i}] = {matrix[j, i]:g}; give both triangles of a symmetric stiffness"
        )
    return matrix


def _checked_rows(unknowns: Any, held: Any, nodes: int, size: int) -> Integers:
    """(nodes, 2) rows of K, -1 for those that are held too."""
    rows = whole_array("unknowns", unknowns, (nodes, 2), least=-1, most=size - 1)
    fixed = whole_array("held", np.zeros(0) if len(listed("held", held)) == 0 else held, (None,), least=0, most=size - 1)
    times = np.bincount(rows[rows >= 0], minlength=size)
    if times.max() > 1:
        row = int(times.argmax())
        raise ModelError(f"unknowns: row {row} of K is that of nodes {np.argwhere(rows == row)[:2, 0].tolist()}; give each row to one node")
    times[fixed] = 1
    if times.min() < 1:
        row = int(times.argmin())
        raise ModelError(f"unknowns: row {row} of K is no node's; give it to a node, or name it in held if its displacement is zero")
    return np.where(np.isin(rows, fixed), -1, rows)


def _checked_pairs(pairs: Any, projection: Any, rows: Integers, points: Array) -> tuple[Integers, csr_matrix]:
    """Nodes of body 1, and the matrix of the places on body 2 that they are glued to."""
    most = len(points) - 1
    if projection is None:
        nodes, other = whole_array("pairs", pairs, (None, 2), least=0, most=most).T
        P = csr_matrix((np.ones(len(other)), (np.arange(len(other)), other)), shape=(len(other), len(points)))
    else:
        nodes = whole_array("pairs", pairs, (None,), least=0, most=most)
        P = _checked_projection(projection, (len(nodes), len(points)))
    if not len(nodes):
        raise ModelError("pairs: none; a contact needs at least one node pair")
    values, times = np.unique(nodes, return_counts=True)
    if np.any(times > 1):
        node = int(values[times > 1][0])
        raise ModelError(f"pairs: node {node} of body 1 at {place(points[node])} is in two pairs; let a corner belong to one contact alone")
    both = np.intersect1d(nodes, P.indices)
    if len(both):
        raise ModelError(f"pairs: node {both[0]} at {place(points[both[0]])} is on both sides; let it be in one pair, and in body 1 or body 2")
    if np.any(rows[nodes] < 0):
        node = int(nodes[(rows[nodes] < 0).any(axis=1)][0])
        raise ModelError(f"pairs: node {node} of body 1 at {place(points[node])} is held; hold body 1 elsewhere, or exchange the bodies")
    return nodes, P


def _checked_projection(projection: Any, shape: tuple[int, int]) -> csr_matrix:
    P = csr_matrix(projection if issparse(projection) else finite_array("projection", projection, (None, None)))
    if P.shape != shape or P.dtype.kind not in "fiu":
        raise ModelError(f"projection: shape {P.shape}, type {P.dtype}; give a real matrix of shape {shape}, a row for each node of body 1")
    P = P.astype(np.float64)
    finite_array("projection: entries", P.data)
    P.eliminate_zeros()
    sums = np.asarray(P.sum(axis=1)).ravel()
    if np.abs(sums - 1).max() > _SAME_POINT:
        i = int(np.abs(sums - 1).argmax())
        raise ModelError(f"projection: row {i} adds up to {sums[i]:g}; its weights of the nodes of body 2 must add up to 1")
    return P


def _checked_normals(normals: Any, n: int) -> Array:
    directions = finite_array("normals", normals)
    if directions.shape not in ((2,), (n, 2)):
        raise ModelError(f"normals: shape {directions.shape}, expected ({n}, 2), or (2,) for one direction")
    return np.broadcast_to(directions, (n, 2))


def _checked_gap(gap: Any, opening: Array, side: Array, points: Array, near: float) -> Array | None:
    """The initial gap, from the openings (N, 2) of the pairs unless it is given; nodes that are `near` coincide."""
    if gap is not None and not isinstance(gap, str):
        return finite_array("gap", gap, (len(points),))
    choice("gap", "measured" if gap is None else gap, ("measured",))
    if gap is None:
        distance = np.hypot(*opening.T)
        if distance.max() > near:
            i = int(distance.argmax())
            raise ModelError(
                f"pairs: the nodes of pair {i}, at {place(points[i])} and {place(points[i] - opening[i])}, lie {distance[i]:g} apart; "
                'let them coincide, or say gap="measured" if the bodies are apart there before loading'
            )
        return None
    distance = np.sum(opening * side, axis=1)
    if distance.min() < -near:
        i = int(distance.argmin())
        raise ModelError(f"gap: the bodies overlap by {-distance[i]:g} at pair {i}, {place(points[i])}; move them apart, and give an interference")
    return np.maximum(distance, 0.0)


def _checked_forces(loads: Any, size: int) -> dict[str, Array]:
    if not isinstance(loads, Mapping):
        raise ModelError(f"loads: a {type(loads).__name__}; give a mapping, load case name -> nodal forces")
    for name in loads:
        check_name("loads", name)
    return {name: finite_array(f"loads[{name!r}]", force, (size,)) for name, force in loads.items()}
