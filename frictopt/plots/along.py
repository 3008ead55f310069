"""Values at the nodes of contacts in the plane, along the x axis that all these pictures share."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes

from ..base import Array, runs
from .style import BLACK, GREY, POINTS, SERIES, Look, as_is, legend, line

# A contact system: the places `x` (N,) of its nodes along the contacts, and their `contact`.
Nodes: TypeAlias = Any


def parts(nodes: Nodes) -> list[tuple[str, slice]]:
    """Name and nodes of each contact, in their order along x."""
    names = nodes.contact
    if names is None:
        return [("", slice(None))]
    return [(str(names[run.start]), run) for run in runs(names)]


def lines(ax: Axes, nodes: Nodes, values: Array, *, label: str | None = None, **look: Any) -> None:
    """Draw values of the nodes as one line for each contact."""
    for _, part in parts(nodes):
        ax.plot(nodes.x[part], values[part], label=label, **look)
        label = None


def lines_or_band(
    ax: Axes,
    nodes: Nodes,
    values: Array,
    names: Sequence[str],
    governing: Sequence[int] = (),
    prefix: str = "",
    band: str = GREY,
    **look_of_lines: Any,
) -> dict[int, Look]:
    """Draw (K, N) values as a line for each corner, and return the looks of the lines, by corner.

    If there are more corners than looks, up to four `governing` corners are lines, and a band spans
    all corners. `prefix` is put before the names of the corners.
    """
    drawn: Sequence[int] = range(len(values))
    if len(values) > len(SERIES):
        drawn = sorted(governing[:4])
        label: str | None = f"{prefix}all {len(values)} corners"
        # NaN at a node only if all its values are NaN.
        low, high = np.fmin.reduce(values), np.fmax.reduce(values)
        for _, part in parts(nodes):
            ax.fill_between(
                nodes.x[part], low[part], high[part], color=band, alpha=0.35, lw=0.6, label=label
            )
            label = None
    looks = {corner: line(number) for number, corner in enumerate(drawn)}
    for corner, look in looks.items():
        style = {**look, **POINTS, **look_of_lines}
        lines(ax, nodes, values[corner], label=f"{prefix}{names[corner]}", **style)
    return looks


def along(
    panels: Sequence[Axes],
    nodes: Nodes,
    rows: Sequence[tuple[str, Mapping[str, Array]] | None],
) -> None:
    """Draw a panel for each row: the name of its axis, and values (N,) by their labels.

    Each panel has a line at 0. A row that is None belongs to a panel that is already drawn.
    """
    for axes, row in zip(panels, rows, strict=True):
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        if row is None:
            continue
        name, values = row
        axes.set_ylabel(name)
        for number, (label, of_nodes) in enumerate(values.items()):
            look = line(number, len(values)) if len(values) > 1 else {"color": BLACK}
            lines(axes, nodes, of_nodes, label=label or None, **look, **POINTS)
        if any(values):
            legend(axes)
    label_panels(panels, nodes)


def label_panels(panels: Sequence[Axes], nodes: Nodes) -> None:
    """Label panels that stand one below the other, with lines between several contacts.

    The names of the contacts stand above the first panel, the position below the last one.
    """
    contacts = parts(nodes)
    for axes in panels:
        for (_, before), (_, after) in pairwise(contacts):
            axes.axvline((nodes.x[before][-1] + nodes.x[after][0]) / 2, color=BLACK, lw=0.6)
    if len(contacts) == 1:
        panels[-1].set_xlabel("position along the contact, $x$ (length)")
        return
    panels[-1].set_xlabel("position along the contacts, one after the other, $x$ (length)")
    labels = [as_is(name) for name, _ in contacts]
    middles = [float(nodes.x[part].mean()) for _, part in contacts]
    above = panels[0].secondary_xaxis("top")
    # Names that do not fit on one line of characters are slanted.
    slanted: Look = {"rotation": 50, "rotation_mode": "anchor", "ha": "left", "va": "bottom"}
    above.set_xticks(middles, labels, **slanted if len("".join(labels)) > 60 else {})
    above.tick_params(length=0)


def friction_bounds(ax: Axes, bound: str = "(f p)") -> None:
    """Draw the bounds of the ratio of q to its friction bound."""
    ax.axhline(-1.0, color=GREY, lw=0.8)
    ax.axhline(1.0, color=GREY, lw=0.8, label=r"friction bound $\pm 1$")
    ax.set_ylabel(rf"$q / {bound}$")
