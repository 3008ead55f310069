"""Pictures of what follows from many transients: what was tried, damping, wear, and the runs of a study."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from ..base import Table
from ..contact.face import panels_of
from ..contact.strip import label_panels
from ..plots.draw import draw as draw
from ..plots.style import (
    ALONG,
    BLACK,
    GREY,
    SERIES,
    AxesArray,
    Look,
    equals,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
    series,
)
from ..transients.pictures import slip_and_work, work_map
from .dissipation_range import DissipationRange
from .excursion import LeastExcursion
from .protocols import REST, SLIP, UNDECIDED, LimitAfterProtocol

_STRIP = 6.4, 2.4  # size of a picture with a row for each outcome, inches
_ROWS = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}
_PANEL = 2.4  # height of each further panel of a study, inches
_COLUMNS = {
    "load_ratio": r"load factor over the shakedown limit, $\lambda / \lambda_2$",
    "load_factor": r"load factor $\lambda$",
    "friction": "friction",
    "friction_number": "friction",
    "cycle": "load cycle",
    "amplitude": "initial slip, root mean square (length)",
}


@picture.register
def _limit_after_protocol(limit: LimitAfterProtocol, ax: Axes | None = None) -> Axes:
    """The load factors tried, in a row for each outcome."""
    (axes,) = new_axes(ax, size=_STRIP)
    again = "" if limit.monotonic else ", and at some load factors above"
    axes.set_title(equals(r"comes to rest up to $\lambda$", limit.load_factor) + again)
    _tried(axes, limit.tried, "load_factor", limit.load_factor, "limit after the protocol")
    limit_line(axes, r"shakedown limit $\lambda_2$", limit.shakedown_limit, BLACK)
    axes.set_xlabel(r"load factor $\lambda$")
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


@picture.register
def _excursion(found: LeastExcursion, ax: Axes | None = None) -> Axes:
    """The shares of the excursion tried, in a row for each outcome; a share may have several, for the start is the hardest one then."""
    (axes,) = new_axes(ax, size=_STRIP)
    if not len(found.tried):
        no_lines([axes], "all starts come to rest without an excursion")
        return axes
    if found.loads is None:
        axes.set_title("no share of the excursion tried brings all starts to rest")
    else:
        loads = ", ".join(f"{name} = {value:.4g}" for name, value in found.loads.items())
        axes.set_title(f"least excursion found: {found.share:.4g} of the largest, to {loads}")
    _tried(axes, found.tried, "share", found.share, "least found")
    axes.set(xlabel="share of the largest excursion", xlim=(0.0, 1.02))
    if np.isfinite(found.share):
        legend(axes)
    return axes


def _tried(axes: Axes, tried: Table, column: str, found: float, name: str) -> None:
    """A mark for each thing tried, in the row of its outcome, and a line at what was found, by its name, if it is finite."""
    rows = [
        outcome
        for outcome in _ROWS
        if outcome != UNDECIDED or (tried["outcome"] == UNDECIDED).any()
    ]
    for row, outcome in enumerate(rows):
        at, look = (
            tried.loc[tried["outcome"] == outcome, column],
            {name: series(row)[name] for name in ("color", "marker")},
        )
        axes.plot(at, np.full(len(at), row), linestyle="none", markersize=5, mfc="none", **look)
    axes.set(
        yticks=range(len(rows)),
        yticklabels=[_ROWS[row] for row in rows],
        ylim=(-0.6, len(rows) - 0.4),
    )
    axes.tick_params(axis="y", length=0)
    if np.isfinite(found):
        axes.axvline(found, color=GREY, lw=0.8, zorder=0, label=name)


def limit_line(axes: Axes, name: str, limit: float, color: str) -> None:
    """Draw a limit, where it is finite and above 0, across an axis of load factors."""
    if np.isfinite(limit) and limit > 0:
        axes.axvline(
            limit, color=color, lw=0.8, linestyle="--", zorder=0, label=equals(name, limit)
        )


def runs_of(
    table: Table,
    ax: Axes | AxesArray | None = None,
    x: str | None = None,
    colour: str | None = None,
    rows: str | None = None,
) -> Axes | AxesArray:
    """Steady dissipation against the load, over a finite lambda_2, or another column; a look for each family of starts, panels and colours."""
    runs = table[table["outcome"] != "FAILED"]
    along = x or ("load_ratio" if np.isfinite(runs["load_ratio"]).all() else "load_factor")
    if colour is None:
        colour = next(
            (name for name in ("friction_number", "cycle") if table[name].nunique() > 1), None
        )
    panels = [None] if rows is None else list(table[rows].unique())
    every = new_axes(ax, len(panels), (ALONG[0], ALONG[1] + _PANEL * (len(panels) - 1)))
    slips = runs.loc[runs["dissipation"] > 0, "dissipation"]
    low, high = (slips.min() / 3, slips.max() * 3) if len(slips) else (0.1, 10.0)
    names = (
        None
        if pd.api.types.is_numeric_dtype(table[along])
        else {value: place for place, value in enumerate(table[along].unique())}
    )
    at = runs[along] if names is None else runs[along].map(names)
    shown = runs.assign(x=at, work=runs["dissipation"].where(runs["dissipation"] > 0, low / 2))
    per_depth = (
        " per depth" if (table["engine"] == "path").any() else ""
    )  # in space a study has increments alone
    failed = [f"{len(table) - len(runs)} of {len(table)} runs failed"] * (len(runs) < len(table))
    for axes, value in zip(every, panels, strict=True):
        _runs(axes, table, shown if value is None else shown[shown[rows] == value], colour)
        axes.axhline(low, color=BLACK, lw=0.6)
        axes.set(
            yscale="log",
            ylim=(low / 4, high),
            ylabel=f"work of friction per cycle, $W$\n(force times length{per_depth})",
        )
        axes.annotate(
            "$W = 0$",
            (1, low / 2),
            (5, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="center",
        )
        if names is not None:
            axes.set(
                xticks=range(len(names)), xticklabels=list(names), xlim=(-0.5, len(names) - 0.5)
            )
        elif along == "load_ratio":
            axes.axvline(1, color=BLACK, lw=0.8, linestyle="--")
        axes.set_title(
            ", ".join([f"{_called(rows)}: {_told(value)}"] * (rows is not None) + failed)
        )
        failed = []
    every[-1].set_xlabel(_called(along))
    _legend_of_runs(every[0], table, colour)
    return every[0] if rows is None else np.array(every)


def _runs(axes: Axes, table: Table, runs: Table, colour: str | None) -> None:
    """A mark for each run at its place and work: the marker of its family, the colour of its value in a column, or of its family too."""
    families = {name: k for k, name in enumerate(table["family"].unique())}
    colours = (
        families if colour is None else {value: k for k, value in enumerate(table[colour].unique())}
    )
    for (family, value), some in runs.groupby(["family", colour or "family"], sort=False):
        look: Look = {
            "color": series(colours[value])["color"],
            "marker": series(families[family])["marker"],
            "label": None if colour else family,
        }
        axes.plot(some["x"], some["work"], markersize=5, linestyle="none", mfc="none", **look)


def _legend_of_runs(axes: Axes, table: Table, colour: str | None) -> None:
    """The legend of all runs of a study."""
    if colour is None:
        return legend(axes, "start")
    for number, family in enumerate(table["family"].unique()):
        axes.plot(
            [],
            [],
            color=BLACK,
            marker=series(number)["marker"],
            label=family,
            linestyle="none",
            mfc="none",
        )
    for number, (value, rows) in enumerate(list(table.groupby(colour, sort=False))[: len(SERIES)]):
        row = rows.iloc[0]
        scattered = rf" $\pm$ {row['friction_std']:.2g}" if row["friction_std"] > 0 else ""
        name = (
            f"$f$ = {row['friction']:.4g}{scattered}"
            if colour == "friction_number"
            else _told(value)
        )
        axes.plot([], [], color=series(number)["color"], lw=3, label=name)
    return legend(axes, f"start and\n{_called(colour)}")


def _called(column: str | None) -> str:
    """A column of a study in words."""
    return _COLUMNS.get(column or "", str(column))


def _told(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


@picture.register
def _dissipation_range(found: DissipationRange, ax: AxesArray | None = None) -> AxesArray:
    """Two panels: slip range and work of friction per cycle of the steady states with the least and with the most work found.

    In space maps of each of the two states.
    """
    ends = {"least work found": found.least_state, "most work found": found.most_state}
    if found.least_state.system.tangents == 2:
        panels = panels_of(ax, found.least_state.system, blocks=2)
        halves = panels[: len(panels) // 2], panels[len(panels) // 2 :]
        for half, (name, steady) in zip(halves, ends.items(), strict=True):
            work_map(
                half,
                steady,
                rf"$\lambda = {steady.load_factor:.4g}$: {name}, $W = {steady.dissipation:.4g}$ per cycle",
            )
        return np.array(panels)
    slip, work = panels = new_axes(ax, 2, (6.4, 5.4))
    for number, (name, steady) in enumerate(ends.items()):
        slip_and_work(slip, work, steady, **line(number), label=name)
    slip.set_title(
        rf"$\lambda = {found.least_state.load_factor:.4g}$: $W$ from {found.least:.4g} to {found.most:.4g} per cycle found"
    )
    legend(slip)
    label_panels(panels, found.least_state.system)
    return np.array(panels)
