"""Input checks shared by all layers: each returns the checked value or raises a `ModelError` that names argument, value and remedy."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, SupportsFloat, TypeAlias

import numpy as np

from ..errors import ModelError

__all__ = ["Array", "check_name", "checked_loads", "finite_array", "finite_number", "flag", "frozen", "real_array", "whole_number"]

_LARGEST = 1e150  # squares of anything larger overflow

Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]


def frozen(values: Any) -> Array:
    """Return a read-only float64 copy."""
    copy = np.array(values, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def finite_array(name: str, values: Any, shape: tuple[int | None, ...]) -> Array:
    """Check that `values` is a real, finite array of `shape` (None: any length) and return it as a read-only float64 copy."""
    raw = real_array(name, values)
    if raw.ndim != len(shape) or any(want is not None and have != want for have, want in zip(raw.shape, shape, strict=True)):
        raise ModelError(f"{name}: shape {raw.shape}, expected {_text(shape)}")
    fits = np.abs(raw) <= _LARGEST  # also false for NaN
    if not fits.all():
        where = tuple(int(i) for i in np.argwhere(~fits)[0])
        at = f" at index {where if len(where) > 1 else where[0]}" if where else ""
        raise ModelError(f"{name}: value {raw[where]}{at}; give finite numbers of at most {_LARGEST:g}")
    return frozen(raw)


def real_array(name: str, values: Any) -> Array:
    """Check that `values` is an array of real numbers (NaN and infinities included) and return it as float64."""
    if isinstance(values, np.ma.MaskedArray):
        raise ModelError(f"{name}: a masked array; fill or drop the masked values")
    if hasattr(values, "toarray"):
        raise ModelError(f"{name}: a sparse {type(values).__name__}; give a dense array, `.toarray()`")
    try:
        raw = np.asarray(values)
    except ValueError as error:
        raise ModelError(f"{name}: rows of different lengths; give a rectangular array") from error
    if raw.dtype.kind == "c":
        raise ModelError(f"{name}: complex numbers (dtype {raw.dtype}); give the real static quantity")
    if raw.dtype.kind not in "fiu":
        raise ModelError(f"{name}: {type(values).__name__} of dtype {raw.dtype} is not numeric; give an array or a list of real numbers")
    with np.errstate(over="ignore"):  # extended precision may not fit; infinities are for the caller to refuse
        return np.asarray(raw, dtype=np.float64)


def finite_number(name: str, value: SupportsFloat, *, least: float = -np.inf, above: float = -np.inf, below: float = np.inf) -> float:
    """Check that `value` is one real finite number with `value >= least`, `value > above` and `value < below`."""
    if isinstance(value, complex | np.complexfloating | str | bytes | bool | np.bool_) or np.ma.is_masked(value):
        raise ModelError(f"{name}: {value!r} is not a real number")
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ModelError(f"{name}: {value!r} is not one real number") from error
    if not (abs(number) <= _LARGEST and number >= least and number > above and number < below):
        limits = [f"at least {least:g}"] * (least > -np.inf) + [f"above {above:g}"] * (above > -np.inf) + [f"below {below:g}"] * (below < np.inf)
        raise ModelError(f"{name}: {number!r}; it must be {' and '.join(['finite', *limits])}")
    return number


def checked_loads(name: str, loads: Any) -> Mapping[str, float]:
    """Check a sum of load cases, name -> finite amplitude, and return it read-only."""
    if not isinstance(loads, Mapping):
        raise ModelError(f"{name}: a {type(loads).__name__}; give a mapping, load case name -> amplitude")
    for case in loads:
        check_name(name, case)
    return MappingProxyType({case: finite_number(f"{name}[{case!r}]", amplitude) for case, amplitude in loads.items()})


def check_name(argument: str, name: Any) -> None:
    """Check the name of a load case: a printable text."""
    if not isinstance(name, str) or not name or not name.isprintable():
        raise ModelError(f"{argument}: load case name {name!r}; give a printable text")


def flag(name: str, value: Any) -> bool:
    """Check that `value` is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise ModelError(f"{name}: {value!r}; give True or False")
    return bool(value)


def whole_number(name: str, value: Any, *, least: int, most: float = np.inf) -> int:
    """Check that `value` is an integer from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise ModelError(f"{name}: {value!r}; it must be a whole number of at least {least}{f' and at most {most:g}' if most < np.inf else ''}")
    return int(value)


def _text(shape: tuple[int | None, ...]) -> str:
    return "(" + ", ".join("any" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"
