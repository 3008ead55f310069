"""Steady dissipation against the load, with a mark for every start.

Between the guaranteed and the shakedown limit the outcome depends on the start.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from studies.dissipation import LIMITS, RUNS
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"runs": RUNS, "limits": LIMITS}

FAMILIES: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "smooth": ("smooth random slip", SERIES[0]),
    "rough": ("rough random slip", SERIES[1]),
    "overload": ("overload before", SERIES[2]),
    "safe": ("multiple of the safe slip", SERIES[3]),
    "none": ("no initial slip", SERIES[6]),
}
"""Family of starts -> its name in legends and its look."""

# Distance of the families of one load, in load ratios. It is so small that no mark seems to lie
# beyond the limit.
_WIDTH = 0.0025


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One panel for each friction.

    A strip below the logarithmic axis has the runs without dissipation.
    """
    runs = tables["runs"]
    runs = runs[runs["dissipation"].notna()]
    frictions = sorted(runs["friction"].unique())
    figure = new_figure(WIDE, 92)
    panels = figure.subplots(2, len(frictions), sharex=True, squeeze=False, height_ratios=[7, 1])
    slipping = runs.loc[runs["dissipation"] > 0, "dissipation_scaled"]
    low, high = 10 ** np.floor(np.log10(slipping.min())), 10 ** np.ceil(np.log10(slipping.max()))
    for (upper, lower), friction, letter in zip(panels.T, frictions, "abcdef", strict=False):
        _marks(upper, lower, runs[runs["friction"] == friction])
        upper.set_yscale("log")
        upper.set_ylim(low, high)
        upper.yaxis.set_major_locator(LogLocator(numticks=12))
        upper.set_title(f"$f = {friction:g}$", loc="right")
        panel_label(upper, letter)
        lower.set(
            ylim=(-1, 1), xlabel=r"load factor over the shakedown limit, $\lambda / \lambda_2$"
        )
        lower.set_yticks([])
        limits = tables["limits"].set_index("friction").loc[friction]
        guaranteed = limits["guaranteed"] / limits["load_factor"]
        for axes in (upper, lower):
            axes.axvline(1, color=BLACK, lw=0.8)
            axes.axvline(guaranteed, color=BLACK, lw=0.8, linestyle="--")
            axes.set_xlim(-0.04, 1.03 * runs["load_ratio"].max())
        for limit, name in (
            (1.0, r"$\lambda_2$"),
            (
                guaranteed,
                rf"$\lambda_1 = {guaranteed:.2g}\,\lambda_2$"
                if guaranteed > 0
                else r"$\lambda_1 = 0$",
            ),
        ):
            upper.annotate(name, (limit, high), (3, -3), textcoords="offset points", va="top")
    panels[1, 0].set_ylabel("$W = 0$", rotation="horizontal", ha="right", va="center")
    panels[0, 0].set_ylabel(r"steady dissipation $W E^* / P^2$ per cycle")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=len(handles),
        columnspacing=1.2,
        handletextpad=0.1,
    )
    return figure


def _marks(upper: Any, lower: Any, runs: pd.DataFrame) -> None:
    for number, (family, (label, look)) in enumerate(FAMILIES.items()):
        rows = runs[runs["family"] == family]
        aside = _WIDTH * (number - 1)
        filled = family in ("overload", "safe", "none")
        marks = {
            "linestyle": "none",
            "marker": look["marker"],
            "color": look["color"],
            "markersize": 3.0 if filled else 2.2,
            "mew": 0.5,
            "mfc": look["color"] if filled else "none",
            "zorder": 3 if filled else 2,
        }
        slips = rows["dissipation"] > 0
        upper.plot(
            rows.loc[slips, "load_ratio"] + aside,
            rows.loc[slips, "dissipation_scaled"],
            label=label,
            **marks,
        )
        at_rest = rows.loc[~slips, "load_ratio"]
        lower.plot(at_rest + aside, 0.6 * (1 - number / 2) * np.ones(len(at_rest)), **marks)
    lower.axhline(0, color=GREY, lw=0.3, zorder=0)
