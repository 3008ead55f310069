"""The units of a limit question: forces and load factors that scale its unknowns and margins.

r0 (K0, t + 1, N) are the reactions of the closed nodes at load factor 0, normal ones last. r1 (K,
t + 1, N) are the reactions of the scaled loads at load factor 1. `closed` (N,) is the mask of the
closed nodes.
"""

import numpy as np

from ..base import CONDENSATION, Array, Booleans


def mean_force(r0: Array, r1: Array, closed: Booleans) -> float:
    """Mean normal force at load factor 0; a force of the same size if there is none."""
    if not closed.any():
        return 1.0
    pressure = float(np.abs(r0[:, -1, closed]).mean())
    if pressure:
        return pressure
    shear = np.linalg.norm(r0[:, :-1, closed], axis=1)
    cyclic_shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    cyclic_pressure = np.abs(r1[:, -1, closed])
    return float(max(shear.mean(), cyclic_shear.mean(), cyclic_pressure.mean())) or 1.0


def mean_bound(r0: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Mean friction bound at load factor 0; `force` if it is only rounding (no pressure)."""
    if not closed.any():
        return force
    bound = float((friction * r0[:, -1])[:, closed].mean())
    size = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return bound if bound > CONDENSATION * size else force


def load_unit(r0: Array, r1: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Load factor at which the cyclic reactions reach the mean friction bound."""
    if not closed.any():
        return 1.0
    f = friction[closed]
    shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    pressure = np.abs(r1[:, -1, closed])
    without_friction = float(pressure[:, f == 0].sum()) / int(closed.sum())
    demand = float(shear.mean() + (f * pressure).mean()) + without_friction
    if not demand > 0:
        return 1.0
    bound = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return (bound or force) / demand


def node_unit(r0: Array, r1: Array, force: float) -> Array:
    """(N,) pressure of each node under the mean load, or its largest other force if it has none."""
    # Least force unit of a node, divided by the mean normal force: answers have errors of this
    # size.
    least_share = 1e-6
    smallest = least_share * force
    pressure = np.abs(r0[:, -1]).max(axis=0)
    shear = np.linalg.norm(r0[:, :-1], axis=1).max(axis=0)
    cyclic = np.maximum(np.linalg.norm(r1[:, :-1], axis=1), np.abs(r1[:, -1])).max(axis=0)
    other_forces = np.maximum(np.maximum(shear, cyclic), smallest)
    return np.asarray(np.where(pressure > smallest, pressure, other_forces))
