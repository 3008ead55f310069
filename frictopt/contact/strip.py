"""Values at the nodes of contacts in the plane, along the x axis that all these pictures share."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ..base import RESIDUAL, Array, Booleans
from ..plots.style import BLACK, GREY, POINTS, SERIES, AxesArray, Look, as_is, legend, line, slanted
from .components import runs
from .diagnosis import in_contact
from .face import face_map
from .law import lengths, most_shear
from .system import ContactSystem

Circles: TypeAlias = dict[int, tuple[Any, Any, Any]]
"""Corner -> nodes that limit the load there, their senses of slip, and areas of their circles."""

ONE_NODE = 60
"""Area of the circle round a node that limits the load by itself, points^2."""

INSIDE: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0, "label": "some residual slip is safe"}


def parts(system: ContactSystem) -> list[tuple[str, slice]]:
    """Name and nodes of each contact, in their order along x."""
    names = system.contact
    if names is None:
        return [("", slice(None))]
    return [(str(names[nodes][0]), nodes) for nodes in runs(names)]


def node_at(system: ContactSystem, node: int) -> str:
    """Text with the number and the place of a node."""
    name = f"node {node}{as_is(in_contact(system, node))}"
    if system.tangents == 1:
        return f"{name}, $x = {system.x[node]:.4g}$"
    place = ", ".join(f"{coordinate:.3g}" for coordinate in system.points[node])
    return f"{name} at ({place})"


def lines(
    ax: Axes, system: ContactSystem, values: Array, *, label: str | None = None, **look: Any
) -> None:
    """Draw values of the nodes as one line for each contact."""
    for number, (_, nodes) in enumerate(parts(system)):
        ax.plot(system.x[nodes], values[nodes], label=label if number == 0 else None, **look)


def lines_or_band(
    ax: Axes,
    system: ContactSystem,
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
        drawn = sorted(list(dict.fromkeys(governing))[:4])
        _draw_band(ax, system, values, f"{prefix}all {len(values)} corners", band)
    looks = {corner: line(number) for number, corner in enumerate(drawn)}
    for corner, look in looks.items():
        style = {**look, **POINTS, **look_of_lines}
        lines(ax, system, values[corner], label=f"{prefix}{names[corner]}", **style)
    return looks


def _draw_band(ax: Axes, system: ContactSystem, values: Array, label: str, color: str) -> None:
    """Fill between the smallest and the largest of (K, N) values."""
    # NaN at a node only if all its values are NaN.
    low = np.fmin.reduce(values)
    high = np.fmax.reduce(values)
    look: Look = {"color": color, "alpha": 0.35, "lw": 0.6}
    for number, (_, nodes) in enumerate(parts(system)):
        name = label if number == 0 else None
        ax.fill_between(system.x[nodes], low[nodes], high[nodes], label=name, **look)


def label_contacts(ax: Axes, system: ContactSystem, *, names: bool = True) -> None:
    """Label the x axis; draw lines between several contacts, and write their names above."""
    contacts = parts(system)
    if len(contacts) == 1:
        ax.set_xlabel("position along the contact, $x$ (length)")
        return
    ax.set_xlabel("position along the contacts, one after the other, $x$ (length)")
    for (_, before), (_, after) in pairwise(contacts):
        ax.axvline((system.x[before][-1] + system.x[after][0]) / 2, color=BLACK, lw=0.6)
    if names:
        labels = [as_is(name) for name, _ in contacts]
        middles = [float(system.x[nodes].mean()) for _, nodes in contacts]
        above = ax.secondary_xaxis("top")
        above.set_xticks(middles, labels, **slanted(labels, "left", "bottom"))
        above.tick_params(length=0)


def label_panels(panels: Sequence[Axes], system: ContactSystem) -> None:
    """Label panels that stand one below the other.

    Each panel gets a zero line. The names of the contacts stand above the first panel, the position
    below the last one.
    """
    for axes in panels:
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        label_contacts(axes, system, names=axes is panels[0])
    for axes in panels[:-1]:
        axes.set_xlabel("")


def force_unit(per_depth: bool) -> str:
    """Unit of a force: per depth in plane strain and stress."""
    return "(force per depth)" if per_depth else "(force)"


def stiffness_unit(per_depth: bool) -> str:
    """Unit of a force over a length: per depth in plane strain and stress."""
    return "(force per depth per length)" if per_depth else "(force per length)"


def work_unit(per_depth: bool) -> str:
    """Unit of a work: per depth in plane strain and stress."""
    return "(force times length per depth)" if per_depth else "(force times length)"


def work_label(system: ContactSystem) -> str:
    """Name of the axis of the work of friction per cycle."""
    return f"work of friction per cycle\n{work_unit(system.per_depth)}"


def friction_bounds(ax: Axes, bound: str = "(f p)") -> None:
    """Draw the bounds of the ratio of q to its friction bound."""
    ax.axhline(-1.0, color=GREY, lw=0.8)
    ax.axhline(1.0, color=GREY, lw=0.8, label=r"friction bound $\pm 1$")
    ax.set_ylabel(rf"$q / {bound}$")


def ratios(shear: Array, bound: Array) -> Array:
    """Shear divided by its friction bound; NaN if the bound is zero up to rounding."""
    ratio = np.full(shear.shape, np.nan)
    bears = bound > RESIDUAL * np.abs(bound).max()
    return np.asarray(np.divide(shear, bound, out=ratio, where=bears))


def circle(
    ax: Axes,
    x: ArrayLike,
    ratio: ArrayLike,
    sense: ArrayLike,
    area: ArrayLike,
    color: str,
    label: str | None,
) -> None:
    """Draw circles round nodes at q / (f p); if that is NaN, at the bound opposed to their slip."""
    places = np.where(np.isfinite(ratio), ratio, np.negative(sense))
    look: Look = {"facecolors": "none", "edgecolors": color, "linewidths": 1.2, "zorder": 3}
    ax.scatter(x, places, s=area, label=label, **look)


def open_marks(ax: Axes, x: Array, label: str, **look: Any) -> None:
    """Mark open nodes, which carry nothing, at zero."""
    if len(x):
        ax.scatter(x, np.zeros(len(x)), marker="v", s=20, zorder=3, label=label, **look)


def shear_ratios(
    panels: Sequence[Axes],
    system: ContactSystem,
    friction: Array,
    q: Array,
    p: Array,
    names: Sequence[str],
    circles: Circles,
    circles_label: str = "",
    at: int = 0,
    slip: Array | None = None,
    opened: Booleans | None = None,
) -> Axes | AxesArray:
    """Draw shear over friction bound of the reactions at K corners, with circles at some nodes.

    No ratio is drawn where the bound is zero up to rounding. In the plane all corners are drawn, or
    those with the largest circles if there are many. In space maps show the corner `at`, with the
    circles of all corners, and the slip as arrows.
    """
    bound = most_shear(system, friction, p)
    bound_name = r"\min(f p, c)" if system.capped else "(f p)"
    if system.tangents == 2:
        ratio = ratios(lengths(q[at], p[at]), bound[at])
        name = rf"$|q| / {bound_name}$ at {names[at]}"
        return _map_of_ratios(panels, system, ratio, name, circles, circles_label, slip, opened)

    (axes,) = panels
    friction_bounds(axes, bound_name)
    ratio = ratios(q, bound)
    governing = sorted(circles, key=lambda corner: -float(np.sum(circles[corner][2]))) or [at]
    looks = lines_or_band(axes, system, ratio, names, governing)
    label = circles_label or None
    for corner, look in looks.items():
        if corner in circles:
            nodes, senses, areas = circles[corner]
            places = ratio[corner, nodes]
            circle(axes, system.x[nodes], places, senses, areas, look["color"], label)
            label = None
    # The axis ends at 3, or a node with almost no pressure would flatten all other lines.
    largest = 1.1 * float(np.nanmax(np.abs(ratio), initial=0.0))
    height = np.clip(largest, 1.25, 3.0)
    axes.set_ylim(-height, height)
    label_contacts(axes, system)
    if opened is not None:
        open_marks(axes, system.x[opened], "open", color=BLACK)
    legend(axes)
    return axes


def _map_of_ratios(
    panels: Sequence[Axes],
    system: ContactSystem,
    ratio: Array,
    name: str,
    circles: Circles,
    circles_label: str,
    slip: Array | None,
    opened: Booleans | None,
) -> Axes | AxesArray:
    """Maps of ratios (N,) in space, with the areas of all circles of a node added."""
    largest = float(np.nanmax(ratio, initial=0.0))
    if largest <= 1.0 + RESIDUAL:
        largest = 1.0
    areas = np.zeros(system.nodes)
    for nodes, _, area in circles.values():
        np.add.at(areas, np.ravel(nodes), area)
    return face_map(
        panels,
        system,
        ratio,
        name,
        most=largest,
        slip=None if slip is None else slip / system.stretch,
        slip_name="residual slip",
        opened=opened,
        circled=(areas, circles_label) if circles else None,
    )
