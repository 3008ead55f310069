"""Values at the nodes of contacts in space, on maps of their faces.

`face_views.py` finds the faces and how each is seen; `triangles.py` joins neighbouring nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import offset_copy
from matplotlib.tri import Triangulation

from ..base import Array, Booleans
from ..plots.style import (
    BLACK,
    FACE,
    GREY,
    SERIES,
    AxesArray,
    Look,
    arrows,
    as_is,
    axes_by_size,
    new_axes,
    spread,
)
from .face_views import Face, faces_of
from .system import ContactSystem
from .triangles import neighbours


@dataclass(frozen=True)
class MapStyle:
    """Sizes on maps, which depend on whether there is one map or several."""

    # Area of all points of a map together, points^2.
    area_of_points: float
    # Largest number of arrows of a map.
    arrows: int
    # Length of the longest arrow, as a share of the size of the map.
    longest_arrow: float
    # Width of an arrow, as a share of the size of the map.
    arrow_width: float


_ONE_MAP = MapStyle(area_of_points=25_000, arrows=60, longest_arrow=0.12, arrow_width=0.007)
_SEVERAL_MAPS = MapStyle(area_of_points=6_000, arrows=24, longest_arrow=0.2, arrow_width=0.012)


@dataclass(frozen=True)
class PanelSizes:
    """Sizes of panels of several faces at one scale, inches."""

    # Longest side of a panel.
    longest: float = 6.5
    # Root of the largest area of a panel.
    mean_side: float = 3.4
    # Shortest side of a panel.
    shortest: float = 1.3
    # Room for the labels beside a panel.
    labels: tuple[float, float] = (0.9, 0.8)
    # Width of a row of panels.
    row: float = 7.5
    # Number of coloured cells along each side of a map.
    cells: int = 300
    # Smallest and largest area of a point, points^2.
    point_area: tuple[float, float] = (6.0, 160.0)


_PANELS = PanelSizes()


def panels_of(
    ax: Axes | AxesArray | None, system: ContactSystem, blocks: int = 1, more: int = 0
) -> list[Axes]:
    """Axes of a picture: one along a contact in the plane, in space a panel for each face.

    In space there are `blocks` maps of each face, in rows, and `more` panels at the end.
    """
    if system.tangents == 1:
        return new_axes(ax)
    faces = len(faces_of(system))
    columns = ceil(faces**0.5)
    if more:
        rows = ceil((faces + more) / columns)
    else:
        rows = blocks * ceil(faces / columns)
    if faces == 1:
        size = (FACE[0], FACE[1] * rows)
    else:
        side = 3.2  # inches
        size = (side * columns + 1.2, side * rows + 0.8)
    panels = blocks * faces + more
    return new_axes(ax, panels, size, common_x=False, columns=columns, blocks=blocks)


def panels_by_size(
    ax: Axes | AxesArray | None, system: ContactSystem, shown: Booleans
) -> list[Axes]:
    """Axes for the faces in space that have some of the nodes (N,) `shown`, at one scale.

    The area of a panel is proportional to its face, but large enough for its labels.
    """
    faces = _shown_faces(system, shown)
    if len(faces) == 1:
        return new_axes(ax, 1, FACE)
    extents = np.array([np.ptp(face.places, axis=0) for face in faces])
    longest = extents.max() or 1.0
    mean_side = np.sqrt(extents.prod(axis=1).max()) or longest
    scale = min(_PANELS.longest / longest, _PANELS.mean_side / mean_side)
    sizes = np.clip(scale * extents, _PANELS.shortest, _PANELS.longest)
    return axes_by_size(ax, sizes + _PANELS.labels, _PANELS.row)


def _shown_faces(system: ContactSystem, shown: Booleans | None) -> list[Face]:
    faces = faces_of(system)
    if shown is None:
        return faces
    return [face for face in faces if shown[face.nodes].any()]


def together(panels: Sequence[Axes]) -> Axes | AxesArray:
    """The axes that a picture returns: a single one, or an array of several."""
    return panels[0] if len(panels) == 1 else np.array(panels)


def face_map(
    panels: Sequence[Axes],
    system: ContactSystem,
    values: Array,
    name: str,
    most: float | None = None,
    *,
    slip: Array | None = None,
    slip_name: str = "",
    to_and_fro: bool = False,
    opened: Booleans | None = None,
    shown: Booleans | None = None,
    circled: tuple[Array, str] | None = None,
) -> Axes | AxesArray:
    """Draw values of the nodes (N,) >= 0 as colours, in a panel for each face.

    The colours end at `most`, or at the largest value. Nodes with NaN are grey. Slips (N, 2) are
    arrows, with two heads if they go `to_and_fro`; open nodes are small rings. `circled` has areas
    (N,) of larger rings, 0 for none, and their name. The title of the first panel becomes the title
    of all maps. `shown` are the nodes of `panels_by_size`; None: all faces have a panel.
    """
    faces = _shown_faces(system, shown)
    several = len(faces) > 1
    style = _SEVERAL_MAPS if several else _ONE_MAP
    title = panels[0].get_title()
    closed = np.ones(system.nodes, dtype=bool) if opened is None else ~opened
    colours: Look = {
        "cmap": colormaps["cividis"].with_extremes(bad=GREY),
        "vmin": 0.0,
        "vmax": most or float(values.max()) or 1.0,
    }
    longest = 0.0
    if slip is not None:
        sizes = np.linalg.norm(slip[closed], axis=1)
        longest = float(np.nanmax(sizes, initial=0.0))

    for axes, face in zip(panels, faces, strict=True):
        points = _draw_values(axes, system, face, values, closed, style, colours)
        half_size = _label_axes(axes, face)
        if slip is not None and longest > 0:
            # Open nodes have no residual slip.
            of_closed = np.where(closed[:, None], slip, np.nan)[face.nodes]
            label = f"{slip_name}, longest {longest:.3g} (length)"
            _draw_slips(axes, face, of_closed, longest, label, style, to_and_fro)
        if circled is not None:
            _draw_rings(axes, face, *circled)

    if several:
        if shown is None:
            _label_panels(panels, faces)
            panels[0].set_title(f"{title}\n", loc="left")
        else:
            for axes, face in zip(panels, faces, strict=True):
                axes.set_title(as_is(face.contact))
            panels[0].figure.suptitle(title)
        bar: Look = {"shrink": 0.7, "aspect": 30}
    else:
        # The colour bar is no taller than a wide map.
        bar = {"shrink": float(np.clip(1.5 * half_size[1] / half_size[0], 0.5, 1.0))}
    panels[0].figure.colorbar(points, ax=_beside_the_first(panels), label=name, **bar)
    _draw_legend(panels)
    return together(panels)


def _beside_the_first(panels: Sequence[Axes]) -> list[Axes]:
    """The panels in the grid of the first one: in one row, or all of them."""
    specs = [axes.get_subplotspec() for axes in panels]
    if specs[0] is None:
        return list(panels)
    grid = specs[0].get_gridspec()
    return [
        axes
        for axes, spec in zip(panels, specs, strict=True)
        if spec is not None and spec.get_gridspec() is grid
    ]


def _draw_values(
    axes: Axes,
    system: ContactSystem,
    face: Face,
    values: Array,
    closed: Booleans,
    style: MapStyle,
    colours: Look,
) -> Any:
    """Draw the values of a face, filled between neighbours, and its open nodes as rings."""
    x, y = face.places.T
    closed = closed[face.nodes]
    values = values[face.nodes]
    has_value = closed & np.isfinite(values)
    size = float(np.clip(style.area_of_points / len(face.nodes), *_PANELS.point_area))

    names = None if system.contact is None else system.contact[face.nodes]
    areas = None
    if system.width is not None:
        areas = system.width[face.nodes] * np.abs(np.linalg.det(face.turn))
    mesh = neighbours(names, face.places, has_value, areas)
    if mesh is not None:
        _draw_cells(axes, mesh, values, colours)
        size = max(_PANELS.point_area[0], size / 4)
    points = axes.scatter(
        x[closed], y[closed], c=values[closed], s=size, plotnonfinite=True, **colours
    )
    if not closed.all():
        ring: Look = {"facecolors": "none", "edgecolors": GREY, "linewidths": 1.0}
        axes.scatter(x[~closed], y[~closed], s=0.6 * size, label="open node", **ring)
    if np.isnan(values[closed]).any():
        axes.scatter([], [], s=size, color=GREY, label="node without friction bound")
    return points


def _draw_cells(axes: Axes, mesh: Triangulation, values: Array, colours: Look) -> None:
    """Colour each place in the triangles by the value (n,) of its nearest corner.

    Interpolated colours would show the diagonals of the triangles, which are arbitrary on a grid.
    """
    # Middles of the cells, as shares of the sides of the map.
    shares = (np.arange(_PANELS.cells) + 0.5) / _PANELS.cells
    left, right, low, high = mesh.x.min(), mesh.x.max(), mesh.y.min(), mesh.y.max()
    x, y = np.meshgrid(left + shares * (right - left), low + shares * (high - low))
    triangle = mesh.get_trifinder()(x, y)
    corners = mesh.triangles[triangle]
    distance = np.hypot(mesh.x[corners] - x[..., None], mesh.y[corners] - y[..., None])
    nearest = np.take_along_axis(corners, distance.argmin(axis=-1)[..., None], axis=-1)[..., 0]
    axes.imshow(
        values[nearest],
        alpha=np.where(triangle < 0, 0.0, 1.0),
        extent=(left, right, low, high),
        origin="lower",
        interpolation="none",
        zorder=0.5,
        **colours,
    )


def _draw_rings(axes: Axes, face: Face, areas: Array, label: str) -> None:
    """Draw rings of given areas (N,) round the nodes of a face."""
    of_face = areas[face.nodes]
    ringed = of_face > 0
    if not ringed.any():
        return
    look: Look = {
        "facecolors": "none",
        "edgecolors": SERIES[1]["color"],
        "linewidths": 1.4,
    }
    x, y = face.places[ringed].T
    axes.scatter(x, y, s=of_face[ringed], zorder=2.8, **look)
    # In the legend the ring has one size, whatever the areas.
    axes.scatter([], [], s=40, label=label, **look)


def _draw_slips(
    axes: Axes,
    face: Face,
    slip: Array,
    longest: float,
    label: str,
    style: MapStyle,
    to_and_fro: bool,
) -> None:
    """Draw slips (n, 2) of the nodes of a face as arrows in the directions of the map.

    An arrow `to_and_fro` has a head at either end, and its middle at the node.

    The `longest` slip of all maps has the same length on paper in each map.
    """
    # Slips below this share of the longest one have no arrow.
    shortest = 0.02
    slips = np.flatnonzero(np.linalg.norm(slip, axis=1) >= shortest * longest)
    if len(slips):
        slips = slips[sorted(spread(face.places[slips].T, style.arrows))]
    size_of_map = float(np.ptp(face.places, axis=0).max() or 1.0)
    enlarged = style.longest_arrow * size_of_map / longest
    on_map = np.einsum("nik,nk->ni", face.turn[slips], slip[slips])
    look: Look = {
        "facecolor": "white",
        "edgecolor": BLACK,
        "linewidth": 0.5,
        "width": style.arrow_width,
    }
    places = face.places[slips]
    if to_and_fro:
        places = np.tile(places, (2, 1))
        on_map = np.concatenate([on_map, -on_map]) / 2
    arrows(axes, places, on_map, enlarged, zorder=3, **look)
    sign = r"$\leftrightarrow$" if to_and_fro else r"$\rightarrow$"
    marker: Look = {"linestyle": "none", "marker": sign, "markersize": 11}
    axes.plot([], [], color=BLACK, label=label, **marker)


def _label_axes(axes: Axes, face: Face) -> Array:
    """Label the axes of a map and make room for all nodes; returns half its size (2,)."""
    axes.set(xlabel=f"{face.labels[0]} (length)", ylabel=f"{face.labels[1]} (length)")
    half_size = np.ptp(face.places, axis=0) / 2
    # The map of nodes on a line gets some height, too.
    half_size = np.maximum(half_size, 0.25 * half_size.max() or 1.0)
    middle = (face.places.max(axis=0) + face.places.min(axis=0)) / 2
    axes.update_datalim(middle + half_size * np.array([[-1.0], [1.0]]))
    axes.margins(0.075)
    # Otherwise the map would end at its cells, and cut points and arrows.
    axes.use_sticky_edges = False
    axes.set_aspect("equal")
    return np.asarray(half_size)


def _label_panels(panels: Sequence[Axes], faces: Sequence[Face]) -> None:
    """Write each contact above its panel, and leave out axis labels that a neighbour repeats."""
    spec = panels[0].get_subplotspec()
    columns = 1 if spec is None else spec.get_gridspec().ncols
    for number, (axes, face) in enumerate(zip(panels, faces, strict=True)):
        axes.set_title(as_is(face.contact))
        below = number + columns
        if below < len(faces) and faces[below].labels[0] == face.labels[0]:
            axes.set_xlabel("")
        if number % columns and faces[number - 1].labels[1] == face.labels[1]:
            axes.set_ylabel("")


def _draw_legend(panels: Sequence[Axes]) -> None:
    """Draw one legend for all panels, below them."""
    figure = panels[0].figure
    by_label = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            by_label[label] = handle
    several = len(panels) > 1
    if several and isinstance(figure, Figure) and figure.get_layout_engine() is not None:
        for earlier in list(figure.legends):
            earlier.remove()
        if by_label:
            place = "outside lower center"
            figure.legend(list(by_label.values()), list(by_label), loc=place, ncols=2)
        # The layout of panels with equal scales is final only at the second drawing.
        figure.draw_without_rendering()
        return
    if not by_label:
        return
    axes = panels[-1]
    if not several:
        handles, labels = axes.get_legend_handles_labels()
        by_label = dict(zip(labels, handles, strict=True))
    # The legend is 30 points below the axes, because the axis labels take this height.
    below = offset_copy(axes.transAxes, figure, y=-30.0, units="points")  # type: ignore[arg-type]
    axes.legend(
        list(by_label.values()),
        list(by_label),
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=below,
        ncols=2,
    )
