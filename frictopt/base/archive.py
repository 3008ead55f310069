"""Results in files: an npz archive of their arrays, and one text of JSON for all else.

The text defines the place of each array. Nothing is pickled, so reading a file runs none of its
code.
"""

import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from datetime import date, datetime
from enum import Enum
from pathlib import Path
from types import MappingProxyType, UnionType
from typing import Any, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd

from ..errors import ModelError
from .files import KINDS, packed, unpacked

_FORMAT = "frictopt result 1"


class _Form(NamedTuple):
    """The form of a type of values in a file, `{name: content}`.

    A content is another value, or a list of values; `made` restores a value from its content.
    """

    name: str
    kind: type[Any]
    content: Callable[[Any], object]
    made: Callable[[Any], object]


def save(result: object, path: str | Path) -> None:
    """Write a result, see `Kept.save`."""
    writer = _Writer()
    text = json.dumps([writer.text(result, type(result).__name__), writer.things])
    arrays = {f"array {number}": array for number, array in enumerate(writer.arrays)}
    packed(path, _FORMAT, text=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)


def load(path: str | Path) -> Any:
    """Read a result, see `frictopt.results.load`."""

    def made(arrays: dict[str, Any]) -> object:
        text, things = json.loads(arrays.pop("text").tobytes())
        numbered = [arrays[f"array {number}"] for number in range(len(arrays))]
        return _Reader(numbered, things).value(text)

    remedy = "give a file that `save` of a result wrote; ContactSystem.load reads a contact"
    return unpacked(path, _FORMAT, made, "a result", remedy, any_version=False)


class _Writer:
    """Writes a result as JSON, in which arrays and things are given by their numbers.

    Things are results and their parts. A thing to which several other things refer, such as the
    contact of a result, is written once.
    """

    def __init__(self) -> None:
        self.arrays = list[Any]()
        self.things = list[Any]()
        self._numbers = dict[int, int]()

    def text(self, value: Any, place: str) -> object:
        """A value as JSON: unchanged if JSON has its type, else `{name: content}`.

        The place of the value is for error messages.
        """
        kind = type(value)
        if value is None or kind in (bool, int, float, str):
            return value
        if getattr(value, "stays_in_memory", False):
            return None
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufUM":
            return {"array": self._array(value)}
        if KINDS.get(kind.__name__) is kind:
            if isinstance(value, Enum):
                return {kind.__name__: value.name}
            return {"thing": self._thing(value, place)}
        form = _FORM_OF.get(np.generic if isinstance(value, np.generic) else kind)
        if form is None:
            raise ModelError(
                f"{place}: a {kind.__name__} cannot be kept in a file; pickle the result instead"
            )
        content = form.content(value)
        if isinstance(content, list):
            parts = enumerate(content)
            return {form.name: [self.text(part, f"{place}[{number}]") for number, part in parts]}
        return {form.name: self.text(content, place)}

    def _array(self, array: Any) -> int:
        """The number of an array."""
        if self._is_new(array):
            self._numbers[id(array)] = len(self.arrays)
            self.arrays.append(array)
        return self._numbers[id(array)]

    def _thing(self, thing: Any, place: str) -> int:
        """The number of an object; the objects in it have smaller numbers."""
        if self._is_new(thing):
            kind = type(thing)
            content = [
                [name, self.text(getattr(thing, name), f"{place}.{name}")]
                for name in _field_names(kind)
            ]
            self._numbers[id(thing)] = len(self.things)
            self.things.append({kind.__name__: content})
        return self._numbers[id(thing)]

    def _is_new(self, value: object) -> bool:
        return id(value) not in self._numbers


class _Reader:
    """Reads the values of a JSON text; the numbers in it refer to lists of arrays and things."""

    def __init__(self, arrays: list[Any], things: list[Any]) -> None:
        self._arrays = arrays
        self._things = list[Any]()
        for array in arrays:
            array.flags.writeable = False
        for thing in things:
            ((kind, content),) = thing.items()
            state = {name: self.value(text) for name, text in content}
            restored: Any = _restored(KINDS[kind], state)
            if hasattr(restored, "check_kept"):
                restored.check_kept()
            self._things.append(restored)

    def value(self, text: Any) -> Any:
        """The value that a JSON text represents."""
        if isinstance(text, list):
            return [self.value(part) for part in text]
        if not isinstance(text, dict):
            return text
        ((name, content),) = text.items()
        if name == "array":
            return self._arrays[content]
        if name == "thing":
            return self._things[content]
        if name in KINDS:  # an Enum, and the name of its member
            return KINDS[name][content]
        form = _FORM_NAMED[name]
        if form.content is list and not isinstance(content, list):
            raise ValueError(f"a {name} of a {type(content).__name__}")
        return form.made(self.value(content))


def _restored(kind: type[Any], state: dict[str, Any]) -> object:
    """A thing with these fields; a class may restore its objects itself, see `kept`."""
    for name, hint in _hints(kind).items():
        if name in state and not _fits(state[name], hint):
            raise ValueError(f"{kind.__name__}.{name} is a {type(state[name]).__name__}")
    if hasattr(kind, "from_kept"):
        return kind.from_kept(state)
    if state.keys() != set(_field_names(kind)):
        raise ValueError(f"{kind.__name__} has other fields")
    if not is_dataclass(kind):
        return kind(**state)
    thing = object.__new__(kind)
    getattr(thing, "__setstate__", vars(thing).update)(state)
    return thing


def _hints(kind: type[Any]) -> dict[str, Any]:
    """The types of the fields of a class; some of these types are written with the name `pd`."""
    return get_type_hints(kind, localns={"pd": pd})


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value, and each entry of a tuple, has a type; whole numbers are also real ones."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is np.ndarray:
        (number,) = get_args(parts[1])
        return isinstance(value, np.ndarray) and np.can_cast(value.dtype, number, "same_kind")
    if origin is tuple and isinstance(value, tuple):
        hints = parts[:1] * len(value) if parts[-1] is ... else parts
        return len(hints) == len(value) and all(map(_fits, value, hints))
    numbers = {float: (int, float, np.number), int: (int, np.integer)}
    if hint in numbers:
        return isinstance(value, numbers[hint]) and not isinstance(value, bool)
    return hint is Any or isinstance(value, origin or hint)


def _field_names(kind: type[Any]) -> list[str]:
    """Names of the fields of a dataclass or a named tuple that files hold."""
    if hasattr(kind, "KEPT_FIELDS"):
        return list(kind.KEPT_FIELDS)
    return [field.name for field in fields(kind)] if is_dataclass(kind) else list(kind._fields)


def _row(row: Any) -> tuple[object, str, object]:
    """Name, type and entries of a column, or of an index."""
    if isinstance(row, pd.RangeIndex):
        return row.name, "int64", range(row.start, row.stop, row.step)
    return row.name, str(row.dtype), row.to_numpy() if row.dtype.kind in "biuf" else row.tolist()


def _index(name: object, kind: str, cells: Any) -> "pd.Index[Any]":
    if isinstance(cells, range):
        return pd.RangeIndex(cells, name=name)
    return pd.Index(cells, dtype=kind, name=name)


def _series(row: tuple[Any, str, Any], index: tuple[Any, str, Any]) -> "pd.Series[Any]":
    name, kind, cells = row
    if isinstance(cells, range):
        raise ValueError(f"the column {name!r} is a range")
    return pd.Series(cells, index=_index(*index), dtype=kind, name=name)


def _table(
    rows: list[tuple[Any, str, Any]], index: tuple[Any, str, Any], attrs: dict[str, object]
) -> pd.DataFrame:
    columns = [_series(row, index) for row in rows]
    table = pd.DataFrame({column.name: column for column in columns}, index=_index(*index))
    table.attrs.update(attrs)
    return table


def _table_parts(table: pd.DataFrame) -> tuple[object, ...]:
    columns = [_row(column) for _, column in table.items()]
    return columns, _row(table.index), dict(table.attrs)


def _items(mapping: Any) -> list[tuple[object, object]]:
    return list(mapping.items())


_FORMS = (
    _Form("tuple", tuple, list, tuple),
    _Form("list", list, list, list),
    _Form("frozenset", frozenset, list, frozenset),
    _Form("dict", dict, _items, dict),
    _Form("mappingproxy", MappingProxyType, _items, lambda pairs: MappingProxyType(dict(pairs))),
    _Form("range", range, lambda r: [r.start, r.stop, r.step], lambda ends: range(*ends)),
    _Form("number", np.generic, np.asarray, lambda array: array[()]),
    _Form("series", pd.Series, lambda s: (_row(s), _row(s.index)), lambda parts: _series(*parts)),
    _Form("table", pd.DataFrame, _table_parts, lambda parts: _table(*parts)),
    _Form("date", date, date.isoformat, date.fromisoformat),
    _Form("datetime", datetime, datetime.isoformat, datetime.fromisoformat),
    _Form("Timestamp", pd.Timestamp, pd.Timestamp.isoformat, pd.Timestamp),
)
_FORM_OF = {form.kind: form for form in _FORMS}
_FORM_NAMED = {form.name: form for form in _FORMS}
