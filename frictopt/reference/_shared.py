"""What the closed forms share: checks, each of which returns the value or raises a `ModelError` with argument, value and remedy; and arithmetic."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array, finite_number
from ..errors import ModelError


def per_node(nodes: int | None = None, **values: ArrayLike) -> tuple[Array, ...]:
    """Check quantities given once for all nodes or once per node and return each as (N,); N is `nodes` or the longest."""
    arrays = {name: finite_array(name, value) for name, value in values.items()}
    count = nodes if nodes is not None else max((array.size for array in arrays.values() if array.ndim == 1), default=1)
    for name, array in arrays.items():
        if array.shape not in ((), (count,)) or array.size == 0:
            raise ModelError(f"{name}: shape {array.shape}; give one number, or one for each of the {count} nodes")
    if "f" in arrays and arrays["f"].min() <= 0:  # a frictionless node resists no shear and has no limit
        raise ModelError(f"f: {arrays['f'].min():g}; give a positive coefficient of friction")
    return tuple(np.broadcast_to(array, (count,)) for array in arrays.values())


def poisson_ratio(name: str, value: float) -> float:
    """Check a Poisson's ratio above -1 and of at most 0.5."""
    if (nu := finite_number(name, value, above=-1.0)) > 0.5:
        raise ModelError(f"{name}: {nu:g}; give Poisson's ratio of at most 0.5")
    return nu


def bisection(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that is positive at `low` and negative at `high`, to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
