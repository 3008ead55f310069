"""Guaranteed and shakedown limit against friction, corner size and slip bound.

Between them is the region in which the outcome depends on the start.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from studies.guaranteed import BOUND, CORNER, FRICTION
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"friction": FRICTION, "corner": CORNER, "bound": BOUND}

_SHADE = "#DCE6EE"
_GUARANTEED, _SHAKEDOWN = "-", (0, (4, 1.5))


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: against friction. Middle: against the corner element. Right: against the slip bound.

    The left panel has the finest mesh, and lambda_1 on coarser meshes.
    """
    figure = new_figure(WIDE, 80)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.4, 1, 1))
    _against_friction(left, tables["friction"])
    frictions = sorted(set(tables["corner"]["friction"]) | set(tables["bound"]["friction"]))
    looks = {friction: series["color"] for friction, series in zip(frictions, SERIES, strict=False)}
    _against(middle, tables["corner"], "corner_size", looks)
    middle.set_xlabel("corner element / $a$")
    middle.legend(
        title="$f$",
        loc="center left",
        bbox_to_anchor=(0, 0.7),
        handlelength=1.2,
        ncols=2,
        columnspacing=1.0,
    )
    _against(right, tables["bound"], "slip_bound", looks)
    right.set_xlabel(r"slip bound $v_{\max}\,E^* / (a\,P/2a)$")
    right.set_title(f"corner element {tables['bound']['corner_size'].iloc[0]:.2g} $a$", loc="right")
    for axes, letter in zip((left, middle, right), "abc", strict=True):
        panel_label(axes, letter)
    left.set_ylabel(r"load factor $\sigma / (P / 2a)$")
    _legend(figure)
    return figure


def _against_friction(axes: Any, table: pd.DataFrame) -> None:
    meshes = list(table.groupby("corner_size", sort=False))
    for (size, rows), series in zip(meshes, SERIES, strict=False):
        axes.plot(
            rows["friction"],
            rows["guaranteed"],
            color=series["color"],
            linestyle=_GUARANTEED,
            lw=0.9,
            label=f"{size:.2g}",
        )
    finest = meshes[-1][1]
    color = SERIES[len(meshes) - 1]["color"]
    axes.plot(finest["friction"], finest["shakedown"], color=color, linestyle=_SHAKEDOWN)
    axes.fill_between(
        finest["friction"], finest["guaranteed"], finest["shakedown"], color=_SHADE, lw=0
    )
    axes.text(0.88, 1.5, "the start\ndecides", ha="center", va="center")
    axes.set_xlim(table["friction"].min(), table["friction"].max())
    axes.set_ylim(0, 1.02 * finest["shakedown"].max())
    axes.set_xlabel("coefficient of friction $f$")
    axes.legend(title="corner element / $a$", loc="upper left", handlelength=1.5)


def _against(axes: Any, table: pd.DataFrame, column: str, looks: Mapping[float, str]) -> None:
    for friction, rows in table.groupby("friction"):
        ordered = rows.sort_values(column)
        axes.plot(
            ordered[column],
            ordered["guaranteed"],
            color=looks[float(friction)],
            linestyle=_GUARANTEED,
            label=f"{friction:g}",
        )
        axes.plot(
            ordered[column],
            ordered["shakedown"],
            color=looks[float(friction)],
            linestyle=_SHAKEDOWN,
        )
    plain_log(axes, "x")
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_minor_locator(LogLocator(subs="auto"))
    axes.set_ylim(bottom=0)


def _legend(figure: Figure) -> None:
    handles = [
        Line2D([], [], color=BLACK, linestyle=_SHAKEDOWN),
        Line2D([], [], color=BLACK, linestyle=_GUARANTEED),
        Patch(color=_SHADE),
    ]
    labels = [
        r"shakedown limit $\lambda_2$",
        r"guaranteed limit $\lambda_1$ (upper bound with witness)",
        "slip stops from some starts, goes on from others",
    ]
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
