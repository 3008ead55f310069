"""Errors of the mesh: corner exponent, dissipation, the law of the corner, and contact stiffness."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies.limits import CORNER, SURFACE, corner_law
from studies.tables import Table
from studies.validation.error_vs_time.study import ERROR

from .style import GREY, SERIES, WIDE, new_figure, panel_label, whole_decades

TABLES: Mapping[str, Table[Any]] = {"error": ERROR, "corner": CORNER, "surface": SURFACE}


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Above: errors against run time. Below: fitted against expected exponents, and limits.

    The limits are without and with contact stiffness.
    """
    figure = new_figure(WIDE, 140)
    panels = figure.subplots(2, 2).ravel()
    meshes = tables["error"][tables["error"]["nodes"] == 0]
    _corner(panels[0], meshes[meshes["quantity"] == "corner exponent"])
    _cylinder(panels[1], meshes[meshes["scene"] == "cylinder on a half-plane"])
    _law(panels[2], corner_law(tables["corner"]))
    _surface(panels[3], tables["surface"])
    for axes, letter in zip(panels, "abcd", strict=True):
        panel_label(axes, letter)
    return figure


def _corner(axes: Any, rows: pd.DataFrame) -> None:
    for (knob, part), series in zip(rows.groupby("knob", sort=False), SERIES, strict=False):
        axes.plot(
            part["seconds"], part["error"], label=knob.removeprefix("elements, "), **series, lw=0.8
        )
    _name_ends(axes, rows[rows["knob"] == rows["knob"].iloc[0]])
    whole_decades(axes, "xy")
    axes.set_xlabel("run time from scene to system, s")
    axes.set_ylabel("relative error of the corner exponent")
    axes.legend(loc="upper right")


def _cylinder(axes: Any, rows: pd.DataFrame) -> None:
    for (computation, part), series in zip(
        rows.groupby("computation", sort=False), SERIES, strict=False
    ):
        axes.plot(part["seconds"], part["error"], label=computation, **series, lw=0.8)
    _name_ends(axes, rows[rows["computation"] == rows["computation"].iloc[0]])
    whole_decades(axes, "xy")
    axes.set_xlabel("run time, s")
    axes.set_ylabel("relative error of the work in a cycle")
    axes.legend(loc="upper right")


def _name_ends(axes: Any, rows: pd.DataFrame) -> None:
    """Number of elements or cells at the first and the last point."""
    for row in (rows.iloc[0], rows.iloc[-1]):
        axes.annotate(
            row["setting"],
            (row["seconds"], row["error"]),
            (4, 3),
            textcoords="offset points",
            fontsize=7,
            color=GREY,
        )


def _law(axes: Any, table: pd.DataFrame) -> None:
    for (friction, rows), series in zip(table.groupby("friction"), SERIES, strict=False):
        axes.axhline(rows["expected"].iloc[0], color=series["color"], lw=0.8, linestyle="-")
        axes.plot(
            rows["corner_size"],
            rows["exponent"],
            **(series | {"linestyle": "none"}),
            label=f"$f = {friction:g}$",
        )
    whole_decades(axes, "x")
    axes.set_ylim(0, 1.45 * table["expected"].max())
    axes.set_xlabel("corner element / $a$")
    axes.set_ylabel(r"exponent of $\lambda_2$ in the corner element")
    axes.legend(loc="upper center", ncols=2, title="lines: closed forms")


def _surface(axes: Any, table: pd.DataFrame) -> None:
    for (give, rows), series in zip(table.groupby("surface"), SERIES, strict=False):
        axes.plot(
            rows["corner_size"],
            rows["load_factor"],
            **series,
            lw=0.8,
            label=f"${give:g}\\,a$" if give else "0 (hard)",
        )
        # In the other rows the mean load alone causes slip.
        slips = rows[rows["onset"] > 0]
        axes.plot(
            slips["corner_size"],
            slips["onset"],
            **(series | {"linestyle": ":"}),
            mfc="white",
            mew=0.7,
            lw=0.8,
        )
    whole_decades(axes, "x")
    axes.set_ylim(0, 1.9 * table["load_factor"].max())
    axes.set_xlabel("corner element / $a$")
    axes.set_ylabel(rf"$\lambda_2$ (full), onset (open), $f = {table['friction'].iloc[0]:g}$")
    axes.legend(loc="upper center", ncols=2, title="$E^*$ over contact stiffness")
