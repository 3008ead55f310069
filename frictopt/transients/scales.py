"""The scales of forces and slips at each node: contacts that no stiffness joins do not count beside each other."""

from typing import NamedTuple

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import NO_DRIVE


class Scales(NamedTuple):
    """Scales (N,) that are the same at all nodes which the stiffness joins: force of the mean load, largest force, slip under the largest force."""

    mean: Array
    force: Array
    length: Array


def scales(S: Array, mean: Array, corners: Array, n: int) -> Scales:
    """Scales of a contact of n nodes with stiffness `S` (M, M) under a mean load (M,) and the loads at its corners, (K, M).

    Loads that are rounding beside the largest ones of all nodes count for nothing.
    """
    shape, p = (len(S) // n, n), mean[-n:]
    largest, stiffness = np.abs(corners).reshape(-1, *shape).max(axis=(0, 1)), np.diag(S).reshape(shape).mean(axis=0)
    least = NO_DRIVE * max(float(np.abs(p).mean()), float(largest.max())) or 1.0
    joined = (S.reshape(shape * 2) != 0).any(axis=(0, 2))
    number, part = 1, np.zeros(n)
    if not joined[0].all():
        from scipy.sparse.csgraph import connected_components  # here, for a contact in one piece needs none

        number, part = connected_components(joined, directed=False)
    found = Scales(np.empty(n), np.empty(n), np.empty(n))
    for k in range(number):
        block = part == k
        most = float(largest[block].max())
        found.mean[block] = mean_force = max(float(np.abs(p[block]).mean()) or most, least)
        found.force[block] = force = max(mean_force, most)
        found.length[block] = force / (float(stiffness[block].mean()) or float(stiffness.mean()) or 1.0)
    return found
