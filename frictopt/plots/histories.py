"""Pictures of what follows from many transients: what was tried, damping, wear, and the runs of a study."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from ..contact import Table
from ..histories.backbone_result import BackboneCurve
from ..histories.excursion import LeastExcursion
from ..histories.protocols import REST, SLIP, UNDECIDED, LimitAfterProtocol
from ..histories.wear import WearHistory
from ..histories.worn_in import WornIn
from .face import face_map, panels_of
from .strip import label_contacts, label_panels, lines, work_label
from .style import ALONG, BLACK, GREY, POINTS, SERIES, AxesArray, Look, equals, legend, line, new_axes, no_lines, picture, series

_STRIP = 6.4, 2.4  # size of a picture with a row for each outcome, inches
_ROWS = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}
_DEPTH = "depth worn off (length)"
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
    _limit_line(axes, r"shakedown limit $\lambda_2$", limit.shakedown_limit, BLACK)
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
    rows = [outcome for outcome in _ROWS if outcome != UNDECIDED or (tried["outcome"] == UNDECIDED).any()]
    for row, outcome in enumerate(rows):
        at, look = tried.loc[tried["outcome"] == outcome, column], {name: series(row)[name] for name in ("color", "marker")}
        axes.plot(at, np.full(len(at), row), linestyle="none", markersize=5, mfc="none", **look)
    axes.set(yticks=range(len(rows)), yticklabels=[_ROWS[row] for row in rows], ylim=(-0.6, len(rows) - 0.4))
    axes.tick_params(axis="y", length=0)
    if np.isfinite(found):
        axes.axvline(found, color=GREY, lw=0.8, zorder=0, label=name)


def _limit_line(axes: Axes, name: str, limit: float, color: str) -> None:
    """Draw a limit, where it is finite and above 0, across an axis of load factors."""
    if np.isfinite(limit) and limit > 0:
        axes.axvline(limit, color=color, lw=0.8, linestyle="--", zorder=0, label=equals(name, limit))


@picture.register
def _backbone_curve(curve: BackboneCurve, ax: AxesArray | None = None) -> AxesArray:
    """Over the load factor (log), up to the sliding-off load: work, slipping share of each contact, and stiffness and damping where they are known.

    Of a mode the frequency stands for the stiffness. Bands are ranges over the residual slips, lines the limits.
    """
    known, look = bool(np.isfinite(curve.stiffness).any()), {name: series(0)[name] for name in ("color", "marker")}
    work, share, *more = panels = new_axes(ax, 4 if known else 2, (6.4, 9.0 if known else 5.4))
    work.plot(curve.load_factor, np.where(curve.work > 0, curve.work, np.nan), **look)
    work.set(yscale="log", ylabel=work_label(curve.system))
    for number, (name, rows) in enumerate(curve.by_contact.groupby("contact", sort=False)):
        share.plot(rows["load_factor"], rows["slipping"], **line(number), label=name)
    if curve.by_contact["contact"].nunique() > 1:
        share.plot(curve.load_factor, curve.slipping, color=BLACK, label="all")
        legend(share)
    share.set(ylabel="share that slips", ylim=(-0.03, 1.03))
    mode = np.isfinite(curve.natural_frequency)
    ranges = (curve.least_frequency, curve.most_frequency), (curve.least_damping, curve.most_damping)
    for axes, name, (least, most) in zip(more, ("frequency" if mode else "stiffness", "damping"), ranges, strict=False):
        axes.plot(curve.load_factor, getattr(curve, name), **look, label="without residual slip")
        if not np.isnan(least).all():
            axes.fill_between(curve.load_factor, least, most, color=look["color"], alpha=0.2, lw=0, label="range over residual slips")
    for axes in panels:
        axes.set_xscale("log")
        _limit_line(axes, r"guaranteed limit $\lambda_1$", curve.guaranteed_limit, GREY)
        _limit_line(axes, r"shakedown limit $\lambda_2$", curve.shakedown_limit, BLACK)
        _limit_line(axes, "bodies slide off" + ", from no slip" * curve.self_stress, curve.gross_slip, SERIES[1]["color"])
    if known:
        if mode:
            more[0].axhline(curve.natural_frequency, color=GREY, lw=0.6, zorder=0, label="glued contact")
        more[0].set_ylabel("frequency (cycles per time)" if mode else "stiffness\n(load factor over displacement)")
        more[1].set_ylabel(r"damping ratio $\zeta$")
    legend(more[0] if known else work)
    last = panels[-1]
    last.set_xlabel(r"load factor $\lambda$")
    low, high = last.get_xlim()
    if high < 30 * low:  # plain numbers, not powers of ten
        last.xaxis.set(major_locator=LogLocator(subs=(1, 2, 3, 5, 7)), major_formatter=ScalarFormatter(), minor_formatter=NullFormatter())
    return np.array(panels)


@picture.register
def _wear(history: WearHistory, ax: AxesArray | None = None) -> AxesArray:
    """Three panels: depth worn off and pressure along the contact after some numbers of cycles; work of friction per cycle against cycles.

    In space two: a map of the depth in the end, and the work of friction per cycle.
    """
    table, system = history.to_frame(), history.system
    if system.tangents == 2:
        *maps, work = panels = panels_of(ax, system, more=1)
        maps[0].set_title(f"depth worn off after {table['cycles'].iloc[-1]:.4g} cycles")
        face_map(maps, system, history.depth[-1], _DEPTH)
    else:
        depth, pressure, work = panels = new_axes(ax, 3, (6.4, 8.4), common_x=False)
        largest = history.depth.max(axis=1)
        even = [np.abs(largest - part).argmin() for part in np.linspace(0.0, largest[-1], 6)[:-1]]  # steps of the largest depth
        for number, row in enumerate(np.unique([*even, len(largest) - 1])):
            label = f"{table['cycles'][row]:.4g}"
            lines(depth, system, history.depth[row], label=label, **line(number))
            lines(pressure, system, history.pressure[row], label=label, **line(number))
        depth.set_ylabel(_DEPTH)
        pressure.set_ylabel("pressure at the last corner\n(force per area)")
        legend(depth, "cycles")
        label_panels([depth, pressure], system)
    work.plot(table["cycles"], table["work"], color=BLACK, **POINTS)
    work.set(xlabel="load cycles", ylabel=work_label(system), ylim=(0.0, None))
    return np.array(panels)


@picture.register
def _worn_in(end: WornIn, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Depth worn off along the contact, and the nodes that never slip; in space a map of the depth."""
    system = end.system
    axes, *_ = panels = panels_of(ax, system)
    axes.set_title(f"worn in: {int(end.stick.sum())} of {system.nodes} nodes never slip")
    if system.tangents == 2:
        return face_map(panels, system, end.depth, _DEPTH)
    lines(axes, system, end.depth, color=BLACK, label="depth worn off")
    lines(axes, system, np.where(end.stick, 0.0, np.nan), color=series(0)["color"], lw=3.0, label="never slips")
    axes.set_ylabel(_DEPTH)
    label_contacts(axes, system)
    legend(axes)
    return axes


def runs_of(
    table: Table, ax: Axes | AxesArray | None = None, x: str | None = None, colour: str | None = None, rows: str | None = None
) -> Axes | AxesArray:
    """Steady dissipation against the load, over a finite lambda_2, or another column; a look for each family of starts, panels and colours."""
    runs = table[table["outcome"] != "FAILED"]
    along = x or ("load_ratio" if np.isfinite(runs["load_ratio"]).all() else "load_factor")
    if colour is None:
        colour = next((name for name in ("friction_number", "cycle") if table[name].nunique() > 1), None)
    panels = [None] if rows is None else list(table[rows].unique())
    every = new_axes(ax, len(panels), (ALONG[0], ALONG[1] + _PANEL * (len(panels) - 1)))
    slips = runs.loc[runs["dissipation"] > 0, "dissipation"]
    low, high = (slips.min() / 3, slips.max() * 3) if len(slips) else (0.1, 10.0)
    names = None if pd.api.types.is_numeric_dtype(table[along]) else {value: place for place, value in enumerate(table[along].unique())}
    at = runs[along] if names is None else runs[along].map(names)
    shown = runs.assign(x=at, work=runs["dissipation"].where(runs["dissipation"] > 0, low / 2))
    per_depth = " per depth" if (table["engine"] == "path").any() else ""  # in space a study has increments alone
    failed = [f"{len(table) - len(runs)} of {len(table)} runs failed"] * (len(runs) < len(table))
    for axes, value in zip(every, panels, strict=True):
        _runs(axes, table, shown if value is None else shown[shown[rows] == value], colour)
        axes.axhline(low, color=BLACK, lw=0.6)
        axes.set(yscale="log", ylim=(low / 4, high), ylabel=f"work of friction per cycle, $W$\n(force times length{per_depth})")
        axes.annotate("$W = 0$", (1, low / 2), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center")
        if names is not None:
            axes.set(xticks=range(len(names)), xticklabels=list(names), xlim=(-0.5, len(names) - 0.5))
        elif along == "load_ratio":
            axes.axvline(1, color=BLACK, lw=0.8, linestyle="--")
        axes.set_title(", ".join([f"{_called(rows)}: {_told(value)}"] * (rows is not None) + failed))
        failed = []
    every[-1].set_xlabel(_called(along))
    _legend_of_runs(every[0], table, colour)
    return every[0] if rows is None else np.array(every)


def _runs(axes: Axes, table: Table, runs: Table, colour: str | None) -> None:
    """A mark for each run at its place and work: the marker of its family, the colour of its value in a column, or of its family too."""
    families = {name: k for k, name in enumerate(table["family"].unique())}
    colours = families if colour is None else {value: k for k, value in enumerate(table[colour].unique())}
    for (family, value), some in runs.groupby(["family", colour or "family"], sort=False):
        look: Look = {"color": series(colours[value])["color"], "marker": series(families[family])["marker"], "label": None if colour else family}
        axes.plot(some["x"], some["work"], markersize=5, linestyle="none", mfc="none", **look)


def _legend_of_runs(axes: Axes, table: Table, colour: str | None) -> None:
    """The legend of all runs of a study."""
    if colour is None:
        return legend(axes, "start")
    for number, family in enumerate(table["family"].unique()):
        axes.plot([], [], color=BLACK, marker=series(number)["marker"], label=family, linestyle="none", mfc="none")
    for number, (value, rows) in enumerate(list(table.groupby(colour, sort=False))[: len(SERIES)]):
        row = rows.iloc[0]
        scattered = rf" $\pm$ {row['friction_std']:.2g}" if row["friction_std"] > 0 else ""
        name = f"$f$ = {row['friction']:.4g}{scattered}" if colour == "friction_number" else _told(value)
        axes.plot([], [], color=series(number)["color"], lw=3, label=name)
    return legend(axes, f"start and\n{_called(colour)}")


def _called(column: str | None) -> str:
    """A column of a study in words."""
    return _COLUMNS.get(column or "", str(column))


def _told(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
