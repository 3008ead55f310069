"""Studies described in files of TOML, and tables of measured load histories."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd
from scipy import stats

from ..base import whole_number
from ..base.checks import distribution as checked_distribution
from ..base.entries import checked_entries, known, made, read_toml
from ..base.files import TABLES, output
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from . import starts as families
from .starts import Start

# Entries of the file of a study, and their kinds in TOML.
_KINDS: dict[str, type] = {
    "system": str,
    "cycle": dict,
    "friction": object,
    "load_factors": object,
    "starts": dict,
    "limits": object,
    "store": str,
    "table": str,
    "picture": str,
}
_NEEDED = ("system", "cycle", "friction", "load_factors")
_STARTS = ("no_slip", "safe_slips", "random_slips", "overloads")
_CYCLE = {"mean", "corners", "history", "harmonic"}  # entries of a single load cycle
_READERS = {".csv": pd.read_csv, ".xlsx": pd.read_excel, ".parquet": pd.read_parquet}


def read_plan(file: str | Path) -> tuple[dict[str, Any], dict[str, Path]]:
    """Arguments of `dissipation_study` from a file of TOML, and the files to write by their kind.

    Names of files are relative to the folder of the file. Its entries are:

    - `system`: file of the contact
    - `cycle`: the arguments of `LoadCycle`; or a `history` and other arguments of
      `LoadCycle.from_history`; or `harmonic` loads and other arguments of `LoadCycle.harmonic`; or
      several such tables, each under its label
    - `friction`: a number, a list, or a `distribution` of scipy.stats with its parameters, `draws`
      and the seed
    - `load_factors`
    - optional `starts`: name of a function of `fo.starts` -> its arguments
    - optional `limits`: true, if the table shall have the shakedown limits
    - optional `store`, `table` and `picture`: files to write

    Raises ModelError for any other file, and for an entry that the study would refuse.
    """
    path = Path(file)
    plan = checked_entries(path.name, read_toml(path), _KINDS, _NEEDED)
    files = _files_to_write(path, plan)
    system = ContactSystem.load(path.parent / plan["system"])
    arguments = {
        "system": system,
        "cycle": _cycles(path, plan["cycle"]),
        "load_factors": plan["load_factors"],
        "starts": _starts(system, plan.get("starts", {"no_slip": {}})),
        "limits": plan.get("limits", False),
    }
    if isinstance(plan["friction"], dict):
        return arguments | _distributions(**plan["friction"]), files
    return arguments | {"friction": plan["friction"]}, files


def _files_to_write(path: Path, plan: dict[str, Any]) -> dict[str, Path]:
    """The store, by default beside the plan, and the table and the picture if they are named."""
    files = {"store": path.parent / plan.get("store", f"{path.stem}.sqlite")}
    for name, endings in (("table", TABLES), ("picture", ())):
        if name in plan:
            files[name] = output(path.parent / plan[name], *endings)
    return files


def _cycles(path: Path, entry: dict[str, Any]) -> LoadCycle | dict[str, LoadCycle]:
    """The load cycle of a plan, or several by their labels."""
    if not entry or _CYCLE & set(entry):
        return _cycle("cycle", path, entry)
    return {label: _cycle(f"cycle.{label}", path, part) for label, part in entry.items()}


def _cycle(name: str, path: Path, entry: Any) -> LoadCycle:
    if not isinstance(entry, dict):
        raise ModelError(f"{name}: {entry!r}; give a table of TOML, [{name}]")
    options = dict(entry)
    if "history" in options:
        table = read_table(path.parent / str(options.pop("history")))
        return made(name, LoadCycle.from_history, options, history=table)
    if "harmonic" in options:
        loads = options.pop("harmonic")
        return made(name, LoadCycle.harmonic, options, loads=loads)
    return made(name, LoadCycle, options)


def _starts(system: ContactSystem, entry: Mapping[str, object]) -> list[Start]:
    """The starts of a plan, by functions of `fo.starts`."""
    starts = list[Start]()
    for name, options in entry.items():
        family = known("starts", name, _STARTS)
        given = {"system": system} if family == "random_slips" else {}
        starts += made(f"starts.{family}", getattr(families, family), options, **given)
    return starts


def _distributions(
    distribution: object = None, draws: object = 1, seed: object = 0, **parameters: Any
) -> dict[str, Any]:
    """Frictions that are drawn from a distribution, and their seed, as arguments of the study."""
    law = named_distribution("friction", distribution, **parameters)
    # More draws would fill the memory.
    count = whole_number("draws", draws, least=1, most=100_000)
    return {"friction": [law] * count, "seed": seed}


def named_distribution(name: str, family: object, /, *values: float, **parameters: Any) -> Any:
    """The distribution of scipy.stats of this name, with its parameters."""
    made = getattr(stats, family, None) if isinstance(family, str) else None
    if not isinstance(made, stats.rv_continuous):
        raise ModelError(
            f"{name}: distribution {family!r}; give one of scipy.stats, such as 'norm'"
        )
    try:
        return checked_distribution(name, made(*values, **parameters))
    except TypeError as error:
        raise ModelError(f"{name}: {error}; give the parameters of `scipy.stats`") from error


def read_table(file: str | Path) -> pd.DataFrame:
    """The table in a file that pandas reads; ModelError if it has another ending or no table."""
    path = Path(file)
    if path.suffix not in _READERS:
        raise ModelError(f"history: {str(file)!r}; give a file that ends in {', '.join(_READERS)}")
    try:
        table = _READERS[path.suffix](path)
    except ValueError as error:
        raise ModelError(f"history: {str(file)!r} is no table ({error})") from error
    if path.suffix == ".csv":
        _check_separators(file, table)
    for name in table.select_dtypes(exclude=["number", "datetime"]):
        # A text that is no date stays; the load cycle then refuses the column by its name.
        with suppress(ValueError, TypeError):
            table[name] = pd.to_datetime(table[name], format="ISO8601")
    return table


def _check_separators(file: str | Path, table: pd.DataFrame) -> None:
    """Refuse a file with semicolons between columns, or with rows longer than its head."""
    too_long = not isinstance(table.index, pd.RangeIndex)
    if too_long or all(";" in str(name) for name in table):
        raise ModelError(
            f"history: {str(file)!r} has semicolons between its columns, or rows with more values "
            "than names; separate columns by commas, use points in numbers, and name each column"
        )
