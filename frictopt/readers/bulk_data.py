"""Grid points, elements and properties of Nastran's bulk data."""

from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ModelError
from .deck import Deck
from .listing import deck_of_points
from .nastran_cards import Card, cards, number_in


class _Kind(NamedTuple):
    """Elements of a card: numbers of their corners and of all nodes, and their types.

    They are linear if they have corners only, and quadratic if they have all nodes.
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
# Beside solids, plane elements only name faces. In the plane, lines name boundaries.
OTHERS = {
    **dict.fromkeys(("CTRIA3", "CTRIAR"), _Kind(3, 3, "triangle")),
    **dict.fromkeys(("CQUAD4", "CQUADR"), _Kind(4, 4, "quad")),
    "CTRIA6": _Kind(3, 6, "triangle", "triangle6"),
    "CQUAD8": _Kind(4, 8, "quad", "quad8"),
    "CQUAD9": _Kind(4, 9, "quad", "quad9"),
    **dict.fromkeys(("CBAR", "CBEAM", "CROD"), _Kind(2, 2, "line")),
}
# Elements whose nodes have other places or another order, such as axisymmetric ones.
UNREAD = ("CQUAD", "CQUADX", "CQUADX4", "CQUADX8", "CTRAX3", "CTRAX6", "CTRIAX", "CTRIAX6")


def bulk_deck(file: Path, *, mesh_alone: bool = False) -> Deck:
    """Grid points and solids of bulk data.

    With `mesh_alone` the deck also has plane elements and lines, and an element set for each
    property, named by its number. Directions of displacements are then without effect, and solids
    with some of their midside nodes are refused.
    """
    kinds = SOLIDS | OTHERS if mesh_alone else SOLIDS
    found = cards(file, "deck", ("GRID", "GRDSET", *kinds, *(UNREAD if mesh_alone else ())))
    grids = [card for card in found if card.name == "GRID"]
    if not grids:
        raise ModelError(f"deck {file.name}: no GRID; give the bulk data of the job")
    # Field 2 is the system of the coordinates, field 6 that of the displacements.
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
        # Behind the nodes of plane elements and lines are angles and offsets.
        count = 2 + kind.nodes
        if card.name in SOLIDS:
            count = max(count, len(card.fields))
        number, section, *fields = map(int, _values(card, count, file))
        if mesh_alone:
            _check_nodes(fields, kind, card, file)
        nodes = [node for node in fields if node]
        if number not in nodes_of_element:
            # An element with some of its midside nodes has the name of its card: its faces are
            # not known.
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

    Nastran's elements with some of their midside nodes have other functions.
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
    """The nodes of a solid with midside nodes of upright edges last, which Nastran has earlier."""
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
    """Check that a number that is given twice is the same both times, as Nastran allows it."""
    if first != again:
        raise ModelError(
            f"deck {file.name}: two cards {card} differ; give the bulk data of one job"
        )


def _check_systems(
    grids: list[Card], defaults: list[Card], systems: tuple[int, ...], file: Path
) -> None:
    """Check that some systems of all grid points, by their fields, are the basic one.

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
