"""Pictures of a contact and of its load cycle."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..plots.draw import draw as draw
from ..plots.style import (
    BESIDE,
    BLACK,
    POINTS,
    AxesArray,
    arrows,
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
from .strip import label_panels, lines
from .system import ContactSystem


@picture.register
def _system(system: ContactSystem, ax: AxesArray | None = None) -> AxesArray:
    """Points with their normals above, below the pressure that each unit load brings to the bonded contact (nodal forces where there is no width).

    In space an axes for each load case, with its pressure as colours.
    """
    force = "force per depth" if system.tangents == 1 else "force"
    width, unit = (
        (1.0, f"bonded normal force\n({force})")
        if system.width is None
        else (system.width, "bonded pressure\n(force per area)")
    )
    few = spread(system.points.T, 60)
    begin, color = system.points[few], series(0)["color"]
    normals = 0.1 * float(np.ptp(system.points, axis=0).max() or 1.0) * system.normals[few]
    if system.tangents == 2:
        count = len(system.bonded)
        panels: list[Any] = new_axes(
            ax,
            count,
            (4.8 * min(count, 2), 3.2 * -(-count // 2)),
            common_x=False,
            in_space=True,
            columns=min(count, 2),
        )
        for axes, (case, (_, p)) in zip(panels, system.bonded.items(), strict=True):
            points = axes.scatter(
                *system.points.T, c=p / width, cmap="cividis", s=14, depthshade=False
            )
            arrows(axes, begin, normals, color=color, linewidth=0.6)
            axes.set_title(f"{case} = 1; arrows: normals into body 1")
            finish_axes(
                axes,
                np.array([system.points.min(axis=0), system.points.max(axis=0)]),
                float(np.linalg.norm(normals[0])),
            )
            axes.figure.colorbar(points, ax=axes, label=unit.replace("\n", " "), **BESIDE)
        return np.array(panels)
    place, pressure = both = new_axes(ax, 2, (6.4, 5.4), common_x=False)
    place.plot(
        *system.points.T, linestyle="none", marker=".", markersize=4, color=BLACK, label="node"
    )
    arrows(place, begin, normals, width=0.003, color=color)
    place.plot(
        [],
        [],
        linestyle="none",
        marker=r"$\uparrow$",
        markersize=9,
        color=color,
        label="normal, into body 1",
    )
    place.margins(0.05)
    place.set(xlabel="$x$ (length)", ylabel="$y$ (length)", aspect="equal", adjustable="datalim")
    legend(place)
    for number, (case, (_, p)) in enumerate(system.bonded.items()):
        lines(pressure, system, p / width, label=f"{case} = 1", **POINTS, **line(number))
    pressure.set_ylabel(unit)
    label_panels([pressure], system)
    legend(pressure, "load case")
    return np.array(both)


_MOST_TICKS = 12  # corners that have a tick each


@picture.register
def _cycle(cycle: LoadCycle, ax: Axes | None = None) -> Axes:
    """The amplitude of each load case at load factor 1 over the corners, or over their times, and its mean."""
    (axes,) = new_axes(ax)
    loads, count = cycle.at(1.0), len(cycle.corners)
    at: Any = np.arange(count + 1) if cycle.times is None else cycle.times
    loads = (loads[-1], *loads) if cycle.times is None else (*loads, loads[0])[: len(at)]
    for number, case in enumerate(
        dict.fromkeys(name for load in (cycle.mean, *loads) for name in load)
    ):
        values = [load.get(case, 0.0) for load in loads]
        axes.plot(
            at, values, label=case, **(series(number) if count <= _MOST_TICKS else line(number))
        )
        axes.axhline(
            cycle.mean.get(case, 0.0), color=series(number)["color"], lw=0.6, linestyle=":"
        )
    axes.plot([], [], color=BLACK, lw=0.6, linestyle=":", label="mean")
    axes.set(
        xlabel="corners visited" if cycle.times is None else "time",
        ylabel="amplitude at load factor 1",
    )
    if cycle.times is None and count <= _MOST_TICKS:
        names = [cycle.corner_names[corner - 1] for corner in range(count + 1)]
        axes.set_xticks(at, names, **slanted(names, "right", "top"))
        axes.set_xlabel("corners in their order")
    legend(axes, "load case")
    return axes
