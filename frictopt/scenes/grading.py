"""Graded coordinates of structured meshes."""

import numpy as np

from ..contact.checks import Array
from ..errors import ModelError

_MOST_STEPS = 1e6


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


def away(length: float, first: float, growth: float) -> Array:
    """Coordinates from 0 to exactly `length`, steps growing by `growth` from about `first`.

    Raises
    ------
    ModelError
        More steps than a mesh may have.
    """
    steps = max(1.0, np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
    if steps > _MOST_STEPS:
        raise ModelError(f"growth: {growth:g} makes {steps:.0e} elements from {first:g} on over {length:g}, the most are {_MOST_STEPS:g}; give more")
    nodes = np.concatenate([[0.0], np.cumsum(growth ** np.arange(steps))])
    nodes *= length / nodes[-1]
    nodes[-1] = length
    return nodes
