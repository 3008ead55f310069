"""Bounds that every state of a contact obeys under a range of loads, whatever its residual slip.

Let `Z = S^-1` and `[q, p] = r^w + S [v, w]` with r^w the reactions of the closed contact. The lower half of `[v, w] = Z (r - r^w)`, multiplied by p,
and the contact condition `p' w = 0` give::

    p' Z_wv q + p' Z_ww p = p' z,    z = (Z r^w)_w

Friction writes `q = diag(sigma f) p` with each sigma in [-1, 1], so that `p' H p = p' z` with H the symmetric part of `Z_ww + Z_wv diag(sigma f)`.
Where H is positive definite for all 2^N signs sigma, which holds for small enough friction, p lies in an ellipsoid; all quantities that bound it are
convex in H and in z, so the signs and the ends of the load range decide. Then q, and with Z slips and gaps, have bounds too.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from ..contact.checks import Array
from .interface import NULL
from .task import Task

__all__ = ["PeriodicBounds", "periodic_bounds"]

_NODES = 10  # more have too many signs
_PAD = 1e-3  # bounds are widened by this share and by this dimensionless amount: above rounding
_DEFINITE = 1e-6  # least eigenvalue of H, over that of friction 0, that counts as positive definite


@dataclass(frozen=True, eq=False)
class PeriodicBounds:
    """Bounds of every state, dimensionless: forces in units of the force scale, lengths in units of `length`.

    Attributes
    ----------
    slip_low, slip_high
        (N,) slip.
    gap_high, pressure_high
        (N,) total gap and normal reaction (their lower bounds are 0).
    length
        Force scale over stiffness scale, length.
    """

    slip_low: Array
    slip_high: Array
    gap_high: Array
    pressure_high: Array
    length: float


def periodic_bounds(task: Task, highest: float) -> PeriodicBounds | None:
    """Bounds of every state at a corner of the cycle with a load factor from 0 to `highest`; None where none can be derived."""
    n, f, loads = task.system.nodes, task.friction, task.loads
    S = task.system.S / task.system.stiffness_scale
    if n > _NODES or np.linalg.eigvalsh(S)[0] <= NULL * np.abs(S).max():
        return None
    Z = np.linalg.inv(S)
    mean = np.r_[loads.q0, loads.p0] / task.force
    ends = np.vstack([mean, *(mean + highest * np.r_[q, p] / task.force for q, p in zip(loads.q1, loads.p1, strict=True))])
    z = ends @ Z[n:].T
    normal = np.linalg.eigvalsh(Z[n:, n:])[0]
    share, size = np.zeros(n), 0.0
    for signs in product((-1.0, 1.0), repeat=n):
        tilted = Z[n:, n:] + Z[n:, :n] * (np.array(signs) * f)
        H = (tilted + tilted.T) / 2
        if np.linalg.eigvalsh(H)[0] <= _DEFINITE * normal:
            return None
        inverse = np.linalg.inv(H)
        share, size = np.maximum(share, np.diag(inverse)), max(size, float(((z @ inverse) * z).sum(axis=1).max()))
    p = (1 + _PAD) * np.sqrt(share * size) + _PAD
    centre, reach = -ends @ Z, np.abs(Z[:, :n]) @ (f * p)
    low = centre.min(axis=0) - reach + np.minimum(Z[:, n:], 0.0) @ p - _PAD
    high = centre.max(axis=0) + reach + np.maximum(Z[:, n:], 0.0) @ p + _PAD
    return PeriodicBounds(low[:n], high[:n], np.maximum(high[n:], 0.0), p, task.force / task.system.stiffness_scale)
