"""Shear against slip of a corner node and of an inner node, above the shakedown limit.

The curves lead from the contact without slip into the steady loop.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.increments import CORNER
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"corner": CORNER}

_FIRST, _STEADY = SERIES[1]["color"], SERIES[0]["color"]
_ARROW = {
    "arrowstyle": "-|>",
    "color": _STEADY,
    "mutation_scale": 11,
    "lw": 0,
    "shrinkA": 0,
    "shrinkB": 0,
}
# Marker -> sense of sigma.
_ENDS = {"v": -1, "^": 1}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: the node at the left corner of the contact; right: a node further in."""
    table = tables["corner"]
    figure = new_figure(WIDE, 84)
    panels = figure.subplots(1, 2)
    for axes, (_, rows), letter in zip(panels, table.groupby("node"), "ab", strict=True):
        _node(axes, rows)
        axes.set_xlabel(r"slip $v\,E^* / (a\,P / 2a)$")
        axes.set_ylabel("nodal shear force $q / (P / 2)$")
        axes.set_title(f"$x = {rows['x'].iloc[0]:.3g}\\,a$", loc="right")
        panel_label(axes, letter)
    left = table.iloc[0]
    note = f"$f = {left['friction']:g}$,  $\\sigma_0 = {left['load_factor']:.3f}\\,P / 2a$"
    panels[0].text(0.97, 0.04, note, ha="right", transform=panels[0].transAxes)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=len(handles),
        columnspacing=1.4,
        handlelength=2,
    )
    return figure


def _node(axes: Any, rows: pd.DataFrame) -> None:
    first, steady = (rows[rows["cycles"] == name] for name in ("first", "steady"))
    axes.plot(
        first["slip"],
        first["q"],
        color=_FIRST,
        linestyle="--",
        lw=1.0,
        label=f"first {int(first['time'].max()) // 2} cycles",
    )
    axes.plot(steady["slip"], steady["q"], color=_STEADY, lw=1.3, label="steady cycle")
    for sense in (-1, 1):
        label = r"bound $\pm f p$ in the steady cycle" if sense > 0 else None
        axes.plot(
            steady["slip"],
            sense * steady["friction"] * steady["p"],
            color=GREY,
            lw=0.6,
            linestyle=":",
            label=label,
        )
    top = steady["load_factor"].iloc[0]
    for marker, sense in _ENDS.items():
        ends = steady[np.isclose(steady["sigma"], sense * top)]
        name = rf"$\sigma = {'-' if sense < 0 else '+'}\sigma_0$"
        axes.plot(
            ends["slip"],
            ends["q"],
            color=BLACK,
            linestyle="none",
            marker=marker,
            mfc="white",
            markersize=4,
            label=name,
        )
    for sense in (-1, 1):
        _arrow(axes, steady, sense)
    start = first.iloc[0]
    axes.plot(
        start["slip"],
        start["q"],
        color=_FIRST,
        linestyle="none",
        marker="o",
        markersize=3.5,
        label=r"$P$ alone",
    )


def _arrow(axes: Any, steady: pd.DataFrame, sense: int) -> None:
    """Arrow head on the branch of one sense of slip, in the middle of its slip."""
    middle = (steady["slip"].min() + steady["slip"].max()) / 2
    slip, q, status = (steady[name].to_numpy() for name in ("slip", "q", "status"))
    crossing = np.flatnonzero(
        (status[:-1] == sense) & ((slip[:-1] - middle) * (slip[1:] - middle) < 0)
    )
    # If the node never slips, there is no arrow.
    for index in crossing[:1]:
        share = (middle - slip[index]) / (slip[index + 1] - slip[index])
        tip = (middle, (1 - share) * q[index] + share * q[index + 1])
        axes.annotate("", tip, (slip[index], q[index]), arrowprops=_ARROW)
