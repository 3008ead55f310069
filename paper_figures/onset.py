"""Load factor at the first slip and the first separation of the bonded contact, against friction."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.limits import FRICTION
from studies.tables import Table

from .style import GREY, NARROW, SERIES, new_figure, plain_log

TABLES: Mapping[str, Table[Any]] = {"friction": FRICTION}

_CURVES = {
    "separation_minus": r"separation, $\sigma < 0$",
    "separation_plus": r"separation, $\sigma > 0$",
    "slip_plus": r"slip, $\sigma > 0$",
    "slip_minus": r"slip, $\sigma < 0$",
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Onset on the finest mesh, for a pulled and for a pressed bulk."""
    table = tables["friction"]
    finest = table[table["elements"] == table["elements"].max()]
    # Below this friction the first slip comes before any sigma.
    bonded = finest[finest["mean_slips"] == 0]
    figure = new_figure(NARROW, 84)
    axes = figure.subplots()
    for (column, label), series in zip(_CURVES.items(), SERIES, strict=False):
        rows = bonded if column.startswith("slip") else finest
        axes.plot(
            rows["friction"],
            rows[column],
            label=label,
            color=series["color"],
            linestyle=series["linestyle"],
        )
    axes.plot(
        finest["friction"],
        finest["load_factor"],
        label=r"shakedown limit $\lambda_2$",
        color=GREY,
        lw=0.7,
    )
    axes.axvspan(0, finest["mean_demand"].iloc[0], color="0.9", lw=0)
    axes.text(
        finest["mean_demand"].iloc[0] / 2,
        5.5,
        "$P$ alone\nslips the\nedges",
        ha="center",
        va="center",
    )
    axes.set_xlim(0, finest["friction"].max())
    axes.set_ylim(0.1, 30)
    plain_log(axes, "y")
    axes.set_xlabel("coefficient of friction $f$")
    axes.set_ylabel(r"load factor $|\sigma| / (P / 2a)$")
    axes.legend(
        title=f"corner element ${finest['corner_size'].iloc[0]:.5f}\\,a$",
        loc="lower right",
        alignment="left",
    )
    return figure
