"""Values at the nodes of contacts: along the x axis that all pictures in the plane share, and in space on maps of the face."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.transforms import offset_copy
from matplotlib.tri import Triangulation
from numpy.typing import ArrayLike

from ..contact import RESIDUAL, Array, Booleans, ContactSystem
from ..contact.parts import runs
from ..transients import SteadyState
from .bodies import spread
from .faces import FLAT, places_of, turned
from .style import BLACK, GREY, SERIES, AxesArray, Look, one_axes, series, slanted

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
        low, high = np.fmin.reduce(values), np.fmax.reduce(values)  # NaN counts where all are
        for _, nodes in parts(system):
            ax.fill_between(system.x[nodes], low[nodes], high[nodes], color=band, alpha=0.35, lw=0.6, label=label)
            label = None
    for corner, look in looks(len(values), ruling).items():
        own = {"color": look["color"], "linestyle": look["linestyle"], "marker": ".", "markersize": 3, **more}
        lines(ax, system, values[corner], label=names[corner], **own)


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
            labels = [name for name, _ in found]
            above.set_xticks([float(system.x[nodes].mean()) for _, nodes in found], labels, **slanted(labels, "left", "bottom"))
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


_FACE = 25_000  # area that the points of a face share, points^2
_LARGEST, _SMALLEST = 160.0, 6.0  # area of a point, points^2
_FILLED = 4.0  # how much smaller points are on a filled face
_PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}  # under names that arrows may cross
_FAR = 1.8  # times the edges at its corners: an edge that spans a hole or a notch of the face
_MOST_ARROWS = 60
_ARROW = 0.12  # length of the longest arrow, over the size of the face
_LABELS = 30.0  # height of the labels of the axis below a map, points
_MARGIN = 0.075  # of the axes, beyond points and arrows


def ratio_map(
    axes: Axes, system: ContactSystem, ratio: Array, corner: str, slip: Array | None, opened: Booleans | None, circled: Sequence[int], why: str
) -> Axes:
    """Shear over friction bound (N,) at a corner by its name; the residual slip as arrows, some nodes circled."""
    most = float(np.nanmax(ratio, initial=0.0))
    places, turn, size = _map(axes, system, ratio, rf"$|q| / (f p)$ at {corner}", most if most > 1.0 + RESIDUAL else 1.0, opened)
    if slip is not None:
        _arrows(axes, places, turn, slip if opened is None else np.where(opened[:, None], np.nan, slip), "residual slip")
    if circled:
        x, y = places[circled].T
        axes.scatter(x, y, s=1.6 * size, facecolors="none", edgecolors=SERIES[1]["color"], linewidths=1.4, label=why)
    return _finished(axes)


def steady_map(steady: SteadyState, ax: Axes | AxesArray | None) -> Axes:
    """Work of friction per cycle at each node; the slip at the last corner as arrows."""
    axes = one_axes(ax, 2)
    outcome = steady.outcome.name.lower().replace("_", " ")
    axes.set_title(f"{outcome}, work of friction per cycle {steady.dissipation:.4g}")
    work = steady.dissipation_per_node
    places, turn, _ = _map(axes, steady.system, work, "work of friction per cycle (force times length)", float(work.max()) or 1.0)
    _arrows(axes, places, turn, steady.slip, f"slip at {steady.cycle.corner_names[-1]}")
    return _finished(axes)


def face_map(axes: Axes, system: ContactSystem, values: Array, name: str) -> Axes:
    """Values of the nodes, (N,) >= 0, by their name."""
    _map(axes, system, values, name, float(values.max()) or 1.0)
    return _finished(axes)


def _map(axes: Axes, system: ContactSystem, values: Array, name: str, most: float, opened: Booleans | None = None) -> tuple[Array, Array, float]:
    """Draw values of the nodes as coloured points, grey where there is none, open ones as rings; places and turns, and the area of a point."""
    places, labels, names, turn = places_of(system)
    size = float(np.clip(_FACE / system.nodes / max(1, len(names)), _SMALLEST, _LARGEST))
    colours = colormaps["cividis"].with_extremes(bad=GREY)
    closed = np.ones(system.nodes, dtype=bool) if opened is None else ~opened
    known = closed & np.isfinite(values)
    if (mesh := _triangles(system, places, known)) is not None:
        axes.tripcolor(mesh, np.where(known, values, 0.0), shading="gouraud", cmap=colours, vmin=0.0, vmax=most, zorder=0.5, rasterized=True)
        size = max(_SMALLEST, size / _FILLED)
    shown = axes.scatter(places[closed, 0], places[closed, 1], c=values[closed], s=size, cmap=colours, vmin=0.0, vmax=most, plotnonfinite=True)
    if not closed.all():
        axes.scatter(places[~closed, 0], places[~closed, 1], s=0.6 * size, facecolors="none", edgecolors=GREY, linewidths=1.0, label="open node")
    if np.isnan(values[closed]).any():
        axes.scatter([], [], s=size, color=GREY, label="node without friction bound")
    axes.set(xlabel=f"{labels[0]} (length)", ylabel=f"{labels[1]} (length)")
    look: Look = {"ha": "center"} | slanted(names, "left", "bottom")
    for contact, place in names.items():
        axes.annotate(contact, (place[0], place[1]), xytext=(0.0, 8.0), textcoords="offset points", zorder=4, bbox=_PLATE, **look)
    half = np.ptp(places, axis=0) / 2
    half = np.maximum(half, 0.25 * half.max() or 1.0)  # nodes on a line get a map as well
    axes.update_datalim((places.max(axis=0) + places.min(axis=0)) / 2 + half * np.array([[-1.0], [1.0]]))
    axes.margins(_MARGIN, 0.2 if names else _MARGIN)
    axes.set_aspect("equal")
    axes.figure.colorbar(shown, ax=axes, label=name, shrink=min(1.0, max(0.5, 1.5 * half[1] / half[0])))  # no taller than a wide map
    return places, turn, size


def _triangles(system: ContactSystem, places: Array, known: Booleans) -> Triangulation | None:
    """Triangles between neighbours of one contact that have values; None where there are none."""
    if np.linalg.matrix_rank(places - places.mean(axis=0), tol=FLAT * float(np.ptp(places))) < 2:
        return None
    mesh = Triangulation(*places.T)
    ends = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    lengths = np.linalg.norm(places[ends[..., 0]] - places[ends[..., 1]], axis=-1)
    at = [lengths[(mesh.triangles == node).any(axis=1)] for node in range(len(places))]
    usual = np.array([np.median(own) if own.size else 0.0 for own in at])
    far = lengths.max(axis=1) > _FAR * usual[mesh.triangles].max(axis=1)
    apart = np.zeros(len(far), dtype=bool)
    if system.contact is not None:
        apart = (system.contact[mesh.triangles] != system.contact[mesh.triangles[:, :1]]).any(axis=1)
    hidden = far | apart | ~known[mesh.triangles].all(axis=1)
    if hidden.all():
        return None
    mesh.set_mask(hidden)
    return mesh


def arrows(axes: Axes, places: Array, vectors: Array, those: Array, **look: Any) -> None:
    """Draw vectors (n, 2) as arrows, with room for all of those, (..., n, 2), that the same map will show; the longest of them has its length."""
    reach = _ARROW * float(np.ptp(places, axis=0).max() or 1.0) / float(np.nanmax(np.linalg.norm(those, axis=-1)) or 1.0)
    axes.quiver(*places.T, *vectors.T, angles="xy", scale_units="xy", scale=1 / reach, zorder=3, **look)
    axes.update_datalim((places + reach * those).reshape(-1, 2))
    axes.autoscale_view()


def _arrows(axes: Axes, places: Array, turn: Array, slip: Array, name: str) -> None:
    """Draw the slip of the nodes as arrows, as the map sees them, none where it is NaN."""
    longest = float(np.nanmax(np.linalg.norm(slip, axis=1), initial=0.0))
    if longest > 0:
        few = sorted(spread(places.T, _MOST_ARROWS))
        seen = turned(turn, slip)[few]
        arrows(axes, places[few], seen, seen, facecolor="white", edgecolor=BLACK, linewidth=0.5, width=0.007)
        axes.plot([], [], linestyle="none", marker=r"$\rightarrow$", markersize=11, color=BLACK, label=f"{name}, longest {longest:.3g} (length)")


def _finished(axes: Axes) -> Axes:
    """Legend below the map, if it has one."""
    if axes.get_legend_handles_labels()[1]:
        below = offset_copy(axes.transAxes, axes.figure, y=-_LABELS, units="points")  # type: ignore[arg-type]  # a figure within another one will do
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, ncols=2)
    return axes
