"""Matrices of Abaqus."""

from pathlib import Path

import numpy as np

from .deck import read_deck
from .job import MatrixJob
from .meshes import file_path
from .rows import numbers_in, symmetric

__all__ = ["read_abaqus"]


def read_abaqus(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read a stiffness that Abaqus writes for `*MATRIX GENERATE, STIFFNESS` with `*MATRIX OUTPUT, STIFFNESS, FORMAT=MATRIX INPUT`.

    Its rows are "node, direction, node, direction, value" (Abaqus Keywords Guide, `*MATRIX INPUT`), one triangle or the whole matrix.
    Unknowns that are coupled to no other are held ones or follow others, and are left out. The stiffness of a plane job with a deck is divided by the
    thickness of its section.

    Parameters
    ----------
    path
        Path of the file, such as `NAME_STIF1.mtx`.
    deck
        Path of the input deck, for nodes and sets; a flat one, without parts and instances.

    Raises
    ------
    ModelError
        A file that is missing or damaged, FORMAT=COORDINATE (it carries no labels), directions other than 1, 2 and 3, a matrix that is not symmetric.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_abaqus("tests/data/spring_STIF1.mtx")
    >>> job.K.toarray().tolist(), job.labels.tolist()
    ([[2.0, -1.0], [-1.0, 2.0]], [[7, 1], [9, 1]])
    """
    node, direction, other_node, other_direction, value = numbers_in(file_path("path", path), "stiffness", ",", 5)
    ends = np.concatenate([np.column_stack([node, direction]), np.column_stack([other_node, other_direction])])
    distinct, place = np.unique(ends, axis=0, return_inverse=True)
    row, column = np.split(place.ravel(), 2)
    K = symmetric("stiffness", row, column, value.astype(np.float64), len(distinct))
    free = np.unique(np.concatenate([row[row != column], column[row != column]]))
    nodes = None if deck is None else read_deck(file_path("deck", deck))
    return MatrixJob(K[free][:, free] / (1.0 if nodes is None else nodes.thickness), distinct[free], nodes)
