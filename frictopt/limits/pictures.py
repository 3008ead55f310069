"""Pictures of limits, designs and safe regions: how close nodes are to slip, and which govern."""

from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ..contact import lengths
from ..contact.pictures import ONE_NODE, Circles, panels_of, shear_ratios
from ..plots.along import along
from ..plots.style import (
    FILL,
    SERIES,
    AnyAxes,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
    together,
)
from .best_design.design import Design
from .fatigue_band import FatigueBand
from .fatigue_limit import FatigueLimit
from .guaranteed import GuaranteedLimit
from .required_friction import RequiredFriction
from .safe_region import SafeRegion
from .safe_slip import SafeSlip
from .shakedown import ShakedownLimit

Answer: TypeAlias = (
    ShakedownLimit | RequiredFriction | GuaranteedLimit | SafeSlip | FatigueLimit | Design
)

# The main number of each kind of answer, and its name in the title of the picture.
_NUMBERS = {
    ShakedownLimit: ("load_factor", r"shakedown limit $\lambda_2$"),
    RequiredFriction: ("required", "required friction $f$"),
    GuaranteedLimit: ("load_factor", r"guaranteed limit $\lambda_1$"),
    SafeSlip: ("margin", "margin of the slip"),
    FatigueLimit: ("load_factor", r"fatigue limit $\lambda$"),
    Design: ("load_factor", r"best design, $\lambda$"),
}


@picture.register
def _answered(answer: Answer, ax: AnyAxes) -> AnyAxes:
    """Shear divided by the friction bound at the corners, with circles at limiting nodes.

    The area of a circle shows the share of its node in the mechanism. In space the picture shows
    one corner, with the slip as arrows: the first corner with limiting nodes or, if there are none,
    the corner with the least reserve. If there is nothing to show, the picture has the reason.
    Below the picture of a design is its profile.
    """
    system = answer.system
    profile = answer.profile if isinstance(answer, Design) and system.tangents == 1 else None
    panels = panels_of(ax, system) if profile is None else new_axes(ax, 2, (6.4, 5.4))
    upper, *below = panels
    upper.set_title(_title(answer))
    circles, what = _limiting_nodes(answer)
    names, q, p = answer._instants
    nothing_limits = not answer.friction.any() and not circles
    if nothing_limits or not np.isfinite(p).all():
        no_lines(panels, answer.reason)
        return together(panels)
    reserve = (answer.friction * p - lengths(q, p))[:, ~answer.open].min(axis=1)
    at = 0 if circles else int(np.argmin(reserve))
    shown = panels if profile is None else [upper]
    corners = list(map(as_is, names))
    drawn = shear_ratios(
        shown, answer, q, p, corners, circles, what, at, slip=answer.slip, opened=answer.open
    )
    if profile is None:
        return drawn
    upper.set_xlabel("")
    along(below, system, [("material taken off (length)", {"": profile})])
    return together(panels)


def _title(answer: Answer) -> str:
    """The main number of an answer, and the amounts of a design."""
    number, name = _NUMBERS[type(answer)]
    if isinstance(answer, ShakedownLimit) and answer.objective is not None:
        name = r"load factor $\lambda$ that the objective chooses"
    elif isinstance(answer, ShakedownLimit) and answer.gap is not None:
        name = r"lower bound of $\lambda_2$"
    parts = [equals(name, getattr(answer, number))]
    if isinstance(answer, RequiredFriction | SafeSlip):
        parts.append(rf"$\lambda = {answer.load_factor:.4g}$")
    if isinstance(answer, GuaranteedLimit):
        upper = answer.shakedown.load_factor
        parts.append(equals(_NUMBERS[ShakedownLimit][1], upper))
    if isinstance(answer, Design):
        amounts = [f"{as_is(name)} {amount:+.4g}" for name, amount in answer.preload.items()]
        # More amounts would not fit on the line.
        parts += amounts[:4] + ["..."] * (len(amounts) > 4)
    return ", ".join(parts)


def _limiting_nodes(answer: Answer) -> tuple[Circles, str]:
    """Circles at the nodes that limit the load, by corner, and their name."""
    circles: Circles = {}
    if isinstance(answer, ShakedownLimit | RequiredFriction):
        # Area of the circle round a node that is the whole mechanism, points^2.
        area = 400
        for corner, rows in answer.mechanism.groupby("corner"):
            circles[corner] = (rows["node"], rows.get("direction"), area * rows["share"])
        return circles, "limiting node; area: share"
    if isinstance(answer, GuaranteedLimit) and answer.corners is not None:
        for corner, sense in zip(answer.corners, (1, -1), strict=False):
            circles[corner] = (answer.node, sense, ONE_NODE)
    return circles, "critical node"


@picture.register
def _fatigue_band(band: FatigueBand, ax: AnyAxes) -> AnyAxes:
    """The parameter at each point: its band, its value in the best state, and without slip.

    The best state of rest has the smallest maximum over the points. In the plane the values are
    drawn along x, in space by the number of the point.
    """
    (axes,) = new_axes(ax)
    table = band.to_frame()
    if np.isfinite(band.least):
        table["least largest value"] = band.at(band.least_slip)
    place = "x" if band.system.tangents == 1 else "point"
    table = table.sort_values(place).replace(np.inf, np.nan)
    axes.fill_between(place, "least", "most", data=table, label="all states of rest", **FILL)
    for number, name in enumerate(("least largest value", "no_slip")):
        if name in table and table[name].notna().all():
            axes.plot(table[place], table[name], label=name.replace("_", " "), **line(number))
    axes.set_title(rf"$\lambda = {band.load_factor:.4g}$: fatigue band")
    axes.set(xlabel=place, ylabel=band.parameter.replace("_", " "))
    legend(axes)
    return axes


@picture.register
def _safe_region(region: SafeRegion, ax: AnyAxes) -> AnyAxes:
    """The region, with the node that moves most in the mechanism of each side.

    If there are many sides, their nodes are not named.
    """
    (axes,) = new_axes(ax)
    axes.set_title("amplitudes of two loads that vary independently")
    sides = len(region.sides)
    if not sides:
        no_lines([axes], region.reason)
        return axes
    free = np.isinf(region.vertices[0])
    inner, outer = region.vertices, region.outer
    if free.any():
        # A strip, which goes on beyond the picture.
        inner = outer = np.where(free, [[0.0], [1.0]], region.vertices.min())
    corners = np.vstack([[0.0, 0.0], inner, free])
    axes.fill(*corners.T, label="some residual slip is safe, proven at the vertices", **FILL)
    for number, ends in enumerate(pairwise(outer)):
        node = int(region.mechanisms[number]["node"].iloc[0])
        label = f"side {number}: node {node} moves most" if sides <= len(SERIES) else None
        axes.plot(*np.transpose(ends), label=label, **line(number, sides))
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    for axis, load, unlimited in zip((axes.xaxis, axes.yaxis), region.loads, free, strict=True):
        axis.set_label_text(f"amplitude of {as_is(load)} (times its unit load)")
        if unlimited:
            axis.set_label_text(f"amplitude of {as_is(load)}: no limit")
            axis.set_ticks([])
    legend(axes)
    return axes
