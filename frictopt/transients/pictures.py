"""Pictures of load cycles and transients: their loops, their history, what each node does in them, and what is left of them in the steady state."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from ..base import RESIDUAL, ROUNDING, SIMULTANEOUS
from ..contact import lengths, most_shear
from ..contact.face import face_map, panels_of, together
from ..contact.strip import (
    ONE_NODE,
    Circles,
    label_contacts,
    label_panels,
    lines,
    lines_or_band,
    node_at,
    parts,
    shear_ratios,
    work_label,
)
from ..plots.draw import draw as draw
from ..plots.style import (
    BLACK,
    GREY,
    POINTS,
    SERIES,
    AxesArray,
    Look,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
    series,
)
from .fretting import slip_ways
from .onset import Onset
from .outcome import SteadyState
from .trajectory import LoadLoop, Trajectory

_STATUS = (
    (0, "stick", "#DDDDDD"),
    (1, "slip", SERIES[0]["color"]),
    (-1, "slip -", SERIES[1]["color"]),
    (2, "open", BLACK),
)  # code, word, colour
_LOOKS: dict[str, Look] = {
    "q": {"band": series(0)["color"]},
    "p": {"band": series(1)["color"], "lw": 0.5, "alpha": 0.8},
}


def node_status(states: Trajectory, ax: Axes | None = None) -> Axes:
    """Stick, slip and open of each node (across) over the corners visited (upwards); in space the nodes by number."""
    (axes,) = new_axes(ax)
    system, done = (
        states.system,
        states.status[:-1] if states.engine == "path" else states.status[1:],
    )
    across, groups = (
        (system.x, parts(system))
        if system.tangents == 1
        else (np.arange(system.nodes, dtype=float), [("", slice(None))])
    )
    codes, words, colours = zip(*_STATUS, strict=True)
    look: Look = {
        "cmap": ListedColormap(colours),
        "norm": BoundaryNorm(np.arange(-0.5, 4), 4),
        "rasterized": True,
    }
    for _, nodes in groups:
        at = across[nodes]
        half = np.diff(at) / 2 if len(at) > 1 else np.array([0.5])
        edges = np.concatenate(
            [[at[0] - half[0]], at[:-1] + half[: len(at) - 1], [at[-1] + half[-1]]]
        )
        axes.pcolormesh(
            edges,
            states.time,
            np.select([done[:, nodes] == code for code in codes], range(4)),
            **look,
        )
    _time_axis(axes, states, "y")
    if system.tangents == 1:
        label_contacts(axes, system)
        words = (words[0], "slip +", *words[2:])
    else:
        axes.set_xlabel("number of the node")
    patches = [
        Patch(facecolor=colour, edgecolor=GREY, label=word)
        for word, colour in zip(words, colours, strict=True)
    ]
    legend(
        axes,
        handles=[
            patch for code, patch in zip(codes, patches, strict=True) if code in states.status
        ],
    )
    return axes


@picture.register
def _trajectory(path: Trajectory, ax: AxesArray | None = None) -> AxesArray:
    """Panels for the nodes with the most work: shear force against slip along each tangent, and last slip against the corners visited."""
    tangents, nodes = path.system.tangents, np.argsort(-path.work[-1], kind="stable")[:3]
    *sides, below = panels = new_axes(
        ax, tangents + 1, (6.4, 6.4 if tangents == 1 else 8.4), common_x=False
    )
    per_depth = " per depth" if tangents == 1 else ""
    names = [node_at(path.system, node) for node in nodes]
    slip, q = (
        values.reshape(*path.gap.shape, tangents)[:, nodes]
        for values in (path.slip / path.system.stretch, path.q * path.system.stretch)
    )
    for axis, axes in enumerate(sides):
        number = f"_{axis + 1}" if tangents == 2 else ""
        for node, name in enumerate(names):
            v, shear, color = slip[:, node, axis], q[:, node, axis], series(node)["color"]
            axes.plot(v, shear, label=name, **line(node))
            axes.plot(
                v[-1:],
                shear[-1:],
                color=color,
                marker="o",
                markersize=4,
                label="last state" if node == 0 else None,
            )
            below.plot(
                path.time,
                v,
                color=color,
                linestyle=series(node if tangents == 1 else axis)["linestyle"],
            )
        axes.set(
            xlabel=f"slip $v{number}$ (length)",
            ylabel=f"shear force $q{number}$ (force{per_depth})",
        )
        if tangents == 2:
            below.plot(
                [],
                [],
                color=BLACK,
                linestyle=series(axis)["linestyle"],
                label=f"$v{number}$, colours as above",
            )
    sides[0].set_title(
        "nodes with the most work of friction" if path.work[-1].any() else "no node slips"
    )
    legend(sides[0])
    _time_axis(below, path, "x")
    if _whole_cycles(below, path) or tangents == 2:
        legend(below)
    below.set_ylabel("slip $v$ (length)" if tangents == 1 else "slip $v_1$, $v_2$ (length)")
    return np.array(panels)


def _whole_cycles(axes: Axes, path: Trajectory) -> bool:
    """Draw a line at each of a few whole cycles; whether there are any."""
    corners = len(path.cycle.corners)
    cycles = int(path.time[-1]) // corners
    few = 0 < cycles <= 50
    for cycle in range(cycles + 1) if few else ():
        axes.axvline(cycle * corners, color=GREY, lw=0.5, label="cycles" if cycle == 0 else None)
    return few


@picture.register
def _steady_state(steady: SteadyState, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Three panels: slip range of the steady cycle; tractions at its corners (nodal forces where there is no width); work of friction per cycle.

    In space maps: work of friction per cycle at each node, and the slip range as arrows.
    """
    if steady.system.tangents == 2:
        outcome = steady.outcome.name.lower().replace("_", " ")
        return work_map(
            panels_of(ax, steady.system),
            steady,
            f"{outcome}, work of friction per cycle {steady.dissipation:.4g}",
        )
    slip, force, work = panels = new_axes(ax, 3, (6.4, 7.6))
    system = steady.system
    slip.set_title(
        f"{steady.outcome.name.replace('_', ' ').lower()}, $W = {steady.dissipation:.4g}$ per cycle"
    )
    slip_and_work(slip, work, steady, color=BLACK)
    states = steady.states()
    count = len(steady.cycle.corners)
    corners = (
        np.searchsorted(states.time, np.arange(1, count * steady.period + 1) + SIMULTANEOUS) - 1
    )
    called = steady.cycle.corner_names
    names = [
        f"{called[corner % count]}{', second cycle' if corner >= count else ''}"
        for corner in range(len(corners))
    ]
    width, unit = (
        (1.0, "nodal force\n(force per depth)")
        if system.width is None
        else (system.width, "traction\n(force per area)")
    )
    for name, look in _LOOKS.items():
        lines_or_band(
            force, system, getattr(states, name)[corners] / width, names, prefix=f"${name}$, ", **look
        )
    force.set_ylabel(unit)
    legend(force)
    label_panels(panels, system)
    return np.array(panels)


@picture.register
def _load_loop(loop: LoadLoop, ax: Axes | None = None) -> Axes:
    """Amplitude against displacement, with a mark where nodes begin or cease to slip."""
    (axes,) = new_axes(ax)
    d, a, slips = loop.displacement, loop.amplitude, loop.slipping
    changes = np.flatnonzero(np.diff(slips, prepend=slips[:1]))
    axes.plot(d, a, color=series(0)["color"], label=f"area {loop.area:.4g}")
    look = {
        "linestyle": "none",
        "marker": "o",
        "markersize": 4,
        "mfc": "white",
        "color": series(1)["color"],
    }
    axes.plot(d[changes], a[changes], label="nodes begin or cease to slip", **look)
    axes.set_title(f"load case {loop.case!r}: secant stiffness {loop.stiffness:.4g}")
    axes.set(xlabel="displacement (work over amplitude)", ylabel="amplitude of the load case")
    legend(axes)
    return axes


def work_map(panels: Sequence[Axes], steady: SteadyState, title: str) -> Axes | AxesArray:
    """Work of friction per cycle at each node that closes; the slip range as arrows, between the two slips of the cycle that are furthest apart."""
    panels[0].set_title(title)
    states = steady.states()
    ranges = slip_ways(states)
    ranges = np.where(
        lengths(ranges, ranges[:, 0])[:, None] > ROUNDING * np.abs(steady.slip).max(), ranges, 0.0
    )
    name = "work of friction per cycle (force times length)"
    opened = states.gap.min(axis=0) > 0
    return face_map(
        panels,
        steady.system,
        steady.dissipation_per_node,
        name,
        slip=ranges,
        slip_name="slip range",
        opened=opened,
    )


def slip_and_work(above: Axes, below: Axes, steady: SteadyState, **look: Any) -> None:
    """Draw the slip range of the steady cycle, and below the work of friction per cycle."""
    ranges = np.asarray(steady.fretting_table()["slip_range"])
    ranges = np.where(
        ranges > ROUNDING * np.abs(steady.slip).max(), ranges, 0.0
    )  # else the picture of a contact at rest is one of rounding
    lines(above, steady.system, ranges, **look, **POINTS)
    lines(below, steady.system, steady.dissipation_per_node, **look, **POINTS)
    above.set_ylabel("slip range (length)")
    below.set_ylabel(work_label(steady.system))


def _time_axis(axes: Axes, path: Trajectory, axis: str) -> None:
    """The axis of corners visited, which begins no earlier than the mean load, with the loads of the first corners as far as there is room."""
    names = ", ".join(
        f"{number}: {name}" for number, name in enumerate(["mean load", *path.cycle.corner_names])
    )
    label = f"corners visited ({names if len(names) <= 60 else '0: mean load'})"
    axes.set(**{f"{axis}label": label if axis == "x" else label.replace(" (", "\n(", 1)})
    if (first := max(0.0, path.time[0])) < path.time[-1]:
        axes.set(**{f"{axis}lim": (first, path.time[-1])})


@picture.register
def _onset(onset: Onset, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear over friction bound of the bonded contact at the first slip towards each corner (in space, the first of all); what slips is circled."""
    axes, *_ = panels = panels_of(ax, onset.system)
    title = "bonded contact at the onset of slip"
    if not onset.mean_admissible:
        settled, alone = (
            "contact under the settled mean load, at the onset of slip",
            "bonded contact; the mean load alone makes it slip or pulls",
        )
        title = settled if onset.state else alone
    axes.set_title(title)
    events = [event for event in onset.slips if event.node is not None]
    if not events:
        no_lines(panels, "no corner makes a node slip")
        return together(panels)
    at, (q, p) = (
        events.index(onset.slip),
        (part[[event.corner for event in events]] for part in onset.reactions),
    )
    shown = range(len(events)) if len(events) <= len(SERIES) else [at]
    circles: Circles = {
        number: (events[number].node, events[number].sense, ONE_NODE) for number in shown
    }
    if onset.system.tangents == 2:
        shear, bound = lengths(q, p)[at], most_shear(onset.system, onset.friction, p[at])
        zero = RESIDUAL * np.abs(bound).max()
        slips = (shear - bound >= -zero) & (
            np.maximum(shear, -bound) > zero
        )  # a node that carries nothing does not slip
        circles = {at: ([onset.slip.node, *np.flatnonzero(slips)], None, ONE_NODE)}
    names = [rf"{event.loads}, $\lambda = {event.load_factor:.4g}$" for event in events]
    return shear_ratios(
        panels, onset.system, onset.friction, q, p, names, circles, "node that slips first", at
    )
