"""Damping of two joints against friction, with its range over the residual slips, below and above the shakedown limit."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.damping import FRICTION
from studies.tables import Table

from .style import SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"friction": FRICTION}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """A panel for each joint, a look for each load factor over the shakedown limit."""
    joints = tables["friction"].groupby("joint", sort=False)
    figure = new_figure(WIDE, 75)
    panels = figure.subplots(1, len(joints))
    for (name, table), axes, letter in zip(joints, panels, "ab", strict=True):
        for (ratio, rows), look in zip(table.groupby("load_ratio"), SERIES, strict=False):
            least, most = 100 * rows["least_damping"], 100 * rows["most_damping"]
            label = rf"at ${ratio:g}\,\lambda_2$"
            axes.fill_between(
                rows["friction"],
                least,
                most,
                color=look["color"],
                alpha=0.25,
                lw=0,
                label=f"range found {label}",
            )
            axes.plot(
                rows["friction"],
                100 * rows["damping"],
                **look,
                label=f"without residual slip {label}",
            )
        axes.set_xlabel("coefficient of friction $f$")
        axes.set_title(name, loc="right")
        panel_label(axes, letter)
    panels[0].set_ylabel(r"damping ratio $\zeta$, %")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return figure
