"""Load up to which the contact shakes down after several protocols, against friction."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.range import PROTOCOLS
from studies.tables import Table

from .style import SERIES, WIDE, new_figure

TABLES: Mapping[str, Table[Any]] = {"protocols": PROTOCOLS}

_NAMES = {
    "safe": r"slip that is safe at $\lambda_2$",
    "unload at tension": r"worst start; $P$ to 0.3 and back at $\sigma = +\lambda$",
    "assembled": "assembled from zero load",
    "unload": r"worst start; $P$ to 0.2 and back",
    "overload": r"worst start; $\sigma$ to $2\lambda_2$ and back",
    "nothing": "worst start, nothing done",
}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One line for each protocol."""
    table = tables["protocols"]
    figure = new_figure(WIDE, 80)
    axes = figure.subplots()
    for (protocol, name), look in zip(_NAMES.items(), SERIES, strict=False):
        rows = table[table["protocol"] == protocol].sort_values("friction")
        axes.plot(rows["friction"], rows["ratio"], label=name, **look, mfc="white", mew=0.8)
    axes.set_ylim(-0.03, 1.05)
    axes.set_xlabel("coefficient of friction $f$")
    axes.set_ylabel(r"limit after the protocol $\lambda / \lambda_2$")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")
    return figure
