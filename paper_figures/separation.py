"""Limits of contacts that open: a cylinder, rounded punches, a flat punch and a pin."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.separation import CLOSED, CYLINDER, FULL, ROUNDED, exponent
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"cylinder": CYLINDER, "rounded": ROUNDED, "closed": CLOSED}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """The cylinder and rounded punches over the mesh, punches over friction, and moving nodes.

    The right panel has a flat punch and a pin, whose nodes open in each cycle.
    """
    figure = new_figure(WIDE, 66)
    first, second, third, fourth = figure.subplots(1, 4)
    _cylinder(first, tables["cylinder"])
    rounded = tables["rounded"]
    same = rounded[rounded["friction"] == FULL.friction]
    for (size, rows), look in zip(same.groupby("rounding"), SERIES, strict=False):
        ordered = rows.sort_values("elements")
        second.plot(2 / ordered["elements"], ordered["shakedown"], label=f"{size:g}", **look)
    plain_log(second, "xy")
    second.set_xlabel("mean element / $a$")
    meshes = rounded["elements"].value_counts()
    several = rounded[rounded["elements"] == meshes.index[0]]
    for (_, rows), look in zip(several.groupby("rounding"), SERIES, strict=False):
        ordered = rows.sort_values("friction")
        third.plot(ordered["friction"], ordered["shakedown"], **look)
    third.set_xlabel("coefficient of friction $f$")
    third.set_ylim(bottom=0)
    for (name, rows), look in zip(tables["closed"].groupby("scene"), SERIES[5:], strict=False):
        fourth.plot(
            rows["friction"], rows["shakedown"] / rows["all_closed"], label=str(name), **look
        )
        fourth.plot(
            rows["friction"],
            rows["rests"] / rows["all_closed"],
            color=BLACK,
            marker="x",
            linestyle="none",
            markersize=4,
        )
    fourth.set_xlabel("coefficient of friction $f$")
    first.set_ylabel("load factor $Q / fP$")
    for axes in (second, third):
        axes.set_ylabel(r"load factor $\sigma / (P / 2a)$")
    fourth.plot(
        [],
        [],
        color=BLACK,
        marker="x",
        linestyle="none",
        markersize=4,
        label="transients rest up to",
    )
    fourth.set_ylabel(r"limit with events / all nodes closed")
    for axes, letter in zip((first, second, third, fourth), "abcd", strict=True):
        panel_label(axes, letter)
    handles, labels = [], []
    for axes in (first, second, fourth):
        more, names = axes.get_legend_handles_labels()
        handles += more
        labels += [f"rounding $s$ = {name}" if axes is second else name for name in names]
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return figure


def _cylinder(axes: Any, table: pd.DataFrame) -> None:
    size = np.geomspace(table["size"].min(), table["size"].max(), 50)
    power = exponent(table["size"], table["shakedown"])
    axes.plot(
        table["size"],
        table["shakedown"],
        color=BLACK,
        marker="o",
        linestyle="none",
        label=f"cylinder: exponent {power:.2f}",
    )
    axes.plot(size, 1 - (1 - size) ** 2, color=GREY, label="partial slip of one cell")
    plain_log(axes, "xy")
    axes.set_xlabel("cell / $a$")
