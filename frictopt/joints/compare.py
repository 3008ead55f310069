"""Reports on variants of a joint in one table: their numbers, their differences, and the best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from ..base import Kept, Plotted, checked_cases, shown
from ..base.files import unsealed
from ..errors import ModelError
from .report import Report

_MORE_IS_BETTER = ("load factor", "probability", "cycles")  # units; of other numbers less is better


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Kept, Plotted):
    """Numbers of the variants of a joint, see `compare`.

    Attributes
    ----------
    table
        DataFrame with a row for each number: number, unit, its value in each variant, its
        difference from the first variant, and `best`: the variants with the largest load factor or
        probability, or more cycles, or with the least value of other numbers; "" if all are equal.
    names
        Names of the variants.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> variants = {f: fo.report(rod, cycle, float(f), pages=1) for f in ("0.5", "0.6")}
    >>> fo.compare(variants).names
    ('0.5', '0.6')
    """

    table: pd.DataFrame
    names: tuple[str, ...]

    def __str__(self) -> str:
        return str(self.table.to_string(index=False, float_format="{:.4g}".format, na_rep="-"))

    def _answer(self) -> Mapping[str, object]:
        return dict(zip(self.table["number"], self.table["best"], strict=True))


def compare(reports: Mapping[str, Report | str | Path]) -> Comparison:
    """Compare the reports on variants of a joint, number by number.

    Parameters
    ----------
    reports
        Name of a variant -> its report, or the JSON file of a report. Differences are from the
        first one. All have the same units.

    Returns
    -------
    Comparison
        One table; `plot` draws all numbers, divided by the numbers of the first variant.

    Raises
    ------
    ModelError
        Fewer than two reports, other units, or a file that is no report.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> variants = {f: fo.report(rod, cycle, float(f), pages=1) for f in ("0.5", "0.6")}
    >>> work = fo.compare(variants).table.set_index("number").loc["work per cycle"]
    >>> round(work["0.6 - 0.5"], 4), work["best"]
    (-0.04, '0.6')
    """
    tables = {
        name: _numbers_of(name, report).set_index("number")
        for name, report in checked_cases("reports", reports, "report").items()
    }
    if len(tables) < 2:
        raise ModelError(f"reports: {list(tables)}; give two or more")
    units = pd.concat({name: table["unit"] for name, table in tables.items()}, axis=1)
    if (units.nunique(axis=1) > 1).any():
        raise ModelError(f"reports: {list(tables)}; give reports with the same units")
    values = pd.concat({name: table["value"] for name, table in tables.items()}, axis=1)
    unit = units.bfill(axis=1).iloc[:, 0]
    rising = values.mul(unit.isin(_MORE_IS_BETTER) * 2 - 1, axis=0)
    is_best = rising.eq(rising.max(axis=1), axis=0)
    first, *others = tables
    table = values.assign(**{f"{name} - {first}": values[name] - values[first] for name in others})
    table["best"] = [
        "" if row.all() else ", ".join(row.index[row]) for _, row in is_best.iterrows()
    ]
    table.insert(0, "unit", unit)
    return Comparison(table.reset_index(names="number"), tuple(tables))


def _numbers_of(name: str, report: object) -> pd.DataFrame:
    """The numbers of a report, or of its file, in which infinity is a text."""
    if isinstance(report, Report):
        return report.numbers
    if isinstance(report, str | Path):
        return pd.DataFrame(unsealed(report)["numbers"]).astype({"value": float})
    raise ModelError(f"reports[{name!r}]: {shown(report)}; give a report or its JSON file")
