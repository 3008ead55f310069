"""Steady dissipation against the root mean square of the initial random slip, at loads below and above the shakedown limit."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.dissipation import RUNS
from studies.tables import Table

from .dissipation import FAMILIES
from .style import GREY, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"runs": RUNS}

# Load factors of the figure, if the study has them.
_RATIOS = (0.5, 0.9, 1.2, 1.6)
# Relative distance of the marks of the two families.
_APART = 0.06


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Rows are frictions, columns loads.

    Marks are runs, lines medians. The grey line is the contact without initial slip.
    """
    runs = tables["runs"]
    runs = runs[runs["dissipation"].notna()]
    frictions = sorted(runs["friction"].unique())
    ratios = [ratio for ratio in _RATIOS if (runs["load_ratio"] == ratio).any()]
    figure = new_figure(WIDE, 18 + 48 * len(frictions))
    panels = figure.subplots(len(frictions), len(ratios), sharex=True, squeeze=False)
    for row, friction in zip(panels, frictions, strict=True):
        for axes, ratio in zip(row, ratios, strict=True):
            _panel(axes, runs[(runs["friction"] == friction) & (runs["load_ratio"] == ratio)])
            axes.set_title(rf"$f = {friction:g}$,  $\lambda = {ratio:g}\,\lambda_2$", loc="right")
        row[0].set_ylabel(r"$10^3\,W E^* / P^2$ per cycle")
    for number, axes in enumerate(panels.flat):
        panel_label(axes, "abcdefghijklmnop"[number])
    for axes in panels[-1]:
        axes.set_xlabel(r"r.m.s. of $v\,E^* / (a\,P / 2a)$")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=len(handles), columnspacing=1.4
    )
    return figure


def _panel(axes: Any, runs: pd.DataFrame) -> None:
    plain_log(axes, "x")
    bare = runs.loc[runs["family"] == "none", "dissipation_scaled"]
    axes.axhline(1e3 * bare.iloc[0], color=GREY, lw=0.9, label="no initial slip")
    for sense, family in ((-1, "smooth"), (1, "rough")):
        label, look = FAMILIES[family]
        rows = runs[runs["family"] == family]
        amplitude = rows["amplitude"].map(lambda value: float(f"{value:.3g}"))
        aside = (1 + _APART) ** sense
        axes.plot(
            amplitude * aside,
            1e3 * rows["dissipation_scaled"],
            linestyle="none",
            marker=look["marker"],
            color=look["color"],
            mfc="none",
            mew=0.5,
        )
        median = (1e3 * rows["dissipation_scaled"]).groupby(amplitude).median()
        axes.plot(
            median.index * aside,
            median,
            color=look["color"],
            linestyle=look["linestyle"],
            label=f"{label}: median",
        )
    top = 1.08e3 * runs["dissipation_scaled"].max() or 1.0
    # The marks at zero are shown as a whole.
    axes.set_ylim(-0.04 * top, top)
    # The label has a power of ten already.
    axes.ticklabel_format(axis="y", style="plain")
