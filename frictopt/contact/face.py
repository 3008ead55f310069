"""Values at the nodes of contacts in space, on maps of their faces: seen along their normals, or unrolled about an axis."""

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import offset_copy
from matplotlib.tri import Triangulation

from ..base import Array, Booleans, Integers
from ..base.checks import Names
from ..errors import ModelError
from ..plots.style import BLACK, FACE, GREY, SERIES, AxesArray, Look, arrows, new_axes, spread
from .frames import frames_of
from .system import ContactSystem

# spread of normals over the largest: that of two flat sides is none; cosine between normals and
# their mean
_LEAST = 0.1
# the same cosine: faces that turn on about an axis are unrolled; sine between normals and such an
# axis
_CAP = 0.5
# difference of directions, of nodes in one plane or at one angle; distance of nodes at one place,
# over the size of the contact
_FLAT = 1e-9
_POINT = 6.0, 160.0  # least and largest area of a point, points^2
_ROW, _PANEL = (
    3,
    2.7,
)  # panels of one row, else as many rows as columns; side of one of several panels, inches
_RING = 40  # area of a ring in a legend, points^2
_MANY, _FEW, _SHORT = (
    60,
    24,
    0.02,
)  # most arrows of one map, of each of several; those below this share of the longest are not drawn
_FAR = 1.8  # times the edges at its corners: an edge that spans a hole or a notch of the face
# largest cosine of the angle of a triangle that may lie in a hole: there it is opposite to the edge
# in the hole
_OBTUSE = -0.1
_MORE = 1.001  # drawn area over the area of the contact, up to which nothing is taken off


class Face(NamedTuple):
    """What one map shows: a contact (or several in one plane, without a name), its nodes, places (n, 2), names of the axes, turns to the map."""

    contact: str
    nodes: Integers
    places: Array
    labels: tuple[str, str]
    turn: Array


def faces_of(system: ContactSystem) -> list[Face]:
    """One face where all nodes lie in one plane, beside each other, or belong to one contact; else one for each contact."""
    every, names = (
        np.arange(system.nodes),
        [] if system.contact is None else list(dict.fromkeys(system.contact.tolist())),
    )
    if len(names) < 2 or np.ptp(system.frames, axis=0).max() <= _FLAT:
        try:
            return [Face("", every, *_seen(system, every))]
        except ModelError:
            if len(names) < 2:
                raise
    nodes = [np.flatnonzero(system.contact == name) for name in names]
    return [Face(name, own, *_seen(system, own)) for name, own in zip(names, nodes, strict=True)]


def panels_of(
    ax: Axes | AxesArray | None, system: ContactSystem, blocks: int = 1, more: int = 0
) -> list[Axes]:
    """Axes along a contact in the plane; in space for `blocks` maps of its faces, each a panel, in rows, and so many `more`."""
    if system.tangents == 1:
        return new_axes(ax)
    faces = len(faces_of(system))
    columns = faces if faces <= _ROW else ceil(faces**0.5)
    rows = blocks * -(-faces // columns) if not more else -(-(faces + more) // columns)
    size = (
        (FACE[0], FACE[1] * rows) if faces == 1 else (_PANEL * columns + 1.2, _PANEL * rows + 0.8)
    )
    return new_axes(ax, blocks * faces + more, size, common_x=False, columns=columns, blocks=blocks)


def together(panels: Sequence[Axes]) -> Axes | AxesArray:
    """What a picture returns: its axes, an array of several."""
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
    opened: Booleans | None = None,
    circled: tuple[Array, str] | None = None,
) -> Axes | AxesArray:
    """Values of the nodes, (N,) >= 0, as colours up to `most`, grey where NaN, in a panel for each face; the title stands above the first one.

    Slips (N, 2) are arrows, open nodes small rings; `circled` are the areas of rings round all
    nodes, (N,), 0 for none, with their name.
    """
    faces, closed = (
        faces_of(system),
        np.ones(system.nodes, dtype=bool) if opened is None else ~opened,
    )
    title, several = panels[0].get_title(), len(faces) > 1
    colours: Look = {
        "cmap": colormaps["cividis"].with_extremes(bad=GREY),
        "vmin": 0.0,
        "vmax": most or float(values.max()) or 1.0,
    }
    longest = (
        0.0 if slip is None else float(np.nanmax(np.linalg.norm(slip[closed], axis=1), initial=0.0))
    )
    for axes, face in zip(panels, faces, strict=True):
        shown = _values(
            axes,
            system,
            face,
            values,
            closed,
            (6_000 if several else 25_000) / len(face.nodes),
            colours,
        )
        half = _frame(axes, face)
        if slip is not None and longest > 0:
            _slips(
                axes,
                face,
                np.where(closed[:, None], slip, np.nan)[face.nodes],
                longest,
                f"{slip_name}, longest {longest:.3g} (length)",
                several,
            )
        if circled is not None and (nodes := face.nodes[circled[0][face.nodes] > 0]).size:
            at, look = (
                face.places[np.isin(face.nodes, nodes)],
                {"facecolors": "none", "edgecolors": SERIES[1]["color"], "linewidths": 1.4},
            )
            axes.scatter(at[:, 0], at[:, 1], s=circled[0][nodes], zorder=2.8, **look)
            axes.scatter([], [], s=_RING, label=circled[1], **look)
    if several:
        _names(panels, faces)
        panels[0].set_title(f"{title}\n", loc="left")
    bar: Look = (
        {"shrink": 0.7, "aspect": 30}
        if several
        else {"shrink": min(1.0, max(0.5, 1.5 * half[1] / half[0]))}
    )  # no taller than a wide map
    panels[0].figure.colorbar(shown, ax=list(panels), label=name, **bar)
    _legend(panels)
    return together(panels)


def _values(
    axes: Axes,
    system: ContactSystem,
    face: Face,
    values: Array,
    closed: Booleans,
    size: float,
    colours: Look,
) -> Any:
    """Values of a face, filled between neighbours, with its open nodes as rings."""
    places, closed, values = face.places, closed[face.nodes], values[face.nodes]
    known, size = closed & np.isfinite(values), float(np.clip(size, *_POINT))
    names = None if system.contact is None else system.contact[face.nodes]
    areas = (
        None
        if system.width is None
        else system.width[face.nodes] * np.abs(np.linalg.det(face.turn))
    )
    if (mesh := _triangles(names, places, known, areas)) is not None:
        axes.tripcolor(
            mesh,
            np.where(known, values, 0.0),
            shading="gouraud",
            zorder=0.5,
            rasterized=True,
            **colours,
        )
        size = max(_POINT[0], size / 4)
    shown = axes.scatter(
        places[closed, 0],
        places[closed, 1],
        c=values[closed],
        s=size,
        plotnonfinite=True,
        **colours,
    )
    if not closed.all():
        axes.scatter(
            places[~closed, 0],
            places[~closed, 1],
            s=0.6 * size,
            facecolors="none",
            edgecolors=GREY,
            linewidths=1.0,
            label="open node",
        )
    if np.isnan(values[closed]).any():
        axes.scatter([], [], s=size, color=GREY, label="node without friction bound")
    return shown


def _names(panels: Sequence[Axes], faces: Sequence[Face]) -> None:
    """The contact above each of several panels, and names of axes only where those of the panel beside or below are others."""
    spec = panels[0].get_subplotspec()
    columns = 1 if spec is None else spec.get_gridspec().ncols
    for number, (axes, face) in enumerate(zip(panels, faces, strict=True)):
        axes.set_title(face.contact)
        if number + columns < len(faces) and faces[number + columns].labels[0] == face.labels[0]:
            axes.set_xlabel("")
        if number % columns and faces[number - 1].labels[1] == face.labels[1]:
            axes.set_ylabel("")


def _frame(axes: Axes, face: Face) -> Array:
    """The names of the axes, and room for all; (2,) half the size of the map."""
    axes.set(xlabel=f"{face.labels[0]} (length)", ylabel=f"{face.labels[1]} (length)")
    half = np.ptp(face.places, axis=0) / 2
    half = np.maximum(half, 0.25 * half.max() or 1.0)  # nodes on a line get a map as well
    axes.update_datalim(
        (face.places.max(axis=0) + face.places.min(axis=0)) / 2 + half * np.array([[-1.0], [1.0]])
    )
    axes.margins(0.075)
    axes.set_aspect("equal")
    return np.asarray(half)


def _slips(axes: Axes, face: Face, slip: Array, longest: float, name: str, several: bool) -> None:
    """Draw the slip of the nodes (n, 2) as arrows, as the map sees them, the `longest` of all maps as long on paper in each."""
    slips = np.flatnonzero(np.linalg.norm(slip, axis=1) >= _SHORT * longest)
    few = (
        slips[sorted(spread(face.places[slips].T, _FEW if several else _MANY))]
        if len(slips)
        else slips
    )
    reach = (0.2 if several else 0.12) * float(np.ptp(face.places, axis=0).max() or 1.0) / longest
    look: Look = {
        "facecolor": "white",
        "edgecolor": BLACK,
        "linewidth": 0.5,
        "width": 0.012 if several else 0.007,
    }
    arrows(
        axes,
        face.places[few],
        np.einsum("nik,nk->ni", face.turn[few], slip[few]),
        reach,
        zorder=3,
        **look,
    )
    axes.plot(
        [], [], linestyle="none", marker=r"$\rightarrow$", markersize=11, color=BLACK, label=name
    )


def _legend(panels: Sequence[Axes]) -> None:
    """One legend for all panels, below them."""
    named = {
        label: handle
        for axes in panels[0].figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure = panels[0].figure
    if len(panels) > 1 and isinstance(figure, Figure) and figure.get_layout_engine() is not None:
        for earlier in list(figure.legends):
            earlier.remove()
        if named:
            figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=2)
        # the layout of panels of equal scales comes to rest at the second drawing
        figure.draw_without_rendering()
    elif named:
        axes = panels[-1]
        below = offset_copy(axes.transAxes, figure, y=-30.0, units="points")  # type: ignore[arg-type]  # the height of the labels; any kind of figure will do
        handles = (
            named
            if len(panels) > 1
            else dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        )
        axes.legend(
            handles.values(),
            handles.keys(),
            loc="upper center",
            bbox_to_anchor=(0.5, 0.0),
            bbox_transform=below,
            ncols=2,
        )


def _triangles(
    names: Names | None, places: Array, known: Booleans, areas: Array | None
) -> Triangulation | None:
    """Triangles between neighbours of one contact that have values; None where there are none.

    `areas` (n,) are those of the nodes on the map, None if unknown. They show which triangles lie
    in a hole.
    """
    if np.linalg.matrix_rank(places - places.mean(axis=0), tol=_FLAT * float(np.ptp(places))) < 2:
        return None
    mesh = Triangulation(*places.T)
    ends = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]]
    lengths = np.linalg.norm(places[ends[..., 0]] - places[ends[..., 1]], axis=-1)
    at = [lengths[(mesh.triangles == node).any(axis=1)] for node in range(len(places))]
    usual = np.array([np.median(own) if own.size else 0.0 for own in at])
    far = lengths.max(axis=1) > _FAR * usual[mesh.triangles].max(axis=1)
    apart = (
        np.zeros(len(far), dtype=bool)
        if names is None
        else (names[mesh.triangles] != names[mesh.triangles[:, :1]]).any(axis=1)
    )
    hidden = far | apart
    if areas is not None:
        one = np.zeros(len(places)) if names is None else names
        for name in np.unique(one):
            own = one == name
            _leave_holes(mesh, hidden, own[mesh.triangles].all(axis=1), float(areas[own].sum()))
    hidden |= ~known[mesh.triangles].all(axis=1)
    if hidden.all():
        return None
    mesh.set_mask(hidden)
    return mesh


def _leave_holes(mesh: Triangulation, hidden: Booleans, own: Booleans, area: float) -> None:
    """Hide triangles of one contact in its holes and notches, until those that are left have its area.

    Triangles join all nodes. Those in a hole join nodes of its rim. Each has an obtuse angle,
    opposite to the edge that it turns to the middle of the hole, and the most obtuse one is hidden
    first. Then the next ones are at the edge of what is drawn.
    """
    corners = np.column_stack([mesh.x, mesh.y])[mesh.triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    sizes = np.abs(np.linalg.det(sides[:, :2])) / 2
    excess = sizes[own & ~hidden].sum() - _MORE * area
    lengths = np.linalg.norm(sides, axis=2)
    before, after = np.roll(sides, 1, axis=1), np.roll(sides, -1, axis=1)
    opposite = (
        -np.sum(before * after, axis=2) / np.roll(lengths, 1, axis=1) / np.roll(lengths, -1, axis=1)
    )

    def free_sides(triangle: int) -> list[tuple[float, int]]:
        neighbours = mesh.neighbors[triangle]
        free = (neighbours < 0) | hidden[neighbours] | ~own[neighbours]
        return [
            (cosine, triangle)
            for cosine in opposite[triangle][free & (opposite[triangle] < _OBTUSE)].tolist()
        ]

    queue = [
        side for triangle in np.flatnonzero(own & ~hidden).tolist() for side in free_sides(triangle)
    ]
    heapify(queue)
    while queue and excess > 0:
        _, triangle = heappop(queue)
        if hidden[triangle]:
            continue
        hidden[triangle] = True
        excess -= sizes[triangle]
        for neighbour in mesh.neighbors[triangle].tolist():
            if neighbour >= 0 and own[neighbour] and not hidden[neighbour]:
                for side in free_sides(neighbour):
                    heappush(queue, side)


def _seen(system: ContactSystem, own: Integers) -> tuple[Array, tuple[str, str], Array]:
    """(n, 2) places of some nodes, names of the axes, and turns: seen along the mean normal, or unrolled about the axis of a face that turns on."""
    frames, points = system.frames[own], system.points[own]
    normals, mean = frames[:, 2], frames[:, 2].mean(axis=0)
    view, of, about = frames[0], "tangent", False
    if np.abs(frames - view).max() > _FLAT:
        _, sizes, directions = np.linalg.svd(normals - mean, full_matrices=False)
        axis = directions[-1] * np.sign(directions[-1][np.abs(directions[-1]).argmax()])
        around = np.cross(axis, normals)
        radii = np.linalg.norm(around, axis=1)
        about = bool(sizes[1] > _LEAST * sizes[0] and radii.min() > _CAP)
        if (normals @ mean).min() > (_CAP if about else _LEAST) * np.linalg.norm(mean):
            view, of, about = frames_of(mean[None])[0], "tangent of the mean plane", False
        elif not about:
            raise ModelError(
                "plot: the contact is not flat, and its sides face each other or away; make a "
                "contact of each side, or use to_frame()"
            )
    if about:
        along = np.stack([around / radii[:, None], np.repeat(axis[None], len(own), axis=0)], axis=1)
        places = np.column_stack([_unrolled(points, along[:, 0], axis), points @ axis])
        labels = "unrolled around the axis of the face", "along that axis"
    else:
        along = np.repeat(view[None, :2], len(own), axis=0)
        places, labels = (
            points @ view[:2].T,
            (_along(view[0], f"first {of}"), _along(view[1], f"second {of}")),
        )
    if len(np.unique(np.round(places / (_FLAT * (np.ptp(places) or 1.0))), axis=0)) < len(own):
        raise ModelError(
            "plot: the contact has nodes above each other, which one map would hide; use to_frame()"
        )
    return places, labels, np.einsum("nij,nkj->nik", along, frames[:, :2])


def _unrolled(points: Array, around: Array, axis: Array) -> Array:
    """(n,) arcs, with the mean radius, of points around an axis in unit directions; cut in the widest gap."""
    first, second, _ = frames_of(axis[None])[0]
    angle = np.arctan2(around @ second, around @ first)
    sides = np.sort(angle)
    gaps = np.diff(sides, append=sides[0] + 2 * np.pi)
    widest = int(
        (gaps > gaps.max() - _FLAT).argmax()
    )  # the first one, where all are alike up to rounding
    outward = np.cross(around, axis)
    outward -= outward.mean(axis=0)
    radius = np.sum((points - points.mean(axis=0)) * outward) / np.sum(outward**2)
    return np.asarray(radius * ((angle - sides[widest] - gaps[widest] / 2) % (2 * np.pi) - np.pi))


def _along(tangent: Array, name: str) -> str:
    """Name of a direction: that of the coordinate axis where it is one."""
    axis = np.flatnonzero(tangent > 1.0 - _FLAT)
    back = np.flatnonzero(tangent < _FLAT - 1.0)
    return (
        f"${'xyz'[axis[0]]}$"
        if len(axis)
        else f"$-{'xyz'[back[0]]}$"
        if len(back)
        else f"position along the {name}"
    )
