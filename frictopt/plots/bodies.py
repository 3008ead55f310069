"""Meshes of bodies: their lines in the plane, their surfaces in space.

matplotlib draws these plain pictures in any document. PyVista draws models in space as the eye sees
them, see `ContactModel.view`.
"""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..base import Array, Integers
from .style import AnyAxes, Look, as_is, legend, named, new_axes

Mesh: TypeAlias = Any  # of scikit-fem


def draw_edges(axes: Axes, mesh: Mesh, facets: Integers, **look: Any) -> None:
    """Draw some facets of a plane mesh."""
    # One line with gaps is drawn far faster than many lines.
    edges = np.insert(mesh.p[:, mesh.facets[:, facets]], 2, np.nan, axis=1)
    axes.plot(*edges.transpose(0, 2, 1).reshape(2, -1), solid_capstyle="round", snap=False, **look)


def draw_mesh(
    axes: Axes, mesh: Mesh, color: str, *, thin: float = 0.12, label: str | None = None
) -> None:
    """Draw the lines of a plane mesh, with its outline."""
    look: Look = {"color": color, "zorder": 0.5}
    draw_edges(axes, mesh, np.arange(mesh.facets.shape[1]), lw=thin, **look)
    draw_edges(axes, mesh, mesh.boundary_facets(), lw=1.0, label=label, **look)


def corners(mesh: Mesh, facets: Integers | None = None) -> Array:
    """(n, corners, 3) corners of facets of a mesh in space; None: all facets of its surface."""
    facets = mesh.boundary_facets() if facets is None else facets
    return np.asarray(mesh.p[:, mesh.facets[:, facets]].transpose(2, 1, 0))


def draw_bodies(
    axes: AnyAxes, meshes: Mapping[str, Mesh], colors: Sequence[str], face: float, edge: float
) -> None:
    """Draw bodies in their colours: meshes in the plane, surfaces in space.

    `face` and `edge` are the opacities of the faces and of their sides in space.
    """
    polygons = list[Array]()
    looks = list[str]()
    for (name, mesh), color in zip(meshes.items(), colors, strict=False):
        if mesh.dim() == 2:
            draw_mesh(axes, mesh, color, thin=0.2, label=as_is(name))
            continue
        surface = corners(mesh)
        polygons += [*surface]
        looks += [color] * len(surface)
        # A patch of the legend as pale as the faces would not show which body is meant.
        axes.plot([], [], marker="s", linestyle="none", color=color, label=as_is(name))
    if polygons:
        # All faces are one collection: matplotlib hides faces behind others only within one
        # collection.
        faces, edges = ([(color, alpha) for color in looks] for alpha in (face, edge))
        axes.add_collection3d(
            Poly3DCollection(polygons, facecolors=faces, edgecolors=edges, linewidth=0.3)
        )


def axes_of(meshes: Mapping[str, Mesh], ax: AnyAxes, panels: int = 1) -> tuple[list[Any], Array]:
    """Axes for bodies, and the least and the largest of their coordinates, (2, d)."""
    points = np.concatenate([mesh.p for mesh in meshes.values()], axis=1)
    in_space = len(points) == 3
    columns = ceil(panels**0.5)
    width, height = (8.0, 5.4) if in_space else (6.4, 4.8)
    if panels > 1:
        width, height = 0.6 * width * columns, 0.6 * height * ceil(panels / columns)
    axes = new_axes(ax, panels, (width, height), common_x=False, in_space=in_space, columns=columns)
    return axes, np.array([points.min(axis=1), points.max(axis=1)])


def legend_of_bodies(axes: AnyAxes, ax: AnyAxes) -> None:
    """A legend for all panels of a new figure, beside the panels, or below them in space."""
    if ax is not None:
        legend(axes)
        return
    # Long joints need the whole width, so their legend is below them.
    place: Look = {"loc": "outside lower center", "ncols": 4}
    if axes.name != "3d":
        axes.figure.set_layout_engine("compressed")
        place = {"loc": "outside right upper"}
    axes.figure.legend(**named([axes]), **place)


def finish_axes(axes: AnyAxes, ends: Array, room: float) -> None:
    """Set names and limits of the axes, in space with room around the drawing.

    `ends` (2, d) are the least and the largest coordinates of the bodies.
    """
    axes.set(xlabel="$x$ (length)", ylabel="$y$ (length)")
    if ends.shape[1] == 2:
        axes.set_aspect("equal")
        return
    x, y, z = axes.xy_dataLim.intervalx, axes.xy_dataLim.intervaly, axes.zz_dataLim.intervalx
    drawn = np.transpose([x, y, z])
    low = np.minimum(ends[0], drawn[0]) - room
    high = np.maximum(ends[1], drawn[1]) + room
    shares = (high - low) / (high - low).max()
    # matplotlib leaves more room around bodies in space than the names of the axes need.
    axes.set_box_aspect(high - low, zoom=1.15)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_zlabel("$z$ (length)")
    axes.grid(False)
    for axis, share in zip((axes.xaxis, axes.yaxis, axes.zaxis), shares, strict=True):
        # As many numbers as the axis has room for.
        axis.set_major_locator(MaxNLocator(max(1, round(5 * share))))
