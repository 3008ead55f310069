"""Decks of CalculiX and Abaqus: nodes with their numbers, node sets, elements, element sets, constraints."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, Integers, Shown, finite_array, frozen, shown, whole, whole_array, whole_number
from ...errors import ModelError
from .constraints import CONSTRAINING, Constraints, constraints_of
from .kinds import FACELESS, LINES, PLANE, PLANES, SHAPES, SOLID, SOLIDS, shape_of
from .text import FLAT, Block, blocks, check_listed, elements_of, entries, fields, members_of, number, parameters, thickness

Solids: TypeAlias = list[tuple[str, list[list[int]]]]  # blocks of elements: their type, and number and nodes of each


@dataclass(frozen=True, eq=False, repr=False)
class Deck(Shown):
    """Nodes, sets and elements of a CalculiX or Abaqus deck. Names of sets are in capital letters, for neither code tells cases apart.

    Parameters
    ----------
    numbers
        (nodes,) numbers of the nodes.
    points
        (nodes, 3) coordinates.
    sets
        Node set, or surface of nodes -> rows of `points`.
    elements
        For each block of elements its type, the numbers of its elements (m,), and their nodes (m, k) as rows of `points`; the numbers alone
        where the type is neither solid nor truss.
    element_sets
        Element set -> numbers of elements.
    surfaces
        Surface of elements -> numbers of elements and the number of their face, in pairs.
    thicknesses
        Different thicknesses of the sections of plane elements; nan for one that varies.
    constraints
        Displacements and rotations that are held or follow others.

    Examples
    --------
    >>> import frictopt as fo
    >>> deck = fo.read_calculix("tests/data/flat").deck
    >>> deck
    Deck(nodes=491, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH', 'N_PUNCH', 'N_TOP'], elements=['CPE3'])
    >>> deck.numbers[deck.nodes("n_top")].tolist()
    [9, 10, 100, 101, 102, 103]
    """

    numbers: Integers
    points: Array
    sets: Mapping[str, Integers]
    elements: tuple[tuple[str, Integers, Integers], ...]
    element_sets: Mapping[str, Integers]
    thicknesses: tuple[float, ...]
    constraints: Constraints
    surfaces: Mapping[str, tuple[tuple[Integers, int], ...]] = field(default_factory=dict)

    def _answer(self) -> Mapping[str, object]:
        return {"nodes": len(self.numbers), "sets": sorted(self.sets), "elements": sorted({kind for kind, _, _ in self.elements})}

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Rows of `points` of the nodes of a set; or the rows that are given, each once.

        Raises
        ------
        ModelError
            The deck has no such node set, or it is empty; numbers that are no rows of `points`.
        """
        if not isinstance(where, str):
            rows = whole_array("nodes", where, (None,), least=0, most=len(self.points) - 1)
            if not len(rows) or len(np.unique(rows)) != len(rows):
                raise ModelError(f"nodes: {shown(where)}; give the name of a node set or different rows of `points`")
            return rows
        if not len(self.sets.get(where.upper(), ())):
            raise ModelError(f"node set {where!r}: unknown, or it has no nodes; this deck names {sorted({*self.sets, *self.surfaces})}")
        return self.sets[where.upper()]

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
        odd = sorted({kind for kind, _, _ in solids if shape_of(kind) is None})
        shapes = sorted({str(shape_of(kind)) for kind, _, _ in solids})
        if odd:
            raise ModelError(f"deck: elements of type {', '.join(odd)}; give solids, {', '.join(SHAPES)} (gmsh: Mesh.SecondOrderIncomplete = 1)")
        if len(shapes) != 1:
            raise ModelError(f"deck: {'elements of several shapes, ' * bool(shapes)}{', '.join(shapes) or 'no elements'}; give elements of one shape")
        numbers, nodes = zip(*((numbers, nodes) for _, numbers, nodes in solids), strict=True)
        return shapes[0], np.concatenate(numbers), np.concatenate(nodes)


def deck_of_points(
    points: Mapping[int, ArrayLike],
    *,
    solids: Mapping[str, Sequence[Sequence[int]]] = MappingProxyType({}),
    sets: Mapping[str, Sequence[int]] = MappingProxyType({}),
    held: Iterable[Sequence[int]] = (),
) -> Deck:
    """A deck from number of a node -> coordinates (2,) or (3,).

    Parameters
    ----------
    points
        The nodes.
    solids
        Type of elements -> number and nodes of each.
    sets
        Node set -> nodes.
    held
        Node and direction, 1 to 6, of displacements and rotations that are held; those of other nodes are passed over.

    Raises
    ------
    ModelError
        No nodes, numbers that are not positive integers, coordinates of another shape or not finite, elements of unknown nodes.
    """
    if not points:
        raise ModelError("deck: no nodes; give number of a node -> its coordinates")
    where = np.zeros((len(points), 3))
    for i, (name, point) in enumerate(points.items()):
        place = finite_array(f"deck: node {whole_number('deck: node', name, least=1, most=10**12)}", point, (None,))
        if len(place) not in (2, 3):
            raise ModelError(f"deck: node {name} has {len(place)} coordinates; give two or three")
        where[i, : len(place)] = place
    row = {name: i for i, name in enumerate(points)}
    fixed = np.zeros((len(points), 6), dtype=bool)
    for name, direction in held:
        if direction <= 6 and name in row:
            fixed[row[name], direction - 1] = True
    nodes = {name: _rows(row, members, f"node set {name}") for name, members in sets.items()}
    return Deck(whole(list(points)), frozen(where), nodes, _with_nodes(solids.items(), row), {}, (), Constraints(fixed))


def _with_nodes(solids: Iterable[tuple[str, Sequence[Sequence[int]]]], row: Mapping[int, int]) -> tuple[tuple[str, Integers, Integers], ...]:
    """Elements of each block: type, numbers, and rows of their nodes."""
    return tuple(
        (kind, whole([r[0] for r in rows]), _rows(row, [n for r in rows for n in r[1:]], f"elements {kind}").reshape(len(rows), -1))
        for kind, rows in solids
        if rows
    )


def _of_plane(sections: list[tuple[str, float]], solids: Solids, sets: Mapping[str, Integers]) -> tuple[float, ...]:
    """Thicknesses of the sections that hold plane elements."""
    plane = [n for kind, rows in solids if kind.startswith(("CPE", "CPS")) for n, *_ in rows]
    return tuple(dict.fromkeys(t for name, t in sections if plane and (not name or np.isin(sets.get(name, []), plane).any())))


@dataclass
class _Read:
    """What the blocks of a deck have given so far."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    members: dict[str, dict[str, list[str]]] = field(default_factory=lambda: {"NSET": {}, "ELSET": {}, "SURFACE": {}})
    solids: Solids = field(default_factory=list)
    within: list[tuple[str, str]] = field(default_factory=list)
    sections: list[tuple[str, float]] = field(default_factory=list)
    constraining: list[Block] = field(default_factory=list)
    faces: dict[str, list[list[str]]] = field(default_factory=dict)

    def add(self, keyword: str, options: dict[str, str], lines: list[str]) -> None:
        """Take what a block gives; KeyError, ValueError or IndexError if it cannot be read."""
        found: list[list[str]] = []
        if keyword == "NODE":
            _add_nodes(self.nodes, found := [entries(line) for line in lines])
        elif keyword == "ELEMENT":
            found = elements_of(options["TYPE"], lines)
            self.solids.append((options["TYPE"], [list(map(int, row)) for row in found]))
        elif keyword in ("NSET", "ELSET"):
            found = members_of(lines, "GENERATE" in options)
            self.within += [(options["NSET"], options["ELSET"])] if keyword == "NSET" and "ELSET" in options else []
        elif keyword == "SURFACE" and options.get("TYPE") == "NODE":
            own = members_of([line.split(",")[0] for line in lines], False)  # a weight may follow
            self.members["SURFACE"][options["NAME"]] = [row[0] for row in own]
        elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT") == "ELEMENT":
            self.faces.setdefault(options["NAME"], []).extend(row for row in map(fields, lines) if row)
        elif keyword in ("SOLIDSECTION", "NODALTHICKNESS"):
            self.sections.append((options["ELSET"], thickness(lines)) if keyword == "SOLIDSECTION" else ("", np.nan))
        elif keyword in CONSTRAINING:
            self.constraining.append((keyword, options, lines))
        for kind, first in (("NSET", "NODE"), ("ELSET", "ELEMENT")):
            if keyword in (kind, first) and kind in options:
                self.members[kind].setdefault(options[kind], []).extend(row[0] for row in found)


def read_deck(path: Path) -> Deck:
    """Read a deck and the files that it includes; keywords that neither name, join nor constrain nodes are passed over.

    meshio reads decks too, but without the numbers of the nodes, with the last block of nodes only, and no plane-strain elements.

    Raises
    ------
    ModelError
        The file is missing or is no deck, nodes or elements that are numbered twice (parts and instances), generated, moved or
        read from elsewhere, sets or elements of unknown nodes, coordinates or displacements in directions that are not the global ones.
    """
    read = _Read()
    for keyword, options, lines in blocks(path):
        check_listed(path, keyword, options, lines)
        try:
            read.add(keyword, options, lines)
        except (KeyError, ValueError, IndexError) as error:
            raise ModelError(f"deck {path.name}: the block *{keyword} {parameters(options)} cannot be read ({error}); repair it") from error
    nodes, members, solids = read.nodes, read.members, read.solids
    if not nodes:
        raise ModelError(f"deck {path.name}: no nodes; give the input deck of the job")
    row = {name: i for i, name in enumerate(nodes)}
    listed = {number: nodes for _, rows in solids for number, *nodes in rows if nodes}
    if twice := sum(bool(row[1:]) for _, rows in solids for row in rows) - len(listed):
        raise ModelError(f"deck {path.name}: {twice} numbers of elements are given twice, as in parts and instances; {FLAT}")
    for name, elements in read.within:
        numbers = _resolved(members["ELSET"], elements, (f"{name} of nodes",))
        members["NSET"][name] += [str(node) for number in numbers for node in listed.get(number, [])]
    sets = {name: _rows(row, _resolved(members["NSET"], name), f"node set {name}") for name in members["NSET"]}
    element_sets = {name: whole(_resolved(members["ELSET"], name)) for name in members["ELSET"]}
    surfaces = {name: _rows(row, _resolved(members["NSET"] | {"": own}, ""), f"surface {name}") for name, own in members["SURFACE"].items()}
    points = frozen([(*point, 0.0, 0.0, 0.0)[:3] for point in nodes.values()])
    return Deck(
        numbers=whole(list(nodes)),
        points=points,
        sets=surfaces | sets,
        elements=_with_nodes(solids, row),
        element_sets=element_sets,
        thicknesses=_of_plane(read.sections, solids, element_sets),
        constraints=constraints_of(read.constraining, row, sets | surfaces, points),
        surfaces={
            name: tuple((whole(_resolved(members["ELSET"] | {"": row[:1]}, "")), int(row[1][1])) for row in own)
            for name, own in read.faces.items()
            if all(re.fullmatch("S[1-6]", row[-1].upper()) for row in own)  # others are surfaces of shells, or all of the outline
        },
    )


def _add_nodes(nodes: dict[int, list[float]], rows: list[list[str]]) -> None:
    for name, *point in rows:
        if int(name) in nodes:
            raise ValueError(f"node {name} is defined twice, as in parts and instances; {FLAT}")
        nodes[int(name)] = [number(value or "0") for value in point]


def _resolved(sets: Mapping[str, list[str]], name: str, above: tuple[str, ...] = ()) -> list[int]:
    """Numbers in a set and in the sets that it names, each once, in their order."""
    if name not in sets or name in above:
        raise ModelError(f"deck: {f'set {above[-1]!r}' if above[-1] else 'a surface'} names {name!r}, which is no other set; repair the deck")
    numbers: list[int] = []
    for member in sets[name]:
        numbers += [int(member)] if member.isdecimal() else _resolved(sets, member.upper(), (*above, name))
    return list(dict.fromkeys(numbers))


def _rows(row: Mapping[int, int], numbers: Sequence[int], what: str) -> Integers:
    try:
        return whole([row[number] for number in numbers])
    except KeyError as error:
        raise ModelError(f"deck: {what} names node {error}, which is not defined; repair the deck") from error
