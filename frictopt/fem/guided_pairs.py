"""Pairs that supports guide: the axes along which they cannot slip, and their normals.

On a plane of symmetry, supports hold the nodes of both bodies across the plane, so that a pair
there slips in the plane only.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import csr_matrix

from ..base import Array, Booleans, Integers, number_of
from ..errors import ModelError


def guided_pairs(
    nodes: Integers,
    opening: csr_matrix,
    unknowns: Integers,
    normals: Array,
    points: Array,
    errors: Array,
) -> tuple[Array, csr_matrix]:
    """Find the axes along which pairs cannot slip, and the nodes that can be dependent.

    Returned are the normals (N, d) without their parts along these axes, of any length, and the
    candidates (N, all nodes), the entries of M at nodes that can be the dependent node of their
    pair.

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
    """
    links = opening.tocoo()  # one link for each node of a pair: `row` is the pair, `col` the node
    held = (unknowns < 0)[links.col]

    def any_link(flags: Booleans) -> Booleans:
        """(N, d) whether flags (links, d) hold for any node of a pair."""
        count = len(nodes)
        return np.column_stack(
            [np.bincount(links.row, flag, minlength=count) > 0 for flag in flags.T]
        )

    # Distance (links, d) of each node from the plane across each axis through the node of body 1.
    first = nodes[links.row]
    distance = points[links.col] - points[first]
    error = 2 * (errors[links.col] + errors[first])
    on_plane = held & (np.abs(distance) <= error)
    below = any_link(~on_plane & (distance <= error))
    above = any_link(~on_plane & (distance >= -error))
    of_body_2 = (links.data < 0)[:, None]
    is_symmetric = ~(below & above) & any_link(on_plane & of_body_2)
    across = ~any_link(~held) | is_symmetric

    lengths_in_plane = np.linalg.norm(np.where(across, 0.0, normals), axis=1)
    # Least share of a normal that lies in a plane of symmetry. The normal at an edge may lean out
    # of the plane by half the angle of the facet beside it.
    least_share = 0.5
    across &= (lengths_in_plane > least_share * np.linalg.norm(normals, axis=1))[:, None]

    slips = ~across[links.row]
    held_against_slip = links.col[(held & slips).any(axis=1)]
    is_candidate = (held != slips).all(axis=1) & ~np.isin(links.col, held_against_slip)
    entries = (links.data[is_candidate], (links.row[is_candidate], links.col[is_candidate]))
    return np.where(across, 0.0, normals), csr_matrix(entries, shape=opening.shape)


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
