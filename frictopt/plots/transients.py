"""Pictures of transients: their loops, their history, what each node does in them, and what is left of them in the steady state."""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ..contact import ROUNDING, SIMULTANEOUS, Array, Integers, shown, whole_number
from ..contact.files import output
from ..histories.dissipation_range import DissipationRange
from ..transients import LoadLoop, SteadyState, Trajectory
from .faces import places_of, turned
from .nodes import arrows, label_contacts, label_panels, lines, lines_or_band, node_at, parts, steady_map
from .style import BLACK, FACE, GREY, SERIES, AxesArray, Look, equals, legend, line, name_units, new_axes, one_axes, picture, screen, series

_CODES = (0, 1, -1, 2)
_COLOURS = ("#DDDDDD", SERIES[0]["color"], SERIES[1]["color"], BLACK)
_MOST_FRAMES = 1000
_PER_SECOND = 12


def node_status(states: Trajectory, ax: Axes | None = None) -> Axes:
    """Stick, slip and open of each node (across) over the corners visited (upwards); in space the nodes by number."""
    (axes,) = new_axes(ax)
    system, done = states.system, states.status[:-1] if states.engine == "path" else states.status[1:]
    across, groups = (system.x, parts(system)) if system.tangents == 1 else (np.arange(system.nodes, dtype=float), [("", slice(None))])
    colours, norm = ListedColormap(_COLOURS), BoundaryNorm(np.arange(-0.5, 4), 4)
    for _, nodes in groups:
        at = across[nodes]
        half = np.diff(at, prepend=at[0], append=at[-1]) / 2
        edges = np.concatenate([[at[0] - (half[1] if len(at) > 1 else 0.5)], at + np.append(half[1:-1], half[-2] if len(at) > 1 else 0.5)])
        rows = np.select([done[:, nodes] == code for code in _CODES], range(4))
        axes.pcolormesh(edges, states.time, rows, cmap=colours, norm=norm, rasterized=True)
    axes.set_ylabel(corners_visited(states).replace(" (", "\n(", 1))
    first = states.time[0] if states.time[0] >= 0 else 0.0
    axes.set_ylim(first, states.time[-1])
    if system.tangents == 1:
        label_contacts(axes, system)
    else:
        axes.set_xlabel("number of the node")
    axes.legend(handles=_patches(system.tangents, states.status), loc="upper left", bbox_to_anchor=(1.0, 1.02))
    return axes


def animate(states: Trajectory, path: object, frames: int) -> None:
    """Write the animation of a transient, see `Trajectory.animate`."""
    file = output(path if isinstance(path, str | Path) else shown(path), ".gif")
    times = np.linspace(max(states.time[0], 0.0), states.time[-1], whole_number("frames", frames, least=2, most=_MOST_FRAMES))
    rows = np.clip(np.searchsorted(states.time, times, side="right") - 1, 0, len(states.time) - 2)
    status = states.status[rows if states.engine == "path" else rows + 1]
    step = states.time[rows + 1] - states.time[rows]
    share = np.divide(times - states.time[rows], step, out=np.zeros(len(times)), where=step > 0)
    q, p, loads = (_between(getattr(states, name), rows, share) for name in ("q", "p", "amplitudes"))
    with screen():
        axes = one_axes(None, states.system.tangents)

        def draw(frame: int) -> None:
            axes.clear()
            colours = [_COLOURS[_CODES.index(code)] for code in status[frame].tolist()]
            (_shear_along if states.system.tangents == 1 else _shear_on_face)(axes, states, q, p, frame, colours)
            named = ", ".join(equals(*load) for load in zip(states.system.bonded, loads[frame].tolist(), strict=True) if np.isfinite(load[1]))
            axes.set_title(f"{times[frame]:.2f} corners visited{': ' * bool(named)}{named}")
            name_units(axes, states.system.units)

        try:
            FuncAnimation(axes.figure, draw, frames=len(times), cache_frame_data=False).save(file, writer=PillowWriter(fps=_PER_SECOND))  # type: ignore[arg-type]
        finally:
            plt.close(axes.figure)


def _between(values: Array, rows: Integers, share: Array) -> Array:
    """States between rows, as the path is linear there."""
    part = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1 - part) * values[rows] + part * values[rows + 1])


def _patches(tangents: int, status: NDArray[np.int8]) -> list[Patch]:
    words = ("stick", "slip +", "slip -", "open") if tangents == 1 else ("stick", "slip", "", "open")
    found = [number for number, code in enumerate(_CODES) if (status == code).any()]
    return [Patch(facecolor=_COLOURS[number], edgecolor=GREY, label=words[number]) for number in found]


def _shear_along(axes: Axes, states: Trajectory, q: Array, p: Array, frame: int, colours: list[str]) -> None:
    """Shear within the bounds of friction, a mark for each node."""
    system = states.system
    width = np.ones(system.nodes) if system.width is None else system.width
    shear, bound = q[frame] / width, states.friction * p / width
    for sign, name in ((1, r"$\pm f p$"), (-1, None)):
        axes.plot(system.x, sign * bound[frame], color=GREY, lw=0.8, label=name)
    axes.plot(system.x, shear, color=BLACK, lw=0.8, label="$q$")
    axes.scatter(system.x, shear, c=colours, edgecolors=GREY, linewidths=0.4, s=22, zorder=3)
    largest = 1.05 * float(np.quantile(np.abs(bound).max(axis=0), 0.95) or 1.0)  # at sharp corners tractions grow without end
    axes.set(ylim=(-largest, largest), ylabel="shear force (force per depth)" if system.width is None else "shear traction (force per area)")
    label_contacts(axes, system)
    axes.legend(handles=[*axes.get_legend_handles_labels()[0], *_patches(1, states.status)], loc="upper left", bbox_to_anchor=(1.0, 1.02))


def _shear_on_face(axes: Axes, states: Trajectory, q: Array, _p: Array, frame: int, colours: list[str]) -> None:
    """The face seen along its normal: a mark for each node, its shear as an arrow."""
    places, labels, _, turn = places_of(states.system)
    shear = turned(turn, q)
    axes.scatter(places[:, 0], places[:, 1], c=colours, edgecolors=GREY, linewidths=0.4, s=60)
    arrows(axes, places, shear[frame], shear, width=0.005)
    axes.set(xlabel=f"{labels[0]} (length)", ylabel=f"{labels[1]} (length)", aspect="equal")
    axes.margins(0.1)
    axes.legend(handles=_patches(2, states.status), loc="upper left", bbox_to_anchor=(1.0, 1.02), title="arrows: shear")


_DOTS: Look = {"marker": ".", "markersize": 3}
_LOOKS: dict[str, Look] = {"q": {"band": series(0)["color"]}, "p": {"band": series(1)["color"], "lw": 0.5, "alpha": 0.8}}
_NODES = 3  # nodes whose loops are drawn
_LONGEST = 60  # characters of the names of corners beside an axis
_MOST_LINES = 50  # cycles of which each has its own line


@picture.register
def _trajectory(path: Trajectory, ax: AxesArray | None = None) -> AxesArray:
    """Panels for the nodes with the most work: shear force against slip along each tangent, and last slip against the corners visited."""
    tangents, nodes = path.system.tangents, np.argsort(-path.work[-1], kind="stable")[:_NODES]
    *sides, below = panels = new_axes(ax, tangents + 1, (6.4, 6.4 if tangents == 1 else 8.4), common_x=False)
    per_depth = " per depth" if tangents == 1 else ""
    names = [node_at(path.system, node) for node in nodes]
    slip, q = (values.reshape(*path.gap.shape, tangents)[:, nodes] for values in (path.slip, path.q))
    for axis, axes in enumerate(sides):
        number = f"_{axis + 1}" if tangents == 2 else ""
        for node, name in enumerate(names):
            v, shear, color = slip[:, node, axis], q[:, node, axis], series(node)["color"]
            axes.plot(v, shear, label=name, **line(node))
            axes.plot(v[-1:], shear[-1:], color=color, marker="o", markersize=4, label="last state" if node == 0 else None)
            below.plot(path.time, v, color=color, linestyle=series(node if tangents == 1 else axis)["linestyle"])
        axes.set(xlabel=f"slip $v{number}$ (length)", ylabel=f"shear force $q{number}$ (force{per_depth})")
        if tangents == 2:
            below.plot([], [], color=BLACK, linestyle=series(axis)["linestyle"], label=f"$v{number}$, colours as above")
    sides[0].set_title("nodes with the most work of friction" if path.work[-1].any() else "no node slips")
    legend(sides[0])
    if cycle_lines(below, path) or tangents == 2:
        legend(below)
    below.set_ylabel("slip $v$ (length)" if tangents == 1 else "slip $v_1$, $v_2$ (length)")
    return np.array(panels)


@picture.register
def _steady_state(steady: SteadyState, ax: Axes | AxesArray | None = None) -> Axes | AxesArray:
    """Three panels: slip range of the steady cycle; tractions at its corners (nodal forces where there is no width); work of friction per cycle.

    In space a map: work of friction per cycle at each node, and the slip at the last corner as arrows.
    """
    if steady.system.tangents == 2:
        return steady_map(steady, ax)
    slip, force, work = panels = new_axes(ax, 3, (6.4, 7.6))
    system = steady.system
    slip.set_title(f"{steady.outcome.name.replace('_', ' ').lower()}, $W = {steady.dissipation:.4g}$ per cycle")
    _slip_and_work(slip, work, steady, color=BLACK)
    states = steady.states()
    count = len(steady.cycle.corners)
    corners = np.searchsorted(states.time, np.arange(1, count * steady.period + 1) + SIMULTANEOUS) - 1
    called = steady.cycle.corner_names
    names = [f"{called[corner % count]}{', second cycle' if corner >= count else ''}" for corner in range(len(corners))]
    width, unit = (1.0, "nodal force\n(force per depth)") if system.width is None else (system.width, "traction\n(force per area)")
    for name, look in _LOOKS.items():
        lines_or_band(force, system, getattr(states, name)[corners] / width, [f"${name}$, {corner}" for corner in names], **look)
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
    look = {"linestyle": "none", "marker": "o", "markersize": 4, "mfc": "white", "color": series(1)["color"]}
    axes.plot(d[changes], a[changes], label="nodes begin or cease to slip", **look)
    axes.set_title(f"load case {loop.case!r}: secant stiffness {loop.stiffness:.4g}")
    axes.set(xlabel="displacement (work over amplitude)", ylabel="amplitude of the load case")
    legend(axes)
    return axes


@picture.register
def _dissipation_range(found: DissipationRange, ax: AxesArray | None = None) -> AxesArray:
    """Two panels: slip range and work of friction per cycle of the steady states with the least and with the most work found.

    In space a map of each of the two states.
    """
    ends = {"least work found": found.least_state, "most work found": found.most_state}
    if found.least_state.system.tangents == 2:
        panels = new_axes(ax, 2, (FACE[0], 2 * FACE[1]), common_x=False)
        for axes, (name, steady) in zip(panels, ends.items(), strict=True):
            steady_map(steady, axes).set_title(rf"$\lambda = {steady.load_factor:.4g}$: {name}, $W = {steady.dissipation:.4g}$ per cycle")
        return np.array(panels)
    slip, work = panels = new_axes(ax, 2, (6.4, 5.4))
    for number, (name, steady) in enumerate(ends.items()):
        _slip_and_work(slip, work, steady, **line(number), label=name)
    slip.set_title(rf"$\lambda = {found.least_state.load_factor:.4g}$: $W$ from {found.least:.4g} to {found.most:.4g} per cycle found")
    legend(slip)
    label_panels(panels, found.least_state.system)
    return np.array(panels)


def _slip_and_work(above: Axes, below: Axes, steady: SteadyState, **look: Any) -> None:
    """Draw the slip range of the steady cycle, and below the work of friction per cycle."""
    ranges = np.asarray(steady.fretting_table()["slip_range"])
    ranges = np.where(ranges > ROUNDING * np.abs(steady.slip).max(), ranges, 0.0)  # else the picture of a contact at rest is one of rounding
    lines(above, steady.system, ranges, **look, **_DOTS)
    lines(below, steady.system, steady.dissipation_per_node, **look, **_DOTS)
    above.set_ylabel("slip range (length)")
    below.set_ylabel("work of friction per cycle\n(force times length per depth)")


def corners_visited(path: Trajectory) -> str:
    """The label of an axis of time, with the loads of the first corners as far as there is room."""
    names = ", ".join(f"{number}: {name}" for number, name in enumerate(["mean load", *path.cycle.corner_names]))
    return f"corners visited ({names if len(names) <= _LONGEST else '0: mean load'})"


def cycle_lines(axes: Axes, path: Trajectory) -> bool:
    """Label the axis of time, which begins no earlier than the mean load, and draw a line at each of a few whole cycles; whether there are lines."""
    axes.set_xlabel(corners_visited(path))
    if (first := max(0.0, path.time[0])) < path.time[-1]:
        axes.set_xlim(first, path.time[-1])
    corners = len(path.cycle.corners)
    cycles = int(path.time[-1]) // corners
    if not 0 < cycles <= _MOST_LINES:
        return False
    for cycle in range(cycles + 1):
        axes.axvline(cycle * corners, color=GREY, lw=0.5, label="cycles" if cycle == 0 else None)
    return True
