"""Error against run time of each computation on its finest mesh, for frictopt and other packages.

Direct calls of the other packages do the same work.
"""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies.tables import Table
from studies.validation.error_vs_time.methods import ROUNDING
from studies.validation.error_vs_time.study import ERROR

from .style import GREY, SERIES, WIDE, new_figure, whole_decades

TABLES: Mapping[str, Table[Any]] = {"error": ERROR}

_BLUE = SERIES[0]["color"]
_LOOKS: dict[str, dict[str, Any]] = {
    "frictopt": {"color": _BLUE, "marker": "o", "ms": 5},
    **{
        name: {"color": series["color"], "marker": series["marker"], "ms": 4, "mfc": "white"}
        for name, series in zip(
            ("HiGHS", "Clarabel", "OSQP", "Lemke", "scipy", "plain cvxpy"), SERIES[1:], strict=False
        )
    },
}
_COLUMNS = 4


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """One panel for each comparison with other packages, and for increments in three dimensions.

    The line is the front of undominated methods.
    """
    questions = {
        key: rows[rows["nodes"] == rows["nodes"].max()]
        for key, rows in tables["error"].groupby(["computation", "quantity"], sort=False)
    }
    plane, space = (
        {
            key: rows
            for key, rows in questions.items()
            if _shown(rows) and key[0].endswith("3-D") is in_space
        }
        for in_space in (False, True)
    )
    lines = (len(plane) + 1 + len(space) + _COLUMNS - 1) // _COLUMNS
    figure = new_figure(WIDE, 56 * lines)
    grid = figure.subplots(lines, _COLUMNS, sharex=True, sharey=True).ravel()
    legend, panels = (
        grid[len(plane)],
        [axes for place, axes in enumerate(grid) if place != len(plane)],
    )
    shown = {**plane, **space}
    for axes, (key, rows) in zip(panels, shown.items(), strict=False):
        _panel(axes, rows[rows["result"] == "answer"])
        axes.set_title(
            "\n".join(key).replace("lambda_1", r"$\lambda_1$").replace("lambda_2", r"$\lambda_2$"),
            loc="left",
        )
    whole_decades(panels[0], "x")
    for axes, rows in zip(panels, shown.values(), strict=False):
        _front(axes, rows[rows["on_front"]].sort_values("seconds"))
    for axes in panels[len(shown) :]:
        axes.axis("off")
    for place, axes in enumerate(grid):
        last = place + _COLUMNS >= len(grid) or grid[place + _COLUMNS] in panels[len(shown) :]
        axes.set_xlabel("run time, s" if last else "")
        axes.tick_params(labelbottom=last)
        axes.set_ylabel("relative error" if place % _COLUMNS == 0 else "")
    _legend(legend, pd.concat(shown.values()))
    return figure


def _shown(rows: pd.DataFrame) -> bool:
    """Whether other packages answer the question, too, or it is an increment in three dimensions."""
    in_space = rows["computation"].iloc[0].endswith("3-D")
    return bool(
        (rows["rival"] != "").any()
        or (in_space and rows["knob"].str.startswith("increments").all())
    )


def _panel(axes: Any, rows: pd.DataFrame) -> None:
    for family, part in rows.groupby(_families(rows), sort=False):
        axes.plot(
            part["seconds"], part["error"], linestyle="none", mew=0.8, zorder=3, **_LOOKS[family]
        )
    axes.axhspan(1e-18, ROUNDING, color=GREY, alpha=0.12, lw=0)
    axes.set(xscale="log", yscale="log", ylim=(3e-17, 30))


def _front(axes: Any, rows: pd.DataFrame) -> None:
    """The line along the front, from the upper edge of the panel to its right edge."""
    error = rows["error"].clip(lower=ROUNDING)
    edges = (
        [rows["seconds"].iloc[0], *rows["seconds"], axes.get_xlim()[1]],
        [axes.get_ylim()[1], *error, error.iloc[-1]],
    )
    axes.plot(*edges, drawstyle="steps-post", color=GREY, lw=0.8, zorder=2)


def _families(rows: pd.DataFrame) -> pd.Series:
    theirs = rows["method"].str.split(",").str[0]
    solvers = theirs.str.split().str[0]
    families = solvers.where(rows["rival"] != "cvxpy", theirs)
    return families.where(rows["rival"] != "", "frictopt")


def _legend(axes: Any, rows: pd.DataFrame) -> None:
    shown = set(_families(rows))
    names = [name for name in _LOOKS if name in shown]
    handles: list[Any] = [
        Line2D([], [], linestyle="none", mew=0.8, **_LOOKS[name]) for name in names
    ]
    handles += [Line2D([], [], color=GREY, lw=0.8), Patch(color=GREY, alpha=0.12, lw=0)]
    axes.axis("off")
    axes.legend(
        handles,
        [*names, "front", "errors that count as equal"],
        loc="center left",
        handlelength=1.4,
        borderpad=0,
    )
