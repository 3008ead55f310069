"""What a study asks, from a file, and tables of measured histories."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from contextlib import suppress
from inspect import signature
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from scipy import stats

from ..base import choice
from ..base.files import WRITERS, output
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from . import starts as families
from .starts import Start

T = TypeVar("T")
_NEEDED = ("system", "cycle", "friction", "load_factors")
_KNOWN = (*_NEEDED, "starts", "store", "table", "picture")
_STARTS = ("no_slip", "safe_slips", "random_slips", "overloads")
_READERS = {".csv": pd.read_csv, ".xlsx": pd.read_excel, ".parquet": pd.read_parquet}


def read_plan(file: str | Path) -> tuple[dict[str, Any], dict[str, Path]]:
    """Arguments of `dissipation_study` from a file of TOML, and the files to be written: store, and table and picture where they are named.

    Names of files are relative to the folder of the file. `system`, `cycle` (the arguments of
    `LoadCycle`, a `history` with those of `from_history`, `harmonic` loads with those of
    `harmonic`; or tables of these by their labels), `friction` (a number, a list, or a
    `distribution` of scipy.stats with its parameters, `draws` and the seed `rng`), `load_factors`
    and, if wanted, `starts` (name of a function of `fo.starts` -> its arguments), `store`, `table`
    and `picture`. ModelError: not such a file, or something in it that the study would refuse.
    """
    path = Path(file)
    try:
        plan = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ModelError(f"{file}: {error}; give a file in TOML") from error
    unknown, missing = (
        sorted(set(plan) - set(_KNOWN)),
        [name for name in _NEEDED if name not in plan],
    )
    wrong = [
        f"{', '.join(names)} {verb}"
        for names, verb in ((unknown, "unknown"), (missing, "missing"))
        if names
    ]
    if wrong:
        raise ModelError(f"{file}: {' and '.join(wrong)}; a study has {', '.join(_KNOWN)}")
    names = {
        name: path.parent / _told(name, plan[name], str)
        for name in ("system", "store", "table", "picture")
        if name in plan
    }
    files = {"store": names.get("store", path.with_suffix(".sqlite"))}
    files |= {
        name: output(names[name], *endings)
        for name, endings in (("table", WRITERS), ("picture", ()))
        if name in names
    }
    system, friction, given = (
        ContactSystem.load(names["system"]),
        plan["friction"],
        _told("cycle", plan["cycle"], dict),
    )
    one = not given or {"mean", "corners", "history", "harmonic"} & set(given)
    cycle = (
        _cycle("cycle", path, given)
        if one
        else {label: _cycle(f"cycle.{label}", path, part) for label, part in given.items()}
    )
    drawn = _distributions(**friction) if isinstance(friction, dict) else {"friction": friction}
    begins = list[Start]()
    for name, options in _told("starts", plan.get("starts", {"no_slip": {}}), dict).items():
        first = (system,) if choice("starts", name, _STARTS) == "random_slips" else ()
        begins += _called(
            f"starts.{name}",
            getattr(families, name),
            *first,
            **_told(f"starts.{name}", options, dict),
        )
    return {
        "system": system,
        "cycle": cycle,
        "load_factors": plan["load_factors"],
        "starts": begins,
        **drawn,
    }, files


def _cycle(name: str, path: Path, told: object) -> LoadCycle:
    """A load cycle of a plan."""
    given = dict[str, Any](_told(name, told, dict))
    if "history" in given:
        return _called(
            name,
            LoadCycle.from_history,
            read_table(path.parent / str(given.pop("history"))),
            **given,
        )
    if "harmonic" in given:
        return _called(name, LoadCycle.harmonic, given.pop("harmonic"), **given)
    return _called(name, LoadCycle, **given)


def _told(name: str, value: object, kind: type[T]) -> T:
    """A part of a plan, of a kind that it needs."""
    if not isinstance(value, kind):
        raise ModelError(
            f"{name}: {value!r}; give {'the name of a file' if kind is str else f'a table of TOML, [{name}]'}"
        )
    return value


def _called(what: str, function: Callable[..., T], *first: Any, **options: Any) -> T:
    """The value of a function whose options come from a file."""
    try:
        return function(*first, **options)
    except TypeError as error:  # an option that it does not have, or lacks
        parameters = signature(function).parameters.values()
        known = [
            one.name
            for one in parameters
            if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
        ][len(first) :]
        raise ModelError(
            f"{what}: {error}" + (f"; its options are {', '.join(known)}" if known else "")
        ) from error


def _distributions(
    distribution: object = None, draws: object = 1, rng: object = 0, **parameters: Any
) -> dict[str, Any]:
    """Frictions and seed."""
    kind = getattr(stats, distribution, None) if isinstance(distribution, str) else None
    if not isinstance(kind, stats.rv_continuous) or not isinstance(draws, int):
        raise ModelError(
            f"friction: distribution {distribution!r}, draws {draws!r}; give one of scipy.stats, such as 'norm', and a number"
        )
    return {"friction": [_called("friction", kind, **parameters)] * draws, "rng": rng}


def read_table(file: str | Path) -> pd.DataFrame:
    """The table of a file of pandas; ModelError: another ending, or no table."""
    path = Path(file)
    if path.suffix not in _READERS:
        raise ModelError(f"history: {str(file)!r}; give a file that ends in {', '.join(_READERS)}")
    try:
        table = _READERS[path.suffix](path)
    except ValueError as error:
        raise ModelError(f"history: {str(file)!r} is no table ({error})") from error
    if path.suffix == ".csv" and (
        not isinstance(table.index, pd.RangeIndex) or all(";" in str(name) for name in table)
    ):
        raise ModelError(
            f"history: {str(file)!r} has semicolons between its columns, or rows of more values than names; write commas between columns and points "
            "in the numbers, and name each column"
        )
    for name in table.select_dtypes(exclude=["number", "datetime"]):
        with suppress(ValueError, TypeError):  # what is no date, the load cycle refuses by its name
            table[name] = pd.to_datetime(table[name], format="ISO8601")
    return table
