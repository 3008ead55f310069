"""Pictures of transients: their loops, their history, and what is left of them in the steady state."""

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import SIMULTANEOUS
from ..histories import DissipationRange
from ..transients import SteadyState, Trajectory, fretting_table, steady_cycle
from .along import label_contacts, lines, lines_or_band
from .loops import cycle_lines, loops, most_work, work_title
from .picture import picture
from .style import BLACK, GREY, AxesArray, Look, legend, new_axes, series

__all__: list[str] = []

_DOTS: Look = {"marker": ".", "markersize": 3}
_LOOKS: dict[str, Look] = {"q": {"band": series(0)["color"]}, "p": {"band": series(1)["color"], "lw": 0.5, "alpha": 0.8}}
_SLIP_RANGE, _WORK = "slip range (length)", "work of friction per cycle\n(force times length per depth)"


@picture.register
def _trajectory(path: Trajectory, ax: AxesArray | None = None) -> AxesArray:
    """Two panels, for the nodes with the most work of friction: shear force against slip, and slip against the corners visited."""
    upper, lower = new_axes(ax, 2, (6.4, 6.4), common_x=False)
    nodes = most_work(path)
    loops(upper, path.slip[:, nodes], path.q[:, nodes], [f"node {node}, $x = {path.system.x[node]:.4g}$" for node in nodes])
    upper.set(xlabel="slip $v$ (length)", ylabel="shear force $q$ (force per depth)", title=work_title(path))
    legend(upper)
    for number, node in enumerate(nodes):
        lower.plot(path.time, path.slip[:, node], color=series(number)["color"], linestyle=series(number)["linestyle"])
    if cycle_lines(lower, path):
        legend(lower)
    lower.set_ylabel("slip $v$ (length)")
    return np.array([upper, lower])


@picture.register
def _steady_state(steady: SteadyState, ax: AxesArray | None = None) -> AxesArray:
    """Three panels: slip range of the steady cycle; tractions at its corners (nodal forces where there is no width); work of friction per cycle."""
    slip, force, work = panels = new_axes(ax, 3, (6.4, 7.6))
    system = steady.system
    problem = system, steady.cycle, steady.friction, steady.load_factor, steady
    slip.set_title(f"{steady.outcome.name.replace('_', ' ').lower()}, $W = {steady.dissipation:.4g}$ per cycle")
    lines(slip, system, _slip_range(steady), color=BLACK, **_DOTS)
    slip.set_ylabel(_SLIP_RANGE)
    states = steady_cycle(*problem)
    count = len(steady.cycle.corners)
    corners = np.searchsorted(states["time"], np.arange(1, count * steady.period + 1) + SIMULTANEOUS) - 1
    names = [f"corner {corner % count}{', second cycle' if corner >= count else ''}" for corner in range(len(corners))]
    width, unit = (1.0, "nodal force\n(force per depth)") if system.width is None else (system.width, "traction\n(force per area)")
    for name, look in _LOOKS.items():
        lines_or_band(force, system, states[name][corners] / width, [f"${name}$, {corner}" for corner in names], **look)
    force.set_ylabel(unit)
    legend(force)
    lines(work, system, steady.dissipation_per_node, color=BLACK, **_DOTS)
    work.set_ylabel(_WORK)
    for axes in panels:
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        label_contacts(axes, system, names=axes is slip)
    for axes in panels[:2]:
        axes.set_xlabel("")
    if ax is None:
        slip.figure.align_ylabels()
    return np.array(panels)


@picture.register
def _dissipation_range(found: DissipationRange, ax: AxesArray | None = None) -> AxesArray:
    """Two panels: slip range and work of friction per cycle of the steady states with the least and with the most work found."""
    slip, work = panels = new_axes(ax, 2, (6.4, 5.4))
    system = found.least_state.system
    for number, (name, steady) in enumerate((("least work found", found.least_state), ("most work found", found.most_state))):
        look = {"color": series(number)["color"], "linestyle": series(number)["linestyle"], "label": name, **_DOTS}
        lines(slip, system, _slip_range(steady), **look)
        lines(work, system, steady.dissipation_per_node, **look)
    slip.set_title(rf"$\lambda = {found.least_state.load_factor:.4g}$: $W$ from {found.least:.4g} to {found.most:.4g} per cycle found")
    slip.set_ylabel(_SLIP_RANGE)
    work.set_ylabel(_WORK)
    legend(slip)
    for axes in panels:
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        label_contacts(axes, system, names=axes is slip)
    slip.set_xlabel("")
    if ax is None:
        slip.figure.align_ylabels()
    return np.array(panels)


def _slip_range(steady: SteadyState) -> Array:
    """(N,) slip range of the steady cycle."""
    table = fretting_table(steady.system, steady.cycle, steady.friction, steady.load_factor, steady)
    return np.asarray(table["slip_range"])
