"""Shear over the friction bound along the contact at the shakedown limit, and the safe slip."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictopt.plots.along import friction_bounds
from frictopt.plots.style import rings
from studies.limits import REACTIONS
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"reactions": REACTIONS}

# Shares of the mechanism above which a node is marked: along the whole contact, and near its edge.
_LARGE = (
    0.05,
    0.01,
)
# Width of the panel of the corner, over a.
_CORNER = 0.03


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One row of panels for each friction.

    The panels are the ratio at both load corners, the ratio near the edge of the contact, and the
    safe slip.
    """
    table = tables["reactions"]
    frictions = table["friction"].unique()
    figure = new_figure(WIDE, 10 + 54 * len(frictions))
    panels = figure.subplots(
        len(frictions), 3, squeeze=False, width_ratios=[1.5, 1, 1.25], sharex="col"
    )
    for panel, friction in zip(panels, frictions, strict=True):
        rows = table[table["friction"] == friction]
        for axes, large in zip(panel[:2], _LARGE, strict=True):
            _ratio(axes, rows, large)
        panel[1].set_ylabel("")
        panel[0].set_title(f"$f = {friction:g}$,  $\\lambda_2 = {rows['load_factor'].iloc[0]:.4f}$")
        panel[1].set_xlim(-1 - 0.1 * _CORNER, -1 + _CORNER)
        _slip(panel[2], rows)
    for axes in panels[-1]:
        axes.set_xlabel("$x / a$")
    for axes, letter in zip(panels.flat, "abcdefghijkl", strict=False):
        panel_label(axes, letter)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    handles.append(
        Line2D([], [], color=GREY, linestyle="none", marker="o", markersize=7, mfc="none")
    )
    figure.legend(
        handles,
        [*labels, "limiting node; area: share in the mechanism"],
        loc="outside upper center",
        ncols=4,
    )
    return figure


def _ratio(axes: Any, rows: pd.DataFrame, large: float) -> None:
    friction_bounds(axes)
    for (sigma, part), series in zip(rows.groupby("sigma"), SERIES, strict=False):
        name = rf"$\sigma = {'-' if sigma < 0 else '+'}\lambda_2\,P / 2a$"
        axes.plot(
            part["x"],
            part["ratio"],
            color=series["color"],
            linestyle=series["linestyle"],
            marker=".",
            markersize=1.5,
            lw=0.8,
            label=name,
        )
        marked = part[part["share"] >= large]
        sizes = 500 * marked["share"]
        rings(axes, marked[["x", "ratio"]].to_numpy(), sizes, None, series["color"])
    axes.set_ylim(-1.2, 1.2)


def _slip(axes: Any, rows: pd.DataFrame) -> None:
    # The slip is the same at all corners.
    part = rows[rows["sigma"] == rows["sigma"].iloc[0]]
    axes.plot(part["x"], part["slip"], color=BLACK)
    axes.axhline(0, color=GREY, lw=0.6)
    axes.set_ylabel(r"safe slip $v\,E^* / (a\,P / 2a)$")
