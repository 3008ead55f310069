"""Square punch in three dimensions: shakedown limit against friction, and the face of the contact at the limit."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.space import FRICTION
from studies.spatial import MAPS
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"limits": FRICTION, "maps": MAPS}

_FACES = ("bulk", "turning, 4 corners")


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: limits. Middle and right: traction ratio at the first corner, and safe slip.

    The length of an arrow stands below.
    """
    figure = new_figure(WIDE, 66)
    left, *faces = figure.subplots(1, 3, width_ratios=(1.15, 1, 1))
    _limits(left, tables["limits"])
    panel_label(left, "a")
    for axes, load, letter in zip(faces, _FACES, "bc", strict=True):
        rows = tables["maps"][tables["maps"]["load"] == load]
        shown = _face(axes, rows)
        axes.set_title(
            f"({letter}) {load}, $\\lambda_2 = {rows['load_factor'].iloc[0]:.3f}$", loc="left"
        )
    figure.colorbar(shown, ax=faces, label=r"$|q| / (f p)$ at the first corner", shrink=0.85)
    return figure


def _limits(axes: Any, table: pd.DataFrame) -> None:
    for (load, rows), series in zip(table.groupby("load", sort=False), SERIES, strict=False):
        axes.plot(rows["friction"], rows["shakedown"], label=load, **series)
    plain_log(axes, "xy")
    axes.set_xlabel("coefficient of friction $f$")
    axes.set_ylabel(r"shakedown limit $\lambda_2$ / mean pressure")
    # The legend needs room.
    axes.set_ylim(top=9 * table["shakedown"].max())
    axes.legend(loc="upper left")


def _face(axes: Any, rows: pd.DataFrame) -> Any:
    x, y = np.unique(rows["x"]), np.unique(rows["y"])
    grid = rows.pivot(index="y", columns="x", values="first_ratio").to_numpy()
    shown = axes.pcolormesh(
        x,
        y,
        np.clip(grid, 0.0, 1.0),
        cmap="cividis",
        vmin=0.0,
        vmax=1.0,
        shading="nearest",
        rasterized=True,
    )
    arrows = axes.quiver(
        rows["x"],
        rows["y"],
        rows["slip1"],
        rows["slip2"],
        color=BLACK,
        pivot="mid",
        width=0.006,
        headwidth=3.5,
    )
    # The length of the longest arrow, rounded to one digit.
    size = float(f"{np.hypot(rows['slip1'], rows['slip2']).max():.0e}")
    axes.quiverkey(
        arrows,
        0.86,
        -0.27,
        size,
        f"$v E / (a \\bar p)$ = {size:g}",
        labelpos="W",
        coordinates="axes",
    )
    axes.set_aspect("equal")
    axes.set_xlabel("$x / a$")
    axes.set_ylabel("$y / a$")
    return shown
