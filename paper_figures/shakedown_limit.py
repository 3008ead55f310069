"""Shakedown limit against friction and against the size of the corner element."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictopt.reference import bonded_corner
from studies.limits import CORNER, FRICTION
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"friction": FRICTION, "corner": CORNER}

_LIMIT = r"shakedown limit $\lambda_2 = \sigma / (P / 2a)$"


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: against friction for several corner sizes. Right: against the corner size.

    The right panel has several frictions.
    """
    figure = new_figure(WIDE, 84)
    left, right = figure.subplots(1, 2)
    _against_friction(left, tables["friction"])
    _against_corner(right, tables["corner"])
    panel_label(left, "a")
    panel_label(right, "b")
    return figure


def _against_friction(axes: Any, table: pd.DataFrame) -> None:
    for (size, rows), series in zip(table.groupby("corner_size", sort=False), SERIES, strict=False):
        axes.plot(
            rows["friction"],
            rows["load_factor"],
            label=f"{size:.2g}",
            color=series["color"],
            linestyle=series["linestyle"],
        )
    ratio = abs(bonded_corner()[0].traction_ratio)
    axes.axvline(ratio, color=GREY, lw=0.6)
    axes.text(
        0.96 * ratio,
        0.97,
        f"$f = {ratio:.3f}$: $|q/p|$ at\nthe bonded corner",
        ha="right",
        va="top",
        transform=axes.get_xaxis_transform(),
    )
    plain_log(axes, "xy")
    axes.set_xlim(0.095, 3.1)
    axes.set_xlabel("coefficient of friction $f$")
    axes.set_ylabel(_LIMIT)
    axes.legend(title="corner element / $a$", loc="lower right")


def _against_corner(axes: Any, table: pd.DataFrame) -> None:
    for (friction, rows), series in zip(table.groupby("friction"), SERIES, strict=False):
        sine, graded = rows[rows["grading"] == "sine"], rows[rows["grading"] != "sine"]
        axes.plot(sine["corner_size"], sine["load_factor"], **series, lw=0.8)
        axes.plot(
            graded["corner_size"],
            graded["load_factor"],
            **(series | {"linestyle": "none"}),
            mfc="white",
            mew=0.7,
        )
        coarsest = rows.loc[rows["corner_size"].idxmax()]
        axes.annotate(
            f"$f = {friction:g}$",
            (coarsest["corner_size"], coarsest["load_factor"]),
            (5, 0),
            textcoords="offset points",
            va="center",
        )
    axes.set_xscale("log")
    plain_log(axes, "y")
    axes.set_xlim(right=0.5)
    # The legend needs room.
    axes.set_ylim(bottom=0.78 * table["load_factor"].min())
    axes.set_xlabel("corner element / $a$")
    axes.set_ylabel(_LIMIT)
    handles = [
        Line2D(
            [],
            [],
            color=BLACK,
            linestyle="none",
            marker="o",
            markerfacecolor=face,
            markeredgewidth=0.7,
        )
        for face in (BLACK, "white")
    ]
    graded = table.loc[table["grading"] != "sine", "elements"].iloc[0]
    labels = [
        "nodes at $x = a\\,\\sin(\\pi t/2)$, $|t| \\leq 1$",
        f"{graded} elements, geometric grading",
    ]
    axes.legend(handles, labels, loc="lower right", handlelength=1)
