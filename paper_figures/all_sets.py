"""Comparison of all sets of open nodes: programs and seconds against the nodes of a contact."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.tables import Table
from studies.validation.all_sets import CONTACTS

from .style import BLACK, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"contacts": CONTACTS}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: programs beside the number of sets. Right: processor time of a limit.

    A line joins the medians. The bars reach from the least to the largest value.
    """
    table = tables["contacts"]
    figure = new_figure(WIDE, 72)
    left, right = figure.subplots(1, 2)
    every = np.arange(table["nodes"].min(), table["nodes"].max() + 1)
    left.plot(every, 2.0**every, color=BLACK, lw=0.8, ls=":", label="all sets of the contact")
    for (family, rows), series in zip(table.groupby("family", sort=False), SERIES, strict=False):
        for axes, column in ((left, "programs"), (right, "seconds")):
            ends = rows.groupby("nodes")[column].agg(["min", "median", "max"])
            middle = ends["median"]
            reach = [middle - ends["min"], ends["max"] - middle]
            axes.errorbar(
                ends.index, middle, reach, label=family, capsize=2, elinewidth=0.8, **series
            )
    for axes, letter in ((left, "a"), (right, "b")):
        axes.set_yscale("log")
        axes.set_xlabel("nodes of the contact, all of which may open")
        panel_label(axes, letter)
    left.set_ylabel("programs of the search")
    right.set_ylabel("processor time of the limit / s")
    left.legend(loc="upper left")
    return figure
