"""The content of the blocks of a deck, by numbers and names, and the `Deck` made from it."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..base import Booleans, Integers, finite_array, frozen, number_of, whole, whole_number
from ..errors import ModelError
from .deck import Deck, Elements
from .deck_text import Block, entries

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
# Keywords that constrain nodes. All but the first make nodes follow others: a load on a node
# that follows is refused, and the error names the keyword.
CONSTRAINING = (
    "BOUNDARY",
    "EQUATION",
    "RIGIDBODY",
    "KINEMATIC",
    "TIE",
    "MPC",
    "DISTRIBUTING",
    "DISTRIBUTINGCOUPLING",
    "KINEMATICCOUPLING",
    "CYCLICSYMMETRYMODEL",
    "PRE-TENSIONSECTION",
    "EMBEDDEDELEMENT",
)


def deck_of_points(
    points: Mapping[int, ArrayLike],
    elements: Mapping[str, list[list[int]]] = MappingProxyType({}),
    sets: Mapping[str, Sequence[int]] = MappingProxyType({}),
    element_sets: Mapping[str, Sequence[int]] = MappingProxyType({}),
) -> Deck:
    """A deck of nodes, which may also have elements and sets of both.

    `points` maps the number of a node to its coordinates, (2,) or (3,). `elements` maps a type of
    elements to the number and nodes of each element.
    """
    listing = DeckListing()
    for name, point in points.items():
        node = whole_number("deck: node", name, least=1, most=10**12)
        coordinates = finite_array(f"deck: node {node}", point, (None,)).tolist()
        if len(coordinates) not in (2, 3):
            raise ModelError(
                f"deck: node {node} has {number_of(len(coordinates), 'coordinate')}; "
                "give two or three"
            )
        listing.nodes[node] = [*coordinates, 0.0][:3]
    if not listing.nodes:
        raise ModelError("deck: no nodes; give number of a node -> its coordinates")
    listing.elements_by_type = list(elements.items())
    for set_name, nodes in sets.items():
        listing.node_sets.add(set_name, map(str, nodes))
    for set_name, members in element_sets.items():
        listing.element_sets.add(set_name, map(str, members))
    return listing.deck()


class Sets:
    """Named sets of nodes, or of elements: their members are numbers, ranges, and names of sets."""

    def __init__(self, known: Collection[int]) -> None:
        self._known = known
        self.members: dict[str, list[str | range]] = {}

    def add(self, name: str, members: Iterable[str | range]) -> None:
        """Add members to a set."""
        self.members.setdefault(name, []).extend(members)

    def numbers_in(self, name: str) -> list[int]:
        """Numbers in a set."""
        return self.numbers(self.members[name], f"set {name!r}", (name,))

    def numbers(
        self, members: Iterable[str | range], owner: str, above: tuple[str, ...] = ()
    ) -> list[int]:
        """Numbers of some members, each once, in their order.

        Error messages call the list `owner`. The list is part of the sets `above`, so it must not
        name them. Of a range, only the numbers that exist count, as in CalculiX and Abaqus.
        """
        numbers: list[int] = []
        for member in members:
            if isinstance(member, range):
                # A range of a deck may have far more numbers than exist.
                fewer, more = sorted((member, self._known), key=len)
                numbers += sorted(number for number in fewer if number in more)
            elif member.isdecimal():
                numbers.append(int(member))
            else:
                name = member.upper()
                if name not in self.members or name in above:
                    raise ModelError(
                        f"deck: {owner} names {name!r}, which is no other set; repair the deck"
                    )
                numbers += self.numbers(self.members[name], f"set {name!r}", (*above, name))
        return list(dict.fromkeys(numbers))


class DeckListing:
    """The content of the blocks of a deck.

    Blocks may use numbers and names that are listed further down; `deck` resolves them at the end.
    """

    def __init__(self) -> None:
        # number of a node -> its three coordinates
        self.nodes: dict[int, list[float]] = {}
        # number of an element -> numbers of its nodes
        self.elements: dict[int, list[int]] = {}
        # type of some elements, and a list for each (all of one length): its number and nodes
        self.elements_by_type: list[tuple[str, list[list[int]]]] = []
        self.node_sets = Sets(self.nodes)
        self.element_sets = Sets(self.elements)
        # node set, and an element set whose nodes also belong to it
        self.node_sets_of_elements: list[tuple[str, str]] = []
        # surface of nodes -> nodes and node sets
        self.node_surfaces: dict[str, list[str]] = {}
        # surface of elements -> element or element set, and the number of a face of these
        self.faces: dict[str, list[tuple[str, int]]] = {}
        # surface of elements -> surfaces that it combines
        self.unions: dict[str, list[str]] = {}
        self.empty_surfaces: list[str] = []
        # element set (None: all elements), and its thickness (nan: it varies)
        self.thicknesses: list[tuple[str | None, float]] = []
        self.constraint_blocks: list[Block] = []

    def deck(self) -> Deck:
        """The deck, with rows of nodes in place of numbers of nodes."""
        row_of_node = {node: row for row, node in enumerate(self.nodes)}
        points = frozen([*self.nodes.values()])
        sets = self._sets(row_of_node)
        held, constraints = constraints_of(self.constraint_blocks, row_of_node, sets)

        return Deck(
            numbers=whole(list(self.nodes)),
            points=points,
            sets=sets,
            elements=tuple(
                _elements(row_of_node, kind, rows) for kind, rows in self.elements_by_type
            ),
            element_sets={
                name: whole(self.element_sets.numbers_in(name))
                for name in self.element_sets.members
            },
            thicknesses=self._thicknesses_of_plane_elements(),
            held=held,
            constraints=constraints,
            surfaces={
                name: tuple(self._faces_of(name, ())) for name in (*self.faces, *self.unions)
            },
        )

    def _sets(self, row_of_node: Mapping[int, int]) -> dict[str, Integers]:
        """Rows of the nodes of each surface of nodes, and of each node set.

        A node set replaces a surface of the same name.
        """
        for name, elements in self.node_sets_of_elements:
            for number in self.element_sets.numbers([elements], f"node set {name!r}"):
                self.node_sets.add(name, map(str, self.elements.get(number, [])))
        sets = {}
        for name, members in self.node_surfaces.items():
            nodes = self.node_sets.numbers(members, "a surface")
            sets[name] = _rows(row_of_node, nodes, f"surface {name}")
        for name in self.node_sets.members:
            nodes = self.node_sets.numbers_in(name)
            sets[name] = _rows(row_of_node, nodes, f"node set {name}")
        return sets

    def _thicknesses_of_plane_elements(self) -> tuple[float, ...]:
        """Distinct thicknesses of the sections that have plane elements."""
        plane_elements = {
            number
            for kind, rows in self.elements_by_type
            if kind.startswith(("CPE", "CPS"))
            for number, *_ in rows
        }
        thicknesses = []
        for name, thickness in self.thicknesses:
            if name is None:
                members = plane_elements
            elif name in self.element_sets.members:
                members = plane_elements.intersection(self.element_sets.numbers_in(name))
            else:
                members = set()
            if members:
                thicknesses.append(thickness)
        return tuple(dict.fromkeys(thicknesses))

    def _faces_of(self, name: str, above: tuple[str, ...]) -> list[tuple[Integers, int]]:
        """The faces of a surface of elements, and of the surfaces that it combines.

        The surfaces `above` combine this surface, so it must not combine them.
        """
        if name in above or (name not in self.faces and name not in self.unions):
            raise ModelError(
                f"deck: surface {above[-1]!r} combines {name!r}, which is no other surface of "
                "elements; write the faces of the elements (S1, S2, ...) in its place"
            )
        faces = []
        for member, face in self.faces.get(name, []):
            if member.isdecimal() and int(member) not in self.elements:
                raise ModelError(
                    f"deck: surface {name} names element {member}, which is not defined; "
                    "repair the deck"
                )
            faces.append((whole(self.element_sets.numbers([member], "a surface")), face))
        for combined in self.unions.get(name, []):
            faces += self._faces_of(combined, (*above, name))
        return faces


def _elements(row_of_node: Mapping[int, int], kind: str, rows: list[list[int]]) -> Elements:
    """Elements of one type, from the number and the nodes of each."""
    nodes = [node for row in rows for node in row[1:]]
    return Elements(
        kind,
        whole([row[0] for row in rows]),
        _rows(row_of_node, nodes, f"elements {kind}").reshape(len(rows), -1),
    )


def _rows(row_of_node: Mapping[int, int], nodes: Sequence[int], what: str) -> Integers:
    try:
        return whole([row_of_node[node] for node in nodes])
    except KeyError as error:
        raise ModelError(
            f"deck: {what} names node {error}, which is not defined; repair the deck"
        ) from error


def constraints_of(
    constraint_blocks: Sequence[Block],
    row_of_node: Mapping[int, int],
    sets: Mapping[str, Integers],
) -> tuple[Booleans, tuple[str, ...]]:
    """(nodes, 6) whether each displacement and rotation is held, and keywords of other constraints.

    If a block cannot be read, only its keyword is kept, because the loads may not depend on it.
    """
    held = np.zeros((len(row_of_node), 6), dtype=bool)
    others: dict[str, None] = {}
    for block in constraint_blocks:
        if block.keyword != "BOUNDARY":
            others[f"*{block.keyword}"] = None
            continue
        try:
            for line in block.lines:
                where, *directions = entries(line)
                nodes = np.r_[row_of_node[int(where)] if where.isdecimal() else sets[where.upper()]]
                held[nodes[:, None], _axes(directions)] = True
        except (KeyError, ValueError, IndexError) as error:
            others[f"a block *BOUNDARY that cannot be read here: {error}"] = None
    return held, tuple(others)


def _axes(directions: Sequence[str]) -> list[int]:
    """Axes of a word, or of a range of directions, without temperatures (directions beyond 6)."""
    first = directions[0]
    if not first.isdecimal():
        return HELD_BY_NAME[first.upper()]
    last = directions[1] if len(directions) > 1 and directions[1] else first
    return [axis for axis in range(int(first) - 1, int(last)) if axis < 6]
