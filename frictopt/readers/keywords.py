"""What each keyword of a deck says: a function for each, of the parameters and data lines of its block."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..base import Integers, finite_array, frozen, whole, whole_number
from ..errors import ModelError
from .constraining import CONSTRAINING, constraints_of
from .deck import FREE, Block, Deck, Faces, blocks, entries, fields, node_count, number

FLAT = "write a flat deck, all where it is (Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"
# These keywords make or move nodes and elements that the deck does not list.
MAKING = (
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "IMPERFECTION",
    "IMPORT",
    "SYMMETRICMODELGENERATION",
    "REFINEMESH",
)
TURNING = ("SYSTEM", "TRANSFORM")  # these give directions of their own
_CUTTING = (
    "TRIM",
    "CROP",
    "CUTTINGSURFACE",
)  # parameters that take a part of the faces of a surface


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
            raise ModelError(
                f"deck: node {node} has {len(read.nodes[node])} coordinates; give two or three"
            )
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
        raise ModelError(
            f"deck: {what} names node {error}, which is not defined; repair the deck"
        ) from error


def read_deck(path: Path, *, mesh_alone: bool = False) -> Deck:
    """Read a deck and the files that it includes; keywords that neither name, join nor constrain nodes are passed over.

    A mesh alone does not depend on the directions of loads and supports.
    meshio reads decks too, but without the numbers of the nodes, with the last block of nodes only,
    and no plane-strain elements.
    """
    read = _Read()
    for keyword, options, lines in blocks(path):
        said = ", ".join(f"{name}={value}" if value else name for name, value in options.items())
        start = f"deck {path.name}: the block *{keyword} {said}".rstrip()
        if not (mesh_alone and keyword == "TRANSFORM"):
            _check_listed(start, keyword, options, lines)
        try:
            if keyword in _READERS:
                _READERS[keyword](read, options, lines)
        except ModelError:
            raise
        except (KeyError, ValueError, IndexError) as error:
            raise ModelError(f"{start} cannot be read ({error}); repair it") from error
        if keyword in CONSTRAINING:
            read.constraining.append((keyword, options, lines))
    if not read.nodes:
        raise ModelError(f"deck {path.name}: no nodes; give the input deck of the job")
    return read.deck()


def _check_listed(
    start: str, keyword: str, options: Mapping[str, str], lines: Sequence[str]
) -> None:
    """Check that a block gives nodes and displacements in the global directions, and all that it makes in the deck itself."""
    if (keyword in TURNING and lines) or (keyword == "NODE" and options.get("SYSTEM", "R") != "R"):
        raise ModelError(
            f"{start} gives directions of its own; write coordinates, and the matrix, in the global directions"
        )
    moved = keyword == "INSTANCE" and re.search("[1-9]", "".join(lines))
    elsewhere = keyword in ("NODE", "ELEMENT") and ("INPUT" in options or "OFFSET" in options)
    if moved or elsewhere or keyword in MAKING:
        raise ModelError(f"{start} makes or moves nodes or elements that are not listed; {FLAT}")
    if keyword == "MODELCHANGE" and options.get("TYPE") == "ELEMENT":
        raise ModelError(
            f"{start} takes elements out or puts them back; list only elements that are there, and leave it out"
        )


@dataclass
class _Read:
    """What the blocks of a deck have given so far."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, list[int]] = field(default_factory=dict)
    solids: list[tuple[str, list[list[int]]]] = field(
        default_factory=list
    )  # of each block of elements the type, and number and nodes of each
    members: dict[str, dict[str, list[str | range]]] = field(
        default_factory=lambda: {"NSET": {}, "ELSET": {}, "SURFACE": {}}
    )
    within: list[tuple[str, str]] = field(
        default_factory=list
    )  # sets of the nodes of sets of elements
    sections: list[tuple[str, float]] = field(default_factory=list)
    faces: dict[str, list[tuple[str, int]]] = field(
        default_factory=dict
    )  # surface of elements -> set or element, and number of its face
    unions: dict[str, list[str]] = field(
        default_factory=dict
    )  # surface -> surfaces that it combines
    constraining: list[Block] = field(default_factory=list)

    def name(self, kind: str, options: Mapping[str, str], members: Iterable[str | range]) -> None:
        """Add members to the set that a block names."""
        if kind in options:
            self.members[kind].setdefault(options[kind], []).extend(members)

    def deck(self) -> Deck:
        """All of it, by rows of the nodes."""
        sets, row = self.members, {name: i for i, name in enumerate(self.nodes)}
        for name, among in self.within:
            sets["NSET"][name] += map(str, self._nodes_of(among, f"{name} of nodes"))
        nodes = {
            name: _rows(row, self._numbers("NSET", own), f"surface {name}")
            for name, own in sets["SURFACE"].items()
        }
        nodes |= {
            name: _rows(row, self._numbers("NSET", name), f"node set {name}")
            for name in sets["NSET"]
        }
        element_sets = {name: whole(self._numbers("ELSET", name)) for name in sets["ELSET"]}
        plane = [
            number
            for kind, rows in self.solids
            if kind.startswith(("CPE", "CPS"))
            for number, *_ in rows
        ]
        thick = dict.fromkeys(
            t
            for name, t in self.sections
            if plane and (not name or np.isin(element_sets.get(name, []), plane).any())
        )
        surfaces = {name: tuple(self._parts(name)) for name in (*self.faces, *self.unions)}
        points = frozen([(*point, 0.0, 0.0, 0.0)[:3] for point in self.nodes.values()])
        elements = list[tuple[str, Integers, Integers]]()
        for kind, rows in self.solids:
            own, *ends = zip(*rows, strict=True)
            elements.append(
                (
                    kind,
                    whole(own),
                    whole(
                        np.reshape(
                            [_rows(row, end, f"elements {kind}") for end in ends], (-1, len(rows))
                        ).T
                    ),
                )
            )

        def followers(elset: str) -> Integers:
            return _rows(
                row, self._nodes_of(elset, "the nodes of a rigid body"), f"element set {elset}"
            )

        constraints = constraints_of(self.constraining, row, nodes, followers, points)
        return Deck(
            whole(list(self.nodes)),
            points,
            nodes,
            tuple(elements),
            element_sets,
            tuple(thick),
            constraints,
            surfaces,
        )

    def _nodes_of(self, elset: str, what: str) -> list[int]:
        """Numbers of the nodes of the elements of a set."""
        numbers = self._numbers("ELSET", elset, (what,))
        return list(
            dict.fromkeys(node for number in numbers for node in self.elements.get(number, []))
        )

    def _numbers(
        self, kind: str, name: str | list[str | range], above: tuple[str, ...] = ()
    ) -> list[int]:
        """Numbers in a set, given by its name or by its members, and in the sets that it names, each once, in their order.

        Of a range both codes take the numbers that exist.
        """
        sets, known = self.members[kind], self.nodes if kind == "NSET" else self.elements
        if isinstance(name, str) and (name not in sets or name in above):
            who = f"set {above[-1]!r}" if above and above[-1] else "a surface"
            raise ModelError(f"deck: {who} names {name!r}, which is no other set; repair the deck")
        found, inside = list[int](), (*above, name if isinstance(name, str) else "")
        for member in sets[name] if isinstance(name, str) else name:
            if isinstance(member, range):
                found += [number for number in member if number in known]
            else:
                found += (
                    [int(member)]
                    if member.isdecimal()
                    else self._numbers(kind, member.upper(), inside)
                )
        return list(dict.fromkeys(found))

    def _parts(self, name: str, above: tuple[str, ...] = ()) -> Faces:
        """The faces of a surface of elements, and of those that it combines."""
        if name in above or (name not in self.faces and name not in self.unions):
            remedy = "write the faces of the elements (S1, S2, ...) in its place"
            raise ModelError(
                f"deck: surface {above[-1]!r} combines {name!r}, which is no other surface of elements; {remedy}"
            )
        found = list[tuple[Integers, int]]()
        for member, face in self.faces.get(name, []):
            if member.isdecimal() and int(member) not in self.elements:
                raise ModelError(
                    f"deck: surface {name} names element {member}, which is not defined; repair the deck"
                )
            found.append((whole(self._numbers("ELSET", [member])), face))
        for other in self.unions.get(name, []):
            found += self._parts(other, (*above, name))
        return tuple(found)


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
    rows = (
        _unknown_elements(lines)
        if count is None
        else [flat[i : i + 1 + count] for i in range(0, len(flat), 1 + count)]
    )
    for name, *nodes in rows:
        if int(name) in read.elements and count is not None:
            raise ValueError(f"element {name} is defined twice, as in parts and instances; {FLAT}")
        read.elements.setdefault(int(name), [int(node) for node in nodes])
    for size in dict.fromkeys(map(len, rows)):
        read.solids.append(
            (options["TYPE"], [list(map(int, row)) for row in rows if len(row) == size])
        )
    read.name("ELSET", options, [row[0] for row in rows])


def _unknown_elements(lines: Sequence[str]) -> list[list[str]]:
    """Number and nodes of elements of a type of which the number of nodes is not known: a line that ends with a comma goes on."""
    rows, goes_on = list[list[str]](), False
    for line in lines:
        if goes_on:
            rows[-1] += fields(line)
        else:
            rows.append(fields(line))
        goes_on = line.endswith(",")
    return rows


def _set(kind: str, read: _Read, options: dict[str, str], lines: list[str]) -> None:
    rows = [fields(line) for line in lines]
    if "GENERATE" in options:
        ranges = [
            range(first, last + 1, *step) for first, last, *step in (map(int, row) for row in rows)
        ]
        if odd := [
            f"{numbers.start} to {numbers.stop - 1} by {numbers.step}"
            for numbers in ranges
            if not numbers or numbers.step < 0
        ]:
            raise ValueError(f"it goes from {odd[0]}, which is not upwards")
        read.name(kind, options, ranges)
        return
    if kind == "NSET" and "ELSET" in options:
        read.within.append((options["NSET"], options["ELSET"]))
    read.name(kind, options, [member for row in rows for member in row])


def _surface(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    name, kind, combine = (
        options["NAME"],
        options.get("TYPE", "ELEMENT"),
        options.get("COMBINE", "UNION"),
    )
    remedy = "name faces (S1, S2, ...) or nodes (TYPE=NODE), or take the surface out"
    cut = [parameter for parameter in _CUTTING if options.get(parameter, "NO") != "NO"]
    if kind not in ("NODE", "ELEMENT") or combine != "UNION" or cut:
        problem = (
            f"TYPE={kind}"
            if kind not in ("NODE", "ELEMENT")
            else f"COMBINE={combine}"
            if combine != "UNION"
            else cut[0]
        )
        raise ModelError(f"deck: surface {name}: {problem} is not read; {remedy}")
    if "COMBINE" in options:
        read.unions.setdefault(name, []).extend(
            field.upper() for line in lines for field in fields(line)
        )
    elif kind == "NODE":  # a weight may follow
        read.members["SURFACE"].setdefault(name, []).extend(
            node for line in lines for node in fields(line.split(",")[0])
        )
    else:
        faces = read.faces.setdefault(name, [])
        for where, *face in map(entries, lines):
            label = face[0].upper() if face else ""
            if not where or not re.fullmatch("(S[1-6])?", label):
                problem = (
                    f"{label} is no face of a solid"
                    if where
                    else "a line without an element set stands for the whole model"
                )
                raise ModelError(f"deck: surface {name}: {problem}; {remedy}")
            faces.append((where, int(label[1:] or FREE)))
    if not lines:
        raise ModelError(
            f"deck: surface {name}: it has no lines, which stands for the whole model; {remedy}"
        )


def _section(read: _Read, options: dict[str, str], lines: list[str]) -> None:
    """The first entry of a section is the thickness of plane elements."""
    try:
        read.sections.append(
            (options["ELSET"], number((fields(lines[0]) or ["1"])[0]) if lines else 1.0)
        )
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
