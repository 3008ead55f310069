"""Grid points, elements and properties of Nastran's bulk data."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ModelError
from .deck import Deck
from .deck_text import check_includes, text_of
from .listing import deck_of_points

_INCLUDE = re.compile(r"\s*include\s+(.*)", re.IGNORECASE)


@dataclass(frozen=True)
class Card:
    """A card: its name in capital letters, and its fields, of which the last is not blank."""

    name: str
    fields: list[str]

    def field(self, place: int) -> str:
        """A field, counted from 1 after the name; empty if it is blank."""
        return self.fields[place - 1] if place <= len(self.fields) else ""

    def __str__(self) -> str:
        return f"{self.name} {self.field(1)}".rstrip()


@dataclass(frozen=True)
class Line:
    """A line: its first field, its data fields, its last field, and what follows the fields."""

    first: str
    data: list[str]
    last: str
    rest: str

    @property
    def name(self) -> str:
        """Name of the card that begins here, in capital letters; empty for a continued card."""
        return "" if self.first[:1] in ("", "+", "*") else self.first.rstrip("*").upper()


def cards(path: Path, what: str, names: tuple[str, ...]) -> list[Card]:
    """The cards of some names in a file of bulk data and in the files that it includes.

    Everything before `BEGIN BULK` and after `ENDDATA` is left out.
    """
    where = f"{what} {path.name}"
    found: list[Card] = []
    card: Card | None = None
    previous = Line("", [], "", "")
    for text in _bulk_data(list(_lines(path, what, path.parent, [])), where):
        line = split(text)
        if line.first.startswith("="):
            raise ModelError(f"{where}: the line {text!r} repeats the card above; write each card")
        if line.name:
            card = Card(line.name, [])
            found.append(card)
        elif line.first[1:] not in ("", previous.last[1:]):
            raise ModelError(
                f"{where}: the line {text!r} does not continue the line above it; sort the lines"
            )
        elif "*" in previous.first and not line.first:
            # Lines of results in a punch file begin with blanks.
            card = None
        if card is None:
            continue
        card.fields.extend(line.data)
        if line.rest and card.name in names:
            raise ModelError(
                f"{where}: {card} has a line of more than ten fields, {text!r}; "
                "continue it on the next line"
            )
        previous = line
    return [_without_blanks_at_end(card) for card in found if card.name in names]


def _without_blanks_at_end(card: Card) -> Card:
    count = max((i for i, field in enumerate(card.fields, start=1) if field), default=0)
    return Card(card.name, card.fields[:count])


def split(text: str) -> Line:
    """The fields of a line.

    A line with a comma has free fields. Otherwise a field has 8 characters, or 16 if the first
    field has an asterisk.
    """
    has_commas = "," in text
    first = (text.split(",")[0] if has_commas else text[:8]).strip()
    count = 4 if "*" in first else 8
    if has_commas:
        fields = [field.strip() for field in text.split(",")[1:]]
    else:
        width = 64 // count
        starts = range(8, 72, width)
        fields = [text[start : start + width].strip() for start in starts] + [text[72:80].strip()]
    fields += [""] * (count + 1 - len(fields))
    rest = "".join(fields[count + 1 :])
    return Line(first, fields[:count], fields[count], rest)


def _bulk_data(lines: list[str], where: str) -> list[str]:
    """The lines after `BEGIN BULK`, if there is one, as far as `ENDDATA`."""
    words = [line.split(maxsplit=1)[0].upper() for line in lines]
    end = words.index("ENDDATA") if "ENDDATA" in words else len(lines)
    begins = [i for i in range(end) if words[i] == "BEGIN"]
    if len(begins) > 1:
        raise ModelError(
            f"{where}: several parts, which may use the same numbers: "
            f"{', '.join(lines[i].strip() for i in begins)}; give the bulk data of one part"
        )
    return lines[begins[0] + 1 if begins else 0 : end]


def _lines(
    path: Path, what: str, root: Path, included_files: list[str], depth: int = 0
) -> Iterator[str]:
    """The lines of a file without comments; included lines take the place of their INCLUDE."""
    check_includes(path, what, included_files, depth)
    if not path.is_file():
        raise ModelError(f"{what}: there is no file {str(path)!r}; give its path")
    lines = iter(text_of(path, what).expandtabs().splitlines())
    for line in lines:
        include = _INCLUDE.match(line)
        if include is None:
            card = line.partition("$")[0].rstrip()
            if card:
                yield card
            continue
        name = _included_file(include[1], lines)
        # A name is relative to the file that includes; with folders, it may be relative to the
        # first file.
        beside = path.parent / name
        file = beside if beside.is_file() else root / name
        yield from _lines(file, what, root, included_files, depth + 1)


def _included_file(words: str, lines: Iterator[str]) -> str:
    """The name of an included file; a name in quotes may continue on the next lines."""
    quote = words[0]
    if quote not in "'\"":
        return words.partition("$")[0].strip()
    name = words[1:].strip()
    while quote not in name:
        following = next(lines, quote)
        name += following.strip()
    return name.partition(quote)[0]


def number_in(field: str) -> float:
    """The value of a field, such as 1.5, 1.5E-3, 1.5D-3 or 1.5-3; 0 if it is blank."""
    text = (field or "0").upper().replace("D", "E")
    return float(re.sub(r"(?<=[\d.])(?=[+-])", "E", text))


def free_fields(bulk: list[Card]) -> str:
    """The text of cards in free fields, eight on a line."""
    lines = []
    for card in bulk:
        for i in range(0, len(card.fields), 8):
            name = card.name if i == 0 else ""
            lines.append(",".join([name, *card.fields[i : i + 8]]))
    return "\n".join(lines) + "\n"


class _Kind(NamedTuple):
    """Elements of a card: how many corners and how many nodes they have, and their types.

    The elements are linear if they have only their corners, and quadratic if they have all nodes.
    """

    corners: int
    nodes: int
    linear: str
    quadratic: str = ""


SOLIDS = {
    "CHEXA": _Kind(8, 20, "C3D8", "C3D20"),
    "CPENTA": _Kind(6, 15, "C3D6", "C3D15"),
    **dict.fromkeys(("CPYRAM", "CPYRA"), _Kind(5, 13, "C3D5", "CPYRAM13")),
    "CTETRA": _Kind(4, 10, "C3D4", "C3D10"),
}
# If there are solids, plane elements only name faces. In the plane, lines name boundaries.
OTHERS = {
    **dict.fromkeys(("CTRIA3", "CTRIAR"), _Kind(3, 3, "triangle")),
    **dict.fromkeys(("CQUAD4", "CQUADR"), _Kind(4, 4, "quad")),
    "CTRIA6": _Kind(3, 6, "triangle", "triangle6"),
    "CQUAD8": _Kind(4, 8, "quad", "quad8"),
    "CQUAD9": _Kind(4, 9, "quad", "quad9"),
    **dict.fromkeys(("CBAR", "CBEAM", "CROD"), _Kind(2, 2, "line")),
}
# Elements whose nodes have other places or another order, such as axisymmetric elements.
UNREAD = ("CQUAD", "CQUADX", "CQUADX4", "CQUADX8", "CTRAX3", "CTRAX6", "CTRIAX", "CTRIAX6")


def bulk_deck(file: Path, *, mesh_alone: bool = False) -> Deck:
    """Grid points and solids of bulk data.

    With `mesh_alone` the deck also has plane elements and lines, and an element set for each
    property, named by its number. Directions of displacements then have no effect, and solids
    with only some of their midside nodes are refused.
    """
    kinds = SOLIDS | OTHERS if mesh_alone else SOLIDS
    found = cards(file, "deck", ("GRID", "GRDSET", *kinds, *(UNREAD if mesh_alone else ())))
    grids = [card for card in found if card.name == "GRID"]
    if not grids:
        raise ModelError(f"deck {file.name}: no GRID; give the bulk data of the job")
    # Field 2 is the system of the coordinates, field 6 the system of the displacements.
    systems = (2,) if mesh_alone else (2, 6)
    _check_systems(grids, [card for card in found if card.name == "GRDSET"], systems, file)

    nodes_of_element: dict[int, list[int]] = {}
    elements: dict[str, list[list[int]]] = defaultdict(list)
    properties: dict[str, list[int]] = defaultdict(list)
    for card in found:
        if card.name in UNREAD:
            raise ModelError(
                f"deck {file.name}: {card} is not read; give a mesh of solids, or a plane mesh of "
                "CTRIA3, CTRIA6, CQUAD4 or CQUAD8"
            )
        kind = kinds.get(card.name)
        if kind is None:
            continue
        # The nodes of plane elements and lines are followed by angles and offsets.
        count = 2 + kind.nodes
        if card.name in SOLIDS:
            count = max(count, len(card.fields))
        number, section, *fields = map(int, _values(card, count, file))
        if mesh_alone:
            _check_nodes(fields, kind, card, file)
        nodes = [node for node in fields if node]
        if number not in nodes_of_element:
            # An element with only some of its midside nodes gets the name of its card as type: its
            # faces are not known.
            names = {kind.nodes: kind.quadratic, kind.corners: kind.linear}
            name = names.get(len(nodes), f"{card.name}{len(nodes)}")
            elements[name].append([number, *_upper_edges_first(nodes)])
            # The number of the element is the default of its property.
            properties[str(section or number)].append(number)
        _check_same(nodes_of_element.setdefault(number, nodes), nodes, card, file)
    return deck_of_points(
        _grid_points(grids, file),
        elements=elements,
        element_sets=properties if mesh_alone else {},
    )


def _check_nodes(fields: list[int], kind: _Kind, card: Card, file: Path) -> None:
    """Check that an element has all its corners, and all of its midside nodes or none.

    In Nastran, elements with only some of their midside nodes have other shape functions.
    """
    count = kind.nodes if any(fields[kind.corners :]) else kind.corners
    if 0 in fields[:count]:
        place = fields.index(0) + 1
        lacking = "midside node" if place > kind.corners else "corner"
        raise ModelError(
            f"deck {file.name}: {card} has no node at place {place} of {count}, a {lacking}; give "
            "each element all of its corners, and all of its midside nodes or none"
        )


def _grid_points(grids: list[Card], file: Path) -> dict[int, list[float]]:
    """Number -> coordinates of the grid points."""
    points: dict[int, list[float]] = {}
    for card in grids:
        # Field 2 is the system of the coordinates.
        number, _, *point = _values(card, 5, file)
        _check_same(points.setdefault(int(number), point), point, card, file)
    return points


def _upper_edges_first(nodes: list[int]) -> list[int]:
    """The nodes of a solid, with midside nodes of upright edges last; Nastran has them earlier."""
    if len(nodes) == 20:
        return [*nodes[:12], *nodes[16:], *nodes[12:16]]
    if len(nodes) == 15:
        return [*nodes[:9], *nodes[12:], *nodes[9:12]]
    return nodes


def _values(card: Card, count: int, file: Path) -> list[float]:
    """The first fields of a card as numbers; blank fields are 0."""
    try:
        return [number_in(card.field(place)) for place in range(1, count + 1)]
    except ValueError as error:
        raise ModelError(
            f"deck {file.name}: the card {card} cannot be read ({error}); repair it"
        ) from error


def _check_same(first: list[Any], again: list[Any], card: Card, file: Path) -> None:
    """Check that two cards with one number are the same; a card may be repeated."""
    if first != again:
        raise ModelError(
            f"deck {file.name}: two cards {card} differ; give the bulk data of one job"
        )


def _check_systems(
    grids: list[Card], defaults: list[Card], systems: tuple[int, ...], file: Path
) -> None:
    """Check that the fields `systems` of all grid points name the basic system.

    GRDSET gives the systems that a GRID leaves blank.
    """
    for place in systems:
        default = next(filter(None, (card.field(place) for card in defaults)), "")
        for card in grids:
            system = card.field(place) or default
            if system not in ("", "0"):
                source = "GRID" if card.field(place) else "GRDSET"
                raise ModelError(
                    f"deck {file.name}: grid point {card.field(1)} has coordinates or "
                    f"displacements in system {system}, by its {source}; write all in the basic one"
                )
