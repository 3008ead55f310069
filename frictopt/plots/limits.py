"""Pictures of onset and limits: how far each node is from slip, and which nodes limit the load."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ..contact import Onset
from ..contact.checks import Array
from ..limits import GuaranteedLimit, LeastSlip, RequiredFriction, SafeSlip, SeparatedLimit, ShakedownLimit
from .along import circle, friction_ratio, label_contacts, lines, lines_or_band, looks, open_nodes
from .picture import picture
from .spatial import first_slips, limiting_face, safe_slip_face, weight_map
from .style import BLACK, GREY, AxesArray, equals, legend, new_axes, no_lines, one_axes

_AREA = 400  # of the circle round a node that is the whole mechanism, points^2
_ONE_NODE = 60  # of the circle round a node that stands alone


@picture.register
def _onset(onset: Onset, ax: Axes | None = None) -> Axes:
    """Shear over friction bound of the bonded contact at the first slip towards each corner (in space, the first of all); what slips is circled."""
    axes = one_axes(ax, onset.system.tangents)
    settled = (
        "contact under the settled mean load, at the onset of slip" if onset.state else "bonded contact; the mean load alone makes it slip or pulls"
    )
    axes.set_title("bonded contact at the onset of slip" if onset.mean_admissible else settled)
    nodes = {event.corner: event.node for event in onset.slips if event.node is not None}
    if not nodes:
        return no_lines(axes, "no corner makes a node slip")
    if onset.system.tangents == 2:
        return first_slips(axes, onset)
    corners = list(nodes)
    first = corners.index(onset.slip.corner)
    called = onset.cycle.corner_names
    names = [rf"{called[corner]}, $\lambda = {onset.slips[corner].load_factor:.4g}$" for corner in corners]
    q, p = (reaction[corners] for reaction in onset.reactions)
    ratio = friction_ratio(axes, onset.system, onset.friction, q, p, names, [first])
    label: str | None = "first node that slips"
    for number, look in looks(len(corners), [first]).items():
        node = nodes[corners[number]]
        circle(axes, onset.system.x[node], ratio[number, node], onset.slips[corners[number]].sense, _ONE_NODE, look["color"], label)
        label = None
    legend(axes)
    return axes


@picture.register
def _shakedown_limit(limit: ShakedownLimit, ax: Axes | None = None) -> Axes:
    """Shear over friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism.

    In space, at the first corner, with the slip as arrows.
    """
    axes = one_axes(ax, limit.system.tangents)
    name = r"shakedown limit $\lambda_2$" if limit.objective is None else r"load factor $\lambda$ that the objective chooses"
    axes.set_title(equals(name, limit.load_factor))
    return _limiting(axes, limit, limit.friction, exists=bool(np.isfinite(limit.load_factor)))


@picture.register
def _required_friction(required: RequiredFriction, ax: Axes | None = None) -> Axes:
    """Shear over the required friction bound at the corners under the safe slip; the area of a circle is the share of its node in the mechanism."""
    axes = one_axes(ax, required.system.tangents)
    axes.set_title(equals(rf"$\lambda = {required.load_factor:.4g}$: required friction $f$", required.required))
    return _limiting(axes, required, np.full(required.system.nodes, required.required), exists=0 < required.required < np.inf)


@picture.register
def _guaranteed_limit(limit: GuaranteedLimit, ax: Axes | None = None) -> Axes:
    """Shear over friction bound at the corners under the witness, in space at the first one; the critical node is circled."""
    axes = one_axes(ax, limit.system.tangents)
    axes.set_title(
        equals(r"guaranteed limit $\lambda_1$", limit.load_factor) + ", " + equals(r"shakedown limit $\lambda_2$", limit.shakedown.load_factor)
    )
    if not np.isfinite(limit.load_factor):
        return no_lines(axes, limit.reason)
    ruling = [] if limit.corners is None else list(limit.corners)
    q, p = limit.reactions
    if limit.node is not None:
        axes.set_title(f"{axes.get_title()}\n{_on_its_bounds(limit.node, limit, ruling)}")
    if limit.system.tangents == 2:
        return limiting_face(axes, limit, limit.friction)
    friction_ratio(axes, limit.system, limit.friction, q, p, limit.cycle.corner_names, ruling)
    label: str | None = f"node {limit.node}, on both bounds"
    for corner, sense in zip(ruling, (1, -1), strict=False):
        circle(axes, limit.system.x[limit.node], -sense, sense, _ONE_NODE, looks(len(q), ruling)[corner]["color"], label)
        label = None
    open_nodes(axes, limit.system, limit.open)
    legend(axes)
    return axes


@picture.register
def _separated_limit(limit: SeparatedLimit, ax: Axes | None = None) -> Axes:
    """Shear over friction bound at the corners of the resting cycle; open nodes, which have none, are marked at zero."""
    axes = one_axes(ax, limit.system.tangents)
    title = equals(rf"{'limit with separation,' if limit.proven else 'rests up to'} $\lambda$", limit.load_factor)
    if not (limit.load_factor == np.inf or np.isnan(limit.bound)):
        title += f", bound {limit.bound:.5g}" if np.isfinite(limit.bound) else ", no bound"
    axes.set_title(title)
    if not np.isfinite(limit.load_factor):
        return no_lines(axes, limit.reason)
    q, p = limit.reactions
    if limit.system.tangents == 2:
        return limiting_face(axes, limit, limit.friction)
    friction_ratio(axes, limit.system, limit.friction, q, p, limit.cycle.corner_names)
    open_nodes(axes, limit.system, limit.open)
    legend(axes)
    return axes


@picture.register
def _least_slip(least: LeastSlip, ax: Axes | None = None) -> Axes:
    """Weights of the slip at the corners (of many corners, lines of those with the largest); in space a map of those between corners."""
    axes = one_axes(ax, least.system.tangents)
    if least.bound <= 0:
        claim = "no slip is proven"
    else:
        claim = f"weighted sum of the slips at least {least.bound:.4g};\n"
        if np.isfinite(least.total):
            claim += f"slip between corners at least {least.total:.4g} in all while all nodes are closed"
        else:
            claim += "no cycle keeps all nodes closed"
    axes.set_title(rf"$\lambda = {least.load_factor:.4g}$: {claim}")
    if least.system.tangents == 2:
        return weight_map(axes, least)
    lines_or_band(axes, least.system, least.g, least.cycle.corner_names, np.argsort(-np.abs(least.g).sum(axis=1), kind="stable").tolist())
    axes.axhline(0, color=GREY, lw=0.6, zorder=0)
    axes.set_ylabel("weight $g$ of the slip (1 / length)")
    label_contacts(axes, least.system)
    legend(axes)
    return axes


@picture.register
def _safe_slip(safe: SafeSlip, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Above, shear over friction bound at the corners under the slip (of many corners, the one with the least reserve); below, the slip itself.

    In space, at the corner with the least reserve, with the slip as arrows.
    """
    title = "safe slip" if safe.exists else "no slip is safe; the least unsafe one"
    title = rf"{title} at $\lambda = {safe.load_factor:.4g}$, margin {safe.margin:.4g}"
    if safe.system.tangents == 2:
        return safe_slip_face(one_axes(ax, 2), safe, title)
    upper, lower = new_axes(ax, 2, (6.4, 5.4))
    q, p = safe.reactions
    least = int(np.argmin((safe.friction * p - np.abs(q))[:, ~safe.open].min(axis=1)))
    friction_ratio(upper, safe.system, safe.friction, q, p, safe.cycle.corner_names, [least])
    open_nodes(upper, safe.system, safe.open)
    upper.set_xlabel("")
    upper.set_title(title)
    legend(upper)
    lines(lower, safe.system, safe.slip, color=BLACK, marker=".", markersize=3)
    lower.axhline(0, color=GREY, lw=0.8)
    lower.set_ylabel("slip $v$ (length)")
    label_contacts(lower, safe.system)
    return np.array([upper, lower])


def _on_its_bounds(node: int, limit: GuaranteedLimit, corners: Sequence[int]) -> str:
    """Where the critical node is, and the loads at which it is on its bounds."""
    names = [limit.cycle.corner_names[corner] for corner in corners]
    if limit.system.tangents == 1:
        sides = [f"of {way} slip at {name}" for way, name in zip(("forward", "backward"), names, strict=True)]
        return f"node {node}, $x = {limit.system.x[node]:.4g}$: on the bound " + "\nand ".join(sides)
    place = ", ".join(f"{part:.3g}" for part in limit.system.points[node])
    return f"node {node} at ({place}): on its bound at\n" + "; ".join(names)


def _limiting(axes: Axes, result: ShakedownLimit | RequiredFriction, friction: Array, *, exists: bool) -> Axes:
    if not exists:
        return no_lines(axes, result.reason)
    if result.system.tangents == 2:
        return limiting_face(axes, result, friction)
    """Draw the shear over the friction bound at the corners, and circles at the nodes of the mechanism."""
    ruling = result.mechanism.groupby("corner")["share"].sum().sort_values(ascending=False).index.tolist()
    q, p = result.reactions
    ratio = friction_ratio(axes, result.system, friction, q, p, result.cycle.corner_names, ruling)
    label: str | None = "limiting node; area: share"
    for corner, look in looks(len(q), ruling).items():
        rows = result.mechanism[result.mechanism["corner"] == corner]
        if len(rows):
            circle(axes, rows["x"], ratio[corner, rows["node"]], rows["direction"], _AREA * rows["share"], look["color"], label)
            label = None
    open_nodes(axes, result.system, result.open)
    legend(axes)
    return axes
