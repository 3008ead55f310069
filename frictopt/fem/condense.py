"""Condensation of any sparse stiffness matrix to the contacts of its bodies."""

from __future__ import annotations  # help() then says ArrayLike, not what it is the union of

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError
from scipy.sparse import block_array, csr_matrix, hstack, identity
from scipy.sparse.csgraph import connected_components

from ..base import (
    EQUILIBRIUM,
    SAME_POINT,
    Array,
    Integers,
    bar_of,
    checked_cases,
    checked_contact,
    finite_array,
    place,
)
from ..contact import ContactSystem
from ..contact.frames import frames_of
from ..errors import ModelError
from .coincidence import coordinate_errors
from .given import (
    check_forgotten,
    checked_gap,
    checked_normals,
    checked_pairs,
    checked_rows,
    checked_stiffness,
)
from .interface import Interface, check_course, check_sides, guided, half_widths, openings
from .rigid import balanced, check_supports, free_motions, node_graph
from .schur import Factor, eliminate, nested_dissection

# displacements that a rotation may be joined to, those of the elements at its node; a mode of a
# body is joined to more
_MANY = 300


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
    """Condense the stiffness matrix of any finite-element code to the contacts of its bodies, in the plane or in space.

    The stiffness is that of the separate bodies: nothing couples them yet. Pair i glues its node of
    body 1 to its node of body 2, but for the relative motion along the tangent, `v_i`, and along
    the normal, `w_i`, opening positive. The unknowns that remain are these. Theory, eq. (3).

    Parameters
    ----------
    K
        (n, n) sparse symmetric stiffness, force per length; in the plane also per depth, as all
        forces. A body held with less than 1e-9 of its own stiffness, in the mean of its nodes, is
        free: that much is rounding.
    loads
        Load case name -> (n,) nodal forces on the unknowns under the unit load.
        `ContactSystem.with_interference` adds interferences.
    pairs
        (N, 2) nodes of body 1 and body 2; in the plane ordered along each contact in the direction
        of the tangent, one contact after the other: body 1 is on the left of the way. With a
        `projection`: (N,) nodes of body 1. Of quadratic faces corner nodes alone, which those amid
        edges follow: see `MatrixJob.with_linear_faces`.
    normals
        (N, d) directions from body 2 into body 1, of any length; or one, (d,), for all. In the
        plane the tangent is the normal turned by -90 degrees: normal +y, tangent +x. In space the
        first tangent is x less its part along the normal (y where the normal is nearly x), the
        second one is normal times first tangent: normal z has the tangents x and y. Where a free
        body slides along each of them but for 1e-4 of its way, as coordinates of few digits have
        it, they are turned until it slides: no residual slip shall wedge it. A taper of less than
        1e-4 is lost by that. A body that slides in three ways, as on a plane in space or in a ball,
        needs them to all digits.
    unknowns
        (nodes, d) rows of K that are the displacements of each node in x, y (and z), -1 where K has
        none because the displacement is held at zero, -2 where it has none because the displacement
        follows others, by an equation that K contains; a node of a contact must not.
    points
        (nodes, d) coordinates, length; d = 2 in the plane, 3 in space.
    held
        Rows of K whose displacements are zero. A pair both nodes of which are held along an axis,
        on a plane of symmetry, does not slip along it, and has its normal in that plane; so does
        one of nodes that do not match if the others of its pair lie on one side of the plane.
    generalised
        Rows of K that are no displacement of a node: rotations, and modal and other generalised
        coordinates of a reduced model. They are free, and eliminated with the nodes; their loads
        count.
    projection
        (N, nodes) sparse matrix P for nodes that do not match: the node of body 1 in row i is glued
        to the place `sum_j P_ij u_j` of body 2. The rows add up to 1.
    gap
        None: the nodes of a pair coincide. "measured": their distance along the normal is the
        initial gap. (N,) values >= 0: the gap, whatever the coordinates say.
    contact
        (N,) names of the contact that each pair belongs to; None: one contact, "contact".
    width
        (N,) tributary lengths, in space areas; None: in the plane half the distances to the
        neighbours on the same contact, in space not known. `MatrixJob.areas` finds them in a deck.
        Wear, and tractions in tables, need them.
    progress
        Whether to show after two seconds how far it is. Nothing of it is of use before the end, so
        Ctrl-C keeps nothing.

    Returns
    -------
    ContactSystem
        The contact. In the plane `x` is the coordinate along the tangent if all contacts lie on one
        straight line, else the arc length, contact after contact: it begins at the first node's
        coordinate along its tangent, each further contact one spacing after the end of the one
        before. `dataclasses.replace` adds `E_star` and `units`.

    Raises
    ------
    ModelError
        K not symmetric, rows of K that are in none of `unknowns`, `held` and `generalised` or are
        multipliers of constraints, nodes that K does not have, pairs of the plane out of order,
        normals that flip or point out of body 1, pairs that do not coincide or whose relative
        motion follows from other pairs or supports, nodes of two bodies that lie on each other next
        to the contact in no pair, negative gaps, bodies that neither supports nor contacts hold, a
        matrix that cannot be eliminated accurately.

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

    The same on ground that has rows in the matrix, which are held, glued to places on it:

    >>> rows, points, P = np.arange(8).reshape(4, 2), [[0.0, 0.0], [1.0, 0.0]] * 2, [0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0]
    >>> whole = np.kron(np.eye(2), K.toarray())
    >>> same = fo.condense(whole, {"P": P}, [0, 1], [0.0, 1.0], rows, points, held=rows[2:].ravel(), projection=np.eye(4)[2:])
    >>> bool(abs(same.S - system.S).max() < 1e-12)
    True
    """
    K = checked_stiffness(K)
    where = finite_array("points", points, (None, None))
    d = where.shape[1]
    if d not in (2, 3):
        raise ModelError(
            f"points: shape {where.shape}; give (nodes, 2) in the plane or (nodes, 3) in space"
        )
    rows, others = checked_rows(unknowns, held, generalised, where.shape, K)
    nodes, P = checked_pairs(pairs, projection, rows, where)
    n, x = len(nodes), where[nodes]
    names = checked_contact("contact", ["contact"] * n if contact is None else contact, n).tolist()
    opening = openings(nodes, P)
    errors = coordinate_errors(where)
    directions, _, able = guided(
        nodes, opening, rows, checked_normals(normals, x.shape), where, errors
    )
    frames = frames_of(directions)
    apart = checked_gap(gap, x, x - P @ where, frames[:, -1], errors[nodes] + abs(P) @ errors)
    F = {
        name: finite_array(f"loads[{name!r}]", force, K.shape[:1])
        for name, force in checked_cases("loads", loads, "nodal forces").items()
    }
    for name, force in F.items():
        if force.any() and not np.delete(force, np.asarray(held, dtype=np.intp)).any():
            raise ModelError(
                f"loads[{name!r}]: acts on rows in `held` alone, so nothing feels it; load others, or hold fewer"
            )
    if d == 2:
        check_course(x, frames, names)
    widths: Any = half_widths(x, names) if d == 2 and width is None else width
    interface, graph = Interface(nodes, opening, frames, able), node_graph(K, rows, others)
    check_forgotten(graph, interface, rows, where)
    check_sides(K, rows, graph, interface, where)
    _, body = connected_components(graph, directed=False)
    motions = free_motions(K, rows, where, body, others)
    interface = interface.sliding(motions, rows)
    glued = Glued(
        K,
        rows,
        where,
        graph,
        interface,
        motions,
        lambda node: f"node {node} of body {body[node]}",
        others,
    )
    with bar_of(progress, "condensation"):
        S, bonded, L = condensed(glued, F)
    return ContactSystem(
        S,
        x,
        bonded,
        gap=apart,
        frames=interface.frames,
        contact=np.array(names),
        width=widths,
        compliance=L,
    )


@dataclass(frozen=True, eq=False)
class Glued:
    """Bodies that are glued together at their contacts."""

    K: csr_matrix  # stiffness of the separate bodies
    unknowns: Integers  # (nodes, d) rows of K, -1 where held, -2 where they follow others
    points: Array  # (nodes, d) coordinates
    graph: csr_matrix  # pattern of the nodes that K joins
    interface: Interface  # pairs and directions
    motions: csr_matrix  # rigid motions of single bodies that nothing prevents, see `free_motions`
    called: Callable[[int], str]  # what an error calls a node
    generalised: Integers  # rows of K that are no displacement of a node


def condensed(glued: Glued, loads: Mapping[str, Array]) -> tuple[Array, dict[str, Array], Array]:
    """Stiffness S (k, k) of the relative motions, direction by direction; of load cases the reactions (k,) that hold these, and the compliance."""
    K, interface, motions = glued.K, glued.interface, glued.motions
    check_supports(K, glued.unknowns, glued.points, glued.graph, interface, glued.generalised)
    relative = interface.relative(motions, glued.unknowns)
    sizes = np.linalg.svd(relative, compute_uv=False)
    if len(sizes) < relative.shape[1] or (sizes[-1:] <= SAME_POINT * sizes[:1]).any():
        raise ModelError(
            "supports: a body can turn about its contact, or move without moving there; hold it, or give the contact more nodes"
        )
    F = np.reshape([*loads.values()], (-1, K.shape[0])).T
    T, front = fronts(glued)
    inside, forces = csr_matrix(T.T @ K @ T), csr_matrix(T.T @ F)
    left, _ = eliminated(
        glued, block_array([[inside, forces], [forces.T, None]], format="csr"), T, front
    )
    k = interface.frames[..., 0].size
    S, R = balanced(left[:k, :k], -left[:k, k:], F, motions, relative)
    largest = np.abs(S).max()
    rounding = (
        np.finfo(float).eps * inside.diagonal()[front < 0].max() / largest if largest > 0 else 0.0
    )
    if motions.shape[1] < k and rounding > EQUILIBRIUM:
        raise ModelError(
            f"stiffness: bodies 1 are so much stiffer than bodies 2 that the stiffness of the contact has an error of {rounding:.1e}; "
            "exchange the bodies, or bring their stiffness closer together"
        )
    motionless = (
        np.asarray(abs(T).sum(axis=0)).ravel()[front < 0] == 0
    )  # across planes of symmetry: any stiffness does, no force is there
    still = np.flatnonzero(motionless)
    S[still, still] = np.diag(S).sum() / max(k - len(still), 1)
    return S, dict(zip(loads, R.T, strict=True)), -left[k:, k:]


def fronts(glued: Glued) -> tuple[csr_matrix, Integers]:
    """The matrix T of `u = T y`, and the front that eliminates each of the y, -1 for the relative motions."""
    K, interface, generalised = glued.K, glued.interface, glued.generalised
    T, columns = interface.motion(glued.unknowns, K.shape[0])
    own = columns >= 0
    present = np.flatnonzero(own.any(axis=1))
    of_node = np.zeros(len(columns), dtype=np.intp)
    image = interface.spread != 0
    of_node[present] = nested_dissection(
        csr_matrix(image.T @ glued.graph @ image)[present][:, present], glued.points[present].T
    )
    front = np.full(T.shape[1], -1)
    front[columns[own]] = np.broadcast_to(of_node[:, None], columns.shape)[own]
    if len(
        generalised
        # each of them with the displacement that it is joined to most; after all if it is joined to
        # many
    ):
        joined = abs(csr_matrix((K[generalised] @ T)[:, front >= 0]))
        count = np.diff(joined.indptr)
        few, most = (count > 0) & (count <= _MANY), np.asarray(joined.argmax(axis=1)).ravel()
        front = np.r_[front, np.where(few, front[front >= 0][most], front.max() + 1)]
        T = csr_matrix(hstack([T, identity(K.shape[0], format="csr")[:, generalised]]))
    return T, front


def eliminated(
    glued: Glued, matrix: csr_matrix, T: csr_matrix, front: Integers, *, keep: bool = False
) -> tuple[Array, list[Factor]]:
    """The elimination of the y of `fronts` from a matrix of them, and of more unknowns that are kept, see `eliminate`."""
    try:
        return eliminate(matrix, np.r_[front, np.full(matrix.shape[0] - len(front), -1)], keep=keep)
    except LinAlgError as error:
        row = int(abs(csr_matrix(T[:, error.args[0]])).argmax())
        node = np.flatnonzero((glued.unknowns == row).any(axis=1))
        where = (
            f"{glued.called(int(node[0]))} at {place(glued.points[node[0]])}"
            if len(node)
            else f"row {row}"
        )
        raise ModelError(
            f"stiffness: {where} has none left once its neighbours are free; support the bodies, or bring the stiffness of bodies closer together"
        ) from error
