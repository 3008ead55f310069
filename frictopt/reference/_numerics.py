"""The two pieces of arithmetic that the closed forms share."""

from collections.abc import Callable

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import ROUNDING


def least_ratio(strength: Array, demand: Array, terms: Array) -> float:
    """Largest `lam >= 0` with `lam * demand <= strength` everywhere, `demand >= 0`; inf if every load factor will do, nan if none.

    `terms` is the size of the terms that cancel in `strength`: it tells a strength of zero from a negative one.
    """
    if (strength < -ROUNDING * terms).any():
        return float("nan")
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.where(demand > 0, np.maximum(strength, 0.0) / demand, np.inf)
    return float(ratio.min())


def bisection(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that is positive at `low` and negative at `high`, to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
