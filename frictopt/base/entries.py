"""Files in TOML: their entries, and the classes and functions that get the entries of a table."""

import difflib
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

from ..errors import ModelError
from .checks import T


def read_toml(file: Path) -> dict[str, Any]:
    """The entries of a file in TOML."""
    try:
        return tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise ModelError(f"{file.name}: {error}; give a file in TOML") from error


def checked_entries(
    where: str, table: Mapping[str, Any], kinds: Mapping[str, type], needed: Sequence[str] = ()
) -> dict[str, Any]:
    """The entries of a table by their names in `kinds` (name -> kind of the value).

    ModelError if an entry has another name or another kind, or if one that is needed is missing.
    """
    entries = by_names(f"{where}: entry", table, kinds)
    for name, value in entries.items():
        if not isinstance(value, kinds[name]):
            raise ModelError(f"{where}: {name} = {value!r}; give a {kinds[name].__name__}")
    missing = [name for name in needed if name not in entries]
    if missing:
        raise ModelError(f"{where}: {', '.join(missing)} missing; give {', '.join(needed)}")
    return entries


def by_names(what: str, table: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """The entries of a table by the `names` that they match, see `known`; each name once."""
    listed = [*names]
    entries = dict[str, Any]()
    for given, value in table.items():
        name = known(what, given, listed)
        if name in entries:
            raise ModelError(f"{what} {given!r} is given twice, as {name!r}; leave one of them out")
        entries[name] = value
    return entries


def known(what: str, name: str, names: Iterable[str], remedy: str = "") -> str:
    """The name among `names` that matches, whatever its case; else a ModelError with near names."""
    by_letters = {each.casefold(): each for each in names}
    letters = name.strip().casefold()
    if letters not in by_letters:
        near = difflib.get_close_matches(letters, by_letters, cutoff=0.4) or by_letters
        listed = [by_letters[each] for each in near]
        raise ModelError(f"{what} {name!r} is unknown; give one of {listed}{remedy}")
    return by_letters[letters]


def made(where: str, kind: Callable[..., T], table: object, **given: object) -> T:
    """The result of a class or function for the arguments in a table and the arguments `given`."""
    if not isinstance(table, Mapping):
        raise ModelError(f"{where}: {table!r}; give a table of the arguments of {kind.__name__}")
    parameters = [name for name in signature(kind).parameters if name not in given]
    arguments = by_names(where, table, parameters)
    try:
        return kind(**given, **arguments)
    except TypeError as error:  # an argument is missing
        raise ModelError(f"{where}: {error}; give a table of {', '.join(parameters)}") from error
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from error
