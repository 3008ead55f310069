"""Graded coordinates of structured meshes."""

import numpy as np

from ..contact.checks import Array
from ..errors import ModelError


def along(half_length: float, elements: int, grading: float) -> Array:
    """(elements + 1,) coordinates from -half_length to half_length, exactly mirror-symmetric, for an even number of elements.

    The element in the middle is `grading` times larger than the one at the end, sizes in geometric progression.
    """
    sizes = grading ** -np.linspace(0.0, 1.0, elements // 2)
    right = half_length * np.cumsum(sizes) / sizes.sum()
    right[-1] = half_length
    if not (np.diff(right, prepend=0.0) > 0).all():
        raise ModelError(f"grading: {grading:g}; elements at the ends are smaller than rounding, give a lower grading or fewer elements")
    return np.concatenate([-right[::-1], [0.0], right])


def steps(length: float, first: float, growth: float) -> float:
    """Number of elements of `away`, a whole number."""
    far = np.log1p(length / first * (growth - 1))
    return float(max(1.0, np.ceil(far / np.log(growth))))


def away(length: float, first: float, growth: float) -> Array:
    """Coordinates from 0 to exactly `length`, steps growing by `growth` from about `first`."""
    nodes = np.concatenate([[0.0], np.cumsum(growth ** np.arange(steps(length, first, growth)))])
    nodes *= length / nodes[-1]
    nodes[-1] = length
    return nodes
