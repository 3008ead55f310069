"""The slip that no start avoids above the shakedown limit: proven values beside values of a search."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.range import SLIP
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"slip": SLIP}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: the weighted slip that the theorem bounds. Right: the sum of the slips of all nodes."""
    table = tables["slip"]
    figure = new_figure(WIDE, 72)
    left, right = figure.subplots(1, 2)
    found = {"ls": "none", "ms": 4}
    for (friction, rows), look in zip(table.groupby("friction"), SERIES, strict=False):
        rows, color = rows.sort_values("load_ratio"), look["color"]
        limit = rows["bound"] / (rows["load_ratio"] - 1)
        for column, marker, name in (
            ("least", "o", "least dissipation"),
            ("most", "x", "most dissipation"),
        ):
            left.plot(
                rows["load_ratio"],
                rows[column] / limit,
                marker=marker,
                mfc="none",
                color=color,
                label=f"{name}, $f = {friction:g}$",
                **found,
            )
            right.plot(
                rows["load_ratio"],
                rows[f"{column}_total"],
                marker=marker,
                mfc="none",
                color=color,
                **found,
            )
        right.plot(
            rows["load_ratio"],
            rows["proven_total"],
            ls="-",
            color=color,
            label=f"proven, $f = {friction:g}$",
        )
    ratio = [1.0, float(table["load_ratio"].max())]
    left.plot(
        ratio,
        [0.0, ratio[1] - 1],
        color=BLACK,
        label=r"proven: $(\lambda - \lambda_2) / \lambda_2$",
    )
    left.set_ylabel(r"weighted slip $\sum_k g_k \cdot v_k / \lambda_2$")
    right.set_ylabel(r"sum of nodal slips $\sum \Delta v\, E^* / (a\,P/2a)$")
    right.set_yscale("log")
    for axes, letter in ((left, "a"), (right, "b")):
        axes.set_xlabel(r"load factor over the shakedown limit, $\lambda / \lambda_2$")
        axes.legend()
        panel_label(axes, letter)
    return figure
