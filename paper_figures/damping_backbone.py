"""Frequency and damping of three joints against the amplitude of their load, with their range over the residual slips."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.damping import BACKBONE
from studies.tables import Table

from .style import BLACK, GREY, SERIES, WIDE, new_figure, panel_label, plain_log

TABLES: Mapping[str, Table[Any]] = {"backbone": BACKBONE}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """A column for each joint: change of frequency above, damping below, in per cent."""
    joints = tables["backbone"].groupby("joint", sort=False)
    figure = new_figure(WIDE, 105)
    panels = figure.subplots(2, len(joints), sharex="col")
    for (name, rows), column in zip(joints, panels.T, strict=True):
        for axes, quantity, glued in zip(column, ("frequency", "damping"), (1.0, 0.0), strict=True):
            settled, least, most = (
                100 * (rows[f"{end}{quantity}"] - glued) for end in ("", "least_", "most_")
            )
            axes.fill_between(
                rows["load_ratio"],
                least,
                most,
                color=SERIES[0]["color"],
                alpha=0.25,
                lw=0,
                label="range found over residual slips",
            )
            axes.plot(rows["load_ratio"], settled, **SERIES[0], label="without residual slip")
            if (guaranteed := rows["guaranteed_ratio"].iloc[0]) > rows["load_ratio"].min():
                axes.axvline(
                    guaranteed,
                    color=GREY,
                    lw=0.8,
                    linestyle="--",
                    label=r"guaranteed limit $\lambda_1$",
                )
            axes.axvline(1.0, color=BLACK, lw=0.8, label=r"shakedown limit $\lambda_2$")
            plain_log(axes, "x")
        column[0].set_title(name, loc="right")
        column[1].set_xlabel(r"load factor $\lambda / \lambda_2$")
    panels[0, 0].set_ylabel("change of frequency, %")
    panels[1, 0].set_ylabel(r"damping ratio $\zeta$, %")
    for axes, letter in zip(panels.flat, "abcdef", strict=True):
        panel_label(axes, letter)
    figure.align_ylabels(panels[:, 0])
    handles, labels = panels[0, -1].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=len(handles), columnspacing=1.2
    )
    return figure
