"""The scales of forces and slips at each node: contacts that no stiffness joins do not count beside each other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...contact.checks import Array
from ...contact.tolerances import NO_DRIVE

__all__ = ["Scales", "scales"]


class Scales(NamedTuple):
    """Scales (N,) that are the same at all nodes which the stiffness joins: force of the mean load, largest force, slip under the largest force."""

    mean: Array
    force: Array
    length: Array


def scales(S: Array, mean: Array, corners: Sequence[Array]) -> Scales:
    """Scales of a path with stiffness `S` (2N, 2N) under a mean load (2N,) and the loads at its corners, (2N,) each.

    Loads that are rounding beside the largest ones of all nodes count for nothing.
    """
    n = len(S) // 2
    largest, stiffness = np.max(np.abs(np.array(corners)).reshape(-1, 2, n), axis=(0, 1)), np.diag(S).reshape(2, n).mean(axis=0)
    least = NO_DRIVE * max(float(np.abs(mean[n:]).mean()), float(largest.max())) or 1.0
    found = Scales(np.empty(n), np.empty(n), np.empty(n))
    for block in _blocks(S):
        most = float(largest[block].max())
        found.mean[block] = max(float(np.abs(mean[n:][block]).mean()) or most, least)
        found.force[block] = max(float(found.mean[block[0]]), most)
        found.length[block] = found.force[block] / (float(stiffness[block].mean()) or float(stiffness.mean()) or 1.0)
    return found


def _blocks(S: Array) -> list[np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """The nodes of each part of a contact that no entry of the (2N, 2N) stiffness joins to the others."""
    nodes = len(S) // 2
    joined = (S.reshape(2, nodes, 2, nodes) != 0).any(axis=(0, 2))
    if joined[0].all():
        return [np.arange(nodes)]
    number, block = connected_components(joined, directed=False)
    return [np.flatnonzero(block == k) for k in range(number)]
