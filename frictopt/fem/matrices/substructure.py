"""Reduced stiffness of Abaqus: the file of `*SUBSTRUCTURE MATRIX OUTPUT`, which is that of a linear user element."""

import re
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.tolerances import ROUNDING
from ...errors import ModelError
from ..ordering import Integers
from .blocks import blocks, fields, number

_REMEDY = "write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, for one substructure"

_NODES = re.compile(r"\*\*.*ELEMENT NODES.*\n((?:\s*\*\*.*\n)*)", re.IGNORECASE)


def is_element(text: str) -> bool:
    """Whether a file defines a user element."""
    return any(line.upper().startswith(("*USER ELEMENT", "*MATRIX")) for line in map(str.strip, text.splitlines()))


def stiffness_of_element(text: str, path: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness, and node and direction of each of its rows, of a user element.

    The nodes stand in comments after "ELEMENT NODES". The first data line has the directions of the first node and those that follow; each further
    one the place of a node in that list from which on other directions hold, and these. The matrix has its lower triangle row by row.

    Raises
    ------
    ModelError
        No such element or several, lines that are no numbers, a matrix of another size than the nodes, not symmetric.
    """
    found, listed = list(blocks(path)), _NODES.search(text)
    elements = [lines for keyword, _, lines in found if keyword == "USERELEMENT"]
    parts = [lines for keyword, options, lines in found if keyword == "MATRIX" and options.get("TYPE") == "STIFFNESS"]
    try:
        nodes = [int(field) for line in (listed[1] if listed else "").splitlines() for field in fields(line.strip(" *"))]
        changes = [[int(field) for field in fields(line)] for lines in elements for line in lines]
        values = [number(field) for lines in parts for line in lines for field in fields(line)]
    except ValueError as error:
        raise ModelError(f"stiffness: {path.name} cannot be read ({error}); give the file as the code wrote it") from error
    if (count := len(elements)) != 1 or not nodes or not changes or not values:
        raise ModelError(f"stiffness: {path.name} has {count} elements, {len(nodes)} nodes and {len(values)} numbers of a stiffness; {_REMEDY}")
    starts = [1, *(first for first, *_ in changes[1:])]
    if starts != sorted(set(starts)) or starts[-1] > len(nodes):
        raise ModelError(f"stiffness: directions of {path.name} change at nodes {starts[1:]} of {len(nodes)}; give the file as the code wrote it")
    directions = [changes[0], *(rest for _, *rest in changes[1:])]
    labels = np.array([(nodes[i], k) for i in range(len(nodes)) for k in directions[np.searchsorted(starts, i + 1, side="right") - 1]])
    size = len(labels)
    if len(values) != size * (size + 1) // 2:
        raise ModelError(
            f"stiffness: {path.name} has {len(values)} numbers, but its nodes have {size} directions, with a triangle of "
            f"{size * (size + 1) // 2}; {_REMEDY}"
        )
    K = np.zeros((size, size))
    K[np.tril_indices(size)] = values
    own = np.sqrt(np.abs(np.diag(K)))
    K[np.abs(K) <= ROUNDING * np.outer(own, own)] = 0.0  # rounding of the elimination joins no bodies
    return csr_matrix(K + np.tril(K, -1).T), labels
