"""Keywords of decks that are read and keywords that are refused. All others have no effect.

To keep one more keyword, write its function in `keyword_blocks.py` and add a row to `KEPT`. If it
constrains nodes, its function and row are in `constraints.py`. To refuse a keyword, add a row
to `REFUSED`. Then list it in `docs/formats.md`: `tests/readers/test_formats.py` reads that page and
tries each row.
"""

import re
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from ..errors import ModelError, ModelWarning
from . import keyword_blocks as read
from .constraints import CONSTRAINING
from .deck import Deck
from .deck_text import Block, blocks
from .instances import flat
from .listing import DeckListing

# Keyword -> the function that reads it. *INCLUDE is read with the text, see `deck_text.py`.
KEPT: dict[str, Callable[[DeckListing, Block], None]] = {
    "NODE": read.nodes,
    "ELEMENT": read.elements,
    "NSET": read.node_set,
    "ELSET": read.element_set,
    "SURFACE": read.surface,
    "SOLIDSECTION": read.solid_section,
    "NODALTHICKNESS": read.nodal_thickness,
    **dict.fromkeys(CONSTRAINING, read.constraint),
}


class Refusal(NamedTuple):
    """A keyword that is refused if `is_refused` holds for its block.

    With `in_meshes` it is refused also if only a mesh is read.
    """

    keyword: str
    is_refused: Callable[[Block], object]
    reason: str
    in_meshes: bool = True


def _always(_: Block) -> bool:
    return True


def _has_lines(block: Block) -> bool:
    return bool(block.lines)


def _has_own_system(block: Block) -> bool:
    return block.parameters.get("SYSTEM", "R") != "R"


def _is_elsewhere(block: Block) -> bool:
    return "INPUT" in block.parameters or "OFFSET" in block.parameters


def _changes_elements(block: Block) -> bool:
    return block.parameters.get("TYPE") == "ELEMENT"


_DIRECTIONS = (
    "gives directions of its own; write coordinates, and the matrix, in the global directions"
)
_NOT_LISTED = f"makes or moves nodes or elements that are not listed; {read.FLAT}"
_CHANGES = (
    "takes elements out or puts them back; list only elements that are there, and leave it out"
)

REFUSED = (
    Refusal("NODE", _has_own_system, _DIRECTIONS),
    Refusal("SYSTEM", _has_lines, _DIRECTIONS),
    Refusal("TRANSFORM", _has_lines, _DIRECTIONS, in_meshes=False),
    Refusal("NODE", _is_elsewhere, _NOT_LISTED),
    Refusal("ELEMENT", _is_elsewhere, _NOT_LISTED),
    *(
        Refusal(keyword, _always, _NOT_LISTED)
        for keyword in (
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
    ),
    Refusal("MODELCHANGE", _changes_elements, _CHANGES),
)


def read_deck(path: Path, *, mesh_alone: bool = False) -> Deck:
    """Read a deck and the files that it includes.

    With `mesh_alone` keywords are accepted that only change the directions of loads and supports.
    meshio also reads decks, but it loses the numbers of the nodes and all blocks of nodes except
    the last, and it has no elements of plane strain.
    """
    listing = DeckListing()
    for block in acting(flat(blocks(path))):
        where = f"deck {path.name}: the block {block}"
        _check_not_refused(block, where, mesh_alone)
        if block.keyword not in KEPT:
            continue
        try:
            KEPT[block.keyword](listing, block)
        except ModelError:
            raise
        except (KeyError, ValueError, IndexError) as error:
            # Python quotes the entry, which may be a line of any file that a deck includes.
            no_number = re.match("invalid literal|could not convert", str(error))
            why = "an entry is no number" if no_number else error
            raise ModelError(f"{where} cannot be read ({why}); repair it") from error
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


def _check_not_refused(block: Block, where: str, mesh_alone: bool) -> None:
    for refusal in REFUSED:
        applies = refusal.keyword == block.keyword and (refusal.in_meshes or not mesh_alone)
        if applies and refusal.is_refused(block):
            raise ModelError(f"{where} {refusal.reason}")


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
