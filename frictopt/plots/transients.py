"""Pictures of transients: their loops, their history, and what is left of them in the steady state."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..contact import ROUNDING, SIMULTANEOUS, Array
from ..histories.dissipation_range import DissipationRange
from ..transients import LoadLoop, SteadyState, Trajectory
from .along import label_panels, lines, lines_or_band, node_at
from .spatial import steady_map
from .style import BLACK, FACE, GREY, AxesArray, Look, legend, line, new_axes, picture, series

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
        loops(axes, slip[..., axis], q[..., axis], names)
        axes.set(xlabel=f"slip $v{number}$ (length)", ylabel=f"shear force $q{number}$ (force{per_depth})")
        for node, values in enumerate(slip[..., axis].T):
            below.plot(path.time, values, color=series(node)["color"], linestyle=series(node if tangents == 1 else axis)["linestyle"])
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


def loops(axes: Axes, slip: Array, force: Array, names: Sequence[str]) -> None:
    """Draw (T, M) forces against slips, each node with a mark at its last state."""
    for number, name in enumerate(names):
        axes.plot(slip[:, number], force[:, number], label=name, **line(number))
        last = "last state" if number == 0 else None
        axes.plot(slip[-1:, number], force[-1:, number], color=series(number)["color"], marker="o", markersize=4, label=last)


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
