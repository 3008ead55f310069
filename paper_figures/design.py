"""Best designs: profiles and limits of a punch, relief of a dovetail, bolts of a lap joint."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.design import BOLTS, LIMITS, PROFILES, RELIEF
from studies.tables import Table

from .style import GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {
    "limits": LIMITS,
    "profiles": PROFILES,
    "relief": RELIEF,
    "bolts": BOLTS,
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Above: limits and profiles of the punch. Below: pressures, dovetail, lap joint."""
    figure = new_figure(WIDE, 120)
    (upper, lower, profiles), (pressures, relief, bolts) = figure.subplots(2, 3)
    for (friction, table), look in zip(tables["limits"].groupby("friction"), SERIES, strict=False):
        for face, style in (("free", "-"), ("three shapes", "--")):
            rows = table[table["face"] == face]
            for axes, column in ((upper, "load_factor"), (lower, "guaranteed")):
                label = f"$f$ = {friction:g}" if face == "free" else None
                axes.plot(
                    rows["depth"],
                    rows[column],
                    color=look["color"],
                    linestyle=style,
                    marker=".",
                    markersize=3,
                    label=label,
                )
    most = 1.05 * float(tables["limits"]["load_factor"].max())
    for axes, name in ((upper, r"$\lambda_2$"), (lower, r"$\lambda_1$ of the same design")):
        axes.set(
            xlabel="largest depth / $(P / 2E)$", ylabel=f"{name} / $(P / 2a)$", ylim=(0.0, most)
        )
    lower.plot([], [], color=GREY, linestyle="--", label="three shapes")
    lower.legend(loc="upper left", handlelength=1.6)
    for (face, rows), look in zip(
        tables["profiles"].groupby("face", sort=False), SERIES, strict=False
    ):
        line = {"color": look["color"], "linestyle": look["linestyle"]}
        profiles.plot(
            rows["x"], rows["profile"], label=f"{face}, {rows['load_factor'].iloc[0]:.2f}", **line
        )
        pressures.plot(rows["x"], rows["pressure"], **line)
    profiles.set(xlabel="$x / a$", ylabel="material taken off / $(P / 2E)$")
    profiles.set_ylim(top=2.4 * float(tables["profiles"]["profile"].max()))
    profiles.legend(title=r"face, limit / $(P / 2a)$", loc="upper center", handlelength=1.8)
    pressures.set(xlabel="$x / a$", ylabel="mean pressure / $(P / 2a)$", ylim=(0.0, 4.0))
    for (friction, rows), look in zip(tables["relief"].groupby("friction"), SERIES, strict=False):
        relief.plot(
            rows["depth"],
            rows["load_factor"],
            color=look["color"],
            marker=".",
            markersize=3,
            label=f"$f$ = {friction:g}",
        )
    relief.set(
        xlabel="largest depth of the relief",
        ylabel=r"$\lambda_2$ of the dovetail",
        ylim=(0.0, 1.5 * float(tables["relief"]["load_factor"].max())),
    )
    relief.legend(loc="upper left", handlelength=1.6)
    table = tables["bolts"]
    for k, look in zip(range(3), SERIES, strict=False):
        bolts.plot(table["load_factor"], table[f"bolt {k}"], label=f"bolt {k}", **look)
    bolts.plot(table["load_factor"], table["total"], color=GREY, label="all")
    bolts.set(xlabel="load of the lap joint", ylabel="least forces", ylim=(0.0, None))
    bolts.legend(loc="upper left", handlelength=1.6)
    for axes, letter in zip(
        (upper, lower, profiles, pressures, relief, bolts), "abcdef", strict=True
    ):
        panel_label(axes, letter)
    return figure
