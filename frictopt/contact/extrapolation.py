"""The fixed point of an affine map from its iterates."""

import numpy as np

from .checks import Array
from .tolerances import ROUNDING

__all__ = ["fixed_point"]


def fixed_point(iterates: Array) -> Array:
    """Fixed point of an affine map from some of its iterates (rows), by reduced-rank extrapolation."""
    steps = np.diff(iterates, axis=0)
    scale = np.linalg.norm(steps, axis=1, keepdims=True)
    differences = np.diff(steps, axis=0)
    weights = np.linalg.lstsq(differences.T, -steps[0], rcond=ROUNDING)[0] if scale.min() > 0 else np.zeros(len(differences))
    fixed: Array = iterates[0] + weights @ steps[:-1]
    return fixed
