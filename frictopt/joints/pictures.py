"""Pictures of joints: the backbone curve, wear, and the worn-in contact."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from ..base import Array, finite_number
from ..contact.face import face_map, panels_of
from ..contact.strip import label_contacts, label_panels, lines, stiffness_unit, work_label
from ..errors import ModelError
from ..plots.draw import draw as draw
from ..plots.style import (
    BLACK,
    GREY,
    POINTS,
    SERIES,
    AxesArray,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    picture,
    series,
)
from .backbone import BackboneCurve
from .curve_load import load_size
from .forced_response import ForcedResponse
from .wear import WearHistory
from .worn_in import WornIn


@dataclass(frozen=True)
class CurveSettings:
    """The numbers of pictures of curves."""

    # Farthest limit that is drawn, over the largest value of a curve, or under the smallest. Limits
    # farther away are in the legend alone.
    farthest: float = 1.5
    # Room around the values and the limits that are drawn, as a factor.
    room: float = 1.12
    # Ratio of the largest to the smallest peak from which amplitudes have a logarithmic axis.
    logarithmic: float = 8.0


_CURVE = CurveSettings()

_DEPTH = "depth worn off (length)"
_MARKED = {name: series(0)[name] for name in ("color", "marker")}


@picture.register
def backbone(
    curve: BackboneCurve, ax: AxesArray | None = None, scale: float | None = None
) -> AxesArray:
    """Work, slipping share of each contact, stiffness and damping over the load factor (log).

    Stiffness and damping are drawn if they are known. For a mode, frequencies replace the
    stiffness. With a `scale` the horizontal axis is the amplitude at a point. Bars are errors of
    increments, bands are ranges over the residual slips, vertical lines are limits.
    """
    has_stiffness = bool(np.isfinite(curve.stiffness).any())
    drawn = _CurveAxis(curve, scale)
    if has_stiffness:
        panels = new_axes(ax, 4, (6.4, 9.0))
    else:
        panels = new_axes(ax, 2, (6.4, 5.4))
    _draw_work(panels[0], drawn)
    _draw_shares(panels[1], drawn)
    if has_stiffness:
        _, _, stiffness, damping = panels
        _draw_stiffness(stiffness, drawn)
        _draw_with_band(damping, drawn, curve.damping, curve.least_damping, curve.most_damping)
        damping.set_ylabel(r"damping ratio $\zeta$")
    for axes in panels:
        drawn.finish(axes)
    legend(panels[2] if has_stiffness else panels[0])
    _label_values(panels[-1], drawn.label)
    return np.array(panels)


class _CurveAxis:
    """The horizontal axis of a curve: its load factors, or amplitudes at a point.

    Attributes
    ----------
    x
        (K,) values of the axis.
    label
        Name of the axis.
    """

    def __init__(self, curve: BackboneCurve, scale: float | None) -> None:
        self.curve = curve
        self.x = curve.load_factor
        self.label = r"load factor $\lambda$"
        if scale is not None:
            if np.isnan(curve.displacement).all():
                raise ModelError(
                    f"scale: {scale:g}, and the load of this curve has no displacement; leave the "
                    "scale out"
                )
            self.x = finite_number("scale", scale, above=0.0) * curve.displacement
            self.label = "amplitude at the point (length)"

    def at(self, load_factors: Array) -> Array:
        """Values of the axis at load factors of the curve."""
        return np.asarray(self.x[np.searchsorted(self.curve.load_factor, load_factors)])

    def finish(self, axes: Axes) -> None:
        """Scale the axis to the curve, and draw the limits.

        A limit far from the curve would compress the curve, so only the legend names it.
        """
        known = self.x[np.isfinite(self.x)]
        low = known.min()
        high = known.max()
        drawn = [low, high]
        axes.set_xscale("log")
        curve = self.curve
        slides = (
            "bodies slide off, from no slip" if curve.self_stress else "bodies slide off or pry"
        )
        limits = {
            r"guaranteed limit $\lambda_1$": (curve.guaranteed_limit, GREY),
            r"shakedown limit $\lambda_2$": (curve.shakedown_limit, BLACK),
            slides: (curve.gross_slip, SERIES[1]["color"]),
        }
        for name, (limit, color) in limits.items():
            place = self._place_of(limit)
            label = equals(name, limit)
            if self.x is not curve.load_factor:
                label += " (load factor)"
            if low / _CURVE.farthest < place < high * _CURVE.farthest:
                drawn.append(place)
                axes.axvline(place, color=color, lw=0.8, ls="--", zorder=0, label=label)
            elif np.isfinite(limit) and limit > 0:
                axes.plot([], [], color="none", label=label)
        axes.set_xlim(min(drawn) / _CURVE.room, max(drawn) * _CURVE.room)

    def _place_of(self, limit: float) -> float:
        """Place of a load factor on the axis; NaN if the curve does not know its amplitude."""
        factors = self.curve.load_factor
        if self.x is factors:
            return limit
        known = np.isfinite(self.x)
        inside = np.interp(limit, factors[known], self.x[known], left=np.nan, right=np.nan)
        return float(inside)


def _draw_work(axes: Axes, drawn: _CurveAxis) -> None:
    curve = drawn.curve
    work = np.where(curve.work > 0, curve.work, np.nan)
    axes.plot(drawn.x, work, **_MARKED)
    at_rest = curve.work == 0
    if at_rest.any():
        # A logarithmic axis has no zero, so its lower end stands for it.
        axes.plot(
            drawn.x[at_rest],
            np.zeros(at_rest.sum()),
            transform=axes.get_xaxis_transform(),
            linestyle="none",
            mfc="white",
            clip_on=False,
            zorder=3,
            label="no work",
            **_MARKED,
        )
        legend(axes)
    error = np.where(np.isfinite(curve.step_error), curve.step_error, 0.0) * work
    if (error > 0).any():
        lower = np.minimum(error, 0.9 * work)  # a bar of a logarithm ends above 0
        axes.errorbar(
            drawn.x,
            work,
            yerr=[lower, error],
            fmt="none",
            ecolor=_MARKED["color"],
            elinewidth=0.8,
            capsize=2,
            label="error of increments, estimated",
        )
        legend(axes)
    axes.set(yscale="log", ylabel=work_label(curve.system))


def _draw_shares(axes: Axes, drawn: _CurveAxis) -> None:
    """The slipping share of each contact, and that of all if there are several."""
    curve = drawn.curve
    contacts = curve.by_contact.groupby("contact", sort=False)
    for number, (name, rows) in enumerate(contacts):
        x = drawn.at(rows["load_factor"].to_numpy())
        axes.plot(x, rows["slipping"], **line(number, len(contacts)), label=as_is(name))
    if len(contacts) > 1:
        axes.plot(drawn.x, curve.slipping, color=BLACK, label="all")
        legend(axes)
    axes.set(ylabel="share that slips", ylim=(-0.03, 1.03))


def _draw_stiffness(axes: Axes, drawn: _CurveAxis) -> None:
    """Frequencies of a mode, or the stiffness of another load."""
    curve = drawn.curve
    least, most = curve.least_frequency, curve.most_frequency
    if np.isnan(curve.natural_frequency):
        # Of a load whose size is known, the stiffness is that of its force over its mean motion.
        size = load_size(curve.system, curve.cycle)
        unit = stiffness_unit(curve.system.per_depth)
        if np.isnan(size):
            size = 1.0
            unit = "(load factor over displacement)"
        _draw_with_band(axes, drawn, curve.stiffness * size**2, least, most)
        axes.set_ylabel(f"stiffness\n{unit}")
        return
    _draw_with_band(axes, drawn, curve.frequency, least, most)
    axes.plot(drawn.x, curve.resonance, **line(1), label="resonance (first harmonic)")
    axes.axhline(curve.natural_frequency, color=GREY, lw=0.6, zorder=0, label="glued contact")
    axes.set_ylabel("frequency (cycles per time)")


def _draw_with_band(
    axes: Axes, drawn: _CurveAxis, values: Array, least: Array, most: Array
) -> None:
    """Values from no residual slip, and a band of their range if it is known."""
    axes.plot(drawn.x, values, **_MARKED, label="from a start without slip")
    if not np.isnan(least).all():
        axes.fill_between(
            drawn.x,
            least,
            most,
            color=_MARKED["color"],
            alpha=0.2,
            lw=0,
            label="range over residual slips",
        )


def _label_values(axes: Axes, label: str) -> None:
    """Name the horizontal axis; short logarithmic axes have plain numbers."""
    axes.set_xlabel(label)
    low, high = axes.get_xlim()
    if high < 30 * low:  # plain numbers instead of powers of ten
        axes.xaxis.set(
            major_locator=LogLocator(subs=(1, 2, 3, 5, 7)),
            major_formatter="{x:g}",
            minor_formatter=NullFormatter(),
        )


@picture.register
def _forced_response(answer: ForcedResponse, ax: Axes | None = None) -> Axes:
    """Amplitude over the frequency of each force, with the backbone through the peaks.

    Bars are the band of the peaks over the residual slips. The part between the folds is dotted;
    curves that end at the largest amplitude of the backbone go on beyond it.
    """
    (axes,) = new_axes(ax)
    oscillator = answer.oscillator
    backbone_frequency = np.sqrt(oscillator.stiffness) / (2 * np.pi)
    axes.plot(
        backbone_frequency,
        answer.scale * oscillator.amplitude,
        color=GREY,
        lw=1.2,
        zorder=0,
        label="backbone",
    )
    forces = list(zip(answer.force, answer.least_peak, answer.most_peak, strict=True))
    for number, (force, least, most) in enumerate(forces):
        color = series(number, len(forces))["color"]
        rows = answer.branches[answer.branches["force"] == force]
        _draw_branches(axes, rows, color, f"force {force:.4g}")
        ends = [least, min(most, answer.scale * oscillator.largest)]
        if np.isfinite(ends).all():
            middle = np.interp(ends, answer.scale * oscillator.amplitude, backbone_frequency)
            axes.plot(middle, ends, color=color, lw=4.0, alpha=0.35, solid_capstyle="butt")
    top = answer.branches.groupby("force")["amplitude"].max()
    drawn = answer.scale * oscillator.amplitude <= top.max()
    axes.set_xlim(*_around_resonance(answer, backbone_frequency[drawn]))
    if top.max() > _CURVE.logarithmic * top.min():
        axes.set(yscale="log", ylim=(top.min() / 10, 1.3 * top.max()))
    else:
        axes.set_ylim(0.0, 1.08 * top.max())
    axes.set(
        xlabel="frequency (cycles per time)",
        ylabel="modal amplitude" if answer.scale == 1.0 else "amplitude at the point (length)",
    )
    legend(axes)
    return axes


def _draw_branches(axes: Axes, rows: pd.DataFrame, color: str, name: str) -> None:
    """Stable parts of the curves of a force as lines, the parts between folds dotted."""
    between = rows["branch"] == "between"
    for detached in (False, True):
        part = rows["detached"] == detached
        for dotted in (False, True) if part.any() else ():
            amplitude = rows["amplitude"].where(between == dotted)[part]
            label = name if not (detached or dotted) else None
            style = ":" if dotted else "-"
            axes.plot(rows["frequency"][part], amplitude, style, color=color, label=label)


def _around_resonance(answer: ForcedResponse, backbone_frequency: Array) -> tuple[float, float]:
    """Range of frequencies around the backbone, and of the curves above a third of their peak."""
    tops = answer.branches.groupby("force")["amplitude"].transform("max")
    near = answer.branches[answer.branches["amplitude"] > tops / 3]["frequency"]
    low = min([near.min(), *backbone_frequency])
    high = max([near.max(), *backbone_frequency])
    room = max(0.15 * (high - low), 0.01 * high)
    return low - room, high + room


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
    # An axis that begins at the least work would make a constant work look like a change.
    highest = float(table["work"].max())
    room = {"ylim": (0.0, _CURVE.room * highest)} if highest > 0 else {}
    work.set(xlabel="load cycles", ylabel=work_label(system), **room)
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
