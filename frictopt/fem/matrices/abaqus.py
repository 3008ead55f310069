"""Matrices of Abaqus."""

from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix

from ..ordering import Integers
from .blocks import text_of
from .deck import read_deck
from .job import MatrixJob
from .meshes import file_path
from .rows import numbers_in, symmetric
from .substructure import is_element, stiffness_of_element


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
    K, labels = stiffness_of_element(text, file) if is_element(text) else _assembled(file)
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
