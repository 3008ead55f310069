"""A cylinder under a normal load that varies with its shear: limit and work of a steady cycle.

They are drawn against the phase between both loads and against Dundurs' constant.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.moving_areas import BETAS, PHASES
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"phases": PHASES, "betas": BETAS}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Above: limit and work against the phase, and work against the load. Below: against beta."""
    table = tables["phases"]
    figure = new_figure(WIDE, 122)
    (left, right), of_betas = figure.subplots(2, 2)
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
    _against_beta(tables["betas"], of_betas)
    for axes, letter in zip((left, right, *of_betas), "abcd", strict=True):
        panel_label(axes, letter)
    return figure


_NAMES = {"in_phase": "in phase", "rolls": "rolls"}


def _against_beta(table: pd.DataFrame, panels: Sequence[Axes]) -> None:
    """Left: limits against beta. Right: the work of a steady cycle above them."""
    limits, works = panels
    for (cycle, rows), look in zip(table.groupby("cycle"), SERIES, strict=False):
        ordered = rows.sort_values("beta")
        name = _NAMES[str(cycle)]
        load_factor = ordered["load_factor"].iloc[0]
        limits.plot(ordered["beta"], ordered["shakedown"], label=name, **look)
        label = f"{name}, load factor {load_factor:g}"
        works.plot(ordered["beta"], ordered["dissipation"], label=label, **look)
    limits.set_ylabel("limit, load factor")
    limits.set_ylim(bottom=0)
    works.set_ylabel(r"work of a cycle $W E^* / P^2$")
    # The work in phase is thousands of times smaller than the work of rolling.
    works.set_yscale("log")
    for axes in panels:
        axes.set_xlabel(r"Dundurs' constant $\beta$")
        axes.legend()
