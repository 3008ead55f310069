"""Matrices of Abaqus: of whole models, and of substructures, whose files are those of linear user elements."""

import re
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.tolerances import ROUNDING
from ...errors import ModelError
from ..ordering import Integers
from .blocks import blocks, fields, number, text_of
from .deck import read_deck
from .job import MatrixJob
from .meshes import file_path
from .rows import numbers_in, symmetric

_REMEDY = "write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, for one substructure"
_NODES = re.compile(r"\*\*.*ELEMENT NODES.*\n((?:\s*\*\*.*\n)*)", re.IGNORECASE)


def read_abaqus(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read a stiffness that Abaqus writes: of the whole model, or of a substructure.

    That of `*MATRIX GENERATE, STIFFNESS` with `*MATRIX OUTPUT, STIFFNESS, FORMAT=MATRIX INPUT` has rows "node, direction, node, direction, value"
    (Abaqus Keywords Guide, `*MATRIX INPUT`), one triangle or the whole matrix. Unknowns that are coupled to no other are held ones or follow others,
    and are left out. That of `*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED` is a linear user element; it keeps the retained
    displacements alone: retain those of the contact and of the loads. Rotations, unknowns of modes and those of internal nodes (numbers that are not
    positive) are generalised coordinates. The stiffness of a plane job with a deck is divided by the thickness of its section.

    Parameters
    ----------
    path
        Path of the file, such as `NAME_STIF1.mtx`.
    deck
        Path of the input deck, for nodes and sets; a flat one, without parts and instances.

    Raises
    ------
    ModelError
        A file that is missing or damaged, FORMAT=COORDINATE (it carries no labels), no displacements, a matrix that is not symmetric.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_abaqus("tests/data/spring_STIF1.mtx")
    >>> job.K.toarray().tolist(), job.labels.tolist()
    ([[2.0, -1.0], [-1.0, 2.0]], [[7, 1], [9, 1]])
    """
    file = file_path("path", path)
    text = text_of(file, "stiffness")
    of_element = any(line.upper().startswith(("*USER ELEMENT", "*MATRIX")) for line in map(str.strip, text.splitlines()))
    K, labels = stiffness_of_element(text, file) if of_element else _assembled(file)
    nodes = None if deck is None else read_deck(file_path("deck", deck))
    return MatrixJob(K / (1.0 if nodes is None else nodes.thickness), labels, nodes)


def _assembled(file: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness and labels of rows of five numbers."""
    node, direction, other_node, other_direction, value = numbers_in(file, "stiffness", ",", 5)
    ends = np.concatenate([np.column_stack([node, direction]), np.column_stack([other_node, other_direction])])
    distinct, place = np.unique(ends, axis=0, return_inverse=True)
    row, column = np.split(place.ravel(), 2)
    K = symmetric("stiffness", row, column, value.astype(np.float64), len(distinct))
    free = np.unique(np.concatenate([row[row != column], column[row != column]]))
    return K[free][:, free], distinct[free]


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
