"""Numbers of nodes: parts that hang together, and places among others."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..contact.checks import Integers

NO_ROWS: Integers = np.zeros(0, dtype=np.intp)


def whole(values: ArrayLike) -> Integers:
    """A read-only copy of whole numbers."""
    array = np.array(values, dtype=np.intp)
    array.flags.writeable = False
    return array


def parts_of(links: Sequence[Integers] | Integers, size: int) -> Integers:
    """(size,) number of the part that each of some things belongs to, by links (2, m) of them."""
    return np.asarray(connected_components(coo_matrix((np.ones(len(links[0])), tuple(links)), shape=(size, size)), directed=False)[1])


def places_among(rows: Integers, others: Integers) -> Integers:
    """(m,) place of each row of numbers (m, k) among others (n, k), in whatever order they stand in a row; -1 where it is none of them."""
    _, number = np.unique(np.sort(np.concatenate([others, rows]), axis=1), axis=0, return_inverse=True)
    place = np.full(len(number), -1)
    place[number.ravel()[: len(others)]] = np.arange(len(others))
    return np.asarray(place[number.ravel()[len(others) :]])
