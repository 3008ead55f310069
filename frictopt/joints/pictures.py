"""Pictures of joints: the backbone curve, wear, and the worn-in contact."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from ..base import Array, finite_number
from ..contact.pictures import faces_of, panels_of, work_label
from ..errors import ModelError
from ..plots.along import along
from ..plots.face import face_map
from ..plots.style import (
    BLACK,
    FILL,
    GREY,
    SERIES,
    AnyAxes,
    Look,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    picture,
    series,
    together,
    unit,
)
from .archard import WearHistory
from .backbone import BackboneCurve
from .curve_question import load_size
from .end_of_wear import WornIn
from .forced_response import ForcedResponse
from .report import Comparison

# The numbers of pictures of curves.

# A limit is drawn if it lies beyond the values of a curve by at most this factor. Limits farther
# away are only in the legend.
_FARTHEST = 1.5
# Room around the values and the limits that are drawn, as a factor.
_ROOM = 1.12
# Amplitudes have a logarithmic axis if the largest peak is at least this many times the smallest.
_LOGARITHMIC = 8.0

_DEPTH = "depth worn off (length)"
_MARKED: Look = {name: series(0)[name] for name in ("color", "marker")}


@picture.register
def _comparison(of: Comparison, ax: AnyAxes) -> AnyAxes:
    """Each number of each variant, divided by the first variant's number, if all are finite."""
    numbers = of.table.set_index("number")[list(of.names)].astype(float)
    ratios = numbers.div(numbers[of.names[0]], axis=0)
    ratios = ratios[np.isfinite(ratios).all(axis=1)]
    (axes,) = new_axes(ax, size=(6.4, 1.2 + 0.3 * len(ratios)))
    for number, name in enumerate(of.names):
        look: Look = series(number, len(of.names)) | {"linestyle": "none"}
        axes.plot(ratios[name], ratios.index, label=as_is(name), **look)
    axes.invert_yaxis()
    axes.set_xlabel(f"divided by {as_is(of.names[0])}")
    legend(axes)
    return axes


@picture.register
def _backbone(curve: BackboneCurve, ax: AnyAxes, scale: float | None) -> AnyAxes:
    """Work, slipping share of each contact, stiffness and damping over the load factor (log).

    Stiffness and damping are drawn if they are known. For a mode, frequencies replace the
    stiffness. With a `scale` the horizontal axis is the amplitude at a point. The band of the work
    is the error of increments, other bands are ranges over the residual slips, and vertical lines
    are limits.
    """
    x, label = curve.load_factor, r"load factor $\lambda$"
    if scale is not None:
        if np.isnan(curve.displacement).all():
            raise ModelError(
                f"scale: {scale:g}, and the load of this curve has no displacement; leave the "
                "scale out"
            )
        x = finite_number("scale", scale, above=0.0) * curve.displacement
        label = "amplitude at the point (length)"
    has_stiffness = bool(np.isfinite(curve.stiffness).any())
    count = 4 if has_stiffness else 2
    panels = new_axes(ax, count, (6.4, 1.8 + 1.8 * count))
    work, share, *others = panels
    _draw_work(work, x, curve)
    contacts = curve.by_contact.groupby("contact", sort=False)
    for number, (name, rows) in enumerate(contacts):
        places = x[np.searchsorted(curve.load_factor, rows["load_factor"])]
        share.plot(places, rows["slipping"], label=as_is(name), **line(number, len(contacts)))
    if len(contacts) > 1:
        share.plot(x, curve.slipping, color=BLACK, label="all")
        legend(share)
    share.set(ylabel="share that slips", ylim=(-0.03, 1.03))
    if has_stiffness:
        stiffness, damping = others
        _draw_stiffness(stiffness, x, curve)
        _draw_with_band(damping, x, curve.damping, curve.least_damping, curve.most_damping)
        damping.set_ylabel(r"damping ratio $\zeta$")
    for axes in panels:
        _draw_limits(axes, x, curve)
    legend(work)
    panels[-1].set_xlabel(label)
    low, high = panels[-1].get_xlim()
    if high < 30 * low:  # plain numbers instead of powers of ten
        panels[-1].xaxis.set(
            major_locator=LogLocator(subs=(1, 2, 3, 5, 7)),
            major_formatter="{x:g}",
            minor_formatter=NullFormatter(),
        )
    return np.array(panels)


def _draw_limits(axes: AnyAxes, x: Array, curve: BackboneCurve) -> None:
    """Scale the horizontal axis to the values x (K,) of a curve, and draw the limits.

    A limit far from the curve would compress the curve, so only the legend names it.
    """
    known = np.isfinite(x)
    shown = [x[known].min(), x[known].max()]
    low, high = shown[0] / _FARTHEST, shown[1] * _FARTHEST
    limits = {
        r"guaranteed limit $\lambda_1$": (curve.guaranteed_limit, GREY),
        r"shakedown limit $\lambda_2$": (curve.shakedown_limit, BLACK),
        "bodies slide off, from no slip" if curve.self_stress else "bodies slide off or pry": (
            curve.gross_slip,
            SERIES[1]["color"],
        ),
    }
    for name, (limit, color) in limits.items():
        # The amplitude of the limit, NaN if the curve does not reach it.
        place = float(np.interp(limit, curve.load_factor[known], x[known], np.nan, np.nan))
        if x is curve.load_factor:
            place = limit
        else:
            name += ": load factor"
        if low < place < high:
            shown.append(place)
        if np.isfinite(limit) and limit > 0:
            axes.axvline(place, color=color, lw=0.8, ls="--", zorder=0, label=equals(name, limit))
    axes.set(xscale="log", xlim=(min(shown) / _ROOM, max(shown) * _ROOM))


def _draw_work(axes: AnyAxes, x: Array, curve: BackboneCurve) -> None:
    """The work, with a band of its error; load factors without work have marks at the lower end."""
    at_rest = curve.work == 0
    work = np.where(at_rest, np.nan, curve.work)
    error = np.minimum(np.where(np.isfinite(curve.step_error), curve.step_error, 0.0), 0.9)
    ends = work * (1 - error), work * (1 + error)
    _draw_with_band(axes, x, work, *ends, "error of increments, estimated")
    if at_rest.any():
        # A logarithmic axis has no zero, so its lower end stands for it.
        place = axes.get_xaxis_transform()
        look: Look = _MARKED | {"linestyle": "none", "mfc": "white", "clip_on": False, "zorder": 3}
        axes.plot(x[at_rest], np.zeros(at_rest.sum()), transform=place, label="no work", **look)
    axes.set(yscale="log", ylabel=work_label(curve.system))


def _draw_stiffness(axes: AnyAxes, x: Array, curve: BackboneCurve) -> None:
    """Frequencies of a mode, or the stiffness of another load."""
    ends = curve.least_frequency, curve.most_frequency
    if np.isnan(curve.natural_frequency):
        # If the size of the load is known, the stiffness is its force over its mean motion.
        size = load_size(curve.system, curve.cycle)
        name = unit("force per length", curve.system.per_depth)
        if np.isnan(size):
            size, name = 1.0, "(load factor over displacement)"
        _draw_with_band(axes, x, curve.stiffness * size**2, *ends)
        axes.set_ylabel(f"stiffness\n{name}")
        return
    _draw_with_band(axes, x, curve.frequency, *ends)
    axes.plot(x, curve.resonance, **line(1), label="resonance (first harmonic)")
    axes.axhline(curve.natural_frequency, color=GREY, lw=0.6, zorder=0, label="glued contact")
    axes.set_ylabel("frequency (cycles per time)")
    legend(axes)


def _draw_with_band(
    axes: AnyAxes,
    x: Array,
    values: Array,
    least: Array,
    most: Array,
    band: str = "range over residual slips",
) -> None:
    """Values from no residual slip, and a band of their range if it is known."""
    axes.plot(x, values, **_MARKED, label="from a start without slip")
    if (most > least).any():
        axes.fill_between(x, least, most, label=band, **FILL)
        legend(axes)


@picture.register
def _forced_response(answer: ForcedResponse, ax: AnyAxes) -> AnyAxes:
    """Amplitude over the frequency of each force, with the backbone through the peaks.

    A thick bar along the backbone is the range of a peak over the residual slips. The part between
    the folds is dotted. A curve that ends at the largest amplitude of the backbone continues beyond
    it.
    """
    (axes,) = new_axes(ax)
    oscillator = answer.oscillator
    amplitude = answer.scale * oscillator.amplitude
    frequency = np.sqrt(oscillator.stiffness) / (2 * np.pi)
    axes.plot(frequency, amplitude, color=GREY, lw=1.2, zorder=0, label="backbone")
    table = answer.branches
    for number, force in enumerate(answer.force):
        color = series(number, len(answer.force))["color"]
        axes.plot([], [], color=color, label=f"force {force:.4g}")
        rows = table[table["force"] == force]
        for (_, branch), part in rows.groupby(["detached", "branch"]):
            style = ":" if branch == "between" else "-"
            axes.plot(part["frequency"], part["amplitude"], style, color=color)
        largest = answer.scale * oscillator.largest
        ends = [answer.least_peak[number], min(answer.most_peak[number], largest)]
        if np.isfinite(ends).all():
            middle = np.interp(ends, amplitude, frequency)
            axes.plot(middle, ends, color=color, lw=4.0, alpha=0.35, solid_capstyle="butt")
    tops = table.groupby("force")["amplitude"].transform("max")
    least, most = tops.min(), tops.max()
    # Around the backbone, and around the curves above a third of their peaks.
    near = [*table["frequency"][table["amplitude"] > tops / 3], *frequency[amplitude <= most]]
    room = max(0.15 * np.ptp(near), 0.01 * max(near))
    axes.set_xlim(min(near) - room, max(near) + room)
    several = most > _LOGARITHMIC * least
    axes.set_yscale("log" if several else "linear")
    axes.set_ylim(least / 10 if several else 0.0, 1.3 * most)
    name = "modal amplitude" if answer.scale == 1.0 else "amplitude at the point (length)"
    axes.set(xlabel="frequency (cycles per time)", ylabel=name)
    legend(axes)
    return axes


@picture.register
def _worn(worn: WearHistory | WornIn, ax: AnyAxes) -> AnyAxes:
    """Depth worn off, with the pressure for a history, and the stick zone for a worn-in contact.

    In space, a map of the final depth.
    """
    system = worn.system
    label = "pressure at the last corner\n(force per area)"
    if isinstance(worn, WornIn):
        end, title = worn.depth, f"worn in: {worn.stick.sum()} of {system.nodes} nodes never slip"
        stick = np.where(worn.stick, 0.0, np.nan)
        rows = [(_DEPTH, {"depth worn off": end, "never slips": stick})]
    else:
        end, cycles = worn.depth[-1], worn.to_frame()["cycles"]
        title = f"worn off after {cycles.iloc[-1]:.4g} cycles"
        some = np.unique(np.linspace(0, len(cycles) - 1, 6).astype(int))
        named = {f"after {cycles[row]:.4g} cycles": row for row in some}
        depths = {name: worn.depth[row] for name, row in named.items()}
        rows = [(_DEPTH, depths), (label, {n: worn.pressure[row] for n, row in named.items()})]
    if system.tangents == 2:
        panels = panels_of(ax, system)
        panels[0].set_title(title)
        return face_map(panels, faces_of(system), end, _DEPTH)
    panels = new_axes(ax, len(rows), (6.4, 0.9 + 2.3 * len(rows)))
    panels[0].set_title(title)
    along(panels, system, rows)
    return together(panels)
