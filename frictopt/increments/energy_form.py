"""A quadratic form of slips and gaps, and what an ellipsoid of it says about reactions."""

import numpy as np

from ..contact.checks import Array

__all__ = ["EnergyForm"]

_NULL = 1e-9  # eigenvalues below this share of the largest are rigid motions, which need no force (a condensation leaves 1e-10 of rounding)


class EnergyForm:
    """The form `u' H u` with its rigid motions, beside the stiffness S that gives the reactions.

    Parameters
    ----------
    H
        (2N, 2N) symmetric; S itself, or what stands in for it.
    S
        (2N, 2N) stiffness.

    Attributes
    ----------
    rigid
        (2N, k) orthonormal rigid motions: those that H does not resist.
    sliding
        (N, j) slips of the rigid motions that open no gap.
    lifting
        Whether some rigid motion opens gaps.
    least
        Smallest eigenvalue of H but for the rigid motions; negative where the form is no energy.
    compliance
        (2N, 2N) pseudo-inverse of H.
    """

    def __init__(self, H: Array, S: Array) -> None:
        values, vectors = np.linalg.eigh(H)
        null = np.abs(values) <= _NULL * max(values[-1], 1.0)
        n = len(H) // 2
        self.nodes, self.S, self.rigid = n, S, vectors[:, null]
        self.least = float(values[~null].min(initial=0.0))
        self.compliance = (vectors[:, ~null] / values[~null]) @ vectors[:, ~null].T
        self.spread = S @ self.compliance @ S
        _, sizes, turned = np.linalg.svd(self.rigid[n:])
        rank = int((sizes > 1e-9).sum())
        self.lifting = rank > 0
        self.sliding: Array = self.rigid[:n] @ turned[rank:].T
        self._rolling = np.abs(self.rigid[:n] @ np.linalg.pinv(self.rigid[n:], rcond=1e-9))

    def range_of(self, rows: Array, trial: Array, centre: Array, energy: float) -> tuple[Array, Array]:
        """Least and largest value of `rows @ r` in an ellipsoid."""
        middle = rows @ (trial + self.S @ centre)
        half = np.sqrt(energy * np.maximum(np.sum((rows @ self.spread) * rows, axis=-1), 0.0))
        return middle - half, middle + half

    def rolling(self, lift: Array) -> Array:
        """(N,) largest slip of each node by rigid motions that lift the nodes by at most `lift`."""
        return np.asarray(self._rolling @ lift)
