"""The fatigue band of a rounded punch: along the contact, and its largest value against the mesh."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.fatigue_band import ALONG, MESH
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"along": ALONG, "mesh": MESH}

_SHADE = "#DCE6EE"


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left and middle: the band on the face and at a depth. Right: `most` over the element size.

    The straight line has the growth that theory gives for the face.
    """
    figure = new_figure(WIDE, 72)
    face, below, mesh = figure.subplots(1, 3)
    parts = tables["along"].groupby("depth")
    for axes, (depth, rows) in zip((face, below), parts, strict=True):
        _band(axes, rows)
        axes.set_title(f"depth {depth:g} $a$" if depth else "face", loc="right")
    face.set_ylabel("SWT over $(P / 2a)^2 / E$")
    _mesh(mesh, tables["mesh"])
    for axes, letter in zip((face, below, mesh), "abc", strict=True):
        panel_label(axes, letter)
    handles, labels = face.get_legend_handles_labels()
    more, names = mesh.get_legend_handles_labels()
    figure.legend([*handles, *more], [*labels, *names], loc="outside upper center", ncols=5)
    return figure


def _band(axes: Any, rows: pd.DataFrame) -> None:
    x = rows["x"]
    axes.fill_between(
        x, rows["least"], rows["most"], color=_SHADE, lw=0, label="all states of rest"
    )
    axes.fill_between(
        x, rows["seen_least"], rows["seen_most"], color=GREY, alpha=0.4, lw=0, label="transients"
    )
    axes.plot(x, rows["best"], color=SERIES[0]["color"], label="least largest value")
    axes.plot(x, rows["assembled"], color=SERIES[1]["color"], ls="--", label="no initial slip")
    # Values of 0 stay visible above the axis.
    axes.set_ylim(-0.03 * rows["most"].max(), 1.08 * rows["most"].max())
    axes.set_xlabel("$x / a$")


def _mesh(axes: Any, table: pd.DataFrame) -> None:
    for (depth, rows), series in zip(table.groupby("depth"), SERIES[2:], strict=False):
        label = f"depth {depth:g} $a$" if depth else "face, $x = 0$"
        axes.plot(rows["size"], rows["most"], **series, lw=0.8, label=label)
    on_face = table[table["depth"] == 0].sort_values("size")
    coarse, size = on_face.iloc[-1], on_face["size"]
    law = coarse["most"] + coarse["growth"] * np.log(coarse["size"] / size)
    axes.plot(size, law, color=BLACK, lw=0.8, ls=":", label="growth by theory")
    plain_log(axes, "x")
    axes.set_ylim(0.0, 1.15 * table["most"].max())
    axes.set_xlabel("element / $a$")
    axes.set_ylabel("largest SWT below $x = 0$")
