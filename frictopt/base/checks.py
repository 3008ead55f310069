"""Types of arrays, and checks of input: each returns the checked value or raises a `ModelError` that names argument, value and remedy."""

import copyreg
import sys
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from inspect import Parameter, isclass, signature
from numbers import Real
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError, ModelWarning

_LARGEST = 1e150  # the square of a larger number overflows
_OURS, _COMMAND = (
    "frictopt.",
    "frictopt.__main__",
)  # questions of the rooms of the package are not the user's, those of its command are
# largest coefficient of friction that is passed without a word: of dry metals it is 0.1 to 1.5, of
# rubber up to 4
_ROUGH = 5.0
_MEANINGS = {  # of arguments that are easily forgotten, for error messages
    "system": "the contact, a ContactSystem",
    "cycle": "the load cycle, a LoadCycle",
    "friction": "the coefficient of friction, one number or one for each node",
    "load_factor": "the load factor, a number >= 0",
    "load_factors": "a list of load factors",
    "mean": "the mean load, a mapping from load case names to amplitudes",
    "corners": "the loads at the corners of the cycle, a list of mappings from load case names to amplitudes",
}
_WEAR = (
    1e-17,
    1e-9,
    # 1/Pa; coefficients of wear: of diamond-like coatings 1e-17 and more, of soft metals that seize up
    # to 1e-10
)
_PASCAL = (
    {"N": 1.0, "kN": 1e3, "MN": 1e6},
    {"m": 1.0, "mm": 1e-3},
)  # names of units of force and length, in N and m
LARGEST_SEED = 2**63 - 1
"""Largest seed of a random choice: the largest whole number that a column of a table holds."""

Array: TypeAlias = NDArray[np.float64]
Names: TypeAlias = NDArray[np.str_]
Booleans: TypeAlias = NDArray[np.bool_]
Integers: TypeAlias = NDArray[np.intp]
T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])


def frozen(values: object) -> Array:
    """Return a read-only float64 copy."""
    copy = np.array(values, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def whole(values: ArrayLike) -> Integers:
    """Return a read-only copy of whole numbers."""
    copy = np.array(values, dtype=np.intp)
    copy.flags.writeable = False
    return copy


def real_array(name: str, values: object) -> Array:
    """Check that `values` is an array of real numbers (NaN and infinities included) and return it as a float64 copy."""
    try:
        raw = np.asarray(values)
        parts = (values, *(values if isinstance(values, list | tuple) else ()))
        if any(isinstance(part, np.ma.MaskedArray) for part in parts):
            raise TypeError("masked numbers")
        if raw.dtype.kind not in "fiu":
            raise TypeError(f"its dtype is {raw.dtype}")
        if any(isinstance(part, bool | np.bool_) for part in parts):
            raise TypeError("True and False are no numbers")
        with np.errstate(
            over="ignore"
        ):  # extended precision may not fit; infinities are for the caller to refuse
            return np.array(raw, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{name}: {shown(values)} ({error}); give an array of real numbers"
        ) from error


def check_entries(name: str, values: Array, fits: Booleans, remedy: str, at: str = "node") -> None:
    """Refuse an array with an entry that does not fit, by its first one and what to give."""
    if not fits.all():
        where = tuple(np.argwhere(~fits)[0].tolist())
        place = f" at {at} {where if len(where) > 1 else where[0]}" if where else ""
        raise ModelError(f"{name}: {values[where]:g}{place}; {remedy}")


def finite_array(name: str, values: object, shape: tuple[int | None, ...] | None = None) -> Array:
    """Check that `values` is a real, finite array of `shape` (None in it: any length) and return it as a read-only float64 copy."""
    raw = real_array(name, values)
    if shape and (
        raw.ndim != len(shape)
        or any(want not in (None, have) for have, want in zip(raw.shape, shape, strict=True))
    ):
        raise ModelError(f"{name}: shape {raw.shape}, expected {str(shape).replace('None', 'any')}")
    check_entries(
        name,
        raw,
        (raw <= _LARGEST) & (raw >= -_LARGEST),
        f"give finite numbers of at most {_LARGEST:g}",
        "index",
    )  # false for NaN
    raw.flags.writeable = False
    return raw


def whole_array(
    name: str, values: object, shape: tuple[int | None, ...], *, least: int, most: int
) -> Integers:
    """Check that `values` is an array of integers from `least` to `most`, of `shape` (None in it: any length), and return a copy."""
    numbers = finite_array(name, values, shape)
    fits = (numbers == np.round(numbers)) & (numbers >= least) & (numbers <= most)
    check_entries(name, numbers, fits, f"give integers from {least} to {most}", "index")
    return numbers.astype(np.intp)


def for_each(name: str, values: Array, nodes: int) -> Array:
    """Check that there is one number for all nodes or one for each, and return them as (N,)."""
    if values.shape not in ((), (nodes,)):
        raise ModelError(
            f"{name}: shape {values.shape}; give one number, or one for each of the {nodes} nodes"
        )
    return np.broadcast_to(values, (nodes,))


def per_node(name: str, values: object, nodes: int, negative: str = "") -> Array:
    """Check real, finite numbers, one for all nodes or one for each, and return them as (N,); none below 0 where a text says why not."""
    if isinstance(values, Mapping):
        remedy = "give one number, or one for each node, as `np.where(system.contact == 'head', 0.15, 0.3)`"
        raise ModelError(f"{name}: a {type(values).__name__}; {remedy}")
    array = finite_array(name, values)
    each = for_each(name, array, nodes)
    if negative:
        check_entries(name, array, array >= 0, negative)
    return each


def finite_number(
    name: str,
    value: object,
    *,
    least: float = -np.inf,
    above: float = -np.inf,
    below: float = np.inf,
) -> float:
    """Check that `value` is one real finite number with `value >= least`, `value > above` and `value < below`."""
    scalar = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    real = isinstance(scalar, Real) and not isinstance(scalar, bool | np.timedelta64)
    try:
        number = float(scalar) if real else np.nan  # type: ignore[arg-type]
    except OverflowError:  # an integer of hundreds of digits
        number, real = np.inf, False
    if not (abs(number) <= _LARGEST and number >= least and number > above and number < below):
        limits = (
            [f"at least {least:g}"] * (least > -np.inf)
            + [f"above {above:g}"] * (above > -np.inf)
            + [f"below {below:g}"] * (below < np.inf)
        )
        told = (
            f"{number!r}; it must be"
            if real
            else f"{shown(value)} is not one real number; it must be"
        )
        raise ModelError(f"{name}: {told} {' and '.join(['finite', *limits])}")
    return number


def whole_number(name: str, value: object, *, least: int, most: int = 10**6) -> int:
    """Check that `value` is an integer from `least` to `most`; by default `most` is a million, more than any count that makes sense."""
    if (
        not isinstance(value, int | np.integer)
        or isinstance(value, bool | np.timedelta64)
        or not least <= value <= most
    ):
        raise ModelError(
            f"{name}: {shown(value)}; it must be a whole number of at least {least} and at most {most}"
        )
    return int(value)


def listed(name: str, values: object) -> list[Any]:
    """Check that `values` is an iterable, but not a text, bytes or a mapping, and return it as a list."""
    if isinstance(values, str | bytes | Mapping) or not np.iterable(values):
        raise ModelError(f"{name}: {shown(values)}; give a list")
    return list(values)


def finite_numbers(name: str, values: object, *, least: float = -np.inf) -> list[float]:
    """Check that `values` is a row of real finite numbers of at least `least`."""
    return [finite_number(name, value, least=least) for value in listed(name, values)]


def listed_parts(argument: str, parts: object, *kinds: type[T]) -> tuple[T, ...]:
    """Check that `parts` is a sequence of parts of some kinds, and return it as a tuple."""
    if not isinstance(parts, Sequence) or not all(isinstance(part, kinds) for part in parts):
        raise ModelError(
            f"{argument}: {shown(parts)}; give a list of {' or '.join(kind.__name__ for kind in kinds)}"
        )
    return tuple(parts)


def flags(name: str, values: object, n: int) -> Booleans:
    """Check that `values` are True or False for each of n nodes."""
    found = listed(name, values)
    if len(found) != n or not all(isinstance(each, bool | np.bool_) for each in found):
        raise ModelError(f"{name}: {shown(values)}; give True or False for each of {n} nodes")
    return np.array(found, dtype=bool)


def flag(name: str, value: object) -> bool:
    """Check that `value` is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise ModelError(f"{name}: {shown(value)}; give True or False")
    return bool(value)


def choice(name: str, value: T, options: Collection[str]) -> T:
    """Check that `value` is one of some texts."""
    if not isinstance(value, str) or value not in options:
        raise ModelError(f"{name}: {shown(value)}; give {' or '.join(map(repr, options))}")
    return value


def check_text(argument: str, value: object, meaning: str, what: str = "") -> None:
    """Check a printable text; error messages say what it is and what it means."""
    if not isinstance(value, str) or not value or not value.isprintable():
        raise ModelError(f"{argument}: {what}{shown(value)}; give {meaning}")


def check_name(argument: str, name: object) -> None:
    """Check the name of a load case: a printable text."""
    check_text(argument, name, "a printable text", "load case name ")


def _read_only(entries: dict[T, object]) -> MappingProxyType[T, object]:
    """A read-only view of a dictionary."""
    return MappingProxyType(entries)


copyreg.pickle(
    MappingProxyType, lambda view: (_read_only, (dict(view),))
)  # Python can neither pickle nor copy such a view by itself


def checked_cases(name: str, cases: object, meaning: str) -> Mapping[str, Any]:
    """Check a mapping, load case name -> something that error messages say the meaning of."""
    if not isinstance(cases, Mapping):
        made = " (`dict` makes one of it)" if hasattr(cases, "to_dict") else ""
        raise ModelError(
            f"{name}: a {type(cases).__name__}; give a mapping{made}, load case name -> {meaning}"
        )
    for case in cases:
        check_name(name, case)
    return cases


def checked_loads(name: str, loads: object) -> Mapping[str, float]:
    """Check a sum of load cases, name -> finite amplitude, and return it read-only."""
    cases = checked_cases(name, loads, "amplitude")
    return MappingProxyType(
        {case: finite_number(f"{name}[{case!r}]", amplitude) for case, amplitude in cases.items()}
    )


def checked_contact(argument: str, contact: object, n: int) -> Names:
    """Check the names of the contacts of n nodes, each name in one run of nodes, and return them read-only."""
    names = listed(argument, contact)
    if len(names) != n:
        raise ModelError(
            f"{argument}: {len(names)} names for {n} nodes; give the name of the contact of each node"
        )
    for i, name in enumerate(names):
        check_text(f"{argument} of node {i}", name, "a printable text")
        if i and name != names[i - 1] and name in names[:i]:
            raise ModelError(
                f"{argument}: {shown(name)} begins again at node {i}; order the nodes contact after contact"
            )
    copy = np.array(names, dtype=np.str_)
    copy.flags.writeable = False
    return copy


def checked_units(units: object) -> str | None:
    """Check the names of the units of force and length, "N, mm"; None: not known. ModelError if they are not two names. No number depends on them."""
    names = [name.strip() for name in units.split(",")] if isinstance(units, str) else []
    if units is not None and not (
        len(names) == 2 and all(names) and all(map(str.isprintable, names))
    ):
        raise ModelError(
            f'units: {shown(units)}; give the names of the units of force and length, such as "N, mm"'
        )
    return ", ".join(names) or None


def warns_of_odd_values(question: F) -> F:
    """Decorator of public functions and classes: refuse a call without an argument, warn of a value that looks like a mistake."""
    if isclass(question):
        question.__init__ = _checks_call(question.__init__, question.__name__)  # type: ignore[method-assign]
        return question
    return _checks_call(question, question.__qualname__)


def _checks_call(question: F, name: str) -> F:
    """The function `question`, which error messages call `name`, with a check of each call."""
    parameters = signature(question).parameters
    names = list(parameters)
    required = [
        each
        for each in names
        if parameters[each].default is Parameter.empty
        and parameters[each].kind is not Parameter.VAR_POSITIONAL
    ]

    @wraps(question)
    def checked(*args: object, **kwargs: object) -> object:
        given = dict(zip(names, args, strict=False)) | kwargs
        missing = [each for each in required if each not in given]
        if missing and given.keys() <= set(
            names
        ):  # Python itself names a keyword that does not exist
            call = f"{name}({', '.join(each for each in required if each not in ('self', 'cls'))})"
            raise ModelError(
                f"{missing[0]}: not given; give {_MEANINGS.get(missing[0], 'it')}, as in {call}"
            )
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if not caller.startswith(_OURS) or caller == _COMMAND:
            for text in _odd(given):
                warnings.warn(text, ModelWarning, stacklevel=2)
        return question(*args, **kwargs)

    return checked  # type: ignore[return-value]


def first_of(bad: Booleans | np.bool_, most: Array | None = None) -> int | None:
    """The number of the first thing that is bad, or of the bad one that has most of something; None if none is."""
    return (
        None
        if not np.any(bad)
        else int(np.argmax(bad if most is None else np.where(bad, most, -np.inf)))
    )


def _odd(given: Mapping[str, Any]) -> Iterator[str]:
    """What may not be meant in the arguments of a question."""
    many = given.get("frictions", [given.get("friction", 0.0)])
    asked_for = (
        many if isinstance(many, Collection) else []
    )  # others may be used up by looking at them
    friction = 0.0
    with suppress(ModelError, TypeError):  # what is no number is for the question to refuse
        friction = max(
            (float(real_array("friction", one).max(initial=0.0)) for one in asked_for), default=0.0
        )
    if friction > _ROUGH:
        yield f"friction: {friction:g}, above {_ROUGH:g}; give the coefficient of friction, not per cent"
    load_factor = given.get("load_factor")
    if (
        isinstance(load_factor, Real)
        and load_factor == 0
        and getattr(given.get("cycle"), "fixed", ()) is None
    ):
        yield "load_factor: 0; the corners of the cycle carry no load then, only the mean load acts"
    yield from _twice(given.get("cycle"))
    if "coefficient" in given:
        yield from _wear_in_other_units(
            given["coefficient"], getattr(given.get("system"), "units", None)
        )


def _twice(cycle: Any) -> Iterator[str]:
    """Load cases that stand in the mean load and, with the same sign, in each of several corners: as if corners held the whole load."""
    mean, corners = getattr(cycle, "mean", {}), getattr(cycle, "corners", ())
    for name, amplitude in mean.items() if len(corners) > 1 else ():
        if all(corner.get(name, 0.0) * amplitude > 0 for corner in corners):
            yield f"cycle: {name!r} is {amplitude:g} in the mean load, and each corner adds to it; give corners what is added to the mean load alone"


def _wear_in_other_units(coefficient: Any, units: str | None) -> Iterator[str]:
    """A coefficient of wear that makes sense in other units than those of the contact."""
    force, length = units.split(", ") if isinstance(units, str) else ("", "")
    newton, metre = _PASCAL[0].get(force), _PASCAL[1].get(length)
    largest = 0.0
    with suppress(ModelError, TypeError):  # what is no number is for the question to refuse
        largest = float(real_array("coefficient", coefficient).max(initial=0.0))
    if (
        newton
        and metre
        and largest > 0
        and not _WEAR[0] <= (in_pascal := largest * metre**2 / newton) <= _WEAR[1]
    ):
        usual = f"{in_pascal:.3g} 1/Pa, for forces are in {force} and lengths in {length}; dry metals have 1e-16 to 1e-11 1/Pa"
        yield f"coefficient: {largest:g} is {usual}; give it in {length}^2/{force}: 1 1/Pa is {newton / metre**2:g} {length}^2/{force}"


def place(point: Array) -> str:
    """A point as a text for messages."""
    return "(" + ", ".join(f"{value:g}" for value in point) + ")"


def shown(value: object) -> str:
    """The value as a short text for an error message."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an integer too long to print, or a foreign object whose repr fails
        text = f"an object of type {type(value).__name__}"
    return text if len(text) <= 80 else f"{text[:77]}..."
