"""Loops of shear force against slip, and what else the pictures of a transient share."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ..contact.checks import Array
from ..fem.ordering import Integers
from ..transients import Trajectory
from .style import GREY, line, series

_NODES = 3  # nodes whose loops are drawn
_LONGEST = 60  # characters of the names of corners beside an axis
_MOST_LINES = 50  # cycles of which each has its own line


def most_work(path: Trajectory) -> Integers:
    """The nodes with the most work of friction, first the one with the most."""
    return np.argsort(-path.work[-1], kind="stable")[:_NODES]


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
