"""The course of contacts in the plane: which nodes follow each other, and the arc length along them."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .checks import Array, Names
from .tolerances import SAME_POINT


def runs(names: Sequence[str] | Names) -> list[slice]:
    """The nodes of each contact, from the name of the contact of each node."""
    starts = [i for i in range(len(names)) if i == 0 or names[i] != names[i - 1]]
    return [slice(start, end) for start, end in pairwise([*starts, len(names)])]


def arc_length(points: Array, frames: Array, contact: Names | None) -> Array:
    """(N,) coordinates along the tangent where all nodes have the same and follow each other along it, else arc length, contact after contact.

    The arc length begins at the first node's coordinate along its tangent; each further contact begins one spacing after the end of the one before.
    """
    pieces = [slice(None)] if contact is None else runs(contact)
    along = points @ frames[0, 0]
    if (frames == frames[0]).all() and (len(pieces) == 1 or np.all(np.diff(along) > 0)):
        return np.asarray(along)
    x, end = np.empty(len(points)), 0.0
    for number, piece in enumerate(pieces):
        p = points[piece]
        lengths = np.hypot(*np.diff(p, axis=0).T)
        step = float(lengths.mean()) if len(lengths) else 1.0
        first = float(frames[0, 0] @ p[0])
        start = end + step if number else first * (abs(first) > SAME_POINT * lengths.sum())
        x[piece] = start + np.r_[0.0, np.cumsum(lengths)]
        end = float(x[piece][-1])
    return x
