"""Results of others beside frictopt: nodes, cylinders, a twisted sphere and a layered beam.

Lines are results of others, marks results of frictopt.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.published.study import COMPARED, CURVES
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {"compared": COMPARED, "curves": CURVES}

# Distance in points from a line to its name.
_ABOVE, _BELOW = 5, -11
# Beginning of a quantity -> its name, the place of the name along the line, its side, and the names
# of the horizontal and the vertical axis.
_PANELS = (
    (
        {
            "guaranteed limit lambda_1": (r"$\lambda_1$", 0.8, _BELOW),
            "shakedown limit lambda_2": (r"$\lambda_2$", 0.65, _ABOVE),
        },
        "coefficient of friction $f$",
        "limits of two nodes",
    ),
    (
        {"critical friction": ("", 0.5, _ABOVE)},
        "angle of a tilted bar, degrees",
        "critical friction",
    ),
    (
        {
            "both limits of a node": ("both limits", 0.5, _ABOVE),
            "work of friction per cycle of a node": ("work $A W / P^2$", 0.5, _BELOW - 7),
        },
        "phase of the normal load, degrees",
        "one node",
    ),
    (
        {
            "half-width of the stick zone / a": ("cylinder", 0.3, _BELOW - 9),
            "half-width of the stick zone / a, punch": ("rounded punch", 0.55, _ABOVE + 5),
        },
        "shear force $Q / f P$",
        "stick zone / $a$",
    ),
    (
        {
            "half-width of the stick zone / a under bulk": ("half-width", 0.5, _BELOW),
            "middle of the stick zone": ("middle", 0.4, _ABOVE + 4),
        },
        r"bulk stress $\sigma / f p_0$",
        "stick zone / $a$",
    ),
    (
        {"work of friction per cycle under a normal": ("", 0.5, _ABOVE)},
        "amplitude of $P$ / mean $P$",
        "cylinder: $W E^* / (f P)^2$",
    ),
    (
        {
            "twisting couple": ("couple / $f P a$", 0.55, _BELOW - 12),
            "radius of the stick zone": ("stick zone / $a$", 0.5, _ABOVE + 16),
        },
        "stick zone of theirs / $a$",
        "twisted sphere",
    ),
    (
        {"work of friction per cycle of a cantilever": ("", 0.5, _ABOVE)},
        "tip force / that of first slip",
        "layered beam: $W$, scaled",
    ),
)


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Eight panels, each with a line of others through marks of frictopt."""
    figure = new_figure(WIDE, 92)
    for axes, letter, (series, across, up) in zip(
        figure.subplots(2, 4).flat, "abcdefgh", _PANELS, strict=True
    ):
        for (begins, (name, along, aside)), look in zip(series.items(), SERIES, strict=False):
            quantity = _named(tables["compared"], begins)
            curve, points = (
                tables[key][tables[key]["quantity"] == quantity] for key in ("curves", "compared")
            )
            axes.plot(curve["at"], curve["theirs"], color=look["color"], lw=1.0)
            axes.plot(
                points["at"],
                points["ours"],
                color=look["color"],
                marker=look["marker"],
                linestyle="none",
                markersize=4,
            )
            if len(curve):
                place = curve.iloc[int(along * len(curve))]
                axes.annotate(
                    name,
                    (place["at"], place["theirs"]),
                    (0, aside),
                    textcoords="offset points",
                    color=look["color"],
                    ha="center",
                )
        axes.set(xlabel=across, ylabel=up, ylim=(0, 1.15 * axes.get_ylim()[1]))
        axes.margins(x=0.08)
        panel_label(axes, letter)
    line, mark = (
        Line2D([], [], color=BLACK, lw=1.0),
        Line2D([], [], color=BLACK, marker="o", linestyle="none", markersize=4),
    )
    figure.legend(
        [line, mark],
        ["of others: closed forms and rules", "ours"],
        loc="outside upper center",
        ncols=2,
    )
    return figure


def _named(table: pd.DataFrame, begins: str) -> str:
    """The shortest quantity with a given beginning."""
    return min(
        (str(name) for name in table["quantity"].unique() if name.startswith(begins)), key=len
    )
