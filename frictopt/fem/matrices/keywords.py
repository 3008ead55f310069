"""What each keyword of a deck says: a function for each, of the parameters and data lines of its block."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, Booleans, Integers, finite_array, frozen, whole, whole_number
from ...errors import ModelError
from .deck import Block, Constraints, Deck, blocks, entries, fields, node_count, number

Terms = list[tuple[int, int, float]]  # what follows, what leads, and the weight: 6 i + k is displacement k of node i, from 3 on its rotation
FLAT = "write a flat deck, all where it is (Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"
_MAKING = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}  # nodes and elements that the deck does not list
_HELD = {"XSYMM": [0, 4, 5], "YSYMM": [1, 3, 5], "ZSYMM": [2, 3, 4], "XASYMM": [1, 2, 3], "YASYMM": [0, 2, 4], "ZASYMM": [0, 1, 5]}
_HELD |= {"PINNED": [0, 1, 2], "ENCASTRE": [0, 1, 2, 3, 4, 5]}


def deck_of_points(
    points: Mapping[int, ArrayLike],
    solids: Mapping[str, Sequence[Sequence[int]]] = MappingProxyType({}),
    sets: Mapping[str, Sequence[int]] = MappingProxyType({}),
    held: Iterable[Sequence[int]] = (),
) -> Deck:
    """A deck from number of a node -> coordinates (2,) or (3,), type of elements -> number and nodes of each, and node, direction that is held."""
    read = _Read(solids=[(kind, [list(row) for row in rows]) for kind, rows in solids.items()])
    for name, point in points.items():
        node = whole_number("deck: node", name, least=1, most=10**12)
        read.nodes[node] = finite_array(f"deck: node {node}", point, (None,)).tolist()
        if len(read.nodes[node]) not in (2, 3):
            raise ModelError(f"deck: node {node} has {len(read.nodes[node])} coordinates; give two or three")
    if not read.nodes:
        raise ModelError("deck: no nodes; give number of a node -> its coordinates")
    read.members["NSET"] = {name: [str(node) for node in members] for name, members in sets.items()}
    deck = read.deck()
    at = {name: i for i, name in enumerate(read.nodes)}
    for name, direction in held:
        if direction <= 6 and name in at:
            deck.constraints.held[at[name], direction - 1] = True
    return deck


def _rows(row: Mapping[int, int], numbers: Sequence[int], what: str) -> Integers:
    try:
        return whole([row[number] for number in numbers])
    except KeyError as error:
        raise ModelError(f"deck: {what} names node {error}, which is not defined; repair the deck") from error


@dataclass
class _Joined:
    """What the blocks that constrain nodes have given so far; an error in one leaves the others as they are."""

    row: Mapping[int, int]
    sets: Mapping[str, Integers]
    held: Booleans
    terms: Terms = field(default_factory=list)
    rigid: list[tuple[int, int | None, Integers, list[int]]] = field(default_factory=list)
    surface: dict[str, str] = field(default_factory=dict)

    def _nodes(self, entry: str) -> Integers:
        return np.array([self.row[int(entry)]]) if entry.isdecimal() else self.sets[entry.upper()]

    def boundary(self, _: Mapping[str, str], lines: Sequence[str]) -> None:
        for line in lines:
            where, *rest = entries(line)
            axes = _HELD[rest[0].upper()] if rest and not rest[0].isdecimal() else _span(rest)
            self.held[self._nodes(where)[:, None], axes] = True

    def equation(self, options: Mapping[str, str], lines: Sequence[str]) -> None:
        """How many terms, then node, direction and coefficient of each; a set of nodes in the first term makes an equation for each."""
        if options:
            raise ValueError(", ".join(options))
        found, entries = list[tuple[int, int, float]](), [entry for line in lines for entry in fields(line)]
        while entries:
            size = 1 + 3 * int(entries[0])
            terms = [(self._nodes(entries[i]), int(entries[i + 1]) - 1, number(entries[i + 2])) for i in range(1, size, 3)]
            if any(axis > 2 for _, axis, _ in terms) or any(len(nodes) != 1 for nodes, _, _ in terms[1:]):
                raise ValueError("directions beyond 3, or a set of nodes that is not the first term")
            (first, axis, weight), *rest = terms
            leading = [(6 * int(nodes[0]) + a, -w / weight) for nodes, a, w in rest]
            found += [(6 * int(node) + axis, *lead) for node in first for lead in leading or [(6 * int(node) + axis, 0.0)]]
            entries = entries[size:]
        self.terms += found

    def rigid_body(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        rotation = self.row[int(options["ROTNODE"])] if "ROTNODE" in options else None
        self.rigid.append((self.row[int(options["REFNODE"])], rotation, self.sets[options["NSET"]], [0, 1, 2]))

    def coupling(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        self.surface = dict(options)

    def kinematic(self, _: Mapping[str, str], lines: Sequence[str]) -> None:
        axes = sorted({axis for line in lines for axis in _span(fields(line)) if axis < 3})
        self.rigid.append((self.row[int(self.surface["REFNODE"])], None, self.sets[self.surface["SURFACE"]], axes))


def _span(ends: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; temperatures and the like are none."""
    return [direction - 1 for direction in range(int(ends[0]), int(ends[1] if len(ends) > 1 and ends[1] else ends[0]) + 1) if direction <= 6]


def _turning(reference: int, rotation: int | None, nodes: Integers, axes: Sequence[int], points: Array) -> Terms:
    """Terms of a rigid part: its nodes, and the displacements of the node of its rotation, follow the reference."""
    turns = np.cross(np.eye(3), (points[nodes] - points[reference])[:, None])  # of each node, about each axis
    found = [] if rotation is None else [(6 * rotation + axis, 6 * reference + 3 + axis, 1.0) for axis in range(3)]
    for node, turn in zip(nodes.tolist(), turns, strict=True):
        for axis in axes if node != reference else ():
            found.append((6 * node + axis, 6 * reference + axis, 1.0))
            found += [(6 * node + axis, 6 * reference + 3 + about, float(weight)) for about, weight in enumerate(turn[:, axis]) if weight]
    return found


def constraints_of(found: Sequence[Block], row: Mapping[int, int], sets: Mapping[str, Integers], points: Array) -> Constraints:
    """The constraints of a deck; a block that cannot be read is one of the `others`, for it may say nothing of the loads."""
    read, others = _Joined(row, sets, np.zeros((len(row), 6), dtype=bool)), list[str]()
    for keyword, options, lines in found:
        reader = CONSTRAINING[keyword]
        try:
            others += [f"*{keyword}"] if reader is None else reader(read, options, lines) or []
        except (KeyError, ValueError, IndexError, ZeroDivisionError) as error:
            others.append(f"a block *{keyword} that cannot be read here: {error}")
    determined = {end for end, *_ in read.terms}
    for reference, rotation, nodes, axes in read.rigid:
        if rotation is not None:
            read.held[reference, 3:] |= read.held[rotation, :3]
        read.terms += [term for term in _turning(reference, rotation, nodes, axes, points) if term[0] not in determined]
    ends = np.array([term[:2] for term in read.terms], dtype=np.intp).reshape(-1, 2)
    weights = np.array([weight for *_, weight in read.terms])
    return Constraints(read.held, ends, weights, tuple(part[:2] for part in read.rigid), tuple(dict.fromkeys(others)))


CONSTRAINING: dict[str, Callable[[_Joined, Mapping[str, str], Sequence[str]], None] | None] = {
    "BOUNDARY": _Joined.boundary,
    "EQUATION": _Joined.equation,
    "RIGIDBODY": _Joined.rigid_body,
    "COUPLING": _Joined.coupling,
    "KINEMATIC": _Joined.kinematic,
    # rules of the code that are not in the deck
    **dict.fromkeys(("TIE", "MPC", "DISTRIBUTING", "DISTRIBUTINGCOUPLING", "KINEMATICCOUPLING"), None),
    **dict.fromkeys(("CYCLICSYMMETRYMODEL", "PRE-TENSIONSECTION", "EMBEDDEDELEMENT"), None),
}


def read_deck(path: Path) -> Deck:
    """Read a deck and the files that it includes; keywords that neither name, join nor constrain nodes are passed over.

    meshio reads decks too, but without the numbers of the nodes, with the last block of nodes only, and no plane-strain elements.
    """
    read = _Read()
    for keyword, options, lines in blocks(path):
        said = ", ".join(f"{name}={value}" if value else name for name, value in options.items())
        start = f"deck {path.name}: the block *{keyword} {said}".rstrip()
        _check_listed(start, keyword, options, lines)
        try:
            if keyword in _READERS:
                _READERS[keyword](read, options, lines)
        except (KeyError, ValueError, IndexError) as error:
            raise ModelError(f"{start} cannot be read ({error}); repair it") from error
        if keyword in CONSTRAINING:
            read.constraining.append((keyword, options, lines))
    if not read.nodes:
        raise ModelError(f"deck {path.name}: no nodes; give the input deck of the job")
    return read.deck()


def _check_listed(start: str, keyword: str, options: Mapping[str, str], lines: Sequence[str]) -> None:
    """Check that a block gives nodes and displacements in the global directions, and all that it makes in the deck itself."""
    if (keyword in ("SYSTEM", "TRANSFORM") and lines) or (keyword == "NODE" and options.get("SYSTEM", "R") != "R"):
        raise ModelError(f"{start} gives directions of its own; write coordinates, and the matrix, in the global directions")
    moved = keyword == "INSTANCE" and re.search("[1-9]", "".join(lines))
    if moved or keyword in _MAKING or (keyword in ("NODE", "ELEMENT") and "INPUT" in options):
        raise ModelError(f"{start} makes or moves nodes or elements that are not listed; {FLAT}")


@dataclass
class _Read:
    """What the blocks of a deck have given so far."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, list[int]] = field(default_factory=dict)  # solids and trusses
    solids: list[tuple[str, list[list[int]]]] = field(default_factory=list)  # of each block of elements the type, and number and nodes of each
    members: dict[str, dict[str, list[str]]] = field(default_factory=lambda: {"NSET": {}, "ELSET": {}, "SURFACE": {}})
    within: list[tuple[str, str]] = field(default_factory=list)  # sets of the nodes of sets of elements
    sections: list[tuple[str, float]] = field(default_factory=list)
    faces: dict[str, list[list[str]]] = field(default_factory=dict)
    constraining: list[Block] = field(default_factory=list)

    def name(self, kind: str, options: Mapping[str, str], members: Iterable[str]) -> None:
        """Add members to the set that a block names."""
        if kind in options:
            self.members[kind].setdefault(options[kind], []).extend(members)

    def deck(self) -> Deck:
        """All of it, by rows of the nodes."""
        sets, row = self.members, {name: i for i, name in enumerate(self.nodes)}
        for name, among in self.within:
            numbers = _resolved(sets["ELSET"], among, (f"{name} of nodes",))
            sets["NSET"][name] += [str(node) for number in numbers for node in self.elements.get(number, [])]
        nodes = {name: _rows(row, _resolved(sets["NSET"] | {"": own}, ""), f"surface {name}") for name, own in sets["SURFACE"].items()}
        nodes |= {name: _rows(row, _resolved(sets["NSET"], name), f"node set {name}") for name in sets["NSET"]}
        element_sets = {name: whole(_resolved(sets["ELSET"], name)) for name in sets["ELSET"]}
        plane = [number for kind, rows in self.solids if kind.startswith(("CPE", "CPS")) for number, *_ in rows]
        thick = dict.fromkeys(t for name, t in self.sections if plane and (not name or np.isin(element_sets.get(name, []), plane).any()))
        surfaces = {
            name: tuple((whole(_resolved(sets["ELSET"] | {"": row[:1]}, "")), int(row[1][1])) for row in own)
            for name, own in self.faces.items()
            if all(re.fullmatch("S[1-6]", row[-1].upper()) for row in own)  # others are surfaces of shells, or all of the outline
        }
        points = frozen([(*point, 0.0, 0.0, 0.0)[:3] for point in self.nodes.values()])
        elements = list[tuple[str, Integers, Integers]]()
        for kind, rows in self.solids:
            own, *ends = zip(*rows, strict=True)
            elements.append((kind, whole(own), whole(np.reshape([_rows(row, end, f"elements {kind}") for end in ends], (-1, len(rows))).T)))
        constraints = constraints_of(self.constraining, row, nodes, points)
        return Deck(whole(list(self.nodes)), points, nodes, tuple(elements), element_sets, tuple(thick), constraints, surfaces)


def _resolved(sets: Mapping[str, list[str]], name: str, above: tuple[str, ...] = ()) -> list[int]:
    """Numbers in a set and in the sets that it names, each once, in their order."""
    if name not in sets or name in above:
        raise ModelError(f"deck: {f'set {above[-1]!r}' if above[-1] else 'a surface'} names {name!r}, which is no other set; repair the deck")
    found = ([int(member)] if member.isdecimal() else _resolved(sets, member.upper(), (*above, name)) for member in sets[name])
    return list(dict.fromkeys(number for numbers in found for number in numbers))


def _node(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    rows = [entries(line) for line in lines]
    for name, *point in rows:
        if int(name) in read.nodes:
            raise ValueError(f"node {name} is defined twice, as in parts and instances; {FLAT}")
        read.nodes[int(name)] = [number(value or "0") for value in point]
    read.name("NSET", options, [row[0] for row in rows])


def _element(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    count, flat = node_count(options["TYPE"]), [entry for line in lines for entry in fields(line)]
    if count is not None and len(flat) % (1 + count):
        raise ValueError(f"{len(flat)} numbers, {1 + count} an element")
    rows = [fields(line)[:1] for line in lines] if count is None else [flat[i : i + 1 + count] for i in range(0, len(flat), 1 + count)]
    for name, *nodes in rows if count else ():
        if int(name) in read.elements:
            raise ValueError(f"element {name} is defined twice, as in parts and instances; {FLAT}")
        read.elements[int(name)] = [int(node) for node in nodes]
    if rows:
        read.solids.append((options["TYPE"], [list(map(int, row)) for row in rows]))
    read.name("ELSET", options, [row[0] for row in rows])


def _set(kind: str, read: _Read, options: dict[str, str], lines: list[str]) -> None:
    rows = [fields(line) for line in lines]
    if "GENERATE" in options:
        ranges = [range(first, last + 1, *step) for first, last, *step in (map(int, row) for row in rows)]
        if odd := [f"{numbers.start} to {numbers.stop - 1} by {numbers.step}" for numbers in ranges if not numbers or numbers.step < 0]:
            raise ValueError(f"it goes from {odd[0]}, which is not upwards")
        rows = [[str(n) for n in numbers] for numbers in ranges]
    if kind == "NSET" and "ELSET" in options:
        read.within.append((options["NSET"], options["ELSET"]))
    read.name(kind, options, [member for row in rows for member in row])


def _surface(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    kind = options.get("TYPE", "ELEMENT")
    if kind == "NODE":  # a weight may follow
        read.members["SURFACE"][options["NAME"]] = [node for line in lines for node in fields(line.split(",")[0])]
    elif kind == "ELEMENT":
        read.faces.setdefault(options["NAME"], []).extend(row for row in map(fields, lines) if row)


def _section(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    """The first entry of a section is the thickness of plane elements."""
    try:
        read.sections.append((options["ELSET"], number((fields(lines[0]) or ["1"])[0]) if lines else 1.0))
    except ValueError:
        read.sections.append((options["ELSET"], np.nan))


_READERS: dict[str, Callable[[_Read, dict[str, str], list[str]], None]] = {
    "NODE": _node,
    "ELEMENT": _element,
    "NSET": lambda *block: _set("NSET", *block),
    "ELSET": lambda *block: _set("ELSET", *block),
    "SURFACE": _surface,
    "SOLIDSECTION": _section,
    "NODALTHICKNESS": lambda read, *_: read.sections.append(("", np.nan)),
}
