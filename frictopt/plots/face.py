"""Values at the nodes of contacts in space, on maps of their faces."""

from collections.abc import Sequence
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.transforms import offset_copy

from ..base import Array, Booleans, Integers
from .bodies import finish_axes
from .style import BLACK, GREY, SERIES, AnyAxes, Look, arrows, as_is, named, rings, spread, together


class Face(NamedTuple):
    """A map of a contact, or, without a name, of all contacts in one plane.

    `nodes` (n,) are the numbers of its nodes, and `places` their places on the map, (n, 2) or in
    space (n, 3). `labels` names the axes of the map. `turn` (n, 2 or 3, 2) turns slips into
    directions on the map. `share` (n,) is the share of each node in the area of the face.
    """

    contact: str
    nodes: Integers
    places: Array
    labels: tuple[str, str]
    turn: Array
    share: Array


def face_map(
    panels: Sequence[AnyAxes],
    faces: Sequence[Face],
    values: Array,
    name: str,
    most: float | None = None,
    *,
    slip: Array | None = None,
    slip_name: str = "",
    to_and_fro: bool = False,
    opened: Booleans | None = None,
    circled: tuple[Array, str] | None = None,
) -> AnyAxes:
    """Draw values of the nodes (N,) >= 0 as colours of points, in a panel for each face.

    The area of a point is the share of its node in the face. The colours end at `most`, or at the
    largest value. Nodes with NaN are grey. Slips (N, 2) are arrows, with two heads if they go
    `to_and_fro`; open nodes are small rings. `circled` has areas (N,) of larger rings, 0 for none,
    and their name. The title of the first panel becomes the title of all maps.
    """
    closed = np.ones(len(values), dtype=bool) if opened is None else ~opened
    colours: Look = {
        "cmap": colormaps["cividis"].with_extremes(bad=GREY),
        "vmin": 0.0,
        "vmax": most or float(values.max()) or 1.0,
        "plotnonfinite": True,
    }
    if slip is not None:
        # Open nodes have no residual slip.
        slip = np.where(closed[:, None], slip, np.nan)
    several = len(faces) > 1
    for axes, face in zip(panels, faces, strict=True):
        ratio = _label_axes(axes, face)
        area = (10_000 if several else 45_000) * min(ratio, 1 / ratio)
        sizes = np.clip(area * face.share, 6.0, 250.0)  # points^2
        near, of_face = closed[face.nodes], values[face.nodes]
        points = axes.scatter(*face.places[near].T, c=of_face[near], s=sizes[near], **colours)
        rings(axes, face.places[~near], 0.6 * sizes[~near], "open node", GREY)
        if np.isnan(of_face[near]).any():
            axes.plot([], [], "o", color=GREY, label="node without friction bound")
        if slip is not None:
            _draw_slips(axes, face, slip, slip_name, to_and_fro)
        if circled is not None:
            ringed = circled[0][face.nodes] > 0
            areas = circled[0][face.nodes][ringed]
            rings(axes, face.places[ringed], areas, circled[1], SERIES[1]["color"])

    if several:
        title = "\n".join(fill(part, 45) for part in panels[0].get_title().splitlines())
        panels[0].set_title(f"{title}\n", loc="left")
        for axes, face in zip(panels, faces, strict=True):
            axes.set_title(as_is(face.contact))
    # The colour bar is no taller than a wide map.
    shrink = 0.7 if several else float(np.clip(1.5 * ratio, 0.5, 1.0))
    panels[0].figure.colorbar(points, ax=list(panels), label=name, shrink=shrink)
    names = named(panels)
    if names["labels"]:
        # The legend is 30 points below the axes, because the axis labels take this height.
        below = offset_copy(axes.transAxes, axes.figure, y=-30.0, units="points")
        axes.legend(
            **names,
            ncols=1 if several else 2,
            loc="upper center",
            bbox_to_anchor=(0.5, 0.0),
            bbox_transform=below,
        )
    return together(panels)


def _draw_slips(axes: AnyAxes, face: Face, slip: Array, name: str, to_and_fro: bool) -> None:
    """Draw slips (N, 2) of all nodes as arrows in the directions of the map of a face.

    An arrow `to_and_fro` has a head at either end, and its middle at the node. The longest slip of
    all maps has the same length on paper in each map.
    """
    longest = float(np.nanmax(np.linalg.norm(slip, axis=1), initial=0.0))
    of_face = slip[face.nodes]
    # Slips below this share of the longest one have no arrow.
    shortest = 0.02
    slips = np.flatnonzero(np.linalg.norm(of_face, axis=1) > shortest * longest)
    if not len(slips):
        return
    # Largest number of arrows, and their length as a share of the size of the map.
    most, length = 40, 0.15
    slips = slips[sorted(spread(face.places[slips].T, most))]
    places = face.places[slips]
    on_map = np.einsum("nik,nk->ni", face.turn[slips], of_face[slips])
    if to_and_fro:
        places = np.tile(places, (2, 1))
        on_map = np.concatenate([on_map, -on_map]) / 2
    enlarged = length * float(np.ptp(face.places, axis=0).max() or 1.0) / longest
    look: Look = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "width": 0.009}
    if places.shape[1] == 3:
        look = {"color": BLACK, "linewidth": 0.8}
    arrows(axes, places, on_map, enlarged, zorder=3, **look)
    sign = r"$\leftrightarrow$" if to_and_fro else r"$\rightarrow$"
    label = f"{name}, longest {longest:.3g} (length)"
    axes.plot([], [], linestyle="none", marker=sign, markersize=11, color=BLACK, label=label)


def _label_axes(axes: AnyAxes, face: Face) -> float:
    """Label the axes of a map, make room for all nodes, and return height divided by width."""
    ends = np.array([face.places.min(axis=0), face.places.max(axis=0)])
    if ends.shape[1] == 3:
        finish_axes(axes, ends, 0.1 * float(np.ptp(ends)))
        return 0.5
    axes.set(xlabel=f"{face.labels[0]} (length)", ylabel=f"{face.labels[1]} (length)")
    half_size = np.ptp(ends, axis=0) / 2
    # The map of nodes on a line gets some height, too.
    half_size = np.maximum(half_size, 0.25 * half_size.max() or 1.0)
    axes.update_datalim(ends.mean(axis=0) + half_size * np.array([[-1.0], [1.0]]))
    axes.margins(0.075)
    axes.set_aspect("equal")
    return float(half_size[1] / half_size[0])
