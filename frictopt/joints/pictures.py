"""Pictures of joints: the backbone curve, wear, and the worn-in contact."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

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


@picture.register
def _backbone_curve(curve: BackboneCurve, ax: AxesArray | None = None) -> AxesArray:
    """Over the load factor (log), up to the sliding-off load: work, slipping share of each contact, and stiffness and damping where they are known.

    Of a mode the frequency stands for the stiffness. Bands are ranges over the residual slips,
    lines the limits.
    """
    known, look = (
        bool(np.isfinite(curve.stiffness).any()),
        {name: series(0)[name] for name in ("color", "marker")},
    )
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
    ranges = (
        (curve.least_frequency, curve.most_frequency),
        (curve.least_damping, curve.most_damping),
    )
    for axes, name, (least, most) in zip(
        more, ("frequency" if mode else "stiffness", "damping"), ranges, strict=False
    ):
        axes.plot(curve.load_factor, getattr(curve, name), **look, label="without residual slip")
        if not np.isnan(least).all():
            axes.fill_between(
                curve.load_factor,
                least,
                most,
                color=look["color"],
                alpha=0.2,
                lw=0,
                label="range over residual slips",
            )
    for axes in panels:
        axes.set_xscale("log")
        limit_line(axes, r"guaranteed limit $\lambda_1$", curve.guaranteed_limit, GREY)
        limit_line(axes, r"shakedown limit $\lambda_2$", curve.shakedown_limit, BLACK)
        limit_line(
            axes,
            "bodies slide off" + ", from no slip" * curve.self_stress,
            curve.gross_slip,
            SERIES[1]["color"],
        )
    if known:
        if mode:
            more[0].axhline(
                curve.natural_frequency, color=GREY, lw=0.6, zorder=0, label="glued contact"
            )
        more[0].set_ylabel(
            "frequency (cycles per time)" if mode else "stiffness\n(load factor over displacement)"
        )
        more[1].set_ylabel(r"damping ratio $\zeta$")
    legend(more[0] if known else work)
    last = panels[-1]
    last.set_xlabel(r"load factor $\lambda$")
    low, high = last.get_xlim()
    if high < 30 * low:  # plain numbers, not powers of ten
        last.xaxis.set(
            major_locator=LogLocator(subs=(1, 2, 3, 5, 7)),
            major_formatter=ScalarFormatter(),
            minor_formatter=NullFormatter(),
        )
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
        even = [
            np.abs(largest - part).argmin() for part in np.linspace(0.0, largest[-1], 6)[:-1]
        ]  # steps of the largest depth
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
    lines(
        axes,
        system,
        np.where(end.stick, 0.0, np.nan),
        color=series(0)["color"],
        lw=3.0,
        label="never slips",
    )
    axes.set_ylabel(_DEPTH)
    label_contacts(axes, system)
    legend(axes)
    return axes
