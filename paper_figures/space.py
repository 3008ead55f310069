"""Both limits in three dimensions against friction and mesh, and the work between the limits."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.space import FRICTION, MESH, WORK
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"friction": FRICTION, "mesh": MESH, "work": WORK}

_LIMITS = {
    "shakedown": ("-", r"$\lambda_2$"),
    "guaranteed": ("--", r"$\lambda_1$"),
    "onset": (":", "onset"),
}
_MESH = (
    ("square punch", "bulk"),
    ("square punch", "turning, 4 corners"),
    ("sphere", "turning, 4 corners"),
)


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: square punch against friction. Middle: against the mesh. Right: work.

    The work is drawn over the load factor.
    """
    figure = new_figure(WIDE, 66)
    friction, mesh, work = figure.subplots(1, 3)
    for (load, rows), look in zip(
        tables["friction"].groupby("load", sort=False), SERIES, strict=False
    ):
        _limits(friction, rows, "friction", look["color"])
        friction.plot([], [], color=look["color"], label=str(load))
    plain_log(friction, "xy")
    friction.set_xlabel("coefficient of friction $f$")
    friction.set_ylabel("load factor / mean pressure")
    _legend(friction)
    for (scene, load), look in zip(_MESH, SERIES, strict=False):
        rows = tables["mesh"].query("scene == @scene and load == @load")
        _limits(mesh, rows, "nodes", look["color"], marker=look["marker"])
        mesh.plot(
            [],
            [],
            color=look["color"],
            marker=look["marker"],
            label=f"{scene}, {load.split(',')[0]}",
        )
    plain_log(mesh, "xy")
    mesh.set_xlabel("node pairs $N$")
    mesh.set_ylabel("load factor")
    # The legend needs room.
    mesh.set_ylim(top=10 * mesh.get_ylim()[1])
    mesh.legend(loc="upper right")
    rows = tables["work"]
    work.fill_between(
        rows["ratio"], rows["least"], rows["most"], color=GREY, alpha=0.4, lw=0, label="all starts"
    )
    work.plot(rows["ratio"], rows["work"], label="no slip", **SERIES[0])
    for place, name in ((rows["guaranteed"].iloc[0], "guaranteed"), (1.0, "shakedown")):
        line, words = _LIMITS[name]
        work.axvline(place, color=BLACK, linestyle=line, lw=0.8, label=words)
    work.set_xlabel(r"load factor / $\lambda_2$")
    work.set_ylabel(r"work of friction per cycle $W E / (a^3 \bar p^2)$")
    # The legend needs room.
    work.set_ylim(0.0, 1.5 * rows["most"].max())
    work.legend(
        loc="upper left",
        ncols=2,
        columnspacing=1.0,
        handlelength=1.6,
        frameon=True,
        framealpha=1.0,
        edgecolor="none",
    )
    for axes, letter in zip((friction, mesh, work), "abc", strict=True):
        panel_label(axes, letter)
    return figure


def _limits(axes: Any, rows: pd.DataFrame, over: str, color: str, marker: str = "") -> None:
    for name, (line, _) in _LIMITS.items():
        axes.plot(
            rows[over], rows[name].where(rows[name] > 0), color=color, linestyle=line, marker=marker
        )


def _legend(axes: Any) -> None:
    """Colours show loads, lines show limits."""
    handles, labels = axes.get_legend_handles_labels()
    for line, words in _LIMITS.values():
        handles.append(Line2D([], [], color=BLACK, linestyle=line))
        labels.append(words)
    axes.set_ylim(top=12 * axes.get_ylim()[1])
    axes.legend(handles, labels, loc="upper left", ncols=2, columnspacing=1.0, handlelength=1.6)
