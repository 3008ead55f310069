"""Values along the contacts: the x axis that all pictures of nodes share."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ..contact import RESIDUAL, Array, ContactSystem
from ..contact.parts import runs
from .style import BLACK, GREY, SERIES, Look, series

Part = tuple[str, slice]
_MOST_RULING = 4  # of many corners, those with a line
_MOST_RATIO = 3.0  # of the vertical axis: nodes with almost no pressure would hide all others


def parts(system: ContactSystem) -> list[Part]:
    """Name and nodes of each contact, in their order along x."""
    names = system.contact
    if names is None:
        return [("", slice(None))]
    return [(str(names[nodes][0]), nodes) for nodes in runs(names)]


def node_at(system: ContactSystem, node: int) -> str:
    """A node by its number and its place."""
    if system.tangents == 1:
        return f"node {node}, $x = {system.x[node]:.4g}$"
    return f"node {node} at ({', '.join(f'{place:.3g}' for place in system.points[node])})"


def lines(ax: Axes, system: ContactSystem, values: Array, *, label: str | None = None, **look: Any) -> None:
    """Draw values of the nodes as lines that do not join one contact to the next."""
    for _, nodes in parts(system):
        ax.plot(system.x[nodes], values[nodes], label=label, **look)
        label = None


def lines_or_band(
    ax: Axes, system: ContactSystem, values: Array, names: Sequence[str], ruling: Sequence[int] = (), band: str = GREY, **more: Any
) -> None:
    """Draw (K, N) values as a line for each corner; of more corners than there are looks, the ruling ones as lines and all of them as a band."""
    if len(values) > len(SERIES):
        label: str | None = f"{names[0].partition(',')[0] + ', ' if names[0].startswith('$') else ''}all {len(values)} corners"
        known = np.isfinite(values)
        low, high = (np.where(known.any(axis=0), end(values, axis=0, where=known, initial=start), np.nan) for end, start in _ENDS)
        for _, nodes in parts(system):
            ax.fill_between(system.x[nodes], low[nodes], high[nodes], color=band, alpha=0.35, lw=0.6, label=label)
            label = None
    for corner, look in looks(len(values), ruling).items():
        own = {"color": look["color"], "linestyle": look["linestyle"], "marker": ".", "markersize": 3, **more}
        lines(ax, system, values[corner], label=names[corner], **own)


_ENDS = (np.min, np.inf), (np.max, -np.inf)


def looks(corners: int, ruling: Sequence[int] = ()) -> dict[int, Look]:
    """Look of each corner that has a line of its own: all, or of more than there are looks the first ruling ones."""
    drawn = range(corners) if corners <= len(SERIES) else sorted(list(dict.fromkeys(ruling))[:_MOST_RULING])
    return {corner: series(number) for number, corner in enumerate(drawn)}


def label_contacts(ax: Axes, system: ContactSystem, *, names: bool = True) -> None:
    """Label the x axis; where there are several contacts, draw a line between them and name them above."""
    found = parts(system)
    ax.set_xlabel("position along the contact, $x$ (length)" if len(found) == 1 else "position along the contacts, one after the other, $x$ (length)")
    if len(found) > 1:
        if names:
            above = ax.secondary_xaxis("top")
            above.set_xticks([float(system.x[nodes].mean()) for _, nodes in found], [name for name, _ in found])
            above.tick_params(length=0)
        for (_, left), (_, right) in pairwise(found):
            ax.axvline((system.x[left][-1] + system.x[right][0]) / 2, color=BLACK, lw=0.6)


def label_panels(panels: Sequence[Axes], system: ContactSystem) -> None:
    """Zero lines of panels one below the other, the names of the contacts above the first one, and the position below the last one."""
    for axes in panels:
        axes.axhline(0, color=GREY, lw=0.6, zorder=0)
        label_contacts(axes, system, names=axes is panels[0])
    for axes in panels[:-1]:
        axes.set_xlabel("")


def friction_bounds(ax: Axes) -> None:
    """Draw the bounds of q / (f p)."""
    ax.axhline(-1.0, color=GREY, lw=0.8)
    ax.axhline(1.0, color=GREY, lw=0.8, label=r"friction bound $\pm 1$")
    ax.set_ylabel("$q / (f p)$")


def ratios(shear: Array, bound: Array) -> Array:
    """Shear over its friction bound; NaN where a node bears nothing."""
    return np.asarray(np.divide(shear, bound, out=np.full(shear.shape, np.nan), where=bound > RESIDUAL * np.abs(bound).max()))


def friction_ratio(ax: Axes, system: ContactSystem, friction: Array, q: Array, p: Array, names: Sequence[str], ruling: Sequence[int] = ()) -> Array:
    """Draw q / (f p) of (K, N) reactions with the friction bounds, and return it; NaN, and left out, where the bound is zero but for rounding."""
    bound = friction * p
    ratio = ratios(q, bound)
    friction_bounds(ax)
    lines_or_band(ax, system, ratio, names, ruling)
    most = min(_MOST_RATIO, max(1.25, 1.1 * float(np.nanmax(np.abs(ratio), initial=0.0))))
    ax.set_ylim(-most, most)
    label_contacts(ax, system)
    return ratio


def circle(ax: Axes, x: ArrayLike, ratio: ArrayLike, sense: ArrayLike, area: ArrayLike, color: str, label: str | None) -> None:
    """Circle nodes at q / (f p); where that is not defined, at the bound of their sense of slip."""
    ax.scatter(
        x, np.where(np.isfinite(ratio), ratio, np.negative(sense)), s=area, facecolors="none", edgecolors=color, linewidths=1.2, zorder=3, label=label
    )
