"""The plane of slips of two coupled nodes, at several loads.

The friction lines approach each other as the load grows, and the region of safe slips shrinks.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies.guaranteed import PLANE
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"plane": PLANE}

_SAFE = "#DCE6EE"
_NODES = {0: SERIES[0]["color"], 1: SERIES[1]["color"]}
_SENSES = {"forward": "-", "backward": (0, (4, 1.5))}
_PATHS = {
    "SHAKEDOWN": ("#009E73", "path that comes to rest"),
    "CYCLIC_SLIP": ("#CC79A7", "path that never does"),
}
_LIMITS = (-1.2, 0.95), (-0.75, 1.4)


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One panel for each load factor."""
    table = tables["plane"]
    factors = list(table.groupby("load_factor"))
    figure = new_figure(WIDE, 68)
    panels = figure.subplots(1, len(factors), sharey=True)
    for axes, letter, (_, rows) in zip(panels, "abcdefgh", factors, strict=False):
        _panel(axes, rows)
        panel_label(axes, letter)
    panels[0].set_ylabel("slip $v_2$ of node 2")
    _legend(figure)
    return figure


def _panel(axes: Any, rows: pd.DataFrame) -> None:
    safe = rows[rows["what"] == "safe"]
    axes.fill(safe["v1"], safe["v2"], color=_SAFE, lw=0)
    # The region is a single slip.
    if np.ptp(safe["v1"]) < 1e-6:
        axes.plot(safe["v1"].iloc[:1], safe["v2"].iloc[:1], "o", color=BLACK, zorder=5)
    for (what, node, sense), line in rows[rows["what"].isin(["line", "mean line"])].groupby(
        ["what", "node", "sense"]
    ):
        look = {"color": _NODES[int(node)], "linestyle": _SENSES[str(sense)]}
        axes.plot(
            line["v1"],
            line["v2"],
            **look,
            lw=1.1 if what == "line" else 0.4,
            alpha=1.0 if what == "line" else 0.7,
        )
    witness = rows[rows["what"] == "witness"]
    axes.plot(witness["v1"], witness["v2"], "o", color=BLACK, zorder=5)
    for (_, fate), path in rows[rows["what"] == "path"].groupby(["path", "sense"]):
        color = _PATHS[str(fate)][0]
        axes.plot(path["v1"], path["v2"], color=color, lw=1.4)
        axes.plot(path["v1"].iloc[:1], path["v2"].iloc[:1], "s", color=color, ms=3.5)
    axes.set_xlim(*_LIMITS[0])
    axes.set_ylim(*_LIMITS[1])
    axes.set_aspect("equal")
    axes.set_xlabel("slip $v_1$ of node 1")
    share, limit = rows["share"].iloc[0], rows["limit"].iloc[0]
    name = {
        "guaranteed limit": r"$\lambda = \lambda_1$",
        "shakedown limit": rf"$\lambda = \lambda_2 = {share:.2f}\,\lambda_1$",
    }
    axes.set_title(name.get(limit, rf"$\lambda = {share:g}\,\lambda_1$"), loc="right")


def _legend(figure: Figure) -> None:
    handles: list[Any] = [
        Line2D([], [], color=_NODES[node], linestyle=style)
        for node in _NODES
        for style in _SENSES.values()
    ]
    labels = [f"node {node + 1}, {sense}" for node in _NODES for sense in _SENSES]
    handles += [Line2D([], [], color=GREY, lw=0.4), Patch(color=_SAFE)]
    labels += ["under the mean load", "safe slips"]
    handles += [
        Line2D([], [], color=color, lw=1.4, marker="s", ms=3.5) for color, _ in _PATHS.values()
    ]
    labels += [label for _, label in _PATHS.values()]
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
