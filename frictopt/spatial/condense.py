"""Condensation of a stiffness matrix of any finite-element code to a contact in three dimensions."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..contact.checks import Array, checked_overlaps, finite_array
from ..contact.system import ContactSystem
from ..errors import ModelError
from ..fem.condense import reactions
from ..fem.given import (
    check_forgotten,
    checked_forces,
    checked_gap,
    checked_normals,
    checked_pairs,
    checked_rows,
    checked_stiffness,
    held_nodes,
    same_point,
)
from ..fem.interface import Interface, openings
from ..fem.rigid import node_graph

__all__ = ["condense", "frames_of"]

_ALONG = 0.9  # share of x in a normal from which on the first tangent is taken from y


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
) -> ContactSystem:
    """Condense the stiffness matrix of any finite-element code to the contacts of its bodies, in three dimensions.

    Parameters
    ----------
    K
        (n, n) sparse symmetric stiffness of the separate bodies, force per length.
    loads
        Load case name -> (n,) nodal forces on the unknowns under the unit load.
    pairs
        (N, 2) nodes of body 1 and body 2, in any order; with a `projection` (N,) nodes of body 1.
    normals
        (N, 3) directions from body 2 into body 1, of any length, or one for all. The first tangent is x less its part along the normal (y where the
        normal is nearly x), the second one is normal times first tangent: normal z has the tangents x and y.
    unknowns, points
        (nodes, 3) rows of K of each node's displacements, -1 where held, -2 where they follow others, and coordinates.
    held, projection, gap, interference
        See `frictopt.condense`.

    Raises
    ------
    ModelError
        As for the plane, but for the order of the pairs.
    """
    K = checked_stiffness(K)
    where = finite_array("points", points, (None, 3))
    rows = checked_rows(unknowns, held, where.shape, K.shape[0])
    nodes, P = checked_pairs(pairs, projection, rows, where)
    n = len(nodes)
    frames = frames_of(checked_normals(normals, (n, 3)))
    apart = checked_gap(gap, where[nodes], where[nodes] - P @ where, frames[:, 2], same_point(where))
    F = checked_forces(loads, K.shape[0])
    overlaps = checked_overlaps("interference", {} if interference is None else interference, n)
    interface, graph = Interface(nodes, openings(nodes, P), frames, held_nodes(rows)), node_graph(K, rows)
    check_forgotten(graph, interface, rows, where)
    S, bonded = reactions(K, F, overlaps, interface, rows, where, graph, ["contact"] * n)
    return ContactSystem(S, where[nodes], bonded, gap=apart, frames=frames)


def frames_of(normals: Array) -> Array:
    """(N, 3, 3) two tangents and the unit normal, from (N, 3) normals of any length."""
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.min() > 0:
        raise ModelError(f"normals: zero at pair {int(lengths.argmin())}; give the direction from body 2 into body 1")
    n = normals / lengths[:, None]
    axis = np.where(np.abs(n[:, :1]) < _ALONG, np.eye(3)[0], np.eye(3)[1])
    first = axis - np.sum(axis * n, axis=1)[:, None] * n
    first = first / np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(n, first), n], axis=1)
