"""Keywords of decks that are read and keywords that are refused. All others have no effect.

To keep one more keyword, write its function and add a row to `KEPT`; constraints are in
`listing.py`. To refuse a keyword, add it to `REFUSED`. Then list it in `docs/formats.md`:
`tests/readers/test_formats.py` reads that page and tries each row.
"""

import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from ..base import number_of
from ..errors import ModelError, ModelWarning
from .deck import FREE, Deck, node_count
from .deck_text import Block, blocks, entries, fields, flat, number, reading
from .listing import CONSTRAINING, DeckListing, Sets

FLAT = (
    "write a flat deck, with all parts in place "
    "(Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"
)


def _nodes(listing: DeckListing, block: Block) -> None:
    """*NODE: lines of a number and its coordinates; a node may occur again."""
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


def _elements(listing: DeckListing, block: Block) -> None:
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


def _node_set(listing: DeckListing, block: Block) -> None:
    """*NSET: nodes and node sets, or first, last and step of ranges; or nodes of an element set."""
    name = block.parameters.get("NSET")
    if name and "ELSET" in block.parameters and "GENERATE" not in block.parameters:
        listing.node_sets_of_elements.append((name, block.parameters["ELSET"]))
    _add_members(listing.node_sets, name, block)


def _element_set(listing: DeckListing, block: Block) -> None:
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


def _surface(listing: DeckListing, block: Block) -> None:
    """*SURFACE: nodes, or faces of elements, or surfaces that it combines."""
    name = block.parameters["NAME"]
    unread = _unread_parameter(block.parameters)
    if unread:
        raise ValueError(f"{unread} is not read; {_NAME_FACES}")
    if not block.lines:
        listing.empty_surfaces.append(name)
        return
    if "COMBINE" in block.parameters:
        combined = [member.upper() for row in block.rows for member in row]
        listing.unions.setdefault(name, []).extend(combined)
    elif block.parameters.get("TYPE") == "NODE":
        # A weight may follow the node in its line.
        first_entries = [node for line in block.lines for node in entries(line)[:1] if node]
        listing.node_surfaces.setdefault(name, []).extend(first_entries)
    else:
        faces = [_face(line) for line in block.lines]
        listing.faces.setdefault(name, []).extend(faces)


_NAME_FACES = "name faces (S1, S2, ...) or nodes (TYPE=NODE), or remove the surface"
# Parameters by which a surface has only a part of its faces.
_CUTTING = ("TRIM", "CROP", "CUTTINGSURFACE")


def _unread_parameter(parameters: Mapping[str, str]) -> str:
    """The parameter for which a surface is not read; empty if it is read."""
    kind = parameters.get("TYPE", "ELEMENT")
    combine = parameters.get("COMBINE", "UNION")
    if kind not in ("NODE", "ELEMENT"):
        return f"TYPE={kind}"
    if combine != "UNION":
        return f"COMBINE={combine}"
    cutting = (name for name in _CUTTING if parameters.get(name, "NO") != "NO")
    return next(cutting, "")


def _face(line: str) -> tuple[str, int]:
    """Element or element set, and the number of its face; `FREE` if the line names no face."""
    where, label, *_ = [*entries(line.upper()), ""]
    if not where:
        raise ValueError(f"a line without an element set means the whole model; {_NAME_FACES}")
    if not label:
        return where, FREE
    if not re.fullmatch("S[1-6]", label):
        raise ValueError(f"{label} is no face of a solid; {_NAME_FACES}")
    return where, int(label[1:])


def _solid_section(listing: DeckListing, block: Block) -> None:
    """*SOLID SECTION: the first entry of the first line is the thickness of plane elements."""
    thickness = 1.0
    if block.lines and block.rows[0]:
        try:
            thickness = number(block.rows[0][0])
        except ValueError:
            thickness = np.nan
    listing.thicknesses.append((block.parameters["ELSET"], thickness))


def _nodal_thickness(listing: DeckListing, block: Block) -> None:
    """*NODAL THICKNESS: a thickness that varies."""
    listing.thicknesses.append((None, np.nan))


def _constraint(listing: DeckListing, block: Block) -> None:
    """A keyword of `CONSTRAINING`: it is read when all sets are known."""
    listing.constraint_blocks.append(block)


# Keyword -> the function that reads it. *INCLUDE is read with the text, see `deck_text.py`.
KEPT: dict[str, Callable[[DeckListing, Block], None]] = {
    "NODE": _nodes,
    "ELEMENT": _elements,
    "NSET": _node_set,
    "ELSET": _element_set,
    "SURFACE": _surface,
    "SOLIDSECTION": _solid_section,
    "NODALTHICKNESS": _nodal_thickness,
    **dict.fromkeys(CONSTRAINING, _constraint),
}


_DIRECTIONS = (
    "gives directions of its own; write coordinates, and the matrix, in the global directions"
)
_NOT_LISTED = f"makes or moves nodes or elements that are not listed; {FLAT}"
_CHANGES = (
    "takes elements out or puts them back; list only elements that are there, and leave it out"
)


def ways_out(names_of: Mapping[str, str]) -> dict[str, str]:
    """Name of a refused block -> what to do instead.

    Names are `KEYWORD`, `KEYWORD,PARAMETER` or `KEYWORD,PARAMETER=VALUE`. `names_of` maps each
    remedy to one text with the names of all blocks that need it.
    """
    return {name: way for way, names in names_of.items() for name in names.split()}


REFUSED = ways_out(
    {
        _DIRECTIONS: "NODE,SYSTEM=C NODE,SYSTEM=S SYSTEM TRANSFORM",
        _NOT_LISTED: (
            "NODE,INPUT NODE,OFFSET ELEMENT,INPUT ELEMENT,OFFSET NGEN NFILL NCOPY NMAP ELGEN "
            "ELCOPY IMPERFECTION IMPORT SYMMETRICMODELGENERATION REFINEMESH"
        ),
        _CHANGES: "MODELCHANGE,TYPE=ELEMENT",
    }
)
# Without data lines, these keywords end the directions that an earlier block has set.
_ENDS = ("SYSTEM", "TRANSFORM")


def way_out(block: Block, refused: Mapping[str, str]) -> str:
    """The way out in words if a block is refused; otherwise empty."""
    names = [block.keyword]
    for parameter, value in block.parameters.items():
        named = f"{block.keyword},{parameter}"
        names += [named, f"{named}={''.join(value.split())}"]
    return next((refused[name] for name in names if name in refused), "")


def read_deck(path: Path, *, mesh_alone: bool = False) -> Deck:
    """Read a deck and the files that it includes.

    With `mesh_alone`, keywords that only change the directions of loads and supports are accepted.
    meshio also reads decks, but it loses the numbers of the nodes and all blocks of nodes except
    the last, and it has no elements of plane strain.
    """
    listing = DeckListing()
    for block in acting(flat(blocks(path))):
        ends = not block.lines and block.keyword in _ENDS
        only_directions = mesh_alone and block.keyword == "TRANSFORM"
        reason = way_out(block, REFUSED)
        if reason and not ends and not only_directions:
            raise ModelError(f"{block.title} {reason}")
        if block.keyword in KEPT:
            with reading(block):
                KEPT[block.keyword](listing, block)
    for kind, numbers in (("node", listing.nodes), ("element", listing.elements)):
        largest = max(numbers, default=0)
        if largest >= 2**62:
            raise ModelError(f"deck {path.name}: the {kind} {largest} is too large; number from 1")
    if not listing.nodes:
        raise ModelError(f"deck {path.name}: no nodes; give the input deck of the job")
    if listing.empty_surfaces:
        names = ", ".join(listing.empty_surfaces)
        warnings.warn(
            f"deck {path.name}: surfaces without lines are left out: {names}; to use one, list its "
            "faces (Abaqus takes it for the outline of the whole model, CalculiX for nothing)",
            ModelWarning,
            stacklevel=3,
        )
    return listing.deck()


def acting(blocks: Iterable[Block]) -> list[Block]:
    """The blocks that act in the step that stores the matrix.

    Later steps are left out. The first `*BOUNDARY, OP=NEW` of a step removes all `*BOUNDARY` before
    it.
    """
    found: list[Block] = []
    is_stored = False
    may_remove = False
    for block in blocks:
        if block.keyword == "STEP":
            may_remove = True
        if block.keyword == "BOUNDARY" and may_remove and block.parameters.get("OP") == "NEW":
            found = [earlier for earlier in found if earlier.keyword != "BOUNDARY"]
            may_remove = False
        found.append(block)
        is_stored |= block.parameters.get("SOLVER") == "MATRIXSTORAGE"
        is_stored |= block.keyword in ("MATRIXGENERATE", "SUBSTRUCTUREGENERATE")
        if is_stored and block.keyword == "ENDSTEP":
            break
    return found
