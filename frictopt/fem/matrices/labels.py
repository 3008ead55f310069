"""Labels of the rows of a matrix: which of them are displacements of nodes."""

import numpy as np
from numpy.typing import ArrayLike

from ...contact.checks import whole_array
from ...errors import ModelError
from ..ordering import Flags, Integers, whole
from .deck import Deck


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct pairs of whole numbers, some of them displacements, and return them read-only."""
    labels = whole_array("labels", values, (None, 2), least=-(10**12), most=10**12)
    if not displaced(labels).any():
        raise ModelError("labels: none is that of a displacement, a node and direction 1, 2 or 3; without any there is no contact")
    if len(np.unique(labels, axis=0)) != len(labels):
        raise ModelError(
            f"labels: {len(labels) - len(np.unique(labels, axis=0))} labels are given twice; let the code write the matrix again, of solids alone: "
            "CalculiX gives nodes of shells, beams and trusses several rows"
        )
    return whole(labels)


def displaced(labels: Integers) -> Flags:
    """(n,) whether a label is that of a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, deck: Deck) -> Integers:
    """(nodes, 6) row of each node's displacements and rotations, -1 where the deck holds them, -2 where there is none else.

    Raises
    ------
    ModelError
        Displacements of nodes that are not in the deck.
    """
    if len(lost := np.setdiff1d(labels[displaced(labels), 0], deck.numbers)):
        raise ModelError(
            f"deck: node {lost[0]} of the matrix is not in it; give the deck of the same job, of solids alone: codes make nodes for shells and beams"
        )
    rows = np.flatnonzero(np.isin(labels[:, 0], deck.numbers) & (labels[:, 1] >= 1) & (labels[:, 1] <= 6))
    order = np.argsort(deck.numbers)
    node = order[np.searchsorted(deck.numbers, labels[rows, 0], sorter=order)]
    unknowns = np.where(deck.constraints.held, -1, -2)
    unknowns[node, labels[rows, 1] - 1] = rows
    return whole(unknowns)
