"""The range of steady dissipation over all starts, with the sampled starts in it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from studies.dissipation import RUNS
from studies.range import FOUND, against_sample
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"found": FOUND, "runs": RUNS}

_SHADE = "#DCE6EE"


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One panel for each friction.

    The band goes from the least to the largest dissipation of the search. Each sampled start has a
    mark.
    """
    found, runs = against_sample(tables["found"], tables["runs"]), tables["runs"]
    runs = runs[runs["dissipation_scaled"] > 0]
    frictions = sorted(found["friction"].unique())
    figure = new_figure(WIDE, 84)
    panels = figure.subplots(1, len(frictions), sharex=True, sharey=True, squeeze=False)[0]
    low = 10 ** np.floor(
        np.log10(min(runs["dissipation_scaled"].min(), found.loc[found["most"] > 0, "most"].min()))
    )
    high = 10 ** np.ceil(np.log10(found["most"].max()))
    for axes, friction, letter in zip(panels, frictions, "abcdef", strict=False):
        rows = found[(found["friction"] == friction) & (found["most"] > 0)].sort_values(
            "load_ratio"
        )
        marks = runs[runs["friction"] == friction]
        least = rows["least"].where(rows["least"] > 0)
        # Below the limit the least dissipation is 0.
        for side, label in (
            (rows["load_ratio"] < 1, "range found"),
            (rows["load_ratio"] > 1, None),
        ):
            part = rows[side]
            axes.fill_between(
                part["load_ratio"],
                part["least"].clip(lower=low),
                part["most"],
                color=_SHADE,
                lw=0,
                label=label,
            )
        axes.plot(
            rows["load_ratio"], rows["most"], label="largest found", **SERIES[1] | {"marker": "_"}
        )
        axes.plot(
            rows["load_ratio"],
            least,
            label="least found (0 where no line)",
            **SERIES[0] | {"marker": "_"},
        )
        axes.plot(
            marks["load_ratio"],
            marks["dissipation_scaled"],
            ".",
            color=GREY,
            ms=2.5,
            mew=0,
            zorder=1.5,
            label="sampled starts that keep slipping",
        )
        axes.axvline(1, color=BLACK, lw=0.8)
        axes.annotate(r"$\lambda_2$", (1, high), (3, -3), textcoords="offset points", va="top")
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(numticks=20))
        axes.set_xlabel(r"load factor over the shakedown limit, $\lambda / \lambda_2$")
        outside, count = (
            int(found.loc[found["friction"] == friction, "outside"].sum()),
            int(found.loc[found["friction"] == friction, "runs"].sum()),
        )
        axes.set_title(f"$f = {friction:g}$; {outside} of {count:,} runs outside", loc="right")
        panel_label(axes, letter)
    panels[0].set_ylim(low, high)
    panels[0].set_ylabel(r"steady dissipation $W E^* / P^2$ per cycle")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=len(handles), columnspacing=1.2
    )
    return figure
