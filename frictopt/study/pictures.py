"""Pictures of studies: protocols, the range of the work, and the runs of a study."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from ..base import Table
from ..contact.face import panels_of
from ..contact.strip import label_panels, work_unit
from ..plots.draw import draw as draw
from ..plots.style import (
    ALONG,
    BLACK,
    GREY,
    AxesArray,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    picture,
    series,
)
from ..transients.pictures import slip_and_work, work_map
from .columns import FAILED, SLIDES_OFF
from .dissipation_range import DissipationRange
from .protocols import REST, SLIP, UNDECIDED, LimitAfterProtocol

_OUTCOMES = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}


@dataclass(frozen=True)
class StudyPictures:
    """The sizes in pictures of studies."""

    # Size of a picture with a row for each outcome, inches.
    outcomes: tuple[float, float] = (6.4, 2.4)
    # Height of each further panel of a study, inches.
    panel_height: float = 2.4
    # Share of the height of a panel for the runs without work, if several stand at one place.
    strip: float = 0.22


_SIZES = StudyPictures()

# Names of families of starts in legends.
_FAMILIES = {"none": "no slip"}
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
    (axes,) = new_axes(ax, size=_SIZES.outcomes)
    title = equals(r"shakes down up to $\lambda$", limit.load_factor)
    if not limit.monotonic:
        title += ", and at some load factors above"
    axes.set_title(title)
    _draw_tried(axes, limit.tried)
    axes.axvline(limit.load_factor, color=GREY, lw=0.8, zorder=0, label="limit after the protocol")
    limit_line(axes, r"shakedown limit $\lambda_2$", limit.shakedown_limit, BLACK)
    axes.set_xlabel(r"load factor $\lambda$")
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


def _draw_tried(axes: Axes, tried: Table) -> None:
    """A mark for each load factor tried, in the row of its outcome."""
    outcomes = [REST, SLIP]
    if (tried["outcome"] == UNDECIDED).any():
        outcomes.append(UNDECIDED)
    for row, outcome in enumerate(outcomes):
        values = tried.loc[tried["outcome"] == outcome, "load_factor"]
        axes.plot(
            values,
            np.full(len(values), row),
            linestyle="none",
            color=series(row)["color"],
            marker=series(row)["marker"],
            markersize=5,
            mfc="none",
        )
    axes.set(
        yticks=range(len(outcomes)),
        yticklabels=[_OUTCOMES[outcome] for outcome in outcomes],
        ylim=(-0.6, len(outcomes) - 0.4),
    )
    axes.tick_params(axis="y", length=0)


def limit_line(axes: Axes, name: str, limit: float, color: str) -> None:
    """Draw a limit across an axis of load factors, if it is finite and above 0."""
    if np.isfinite(limit) and limit > 0:
        axes.axvline(
            limit, color=color, lw=0.8, linestyle="--", zorder=0, label=equals(name, limit)
        )


@picture.register
def _dissipation_range(span: DissipationRange, ax: AxesArray | None = None) -> AxesArray:
    """Slip range and work of friction per cycle of the states with the least and the most work.

    In space maps of each of the two states.
    """
    states = {"least work found": span.least_state, "most work found": span.most_state}
    system = span.least_state.system
    unit = work_unit(system.per_depth)
    load_factor = rf"$\lambda = {span.least_state.load_factor:.4g}$"
    if system.tangents == 2:
        panels = panels_of(ax, system, blocks=2)
        half = len(panels) // 2
        for maps, (name, steady) in zip(
            (panels[:half], panels[half:]), states.items(), strict=True
        ):
            work = f"$W$ = {steady.dissipation:.4g} {unit} per cycle"
            work_map(maps, steady, f"{load_factor}: {name}, {work}")
        return np.array(panels)
    slip_axes, work_axes = panels = new_axes(ax, 2, (6.4, 5.4))
    for number, (name, steady) in enumerate(states.items()):
        slip_and_work(slip_axes, work_axes, steady, **line(number), label=name)
    slip_axes.set_title(
        f"{load_factor}: $W$ from {span.least:.4g} to {span.most:.4g} {unit} per cycle found"
    )
    legend(slip_axes)
    label_panels(panels, system)
    return np.array(panels)


def runs_of(
    table: Table,
    ax: Axes | AxesArray | None = None,
    x: str | None = None,
    colour: str | None = None,
    rows: str | None = None,
) -> Axes | AxesArray:
    """Steady dissipation of the runs of a study against one of its columns, see `plot_study`."""
    study = _StudyPicture(table, x, colour)
    panels = [None] if rows is None else list(table[rows].unique())
    height = ALONG[1] + _SIZES.panel_height * (len(panels) - 1)
    all_axes = new_axes(ax, len(panels), (ALONG[0], height))
    for axes, value in zip(all_axes, panels, strict=True):
        runs = study.runs if rows is None else study.runs[study.runs[rows] == value]
        study.draw_panel(axes, runs)
        title = [] if rows is None else [f"{_column_name(rows)}: {_value_name(value)}"]
        if axes is all_axes[0]:
            title += study.without_mark()
        axes.set_title(", ".join(title))
    all_axes[-1].set_xlabel(_column_name(study.x))
    study.draw_legend(all_axes[0])
    return all_axes[0] if rows is None else np.array(all_axes)


class _StudyPicture:
    """The runs of a study: a marker for each family of starts, a colour for each value of a column.

    Attributes
    ----------
    table, x, colour
        The study, the column along the horizontal axis, and that of the colours; None: family.
    runs
        The runs with a steady state, with the place of their marks along the horizontal axis in the
        column `place`.
    names
        Values along the horizontal axis if they are no numbers.
    low, high, bottom
        Range of the dissipation. Runs without any stand in a strip below it, which ends at
        `bottom`.
    """

    def __init__(self, table: Table, x: str | None, colour: str | None) -> None:
        self.table = table
        self.families = list(table["family"].unique())
        runs = table[~table["outcome"].isin([FAILED, SLIDES_OFF])]
        if x is None:
            ratios = runs.get("load_ratio", pd.Series([np.nan]))
            x = "load_ratio" if np.isfinite(ratios).all() else "load_factor"
            if table["load_factor"].nunique() == 1 and table["friction"].nunique() > 1:
                x = "friction"
        self.x = x
        named = ["cycle"] if x == "friction" else ["friction_number", "cycle"]
        axes_of_study = [name for name in named if table[name].nunique() > 1]
        if colour is None and axes_of_study:
            colour = axes_of_study[0]
        self.colour = colour

        works = runs.loc[runs["dissipation"] > 0, "dissipation"]
        self.low = works.min() / 3 if len(works) else 0.1
        self.high = works.max() * 3 if len(works) else 10.0
        self.names: list[object] = []
        place = runs[x]
        if not pd.api.types.is_numeric_dtype(table[x]):
            self.names = list(table[x].unique())
            place = place.map({name: number for number, name in enumerate(self.names)})
        self.runs = runs.assign(place=place)
        self.bottom = self.low / 4
        if self._at_rest(self.runs).groupby(place).sum().max() > 1:
            self.bottom = self.low / (self.high / self.low) ** (_SIZES.strip / (1 - _SIZES.strip))

    def without_mark(self) -> list[str]:
        """The numbers of runs without a steady state, in words."""
        words = {SLIDES_OFF: "runs slide off", FAILED: "runs failed"}
        numbers = {word: int((self.table["outcome"] == name).sum()) for name, word in words.items()}
        return [f"{n} of {len(self.table)} {word}" for word, n in numbers.items() if n]

    def _at_rest(self, runs: Table) -> "pd.Series[bool]":
        """Whether each run has no dissipation."""
        return ~(runs["dissipation"] > 0)

    def _heights(self, runs: Table) -> "pd.Series[float]":
        """Height of the mark of each run of a panel.

        Runs without dissipation at one place stand above each other in the strip.
        """
        at_rest = self._at_rest(runs)
        rank = at_rest.groupby(runs["place"]).cumsum()
        number = at_rest.groupby(runs["place"]).transform("sum")
        strip = self.low * (self.bottom / self.low) ** (rank / (number + 1))
        return runs["dissipation"].where(~at_rest, strip)

    def draw_panel(self, axes: Axes, runs: Table) -> None:
        """A mark for each run, above a strip for runs without dissipation."""
        runs = runs.assign(height=self._heights(runs))
        colour = self.colour or "family"
        colours = list(self.table[colour].unique())
        for (family, value), group in runs.groupby(["family", colour], sort=False):
            axes.plot(
                group["place"],
                group["height"],
                color=series(colours.index(value), len(colours))["color"],
                marker=series(self.families.index(family))["marker"],
                label=_family_name(family) if self.colour is None else None,
                markersize=5,
                linestyle="none",
                mfc="none",
            )
        axes.axhline(self.low, color=BLACK, lw=0.6)
        # A table of a store does not state it, but only a contact in the plane has an exact path.
        in_plane = (self.table["engine"] == "path").any()
        per_depth = self.table.attrs.get("per_depth", in_plane)
        unit = work_unit(per_depth)
        axes.set(
            yscale="log",
            ylim=(self.bottom, self.high),
            ylabel=f"work of friction per cycle, $W$\n{unit}",
        )
        for minor in (False, True):
            ticks = axes.get_yticks(minor=minor)
            axes.set_yticks(ticks[(ticks >= self.low) & (ticks <= self.high)], minor=minor)
        axes.annotate(
            "$W = 0$",
            (1, np.sqrt(self.low * self.bottom)),
            (5, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="center",
        )
        if self.names:
            count = len(self.names)
            axes.set(
                xticks=range(count), xticklabels=map(as_is, self.names), xlim=(-0.5, count - 0.5)
            )
        elif self.x == "load_ratio":
            axes.axvline(1, color=BLACK, lw=0.8, linestyle="--")

    def draw_legend(self, axes: Axes) -> None:
        """The legend of all runs: markers of the families, and colours of the column."""
        if self.colour is None:
            return legend(axes, "start")
        for number, family in enumerate(self.families):
            marker = series(number)["marker"]
            look = {"color": BLACK, "marker": marker, "mfc": "none", "linestyle": "none"}
            axes.plot([], [], label=_family_name(family), **look)
        groups = list(self.table.groupby(self.colour, sort=False))
        for number, (value, group) in enumerate(groups):
            name = _value_name(value)
            if self.colour == "friction_number":
                name = _friction_name(group.iloc[0])
            axes.plot([], [], color=series(number, len(groups))["color"], lw=3, label=name)
        return legend(axes, f"start and\n{_column_name(self.colour)}")


def _family_name(family: str) -> str:
    return _FAMILIES.get(family, as_is(family))


def _friction_name(run: "pd.Series[float]") -> str:
    # As a float, 1 is 1.0 between 0.9 and 1.1.
    friction = float(f"{run['friction']:.4g}")
    name = f"$f$ = {friction}"
    if run["friction_std"] > 0:
        name += rf" $\pm$ {run['friction_std']:.2g}"
    return name


def _column_name(column: str | None) -> str:
    """A column of a study in words."""
    return _COLUMNS.get(column or "", as_is(column))


def _value_name(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else as_is(value)
