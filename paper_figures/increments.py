"""Error of the steady cycle's dissipation against run time, for increments and the exact path."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.tables import Table
from studies.validation.error_vs_time.study import ERROR

from .style import BLACK, GREY, SERIES, WIDE, new_figure

TABLES: Mapping[str, Table[Any]] = {"error": ERROR}

_MARKERS = {
    "frictopt, increments": ("o", "increments"),
    "frictopt, exact path": ("*", "exact path (energy residual)"),
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Markers show the engine, colours and lines the mesh; numbers are increments per segment."""
    table = tables["error"].query("computation == 'transient' and nodes > 0 and rival == ''")
    figure = new_figure(WIDE, 88)
    axes = figure.subplots()
    meshes = table["nodes"].unique()
    for nodes, series in zip(meshes, SERIES, strict=False):
        for engine, rows in table[table["nodes"] == nodes].groupby("method", sort=False):
            marker = _MARKERS[engine][0]
            look = {
                "color": series["color"],
                "linestyle": series["linestyle"],
                "marker": marker,
                "lw": 0.8,
            }
            axes.plot(
                rows["seconds"],
                rows["error"],
                **look,
                markersize=8 if marker == "*" else 4,
            )
    _steps(
        axes, table[(table["nodes"] == meshes[-1]) & (table["method"] == "frictopt, increments")]
    )
    _order(axes, table)
    axes.set(xscale="log", yscale="log", ylim=(1e-16, 1))
    axes.set_xlabel("run time of two cycles, s")
    axes.set_ylabel("relative error of the work of friction in a cycle")
    _legends(axes, meshes)
    return figure


def _steps(axes: Any, rows: pd.DataFrame) -> None:
    for row in rows.itertuples():
        axes.annotate(
            row.setting,
            (row.seconds, row.error),
            (4, 3),
            textcoords="offset points",
            va="bottom",
            fontsize=7,
            color=GREY,
        )


def _order(axes: Any, table: pd.DataFrame) -> None:
    """Line of second order below the points.

    A run time proportional to the number of increments would give this line.
    """
    last = table[table["method"] == "frictopt, increments"].groupby("nodes").last().iloc[0]
    times = last["seconds"] * np.array([0.2, 1.0])
    errors = last["error"] / 20 * np.array([25.0, 1.0])
    axes.plot(times, errors, color=BLACK, lw=0.6)
    axes.annotate(
        "(run time)$^{-2}$",
        (times.prod() ** 0.5, errors.prod() ** 0.5),
        (-4, -2),
        textcoords="offset points",
        ha="right",
        va="top",
    )


def _legends(axes: Any, meshes: Any) -> None:
    handles = [
        Line2D(
            [],
            [],
            color=BLACK,
            linestyle="none",
            marker=marker,
            markersize=7 if marker == "*" else 4,
            mfc=BLACK,
        )
        for marker, _ in _MARKERS.values()
    ]
    labels = [name for _, name in _MARKERS.values()]
    for nodes, series in zip(meshes, SERIES, strict=False):
        handles.append(Line2D([], [], color=series["color"], linestyle=series["linestyle"]))
        labels.append(f"N = {nodes}")
    axes.legend(
        handles,
        labels,
        loc="upper left",
        title="numbers: increments from corner to corner",
        alignment="left",
    )
