"""Pictures of onset, limits, designs and safe regions: how far each node is from slip, and which nodes limit the load."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from ..contact import RESIDUAL, Array, Booleans, ContactSystem, lengths
from ..limits import Design, GuaranteedLimit, LeastSlip, RequiredFriction, SafeRegion, SafeSlip, ShakedownLimit
from ..transients import Onset
from .nodes import circle, face_map, friction_ratio, label_panels, lines, lines_or_band, looks, node_at, ratio_map, ratios
from .style import BLACK, SERIES, AxesArray, Look, equals, legend, line, new_axes, no_lines, one_axes, picture, series

Circles: TypeAlias = dict[int, tuple[Any, Any, Any]]
Circled: TypeAlias = tuple[Circles, str]  # and what is circled
State: TypeAlias = tuple[Array | None, Booleans | None]  # slip, and which nodes are open
_ABSENT: State = None, None
Limit: TypeAlias = ShakedownLimit | RequiredFriction | GuaranteedLimit

_SHOWN = 4  # preloads in a title
_AREA = 400  # of the circle round a node that is the whole mechanism, points^2
_ONE_NODE = 60  # of the circle round a node that stands alone
_INSIDE: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0, "label": "some residual slip is safe"}
_MARGIN = 1.08  # of the axes, over the largest amplitude


@picture.register
def _onset(onset: Onset, ax: Axes | None = None) -> Axes:
    """Shear over friction bound of the bonded contact at the first slip towards each corner (in space, the first of all); what slips is circled."""
    axes = one_axes(ax, onset.system.tangents)
    settled = (
        "contact under the settled mean load, at the onset of slip" if onset.state else "bonded contact; the mean load alone makes it slip or pulls"
    )
    axes.set_title("bonded contact at the onset of slip" if onset.mean_admissible else settled)
    events = [event for event in onset.slips if event.node is not None]
    if not events:
        return no_lines(axes, "no corner makes a node slip")
    system, at, (q, p) = onset.system, events.index(onset.slip), (part[[event.corner for event in events]] for part in onset.reactions)
    shown = range(len(events)) if len(events) <= len(SERIES) else [at]
    circles: Circles = {number: (events[number].node, events[number].sense, _ONE_NODE) for number in shown}
    if system.tangents == 2:
        shear, bound = lengths(q, p)[at], onset.friction * p[at]
        zero = RESIDUAL * np.abs(bound).max()
        slips = (shear - bound >= -zero) & (np.maximum(shear, -bound) > zero)  # a node that carries nothing does not slip
        circles = {at: ([onset.slip.node, *np.flatnonzero(slips)], None, _ONE_NODE)}
    names = [rf"{event.loads}, $\lambda = {event.load_factor:.4g}$" for event in events]
    return _ratios(axes, system, onset.friction, q, p, names, (circles, "node that slips first"), at)


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: Axes | None = None) -> Axes:
    """Shear over friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism.

    Open nodes, which carry nothing, are marked at zero. In space, at the first corner, with the slip as arrows. Of nodes that open and close in each
    cycle also where the load is when they do.
    """
    name = r"shakedown limit $\lambda_2$" if limit.objective is None else r"load factor $\lambda$ that the objective chooses"
    axes, share = _at_corners(limit, ax, equals(name, limit.load_factor)), limit.open_share
    partly = (share > 0) & (share < 1)
    if partly.any() and limit.system.tangents == 1:
        x, label = limit.system.x[partly], "open in part of the cycle"
        axes.scatter(x, np.zeros(len(x)), marker="v", s=20, facecolors="none", edgecolors=BLACK, zorder=3, label=label)
        legend(axes)
    return axes


@picture.register
def _required_friction(required: RequiredFriction, ax: Axes | None = None) -> Axes:
    """Shear over the required friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism."""
    title = equals(rf"$\lambda = {required.load_factor:.4g}$: required friction $f$", required.required)
    return _at_corners(required, ax, title)


@picture.register
def _guaranteed_limit(limit: GuaranteedLimit, ax: Axes | None = None) -> Axes:
    """Shear over friction bound at the corners under the witness, in space at the first one; the critical node is circled."""
    title = equals(r"guaranteed limit $\lambda_1$", limit.load_factor) + ", " + equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    if limit.node is not None and limit.corners is not None:
        title += f"\n{_on_its_bounds(limit.node, limit, limit.corners)}"
    return _at_corners(limit, ax, title)


@picture.register
def _least_slip(least: LeastSlip, ax: Axes | None = None) -> Axes:
    """Weights of the slip at the corners (of many corners, lines of those with the largest); in space a map of those between corners."""
    axes = one_axes(ax, least.system.tangents)
    claim = "no slip is proven"
    if least.bound > 0:
        total = f"slip between corners at least {least.total:.4g} in all while all nodes are closed"
        claim = f"weighted sum of the slips at least {least.bound:.4g};\n{total if np.isfinite(least.total) else 'no cycle keeps all nodes closed'}"
    axes.set_title(rf"$\lambda = {least.load_factor:.4g}$: {claim}")
    if least.system.tangents == 2:
        return face_map(axes, least.system, least.weight, "weight of the slip between corners (1 / length)")
    lines_or_band(axes, least.system, least.g, least.cycle.corner_names, np.argsort(-np.abs(least.g).sum(axis=1), kind="stable").tolist())
    axes.set_ylabel("weight $g$ of the slip (1 / length)")
    label_panels([axes], least.system)
    legend(axes)
    return axes


@picture.register
def _safe_slip(safe: SafeSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    return _reserve(safe, ax, rf"{title} at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}", safe.slip, "slip $v$ (length)")


@picture.register
def _design(design: Design, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; below, the profile where the faces were free."""
    amounts = [f"{name} {amount:+.4g}" for name, amount in design.preload.items()]
    title = equals(r"best design, $\lambda$", design.load_factor) + "".join(f", {amount}" for amount in amounts[:_SHOWN])
    return _reserve(design, ax, title + ", ..." * (len(amounts) > _SHOWN), design.profile, "material taken off (length)")


def _reserve(found: SafeSlip | Design, ax: Axes | AxesArray | None, title: str, profile: Array | None, name: str) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip (of many corners, the one with the least reserve); below, a profile, if there is one.

    In space, at the corner with the least reserve, with the slip as arrows.
    """
    system, (q, p), names = found.system, found.reactions, found.cycle.corner_names
    least = int(np.argmin((found.friction * p - lengths(q, p))[:, ~found.open].min(axis=1)))
    alone = profile is None or system.tangents == 2
    upper, *below = [one_axes(ax, system.tangents)] if alone else new_axes(ax, 2, (6.4, 5.4))
    upper.set_title(title)
    _ratios(upper, system, found.friction, q, p, names, ({}, ""), least, (found.slip, found.open))
    if profile is None or alone:
        return upper
    upper.set_xlabel("")
    lines(below[0], system, profile, color=BLACK, marker=".", markersize=3)
    below[0].set_ylabel(name)
    label_panels(below, system)
    return np.array([upper, *below])


def _on_its_bounds(node: int, limit: GuaranteedLimit, corners: Sequence[int]) -> str:
    """Where the critical node is, and the loads at which it is on its bounds."""
    names, name = [limit.cycle.corner_names[corner] for corner in corners], node_at(limit.system, node)
    if limit.system.tangents == 2:
        return f"{name}: on its bound at\n" + "; ".join(names)
    return f"{name}: on the bound of forward slip at {names[0]}\nand of backward slip at {names[1]}"


def _at_corners(limit: Limit, ax: Axes | None, title: str) -> Axes:
    """Shear over friction bound at the corners, with circles at the nodes that limit the load; or why there is nothing to show."""
    axes = one_axes(ax, limit.system.tangents)
    axes.set_title(title)
    (names, q, p), circled = limit._instants, _circles(limit)
    if not np.isfinite(p).all() or not (limit.friction.any() or circled[0]):  # without friction, and nothing that limits
        return no_lines(axes, limit.reason)
    return _ratios(axes, limit.system, limit.friction, q, p, names, circled, 0, (limit.slip, limit.open))


def _circles(limit: Limit) -> Circled:
    """Nodes that limit the load, with their senses of slip and the areas of their circles, by corner; and what the circles are."""
    if isinstance(limit, ShakedownLimit | RequiredFriction):
        rows = limit.mechanism.groupby("corner")
        return {corner: (row["node"], row.get("direction"), _AREA * row["share"]) for corner, row in rows}, "limiting node; area: share"
    if limit.corners is None:
        return {}, ""
    both = zip(limit.corners, (1, -1), strict=False)
    return {corner: (limit.node, sense, _ONE_NODE) for corner, sense in both}, "critical node"


def _ratios(
    axes: Axes, system: ContactSystem, friction: Array, q: Array, p: Array, names: Sequence[str], circled: Circled, at: int, state: State = _ABSENT
) -> Axes:
    """Shear over friction bound of reactions at K corners, with circles at some of them; of many corners, those with the largest circles.

    In space a map of the corner `at`, with the circles of all, and with the slip as arrows.
    """
    (circles, label), (slip, opened) = circled, state
    if system.tangents == 2:
        nodes = sorted({int(node) for nodes, _, _ in circles.values() for node in np.ravel(nodes)})
        ratio = ratios(lengths(q[at], p[at]), friction * p[at])
        return ratio_map(axes, system, ratio, names[at], slip, opened, nodes, label.partition(";")[0])
    ruling = sorted(circles, key=lambda corner: -float(np.sum(circles[corner][2]))) or [at]
    ratio, said = friction_ratio(axes, system, friction, q, p, names, ruling), False
    for corner, look in looks(len(q), ruling).items():
        if corner in circles:
            nodes, senses, areas = circles[corner]
            circle(axes, system.x[nodes], ratio[corner, nodes], senses, areas, look["color"], None if said else label)
            said = True
    if opened is not None and opened.any():  # they carry nothing
        axes.scatter(system.x[opened], np.zeros(opened.sum()), marker="v", s=20, color=BLACK, zorder=3, label="open")
    legend(axes)
    return axes


@picture.register
def _safe_region(region: SafeRegion, ax: Axes | None = None) -> Axes:
    """The region, with the node that slips or opens most beyond each side (of many sides, one look for all)."""
    (axes,) = new_axes(ax)
    axes.set_title("amplitudes of two loads that vary independently")
    if not len(region.sides):
        return no_lines(axes, region.reason)
    names = [f"amplitude of {name}" + (": no limit" if name in region.unlimited else " (times its unit load)") for name in region.loads]
    axes.set(xlabel=names[0], ylabel=names[1])
    if region.unlimited:
        _strip(axes, region)
    else:
        _polygon(axes, region)
    legend(axes)
    return axes


def _strip(axes: Axes, region: SafeRegion) -> None:
    """One of the loads has no limit."""
    upright = np.isinf(region.vertices[0, 1])
    span, line, free = (axes.axvspan, axes.axvline, "y") if upright else (axes.axhspan, axes.axhline, "x")
    most = float(region.vertices.min())
    span(0.0, most, **_INSIDE)
    line(most, color=series(0)["color"], label=_limiting(region, 0))
    axes.set(**{f"{free}ticks": [], f"{free}lim": (0.0, 1.0), f"{'x' if upright else 'y'}lim": (0.0, _MARGIN * most or 1.0)})


def _polygon(axes: Axes, region: SafeRegion) -> None:
    """Both loads have a limit."""
    axes.fill(*np.vstack([[0.0, 0.0], region.vertices]).T, **_INSIDE)
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(region.outer)):
        look = line(number) if few else {"color": BLACK}
        all_sides = f"{len(region.sides)} sides, each a mechanism" if number == 0 else None
        axes.plot(*np.transpose(ends), **look, label=_limiting(region, number) if few else all_sides)
    axes.plot(*region.vertices.T, linestyle="none", marker="o", markersize=3, color=BLACK, clip_on=False, label="vertex, proven safe")
    most = region.outer.max(axis=0)
    axes.set(xlim=(0.0, _MARGIN * most[0] or 1.0), ylim=(0.0, _MARGIN * most[1] or 1.0))


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {'slips' if slips else 'opens'} most"
