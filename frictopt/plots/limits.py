"""Pictures of onset, limits, designs and safe regions: how far each node is from slip, and which nodes limit the load."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from ..contact import RESIDUAL, Array, lengths, most_shear
from ..limits import Design, GuaranteedLimit, LeastSlip, RequiredFriction, SafeRegion, SafeSlip, ShakedownLimit
from ..transients import Onset
from .face import face_map, panels_of, together
from .strip import circle, friction_bounds, label_contacts, label_panels, lines, lines_or_band, node_at, open_marks, ratios
from .style import BLACK, POINTS, SERIES, AxesArray, Look, equals, legend, line, new_axes, no_lines, picture

Circles: TypeAlias = dict[int, tuple[Any, Any, Any]]  # by corner: nodes that limit the load, their senses of slip, areas of their circles
Limit: TypeAlias = ShakedownLimit | RequiredFriction | GuaranteedLimit

_AREA = 400  # of the circle round a node that is the whole mechanism, points^2
_ONE_NODE = 60  # of the circle round a node that stands alone
_INSIDE: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0, "label": "some residual slip is safe"}


def _ratios(
    panels: Sequence[Axes],
    found: Onset | Limit | SafeSlip | Design,
    q: Array,
    p: Array,
    names: Sequence[str],
    circles: Circles,
    what: str = "",
    at: int = 0,
) -> Axes | AxesArray:
    """Shear over friction bound of reactions at K corners, with circles at some of them; of many corners, those with the largest circles.

    Where the bound is zero up to rounding, no ratio is drawn. In space maps of the corner `at`, with the circles of all, and the slip as arrows.
    """
    system = found.system
    bound, of = most_shear(system, found.friction, p), r"\min(f p, c)" if system.capped else "(f p)"
    slip, opened = (None, None) if isinstance(found, Onset) else (found.slip / system.stretch, found.open)
    if system.tangents == 2:
        ratio = ratios(lengths(q[at], p[at]), bound[at])
        largest = float(np.nanmax(ratio, initial=0.0))
        most, name = largest if largest > 1.0 + RESIDUAL else 1.0, rf"$|q| / {of}$ at {names[at]}"
        areas = np.zeros(system.nodes)
        for nodes, _, area in circles.values():
            np.add.at(areas, np.ravel(nodes), area)
        circled = (areas, what) if circles else None
        return face_map(panels, system, ratio, name, most=most, slip=slip, slip_name="residual slip", opened=opened, circled=circled)
    (axes,), ratio, label = panels, ratios(q, bound), what or None
    friction_bounds(axes, of)
    ruling = sorted(circles, key=lambda corner: -float(np.sum(circles[corner][2]))) or [at]
    for corner, look in lines_or_band(axes, system, ratio, names, ruling).items():
        if corner in circles:
            nodes, senses, areas = circles[corner]
            circle(axes, system.x[nodes], ratio[corner, nodes], senses, areas, look["color"], label)
            label = None
    most = np.clip(1.1 * float(np.nanmax(np.abs(ratio), initial=0.0)), 1.25, 3.0)  # beyond, nodes with almost no pressure would hide all others
    axes.set_ylim(-most, most)
    label_contacts(axes, system)
    if opened is not None:
        open_marks(axes, system.x[opened], "open", color=BLACK)
    legend(axes)
    return axes


@picture.register
def _onset(onset: Onset, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound of the bonded contact at the first slip towards each corner (in space, the first of all); what slips is circled."""
    axes, *_ = panels = panels_of(ax, onset.system)
    title = "bonded contact at the onset of slip"
    if not onset.mean_admissible:
        settled, alone = "contact under the settled mean load, at the onset of slip", "bonded contact; the mean load alone makes it slip or pulls"
        title = settled if onset.state else alone
    axes.set_title(title)
    events = [event for event in onset.slips if event.node is not None]
    if not events:
        no_lines(panels, "no corner makes a node slip")
        return together(panels)
    at, (q, p) = events.index(onset.slip), (part[[event.corner for event in events]] for part in onset.reactions)
    shown = range(len(events)) if len(events) <= len(SERIES) else [at]
    circles: Circles = {number: (events[number].node, events[number].sense, _ONE_NODE) for number in shown}
    if onset.system.tangents == 2:
        shear, bound = lengths(q, p)[at], most_shear(onset.system, onset.friction, p[at])
        zero = RESIDUAL * np.abs(bound).max()
        slips = (shear - bound >= -zero) & (np.maximum(shear, -bound) > zero)  # a node that carries nothing does not slip
        circles = {at: ([onset.slip.node, *np.flatnonzero(slips)], None, _ONE_NODE)}
    names = [rf"{event.loads}, $\lambda = {event.load_factor:.4g}$" for event in events]
    return _ratios(panels, onset, q, p, names, circles, "node that slips first", at)


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism.

    Open nodes, which carry nothing, are marked at zero. In space, at the first corner, with the slip as arrows. Of nodes that open and close in each
    cycle also where the load is when they do.
    """
    name = r"shakedown limit $\lambda_2$" if limit.objective is None else r"load factor $\lambda$ that the objective chooses"
    axes, share = _at_corners(limit, ax, equals(name, limit.load_factor)), limit.open_share
    partly = (share > 0) & (share < 1)
    if partly.any() and isinstance(axes, Axes) and limit.system.tangents == 1:
        open_marks(axes, limit.system.x[partly], "open in part of the cycle", facecolors="none", edgecolors=BLACK)
        legend(axes)
    return axes


@picture.register
def _required_friction(required: RequiredFriction, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over the required friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism."""
    return _at_corners(required, ax, equals(rf"$\lambda = {required.load_factor:.4g}$: required friction $f$", required.required))


@picture.register
def _guaranteed_limit(limit: GuaranteedLimit, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the witness, in space at the first one; the critical node is circled."""
    title = equals(r"guaranteed limit $\lambda_1$", limit.load_factor) + ", " + equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    if limit.node is not None and limit.corners is not None:
        names, node = [limit.cycle.corner_names[corner] for corner in limit.corners], node_at(limit.system, limit.node)
        on_both = f"on the bound of forward slip at {names[0]}\nand of backward slip at {names[-1]}"
        title += f"\n{node}: " + (on_both if limit.system.tangents == 1 else "on its bound at\n" + "; ".join(names))
    return _at_corners(limit, ax, title)


def _at_corners(limit: Limit, ax: Axes | AxesArray | None, title: str) -> Axes | AxesArray:
    """Shear over friction bound at the corners, with circles at the nodes that limit the load; or why there is nothing to show."""
    panels, circles, what = panels_of(ax, limit.system), {}, ""
    panels[0].set_title(title)
    if isinstance(limit, ShakedownLimit | RequiredFriction):
        rows, what = limit.mechanism.groupby("corner"), "limiting node; area: share"
        circles = {corner: (row["node"], row.get("direction"), _AREA * row["share"]) for corner, row in rows}
    elif limit.corners is not None:
        circles, what = {corner: (limit.node, sense, _ONE_NODE) for corner, sense in zip(limit.corners, (1, -1), strict=False)}, "critical node"
    names, q, p = limit._instants
    if not np.isfinite(p).all() or not (limit.friction.any() or circles):  # without friction, and nothing that limits
        no_lines(panels, limit.reason)
        return together(panels)
    return _ratios(panels, limit, q, p, names, circles, what)


@picture.register
def _safe_slip(safe: SafeSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    return _reserve(safe, ax, rf"{title} at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}", safe.slip, "slip $v$ (length)")


@picture.register
def _design(design: Design, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; below, the profile where the faces were free."""
    amounts = [f"{name} {amount:+.4g}" for name, amount in design.preload.items()]
    title = ", ".join([equals(r"best design, $\lambda$", design.load_factor), *amounts[:4], *["..."] * (len(amounts) > 4)])
    return _reserve(design, ax, title, design.profile, "material taken off (length)")


def _reserve(found: SafeSlip | Design, ax: Axes | AxesArray | None, title: str, profile: Array | None, name: str) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip (of many corners, the one with the least reserve); below, a profile, if there is one.

    In space, at the corner with the least reserve, with the slip as arrows.
    """
    system, (q, p), names = found.system, found.reactions, found.cycle.corner_names
    least = int(np.argmin((found.friction * p - lengths(q, p))[:, ~found.open].min(axis=1)))
    alone = profile is None or system.tangents == 2
    upper, *below = panels = panels_of(ax, system) if alone else new_axes(ax, 2, (6.4, 5.4))
    upper.set_title(title)
    drawn = _ratios(panels if alone else [upper], found, q, p, names, {}, at=least)
    if profile is None or alone:
        return drawn
    upper.set_xlabel("")
    lines(below[0], system, profile, color=BLACK, **POINTS)
    below[0].set_ylabel(name)
    label_panels(below, system)
    return np.array([upper, *below])


@picture.register
def _least_slip(least: LeastSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Weights of the slip at the corners (of many corners, lines of those with the largest); in space maps of those between corners."""
    panels, claim = panels_of(ax, least.system), "no slip is proven"
    axes = panels[0]
    if least.bound > 0:
        total = f"slip between corners at least {least.total:.4g} in all while all nodes are closed"
        claim = f"weighted sum of the slips at least {least.bound:.4g};\n{total if np.isfinite(least.total) else 'no cycle keeps all nodes closed'}"
    axes.set_title(rf"$\lambda = {least.load_factor:.4g}$: {claim}")
    if least.system.tangents == 2:
        return face_map(panels, least.system, least.weight, "weight of the slip between corners (1 / length)")
    lines_or_band(axes, least.system, least.g, least.cycle.corner_names, np.argsort(-np.abs(least.g).sum(axis=1), kind="stable").tolist())
    axes.set_ylabel("weight $g$ of the slip (1 / length)")
    label_panels([axes], least.system)
    legend(axes)
    return axes


@picture.register
def _safe_region(region: SafeRegion, ax: Axes | None = None) -> Axes:
    """The region, with the node that slips or opens most beyond each side (of many sides, one look for all)."""
    (axes,) = new_axes(ax)
    axes.set_title("amplitudes of two loads that vary independently")
    if not len(region.sides):
        no_lines([axes], region.reason)
        return axes
    free, inner, outer = np.isinf(region.vertices[0]), region.vertices, region.outer
    if free.any():  # a strip, which goes on beyond the picture
        inner = outer = np.where(free, [[0.0], [1.0]], region.vertices.min())
    axes.fill(*np.vstack([[0.0, 0.0], inner, free]).T, **_INSIDE)
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(outer)):
        look = line(number) if few else {"color": BLACK}
        all_sides = f"{len(region.sides)} sides, each a mechanism" if number == 0 else None
        axes.plot(*np.transpose(ends), **look, label=_limiting(region, number) if few else all_sides)
    if not free.any():
        axes.plot(*inner.T, linestyle="none", marker="o", markersize=3, color=BLACK, clip_on=False, label="vertex, proven safe")
    for name, load, unlimited, most in zip("xy", region.loads, free, outer.max(axis=0), strict=True):
        label = f"amplitude of {load}" + (": no limit" if unlimited else " (times its unit load)")
        ends = (0.0, 1.0) if unlimited else (0.0, 1.08 * most or 1.0)
        axes.set(**{f"{name}label": label, f"{name}lim": ends} | ({f"{name}ticks": []} if unlimited else {}))
    legend(axes)
    return axes


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {'slips' if slips else 'opens'} most"
