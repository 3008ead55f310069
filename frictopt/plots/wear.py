"""Pictures of wear: profiles over the cycles, and the work of friction as it changes."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ..histories.wear_history import WearHistory
from ..histories.worn_in import WornIn
from .along import label_contacts, label_panels, lines
from .picture import picture
from .spatial import face_map
from .style import BLACK, FACE, AxesArray, legend, line, new_axes, one_axes, series

_DEPTH = "depth worn off (length)"
_PROFILES = 6  # contacts whose profiles are drawn


@picture.register
def _wear(history: WearHistory, ax: AxesArray | None = None) -> AxesArray:
    """Three panels: depth worn off and pressure along the contact after some numbers of cycles; work of friction per cycle against cycles.

    In space two: a map of the depth in the end, and the work of friction per cycle.
    """
    table, system = history.to_frame(), history.system
    if system.tangents == 2:
        face, work = panels = new_axes(ax, 2, (FACE[0], 2 * FACE[1]), common_x=False)
        face_map(face, system, history.depth[-1], _DEPTH)
        face.set_title(f"depth worn off after {table['cycles'].iloc[-1]:.4g} cycles")
    else:
        depth, pressure, work = panels = new_axes(ax, 3, (6.4, 8.4), common_x=False)
        for number, row in enumerate(_chosen(history)):
            look = {**line(number), "label": f"{table['cycles'][row]:.4g}"}
            lines(depth, system, history.depth[row], **look)
            lines(pressure, system, history.pressure[row], **look)
        depth.set_ylabel(_DEPTH)
        pressure.set_ylabel("pressure at the last corner\n(force per area)")
        legend(depth, "cycles")
        label_panels([depth, pressure], system)
    work.plot(table["cycles"], table["work"], color=BLACK, marker=".", markersize=3)
    per_depth = " per depth" if system.tangents == 1 else ""
    work.set(xlabel="load cycles", ylabel=f"work of friction per cycle\n(force times length{per_depth})", ylim=(0.0, None))
    return np.array(panels)


@picture.register
def _worn_in(end: WornIn, ax: Axes | AxesArray | None = None) -> Axes:
    """Depth worn off along the contact, and the nodes that never slip; in space a map of the depth."""
    system = end.system
    axes = one_axes(ax, system.tangents)
    axes.set_title(f"worn in: {int(end.stick.sum())} of {system.nodes} nodes never slip")
    if system.tangents == 2:
        return face_map(axes, system, end.depth, _DEPTH)
    lines(axes, system, end.depth, color=BLACK, label="depth worn off")
    lines(axes, system, np.where(end.stick, 0.0, np.nan), color=series(0)["color"], lw=3.0, label="never slips")
    axes.set_ylabel(_DEPTH)
    label_contacts(axes, system)
    legend(axes)
    return axes


def _chosen(history: WearHistory) -> NDArray[np.intp]:
    """Rows at about even steps of the largest depth, the first and the last one among them."""
    largest = history.depth.max(axis=1)
    between = [np.abs(largest - part).argmin() for part in np.linspace(0.0, largest[-1], _PROFILES)[:-1]]
    return np.unique([*between, len(largest) - 1])
