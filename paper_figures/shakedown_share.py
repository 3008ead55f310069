"""Share of the starts that shake down, by family, against the load factor."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.dissipation import RUNS, summary
from studies.tables import Table

from .dissipation import FAMILIES
from .style import BLACK, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"runs": RUNS}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One panel for each friction, one line for each family of starts."""
    table = summary(tables["runs"], "family")
    frictions = sorted(table["friction"].unique())
    figure = new_figure(WIDE, 72)
    panels = figure.subplots(1, len(frictions), sharex=True, sharey=True, squeeze=False)[0]
    for axes, friction, letter in zip(panels, frictions, "abcdef", strict=False):
        for family, (label, look) in FAMILIES.items():
            rows = table[(table["friction"] == friction) & (table["family"] == family)].sort_values(
                "load_ratio"
            )
            name = f"{label} ({rows['runs'].max()})" if len(rows) else None
            axes.plot(
                rows["load_ratio"],
                100 * rows["shakedown"],
                label=name,
                **look,
                mfc="white",
                mew=0.8,
            )
        axes.axvline(1, color=BLACK, lw=0.8)
        axes.annotate(r"$\lambda_2$", (1, 100), (3, -1), textcoords="offset points", va="top")
        axes.set_xlabel(r"load factor over the shakedown limit, $\lambda / \lambda_2$")
        axes.set_title(f"$f = {friction:g}$", loc="right")
        panel_label(axes, letter)
    panels[0].set_ylim(-4, 104)
    panels[0].set_ylabel("runs that shake down, %")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=len(handles),
        columnspacing=1.0,
        handletextpad=0.4,
        handlelength=2.0,
    )
    return figure
