"""Decks of CalculiX and Abaqus, whose grammar is one: nodes, sets and elements."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, Integers, Shown, finite_array, frozen, shown, whole, whole_array, whole_number
from ...errors import ModelError
from .constraints import CONSTRAINING, Constraints, constraints_of
from .text import FACELESS, FLAT, LINES, PLANE, PLANES, SHAPES, SOLID, SOLIDS, Block, blocks, entries, fields, node_count, number, shape_of

_MAKING = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}  # nodes and elements that the deck does not list


@dataclass(frozen=True, eq=False, repr=False)
class Deck(Shown):
    """Nodes, sets and elements of a CalculiX or Abaqus deck. Names of sets are in capital letters, for neither code tells cases apart.

    Examples
    --------
    >>> import frictopt as fo
    >>> deck = fo.read_calculix("tests/data/flat").deck
    >>> deck
    Deck(nodes=491, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'], elements=['CPE3'])
    >>> deck.numbers[deck.nodes("n_top")].tolist()
    [9, 10, 100, 101, 102, 103]
    """

    numbers: Integers  # (nodes,) of the nodes
    points: Array  # (nodes, 3) coordinates
    sets: Mapping[str, Integers]  # node set, or surface of nodes -> rows of `points`
    elements: tuple[
        tuple[str, Integers, Integers], ...
    ]  # of each block the type, the numbers (m,), and the nodes (m, k) of solids and trusses by row
    element_sets: Mapping[str, Integers]  # element set -> numbers of elements
    thicknesses: tuple[float, ...]  # different ones of the sections of plane elements; nan for one that varies
    constraints: Constraints  # displacements and rotations that are held or follow others
    surfaces: Mapping[str, tuple[tuple[Integers, int], ...]] = field(
        default_factory=dict
    )  # of elements -> numbers, and number of their face, in pairs

    def _answer(self) -> Mapping[str, object]:
        return {"nodes": len(self.numbers), "sets": sorted(self.sets), "elements": sorted({kind for kind, _, _ in self.elements})}

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Rows of `points` of the nodes of a set; or the rows that are given, each once.

        Raises
        ------
        ModelError
            The deck has no such node set, or it is empty; numbers that are no rows of `points`.
        """
        if isinstance(where, str):
            if not len(self.sets.get(where.upper(), ())):
                raise ModelError(f"node set {where!r}: unknown, or it has no nodes; this deck names {sorted({*self.sets, *self.surfaces})}")
            return self.sets[where.upper()]
        rows = whole_array("nodes", where, (None,), least=0, most=len(self.points) - 1)
        if not len(rows) or len(np.unique(rows)) != len(rows):
            raise ModelError(f"nodes: {shown(where)}; give the name of a node set or different rows of `points`")
        return rows

    @property
    def thickness(self) -> float:
        """Thickness of the plane elements; 1 if no section gives one, as in both codes.

        Raises
        ------
        ModelError
            Sections of several thicknesses, or of one that varies.
        """
        if len(self.thicknesses) > 1 or not all(0 < t < np.inf for t in self.thicknesses):
            raise ModelError(f"deck: sections of thickness {', '.join(f'{t:g}' for t in self.thicknesses)}; give all plane elements one thickness")
        return self.thicknesses[0] if self.thicknesses else 1.0

    @property
    def faces(self) -> list[tuple[Integers, Integers]]:
        """Numbers (m,) and nodes (m, k) of the elements that only name facets, block by block: in the plane lines, in space plane elements."""
        if self._in_space:
            return [(numbers, nodes) for kind, numbers, nodes in self.elements if kind.startswith(PLANES)]
        return [(numbers, nodes[:, [0, -1]]) for kind, numbers, nodes in self.elements if kind.startswith(LINES)]

    @property
    def midsides(self) -> Integers:
        """Rows of the nodes amid edges of quadratic elements."""
        found = [nodes[:, (PLANE | SOLID).get(str(shape_of(kind)), nodes.shape[1]) :].ravel() for kind, _, nodes in self.elements]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *found]))

    @property
    def _in_space(self) -> bool:
        return any(kind.startswith(SOLIDS) for kind, _, _ in self.elements)

    def shaped(self) -> tuple[str, Integers, Integers]:
        """The shape that all elements with faces have (as meshio names it), their numbers (m,) and nodes (m, k); beside solids, planes only name.

        Raises
        ------
        ModelError
            No elements, elements of several shapes, or others than triangles, quadrilaterals, tetrahedra and hexahedra, linear or quadratic.
        """
        solids = [block for block in self.elements if not block[0].startswith((*FACELESS, *PLANES) if self._in_space else FACELESS)]
        if odd := sorted({kind for kind, _, _ in solids if shape_of(kind) is None}):
            raise ModelError(f"deck: elements of type {', '.join(odd)}; give solids, {', '.join(SHAPES)} (gmsh: Mesh.SecondOrderIncomplete = 1)")
        shapes = sorted({str(shape_of(kind)) for kind, _, _ in solids})
        if len(shapes) != 1:
            raise ModelError(f"deck: {'elements of several shapes, ' * bool(shapes)}{', '.join(shapes) or 'no elements'}; give elements of one shape")
        return shapes[0], *(np.concatenate([block[i] for block in solids]) for i in (1, 2))  # type: ignore[return-value]


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
