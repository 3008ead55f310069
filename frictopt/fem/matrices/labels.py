"""Labels of the rows of a matrix: which of them are displacements of nodes."""

import numpy as np
from numpy.typing import ArrayLike

from ...contact.checks import Array, finite_array
from ...errors import ModelError
from ..ordering import Flags, Integers
from .deck import Deck


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct pairs of whole numbers, some of them displacements, and return them read-only."""
    labels = finite_array("labels", values, (None, 2))
    if not len(labels):
        raise ModelError("labels: none; give the node and the direction of each row")
    bad = (labels != np.floor(labels)).any(axis=1)
    if bad.any():
        node, direction = labels[bad.argmax()]
        raise ModelError(f"labels: node {node:g}, direction {direction:g}; give whole numbers")
    if not displaced(labels).any():
        raise ModelError("labels: none is that of a displacement, a node and direction 1, 2 or 3; without any there is no contact")
    if len(np.unique(labels, axis=0)) != len(labels):
        raise ModelError(f"labels: {len(labels) - len(np.unique(labels, axis=0))} labels are given twice; let the code write the matrix again")
    checked = labels.astype(np.intp)
    checked.flags.writeable = False
    return checked


def displaced(labels: Array | Integers) -> Flags:
    """(n,) whether a label is that of a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, deck: Deck, directions: int) -> Integers:
    """(nodes, d) row of each node's displacements, -1 where the deck holds them, -2 where there is none else.

    Raises
    ------
    ModelError
        There are labels of nodes that are not in the deck.
    """
    rows = np.flatnonzero(displaced(labels))
    wanted, direction = labels[rows].T
    order = np.argsort(deck.numbers)
    place = np.minimum(np.searchsorted(deck.numbers, wanted, sorter=order), len(order) - 1)
    node = order[place]
    if not np.array_equal(deck.numbers[node], wanted):
        lost = int(wanted[np.argmax(deck.numbers[node] != wanted)])
        raise ModelError(f"deck: node {lost} of the matrix is not in it; give the deck of the same job")
    unknowns = np.where(deck.constraints.held[:, :directions], -1, -2)
    unknowns[node, direction - 1] = rows
    unknowns.flags.writeable = False
    return unknowns
