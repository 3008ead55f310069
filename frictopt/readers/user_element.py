"""Substructures of Abaqus: linear user elements, with their nodes in comments."""

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix

from ..base import ROUNDING, Array, Integers, number_of
from ..errors import ModelError
from .deck_text import Block, blocks, fields, number

_NODES = re.compile(r"\*\*.*ELEMENT NODES.*\n((?:\s*\*\*.*\n)*)", re.IGNORECASE)
_WRITE = (
    "write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, "
    "for one substructure"
)
_AS_WRITTEN = "give the file as the code wrote it"


@dataclass(frozen=True)
class _UserElement:
    """The numbers of a file of a user element."""

    # how many *USER ELEMENT the file has
    count: int
    # numbers of the nodes, in the order of the comments after "ELEMENT NODES"
    nodes: list[int]
    # data lines of *USER ELEMENT: the directions of the first nodes; then, for each change of
    # directions, the place in `nodes` (from 1) of the first node that has them, and the new
    # directions
    direction_lines: list[list[int]]
    # lower triangle of the stiffness, row by row
    triangle: list[float]


def stiffness_of_element(text: str, path: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness of a user element, and the labels (n, 2) of its rows: node and direction."""
    all_blocks = list(blocks(path))
    try:
        element = _user_element(text, all_blocks)
    except ValueError as error:
        raise ModelError(
            f"stiffness: {path.name} cannot be read ({error}); {_AS_WRITTEN}"
        ) from error
    _check_element(element, path.name)
    labels = _labels(element, path.name)
    return csr_matrix(_stiffness(element.triangle, len(labels), path.name)), labels


def _user_element(text: str, all_blocks: list[Block]) -> _UserElement:
    comments = _NODES.search(text)
    node_lines = comments[1].splitlines() if comments else []
    element_blocks = [block for block in all_blocks if block.keyword == "USERELEMENT"]
    stiffness_blocks = [block for block in all_blocks if _is_stiffness(block)]
    return _UserElement(
        len(element_blocks),
        [int(entry) for line in node_lines for entry in fields(line.strip(" *"))],
        [list(map(int, row)) for block in element_blocks for row in block.rows],
        [number(entry) for block in stiffness_blocks for row in block.rows for entry in row],
    )


def _is_stiffness(block: Block) -> bool:
    return block.keyword == "MATRIX" and block.parameters.get("TYPE") == "STIFFNESS"


def _check_element(element: _UserElement, file: str) -> None:
    nodes = element.nodes
    is_complete = nodes and element.direction_lines and element.triangle
    if element.count != 1 or not is_complete:
        raise ModelError(
            f"stiffness: {file} has elements: {element.count}, nodes: {len(nodes)}, numbers of a "
            f"stiffness: {len(element.triangle)}; {_WRITE}"
        )
    # Abaqus lists each node once.
    if nodes[0] in nodes[1:]:
        raise ModelError(
            f"stiffness: {file} is by CalculiX, which leaves out the elimination in this file; "
            "store the whole stiffness by *FREQUENCY, SOLVER=MATRIXSTORAGE, and read it with "
            "read_calculix; condense reduces it"
        )


def _labels(element: _UserElement, file: str) -> Integers:
    """(n, 2) node and direction of each row."""
    first_directions, *changes = element.direction_lines
    count = len(element.nodes)
    starts = [1, *(change[0] for change in changes)]
    rises = all(start < following for start, following in pairwise(starts))
    if not rises or starts[-1] > count:
        raise ModelError(
            f"stiffness: directions of {file} change at nodes {starts[1:]} of {count}; "
            f"{_AS_WRITTEN}"
        )
    directions = [first_directions, *(change[1:] for change in changes)]
    labels = []
    for place, node in enumerate(element.nodes, start=1):
        latest = np.searchsorted(starts, place, side="right") - 1
        labels += [(node, direction) for direction in directions[latest]]
    return np.array(labels)


def _stiffness(triangle: list[float], size: int, file: str) -> Array:
    expected = size * (size + 1) // 2
    if len(triangle) != expected:
        raise ModelError(
            f"stiffness: {file} has {number_of(len(triangle), 'number')}, not {expected} for "
            f"a triangle of {size} rows; {_WRITE}"
        )
    K = np.zeros((size, size))
    K[np.tril_indices(size)] = triangle
    # Rounding of the elimination must not join bodies.
    scale = np.sqrt(np.abs(np.diag(K)))
    K[np.abs(K) <= ROUNDING * np.outer(scale, scale)] = 0.0
    return K + np.tril(K, -1).T
