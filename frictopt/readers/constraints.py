"""Displacements that a deck holds, and its keywords that let nodes follow others."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..base import Booleans, Integers
from .deck_text import Block, entries

# Axes that a word of *BOUNDARY holds: 0 to 2 are displacements, 3 to 5 rotations.
HELD_BY_NAME = {
    "XSYMM": [0, 4, 5],
    "YSYMM": [1, 3, 5],
    "ZSYMM": [2, 3, 4],
    "XASYMM": [1, 2, 3],
    "YASYMM": [0, 2, 4],
    "ZASYMM": [0, 1, 5],
    "PINNED": [0, 1, 2],
    "ENCASTRE": [0, 1, 2, 3, 4, 5],
}
# Keywords that constrain nodes. All but the first one let nodes follow others: a load on a node
# that follows is refused by the name of the keyword.
CONSTRAINING = (
    "BOUNDARY",
    "EQUATION",
    "RIGIDBODY",
    "KINEMATIC",
    "TIE",
    "MPC",
    "DISTRIBUTING",
    "DISTRIBUTINGCOUPLING",
    "KINEMATICCOUPLING",
    "CYCLICSYMMETRYMODEL",
    "PRE-TENSIONSECTION",
    "EMBEDDEDELEMENT",
)


def constraints_of(
    constraint_blocks: Sequence[Block],
    row_of_node: Mapping[int, int],
    sets: Mapping[str, Integers],
) -> tuple[Booleans, tuple[str, ...]]:
    """(nodes, 6) whether each displacement and rotation is held, and keywords of other constraints.

    A block that cannot be read is only named: loads may not depend on it.
    """
    held = np.zeros((len(row_of_node), 6), dtype=bool)
    others: dict[str, None] = {}
    for block in constraint_blocks:
        if block.keyword != "BOUNDARY":
            others[f"*{block.keyword}"] = None
            continue
        try:
            for line in block.lines:
                where, *directions = entries(line)
                nodes = np.r_[row_of_node[int(where)] if where.isdecimal() else sets[where.upper()]]
                held[nodes[:, None], _axes(directions)] = True
        except (KeyError, ValueError, IndexError) as error:
            others[f"a block *BOUNDARY that cannot be read here: {error}"] = None
    return held, tuple(others)


def _axes(directions: Sequence[str]) -> list[int]:
    """Axes of a word, or from the first to the last direction; those beyond 6 are temperatures."""
    first = directions[0]
    if not first.isdecimal():
        return HELD_BY_NAME[first.upper()]
    last = directions[1] if len(directions) > 1 and directions[1] else first
    return [axis for axis in range(int(first) - 1, int(last)) if axis < 6]
