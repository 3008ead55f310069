"""Pictures of onset, limits, designs and safe regions: how far each node is from slip, and which nodes limit the load."""

from itertools import pairwise
from typing import TypeAlias

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

_AREA = 400  # of the circle round a node that is the whole mechanism, points^2


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism.

    Open nodes, which carry nothing, are marked at zero. In space, at the first corner, with the
    slip as arrows. Of nodes that open and close in each cycle also where the load is when they do.
    """
    name = (
        r"shakedown limit $\lambda_2$"
        if limit.objective is None
        else r"load factor $\lambda$ that the objective chooses"
    )
    axes, share = _at_corners(limit, ax, equals(name, limit.load_factor)), limit.open_share
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
    """Shear over the required friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism."""
    return _at_corners(
        required,
        ax,
        equals(
            rf"$\lambda = {required.load_factor:.4g}$: required friction $f$", required.required
        ),
    )


@picture.register
def _guaranteed_limit(
    limit: GuaranteedLimit, ax: Axes | AxesArray | None = None
) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the witness, in space at the first one; the critical node is circled."""
    title = (
        equals(r"guaranteed limit $\lambda_1$", limit.load_factor)
        + ", "
        + equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    )
    if limit.node is not None and limit.corners is not None:
        names, node = (
            [limit.cycle.corner_names[corner] for corner in limit.corners],
            node_at(limit.system, limit.node),
        )
        on_both = f"on the bound of forward slip at {names[0]}\nand of backward slip at {names[-1]}"
        title += f"\n{node}: " + (
            on_both if limit.system.tangents == 1 else "on its bound at\n" + "; ".join(names)
        )
    return _at_corners(limit, ax, title)


def _at_corners(limit: Limit, ax: Axes | AxesArray | None, title: str) -> Axes | AxesArray:
    """Shear over friction bound at the corners, with circles at the nodes that limit the load; or why there is nothing to show."""
    panels, circles, what = panels_of(ax, limit.system), {}, ""
    panels[0].set_title(title)
    if isinstance(limit, ShakedownLimit | RequiredFriction):
        rows, what = limit.mechanism.groupby("corner"), "limiting node; area: share"
        circles = {
            corner: (row["node"], row.get("direction"), _AREA * row["share"])
            for corner, row in rows
        }
    elif limit.corners is not None:
        circles, what = (
            {
                corner: (limit.node, sense, ONE_NODE)
                for corner, sense in zip(limit.corners, (1, -1), strict=False)
            },
            "critical node",
        )
    names, q, p = limit._instants
    if not np.isfinite(p).all() or not (
        limit.friction.any() or circles
    ):  # without friction, and nothing that limits
        no_lines(panels, limit.reason)
        return together(panels)
    return shear_ratios(
        panels,
        limit.system,
        limit.friction,
        q,
        p,
        names,
        circles,
        what,
        slip=limit.slip,
        opened=limit.open,
    )


@picture.register
def _safe_slip(safe: SafeSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    return _reserve(
        safe,
        ax,
        rf"{title} at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}",
        safe.slip,
        "slip $v$ (length)",
    )


@picture.register
def _design(design: Design, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the safe slip; below, the profile where the faces were free."""
    amounts = [f"{name} {amount:+.4g}" for name, amount in design.preload.items()]
    title = ", ".join(
        [
            equals(r"best design, $\lambda$", design.load_factor),
            *amounts[:4],
            *["..."] * (len(amounts) > 4),
        ]
    )
    return _reserve(design, ax, title, design.profile, "material taken off (length)")


def _reserve(
    found: SafeSlip | Design,
    ax: Axes | AxesArray | None,
    title: str,
    profile: Array | None,
    name: str,
) -> Axes | AxesArray:
    """Shear over friction bound at the corners under the slip (of many corners, the one with the least reserve); below, a profile, if there is one.

    In space, at the corner with the least reserve, with the slip as arrows.
    """
    system, (q, p), names = found.system, found.reactions, found.cycle.corner_names
    least = int(np.argmin((found.friction * p - lengths(q, p))[:, ~found.open].min(axis=1)))
    alone = profile is None or system.tangents == 2
    upper, *below = panels = panels_of(ax, system) if alone else new_axes(ax, 2, (6.4, 5.4))
    upper.set_title(title)
    where = panels if alone else [upper]
    drawn = shear_ratios(
        where,
        found.system,
        found.friction,
        q,
        p,
        names,
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
    """Weights of the slip at the corners (of many corners, lines of those with the largest); in space maps of those between corners."""
    panels, claim = panels_of(ax, least.system), "no slip is proven"
    axes = panels[0]
    if least.bound > 0:
        total = f"slip between corners at least {least.total:.4g} in all while all nodes are closed"
        claim = f"weighted sum of the slips at least {least.bound:.4g};\n{total if np.isfinite(least.total) else 'no cycle keeps all nodes closed'}"
    axes.set_title(rf"$\lambda = {least.load_factor:.4g}$: {claim}")
    if least.system.tangents == 2:
        return face_map(
            panels, least.system, least.weight, "weight of the slip between corners (1 / length)"
        )
    lines_or_band(
        axes,
        least.system,
        least.g,
        least.cycle.corner_names,
        np.argsort(-np.abs(least.g).sum(axis=1), kind="stable").tolist(),
    )
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
    axes.fill(*np.vstack([[0.0, 0.0], inner, free]).T, **INSIDE)
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(outer)):
        look = line(number) if few else {"color": BLACK}
        all_sides = f"{len(region.sides)} sides, each a mechanism" if number == 0 else None
        axes.plot(
            *np.transpose(ends), **look, label=_limiting(region, number) if few else all_sides
        )
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
    for name, load, unlimited, most in zip(
        "xy", region.loads, free, outer.max(axis=0), strict=True
    ):
        label = f"amplitude of {load}" + (": no limit" if unlimited else " (times its unit load)")
        ends = (0.0, 1.0) if unlimited else (0.0, 1.08 * most or 1.0)
        axes.set(
            **{f"{name}label": label, f"{name}lim": ends}
            | ({f"{name}ticks": []} if unlimited else {})
        )
    legend(axes)
    return axes


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {'slips' if slips else 'opens'} most"
