"""Studies in files: what a study asks, as TOML."""

import tomllib
from collections.abc import Callable, Mapping
from contextlib import suppress
from inspect import signature
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from scipy import stats

from ..contact import ContactSystem, LoadCycle
from ..contact.files import WRITERS, output
from ..errors import ModelError
from . import starts

T = TypeVar("T")
_NEEDED = ("system", "cycle", "friction", "load_factors")
_KNOWN = (*_NEEDED, "starts", "store", "table", "picture")
_STARTS = ("no_slip", "safe_slips", "random_slips", "overloads")
_READERS = {".csv": pd.read_csv, ".xlsx": pd.read_excel, ".parquet": pd.read_parquet}


def read_plan(file: str | Path) -> tuple[dict[str, Any], dict[str, Path]]:
    """Arguments of `dissipation_study` from a file, and the files to be written: store, and table and picture where they are named.

    Names of files are relative to the folder of the file. `system`, `cycle` (the arguments of `LoadCycle`, or a `history` with those of
    `from_history`), `friction` (a number, a list, or a `distribution` of scipy.stats with its parameters, `draws` and the seed `rng`), `load_factors`
    and, if wanted, `starts` (name of a function of `fo.starts` -> its arguments), `store`, `table` and `picture`.

    Raises
    ------
    ModelError
        Not such a file, or something in it that the study would refuse.
    """
    path = Path(file)
    try:
        plan = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ModelError(f"{file}: {error}; give a file in TOML") from error
    unknown, missing = sorted(set(plan) - set(_KNOWN)), [name for name in _NEEDED if name not in plan]
    if unknown or missing:
        wrong = [f"{', '.join(names)} {verb}" for names, verb in ((unknown, "unknown"), (missing, "missing")) if names]
        raise ModelError(f"{file}: {' and '.join(wrong)}; a study has {', '.join(_KNOWN)}")
    for name in ("system", "store", "table", "picture"):
        if not isinstance(plan.get(name, ""), str):
            raise ModelError(f"{name}: {plan[name]!r}; give the name of a file")
    system = ContactSystem.load(path.parent / plan["system"])
    question = {
        "system": system,
        "cycle": _cycle(_mapping("cycle", plan["cycle"]), path.parent),
        "load_factors": plan["load_factors"],
        "starts": _starts(_mapping("starts", plan.get("starts", {"no_slip": {}})), system),
        **_friction(plan["friction"]),
    }
    files = {"store": path.parent / plan.get("store", f"{path.stem}.sqlite")}
    for name, endings in (("table", WRITERS), ("picture", {})):
        if name in plan:
            files[name] = output(path.parent / plan[name], *endings)
    return question, files


def read_table(file: str | Path) -> pd.DataFrame:
    """The table of a file of pandas.

    Raises
    ------
    ModelError
        Another ending, or no table.
    """
    path = Path(file)
    if path.suffix not in _READERS:
        raise ModelError(f"history: {str(file)!r}; give a file that ends in {', '.join(_READERS)}")
    try:
        table = _READERS[path.suffix](path)
    except (ValueError, pd.errors.ParserError) as error:
        raise ModelError(f"history: {str(file)!r} is no table ({error})") from error
    if path.suffix == ".csv" and (not isinstance(table.index, pd.RangeIndex) or all(";" in str(name) for name in table)):
        raise ModelError(
            f"history: {str(file)!r} has semicolons between its columns, or rows of more values than names; write commas between columns and points "
            "in the numbers, and name each column"
        )
    for name in table.select_dtypes(exclude=["number", "datetime"]):
        with suppress(ValueError, TypeError):  # what is no date, the load cycle refuses by its name
            table[name] = pd.to_datetime(table[name], format="ISO8601")
    return table


def _cycle(plan: Mapping[str, Any], folder: Path) -> LoadCycle:
    given = dict(plan)
    if "history" not in given:
        return _called("cycle", LoadCycle, **given)
    return _called("cycle", LoadCycle.from_history, read_table(folder / str(given.pop("history"))), **given)


def _friction(friction: object) -> dict[str, Any]:
    """Frictions and seed."""
    if not isinstance(friction, Mapping):
        return {"friction": friction}
    parameters = dict(friction)
    name, draws, rng = parameters.pop("distribution", None), parameters.pop("draws", 1), parameters.pop("rng", 0)
    kind = getattr(stats, name, None) if isinstance(name, str) else None
    if not isinstance(kind, stats.rv_continuous) or not isinstance(draws, int):
        raise ModelError(f"friction: distribution {name!r}, draws {draws!r}; give a continuous one of scipy.stats, such as 'norm', and a number")
    return {"friction": [_called("friction", kind, **parameters)] * draws, "rng": rng}


def _starts(plan: Mapping[str, Any], system: ContactSystem) -> list[starts.Start]:
    made = list[starts.Start]()
    for name, options in plan.items():
        if name not in _STARTS:
            raise ModelError(f"starts: {name!r} is unknown; give {', '.join(_STARTS)}, with their arguments")
        first = (system,) if name == "random_slips" else ()
        made += _called(f"starts.{name}", getattr(starts, name), *first, **_mapping(f"starts.{name}", options))
    return made


def _mapping(name: str, value: object) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ModelError(f"{name}: {value!r}; give a table of TOML, [{name}]")
    return value


def _called(what: str, function: Callable[..., T], *first: Any, **options: Any) -> T:
    """The value of a function whose options come from a file."""
    try:
        return function(*first, **options)
    except TypeError as error:  # an option that it does not have, or lacks
        known = [
            name for name, one in signature(function).parameters.items() if one.kind is not one.VAR_POSITIONAL and one.kind is not one.VAR_KEYWORD
        ]
        raise ModelError(f"{what}: {error}" + (f"; its options are {', '.join(known[len(first) :])}" if known else "")) from error
