"""Pictures of studies: protocols, the range of the work, and the runs of a study."""

import numpy as np
import pandas as pd

from ..base import Table
from ..contact.pictures import panels_of
from ..plots.along import along
from ..plots.draw import draw as draw
from ..plots.style import (
    ALONG,
    BLACK,
    GREY,
    AnyAxes,
    Look,
    as_is,
    equals,
    legend,
    limit_line,
    new_axes,
    picture,
    series,
    together,
    unit,
)
from ..transients.pictures import slip_and_work, work_map
from .columns import FAILED, SLIDES_OFF
from .dissipation_range import DissipationRange
from .protocols import REST, SLIP, UNDECIDED, FrictionAfterProtocol, LimitAfterProtocol

_OUTCOMES = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}

# Share of the height of a panel for the runs without work.
_STRIP = 0.22

_COLUMNS = {
    "load_ratio": r"load factor over the shakedown limit, $\lambda / \lambda_2$",
    "load_factor": r"load factor $\lambda$",
    "friction_number": "friction",
    "cycle": "load cycle",
    "amplitude": "initial slip, root mean square (length)",
}


@picture.register
def _limit_after_protocol(limit: LimitAfterProtocol, ax: AnyAxes = None) -> AnyAxes:
    """The load factors tried, in a row for each outcome."""
    title = equals(r"shakes down up to $\lambda$", limit.load_factor)
    if not limit.monotonic:
        title += ", and at some load factors above"
    axes = _tried(ax, limit.tried, title)
    limit_line(axes, "limit after the protocol", limit.load_factor, color=GREY, ls="-")
    name = equals(r"shakedown limit $\lambda_2$", limit.shakedown_limit)
    limit_line(axes, name, limit.shakedown_limit, color=BLACK)
    axes.set_xlabel(r"load factor $\lambda$")
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


@picture.register
def _friction_after_protocol(answer: FrictionAfterProtocol, ax: AnyAxes = None) -> AnyAxes:
    """The frictions tried, in a row for each outcome."""
    title = equals("shakes down from friction", answer.required)
    if not answer.monotonic:
        title += " on, and with some frictions below"
    axes = _tried(ax, answer.tried, title)
    limit_line(axes, "required friction", answer.least, color=BLACK)
    axes.set_xlabel("friction")
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


def _tried(ax: AnyAxes, tried: Table, title: str) -> AnyAxes:
    """A mark for each load factor or friction tried, in the row of its outcome."""
    (axes,) = new_axes(ax, size=(6.4, 2.4))
    axes.set_title(title)
    outcomes = [name for name in _OUTCOMES if name != UNDECIDED or (tried["outcome"] == name).any()]
    for row, outcome in enumerate(outcomes):
        values = tried.loc[tried["outcome"] == outcome].iloc[:, 0]
        look: Look = series(row) | {"linestyle": "none", "markersize": 5, "mfc": "none"}
        axes.plot(values, np.full(len(values), row), **look)
    names = [_OUTCOMES[outcome] for outcome in outcomes]
    axes.set(yticks=range(len(names)), yticklabels=names, ylim=(-0.6, len(names) - 0.4))
    axes.tick_params(axis="y", length=0)
    return axes


@picture.register
def _dissipation_range(span: DissipationRange, ax: AnyAxes = None) -> AnyAxes:
    """Slip range and work of friction per cycle of the states with the least and the most work.

    In space a map of the state with the most work.
    """
    states = {"least work found": span.least_state, "most work found": span.most_state}
    system = span.most_state.system
    of_work = unit("force times length", system.per_depth)
    works = f"$W$ from {span.least:.4g} to {span.most:.4g} {of_work} per cycle found"
    title = rf"$\lambda = {span.most_state.load_factor:.4g}$: {works}"
    if system.tangents == 2:
        return work_map(panels_of(ax, system), span.most_state, f"{title}\nstate of the most work")
    panels = new_axes(ax, 2, (6.4, 5.4))
    panels[0].set_title(title)
    along(panels, system, slip_and_work(states))
    return np.array(panels)


def runs_of(
    table: Table,
    ax: AnyAxes = None,
    x: str | None = None,
    colour: str | None = None,
    rows: str | None = None,
) -> AnyAxes:
    """Steady dissipation of the runs of a study against one of its columns, see `plot_study`.

    A marker for each family of starts, a colour for each value of a column.
    """
    of_outcome = table["outcome"].value_counts()
    words = {SLIDES_OFF: "runs slide off", FAILED: "runs failed"}
    missing = [f"{of_outcome[n]} of {len(table)} {w}" for n, w in words.items() if n in of_outcome]
    runs = table[~table["outcome"].isin([*words])]
    x = x or _usual_x(table, runs)
    if colour is None:
        several = ["cycle"] if x == "friction" else ["friction_number", "cycle"]
        colour = next((name for name in several if table[name].nunique() > 1), "family")
    names = None
    runs = runs.assign(place=runs[x])
    if not pd.api.types.is_numeric_dtype(table[x]):
        names = list(table[x].unique())
        runs["place"] = runs[x].map(names.index)

    panels = [None] if rows is None else list(table[rows].unique())
    all_axes = new_axes(ax, len(panels), (ALONG[0], ALONG[1] + 2.4 * (len(panels) - 1)))
    low, high = _range_of_work(runs)
    for axes, value in zip(all_axes, panels, strict=True):
        of_panel = runs if rows is None else runs[runs[rows] == value]
        _draw_runs(axes, of_panel, table, colour, low, high)
        title = [] if rows is None else [f"{_column_name(rows)}: {_value_name(value)}"]
        if names is not None:
            places = {"xticks": range(len(names)), "xticklabels": map(as_is, names)}
            axes.set(**places, xlim=(-0.5, len(names) - 0.5))
        elif x == "load_ratio":
            limit_line(axes, "_", 1.0, color=BLACK)
        axes.set_title(", ".join(title + (missing if axes is all_axes[0] else [])))
    all_axes[-1].set_xlabel(_column_name(x))
    _legend_of_runs(all_axes[0], table, colour)
    return together(all_axes) if rows is None else np.array(all_axes)


def _usual_x(table: Table, runs: Table) -> str:
    """The column along which runs are drawn, unless the user names one."""
    if table["load_factor"].nunique() == 1 and table["friction"].nunique() > 1:
        return "friction"
    if np.isfinite(runs.get("load_ratio", np.nan)).all():
        return "load_ratio"
    return "load_factor"


def _range_of_work(runs: Table) -> tuple[float, float]:
    """The range of the axis of the work, above the strip of runs without work."""
    works = runs.loc[runs["dissipation"] > 0, "dissipation"]
    return (works.min() / 3, works.max() * 3) if len(works) else (0.1, 10.0)


def _draw_runs(
    axes: AnyAxes, runs: Table, table: Table, colour: str, low: float, high: float
) -> None:
    """A mark for each run of a panel.

    Runs without work at one place stand above each other in a strip at the bottom.
    """
    bottom = low / (high / low) ** (_STRIP / (1 - _STRIP))
    at_rest = ~(runs["dissipation"] > 0)
    rank = at_rest.groupby(runs["place"]).cumsum()
    number = at_rest.groupby(runs["place"]).transform("sum")
    strip = low * (bottom / low) ** (rank / (number + 1))
    runs = runs.assign(height=runs["dissipation"].where(~at_rest, strip))
    markers, colours = _looks(table, "family", "marker"), _looks(table, colour, "color")
    for (family, value), group in runs.groupby(["family", colour], sort=False):
        look: Look = {"color": colours[value], "marker": markers[family], "mfc": "none"}
        look["label"] = _family_name(family) if colour == "family" else None
        axes.plot(group["place"], group["height"], linestyle="none", markersize=5, **look)
    axes.axhline(low, color=BLACK, lw=0.6)
    # A table of a store does not state it, but only a contact in the plane has an exact path.
    per_depth = table.attrs.get("per_depth", (table["engine"] == "path").any())
    name = f"work of friction per cycle, $W$\n{unit('force times length', per_depth)}"
    axes.set(yscale="log", ylim=(bottom, high), ylabel=name)
    for minor in (False, True):
        ticks = axes.get_yticks(minor=minor)
        axes.set_yticks(ticks[(ticks >= low) & (ticks <= high)], minor=minor)
    place = axes.get_yaxis_transform()
    axes.text(1.01, np.sqrt(low * bottom), "$W = 0$", va="center", transform=place)


def _looks(table: Table, column: str, part: str) -> dict[object, str]:
    """The marker or the colour of each value of a column."""
    values = list(table[column].unique())
    return {value: series(number, len(values))[part] for number, value in enumerate(values)}


def _legend_of_runs(axes: AnyAxes, table: Table, colour: str) -> None:
    """The legend of all runs: markers of the families of starts, and colours of the column."""
    if colour == "family":
        return legend(axes, "start")
    for family, marker in _looks(table, "family", "marker").items():
        look: Look = {"color": BLACK, "marker": marker, "mfc": "none", "linestyle": "none"}
        axes.plot([], [], label=_family_name(family), **look)
    for value, color in _looks(table, colour, "color").items():
        name = _value_name(value)
        if colour == "friction_number":
            name = _friction_name(table[table[colour] == value].iloc[0])
        axes.plot([], [], color=color, lw=3, label=name)
    return legend(axes, f"start and\n{_column_name(colour)}")


def _family_name(family: object) -> str:
    return "no slip" if family == "none" else as_is(family)


def _friction_name(run: "pd.Series[float]") -> str:
    # As a float, 1 is 1.0 between 0.9 and 1.1.
    friction = float(f"{run['friction']:.4g}")
    return f"$f$ = {friction}" + (
        rf" $\pm$ {run['friction_std']:.2g}" if run["friction_std"] > 0 else ""
    )


def _column_name(column: str) -> str:
    """A column of a study in words."""
    return _COLUMNS.get(column, as_is(column))


def _value_name(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else as_is(value)
