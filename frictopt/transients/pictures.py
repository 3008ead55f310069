"""Pictures of transients and steady states: loops, history, status of the nodes, and the onset."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from ..base import RESIDUAL, ROUNDING, SIMULTANEOUS, Array, Booleans, Integers
from ..contact import lengths, most_shear
from ..contact.face import face_map, panels_by_size, panels_of, together
from ..contact.strip import (
    ONE_NODE,
    Circles,
    force_unit,
    label_contacts,
    label_panels,
    lines,
    lines_or_band,
    node_at,
    parts,
    shear_ratios,
    stiffness_unit,
    work_label,
    work_unit,
)
from ..plots.draw import draw as draw
from ..plots.style import (
    BLACK,
    GREY,
    POINTS,
    SERIES,
    AxesArray,
    Look,
    as_is,
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

# Code, word and colour of each status.
_STATUS = (
    (0, "stick", "#DDDDDD"),
    (1, "slip", SERIES[0]["color"]),
    (-1, "slip -", SERIES[1]["color"]),
    (2, "open", BLACK),
)

# Area of a loop, as a share of the rectangle around it, below which it looks like a line.
_THIN = 0.1


def node_status(states: Trajectory, ax: Axes | None = None) -> Axes:
    """Stick, slip and open of each node (across) over the corners visited (upwards).

    In space the nodes are placed by their numbers.
    """
    (axes,) = new_axes(ax)
    system = states.system
    # The status until the next event, or over the increment that ends at a state.
    status = states.status[:-1] if states.engine == "path" else states.status[1:]
    codes, words, colours = zip(*_STATUS, strict=True)
    if system.tangents == 1:
        x = system.x
        groups = parts(system)
        words = ("stick", "slip +", "slip -", "open")
    else:
        x = np.arange(system.nodes, dtype=float)
        groups = [("", slice(None))]
    for _, nodes in groups:
        numbers = np.select([status[:, nodes] == code for code in codes], range(len(codes)))
        axes.pcolormesh(
            _edges(x[nodes]),
            states.time,
            numbers,
            cmap=ListedColormap(colours),
            norm=BoundaryNorm(np.arange(-0.5, len(codes)), len(codes)),
            rasterized=True,
        )
    _time_axis(axes, states, "y")
    if system.tangents == 1:
        label_contacts(axes, system)
    else:
        axes.set_xlabel("number of the node")
    shown = [
        Patch(facecolor=colour, edgecolor=GREY, label=word)
        for code, word, colour in zip(codes, words, colours, strict=True)
        if code in states.status
    ]
    legend(axes, handles=shown)
    return axes


def _edges(x: Array) -> Array:
    """(N + 1,) ends of the columns of nodes at x (N,), halfway to the next node."""
    half = np.diff(x) / 2 if len(x) > 1 else np.array([0.5])
    inner = x[:-1] + half[: len(x) - 1]
    return np.concatenate([[x[0] - half[0]], inner, [x[-1] + half[-1]]])


@picture.register
def _trajectory(path: Trajectory, ax: AxesArray | None = None) -> AxesArray:
    """Panels for the nodes with the most work: shear against slip, and slip against time.

    The shear force has a panel for each tangent; the last panel is over the corners visited.
    """
    tangents = path.system.tangents
    size = (6.4, 6.4 if tangents == 1 else 8.4)
    panels = new_axes(ax, tangents + 1, size, common_x=False)
    *loops, history = panels
    nodes = np.argsort(-path.work[-1], kind="stable")[:3]
    shape = (*path.gap.shape, tangents)
    slip = (path.slip / path.system.stretch).reshape(shape)[:, nodes]
    q = (path.q * path.system.stretch).reshape(shape)[:, nodes]
    for axis, axes in enumerate(loops):
        for k, node in enumerate(nodes):
            v = slip[:, k, axis]
            shear = q[:, k, axis]
            color = series(k)["color"]
            axes.plot(v, shear, label=node_at(path.system, node), **line(k))
            last: Look = {"color": color, "marker": "o", "markersize": 4}
            axes.plot(v[-1:], shear[-1:], label="last state" if k == 0 else None, **last)
            style = series(k if tangents == 1 else axis)["linestyle"]
            history.plot(path.time, v, color=color, linestyle=style)
        if tangents == 1:
            force = force_unit(path.system.per_depth)
            axes.set(xlabel="slip $v$ (length)", ylabel=f"shear force $q$ {force}")
            continue
        v_name = f"$v_{axis + 1}$"
        axes.set(xlabel=f"slip {v_name} (length)", ylabel=f"shear force $q_{axis + 1}$ (force)")
        style = series(axis)["linestyle"]
        history.plot([], [], color=BLACK, linestyle=style, label=f"{v_name}, colours as above")
    history.set_ylabel("slip $v$ (length)" if tangents == 1 else "slip $v_1$, $v_2$ (length)")
    works = path.work[-1].any()
    loops[0].set_title("nodes with the most work of friction" if works else "no node slips")
    legend(loops[0])
    _time_axis(history, path, "x")
    if _whole_cycles(history, path) or tangents == 2:
        legend(history)
    return np.array(panels)


def _whole_cycles(axes: Axes, path: Trajectory) -> bool:
    """Draw a line at each whole cycle, if these are few; returns whether there is a line."""
    corners = len(path.cycle.corners)
    cycles = int(path.time[-1]) // corners
    if not 0 < cycles <= 50:
        return False
    for cycle in range(cycles + 1):
        axes.axvline(cycle * corners, color=GREY, lw=0.5, label="cycles" if cycle == 0 else None)
    return True


@picture.register
def _steady_state(steady: SteadyState, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Panels of the slip range, the tractions at the corners, and the work of friction per cycle.

    Without a width of the nodes, nodal forces are drawn instead of tractions. In space maps show
    the work of friction per cycle of each node, and the slip range as arrows.
    """
    system = steady.system
    outcome = steady.outcome.name.lower().replace("_", " ")
    if system.tangents == 2:
        shown = _slipping_contacts(steady)
        title = _title_in_space(steady, outcome, shown)
        return work_map(panels_by_size(ax, system, shown), steady, title, shown)
    panels = new_axes(ax, 3, (6.4, 7.6))
    slip, force, work = panels
    work_of_cycle = f"{steady.dissipation:.4g} {work_unit(system.per_depth)}"
    slip.set_title(f"{outcome}, $W$ = {work_of_cycle} per cycle")
    slip_and_work(slip, work, steady, color=BLACK)

    states = steady.states()
    names = list(map(as_is, steady.cycle.corner_names))
    if steady.period == 2:
        names += [f"{name}, second cycle" for name in names]
    corners = np.searchsorted(states.time, np.arange(1, len(names) + 1) + SIMULTANEOUS) - 1
    width: float | Array = 1.0
    force.set_ylabel(f"nodal force\n{force_unit(system.per_depth)}")
    if system.width is not None:
        width = system.width
        force.set_ylabel("traction\n(force per area)")
    shear_look: Look = {"band": series(0)["color"]}
    pressure_look: Look = {"band": series(1)["color"], "lw": 0.5, "alpha": 0.8}
    lines_or_band(force, system, states.q[corners] / width, names, prefix="$q$, ", **shear_look)
    lines_or_band(force, system, states.p[corners] / width, names, prefix="$p$, ", **pressure_look)
    legend(force)
    label_panels(panels, system)
    return np.array(panels)


@picture.register
def _load_loop(loop: LoadLoop, ax: Axes | None = None) -> Axes:
    """Load against displacement, with a mark where nodes begin or cease to slip.

    They are force and mean motion if the size of the load is known. Of a thin loop the load without
    the share of the secant stiffness is drawn.
    """
    (axes,) = new_axes(ax)
    changes = np.flatnonzero(np.diff(loop.slipping, prepend=loop.slipping[:1]))
    work = work_unit(loop.per_depth)
    if np.isfinite(loop.load_size):
        size = loop.load_size
        names = "mean motion of the load (length)", f"force {force_unit(loop.per_depth)}"
        unit = stiffness_unit(loop.per_depth)
    else:
        size = 1.0
        names = f"displacement, work over amplitude {work}", "amplitude of the load case"
        unit = "(1 / force)" if loop.per_depth else "(1 / force times length)"
    displacement = loop.displacement / size
    amplitude = loop.amplitude * size
    stiffness = loop.stiffness * size**2
    around = float(np.ptp(displacement) * np.ptp(amplitude))
    if 0 < loop.area < _THIN * around:
        middle = (displacement.max() + displacement.min()) / 2
        amplitude = amplitude - stiffness * (displacement - middle)
        names = names[0], f"{names[1]}\nbeyond the secant stiffness"
    area = f"area {loop.area:.4g} {work}"
    axes.plot(displacement, amplitude, color=series(0)["color"], label=area)
    marks = {
        "linestyle": "none",
        "marker": "o",
        "markersize": 4,
        "mfc": "white",
        "color": series(1)["color"],
    }
    label = "nodes begin or cease to slip"
    axes.plot(displacement[changes], amplitude[changes], label=label, **marks)
    axes.set_title(f"load case {as_is(repr(loop.case))}: secant stiffness {stiffness:.4g} {unit}")
    axes.set(xlabel=names[0], ylabel=names[1])
    legend(axes)
    return axes


def _slipping_contacts(steady: SteadyState) -> Booleans:
    """(N,) the nodes of the contacts that slip; all nodes if none slips."""
    slips = steady.slipping
    if steady.system.contact is not None:
        slips = np.isin(steady.system.contact, np.unique(steady.system.contact[slips]))
    return slips if slips.any() else np.ones_like(slips)


def _title_in_space(steady: SteadyState, outcome: str, shown: Booleans) -> str:
    """The outcome and the work, and the contacts that are left out because they do not slip."""
    work = f"{steady.dissipation:.4g} (force times length)"
    title = f"{outcome}, work of friction per cycle {work}"
    names = steady.system.contact
    if names is None or shown.all():
        return title
    kept = dict.fromkeys(names[shown].tolist())
    left_out = list(dict.fromkeys(names[~shown].tolist()))
    if len(kept) == 1:
        title = f"{as_is(next(iter(kept)))}: {title}"
    without_slip = ", ".join(map(as_is, left_out))
    # A title names so many contacts.
    most_names = 4
    if len(left_out) > most_names:
        without_slip = f"{len(left_out)} other contacts"
    return f"{title}\nno slip: {without_slip}"


def work_map(
    panels: Sequence[Axes], steady: SteadyState, title: str, shown: Booleans | None = None
) -> Axes | AxesArray:
    """Work of friction per cycle at each node that closes, and the slip range as arrows.

    An arrow has the length and the direction of the largest difference of two slips of the cycle.
    """
    panels[0].set_title(title)
    states = steady.states()
    ranges = slip_ways(states)
    is_rounding = lengths(ranges, ranges[:, 0]) <= ROUNDING * np.abs(steady.slip).max()
    ranges = np.where(is_rounding[:, None], 0.0, ranges)
    return face_map(
        panels,
        steady.system,
        steady.dissipation_per_node,
        "work of friction per cycle (force times length)",
        slip=ranges,
        slip_name="slip range",
        to_and_fro=True,
        opened=states.gap.min(axis=0) > 0,
        shown=shown,
    )


def slip_and_work(above: Axes, below: Axes, steady: SteadyState, **look: Any) -> None:
    """Draw the slip range of the steady cycle, and below the work of friction per cycle."""
    ranges = np.asarray(steady.fretting_table()["slip_range"])
    # Otherwise the picture of a contact at rest would show rounding.
    ranges = np.where(ranges > ROUNDING * np.abs(steady.slip).max(), ranges, 0.0)
    lines(above, steady.system, ranges, **look, **POINTS)
    lines(below, steady.system, steady.dissipation_per_node, **look, **POINTS)
    above.set_ylabel("slip range (length)")
    below.set_ylabel(work_label(steady.system))


def _time_axis(axes: Axes, path: Trajectory, axis: str) -> None:
    """Label and limits of the axis ("x" or "y") of the corners visited, from the mean load on.

    The label lists the loads of the corners, if there is room.
    """
    names = ["0: mean load"]
    names += [f"{k}: {as_is(name)}" for k, name in enumerate(path.cycle.corner_names, start=1)]
    listed = ", ".join(names)
    if len(listed) > 60:
        listed = names[0]
    separator = " " if axis == "x" else "\n"
    axes.set(**{f"{axis}label": f"corners visited{separator}({listed})"})
    if path.time[0] < path.time[-1]:
        axes.set(**{f"{axis}lim": (path.time[0], path.time[-1])})


@picture.register
def _onset(onset: Onset, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Shear divided by friction bound of the bonded contact at the first slip towards each corner.

    In space only the first slip of all is drawn. Slipping nodes are circled.
    """
    system = onset.system
    panels = panels_of(ax, system)
    panels[0].set_title(_onset_title(onset))
    events = [event for event in onset.slips if event.node is not None]
    if not events:
        no_lines(panels, "no corner makes a node slip")
        return together(panels)
    first = events.index(onset.slip)
    corners = [event.corner for event in events]
    q, p = (part[corners] for part in onset.reactions)
    if system.tangents == 2:
        nodes = [onset.slip.node, *_at_bound(onset, q[first], p[first])]
        circles: Circles = {first: (nodes, None, ONE_NODE)}
    else:
        drawn = range(len(events)) if len(events) <= len(SERIES) else [first]
        circles = {k: (events[k].node, events[k].sense, ONE_NODE) for k in drawn}
    names = [rf"{as_is(event.loads)}, $\lambda = {event.load_factor:.4g}$" for event in events]
    label = "node that slips first"
    return shear_ratios(panels, system, onset.friction, q, p, names, circles, label, first)


def _onset_title(onset: Onset) -> str:
    if onset.mean_admissible:
        return "bonded contact at the onset of slip"
    if onset.state is None:
        return "bonded contact; the mean load makes it slip, or pulls"
    return "contact under the settled mean load, at the onset of slip"


def _at_bound(onset: Onset, q: Array, p: Array) -> Integers:
    """Nodes on their friction bound. A node that carries nothing does not slip."""
    bound = most_shear(onset.system, onset.friction, p)
    shear = lengths(q, p)
    zero = RESIDUAL * np.abs(bound).max()
    return np.flatnonzero((shear - bound >= -zero) & (np.maximum(shear, -bound) > zero))
