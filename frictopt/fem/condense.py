"""Condensation of any sparse stiffness matrix to the contacts of its bodies."""

from __future__ import annotations  # so that help() shows the name ArrayLike

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError
from scipy.sparse import block_array, csr_matrix, hstack, identity

from ..base import (
    EQUILIBRIUM,
    SAME_POINT,
    Array,
    Integers,
    checked_cases,
    checked_contact,
    finite_array,
    place,
    progress_bar,
    runs,
)
from ..contact import ContactSystem
from ..errors import ModelError
from .coincidence import coordinate_errors
from .interface import interface_of, openings
from .matrix_checks import (
    NumberedPoints,
    check_forgotten,
    check_order,
    check_sides,
    checked_gap,
    checked_normals,
    checked_pairs,
    checked_rows,
    checked_stiffness,
)
from .rigid import Glued, balanced, check_supports, glued_bodies
from .schur import Factor, eliminate, nested_dissection


def condense(
    K: Any,
    loads: Mapping[str, ArrayLike],
    pairs: ArrayLike,
    normals: ArrayLike,
    unknowns: ArrayLike,
    points: ArrayLike,
    *,
    held: ArrayLike = (),
    generalised: ArrayLike = (),
    projection: object = None,
    gap: ArrayLike | None = None,
    contact: ArrayLike | None = None,
    width: ArrayLike | None = None,
    progress: bool = True,
) -> ContactSystem:
    """Condense the stiffness matrix of any finite-element code to the contacts of its bodies.

    The bodies are plane or in space, and the stiffness must not couple them. Pair i glues its node
    of body 1 to its node of body 2, except for two relative motions: `v_i` along the tangent, and
    `w_i` along the normal (opening is positive). These motions remain as unknowns. Theory, eq. (3).

    Parameters
    ----------
    K
        (n, n) sparse symmetric stiffness, force per length; in the plane also per depth, like all
        forces. A body counts as free if the stiffness of its supports, averaged over its nodes, is
        below 1e-9 of its own stiffness: so small a stiffness is no more than rounding.
    loads
        Load case name -> (n,) nodal forces on the unknowns under the unit load.
        `ContactSystem.with_interference` adds interferences.
    pairs
        (N, 2) nodes of body 1 and body 2. With a `projection`: (N,) nodes of body 1. In the plane
        the pairs are ordered along each contact in the direction of the tangent, contact after
        contact, with body 1 on the left. On quadratic faces give corner nodes only; the midside
        nodes have to follow them, see `MatrixJob.with_linear_faces`.
    normals
        (N, d) directions from body 2 into body 1, of any length; or (d,), one direction for all. In
        the plane the tangent is the normal turned by -90 degrees: normal +y, tangent +x. In space
        the first tangent is x minus its part along the normal (y if the normal is nearly x). The
        second tangent is the cross product of normal and first tangent: normal z has the tangents x
        and y. Coordinates of few digits can wedge a body that is free to slide. If sliding opens
        no pair by more than 1e-4 of the slip, the normals are therefore turned until the body
        slides freely; a taper below 1e-4 is lost. A body with three sliding motions, as on a plane
        in space or in a ball, needs normals with all digits.
    unknowns
        (nodes, d) rows of K of the displacements of each node in x, y (and z). A row is -1 if K has
        none because the displacement is held at zero. It is -2 if K has none because the
        displacement follows others by an equation that K contains; this is not allowed at nodes of
        a contact.
    points
        (nodes, d) coordinates, length; d = 2 in the plane, 3 in space. `MatrixJob.points` also have
        the numbers of the nodes in the deck. Errors then name nodes by these numbers, and tables
        have them in the column `deck_node`.
    held
        Rows of K whose displacements are zero. On a plane of symmetry, hold both nodes of a pair
        across the plane: the pair then does not slip across the plane, and its normal is turned
        into the plane. If the nodes of a pair do not match, the rest of the pair must lie on one
        side of the plane.
    generalised
        Rows of K that are generalised coordinates, such as rotations, and modal amplitudes of a
        reduced model. These coordinates are free, and are eliminated with the nodes; loads may act
        on them.
    projection
        (N, nodes) sparse matrix P for nodes that do not match: the node of body 1 of pair i is
        glued to a place of body 2 with the displacement `sum_j P_ij u_j`. Each row adds up to 1.
    gap
        None: the nodes of a pair coincide. "measured": their distance along the normal is the
        initial gap. (N,) values >= 0: the gap, independent of the coordinates.
    contact
        (N,) names of the contact that each pair belongs to; None: one contact, "contact".
    width
        (N,) tributary lengths, in space areas. None: in the plane half the distances to the
        neighbours on the same contact, in space unknown. `MatrixJob.areas` computes them from a
        deck. Wear, and tractions in tables, need widths.
    progress
        Whether to show a progress bar after two seconds. Ctrl-C keeps nothing, because there is no
        partial result.

    Returns
    -------
    ContactSystem
        The contact. In the plane `x` is the coordinate along the tangent if all contacts lie on one
        straight line, otherwise the arc length. The arc length begins at the first node's
        coordinate along its tangent; each further contact begins one mean spacing of nodes after
        the end of the contact before it. `dataclasses.replace` adds `E_star`, `units` and
        `axisymmetric`.

    Raises
    ------
    ModelError
        K is not symmetric. A row of K is in none of `unknowns`, `held` and `generalised`, or is the
        multiplier of a constraint. `unknowns` names rows that K does not have. Pairs in the plane
        are out of order. Normals flip, or point out of body 1. Nodes of a pair do not coincide, or
        their relative motion follows from other pairs or from supports. Nodes of two bodies
        coincide next to the contact and are in no pair. A gap is negative. A body is held neither
        by supports nor by contacts. The matrix cannot be eliminated accurately.

    Examples
    --------
    A square on rigid ground, held by springs against a slide:

    >>> import numpy as np
    >>> from scipy.sparse import csr_matrix
    >>> import frictopt as fo
    >>> spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> across = np.kron(np.eye(2), np.diag([1.0, 0.0]))
    >>> K = csr_matrix(np.kron(spring, np.eye(2)) + across)
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

    The same contact, if the matrix also has rows for the ground; these rows are held:

    >>> rows = np.arange(8).reshape(4, 2)
    >>> same = fo.condense(
    ...     np.kron(np.eye(2), K.toarray()),
    ...     loads={"P": [0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0]},
    ...     pairs=[0, 1],
    ...     normals=[0.0, 1.0],
    ...     unknowns=rows,
    ...     points=[[0.0, 0.0], [1.0, 0.0]] * 2,
    ...     held=rows[2:].ravel(),
    ...     projection=np.eye(4)[2:],
    ... )
    >>> bool(abs(same.S - system.S).max() < 1e-12)
    True
    """
    K = checked_stiffness(K)
    coordinates = finite_array("points", points, (None, None))
    d = coordinates.shape[1]
    if d not in (2, 3):
        raise ModelError(
            f"points: shape {coordinates.shape}; give (nodes, 2) in the plane or (nodes, 3) in "
            "space"
        )
    deck_numbers = points.numbers if isinstance(points, NumberedPoints) else None
    numbers = np.arange(len(coordinates)) if deck_numbers is None else deck_numbers
    rows, generalised_rows = checked_rows(
        unknowns, held, generalised, coordinates.shape, K, numbers
    )
    nodes, P = checked_pairs(pairs, projection, rows, coordinates, numbers)
    x = coordinates[nodes]
    contact = ["contact"] * len(nodes) if contact is None else contact
    names = checked_contact(contact, len(nodes)).tolist()

    errors = coordinate_errors(coordinates)
    directions = checked_normals(normals, x.shape)
    interface = interface_of(
        nodes, openings(nodes, P), rows, directions, coordinates, errors, numbers
    )
    frames = interface.frames
    pair_errors = errors[nodes] + abs(P) @ errors
    initial_gap = checked_gap(gap, x, x - P @ coordinates, frames[:, -1], pair_errors)
    forces = _checked_forces(loads, held, K.shape[0])
    if d == 2:
        check_order(x, frames, names)
    widths: Any = width
    if d == 2 and width is None:
        widths = _half_widths(x, names)

    def name_of_node(node: int) -> str:
        return f"node {numbers[node]}"

    glued = glued_bodies(K, rows, coordinates, interface, name_of_node, generalised_rows)
    check_forgotten(glued.graph, interface, rows, coordinates, numbers)
    check_sides(K, rows, glued.graph, interface, coordinates)
    F = np.reshape([*forces.values()], (-1, K.shape[0])).T
    with progress_bar(progress, "condensation"):
        stiffness, reactions, compliance = condensed(glued, F)
    return ContactSystem(
        **stiffness,
        points=x,
        bonded=dict(zip(forces, reactions.T, strict=True)),
        gap=initial_gap,
        frames=glued.interface.frames,
        contact=np.array(names),
        deck_node=None if deck_numbers is None else deck_numbers[nodes],
        width=widths,
        compliance=compliance,
    )


def _checked_forces(loads: Mapping[str, ArrayLike], held: ArrayLike, size: int) -> dict[str, Array]:
    """Nodal forces (size,) of each load case; some of them must act on rows that are not held."""
    held_rows = np.asarray(held, dtype=np.intp)
    forces = {}
    for name, values in checked_cases("loads", loads, "nodal forces").items():
        force = finite_array(f"loads[{name!r}]", values, (size,))
        if force.any() and not np.delete(force, held_rows).any():
            raise ModelError(
                f"loads[{name!r}]: acts only on rows in `held`, so it has no effect; load other "
                "rows, or hold fewer rows"
            )
        forces[name] = force
    return forces


def _half_widths(points: Array, names: Sequence[str]) -> Array | None:
    """(N,) half the distances to the neighbours on the contact; None if a contact has one pair."""
    width = np.zeros(len(points))
    for run in runs(names):
        half = np.hypot(*np.diff(points[run], axis=0).T) / 2
        width[run] += np.r_[half, 0.0] + np.r_[0.0, half]
    return width if width.min() > 0 else None


def condensed(glued: Glued, F: Array) -> tuple[dict[str, Any], Array, Array]:
    """Stiffness "S" (k, k) of the relative motions, bonded reactions (k, loads), and compliance.

    The k relative motions are ordered direction by direction. The bonded reactions keep them at
    zero under loads F (size, loads). The compliance (loads, loads) is that of the glued bodies.
    """
    K = glued.K
    motions = glued.motions
    relative = checked_motions(glued)

    # Eliminate the inside of the bodies from the stiffness, with the loads as further columns.
    T, front = fronts(glued)
    stiffness = csr_matrix(T.T @ K @ T)
    forces = csr_matrix(T.T @ F)
    bordered = block_array([[stiffness, forces], [forces.T, None]], format="csr")
    schur, _ = eliminated(glued, bordered, T, front)
    k = len(relative)
    S, reactions = balanced(schur[:k, :k], -schur[:k, k:], F, motions, relative)

    is_relative = front < 0
    if motions.shape[1] < k:
        _check_rounding(float(stiffness.diagonal()[is_relative].max()), S)
    # Across a plane of symmetry there is neither motion nor force, so any stiffness may be used.
    motionless = np.asarray(abs(T).sum(axis=0)).ravel()[is_relative] == 0
    still = np.flatnonzero(motionless)
    S[still, still] = np.diag(S).sum() / max(k - len(still), 1)
    return {"S": S}, reactions, -schur[k:, k:]


def checked_motions(glued: Glued) -> Array:
    """(k, motions) relative motions due to free rigid motions, each of which must cause some."""
    check_supports(glued)
    relative = glued.interface.relative(glued.motions, glued.unknowns)
    sizes = np.linalg.svd(relative, compute_uv=False)
    if len(sizes) < relative.shape[1] or (sizes[-1:] <= SAME_POINT * sizes[:1]).any():
        raise ModelError(
            "supports: a body can turn about its contact, or move without relative motion of the "
            "contact; hold it, or give the contact more nodes"
        )
    return relative


def _check_rounding(largest_before: float, S: Array) -> None:
    """Check that S is not a small difference of large stiffnesses, as it is if body 1 is rigid.

    `largest_before` is the largest stiffness of a relative motion before the elimination.
    """
    largest = np.abs(S).max()
    rounding = np.finfo(float).eps * largest_before / largest if largest > 0 else 0.0
    if rounding > EQUILIBRIUM:
        raise ModelError(
            "stiffness: bodies 1 are so much stiffer than bodies 2 that the stiffness of the "
            f"contact has an error of {rounding:.1e}; exchange the bodies, or reduce the ratio of "
            "their stiffnesses"
        )


def fronts(glued: Glued) -> tuple[csr_matrix, Integers]:
    """Matrix T of `u = T y`, and the number of the front that eliminates each unknown y.

    The number is -1 for the relative motions, which are kept.
    """
    K = glued.K
    interface = glued.interface
    generalised = glued.generalised
    T, columns = interface.motion(glued.unknowns, K.shape[0])

    # A dependent node connects the independent nodes on which it depends.
    has_column = columns >= 0
    present = np.flatnonzero(has_column.any(axis=1))
    depends = interface.spread != 0
    graph = csr_matrix(depends.T @ glued.graph @ depends)[present][:, present]
    front_of_node = np.zeros(len(columns), dtype=np.intp)
    front_of_node[present] = nested_dissection(graph, glued.points[present].T)
    front = np.full(T.shape[1], -1)
    front[columns[has_column]] = np.broadcast_to(front_of_node[:, None], columns.shape)[has_column]
    if not len(generalised):
        return T, front

    # A rotation is eliminated with the displacement that it is connected to most strongly.
    connections = abs(csr_matrix((K[generalised] @ T)[:, front >= 0]))
    strongest = np.asarray(connections.argmax(axis=1)).ravel()
    T = csr_matrix(hstack([T, identity(K.shape[0], format="csr")[:, generalised]]))
    return T, np.r_[front, front[front >= 0][strongest]]


def eliminated(
    glued: Glued, matrix: csr_matrix, T: csr_matrix, front: Integers, *, keep: type | None = None
) -> tuple[Array, list[Factor]]:
    """Eliminate the y of `fronts` from a matrix, see `eliminate`; further unknowns are kept."""
    kept = np.full(matrix.shape[0] - len(front), -1)
    try:
        return eliminate(matrix, np.r_[front, kept], keep=keep)
    except LinAlgError as error:
        row = int(abs(csr_matrix(T[:, error.args[0]])).argmax())
        nodes = np.flatnonzero((glued.unknowns == row).any(axis=1))
        unknown = f"row {row}"
        if len(nodes):
            unknown = f"{glued.name_of_node(int(nodes[0]))} at {place(glued.points[nodes[0]])}"
        raise ModelError(
            f"stiffness: {unknown} has no stiffness if its neighbours are free; support the "
            "bodies, or reduce the ratio of their stiffnesses"
        ) from error
