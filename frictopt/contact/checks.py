"""Input checks shared by all layers: each returns the checked value or raises a `ModelError` that names argument, value and remedy."""

from typing import Any, SupportsFloat, TypeAlias

import numpy as np

from ..errors import ModelError

__all__ = ["Array", "finite_array", "finite_number", "frozen", "whole_number"]

Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]


def frozen(values: Any) -> Array:
    """Return a read-only float64 copy."""
    copy = np.array(values, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def finite_array(name: str, values: Any, shape: tuple[int | None, ...]) -> Array:
    """Check that `values` is a real, finite array of `shape` (None: any length) and return it as a read-only float64 copy."""
    try:
        raw = np.asarray(values)
    except ValueError as error:
        raise ModelError(f"{name}: rows of different lengths; give an array of shape {_text(shape)}") from error
    if raw.dtype.kind == "c":
        raise ModelError(f"{name}: complex numbers (dtype {raw.dtype}); give the real static quantity")
    if raw.dtype.kind not in "fiu":
        raise ModelError(f"{name}: dtype {raw.dtype} is not numeric; give real numbers")
    if raw.ndim != len(shape) or any(want is not None and have != want for have, want in zip(raw.shape, shape, strict=True)):
        raise ModelError(f"{name}: shape {raw.shape}, expected {_text(shape)}")
    array = frozen(raw)
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        at = f" at index {where if len(where) > 1 else where[0]}" if where else ""
        raise ModelError(f"{name}: value {array[where]}{at}; give finite numbers")
    return array


def finite_number(name: str, value: SupportsFloat, *, least: float = -np.inf, above: float = -np.inf, below: float = np.inf) -> float:
    """Check that `value` is one real finite number with `value >= least`, `value > above` and `value < below`."""
    if isinstance(value, complex | np.complexfloating | str | bytes | bool | np.bool_):
        raise ModelError(f"{name}: {value!r} is not a real number")
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{name}: {value!r} is not one real number") from error
    if not (np.isfinite(number) and number >= least and number > above and number < below):
        limits = [f"at least {least:g}"] * (least > -np.inf) + [f"above {above:g}"] * (above > -np.inf) + [f"below {below:g}"] * (below < np.inf)
        raise ModelError(f"{name}: {number!r}; it must be {' and '.join(['finite', *limits])}")
    return number


def whole_number(name: str, value: Any, *, least: int) -> int:
    """Check that `value` is an integer of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ModelError(f"{name}: {value!r}; it must be a whole number of at least {least}")
    return int(value)


def _text(shape: tuple[int | None, ...]) -> str:
    return "(" + ", ".join("any" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"
