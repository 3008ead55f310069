"""Error of the steady cycle's dissipation against run time: increments of two kinds, and the exact path."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.increments import ERROR
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure

TABLES: Mapping[str, Table[Any]] = {"error": ERROR}

_MARKERS = {"qp": ("o", "frozen bounds (QP)"), "milp": ("s", "complementarity (MILP)"), "path": ("*", "exact path (energy residual)")}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Markers tell the engine, colours and lines the mesh; numbers are increments from corner to corner."""
    table = tables["error"]
    figure = new_figure(WIDE, 88)
    axes = figure.subplots()
    meshes = table["elements"].unique()
    for elements, series in zip(meshes, SERIES, strict=False):
        for engine, rows in table[table["elements"] == elements].groupby("engine", sort=False):
            look = {"color": series["color"], "linestyle": series["linestyle"], "marker": _MARKERS[engine][0], "lw": 0.8}
            axes.plot(rows["seconds"], rows["error"], **look, markersize=8 if engine == "path" else 4, mfc="white" if engine == "milp" else None)
    _steps(axes, table[(table["elements"] == meshes[-1]) & (table["engine"] == "qp")])
    _order(axes, table)
    axes.set(xscale="log", yscale="log", ylim=(1e-16, 1))
    axes.set_xlabel("run time of two cycles, s")
    axes.set_ylabel("relative error of the work of friction in a cycle")
    _legends(axes, meshes)
    return figure


def _steps(axes: Any, rows: pd.DataFrame) -> None:
    for row in rows.itertuples():
        axes.annotate(f"{row.steps}", (row.seconds, row.error), (4, 3), textcoords="offset points", va="bottom", fontsize=7, color=GREY)


def _order(axes: Any, table: pd.DataFrame) -> None:
    """Line of second order, below the points: what a run time proportional to the number of increments would give."""
    last = table[table["engine"] == "qp"].groupby("elements").last().iloc[0]
    times = last["seconds"] * np.array([0.2, 1.0])
    errors = last["error"] / 20 * np.array([25.0, 1.0])
    axes.plot(times, errors, color=BLACK, lw=0.6)
    axes.annotate("(run time)$^{-2}$", (times.prod() ** 0.5, errors.prod() ** 0.5), (-4, -2), textcoords="offset points", ha="right", va="top")


def _legends(axes: Any, meshes: Any) -> None:
    handles = [
        Line2D([], [], color=BLACK, linestyle="none", marker=marker, markersize=7 if marker == "*" else 4, mfc="white" if marker == "s" else BLACK)
        for marker, _ in _MARKERS.values()
    ]
    labels = [name for _, name in _MARKERS.values()]
    for elements, series in zip(meshes, SERIES, strict=False):
        handles.append(Line2D([], [], color=series["color"], linestyle=series["linestyle"]))
        labels.append(f"{elements} elements")
    axes.legend(handles, labels, loc="upper left", title="numbers: increments from corner to corner", alignment="left")
