"""Square punch in three dimensions: error against the number of increments, and times against size."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.size import SIZES
from studies.spatial import STEPS
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label, whole_decades

TABLES: Mapping[str, Table[Any]] = {"steps": STEPS, "times": SIZES}

_QUESTIONS = (
    "condense",
    "shakedown limit",
    "limit, nothing left out",
    "safe slip",
    "guaranteed limit",
)


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: error of the dissipation, and its estimate in the result. Right: processor times."""
    figure = new_figure(WIDE, 74)
    left, right = figure.subplots(1, 2)
    _errors(left, tables["steps"])
    _times(right, tables["times"])
    panel_label(left, "a")
    panel_label(right, "b")
    return figure


def _errors(axes: Any, table: pd.DataFrame) -> None:
    for (load, rows), series in zip(table.groupby("load", sort=False), SERIES, strict=False):
        axes.plot(rows["steps"], rows["error"], label=load, **series)
        axes.plot(
            rows["steps"], rows["step_error"], **(series | {"linestyle": "none"}), mfc="white"
        )
    whole_decades(axes, "y")
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("increments from corner to corner")
    axes.set_ylabel("relative error of the dissipation per cycle")
    handles, labels = axes.get_legend_handles_labels()
    handles.append(
        Line2D([], [], color=BLACK, linestyle="none", marker="o", markerfacecolor="white")
    )
    axes.legend(handles, [*labels, "as told by the result"], loc="lower left")


def _times(axes: Any, table: pd.DataFrame) -> None:
    for question, series in zip(_QUESTIONS, SERIES, strict=False):
        rows = table.query("scene == 'space' and question == @question")
        axes.plot(rows["nodes"], rows["seconds"], label=question, **series)
    whole_decades(axes, "xy")
    # The legend needs room.
    axes.set_ylim(top=30 * axes.get_ylim()[1])
    axes.set_xlabel("node pairs $N$")
    axes.set_ylabel("processor time, s")
    axes.legend(loc="upper left")
