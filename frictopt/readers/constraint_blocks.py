"""Keywords that hold displacements, or let them follow others: a function for each.

The table `CONSTRAINING` at the end names them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..base import Array, Booleans, Integers
from .constraints import Constraints
from .deck_text import Block, entries, number

# Axes that a word of *BOUNDARY holds: 0 to 2 are displacements, 3 to 5 rotations.
HELD_BY_NAME = {
    "XSYMM": [0, 4, 5],
    "YSYMM": [1, 3, 5],
    "ZSYMM": [2, 3, 4],
    "XASYMM": [1, 2, 3],
    "YASYMM": [0, 2, 4],
    "ZASYMM": [0, 1, 5],
    "PINNED": [0, 1, 2],
    "ENCASTRE": [0, 1, 2, 3, 4, 5],
}


class _Term(NamedTuple):
    """An unknown that follows another one, and how much: 6 i + k is axis k of node i."""

    follower: int
    leader: int
    weight: float


class _RigidPart(NamedTuple):
    """Nodes that follow a reference along some axes; node `rotation` moves as it turns."""

    reference: int
    rotation: int | None
    nodes: Integers
    axes: Sequence[int]


@dataclass
class _ConstraintListing:
    """The entries of the blocks that constrain nodes."""

    row_of_node: Mapping[int, int]
    # node set or surface of nodes -> rows
    sets: Mapping[str, Integers]
    # element set -> rows of the nodes of its elements
    nodes_of_elements: Callable[[str], Integers]
    # (nodes, 6)
    held: Booleans
    terms: list[_Term] = field(default_factory=list)
    rigid: list[_RigidPart] = field(default_factory=list)
    # parameters of the latest *COUPLING
    coupling: Mapping[str, str] = field(default_factory=dict)

    def rows(self, entry: str) -> Integers:
        """Rows of the nodes that an entry names, by a number or a set."""
        if entry.isdecimal():
            return np.array([self.row_of_node[int(entry)]])
        return self.sets[entry.upper()]


def constraints_of(
    constraint_blocks: Sequence[Block],
    row_of_node: Mapping[int, int],
    sets: Mapping[str, Integers],
    nodes_of_elements: Callable[[str], Integers],
    points: Array,
) -> Constraints:
    """The constraints of a deck.

    A block that cannot be read is only named, in `unresolved`: loads may not depend on it.
    """
    held = np.zeros((len(row_of_node), 6), dtype=bool)
    listing = _ConstraintListing(row_of_node, sets, nodes_of_elements, held)
    unresolved: dict[str, None] = {}
    for block in constraint_blocks:
        read = CONSTRAINING[block.keyword]
        if read is None:
            unresolved[f"*{block.keyword}"] = None
            continue
        try:
            read(listing, block)
        except (KeyError, ValueError, IndexError, ZeroDivisionError) as error:
            unresolved[f"a block *{block.keyword} that cannot be read here: {error}"] = None

    terms = list(listing.terms)
    # An equation takes precedence over a rigid part.
    in_equations = {term.follower for term in terms}
    for part in listing.rigid:
        if part.rotation is not None:
            held[part.reference, 3:] |= held[part.rotation, :3]
        terms += [
            term for term in _terms_of_part(part, points) if term.follower not in in_equations
        ]
    return Constraints(
        held,
        ends=np.array([term[:2] for term in terms], dtype=np.intp).reshape(-1, 2),
        weights=np.array([term.weight for term in terms]),
        rigid=tuple((part.reference, part.rotation) for part in listing.rigid),
        unresolved=tuple(unresolved),
    )


def _boundary(listing: _ConstraintListing, block: Block) -> None:
    """Lines of a node or set, and the first and last direction or a word."""
    for line in block.lines:
        where, *directions = entries(line)
        if directions and not directions[0].isdecimal():
            axes = HELD_BY_NAME[directions[0].upper()]
        else:
            axes = _axes(directions)
        listing.held[listing.rows(where)[:, None], axes] = True


def _equation(listing: _ConstraintListing, block: Block) -> None:
    """The number of terms of each equation, then node, direction and coefficient of each term."""
    if block.parameters:
        raise ValueError(", ".join(block.parameters))
    terms: list[_Term] = []
    unread = [entry for row in block.rows for entry in row]
    while unread:
        count = int(unread[0])
        terms += _terms_of_equation(listing, count, unread[1:])
        unread = unread[1 + 3 * count :]
    # All or none: an equation that cannot be read leaves the listing as it is.
    listing.terms += terms


def _terms_of_equation(
    listing: _ConstraintListing, count: int, unread: Sequence[str]
) -> list[_Term]:
    """The terms of an equation: the first displacement follows the others.

    If the first term names a set, each node of the set has an equation.
    """
    places = []
    weights = []
    for i in range(0, 3 * count, 3):
        places.append((listing.rows(unread[i]), int(unread[i + 1]) - 1))
        weights.append(number(unread[i + 2]))
    has_rotation = any(axis > 2 for _, axis in places)
    if has_rotation or any(len(nodes) != 1 for nodes, _ in places[1:]):
        raise ValueError("directions beyond 3, or a set of nodes that is not the first term")

    first_nodes, first_axis = places[0]
    leaders = [
        (6 * int(nodes[0]) + axis, -weight / weights[0])
        for (nodes, axis), weight in zip(places[1:], weights[1:], strict=True)
    ]
    terms: list[_Term] = []
    for node in first_nodes:
        follower = 6 * int(node) + first_axis
        # An unknown without leaders is zero.
        terms += [_Term(follower, *leader) for leader in leaders or [(follower, 0.0)]]
    return terms


def _rigid_body(listing: _ConstraintListing, block: Block) -> None:
    parameters = block.parameters
    rotation = None
    if "ROTNODE" in parameters:
        rotation = listing.row_of_node[int(parameters["ROTNODE"])]
    if "ELSET" in parameters:
        nodes = listing.nodes_of_elements(parameters["ELSET"])
    else:
        nodes = listing.sets[parameters["NSET"]]
    reference = listing.row_of_node[int(parameters["REFNODE"])]
    listing.rigid.append(_RigidPart(reference, rotation, nodes, [0, 1, 2]))


def _coupling(listing: _ConstraintListing, block: Block) -> None:
    listing.coupling = block.parameters


def _kinematic(listing: _ConstraintListing, block: Block) -> None:
    """Lines of the first and last direction that follow the reference of the *COUPLING above."""
    axes = sorted({axis for row in block.rows for axis in _axes(row) if axis < 3})
    reference = listing.row_of_node[int(listing.coupling["REFNODE"])]
    nodes = listing.sets[listing.coupling["SURFACE"]]
    listing.rigid.append(_RigidPart(reference, None, nodes, axes))


def _axes(directions: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; those beyond 6 are temperatures and the like."""
    first = directions[0]
    last = directions[1] if len(directions) > 1 and directions[1] else first
    return [axis for axis in range(int(first) - 1, int(last)) if axis < 6]


def _terms_of_part(part: _RigidPart, points: Array) -> list[_Term]:
    """Terms by which the nodes of a rigid part follow its reference.

    The displacements of the node of its rotation are the rotation of the reference.
    """
    first = 6 * part.reference
    terms: list[_Term] = []
    if part.rotation is not None:
        terms = [_Term(6 * part.rotation + axis, first + 3 + axis, 1.0) for axis in range(3)]
    arms = points[part.nodes] - points[part.reference]
    # (nodes, 3, 3) displacement of each node as the part turns about each axis
    turns = np.cross(np.eye(3), arms[:, None])
    for node, turn in zip(part.nodes.tolist(), turns, strict=True):
        if node == part.reference:
            continue
        for axis in part.axes:
            follower = 6 * node + axis
            terms.append(_Term(follower, first + axis, 1.0))
            for about, weight in enumerate(turn[:, axis].tolist()):
                if weight:
                    terms.append(_Term(follower, first + 3 + about, weight))
    return terms


# Keyword -> the function that reads it. None: its equations are rules of the code that are not in
# the deck; a load on a node that follows is then refused by the name of the keyword.
CONSTRAINING: dict[str, Callable[[_ConstraintListing, Block], None] | None] = {
    "BOUNDARY": _boundary,
    "EQUATION": _equation,
    "RIGIDBODY": _rigid_body,
    "COUPLING": _coupling,
    "KINEMATIC": _kinematic,
    "TIE": None,
    "MPC": None,
    "DISTRIBUTING": None,
    "DISTRIBUTINGCOUPLING": None,
    "KINEMATICCOUPLING": None,
    "CYCLICSYMMETRYMODEL": None,
    "PRE-TENSIONSECTION": None,
    "EMBEDDEDELEMENT": None,
}
