"""Shear over the friction bound, and slip, along the contact through one steady cycle above the shakedown limit."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.increments import CYCLE
from studies.tables import Table

from .style import BLACK, GREY, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"cycle": CYCLE}

_STYLES = {"falls": "-", "rises": (0, (4, 1.5))}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: q / (f p). Right: slip.

    Colours show sigma; solid and dashed lines show whether sigma falls or rises.
    """
    table = tables["cycle"]
    figure = new_figure(WIDE, 88)
    left, right = figure.subplots(1, 2)
    for bound in (-1, 1):
        left.axhline(bound, color=GREY, lw=0.6)
    right.axhline(0, color=GREY, lw=0.6)
    _instants(left, right, table)
    left.set_ylim(-1.12, 1.12)
    left.set_ylabel("$q / (f p)$")
    left.set_title(
        f"$f = {table['friction'].iloc[0]:g}$,  $\\sigma_0 = "
        f"{table['load_factor'].iloc[0]:.3f}\\,P / 2a$",
        loc="right",
    )
    right.set_ylabel(r"slip $v\,E^* / (a\,P / 2a)$")
    for axes, letter in zip((left, right), "ab", strict=True):
        axes.set_xlim(-1.02, 1.02)
        axes.set_xticks([-1, -0.5, 0, 0.5, 1])
        axes.set_xlabel("$x / a$")
        panel_label(axes, letter)
    _legend(figure, sorted(set(_levels(table))))
    return figure


def _levels(table: pd.DataFrame) -> pd.Series:
    """Sigma over its amplitude, rounded."""
    return (table["sigma"] / table["load_factor"]).round(9)


def _color(level: float) -> Any:
    # The light end of the colour map is not used.
    return colormaps["viridis"](0.45 * (1 + level))


def _instants(left: Any, right: Any, table: pd.DataFrame) -> None:
    """One line for each instant; the last instant is the first one again."""
    end = table["instant"].max()
    for instant, rows in table[table["instant"] < end].groupby("instant"):
        level = _levels(rows).iloc[0]
        look = {
            "color": _color(level),
            "linestyle": _STYLES["falls" if instant <= end / 2 else "rises"],
            "lw": 1.6 if abs(level) == 1 else 0.9,
        }
        left.plot(rows["x"], rows["ratio"], **look)
        right.plot(rows["x"], rows["slip"], **look)


def _legend(figure: Figure, levels: Sequence[float]) -> None:
    handles = [Line2D([], [], color=_color(level), lw=2) for level in levels]
    labels = [
        rf"$\sigma = {level:+g}\,\sigma_0$"
        if abs(level) != 1
        else rf"$\sigma = {'+' if level > 0 else '-'}\sigma_0$"
        for level in levels
    ]
    labels = [
        r"$\sigma = 0$" if level == 0 else label
        for level, label in zip(levels, labels, strict=True)
    ]
    # The names of the two lines have the last of two columns.
    handles += [Line2D([], [], linestyle="none")] * (len(levels) % 2)
    labels += [""] * (len(levels) % 2)
    handles += [Line2D([], [], color=BLACK, lw=0.9, linestyle=style) for style in _STYLES.values()]
    figure.legend(
        handles,
        [*labels, *(f"$\\sigma$ {name}" for name in _STYLES)],
        loc="outside upper center",
        ncols=len(handles) // 2,
    )
