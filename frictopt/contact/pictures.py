"""Pictures of a contact and of its load cycle."""

from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..base import Array
from ..plots.draw import draw as draw
from ..plots.style import (
    BESIDE,
    BLACK,
    POINTS,
    AxesArray,
    arrows,
    as_is,
    finish_axes,
    legend,
    line,
    new_axes,
    picture,
    series,
    slanted,
    spread,
)
from .cycle import LoadCycle
from .strip import force_unit, label_panels, lines
from .system import ContactSystem

# Largest number of corners of a cycle that each have a tick.
_NUMBER_OF_TICKS = 12


@picture.register
def _system(system: ContactSystem, ax: AxesArray | None = None) -> AxesArray:
    """The points of a contact with their normals, and the pressures of the load cases.

    The pressures are those of the bonded contact under each unit load. If the widths are not known,
    nodal forces are drawn. In space each load case has a panel, with its pressure as colours.
    """
    # More normals would hide each other.
    most_normals = 60
    drawn = spread(system.points.T, most_normals)
    # The normals are a tenth of the size of the contact.
    length = 0.1 * float(np.ptp(system.points, axis=0).max() or 1.0)
    places = system.points[drawn]
    normals = length * system.normals[drawn]
    if system.tangents == 2:
        return _system_in_space(system, places, normals, ax)
    return _system_in_plane(system, places, normals, ax)


def _pressures(system: ContactSystem) -> tuple[dict[str, Array], str]:
    """Pressure of each unit load on the bonded contact, and its name with its unit."""
    if system.width is None:
        forces = {case: p for case, (_, p) in system.bonded.items()}
        return forces, f"bonded normal force\n{force_unit(system.per_depth)}"
    pressures = {case: p / system.width for case, (_, p) in system.bonded.items()}
    return pressures, "bonded pressure\n(force per area)"


def _system_in_space(
    system: ContactSystem, places: Array, normals: Array, ax: AxesArray | None
) -> AxesArray:
    pressures, name = _pressures(system)
    columns = min(len(pressures), 2)
    size = (4.8 * columns, 3.2 * ceil(len(pressures) / 2))
    panels: list[Any] = new_axes(
        ax, len(pressures), size, common_x=False, in_space=True, columns=columns
    )
    ends = np.array([system.points.min(axis=0), system.points.max(axis=0)])
    for axes, (case, pressure) in zip(panels, pressures.items(), strict=True):
        points = axes.scatter(*system.points.T, c=pressure, cmap="cividis", s=14, depthshade=False)
        arrows(axes, places, normals, color=series(0)["color"], linewidth=0.6)
        axes.set_title(f"{as_is(case)} = 1; arrows: normals into body 1")
        finish_axes(axes, ends, float(np.linalg.norm(normals[0])))
        axes.figure.colorbar(points, ax=axes, label=name.replace("\n", " "), **BESIDE)
    return np.array(panels)


def _system_in_plane(
    system: ContactSystem, places: Array, normals: Array, ax: AxesArray | None
) -> AxesArray:
    panels = new_axes(ax, 2, (6.4, 5.4), common_x=False)
    upper, lower = panels
    color = series(0)["color"]
    nodes: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 4, "color": BLACK}
    upper.plot(*system.points.T, label="node", **nodes)
    arrows(upper, places, normals, width=0.003, color=color)
    arrow: dict[str, Any] = {"linestyle": "none", "marker": r"$\uparrow$", "markersize": 9}
    upper.plot([], [], color=color, label="normal, into body 1", **arrow)
    upper.margins(0.05)
    upper.set(xlabel="$x$ (length)", ylabel="$y$ (length)", aspect="equal", adjustable="datalim")
    legend(upper)

    pressures, name = _pressures(system)
    for number, (case, pressure) in enumerate(pressures.items()):
        look = {**POINTS, **line(number, len(pressures))}
        lines(lower, system, pressure, label=f"{as_is(case)} = 1", **look)
    lower.set_ylabel(name)
    label_panels([lower], system)
    legend(lower, "load case")
    return np.array(panels)


@picture.register
def _cycle(cycle: LoadCycle, ax: Axes | None = None) -> Axes:
    """The amplitude of each load case at load factor 1 over the corners or their times."""
    (axes,) = new_axes(ax)
    count = len(cycle.corners)
    corners = cycle.at(1.0)
    if cycle.times is None:
        # The cycle begins and ends at its last corner.
        places: Any = np.arange(count + 1)
        loads = (corners[-1], *corners)
    else:
        places = cycle.times
        loads = (*corners, corners[0])[: len(places)]

    cases = dict.fromkeys(name for load in (cycle.mean, *loads) for name in load)
    for number, case in enumerate(cases):
        amplitudes = [load.get(case, 0.0) for load in loads]
        look = (series if count <= _NUMBER_OF_TICKS else line)(number, len(cases))
        axes.plot(places, amplitudes, label=as_is(case), **look)
        mean = cycle.mean.get(case, 0.0)
        axes.axhline(mean, color=look["color"], lw=0.6, linestyle=":")
    axes.plot([], [], color=BLACK, lw=0.6, linestyle=":", label="mean")

    axes.set_ylabel("amplitude at load factor 1")
    if cycle.times is not None:
        axes.set_xlabel("time")
    elif count > _NUMBER_OF_TICKS:
        axes.set_xlabel("corners visited")
    else:
        axes.set_xlabel("corners in their order")
        names = [as_is(cycle.corner_names[corner - 1]) for corner in range(count + 1)]
        axes.set_xticks(places, names, **slanted(names, "right", "top"))
    legend(axes, "load case")
    return axes
