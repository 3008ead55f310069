"""Labels of the unknowns of a matrix: (n, 2) numbers of nodes, and directions.

Directions 1, 2 and 3 are displacements. A number that is not positive, or any other direction,
belongs to a generalised coordinate.
"""

import numpy as np
from numpy.typing import ArrayLike

from ..base import Booleans, Integers, number_of, whole, whole_array
from ..errors import ModelError
from .deck import Deck


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct, and some of displacements; return them read-only."""
    labels = whole_array("labels", values, (None, 2), least=-(10**12), most=10**12)
    if not displaced(labels).any():
        raise ModelError(
            "labels: no label names a displacement (a node and direction 1, 2 or 3), so there is "
            "no contact"
        )
    repeated = len(labels) - len(np.unique(labels, axis=0))
    if repeated:
        raise ModelError(
            f"labels: {number_of(repeated, 'label is', 'labels are')} given twice; "
            "write the matrix of solids alone: shells, beams and trusses have several rows"
        )
    return whole(labels)


def displaced(labels: Integers) -> Booleans:
    """(n,) whether a label names a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, deck: Deck) -> Integers:
    """(nodes, 6) row of each displacement and rotation of each node.

    It is -1 if the deck holds the unknown, and -2 if the matrix lacks it otherwise.
    """
    numbers = deck.numbers
    unknown = np.setdiff1d(labels[displaced(labels), 0], numbers)
    if len(unknown):
        constraints = deck.constraints.unresolved
        remedy = f", and without {', '.join(constraints)}" if constraints else ""
        raise ModelError(
            f"deck: node {unknown[0]} of the matrix is not in it; "
            f"give the deck of the same job, of solids alone, not shells or beams{remedy}"
        )
    of_node = np.isin(labels[:, 0], numbers) & (labels[:, 1] >= 1) & (labels[:, 1] <= 6)
    rows = np.flatnonzero(of_node)
    order = np.argsort(numbers)
    node = order[np.searchsorted(numbers, labels[rows, 0], sorter=order)]
    unknowns = np.where(deck.constraints.held, -1, -2)
    unknowns[node, labels[rows, 1] - 1] = rows
    return whole(unknowns)
