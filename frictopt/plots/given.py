"""Pictures of what is given: a contact system with its bonded pressure, and a load cycle."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..contact import Array, ContactSystem, LoadCycle
from .bodies import finish, spread
from .nodes import label_panels, lines
from .style import BLACK, AxesArray, legend, line, new_axes, picture, series, slanted

_LENGTH = 0.1  # of a normal, over the size of the contact
_MOST_NORMALS = 60
_MOST_TICKS = 12  # corners that have a tick each


@picture.register
def _system(system: ContactSystem, ax: AxesArray | None = None) -> AxesArray:
    """Points with their normals above, below the pressure that each unit load brings to the bonded contact (nodal forces where there is no width).

    In space an axes for each load case, with its pressure as colours.
    """
    width, unit = (np.ones(system.nodes), "force") if system.width is None else (system.width, "force per area")
    few = spread(system.points.T, _MOST_NORMALS)
    arrows = _LENGTH * float(np.ptp(system.points, axis=0).max() or 1.0) * system.normals
    if system.tangents == 2:
        return _in_space(system, width, unit, few, arrows, ax)
    place, pressure = panels = new_axes(ax, 2, (6.4, 5.4), common_x=False)
    place.plot(*system.points.T, linestyle="none", marker=".", markersize=4, color=BLACK, label="node")
    look = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.003, "color": series(0)["color"]}
    place.quiver(*system.points[few].T, *arrows[few].T, **look)
    place.plot([], [], linestyle="none", marker=r"$\uparrow$", markersize=9, color=series(0)["color"], label="normal, into body 1")
    place.update_datalim(system.points + arrows)
    place.margins(0.05)
    place.autoscale_view()
    place.set(xlabel="$x$ (length)", ylabel="$y$ (length)", aspect="equal", adjustable="datalim")
    legend(place)
    for number, (case, (_, p)) in enumerate(system.bonded.items()):
        lines(pressure, system, p / width, label=f"{case} = 1", marker=".", markersize=3, **line(number))
    pressure.set_ylabel(f"bonded pressure\n({unit})" if system.width is not None else "bonded normal force\n(force per depth)")
    label_panels([pressure], system)
    legend(pressure, "load case")
    return np.array(panels)


def _in_space(system: ContactSystem, width: Array, unit: str, few: list[int], arrows: Array, ax: AxesArray | None) -> AxesArray:
    cases, ends = list(system.bonded), np.array([system.points.min(axis=0), system.points.max(axis=0)])
    columns, rows = min(len(cases), 2), -(-len(cases) // 2)
    panels: list[Any] = new_axes(ax, len(cases), (4.8 * columns, 3.2 * rows), common_x=False, in_space=True, columns=columns)
    for axes, case in zip(panels, cases, strict=True):
        values = system.bonded[case][1] / width
        shown = axes.scatter(*system.points.T, c=values, cmap="cividis", s=14, depthshade=False)
        axes.quiver(*system.points[few].T, *arrows[few].T, color=series(0)["color"], linewidth=0.6)
        axes.set_title(f"{case} = 1; arrows: normals into body 1")
        finish(axes, ends, float(np.linalg.norm(arrows[0])))
        axes.figure.colorbar(shown, ax=axes, shrink=0.6, pad=0.12, label=f"bonded {'normal force' if unit == 'force' else 'pressure'} ({unit})")
    return np.array(panels)


@picture.register
def _cycle(cycle: LoadCycle, ax: Axes | None = None) -> Axes:
    """The amplitude of each load case at load factor 1 over the corners, or over their times, and its mean."""
    (axes,) = new_axes(ax)
    loads, count = cycle.at(1.0), len(cycle.corners)
    at: Any = np.arange(count + 1) if cycle.times is None else cycle.times
    loads = (loads[-1], *loads) if cycle.times is None else (*loads, loads[0])[: len(at)]
    for number, case in enumerate(dict.fromkeys(name for load in (cycle.mean, *loads) for name in load)):
        look = series(number)
        values = [load.get(case, 0.0) for load in loads]
        axes.plot(at, values, label=case, **(look if count <= _MOST_TICKS else line(number)))
        axes.axhline(cycle.mean.get(case, 0.0), color=look["color"], lw=0.6, linestyle=":")
    axes.plot([], [], color=BLACK, lw=0.6, linestyle=":", label="mean")
    if cycle.times is not None:
        axes.set_xlabel("time")
    elif count <= _MOST_TICKS:
        axes.set_xlabel("corners in their order")
        names = [cycle.corner_names[corner - 1] for corner in range(count + 1)]
        axes.set_xticks(np.arange(count + 1), names, **slanted(names, "right", "top"))
    else:
        axes.set_xlabel("corners visited")
    axes.set_ylabel("amplitude at load factor 1")
    legend(axes, "load case")
    return axes
