"""Input checks of the closed forms: each returns the checked value or raises a `ModelError` with argument, value and remedy."""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError

Array: TypeAlias = NDArray[np.float64]


def finite(name: str, value: ArrayLike, shape: tuple[int, ...] | None = None) -> Array:
    """Check that `value` holds real finite numbers, in an array of `shape` where one is given."""
    try:
        raw = np.asarray(value)
    except ValueError as error:
        raise ModelError(f"{name}: {value!r} has rows of different lengths; give a rectangular array") from error
    if raw.dtype.kind not in "fiu":
        raise ModelError(f"{name}: {value!r} is not real; give real numbers")
    if shape is not None and raw.shape != shape:
        raise ModelError(f"{name}: shape {raw.shape}; give {'one number' if shape == () else f'shape {shape}'}")
    if not np.isfinite(raw).all():
        raise ModelError(f"{name}: {value!r} is not finite; give finite numbers")
    return raw.astype(np.float64)


def number(name: str, value: float, *, least: float = -np.inf, above: float = -np.inf) -> float:
    """Check that `value` is one real finite number, at least `least` and greater than `above`."""
    checked = float(finite(name, value, ()))
    if checked < least or checked <= above:
        raise ModelError(f"{name}: {checked:g}; give a number {f'above {above:g}' if checked <= above else f'of at least {least:g}'}")
    return checked


def per_node(nodes: int | None = None, **values: ArrayLike) -> tuple[Array, ...]:
    """Check quantities given once for all nodes or once per node and return each as (N,); N is `nodes` or the longest."""
    arrays = {name: finite(name, value) for name, value in values.items()}
    count = nodes if nodes is not None else max((array.size for array in arrays.values() if array.ndim == 1), default=1)
    for name, array in arrays.items():
        if array.shape not in ((), (count,)) or array.size == 0:
            raise ModelError(f"{name}: shape {array.shape}; give one number, or one for each of the {count} nodes")
    return tuple(np.broadcast_to(array, (count,)) for array in arrays.values())


def friction(f: Array) -> None:
    """Check coefficients of friction; zero is refused because a frictionless node resists no shear and thus has no limit."""
    if f.min() <= 0:
        raise ModelError(f"f: {f.min():g}; give a positive coefficient of friction")


def count(name: str, value: int, *, least: int) -> int:
    """Check that `value` is a whole number of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise ModelError(f"{name}: {value!r}; give a whole number")
    if value < least:
        raise ModelError(f"{name}: {value}; give at least {least}")
    return int(value)
