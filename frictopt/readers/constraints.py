"""Held and dependent displacements of a deck, and the unknowns that take loads on them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from ..base import ROUNDING, Array, Booleans, Integers
from ..errors import ModelError
from .deck_text import Block, entries, number


@dataclass(frozen=True, eq=False)
class Constraints:
    """Held displacements and rotations, and those that follow others.

    Unknowns 6 i to 6 i + 5 are the displacements and rotations of node i. `*BOUNDARY` holds some;
    `*EQUATION` lets some follow others.
    """

    # (nodes, 6) whether an unknown is held
    held: Booleans
    # (m, 2) an unknown that follows, and one that it follows
    ends: Integers = field(default_factory=lambda: np.zeros((0, 2), dtype=np.intp))
    # (m,) how much it follows
    weights: Array = field(default_factory=lambda: np.zeros(0))
    # keywords whose equations are not in the deck
    unresolved: tuple[str, ...] = ()

    def passed_on(self, forces: Array, present: Booleans, numbers: Integers) -> Array:
        """Forces and moments (nodes, 6), moved from unknowns that follow others to these.

        `present` (nodes, 6) are the unknowns of the matrix, `numbers` those of the nodes.
        """
        missing = ~(present | self.held).ravel()
        in_use = missing[self.ends[:, 0]]
        followers, leaders = self.ends[in_use].T
        size = forces.size
        follow = csr_matrix((self.weights[in_use], (followers, leaders)), shape=(size, size))
        follows = np.zeros(size, dtype=bool)
        follows[followers] = True

        moved = forces.ravel()
        # A chain of unknowns that follow each other has at most this length.
        for _ in followers:
            on_followers = np.where(follows, moved, 0.0)
            if not on_followers.any():
                break
            moved = np.where(follows, 0.0, moved) + follow.T @ on_followers

        lost = missing & (np.abs(moved) > ROUNDING * np.abs(forces).max(initial=0.0))
        if lost.any():
            node, axis = divmod(int(lost.argmax()), 6)
            raise ModelError(self._lost(int(numbers[node]), axis + 1))
        return np.asarray(moved.reshape(forces.shape))

    def _lost(self, node: int, direction: int) -> str:
        reason = "give the deck of the same job"
        if self.unresolved:
            reason = f"the deck has {', '.join(self.unresolved)}"
        return (
            f"force: it acts on node {node}, direction {direction}, which is neither in the "
            f"matrix nor in *BOUNDARY, and no *EQUATION determines it ({reason}); load nodes that "
            "follow no others, write the constraint as *EQUATION, or merge tied nodes"
        )

    def following(self, ends: Integers, weights: Array) -> "Constraints":
        """These constraints, with more unknowns that follow others."""
        return replace(
            self,
            ends=np.concatenate([self.ends, ends]),
            weights=np.concatenate([self.weights, weights]),
        )


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


@dataclass
class _ConstraintListing:
    """The entries of the blocks that constrain nodes."""

    row_of_node: Mapping[int, int]
    # node set or surface of nodes -> rows
    sets: Mapping[str, Integers]
    # (nodes, 6)
    held: Booleans
    terms: list[_Term] = field(default_factory=list)

    def rows(self, entry: str) -> Integers:
        """Rows of the nodes that an entry names, by a number or a set."""
        if entry.isdecimal():
            return np.array([self.row_of_node[int(entry)]])
        return self.sets[entry.upper()]


def constraints_of(
    constraint_blocks: Sequence[Block],
    row_of_node: Mapping[int, int],
    sets: Mapping[str, Integers],
) -> Constraints:
    """The constraints of a deck.

    A block that cannot be read is only named, in `unresolved`: loads may not depend on it.
    """
    held = np.zeros((len(row_of_node), 6), dtype=bool)
    listing = _ConstraintListing(row_of_node, sets, held)
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

    return Constraints(
        held,
        ends=np.array([term[:2] for term in listing.terms], dtype=np.intp).reshape(-1, 2),
        weights=np.array([term.weight for term in listing.terms]),
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


def _axes(directions: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; those beyond 6 are temperatures and the like."""
    first = directions[0]
    last = directions[1] if len(directions) > 1 and directions[1] else first
    return [axis for axis in range(int(first) - 1, int(last)) if axis < 6]


# Keyword -> the function that reads it. None: its equations are rules of the code that are not in
# the deck; a load on a node that follows is then refused by the name of the keyword.
CONSTRAINING: dict[str, Callable[[_ConstraintListing, Block], None] | None] = {
    "BOUNDARY": _boundary,
    "EQUATION": _equation,
    "RIGIDBODY": None,
    "KINEMATIC": None,
    "TIE": None,
    "MPC": None,
    "DISTRIBUTING": None,
    "DISTRIBUTINGCOUPLING": None,
    "KINEMATICCOUPLING": None,
    "CYCLICSYMMETRYMODEL": None,
    "PRE-TENSIONSECTION": None,
    "EMBEDDEDELEMENT": None,
}
