"""Types of arrays, and checks of input.

A check returns the checked value, or raises a `ModelError` that names argument, value and remedy.
"""

# One file because the checks use each other, and the whole package finds them in one place.
import copyreg
import sys
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import wraps
from inspect import Parameter, isclass, signature
from itertools import pairwise
from numbers import Real
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError, ModelWarning

# The square of a larger number overflows.
_LARGEST = 1e150
# Calls from inside the package give no warnings of odd values; calls from the command line do.
_OURS = "frictopt."
_COMMAND = "frictopt.command."
# Units of force in N, and of length in m.
_NEWTON = {"N": 1.0, "kN": 1e3, "MN": 1e6}
_METRE = {"m": 1.0, "mm": 1e-3}
# Meanings of arguments that are easily forgotten, for error messages.
_MEANINGS = {
    "system": "the contact, a ContactSystem",
    "cycle": "the load cycle, a LoadCycle",
    "friction": "the coefficient of friction, one number or one for each node or contact",
    "load_factor": "the load factor, a number >= 0",
    "load_factors": "a list of load factors",
    "mean": "the mean load, a mapping from load case names to amplitudes",
    "corners": (
        "the loads at the corners of the cycle, "
        "a list of mappings from load case names to amplitudes"
    ),
}
LARGEST_SEED = 2**63 - 1
"""Largest seed of a random choice: the largest whole number that a column of a table holds."""

Array: TypeAlias = NDArray[np.float64]
PerNode: TypeAlias = ArrayLike | Mapping[str, float]
Loads: TypeAlias = Mapping[str, float]  # load case name -> amplitude
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


def by_labels(name: str, values: object) -> Any:
    """A table or series of pandas in the order of its labels, 0 to n - 1; other values as given.

    In another order, the numbers would belong to other nodes.
    """
    labels = getattr(values, "index", None)
    if labels is None or callable(labels):
        return values
    if set(labels) != set(range(len(labels))):
        raise ModelError(
            f"{name}: {shown(values)}, whose labels are not 0 to {len(labels) - 1}; label its "
            "entries by their nodes, or give them in order by `.to_numpy()`"
        )
    return values.sort_index()  # type: ignore[attr-defined]


def real_array(name: str, values: object) -> Array:
    """Check an array of real numbers, NaN and infinities included; returns a float64 copy."""
    values = by_labels(name, values)
    try:
        raw = np.asarray(values)
        parts = [values]
        if isinstance(values, list | tuple):
            parts += values
        if any(isinstance(part, np.ma.MaskedArray) for part in parts):
            raise TypeError("masked numbers")
        if raw.dtype.kind not in "fiu":
            raise TypeError(f"its dtype is {raw.dtype}")
        if any(isinstance(part, bool | np.bool_) for part in parts):
            raise TypeError("True and False are not numbers")
        # A number in extended precision may become infinite; the caller refuses infinite numbers.
        with np.errstate(over="ignore"):
            return np.array(raw, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        # The user may have passed a start or a result, which has the array as an attribute.
        part = name.removeprefix("initial_")
        remedy = f"its `.{part}`" if hasattr(values, part) else "an array of real numbers"
        raise ModelError(f"{name}: {shown(values)} ({error}); give {remedy}") from error


def check_entries(name: str, values: Array, fits: Booleans, remedy: str, at: str = "node") -> None:
    """Refuse an array with an entry that does not fit; the error names the first one."""
    if not fits.all():
        index = tuple(np.argwhere(~fits)[0].tolist())
        place = ""
        if index:
            place = f" at {at} {index if len(index) > 1 else index[0]}"
        raise ModelError(f"{name}: {values[index]:g}{place}; {remedy}")


def finite_array(name: str, values: object, shape: tuple[int | None, ...] | None = None) -> Array:
    """Check a real, finite array of `shape` (None in it: any length); returns a read-only copy."""
    raw = real_array(name, values)
    if shape is not None and not _has_shape(raw, shape):
        raise ModelError(f"{name}: shape {raw.shape}, expected {str(shape).replace('None', 'any')}")
    fits = (raw <= _LARGEST) & (raw >= -_LARGEST)  # false for NaN
    check_entries(name, raw, fits, f"give finite numbers of at most {_LARGEST:g}", "index")
    raw.flags.writeable = False
    return raw


def _has_shape(values: Array, shape: tuple[int | None, ...]) -> bool:
    if values.ndim != len(shape):
        return False
    lengths = zip(values.shape, shape, strict=True)
    return all(expected in (None, length) for length, expected in lengths)


def whole_array(
    name: str, values: object, shape: tuple[int | None, ...], *, least: int, most: int
) -> Integers:
    """Check an array of integers from `least` to `most`, of `shape` (None: any length)."""
    numbers = finite_array(name, values, shape)
    fits = (numbers == np.round(numbers)) & (numbers >= least) & (numbers <= most)
    check_entries(name, numbers, fits, f"give integers from {least} to {most}", "index")
    return numbers.astype(np.intp)


def for_each(name: str, values: Array, nodes: int) -> Array:
    """Check one number for all nodes or one for each; returns (N,)."""
    if values.shape not in ((), (nodes,)):
        raise ModelError(
            f"{name}: shape {values.shape}; give one number, or one for each of "
            f"{number_of(nodes, 'node')}"
        )
    return np.broadcast_to(values, (nodes,))


def is_named(values: object) -> bool:
    """Whether values have names: a mapping, or a table or series of pandas with texts as labels."""
    labels = getattr(values, "index", None)
    has_texts = np.iterable(labels) and all(isinstance(label, str) for label in labels)
    return has_texts or isinstance(values, Mapping)


def by_contact(name: str, values: object, system: Any) -> Any:
    """Values for each node, from values by the names of contacts; other values as given."""
    if not is_named(values):
        return values
    named = dict(values)  # type: ignore[call-overload]
    contact = [] if system.contact is None else system.contact.tolist()
    if named.keys() != set(contact):
        known = f"one for each of the contacts {list(dict.fromkeys(contact))}"
        if not contact:
            known = "name the contacts of the system"
        raise ModelError(f"{name}: {shown(values)}; give one number, one per node, or {known}")
    return [named[label] for label in contact]


def per_node(name: str, values: object, system: Any, negative: str = "") -> Array:
    """Check real, finite numbers, one for all, or one for each node or contact; returns (N,).

    If `negative` is a text, it is the remedy for a number below 0.
    """
    array = finite_array(name, by_contact(name, values, system))
    by_node = for_each(name, array, system.nodes)
    if negative:
        check_entries(name, array, array >= 0, negative)
    return by_node


def finite_number(
    name: str,
    value: object,
    *,
    least: float = -np.inf,
    above: float = -np.inf,
    below: float = np.inf,
    most: float = np.inf,
) -> float:
    """Check one real finite number with `least <= value <= most` and `above < value < below`."""
    scalar = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    is_real = isinstance(scalar, Real) and not isinstance(scalar, bool | np.timedelta64)
    try:
        number = float(scalar) if is_real else np.nan  # type: ignore[arg-type]
    except OverflowError:  # an integer of hundreds of digits
        number = np.inf
        is_real = False
    if not (abs(number) <= _LARGEST and least <= number <= most and above < number < below):
        ends = {"at least": least, "above": above, "below": below, "at most": most}
        bounds = [f"{words} {end:g}" for words, end in ends.items() if np.isfinite(end)]
        conditions = ["finite", *bounds]
        got = repr(number) if is_real else f"{shown(value)} is not one real number"
        raise ModelError(f"{name}: {got}; it must be {' and '.join(conditions)}")
    return number


def whole_number(name: str, value: object, *, least: int, most: int = 10**6) -> int:
    """Check an integer from `least` to `most`; the default, a million, exceeds all usual counts."""
    if (
        not isinstance(value, int | np.integer)
        or isinstance(value, bool | np.timedelta64)
        or not least <= value <= most
    ):
        raise ModelError(
            f"{name}: {shown(value)}; "
            f"it must be a whole number of at least {least} and at most {most}"
        )
    return int(value)


def listed(name: str, values: object) -> list[Any]:
    """Check an iterable that is no text, bytes or mapping; returns it as a list."""
    if isinstance(values, str | bytes | Mapping) or not np.iterable(values):
        raise ModelError(f"{name}: {shown(values)}; give a list")
    return list(values)


def finite_numbers(name: str, values: object, *, least: float = -np.inf) -> list[float]:
    """Check a list of real finite numbers of at least `least`."""
    return [finite_number(name, value, least=least) for value in listed(name, values)]


def listed_parts(argument: str, parts: object, *kinds: type[T]) -> tuple[T, ...]:
    """Check a sequence of parts of some kinds; returns it as a tuple."""
    if not isinstance(parts, Sequence) or not all(isinstance(part, kinds) for part in parts):
        names = " or ".join(kind.__name__ for kind in kinds)
        raise ModelError(f"{argument}: {shown(parts)}; give a list of {names}")
    return tuple(parts)


def flags(name: str, values: object, n: int) -> Booleans:
    """Check True or False for each of n nodes."""
    entries = listed(name, by_labels(name, values))
    if len(entries) != n or not all(isinstance(entry, bool | np.bool_) for entry in entries):
        raise ModelError(f"{name}: {shown(values)}; give True or False for each of {n} nodes")
    return np.array(entries, dtype=bool)


def is_distribution(value: object) -> bool:
    """Whether a value is a frozen distribution of `scipy.stats`.

    It is recognised by its methods, because scipy.stats is slow to import.
    """
    return hasattr(value, "dist") and hasattr(value, "ppf")


def distribution(name: str, value: Any) -> Any:
    """Check a frozen distribution of `scipy.stats` of one random number."""
    median = value.ppf(0.5) if is_distribution(value) else np.nan
    if np.ndim(median) or not np.isfinite(median):
        raise ModelError(
            f"{name}: {shown(value)}; give a frozen distribution of scipy.stats with parameters of "
            "one number, such as norm(0.3, 0.03)"
        )
    return value


def flag(name: str, value: object) -> bool:
    """Check True or False."""
    if not isinstance(value, bool | np.bool_):
        raise ModelError(f"{name}: {shown(value)}; give True or False")
    return bool(value)


def choice(name: str, value: T, options: Collection[str]) -> T:
    """Check a text that has to be one of the options."""
    if not isinstance(value, str) or value not in options:
        raise ModelError(f"{name}: {shown(value)}; give {' or '.join(map(repr, options))}")
    return value


def check_text(argument: str, value: object, meaning: str, what: str = "") -> None:
    """Check a printable text; the error message has `what` before the text, and its meaning."""
    if not isinstance(value, str) or not value or not value.isprintable():
        raise ModelError(f"{argument}: {what}{shown(value)}; give {meaning}")


def check_name(argument: str, name: object) -> None:
    """Check the name of a load case: a printable text."""
    check_text(argument, name, "a printable text", "load case name ")


def _read_only(entries: dict[T, object]) -> MappingProxyType[T, object]:
    """A read-only view of a dictionary."""
    return MappingProxyType(entries)


# Python can neither pickle nor copy such a view by itself.
copyreg.pickle(MappingProxyType, lambda view: (_read_only, (dict(view),)))


def checked_cases(name: str, cases: object, meaning: str) -> Mapping[str, Any]:
    """Check a mapping from load case names; `meaning` describes its values in error messages."""
    if not isinstance(cases, Mapping):
        hint = " (`dict` converts it)" if hasattr(cases, "to_dict") else ""
        raise ModelError(
            f"{name}: a {type(cases).__name__}; give a mapping{hint}, load case name -> {meaning}"
        )
    for case in cases:
        check_name(name, case)
    return cases


def checked_loads(name: str, loads: object) -> Loads:
    """Check a sum of load cases, name -> finite amplitude; returns it read-only."""
    cases = checked_cases(name, loads, "amplitude")
    return MappingProxyType(
        {case: finite_number(f"{name}[{case!r}]", amplitude) for case, amplitude in cases.items()}
    )


def checked_contact(contact: object, n: int) -> Names:
    """Check the name of the contact of each of n nodes; nodes of one contact must be adjacent."""
    names = listed("contact", by_labels("contact", contact))
    if len(names) != n:
        raise ModelError(
            f"contact: {number_of(len(names), 'name')} for {number_of(n, 'node')}; give the "
            "name of the contact of each node"
        )
    for i, name in enumerate(names):
        check_text(f"contact of node {i}", name, "a printable text")
        if i and name != names[i - 1] and name in names[:i]:
            raise ModelError(
                f"contact: {shown(name)} begins again at node {i}; "
                "order the nodes contact after contact"
            )
    copy = np.array(names, dtype=np.str_)
    copy.flags.writeable = False
    return copy


def runs(names: Sequence[str] | Names) -> list[slice]:
    """The nodes of each contact, from the name of the contact of each node."""
    starts = [i for i in range(len(names)) if i == 0 or names[i] != names[i - 1]]
    return [slice(start, end) for start, end in pairwise([*starts, len(names)])]


def checked_units(units: object) -> str | None:
    """Check the names of the units of force and length, "N, mm"; None if they are not known.

    No number depends on them.
    """
    if units is None:
        return None
    names = [name.strip() for name in units.split(",")] if isinstance(units, str) else []
    if len(names) != 2 or not all(name and name.isprintable() for name in names):
        raise ModelError(
            f"units: {shown(units)}; "
            'give the names of the units of force and length, such as "N, mm"'
        )
    return ", ".join(names)


def warns_of_odd_values(question: F) -> F:
    """Decorator: refuse a call that lacks an argument, warn of values that look like mistakes."""
    if isclass(question):
        question.__init__ = _checks_call(question.__init__, question.__name__)  # type: ignore[method-assign]
        return question
    return _checks_call(question, question.__qualname__)


def _checks_call(question: F, name: str) -> F:
    """The function `question`, which error messages call `name`, with a check of each call."""
    parameters = signature(question).parameters
    required = [
        parameter.name
        for parameter in parameters.values()
        if parameter.default is Parameter.empty and parameter.kind is not Parameter.VAR_POSITIONAL
    ]
    call = f"{name}({', '.join(name for name in required if name not in ('self', 'cls'))})"

    @wraps(question)
    def checked(*args: object, **kwargs: object) -> object:
        arguments = dict(zip(parameters, args, strict=False)) | kwargs
        missing = [name for name in required if name not in arguments]
        # Python itself names a keyword that does not exist.
        if missing and arguments.keys() <= parameters.keys():
            meaning = _MEANINGS.get(missing[0], "it")
            raise ModelError(f"{missing[0]}: not given; give {meaning}, as in {call}")
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if not caller.startswith(_OURS) or caller.startswith(_COMMAND):
            for text in _odd_values(arguments):
                warnings.warn(text, ModelWarning, stacklevel=2)
        return question(*args, **kwargs)

    return checked  # type: ignore[return-value]


def first_of(bad: Booleans | np.bool_, most: Array | None = None) -> int | None:
    """Index of the first True entry of `bad`, or of the True entry with the largest `most`.

    The result is None if all entries are False.
    """
    if not np.any(bad):
        return None
    return int(np.argmax(bad if most is None else np.where(bad, most, -np.inf)))


def _odd_values(arguments: Mapping[str, Any]) -> Iterator[str]:
    """Warnings of values of arguments that look like mistakes."""
    frictions = arguments.get("frictions", [arguments.get("friction", 0.0)])
    # Reading an iterator here would use it up; an array without dimensions cannot be iterated.
    if isinstance(frictions, Collection) and np.iterable(frictions):
        friction = max((_largest("friction", value) for value in frictions), default=0.0)
        # Largest coefficient of friction without a warning. Dry metals have 0.1 to 1.5, and rubber
        # up to 4.
        rough = 5.0
        if friction > rough:
            yield (
                f"friction: {friction:g}, above {rough:g}; "
                "give the coefficient of friction, not per cent"
            )
    cycle = arguments.get("cycle")
    load_factor = arguments.get("load_factor")
    is_zero = isinstance(load_factor, Real) and load_factor == 0
    if is_zero and getattr(cycle, "fixed", ()) is None:
        yield (
            "load_factor: 0; only the mean load acts then, because the load factor multiplies the "
            "loads of the corners"
        )
    yield from _repeated_loads(cycle)
    if "coefficient" in arguments:
        units = getattr(arguments.get("system"), "units", None)
        yield from _wear_in_other_units(arguments["coefficient"], units)


def _largest(name: str, values: object) -> float:
    """The largest of some numbers; 0 if they are no numbers, which the function itself refuses."""
    if is_named(values):
        values = [*dict(values).values()]  # type: ignore[call-overload]
    with suppress(ModelError, TypeError):
        return float(real_array(name, values).max(initial=0.0))
    return 0.0


def _repeated_loads(cycle: Any) -> Iterator[str]:
    """Warnings of load cases in the mean load that every corner repeats with the same sign."""
    corners = getattr(cycle, "corners", ())
    if len(corners) < 2:
        return
    for name, amplitude in getattr(cycle, "mean", {}).items():
        if all(corner.get(name, 0.0) * amplitude > 0 for corner in corners):
            yield (
                f"cycle: {name!r} is {amplitude:g} in the mean load, and each corner adds to "
                "it; in a corner, give only the addition to the mean load"
            )


def _wear_in_other_units(coefficient: Any, units: str | None) -> Iterator[str]:
    """Warning of a coefficient of wear that seems not to be in the units of the contact."""
    force, length = units.split(", ") if isinstance(units, str) else ("", "")
    if force not in _NEWTON or length not in _METRE:
        return
    largest = _largest("coefficient", coefficient)
    pascal = _NEWTON[force] / _METRE[length] ** 2  # the unit of pressure, in Pa
    in_pascal = largest / pascal
    # Coefficients of wear in this range, in 1/Pa, give no warning. Diamond-like coatings have 1e-17
    # and more, and soft metals that seize have up to 1e-10.
    usual = (1e-17, 1e-9)
    if largest > 0 and not usual[0] <= in_pascal <= usual[1]:
        yield (
            f"coefficient: {largest:g} is {in_pascal:.3g} 1/Pa, as forces are in {force} and "
            f"lengths in {length}; dry metals have 1e-16 to 1e-11 1/Pa; give it in "
            f"{length}^2/{force}: 1 1/Pa is {pascal:g} {length}^2/{force}"
        )


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


def number_of(count: int, one: str, several: str = "") -> str:
    """A count with its noun: "1 node", "2 nodes". `several` is `one` with an s by default.

    The words may hold a verb, too: `number_of(count, "node is", "nodes are")`.
    """
    words = one if count == 1 else several or f"{one}s"
    return f"{count} {words}"
