"""Results in files: an npz archive of their arrays, and one text of JSON that says where each belongs. No pickle: a file makes no code run."""

import json
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from datetime import date, datetime
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from ..errors import ModelError
from .files import packed, unpacked
from .kinds import KINDS

_FORM = "frictopt result 1"
_MADE: dict[
    str, Callable[[Any], object]
] = {  # what a file may hold beside results and their parts, from its content
    "tuple": tuple,
    "list": list,
    "frozenset": frozenset,
    "dict": dict,
    "mappingproxy": lambda pairs: MappingProxyType(dict(pairs)),
    "range": lambda ends: range(*ends),
    "number": lambda array: array[()],
    "series": lambda row: _series(*row),
    "table": lambda parts: _table(*parts),
    "date": date.fromisoformat,
    "datetime": datetime.fromisoformat,
    "Timestamp": pd.Timestamp,
}


def save(result: object, path: str | Path) -> None:
    """Write a result, see `Kept.save`."""
    written = _Written()
    text = json.dumps([written.text(result, type(result).__name__), written.things])
    arrays = {f"array {number}": array for number, array in enumerate(written.arrays)}
    packed(path, _FORM, text=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)


def load(path: str | Path) -> Any:
    """Read a result, see `frictopt.results.load`."""

    def made(arrays: dict[str, Any]) -> object:
        text, things = json.loads(arrays.pop("text").tobytes())
        return _Read([arrays[f"array {number}"] for number in range(len(arrays))], things).value(
            text
        )

    return unpacked(
        path,
        _FORM,
        made,
        "a result",
        "give one that `save` of a result wrote; of a contact ContactSystem.load reads it",
    )


def _names(kind: type[Any]) -> list[str]:
    return [one.name for one in fields(kind)] if is_dataclass(kind) else list(kind._fields)


class _Written:
    """A result as JSON with the numbers of its arrays and parts. What stands in several places, as its contact, is written once."""

    def __init__(self) -> None:
        self.arrays, self.things, self._numbers, self._kinds = (
            list[Any](),
            list[Any](),
            dict[int, int](),
            KINDS,
        )

    def text(self, value: Any, at: str) -> object:
        """A value that stands `at` a place: as it is if JSON knows it, else {its kind: its content}."""
        kind = type(value).__name__
        if value is None or type(value) in (bool, int, float, str):
            return value
        if getattr(value, "stays_in_memory", False):
            return None
        if isinstance(value, Enum) and KINDS.get(kind) is type(value):
            return {kind: value.name}
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufUM":
            return {"array": self._once(value, self.arrays, lambda: value)}
        if self._kinds.get(kind) is type(value):
            return {
                "thing": self._once(value, self.things, lambda: {kind: self._fields(value, at)})
            }
        if isinstance(value, np.generic):
            return {"number": self.text(np.asarray(value), at)}
        if isinstance(value, pd.Series):
            return {"series": self.text((_row(value), _row(value.index)), at)}
        if isinstance(value, pd.DataFrame):
            return {
                "table": self.text(
                    (
                        [_row(column) for _, column in value.items()],
                        _row(value.index),
                        dict(value.attrs),
                    ),
                    at,
                )
            }
        if isinstance(value, range):
            return {kind: [value.start, value.stop, value.step]}
        if isinstance(value, tuple | list | frozenset | Mapping) and kind in _MADE:
            return {
                kind: [
                    self.text(part, f"{at}[{number}]")
                    for number, part in enumerate(
                        value.items() if isinstance(value, Mapping) else value
                    )
                ]
            }
        if isinstance(value, date) and kind in _MADE:
            return {kind: value.isoformat()}
        raise ModelError(f"{at}: a {kind} cannot be kept in a file; pickle the result instead")

    def _fields(self, value: Any, at: str) -> list[list[object]]:
        return [
            [name, self.text(getattr(value, name), f"{at}.{name}")] for name in _names(type(value))
        ]

    def _once(self, value: object, written: list[Any], content: Callable[[], object]) -> int:
        if id(value) not in self._numbers:
            made = content()  # after the parts in it, which have smaller numbers then
            self._numbers[id(value)] = len(written)
            written.append(made)
        return self._numbers[id(value)]


class _Read:
    """The way back, with arrays and parts by their numbers."""

    def __init__(self, arrays: list[Any], things: list[Any]) -> None:
        self._parts, self._kinds = {"array": arrays, "thing": list[Any]()}, KINDS
        for array in arrays:
            array.flags.writeable = False
        for thing in things:
            ((kind, content),) = thing.items()
            self._parts["thing"].append(
                self._thing(self._kinds[kind], {name: self.value(text) for name, text in content})
            )

    def value(self, text: Any) -> Any:
        """What a text of JSON stands for."""
        if isinstance(text, list):
            return [self.value(part) for part in text]
        if not isinstance(text, dict):
            return text
        ((kind, content),) = text.items()
        if kind in self._parts:
            return self._parts[kind][content]
        if kind in KINDS:  # the name of a member of an Enum
            return KINDS[kind][content]
        return _MADE[kind](self.value(content))

    @staticmethod
    def _thing(kind: type[Any], state: dict[str, Any]) -> object:
        """A thing with its state. A field that a later version of its class has added takes its default."""
        names = _names(kind)
        if unknown := [name for name in state if name not in names]:
            raise ValueError(
                f"another version of frictopt wrote it: {kind.__name__} has no field {unknown[0]!r}"
            )
        missing = [name for name in names if name not in state and name not in _optional(kind)]
        if missing:
            raise ValueError(
                f"another version of frictopt wrote it: {kind.__name__} lacks its field {missing[0]!r}"
            )
        if not is_dataclass(kind):
            return kind(**state)
        if len(state) < len(names):  # `__init__` also makes what follows from a default
            return kind(
                **{
                    one.name: state[one.name]
                    for one in fields(kind)
                    if one.init and one.name in state
                }
            )
        made = object.__new__(kind)
        getattr(made, "__setstate__", vars(made).update)(state)
        return made


def _optional(kind: type[Any]) -> set[str]:
    """Names of the fields that have a default, or that follow from others."""
    if not is_dataclass(kind):
        return set(kind._field_defaults)
    has_default = {
        one.name
        for one in fields(kind)
        if one.default is not MISSING or one.default_factory is not MISSING
    }
    return has_default | {one.name for one in fields(kind) if not one.init}


def _row(row: Any) -> tuple[object, str, object]:
    """Name, type and entries of a column, or of an index."""
    if isinstance(row, pd.RangeIndex):
        return row.name, "int64", range(row.start, row.stop, row.step)
    return row.name, str(row.dtype), row.to_numpy() if row.dtype.kind in "biuf" else row.tolist()


def _index(name: object, kind: str, cells: Any) -> "pd.Index[Any]":
    return (
        pd.RangeIndex(cells, name=name)
        if isinstance(cells, range)
        else pd.Index(cells, dtype=kind, name=name)
    )


def _series(row: tuple[Any, str, Any], index: tuple[Any, str, Any]) -> "pd.Series[Any]":
    name, kind, cells = row
    return pd.Series(cells, index=_index(*index), dtype=kind, name=name)


def _table(
    rows: list[tuple[Any, str, Any]], index: tuple[Any, str, Any], attrs: dict[str, object]
) -> pd.DataFrame:
    columns = [_series(row, index) for row in rows]
    made = pd.DataFrame({column.name: column for column in columns}, index=_index(*index))
    made.attrs.update(attrs)
    return made
