"""Two steady states at one load above the shakedown limit, with least and most dissipation."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from studies.dissipation import STATES
from studies.tables import Table

from .dissipation import FAMILIES
from .style import GREY, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"states": STATES}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: slip along the contact. Middle: range of the slip. Right: a loop.

    The range over the cycle is shaded. The loop belongs to the node that dissipates most.
    """
    table = tables["states"]
    figure = new_figure(WIDE, 76)
    slip, width, loop = figure.subplots(1, 3)
    for (name, rows), look in zip(table.groupby("state"), SERIES, strict=False):
        by_node = rows.groupby("x")["slip"]
        low, high = by_node.min(), by_node.max()
        run = rows.iloc[0]
        start = f"{FAMILIES[run['family']][0]}, r.m.s. {run['amplitude']:.2g}"
        label = (
            rf"{name} dissipation, $W E^* / P^2 = {_number(run['dissipation_scaled'])}$: {start}"
        )
        slip.fill_between(low.index, low, high, color=look["color"], alpha=0.35, lw=0)
        slip.plot(
            low.index,
            (low + high) / 2,
            color=look["color"],
            linestyle=look["linestyle"],
            lw=0.9,
            label=label,
        )
        width.plot(
            low.index, 1e3 * (high - low), color=look["color"], linestyle=look["linestyle"], lw=1.1
        )
        node = rows[rows["x"] == _most(rows)]
        loop.plot(
            1e3 * (node["slip"] - (node["slip"].min() + node["slip"].max()) / 2),
            node["q"],
            color=look["color"],
            linestyle=look["linestyle"],
            lw=1.1,
        )
        loop.plot(
            [],
            [],
            color=look["color"],
            linestyle=look["linestyle"],
            label=f"$x = {_most(rows):.3f}\\,a$",
        )
    slip.set_ylabel(r"slip $v\,E^* / (a\,P / 2a)$")
    width.set_ylabel(r"range of the slip, $10^3 v\,E^* / (a\,P / 2a)$")
    loop.set(
        xlabel=r"$10^3 (v - v_m)\,E^* / (a\,P / 2a)$", ylabel="nodal shear force $q / (P / 2)$"
    )
    low, high = loop.get_ylim()
    loop.set_ylim(low, high + 0.25 * (high - low))
    loop.legend(loc="upper right", handlelength=2)
    for axes in (slip, width):
        axes.set(xlim=(-1.02, 1.02), xlabel="$x / a$")
    slip.axhline(0, color=GREY, lw=0.6)
    width.set_ylim(bottom=0)
    loop.set_title(
        rf"$f = {table['friction'].iloc[0]:g}$,  $\lambda = {table['load_ratio'].iloc[0]:g}\,\lambda_2$",
        loc="right",
    )
    for axes, letter in zip((slip, width, loop), "abc", strict=True):
        panel_label(axes, letter)
    figure.legend(*slip.get_legend_handles_labels(), loc="outside upper center", ncols=1)
    return figure


def _most(rows: pd.DataFrame) -> float:
    """Place of the node whose loop encloses the largest area."""
    loops = {x: abs(np.trapezoid(node["q"], node["slip"])) for x, node in rows.groupby("x")}
    return float(max(loops, key=loops.__getitem__))


def _number(value: float) -> str:
    """A number in powers of ten, for mathematical text."""
    digits, exponent = f"{value:.2e}".split("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}"
