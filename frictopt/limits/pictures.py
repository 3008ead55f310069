"""Pictures of limits, designs and safe regions: distances from slip, and limiting nodes."""

from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from ..base import Array
from ..contact import lengths
from ..contact.faces import faces_of
from ..contact.pictures import ONE_NODE, node_at, panels_of, shear_ratios
from ..plots.along import along, open_marks
from ..plots.draw import draw as draw
from ..plots.face import face_map
from ..plots.style import (
    BLACK,
    SERIES,
    AnyAxes,
    Look,
    as_is,
    equals,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
    together,
)
from .answers.least_slip import LeastSlip
from .best_design.design import Design
from .fatigue_band import FatigueBand
from .fatigue_limit import FatigueLimit
from .guaranteed import GuaranteedLimit
from .required_friction import RequiredFriction
from .safe_region import SafeRegion
from .safe_slip import SafeSlip
from .shakedown import ShakedownLimit

Limit: TypeAlias = ShakedownLimit | RequiredFriction | GuaranteedLimit


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: AnyAxes = None) -> AnyAxes:
    """Shear over friction bound at the corners under the safe slip.

    The area of a circle is the share of its node in the mechanism. Open nodes, which carry nothing,
    are marked at zero. In space, at the first corner, with the slip as arrows. If nodes open and
    close in each cycle, they are marked too.
    """
    name = r"shakedown limit $\lambda_2$"
    if limit.objective is not None:
        name = r"load factor $\lambda$ that the objective chooses"
    if limit.gap is not None:
        name = r"lower bound of $\lambda_2$"
    axes = _at_corners(limit, ax, equals(name, limit.load_factor))
    share = limit.open_share
    partly = (share > 0) & (share < 1)
    if isinstance(axes, Axes) and limit.system.tangents == 1:
        ring: Look = {"facecolors": "none", "edgecolors": BLACK}
        open_marks(axes, limit.system.x[partly], "open in part of the cycle", **ring)
    return axes


@picture.register
def _required_friction(required: RequiredFriction, ax: AnyAxes = None) -> AnyAxes:
    """Shear over the required friction bound at the corners under the safe slip.

    The area of a circle is the share of its node in the mechanism.
    """
    name = rf"$\lambda = {required.load_factor:.4g}$: required friction $f$"
    return _at_corners(required, ax, equals(name, required.required))


@picture.register
def _guaranteed_limit(limit: GuaranteedLimit, ax: AnyAxes = None) -> AnyAxes:
    """Shear over friction bound at the corners under the witness; the critical node is circled.

    In space, at the first corner.
    """
    lower = equals(r"guaranteed limit $\lambda_1$", limit.load_factor)
    upper = equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    title = f"{lower}, {upper}"
    if limit.node is not None:
        title += f"\n{node_at(limit.system, limit.node)}"
    return _at_corners(limit, ax, title)


def _at_corners(limit: Limit, ax: AnyAxes, title: str) -> AnyAxes:
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
    instants, q, p = limit._instants
    names = list(map(as_is, instants))
    nothing_limits = not limit.friction.any() and not circles
    if nothing_limits or not np.isfinite(p).all():
        no_lines(panels, limit.reason)
        return together(panels)
    of_slip: Look = {"slip": limit.slip, "opened": limit.open}
    return shear_ratios(panels, limit, q, p, names, circles, what, **of_slip)


@picture.register
def _safe_slip(safe: SafeSlip, ax: AnyAxes = None) -> AnyAxes:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    title += rf" at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}"
    return _reserve(safe, ax, title, safe.slip, "slip $v$ (length)")


@picture.register
def _fatigue_limit(limit: FatigueLimit, ax: AnyAxes = None) -> AnyAxes:
    """Shear over friction bound at the corners under the slip; below, the slip itself."""
    title = equals(r"fatigue limit $\lambda$", limit.load_factor)
    return _reserve(limit, ax, title, limit.slip, "slip $v$ (length)")


@picture.register
def _design(design: Design, ax: AnyAxes = None) -> AnyAxes:
    """Shear over friction bound at the corners under the safe slip; below, the free profile."""
    amounts = [f"{as_is(name)} {amount:+.4g}" for name, amount in design.preload.items()]
    parts = [equals(r"best design, $\lambda$", design.load_factor), *amounts[:4]]
    if len(amounts) > 4:
        parts.append("...")
    title = ", ".join(parts)
    return _reserve(design, ax, title, design.profile, "material taken off (length)")


def _reserve(
    found: SafeSlip | Design | FatigueLimit,
    ax: AnyAxes,
    title: str,
    profile: Array | None,
    name: str,
) -> AnyAxes:
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
    names = list(map(as_is, found.cycle.corner_names))
    of_slip: Look = {"slip": found.slip, "opened": found.open}
    panels_of_ratio = panels if alone else [upper]
    drawn = shear_ratios(panels_of_ratio, found, q, p, names, {}, at=least, **of_slip)
    if profile is None or alone:
        return drawn
    upper.set_xlabel("")
    along(below, system, [(name, {"": profile})])
    return np.array([upper, *below])


@picture.register
def _least_slip(least: LeastSlip, ax: AnyAxes = None) -> AnyAxes:
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
            panels,
            faces_of(least.system),
            least.weight,
            "weight of the slip between corners (1 / length)",
        )
    # Of many corners those with the largest weights.
    first = np.argsort(-np.abs(least.g).sum(axis=1), kind="stable")[: len(SERIES)]
    weights = {as_is(least.cycle.corner_names[corner]): least.g[corner] for corner in sorted(first)}
    along([axes], least.system, [("weight $g$ of the slip (1 / length)", weights)])
    return axes


@picture.register
def _fatigue_band(band: FatigueBand, ax: AnyAxes = None) -> AnyAxes:
    """The parameter at the points: the band of each, the least largest values, and no slip.

    In the plane along x, in space by the number of the point.
    """
    (axes,) = new_axes(ax)
    table = band.to_frame()
    in_plane = band.system.tangents == 1
    order = np.argsort(table["x"]) if in_plane else table["point"]
    x = table["x" if in_plane else "point"][order]
    finite = np.isfinite(table["most"][order])
    bounds = [table[end][order].where(finite) for end in ("least", "most")]
    axes.fill_between(x, *bounds, color="#56B4E9", alpha=0.25, lw=0, label="all states of rest")
    if np.isfinite(band.least):
        axes.plot(x, band.at(band.least_slip)[order], label="least largest value", **line(0))
    if table["no_slip"].notna().all():
        axes.plot(x, table["no_slip"][order], label="no slip", **line(1))
    axes.set_title(rf"$\lambda = {band.load_factor:.4g}$: fatigue band")
    axes.set(xlabel="x" if in_plane else "point", ylabel=band.parameter.replace("_", " "))
    legend(axes)
    return axes


@picture.register
def _safe_region(region: SafeRegion, ax: AnyAxes = None) -> AnyAxes:
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
    inside: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0}
    axes.fill(*np.vstack([[0.0, 0.0], inner, free]).T, label="some residual slip is safe", **inside)
    # Each side has a name and a colour of its own, if they are few.
    few = len(region.sides) <= len(SERIES)
    for number, ends in enumerate(pairwise(outer)):
        label = f"{len(region.sides)} sides, each a mechanism" if number == 0 else None
        look: Look = {"color": BLACK, "label": label}
        if few:
            look = line(number) | {"label": _limiting(region, number)}
        axes.plot(*np.transpose(ends), **look)
    if not free.any():
        marks: Look = {"linestyle": "none", "marker": "o", "markersize": 3, "color": BLACK}
        axes.plot(*inner.T, clip_on=False, label="vertex, proven safe", **marks)
    for name, load, unlimited, largest in zip(
        "xy", map(as_is, region.loads), free, outer.max(axis=0), strict=True
    ):
        look = {f"{name}lim": (0.0, 1.08 * largest or 1.0)}
        look[f"{name}label"] = f"amplitude of {load} (times its unit load)"
        if unlimited:
            look = {f"{name}lim": (0.0, 1.0), f"{name}ticks": []}
            look[f"{name}label"] = f"amplitude of {load}: no limit"
        axes.set(**look)
    legend(axes)
    return axes


def _limiting(region: SafeRegion, side: int) -> str:
    """The node with the largest share in the mechanism of a side."""
    first = region.mechanisms[side].iloc[0]
    slips = first["direction"] if "direction" in first else first["slip1"] or first["slip2"]
    moves = "slips" if slips else "opens"
    return f"side {side}: node {int(first['node'])}, $x = {first['x']:.4g}$, {moves} most"
