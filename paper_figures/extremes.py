"""Residual and error of every answer at the extremes, and how many questions were refused."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.tables import Table
from studies.validation.extremes.study import EXTREMES

from .style import BLACK, GREY, SERIES, WIDE, new_figure

TABLES: Mapping[str, Table[Any]] = {"extremes": EXTREMES}
# Smaller values are drawn here.
_FLOOR = 1e-17
# Distance of the marks from the middle of a line.
_SHIFT = 0.17
_MARKS: Mapping[str, dict[str, Any]] = {
    "residual": {"color": SERIES[0]["color"], "marker": "o", "mfc": "white"},
    "error": {"color": SERIES[1]["color"], "marker": "s"},
    "mesh": {"color": GREY, "marker": "D"},
}
_LABELS = {
    "residual": "residual of the answer",
    "error": "error against the reference",
    "mesh": "the same, where it is the error of the mesh",
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One line for each extreme; the number at the right is the number of refused questions."""
    table = tables["extremes"]
    names = list(dict.fromkeys(table["extreme"]))
    figure = new_figure(WIDE, 88)
    axes = figure.add_subplot()
    for line, name in enumerate(names):
        rows = table[table["extreme"] == name]
        answered = rows[rows["verdict"] != "refused"]
        _marks(axes, answered["residual"], line - _SHIFT, "residual")
        _marks(axes, answered.loc[answered["verdict"] != "mesh", "error"], line + _SHIFT, "error")
        _marks(axes, answered.loc[answered["verdict"] == "mesh", "error"], line + _SHIFT, "mesh")
        axes.annotate(
            f"{len(rows) - len(answered)} of {len(rows)}",
            (1.01, line),
            xycoords=("axes fraction", "data"),
            va="center",
        )
    axes.axvline(1e-9, color=BLACK, lw=0.6, ls="--")
    axes.annotate("refused", (1.01, -0.9), xycoords=("axes fraction", "data"), va="center")
    axes.set(
        xscale="log",
        xlim=(_FLOOR / 3, 3),
        ylim=(len(names) - 0.5, -0.5),
        yticks=range(len(names)),
        yticklabels=[name.replace("lambda_2", r"$\lambda_2$") for name in names],
    )
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(
        "residual, relative error (at least $10^{-17}$; dashed: tolerance of residuals)"
    )
    axes.set_ylabel("what is extreme")
    handles = [
        Line2D([], [], linestyle="none", markersize=4, label=_LABELS[kind], **mark)
        for kind, mark in _MARKS.items()
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3)
    return figure


def _marks(axes: Any, values: pd.Series, line: float, kind: str) -> None:
    values = np.maximum(values.dropna().to_numpy(), _FLOOR)
    axes.plot(
        values,
        np.full(len(values), line),
        linestyle="none",
        markersize=3.5,
        alpha=0.8,
        **_MARKS[kind],
    )
