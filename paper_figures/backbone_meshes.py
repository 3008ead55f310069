"""A bolted joint on three meshes: shakedown limit, work of friction and slipping share.

The limit jumps from mesh to mesh, while the curves of work and slipping share agree.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.damping import MESHES
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"meshes": MESHES}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Work of friction and slipping share over the load, with a look for each mesh.

    A line in its colour shows its limit.
    """
    figure = new_figure(WIDE, 75)
    work, share = panels = figure.subplots(1, 2)
    for (elements, rows), look in zip(tables["meshes"].groupby("elements"), SERIES, strict=False):
        work.plot(
            rows["load_share"],
            rows["work"],
            **look,
            label=f"{elements} elements along the joint, {rows['nodes'].iloc[0]} nodes",
        )
        share.plot(rows["load_share"], rows["slipping"], **look)
        for axes in panels:
            axes.axvline(
                rows["shakedown_share"].iloc[0], color=look["color"], lw=0.8, linestyle="--"
            )
    work.plot([], [], color=BLACK, lw=0.8, linestyle="--", label=r"shakedown limit $\lambda_2$")
    work.set_yscale("log")
    work.set_ylabel("work of friction per cycle")
    share.set_ylim(0.0, 1.0)
    share.set_ylabel("share of the area that slips")
    for axes, letter in zip(panels, "ab", strict=True):
        axes.set_xlabel("load over that at which the plates slide off")
        axes.set_xscale("log")
        panel_label(axes, letter)
    figure.legend(*work.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure
