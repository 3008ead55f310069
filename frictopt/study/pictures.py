"""Pictures of studies: protocols, the range of the work, and the runs of a study."""

import numpy as np
import pandas as pd

from ..base import Table
from ..plots.along import along
from ..plots.style import (
    BLACK,
    GREY,
    AnyAxes,
    Look,
    as_is,
    equals,
    legend,
    new_axes,
    picture,
    series,
    unit,
)
from ..transients.pictures import slip_and_work, work_map
from .case import FAILED, SLIDES_OFF
from .dissipation_range import DissipationRange
from .protocols import REST, SLIP, UNDECIDED, FrictionAfterProtocol, LimitAfterProtocol

_OUTCOMES = {REST: "comes to rest", SLIP: "keeps slipping", UNDECIDED: "undecided"}

_COLUMNS = {
    "load_ratio": r"load factor over the shakedown limit, $\lambda / \lambda_2$",
    "load_factor": r"load factor $\lambda$",
    "cycle": "load cycle",
    "amplitude": "initial slip, root mean square (length)",
}


@picture.register
def _after_protocol(answer: LimitAfterProtocol | FrictionAfterProtocol, ax: AnyAxes) -> AnyAxes:
    """A mark for each load factor or friction tried, in the row of its outcome."""
    (axes,) = new_axes(ax, size=(6.4, 2.4))
    rows = list(_OUTCOMES)
    for number, (outcome, tried) in enumerate(answer.tried.groupby("outcome", sort=False)):
        row = rows.index(outcome)
        look: Look = series(number) | {"linestyle": "none", "markersize": 5, "mfc": "none"}
        axes.plot(tried.iloc[:, 0], np.full(len(tried), row), **look)
    axes.set(yticks=range(len(rows)), yticklabels=_OUTCOMES.values(), ylim=(-0.6, 2.6))
    if isinstance(answer, LimitAfterProtocol):
        limits = {"limit after the protocol": answer.load_factor}
        limits[r"shakedown limit $\lambda_2$"] = answer.shakedown_limit
        name = _COLUMNS["load_factor"]
    else:
        limits = {"friction after the protocol": answer.required, "required friction": answer.least}
        name = "friction"
    for number, (label, limit) in enumerate(limits.items()):
        axes.axvline(limit, color=(GREY, BLACK)[number], lw=0.8, label=equals(label, limit))
    axes.set_title("" if answer.monotonic else "some values beyond the limit come to rest, too")
    axes.set_xlabel(name)
    axes.set_xlim(left=0.0)
    legend(axes)
    return axes


@picture.register
def _dissipation_range(span: DissipationRange, ax: AnyAxes) -> AnyAxes:
    """Slip range and work of friction per cycle of the states with the least and the most work.

    In space a map of the state with the most work.
    """
    states = {"least work found": span.least_state, "most work found": span.most_state}
    system = span.most_state.system
    of_work = unit("force times length", system.per_depth)
    works = f"$W$ from {span.least:.4g} to {span.most:.4g} {of_work} per cycle found"
    title = rf"$\lambda = {span.most_state.load_factor:.4g}$: {works}"
    if system.tangents == 2:
        return work_map(ax, span.most_state, f"{title}\nstate of the most work")
    panels = new_axes(ax, 2, (6.4, 5.4))
    panels[0].set_title(title)
    along(panels, system, slip_and_work(states))
    return np.array(panels)


@picture.register
def _runs(table: Table, ax: AnyAxes, x: str | None, colour: str | None) -> AnyAxes:
    """Steady dissipation of the runs of a study against one of its columns, see `plot_study`.

    A marker for each family of starts, a colour for each value of a column.
    """
    (axes,) = new_axes(ax)
    of_outcome = table["outcome"].value_counts()
    words = {SLIDES_OFF: "runs slide off", FAILED: "runs failed"}
    missing = [f"{of_outcome[n]} of {len(table)} {w}" for n, w in words.items() if n in of_outcome]
    axes.set_title(", ".join(missing))
    runs = table[~table["outcome"].isin([*words])]
    x = x or _usual_x(table, runs)
    if colour is None:
        several = ["cycle"] if x == "friction" else ["friction", "cycle"]
        colour = next((name for name in several if table[name].nunique() > 1), "family")
    markers, colours = _looks(table, "family", "marker"), _looks(table, colour, "color")
    places = runs[x] if pd.api.types.is_numeric_dtype(runs[x]) else runs[x].map(as_is)
    for (family, value), group in runs.groupby(["family", colour], sort=False):
        axes.plot(
            places[group.index],
            group["dissipation"],
            linestyle="none",
            marker=markers[family],
            markersize=5,
            mfc="none",
            color=colours[value],
            clip_on=False,
            label=_name(family) if colour == "family" else None,
        )
    if x == "load_ratio":
        axes.axvline(1.0, color=BLACK, lw=0.8, ls="--", zorder=0)
    # A table from a store lacks this attribute. There, exact paths show a contact in the plane.
    per_depth = table.attrs.get("per_depth", (table["engine"] == "path").any())
    name = f"work of friction per cycle, $W$\n{unit('force times length', per_depth)}"
    axes.set(xlabel=_COLUMNS.get(x, as_is(x)), ylabel=name)
    axes.set_ylim(bottom=0.0)
    title = "start"
    if colour != "family":
        title = f"start and\n{_COLUMNS.get(colour, as_is(colour))}"
        for family, marker in markers.items():
            axes.plot(
                [],
                [],
                color=BLACK,
                marker=marker,
                mfc="none",
                linestyle="none",
                label=_name(family),
            )
        for value, color in colours.items():
            axes.plot([], [], color=color, lw=3, label=_name(value))
    legend(axes, title)
    return axes


def _usual_x(table: Table, runs: Table) -> str:
    """The column along which runs are drawn, unless the user names one."""
    if table["load_factor"].nunique() == 1 and table["friction"].nunique() > 1:
        return "friction"
    if np.isfinite(runs.get("load_ratio", np.nan)).all():
        return "load_ratio"
    return "load_factor"


def _looks(table: Table, column: str, part: str) -> dict[object, str]:
    """The marker or the colour of each value of a column."""
    values = list(table[column].unique())
    return {value: series(number, len(values))[part] for number, value in enumerate(values)}


def _name(value: object) -> str:
    """A value of a column, or a family of starts."""
    if isinstance(value, float):
        return f"{value:.4g}"
    return "no slip" if value == "none" else as_is(value)
