"""Pairs that supports guide: the directions in which they cannot slip, and their normals.

On a plane of symmetry, supports hold the nodes of both bodies across the plane, so that a pair
there slips in the plane only.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..base import Array, Booleans, Integers, first_of, number_of, place
from ..errors import ModelError
from .interface import ASKEW


@dataclass(frozen=True, eq=False)
class GuidedPairs:
    """N pairs: normals, directions without slip, and candidates for dependent nodes."""

    # (N, d) normals, of any length
    normals: Array
    # (N, d) direction in which a pair cannot slip, if it exists and is not an axis; otherwise zero
    blocked: Array
    # (N, all nodes) entries of M at nodes that can be the dependent node of their pair
    candidates: csr_matrix


def guided_pairs(
    nodes: Integers,
    opening: csr_matrix,
    unknowns: Integers,
    normals: Array,
    points: Array,
    errors: Array,
    directions: Array | None = None,
) -> GuidedPairs:
    """Find the directions in which pairs cannot slip, and the nodes that can be dependent.

    A pair cannot slip along an axis if supports hold all its nodes along that axis. This is also
    true on a plane of symmetry (or an axis of symmetry), on two conditions. Supports hold the nodes
    of both bodies there, and the rest of the pair lies on one side: its mirror image cancels its
    motion. The normal is then put into the plane, because it comes from facets on one side only.

    A node can be dependent if it is held along exactly the axes in which its pairs cannot slip.
    Then no other node depends on its motion along these axes.

    Parameters
    ----------
    nodes, opening
        (N,) nodes of body 1 of the pairs, and (N, all nodes) matrix M of the relative motions.
    unknowns
        (all nodes, d) unknowns, negative if held.
    normals
        (N, d) normals of the pairs.
    points, errors
        (all nodes, d) coordinates and their errors.
    directions
        (all nodes, d, d) directions of the unknowns of each node; None: x, y and z. If the nodes of
        a pair have rotated directions, its axes are these directions.
    """
    links = opening.tocoo()  # one link for each node of a pair: `row` is the pair, `col` the node
    axes, held = _axes_of_pairs(links, unknowns < 0, directions, points[nodes])

    def any_link(flags: Booleans) -> Booleans:
        """(N, d) whether flags (links, d) hold for any node of a pair."""
        count = len(nodes)
        return np.column_stack(
            [np.bincount(links.row, flag, minlength=count) > 0 for flag in flags.T]
        )

    # Distance (links, d) of each node from the plane across each axis through the node of body 1.
    first = nodes[links.row]
    distance = np.einsum("lka,la->lk", axes[links.row], points[links.col] - points[first])
    # The places have errors, and so has the axis, which follows from the places of a face.
    error = 2 * np.einsum("lka,la->lk", np.abs(axes[links.row]), errors[links.col] + errors[first])
    on_plane = held & (np.abs(distance) <= error)
    below = any_link(~on_plane & (distance <= error))
    above = any_link(~on_plane & (distance >= -error))
    of_body_2 = (links.data < 0)[:, None]
    is_symmetric = ~(below & above) & any_link(on_plane & of_body_2)
    across = ~any_link(~held) | is_symmetric

    normals = np.einsum("nka,na->nk", axes, normals)  # components along the axes of the pair
    lengths_in_plane = np.linalg.norm(np.where(across, 0.0, normals), axis=1)
    # Least share of a normal that lies in a plane of symmetry. The normal at an edge may lean out
    # of the plane by half the angle of the facet beside it.
    least_share = 0.5
    across &= (lengths_in_plane > least_share * np.linalg.norm(normals, axis=1))[:, None]
    blocked = np.einsum("nk,nka->na", across * 1.0, axes)
    along_coordinates = np.all(axes == np.eye(axes.shape[1]), axis=(1, 2))
    blocked[(across.sum(axis=1) != 1) | along_coordinates] = 0.0

    slips = ~across[links.row]
    held_against_slip = links.col[(held & slips).any(axis=1)]
    is_candidate = (held != slips).all(axis=1) & ~np.isin(links.col, held_against_slip)
    entries = (links.data[is_candidate], (links.row[is_candidate], links.col[is_candidate]))
    return GuidedPairs(
        np.einsum("nk,nka->na", np.where(across, 0.0, normals), axes),
        blocked,
        csr_matrix(entries, shape=opening.shape),
    )


def notes_on_held(
    names: Sequence[str],
    contact: Integers,
    nodes: Integers,
    moves: Booleans,
    name_of_node: Callable[[int], str],
) -> list[str]:
    """A note for each contact with pairs that cannot move; some pair of each contact can.

    Of each pair are given the number of its contact, its node of body 1, and whether it moves.
    """
    notes = []
    for number, name in enumerate(names):
        held = nodes[~moves & (contact == number)]
        if not len(held):
            continue
        if not moves[contact == number].any():
            raise ModelError(
                f"contacts: no pair of {name!r} can move, because supports or ties hold both "
                "sides; leave the contact out, or hold fewer nodes"
            )
        listed = ", ".join(name_of_node(node) for node in held.tolist())
        count = number_of(len(held), "pair")
        notes.append(f"contact {name!r}: {count} that cannot move left out: {listed}")
    return notes


def _axes_of_pairs(
    links: Any, held: Booleans, directions: Array | None, places: Array
) -> tuple[Array, Booleans]:
    """Axes (N, d, d) of the pairs, and whether each node of a pair is held along them, (links, d).

    A pair has other axes than x, y and z if one of its nodes has other directions. They are the
    directions of its node of body 1, which is mostly the dependent one: nothing then moves in the
    direction in which it is held, also if rounding tilts the direction of the other node. Rounding
    tilts a direction that is normal to another one, so nodes with the largest weights come next.
    """
    n, d = places.shape
    axes = np.tile(np.eye(d), (n, 1, 1))
    if directions is None:
        return axes, held[links.col]

    oblique = (directions != np.eye(d)).any(axis=(1, 2))[links.col]
    for pair in np.unique(links.row[oblique]).tolist():
        of_pair = np.flatnonzero(links.row == pair)
        weights = links.data[of_pair]
        nodes = links.col[of_pair[np.lexsort([-np.abs(weights), weights < 0])]]
        axes[pair] = node_directions(directions[nodes][held[nodes]])[0]

    # Share of each axis of the pair in the directions in which the node is held: 0 or 1.
    cosines = np.einsum("lma,lka->lmk", directions[links.col], axes[links.row])
    share = np.einsum("lm,lmk->lk", held[links.col], cosines**2)
    if (k := first_of((np.abs(share - 0.5) < 0.5 - ASKEW).any(axis=1))) is not None:
        raise ModelError(
            f"supports: the nodes of the contact at {place(places[links.row[k]])} are held along "
            "different normals; give the faces of both bodies that lie in one plane, or on one "
            "cylinder, supports of the same kind"
        )
    return axes, share > 0.5


def node_directions(normals: Iterable[Array]) -> tuple[Array, int]:
    """Orthonormal directions (d, d) of a node, and in how many of them the node is held.

    The node is held along the normals (d,); the first directions span these.
    """
    spanned: list[Array] = []
    # Sine of the least angle between two normals for which a node is held along both.
    two_normals = 1e-4
    for normal in normals:
        projection = sum((basis * (basis @ normal) for basis in spanned), np.zeros(len(normal)))
        remainder = normal - projection
        size = float(np.linalg.norm(remainder))
        if size > two_normals:
            spanned.append(remainder / size)
    directions = np.linalg.qr(np.transpose(spanned), mode="complete")[0].T
    return np.asarray(directions), len(spanned)
