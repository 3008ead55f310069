"""What each node does over a transient: a picture over place and time, and an animation."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ..contact import Array, Integers, shown, whole_number
from ..contact.files import output
from ..transients import Trajectory
from .along import label_contacts, parts
from .spatial import arrows, places_of
from .style import BLACK, GREY, SERIES, equals, name_units, new_axes, one_axes, screen
from .transients import corners_visited

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
    places, labels, _ = places_of(states.system)
    axes.scatter(places[:, 0], places[:, 1], c=colours, edgecolors=GREY, linewidths=0.4, s=60)
    arrows(axes, places, q[frame], q, width=0.005)
    axes.set(xlabel=f"{labels[0]} (length)", ylabel=f"{labels[1]} (length)", aspect="equal")
    axes.margins(0.1)
    axes.legend(handles=_patches(2, states.status), loc="upper left", bbox_to_anchor=(1.0, 1.02), title="arrows: shear")
