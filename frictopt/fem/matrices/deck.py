"""Decks of CalculiX and Abaqus: nodes with their numbers, node sets, elements, element sets."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np

from ...contact.checks import Array, frozen, shown
from ...contact.show import Shown
from ...errors import ModelError
from ..ordering import Integers

__all__ = ["Deck", "read_deck", "text_of"]

Block: TypeAlias = tuple[str, dict[str, str], list[str]]  # keyword, parameters, data lines

_SHAPES = {"C3D4": "tetra", "C3D8": "hexahedron"} | {
    f"{kind}{n}": shape for kind in ("CPE", "CPS", "CAX") for n, shape in ((3, "triangle"), (4, "quad"))
}
_SOLID = re.compile(r"(C3D|CPE|CPS|CAX)(\d+)")


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
        Node set -> rows of `points`.
    elements
        For each block of elements its type, the numbers of its elements (m,), and their nodes (m, k) as rows of `points`; the numbers alone
        where the type is no solid.
    element_sets
        Element set -> numbers of elements.

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

    def _answer(self) -> Mapping[str, Any]:
        return {"nodes": len(self.numbers), "sets": sorted(self.sets), "elements": sorted({kind for kind, _, _ in self.elements})}

    def nodes(self, name: str) -> Integers:
        """Rows of `points` of the nodes of a set.

        Raises
        ------
        ModelError
            The deck has no such node set, or it is empty.
        """
        if not isinstance(name, str) or name.upper() not in self.sets:
            raise ModelError(f"node set {shown(name)}: unknown; this deck names {sorted(self.sets)}")
        if not len(self.sets[name.upper()]):
            raise ModelError(f"node set {name!r}: it has no nodes")
        return self.sets[name.upper()]

    def shaped(self) -> tuple[str, Integers, Integers]:
        """The shape that all elements have (as meshio names it), their numbers (m,) and nodes (m, k).

        Raises
        ------
        ModelError
            No elements, elements of several shapes, or others than linear triangles, quadrilaterals, tetrahedra and hexahedra.
        """
        odd = sorted({kind for kind, _, _ in self.elements if _shape(kind) is None})
        shapes = sorted({str(_shape(kind)) for kind, _, _ in self.elements})
        if odd:
            raise ModelError(f"deck: elements of type {', '.join(odd)}; give linear solids, {', '.join(_SHAPES)}")
        if len(shapes) != 1:
            raise ModelError(
                f"deck: {'no elements' if not shapes else 'elements of several shapes, ' + ', '.join(shapes)}; give elements of one shape"
            )
        numbers, nodes = zip(*((numbers, nodes) for _, numbers, nodes in self.elements), strict=True)
        return shapes[0], np.concatenate(numbers), np.concatenate(nodes)


def read_deck(path: Path) -> Deck:
    """Read a deck and the files that it includes; keywords other than nodes, elements and sets are passed over.

    meshio reads decks too, but without the numbers of the nodes, with the last block of nodes only, and no plane-strain elements.

    Raises
    ------
    ModelError
        The file is missing or is no deck, nodes numbered twice (parts and instances), sets or elements of unknown nodes, coordinates or
        displacements in directions that are not the global ones.
    """
    nodes: dict[int, list[float]] = {}
    members: dict[str, dict[str, list[str]]] = {"NSET": {}, "ELSET": {}}
    solids: list[tuple[str, list[list[int]]]] = []
    for keyword, options, lines in _blocks(path):
        if (keyword in ("SYSTEM", "TRANSFORM") and lines) or (keyword == "NODE" and options.get("SYSTEM", "R") != "R"):
            raise ModelError(
                f"deck {path.name}: the block *{keyword} {_text(options)} gives nodes or displacements in directions of their own; "
                "write coordinates, and the matrix, in the global directions"
            )
        try:
            if keyword == "NODE":
                found = [_fields(line) for line in lines]
                _add_nodes(nodes, found)
            elif keyword == "ELEMENT":
                found = _elements(options["TYPE"], lines)
                solids.append((options["TYPE"], [list(map(int, row)) for row in found]))
            elif keyword in members:
                found = _members(lines, "GENERATE" in options)
            else:
                continue
        except (KeyError, ValueError, IndexError) as error:
            raise ModelError(f"deck {path.name}: the block *{keyword} {_text(options)} cannot be read ({error}); repair it") from error
        for kind, where in (("NSET", ("NODE", "NSET")), ("ELSET", ("ELEMENT", "ELSET"))):
            if keyword in where and kind in options:
                members[kind].setdefault(options[kind], []).extend(row[0] for row in found)
    if not nodes:
        raise ModelError(f"deck {path.name}: no nodes; give the input deck of the job")
    row = {number: i for i, number in enumerate(nodes)}
    return Deck(
        numbers=_frozen(list(nodes)),
        points=frozen([(*point, 0.0, 0.0, 0.0)[:3] for point in nodes.values()]),
        sets=MappingProxyType({name: _rows(row, _resolved(members["NSET"], name), f"node set {name}") for name in members["NSET"]}),
        elements=tuple(
            (kind, _frozen([r[0] for r in rows]), _rows(row, [n for r in rows for n in r[1:]], f"elements {kind}").reshape(len(rows), -1))
            for kind, rows in solids
            if rows
        ),
        element_sets=MappingProxyType({name: _frozen(_resolved(members["ELSET"], name)) for name in members["ELSET"]}),
    )


def _blocks(path: Path, depth: int = 0) -> Iterator[Block]:
    """The blocks of a deck in order: keyword, parameters (in capitals, but for file names) and data lines."""
    block: Block | None = None
    for line in text_of(path, "deck").splitlines():
        if line.startswith("**") or not line.strip():
            continue
        if not line.startswith("*"):
            if block:
                block[2].append(line)
            continue
        if block:
            yield block
        keyword, *parameters = (part.strip() for part in line[1:].split(","))
        pairs = [part.partition("=") for part in parameters]
        block = keyword.upper(), {name.strip().upper(): value.strip().strip('"').upper() for name, _, value in pairs}, []
        if block[0] == "INCLUDE":
            if depth > 20:
                raise ModelError(f"deck {path.name}: it includes itself; take the *INCLUDE out")
            inputs = [value.strip().strip('"') for name, _, value in pairs if name.strip().upper() == "INPUT"]
            yield from _blocks(path.parent / (inputs or [""])[0], depth + 1)
    if block:
        yield block


def text_of(path: Path, what: str) -> str:
    """Text of a file.

    Raises
    ------
    ModelError
        It cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except (OSError, ValueError) as error:
        raise ModelError(f"{what}: {str(path)!r} cannot be read ({error}); give the path of a file") from error


def _shape(kind: str) -> str | None:
    match = _SOLID.match(kind)
    return _SHAPES.get(match.group()) if match else None


def _fields(line: str) -> list[str]:
    return [field.strip() for field in line.split(",") if field.strip()]


def _text(options: Mapping[str, str]) -> str:
    return ", ".join(f"{name}={value}" if value else name for name, value in options.items())


def _add_nodes(nodes: dict[int, list[float]], rows: list[list[str]]) -> None:
    for number, *point in rows:
        if int(number) in nodes:
            raise ValueError(f"node {number} is defined twice; parts and instances are not supported, write a flat deck")
        nodes[int(number)] = [float(value.upper().replace("D", "E")) for value in point]


def _elements(kind: str, lines: list[str]) -> list[list[str]]:
    """Number and nodes of each element; the number alone of an element that is no solid."""
    match = _SOLID.match(kind)
    if match is None:
        return [_fields(line)[:1] for line in lines]
    flat = [field for line in lines for field in _fields(line)]
    size = 1 + int(match[2])
    if len(flat) % size:
        raise ValueError(f"{len(flat)} numbers, {size} an element")
    return [flat[i : i + size] for i in range(0, len(flat), size)]


def _members(lines: list[str], generate: bool) -> list[list[str]]:
    """Members of a set, numbers or names of other sets."""
    if not generate:
        return [[field] for line in lines for field in _fields(line)]
    ranges = [[int(field) for field in _fields(line)] for line in lines]
    return [[str(n)] for first, last, *step in ranges for n in range(first, last + 1, *step)]


def _resolved(sets: Mapping[str, list[str]], name: str, above: tuple[str, ...] = ()) -> list[int]:
    """Numbers in a set and in the sets that it names, each once, in their order."""
    if name not in sets or name in above:
        raise ModelError(f"deck: set {above[-1]!r} names {name!r}, which is no other set; repair the deck")
    numbers: list[int] = []
    for member in sets[name]:
        numbers += [int(member)] if member.isdecimal() else _resolved(sets, member.upper(), (*above, name))
    return list(dict.fromkeys(numbers))


def _rows(row: Mapping[int, int], numbers: list[int], what: str) -> Integers:
    try:
        return _frozen([row[number] for number in numbers])
    except KeyError as error:
        raise ModelError(f"deck: {what} names node {error}, which is not defined; repair the deck") from error


def _frozen(values: Any) -> Integers:
    array = np.array(values, dtype=np.intp)
    array.flags.writeable = False
    return array
