"""Keywords that list nodes, elements, sets, surfaces and sections: a function for each."""

import re

import numpy as np

from ..base import number_of
from ..errors import ModelError
from .deck import FREE
from .deck_text import Block, entries, fields, number
from .element_types import node_count
from .listing import DeckListing, Sets

FLAT = (
    "write a flat deck, with all parts in place "
    "(Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"
)


def nodes(listing: DeckListing, block: Block) -> None:
    """*NODE: lines of a number and its coordinates, also if they repeat a node."""
    numbers = []
    for line in block.lines:
        name, *listed = entries(line)
        # Coordinates that are blank or left out are zero.
        point = [number(value or "0") for value in (*listed, "", "", "")[:3]]
        first = listing.nodes.setdefault(int(name), point)
        if first != point:
            raise ValueError(
                f"node {name} is defined twice, at {tuple(first)} and at {tuple(point)}, as in "
                f"parts and instances; {FLAT}"
            )
        numbers.append(name)
    if "NSET" in block.parameters:
        listing.node_sets.add(block.parameters["NSET"], numbers)


def elements(listing: DeckListing, block: Block) -> None:
    """*ELEMENT: the number and the nodes of each element."""
    kind = block.parameters["TYPE"]
    count = node_count(kind)
    rows = _rows_of_known_type(block, count) if count else _rows_of_unknown_type(block)
    by_length: dict[int, list[list[int]]] = {}
    for row in rows:
        name, *corners = map(int, row)
        if count and name in listing.elements:
            raise ValueError(f"element {name} is defined twice, as in parts and instances; {FLAT}")
        listing.elements.setdefault(name, corners)
        by_length.setdefault(len(row), []).append([name, *corners])
    listing.elements_by_type += [(kind, same_length) for same_length in by_length.values()]
    if "ELSET" in block.parameters:
        listing.element_sets.add(block.parameters["ELSET"], [row[0] for row in rows])


def _rows_of_known_type(block: Block, count: int) -> list[list[str]]:
    """Number and `count` nodes of each element, wherever lines end."""
    flat = [entry for row in block.rows for entry in row]
    size = 1 + count
    if len(flat) % size:
        raise ValueError(f"{number_of(len(flat), 'number')}, {size} an element")
    return [flat[i : i + size] for i in range(0, len(flat), size)]


def _rows_of_unknown_type(block: Block) -> list[list[str]]:
    """Number and nodes of each element.

    A line that ends with a comma continues on the next line.
    """
    rows: list[list[str]] = []
    goes_on = False
    for line in block.lines:
        if goes_on:
            rows[-1] += fields(line)
        else:
            rows.append(fields(line))
        goes_on = line.endswith(",")
    return rows


def node_set(listing: DeckListing, block: Block) -> None:
    """*NSET: nodes and node sets, or first, last and step of ranges; or nodes of an element set."""
    name = block.parameters.get("NSET")
    if name and "ELSET" in block.parameters and "GENERATE" not in block.parameters:
        listing.node_sets_of_elements.append((name, block.parameters["ELSET"]))
    _add_members(listing.node_sets, name, block)


def element_set(listing: DeckListing, block: Block) -> None:
    """*ELSET: elements and element sets, or first, last and step of ranges."""
    _add_members(listing.element_sets, block.parameters.get("ELSET"), block)


def _add_members(sets: Sets, name: str | None, block: Block) -> None:
    if "GENERATE" in block.parameters:
        members: list[str | range] = [_range(row) for row in block.rows]
    else:
        members = [member for row in block.rows for member in row]
    if name:
        sets.add(name, members)


def _range(row: list[str]) -> range:
    first, last, *steps = map(int, row)
    step = steps[0] if steps else 1
    numbers = range(first, last + 1, step)
    if not numbers or step < 0:
        raise ValueError(f"it goes from {first} to {last} by {step}, which does not increase")
    return numbers


def surface(listing: DeckListing, block: Block) -> None:
    """*SURFACE: nodes, or faces of elements, or surfaces that it combines."""
    name = block.parameters["NAME"]
    remedy = "name faces (S1, S2, ...) or nodes (TYPE=NODE), or remove the surface"
    problem = _problem_of_surface(block)
    if problem:
        raise ModelError(f"deck: surface {name}: {problem}; {remedy}")
    if not block.lines:
        listing.empty_surfaces.append(name)
        return
    if "COMBINE" in block.parameters:
        combined = [member.upper() for row in block.rows for member in row]
        listing.unions.setdefault(name, []).extend(combined)
    elif block.parameters.get("TYPE") == "NODE":
        # A weight may follow the node.
        first_entries = [node for line in block.lines for node in entries(line)[:1] if node]
        listing.node_surfaces.setdefault(name, []).extend(first_entries)
    else:
        faces = [_face(line) for line in block.lines]
        listing.faces.setdefault(name, []).extend(faces)


# Parameters that take a part of the faces of a surface.
_CUTTING = ("TRIM", "CROP", "CUTTINGSURFACE")


def _problem_of_surface(block: Block) -> str:
    """Why a surface is not read; empty if it is."""
    parameters = block.parameters
    kind = parameters.get("TYPE", "ELEMENT")
    combine = parameters.get("COMBINE", "UNION")
    if kind not in ("NODE", "ELEMENT"):
        return f"TYPE={kind} is not read"
    if combine != "UNION":
        return f"COMBINE={combine} is not read"
    for parameter in _CUTTING:
        if parameters.get(parameter, "NO") != "NO":
            return f"{parameter} is not read"
    if kind == "NODE" or "COMBINE" in parameters:
        return ""
    return next(filter(None, map(_problem_of_face, block.lines)), "")


def _problem_of_face(line: str) -> str:
    where, *face = entries(line)
    if not where:
        return "a line without an element set means the whole model"
    if face and not re.fullmatch("(S[1-6])?", face[0].upper()):
        return f"{face[0].upper()} is no face of a solid"
    return ""


def _face(line: str) -> tuple[str, int]:
    """Element or element set, and the number of its face; all free faces if the line names none."""
    where, *face = entries(line)
    if face and face[0]:
        return where, int(face[0][1:])
    return where, FREE


def solid_section(listing: DeckListing, block: Block) -> None:
    """*SOLID SECTION: the first entry of the first line is the thickness of plane elements."""
    thickness = 1.0
    if block.lines and block.rows[0]:
        try:
            thickness = number(block.rows[0][0])
        except ValueError:
            thickness = np.nan
    listing.thicknesses.append((block.parameters["ELSET"], thickness))


def nodal_thickness(listing: DeckListing, block: Block) -> None:
    """*NODAL THICKNESS: a thickness that varies."""
    listing.thicknesses.append((None, np.nan))


def constraint(listing: DeckListing, block: Block) -> None:
    """A keyword of `CONSTRAINING`: it is read when all sets are known."""
    listing.constraint_blocks.append(block)
