"""Meshes of dovetail, pin and rounded punch, and their shakedown limits against friction."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import frictopt as fo
from frictopt.plots.bodies import draw_mesh
from studies.scenes import LIMITS, punch
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"limits": LIMITS}

_FIRST, _SECOND = SERIES[1]["color"], SERIES[0]["color"]
_CASES = {"to and fro": "force to and fro", "rotating": "rotating force", "plate": "pulled plate"}
_LOAD = {
    "arrowstyle": "-|>",
    "mutation_scale": 6,
    "lw": 0.8,
    "color": BLACK,
    "shrinkA": 0,
    "shrinkB": 0,
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Above: scenes. Below: limits."""
    table = tables["limits"]
    figure = new_figure(WIDE, 118)
    axes = figure.subplots(2, 3, height_ratios=[1.0, 1.05])
    for column, picture in zip(axes[0], (_dovetail, _pin, _punch), strict=True):
        picture(column)
        column.set_aspect("equal")
        column.set_axis_off()
    _dovetail_limits(axes[1, 0], table[(table["scene"] == "dovetail") & (table["case"] == "pull")])
    _pin_limits(axes[1, 1], table[table["scene"] == "pin"])
    _punch_limits(axes[1, 2], table[table["scene"] == "punch"])
    for letter, panel in zip("abcdef", axes.ravel(), strict=True):
        panel_label(panel, letter)
    axes[1, 0].set_ylabel(r"load factor $\lambda$")
    return figure


def _bodies(axes: Any, model: Any, window: tuple[float, float, float, float]) -> None:
    for body, color in zip(model.bodies.values(), (_FIRST, _SECOND), strict=True):
        draw_mesh(axes, body.mesh, color)
    axes.set_xlim(window[:2])
    axes.set_ylim(window[2:])


def _arrow(axes: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate("", end, start, arrowprops=_LOAD)


def _dovetail(axes: Any) -> None:
    scene = fo.scenes.Dovetail(angle=45.0, elements=12)
    _bodies(axes, scene.model(), (-3.2, 3.2, -2.6, 3.3))
    for x in (-0.6, 0.0, 0.6):
        _arrow(axes, (x, 2.4), (x, 3.2))
    axes.text(1.2, 2.8, "pull", va="center")


def _pin(axes: Any) -> None:
    _bodies(axes, fo.scenes.PinInPlate(elements=32).model(), (-2.6, 2.6, -2.4, 2.4))
    _arrow(axes, (0.0, 0.0), (0.8, 0.0))
    axes.text(
        0.35, 0.12, "$F$", ha="center", bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5}
    )


def _punch(axes: Any) -> None:
    scene = punch(0.5, 24)
    model = scene.model()
    _bodies(axes, model, (-2.6, 2.6, -2.1, 2.9))
    for x in (-0.6, 0.0, 0.6):
        _arrow(axes, (x, 2.75), (x, 2.05))
    axes.text(0.95, 2.45, "$P$", va="center")
    _arrow(axes, (1.7, -1.0), (2.5, -1.0))
    axes.text(
        2.1,
        -0.75,
        r"$\sigma$",
        ha="center",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
    )


def _dovetail_limits(axes: Any, table: pd.DataFrame) -> None:
    for (angle, rows), series in zip(table.groupby("parameter"), SERIES, strict=False):
        finite = rows[np.isfinite(rows["load_factor"])]
        share = finite["friction"] * np.tan(np.radians(angle))
        axes.plot(share, finite["load_factor"], label=rf"$\theta = {angle:g}\degree$", **series)
    axes.axvline(1.0, color=GREY, lw=0.7)
    axes.text(0.97, 0.06, "locks beyond", rotation=90, ha="right", va="bottom", color=GREY)
    axes.set_xlim(0, 1.05)
    axes.set_ylim(0, 1.05)
    axes.set_xlabel(r"friction $f\,\tan\theta$")
    axes.legend(title=r"pull, $\lambda_2$", loc="upper left", alignment="left")


def _pin_limits(axes: Any, table: pd.DataFrame) -> None:
    for (case, label), series in zip(_CASES.items(), SERIES, strict=False):
        rows = table[table["case"] == case]
        axes.plot(rows["friction"], rows["load_factor"], label=label, **series)
        axes.plot(rows["friction"], rows["guaranteed"], color=series["color"], lw=0.6)
    f = np.linspace(0.0, table["friction"].max(), 50)
    axes.plot(
        f,
        2 * f / (f + np.hypot(1, f)),
        color=BLACK,
        lw=0.7,
        linestyle=(0, (1, 1)),
        label="first slip, pulled plate",
    )
    axes.set_xlim(0, None)
    axes.set_ylim(0, 8.5)
    axes.set_xlabel("coefficient of friction $f$")
    axes.legend(title=r"$\lambda_2$; thin: $\lambda_1$", loc="upper left", alignment="left")


def _punch_limits(axes: Any, table: pd.DataFrame) -> None:
    for (radius, rows), series in zip(table.groupby("parameter", sort=False), SERIES, strict=False):
        label = "sharp" if np.isinf(radius) else f"$R = {radius:g}\\,a$"
        axes.plot(rows["friction"], rows["load_factor"], label=label, **series)
    axes.set_xlim(0, None)
    axes.set_ylim(0, None)
    axes.set_xlabel("coefficient of friction $f$")
    axes.legend(title=r"edges, $\lambda_2$", loc="upper left", alignment="left")
