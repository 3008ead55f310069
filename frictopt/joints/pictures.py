"""Pictures of joints: the backbone curve, wear, and the worn-in contact."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from ..base import Array
from ..contact.face import face_map, panels_of
from ..contact.strip import label_contacts, label_panels, lines, work_label
from ..plots.draw import draw as draw
from ..plots.style import (
    BLACK,
    GREY,
    POINTS,
    SERIES,
    AxesArray,
    legend,
    line,
    new_axes,
    picture,
    series,
)
from ..study.pictures import limit_line
from .backbone import BackboneCurve
from .wear import WearHistory
from .worn_in import WornIn

_DEPTH = "depth worn off (length)"
_MARKED = {name: series(0)[name] for name in ("color", "marker")}


@picture.register
def _backbone_curve(curve: BackboneCurve, ax: AxesArray | None = None) -> AxesArray:
    """Work, slipping share of each contact, stiffness and damping over the load factor (log).

    The last two are drawn if they are known; of a mode the frequency stands for the stiffness.
    Bands are ranges over the residual slips, vertical lines are limits.
    """
    has_stiffness = bool(np.isfinite(curve.stiffness).any())
    is_mode = bool(np.isfinite(curve.natural_frequency))
    if has_stiffness:
        panels = new_axes(ax, 4, (6.4, 9.0))
    else:
        panels = new_axes(ax, 2, (6.4, 5.4))
    _draw_work(panels[0], curve)
    _draw_shares(panels[1], curve)
    if has_stiffness:
        _, _, stiffness, damping = panels
        if is_mode:
            _draw_with_band(
                stiffness, curve, curve.frequency, curve.least_frequency, curve.most_frequency
            )
            stiffness.set_ylabel("frequency (cycles per time)")
        else:
            _draw_with_band(
                stiffness, curve, curve.stiffness, curve.least_frequency, curve.most_frequency
            )
            stiffness.set_ylabel("stiffness\n(load factor over displacement)")
        _draw_with_band(damping, curve, curve.damping, curve.least_damping, curve.most_damping)
        damping.set_ylabel(r"damping ratio $\zeta$")
    for axes in panels:
        axes.set_xscale("log")
        _draw_limits(axes, curve)
    if has_stiffness and is_mode:
        panels[2].axhline(
            curve.natural_frequency, color=GREY, lw=0.6, zorder=0, label="glued contact"
        )
    legend(panels[2] if has_stiffness else panels[0])
    _label_load_factors(panels[-1])
    return np.array(panels)


def _draw_work(axes: Axes, curve: BackboneCurve) -> None:
    work = np.where(curve.work > 0, curve.work, np.nan)
    axes.plot(curve.load_factor, work, **_MARKED)
    axes.set(yscale="log", ylabel=work_label(curve.system))


def _draw_shares(axes: Axes, curve: BackboneCurve) -> None:
    """The slipping share of each contact, and that of all if there are several."""
    contacts = curve.by_contact.groupby("contact", sort=False)
    for number, (name, rows) in enumerate(contacts):
        axes.plot(rows["load_factor"], rows["slipping"], **line(number), label=name)
    if len(contacts) > 1:
        axes.plot(curve.load_factor, curve.slipping, color=BLACK, label="all")
        legend(axes)
    axes.set(ylabel="share that slips", ylim=(-0.03, 1.03))


def _draw_with_band(
    axes: Axes, curve: BackboneCurve, values: Array, least: Array, most: Array
) -> None:
    """Values from no residual slip, and a band of their range if it is known."""
    axes.plot(curve.load_factor, values, **_MARKED, label="without residual slip")
    if not np.isnan(least).all():
        axes.fill_between(
            curve.load_factor,
            least,
            most,
            color=_MARKED["color"],
            alpha=0.2,
            lw=0,
            label="range over residual slips",
        )


def _draw_limits(axes: Axes, curve: BackboneCurve) -> None:
    limit_line(axes, r"guaranteed limit $\lambda_1$", curve.guaranteed_limit, GREY)
    limit_line(axes, r"shakedown limit $\lambda_2$", curve.shakedown_limit, BLACK)
    slides = "bodies slide off, from no slip" if curve.self_stress else "bodies slide off"
    limit_line(axes, slides, curve.gross_slip, SERIES[1]["color"])


def _label_load_factors(axes: Axes) -> None:
    axes.set_xlabel(r"load factor $\lambda$")
    low, high = axes.get_xlim()
    if high < 30 * low:  # plain numbers instead of powers of ten
        axes.xaxis.set(
            major_locator=LogLocator(subs=(1, 2, 3, 5, 7)),
            major_formatter=ScalarFormatter(),
            minor_formatter=NullFormatter(),
        )


@picture.register
def _wear(history: WearHistory, ax: AxesArray | None = None) -> AxesArray:
    """Depth worn off and pressure along the contact after some cycles, and the work over cycles.

    In space a map of the depth in the end, and the work.
    """
    table, system = history.to_frame(), history.system
    if system.tangents == 2:
        *maps, work = panels = panels_of(ax, system, more=1)
        maps[0].set_title(f"depth worn off after {table['cycles'].iloc[-1]:.4g} cycles")
        face_map(maps, system, history.depth[-1], _DEPTH)
    else:
        depth, pressure, work = panels = new_axes(ax, 3, (6.4, 8.4), common_x=False)
        for number, row in enumerate(_rows_of_even_depth(history)):
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


def _rows_of_even_depth(history: WearHistory) -> list[int]:
    """At most six rows of a history, between which the largest depth grows about evenly."""
    largest = history.depth.max(axis=1)
    even = np.linspace(0.0, largest[-1], 6)[:-1]
    rows = {int(np.abs(largest - depth).argmin()) for depth in even}
    return sorted({*rows, len(largest) - 1})


@picture.register
def _worn_in(end: WornIn, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Depth worn off, and the nodes that never slip; in space a map of the depth."""
    system = end.system
    axes, *_ = panels = panels_of(ax, system)
    axes.set_title(f"worn in: {int(end.stick.sum())} of {system.nodes} nodes never slip")
    if system.tangents == 2:
        return face_map(panels, system, end.depth, _DEPTH)
    lines(axes, system, end.depth, color=BLACK, label="depth worn off")
    stick = np.where(end.stick, 0.0, np.nan)
    lines(axes, system, stick, color=series(0)["color"], lw=3.0, label="never slips")
    axes.set_ylabel(_DEPTH)
    label_contacts(axes, system)
    legend(axes)
    return axes
