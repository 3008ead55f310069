"""Values at the nodes of contacts in the plane, along the x axis that all these pictures share."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ..base import RESIDUAL, Array, Booleans
from ..plots.style import BLACK, GREY, POINTS, SERIES, AxesArray, Look, legend, line, slanted
from .components import runs
from .face import face_map
from .law import lengths, most_shear
from .system import ContactSystem


def parts(system: ContactSystem) -> list[tuple[str, slice]]:
    """Name and nodes of each contact, in their order along x."""
    names = system.contact
    return (
        [("", slice(None))]
        if names is None
        else [(str(names[nodes][0]), nodes) for nodes in runs(names)]
    )


def node_at(system: ContactSystem, node: int) -> str:
    """A node by its number and its place."""
    if system.tangents == 1:
        return f"node {node}, $x = {system.x[node]:.4g}$"
    return f"node {node} at ({', '.join(f'{place:.3g}' for place in system.points[node])})"


def lines(
    ax: Axes, system: ContactSystem, values: Array, *, label: str | None = None, **look: Any
) -> None:
    """Draw values of the nodes as lines that do not join one contact to the next."""
    for number, (_, nodes) in enumerate(parts(system)):
        ax.plot(system.x[nodes], values[nodes], label=label if number == 0 else None, **look)


def lines_or_band(
    ax: Axes,
    system: ContactSystem,
    values: Array,
    names: Sequence[str],
    ruling: Sequence[int] = (),
    what: str = "",
    band: str = GREY,
    **more: Any,
) -> dict[int, Look]:
    """Draw (K, N) values as a line for each corner; of more corners than there are looks, the ruling ones as lines and all of them as a band.

    Returns the looks of the lines, by corner.
    """
    drawn: Sequence[int] = range(len(values))
    if len(values) > len(SERIES):
        drawn = sorted(list(dict.fromkeys(ruling))[:4])
        low, high = np.fmin.reduce(values), np.fmax.reduce(values)  # NaN counts where all are
        for number, (_, nodes) in enumerate(parts(system)):
            label = f"{what}all {len(values)} corners" if number == 0 else None
            ax.fill_between(
                system.x[nodes],
                low[nodes],
                high[nodes],
                color=band,
                alpha=0.35,
                lw=0.6,
                label=label,
            )
    looks = {corner: line(number) for number, corner in enumerate(drawn)}
    for corner, look in looks.items():
        lines(
            ax, system, values[corner], label=f"{what}{names[corner]}", **{**look, **POINTS, **more}
        )
    return looks


def label_contacts(ax: Axes, system: ContactSystem, *, names: bool = True) -> None:
    """Label the x axis; where there are several contacts, draw a line between them and name them above."""
    found = parts(system)
    if len(found) == 1:
        ax.set_xlabel("position along the contact, $x$ (length)")
        return
    ax.set_xlabel("position along the contacts, one after the other, $x$ (length)")
    for (_, left), (_, right) in pairwise(found):
        ax.axvline((system.x[left][-1] + system.x[right][0]) / 2, color=BLACK, lw=0.6)
    if names:
        above, labels = ax.secondary_xaxis("top"), [name for name, _ in found]
        above.set_xticks(
            [float(system.x[nodes].mean()) for _, nodes in found],
            labels,
            **slanted(labels, "left", "bottom"),
        )
        above.tick_params(length=0)


def label_panels(panels: Sequence[Axes], system: ContactSystem) -> None:
    """Zero lines of panels one below the other, the names of the contacts above the first one, and the position below the last one."""
    for axes in panels:
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        label_contacts(axes, system, names=axes is panels[0])
    for axes in panels[:-1]:
        axes.set_xlabel("")


def work_label(system: ContactSystem) -> str:
    """Name of the axis of the work of friction per cycle."""
    return (
        f"work of friction per cycle\n(force times length{' per depth' * (system.tangents == 1)})"
    )


def friction_bounds(ax: Axes, of: str = "(f p)") -> None:
    """Draw the bounds of q over the shear that friction holds."""
    ax.axhline(-1.0, color=GREY, lw=0.8)
    ax.axhline(1.0, color=GREY, lw=0.8, label=r"friction bound $\pm 1$")
    ax.set_ylabel(rf"$q / {of}$")


def ratios(shear: Array, bound: Array) -> Array:
    """Shear over its friction bound; NaN where a node bears nothing but rounding."""
    return np.asarray(
        np.divide(
            shear,
            bound,
            out=np.full(shear.shape, np.nan),
            where=bound > RESIDUAL * np.abs(bound).max(),
        )
    )


def circle(
    ax: Axes,
    x: ArrayLike,
    ratio: ArrayLike,
    sense: ArrayLike,
    area: ArrayLike,
    color: str,
    label: str | None,
) -> None:
    """Circle nodes at q / (f p); where that is not defined, at the bound of their sense of slip."""
    places = np.where(np.isfinite(ratio), ratio, np.negative(sense))
    ax.scatter(
        x,
        places,
        s=area,
        facecolors="none",
        edgecolors=color,
        linewidths=1.2,
        zorder=3,
        label=label,
    )


def open_marks(ax: Axes, x: Array, label: str, **look: Any) -> None:
    """Mark nodes that are open, and carry nothing, at zero."""
    if len(x):
        ax.scatter(x, np.zeros(len(x)), marker="v", s=20, zorder=3, label=label, **look)


Circles: TypeAlias = dict[
    int, tuple[Any, Any, Any]
]  # by corner: nodes that limit the load, their senses of slip, areas of their circles
ONE_NODE = 60  # of the circle round a node that stands alone
INSIDE: Look = {"color": "#56B4E9", "alpha": 0.25, "lw": 0, "label": "some residual slip is safe"}


def shear_ratios(
    panels: Sequence[Axes],
    system: ContactSystem,
    friction: Array,
    q: Array,
    p: Array,
    names: Sequence[str],
    circles: Circles,
    what: str = "",
    at: int = 0,
    slip: Array | None = None,
    opened: Booleans | None = None,
) -> Axes | AxesArray:
    """Shear over friction bound of reactions at K corners, with circles at some of them; of many corners, those with the largest circles.

    Where the bound is zero up to rounding, no ratio is drawn. In space maps of the corner `at`,
    with the circles of all, and the slip as arrows.
    """
    bound, of = most_shear(system, friction, p), r"\min(f p, c)" if system.capped else "(f p)"
    if slip is not None:
        slip = slip / system.stretch
    if system.tangents == 2:
        ratio = ratios(lengths(q[at], p[at]), bound[at])
        largest = float(np.nanmax(ratio, initial=0.0))
        most, name = largest if largest > 1.0 + RESIDUAL else 1.0, rf"$|q| / {of}$ at {names[at]}"
        areas = np.zeros(system.nodes)
        for nodes, _, area in circles.values():
            np.add.at(areas, np.ravel(nodes), area)
        circled = (areas, what) if circles else None
        return face_map(
            panels,
            system,
            ratio,
            name,
            most=most,
            slip=slip,
            slip_name="residual slip",
            opened=opened,
            circled=circled,
        )
    (axes,), ratio, label = panels, ratios(q, bound), what or None
    friction_bounds(axes, of)
    ruling = sorted(circles, key=lambda corner: -float(np.sum(circles[corner][2]))) or [at]
    for corner, look in lines_or_band(axes, system, ratio, names, ruling).items():
        if corner in circles:
            nodes, senses, areas = circles[corner]
            circle(axes, system.x[nodes], ratio[corner, nodes], senses, areas, look["color"], label)
            label = None
    most = np.clip(
        1.1 * float(np.nanmax(np.abs(ratio), initial=0.0)), 1.25, 3.0
    )  # beyond, nodes with almost no pressure would hide all others
    axes.set_ylim(-most, most)
    label_contacts(axes, system)
    if opened is not None:
        open_marks(axes, system.x[opened], "open", color=BLACK)
    legend(axes)
    return axes
