"""Fretting of two joints under a measured history.

The figure has slip, work, fretting parameters, and the safe amplitudes of two loads.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.joint import FRETTING, REGION
from studies.tables import Table

from .style import GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"fretting": FRETTING, "region": REGION}

_UNITS = {"push": "push, kN", "tension": "tension, MPa", "pull": "pull, MPa", "sway": "sway, MPa"}
_SCALE = {"push": 1e-3}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Rows are joints. Columns are slip range, fretting parameters, and safe amplitudes.

    Fretting parameters are relative to their largest values. The amplitudes of the history stand
    beside the safe amplitudes.
    """
    fretting, region = tables["fretting"], tables["region"]
    names = list(dict.fromkeys(fretting["joint"]))
    figure = new_figure(WIDE, 14 + 52 * len(names))
    panels = figure.subplots(len(names), 3, squeeze=False)
    for row, name in zip(panels, names, strict=True):
        _slips(row[0], fretting[fretting["joint"] == name])
        _parameters(row[1], fretting[fretting["joint"] == name])
        _region(row[2], region[region["joint"] == name])
        row[0].set_title(name, loc="right")
    for number, axes in enumerate(panels.flat):
        panel_label(axes, "abcdef"[number])
    return figure


def _slips(axes: Any, table: pd.DataFrame) -> None:
    for name, part in table.groupby("contact", sort=False):
        look = SERIES[list(dict.fromkeys(table["contact"])).index(name)]
        several = table["contact"].nunique() > 1
        axes.plot(
            part["x"],
            1e3 * part["slip_range"],
            color=look["color"],
            linestyle="-",
            label=f"{name} flank" if several else None,
        )
    axes.set_xlabel("arc length, mm")
    axes.set_ylabel("slip range, µm")
    axes.set_ylim(0.0, 1.25e3 * table["slip_range"].max())
    if table["contact"].nunique() > 1:
        axes.legend(loc="upper center", ncols=2, handlelength=1.6, columnspacing=1.2)


def _parameters(axes: Any, table: pd.DataFrame) -> None:
    for look, (column, label) in zip(
        SERIES, {"F1": "$F_1$", "F2": "$F_2$", "SWT": "SWT"}.items(), strict=False
    ):
        for number, (_, part) in enumerate(table.groupby("contact", sort=False)):
            values = part[column] / (table[column].max() or 1.0)
            axes.plot(
                part["x"],
                values,
                color=look["color"],
                linestyle=look["linestyle"],
                label=label if number == 0 else None,
            )
    axes.set_xlabel("arc length, mm")
    axes.set_ylabel("over the largest value")
    axes.set_ylim(0.0, 1.25)
    axes.legend(loc="upper center", ncols=3, handlelength=1.8, columnspacing=1.0)


def _region(axes: Any, table: pd.DataFrame) -> None:
    first, second = table.iloc[0][["first", "second"]]
    a, b = table["a"] * _SCALE.get(first, 1.0), table["b"] * _SCALE.get(second, 1.0)
    vertex = table["what"] == "vertex"
    axes.fill([0.0, *a[vertex]], [0.0, *b[vertex]], color=SERIES[4]["color"], alpha=0.4, lw=0.0)
    axes.plot(a[vertex], b[vertex], color=SERIES[0]["color"], marker="o", label="safe region")
    axes.plot(
        a[~vertex], b[~vertex], color=GREY, marker="s", linestyle="none", label="history, largest"
    )
    axes.set_xlim(0.0, 1.1 * a.max())
    axes.set_ylim(0.0, 1.4 * b.max())
    axes.set_xlabel(_UNITS[first])
    axes.set_ylabel(_UNITS[second])
    axes.legend(loc="upper right")
