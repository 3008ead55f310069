"""Pictures of limits, designs and safe regions: distances from slip, and limiting nodes."""

from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from ..base import Array
from ..contact import lengths
from ..contact.face import face_map, panels_of, together
from ..contact.strip import (
    INSIDE,
    ONE_NODE,
    label_panels,
    lines,
    lines_or_band,
    node_at,
    open_marks,
    shear_ratios,
)
from ..plots.draw import draw as draw
from ..plots.style import (
    BLACK,
    POINTS,
    SERIES,
    AxesArray,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
)
from .design import Design
from .guaranteed import GuaranteedLimit
from .least_slip import LeastSlip
from .required_friction import RequiredFriction
from .safe_region import SafeRegion
from .safe_slip import SafeSlip
from .shakedown import ShakedownLimit

Limit: TypeAlias = ShakedownLimit | RequiredFriction | GuaranteedLimit


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip.

    The area of a circle is the share of its node in the mechanism. Open nodes, which carry nothing,
    are marked at zero. In space, at the first corner, with the slip as arrows. If nodes open and
    close in each cycle, they are marked too.
    """
    name = r"shakedown limit $\lambda_2$"
    if limit.objective is not None:
        name = r"load factor $\lambda$ that the objective chooses"
    axes = _at_corners(limit, ax, equals(name, limit.load_factor))
    share = limit.open_share
    partly = (share > 0) & (share < 1)
    if partly.any() and isinstance(axes, Axes) and limit.system.tangents == 1:
        open_marks(
            axes,
            limit.system.x[partly],
            "open in part of the cycle",
            facecolors="none",
            edgecolors=BLACK,
        )
        legend(axes)
    return axes


@picture.register
def _required_friction(
    required: RequiredFriction, ax: Axes | AxesArray | None = None
) -> Axes | AxesArray:
    """Shear over the required friction bound at the corners under the safe slip.

    The area of a circle is the share of its node in the mechanism.
    """
    name = rf"$\lambda = {required.load_factor:.4g}$: required friction $f$"
    return _at_corners(required, ax, equals(name, required.required))


@picture.register
def _guaranteed_limit(
    limit: GuaranteedLimit, ax: Axes | AxesArray | None = None
) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the witness; the critical node is circled.

    In space, at the first corner.
    """
    lower = equals(r"guaranteed limit $\lambda_1$", limit.load_factor)
    upper = equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    title = f"{lower}, {upper}"
    if limit.node is not None and limit.corners is not None:
        names = [as_is(limit.cycle.corner_names[corner]) for corner in limit.corners]
        bounds = "on its bound at\n" + "; ".join(names)
        if limit.system.tangents == 1:
            bounds = f"on the bound of forward slip at {names[0]}\n"
            bounds += f"and of backward slip at {names[-1]}"
        title += f"\n{node_at(limit.system, limit.node)}: {bounds}"
    return _at_corners(limit, ax, title)


def _at_corners(limit: Limit, ax: Axes | AxesArray | None, title: str) -> Axes | AxesArray:
    """Shear over friction bound at the corners, with circles at the nodes that limit the load.

    If there is nothing to show, the reason.
    """
    panels = panels_of(ax, limit.system)
    panels[0].set_title(title)
    circles: dict[Any, tuple[Any, Any, Any]] = {}
    what = ""
    if isinstance(limit, ShakedownLimit | RequiredFriction):
        what = "limiting node; area: share"
        # Area of the circle round a node that is the whole mechanism, points^2.
        area = 400
        for corner, rows in limit.mechanism.groupby("corner"):
            circles[corner] = (rows["node"], rows.get("direction"), area * rows["share"])
    elif limit.corners is not None:
        what = "critical node"
        for corner, sense in zip(limit.corners, (1, -1), strict=False):
            circles[corner] = (limit.node, sense, ONE_NODE)
    names, q, p = limit._instants
    nothing_limits = not limit.friction.any() and not circles
    if nothing_limits or not np.isfinite(p).all():
        no_lines(panels, limit.reason)
        return together(panels)
    return shear_ratios(
        panels,
        limit.system,
        limit.friction,
        q,
        p,
        list(map(as_is, names)),
        circles,
        what,
        slip=limit.slip,
        opened=limit.open,
    )


@picture.register
def _safe_slip(safe: SafeSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    title += rf" at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}"
    return _reserve(safe, ax, title, safe.slip, "slip $v$ (length)")


@picture.register
def _design(design: Design, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; below, the free profile."""
    amounts = [f"{as_is(name)} {amount:+.4g}" for name, amount in design.preload.items()]
    parts = [equals(r"best design, $\lambda$", design.load_factor), *amounts[:4]]
    if len(amounts) > 4:
        parts.append("...")
    title = ", ".join(parts)
    return _reserve(design, ax, title, design.profile, "material taken off (length)")


def _reserve(
    found: SafeSlip | Design,
    ax: Axes | AxesArray | None,
    title: str,
    profile: Array | None,
    name: str,
) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip; below, a profile, if there is one.

    Of many corners, that with the least reserve. In space at this corner, with the slip as arrows.
    """
    system = found.system
    q, p = found.reactions
    least = int(np.argmin((found.friction * p - lengths(q, p))[:, ~found.open].min(axis=1)))
    alone = profile is None or system.tangents == 2
    panels = panels_of(ax, system) if alone else new_axes(ax, 2, (6.4, 5.4))
    upper, *below = panels
    upper.set_title(title)
    drawn = shear_ratios(
        panels if alone else [upper],
        system,
        found.friction,
        q,
        p,
        list(map(as_is, found.cycle.corner_names)),
        {},
        at=least,
        slip=found.slip,
        opened=found.open,
    )
    if profile is None or alone:
        return drawn
    upper.set_xlabel("")
    lines(below[0], system, profile, color=BLACK, **POINTS)
    below[0].set_ylabel(name)
    label_panels(below, system)
    return np.array([upper, *below])


@picture.register
def _least_slip(least: LeastSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Weights of the slip at the corners; in space, maps of the weights between corners.

    If there are many corners, lines are drawn only for the corners with the largest weights.
    """
    panels = panels_of(ax, least.system)
    axes = panels[0]
    claim = "no slip is proven"
    if least.bound > 0:
        total = "no cycle keeps all nodes closed"
        if np.isfinite(least.total):
            total = (
                f"slip between corners at least {least.total:.4g} in all while all nodes are closed"
            )
        claim = f"weighted sum of the slips at least {least.bound:.4g};\n{total}"
    axes.set_title(rf"$\lambda = {least.load_factor:.4g}$: {claim}")
    if least.system.tangents == 2:
        return face_map(
            panels, least.system, least.weight, "weight of the slip between corners (1 / length)"
        )
    largest_first = np.argsort(-np.abs(least.g).sum(axis=1), kind="stable").tolist()
    names = list(map(as_is, least.cycle.corner_names))
    lines_or_band(axes, least.system, least.g, names, largest_first)
    axes.set_ylabel("weight $g$ of the slip (1 / length)")
    label_panels([axes], least.system)
    legend(axes)
    return axes


@picture.register
def _safe_region(region: SafeRegion, ax: Axes | None = None) -> Axes:
    """The region, with the node that slips or opens most beyond each side.

    Many sides look alike.
    """
    (axes,) = new_axes(ax)
    axes.set_title("amplitudes of two loads that vary independently")
    if not len(region.sides):
        no_lines([axes], region.reason)
        return axes
    free = np.isinf(region.vertices[0])
    inner = region.vertices
    outer = region.outer
    if free.any():
        # A strip, which goes on beyond the picture.
        inner = outer = np.where(free, [[0.0], [1.0]], region.vertices.min())
    axes.fill(*np.vstack([[0.0, 0.0], inner, free]).T, **INSIDE)
    _draw_sides(axes, region, outer)
    if not free.any():
        axes.plot(
            *inner.T,
            linestyle="none",
            marker="o",
            markersize=3,
            color=BLACK,
            clip_on=False,
            label="vertex, proven safe",
        )
    for name, load, unlimited, largest in zip(
        "xy", region.loads, free, outer.max(axis=0), strict=True
    ):
        look: dict[str, Any] = {f"{name}lim": (0.0, 1.08 * largest or 1.0)}
        label = f"amplitude of {as_is(load)} (times its unit load)"
        if unlimited:
            look = {f"{name}lim": (0.0, 1.0), f"{name}ticks": []}
            label = f"amplitude of {as_is(load)}: no limit"
        axes.set(**{f"{name}label": label}, **look)
    legend(axes)
    return axes


def _draw_sides(axes: Axes, region: SafeRegion, outer: Array) -> None:
    """The sides; each has a name and a colour of its own, if they are few."""
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(outer)):
        label = None
        if few:
            label = _limiting(region, number)
        elif number == 0:
            label = f"{len(region.sides)} sides, each a mechanism"
        look = line(number) if few else {"color": BLACK}
        axes.plot(*np.transpose(ends), **look, label=label)


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    moves = "slips" if slips else "opens"
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {moves} most"
