"""The fixed point of an affine map from its iterates."""

import numpy as np

from .checks import Array
from .tolerances import ROUNDING

__all__ = ["SLOW", "drift_text", "fixed_point"]

SLOW = 1e-3
"""A drift that changes by a smaller share of itself from cycle to cycle needs more than ten thousand cycles to die out."""


def fixed_point(iterates: Array) -> Array:
    """Fixed point of an affine map from some of its iterates (rows), by reduced-rank extrapolation."""
    steps = np.diff(iterates, axis=0)
    scale = np.linalg.norm(steps, axis=1, keepdims=True)
    differences = np.diff(steps, axis=0)
    weights = np.linalg.lstsq(differences.T, -steps[0], rcond=ROUNDING)[0] if scale.min() > 0 else np.zeros(len(differences))
    fixed: Array = iterates[0] + weights @ steps[:-1]
    return fixed


def drift_text(change: float, decay: float) -> str:
    """What to make of a slip that changes by `change` slip scales a cycle, where this change alters by the share `decay` from cycle to cycle."""
    return (
        f"the slip drifts by {change:.1e} slip scales a cycle, and from one cycle to the next this drift changes by only {decay:.1e} of itself: slow "
        "ratcheting, or a body that rolls or that nothing guides; guide it by a Support, or follow its drift with march"
    )
