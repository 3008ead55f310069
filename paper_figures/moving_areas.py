"""A cylinder under a normal load that varies with its shear: limit against the phase between them, and work of a steady cycle."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.moving_areas import PHASES
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"phases": PHASES}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: the limit, and the work at two loads, against the phase; right: the work against the load."""
    table = tables["phases"]
    figure = new_figure(WIDE, 66)
    left, right = figure.subplots(1, 2)
    limits = table.groupby("phase")["shakedown"].first()
    left.plot(limits.index, limits, color=BLACK, marker="o", linestyle="none", label="limit")
    left.set_xlabel("normal load leads shear by, degrees")
    left.set_ylabel("limit $Q / P$")
    left.set_ylim(bottom=-0.004)
    works = left.twinx()
    loads = sorted(table["load_factor"].unique())
    for load, look in zip((loads[len(loads) // 2 - 1], loads[-1]), SERIES, strict=False):
        rows = table[table["load_factor"] == load].sort_values("phase")
        works.plot(rows["phase"], rows["dissipation"], label=f"work at $Q = {load:g} P$", **look)
    works.set_ylabel(r"work of a cycle $W E^* / P^2$")
    works.set_ylim(bottom=-0.0001)
    for (phase, rows), look in zip(table.groupby("phase"), SERIES, strict=False):
        ordered = rows.sort_values("load_factor")
        slips = ordered[ordered["dissipation"] > 0]
        right.plot(slips["load_factor"], slips["dissipation"], label=f"{phase:g}°", **look)
    in_phase = limits.loc[limits.index.min()]
    right.axvline(in_phase, color=GREY, lw=0.8)
    right.set_yscale("log")
    right.set_xlabel("shear $Q / P$")
    right.set_ylabel(r"work of a cycle $W E^* / P^2$")
    right.legend(title="phase", ncols=2)
    handles, labels = left.get_legend_handles_labels()
    more, names = works.get_legend_handles_labels()
    left.legend(handles + more, labels + names, loc="center right")
    for axes, letter in zip((left, right), "ab", strict=True):
        panel_label(axes, letter)
    return figure
