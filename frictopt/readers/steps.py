"""The steps of a deck: which conditions act while the matrix is stored."""

from collections.abc import Iterable

from .deck_text import Block


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
