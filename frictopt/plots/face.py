"""Values at the nodes of contacts in space, on one map of their faces: seen along their normals, or unrolled about an axis."""

from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.transforms import offset_copy
from matplotlib.tri import Triangulation

from ..contact import Array, Booleans, ContactSystem, Integers
from ..errors import ModelError
from ..fem.interface import frames_of
from .style import BLACK, GREY, SERIES, Look, arrows, slanted, spread

_LEAST = 0.1  # spread of normals over the largest: that of two flat sides is none; cosine between normals and their mean
_CAP = 0.5  # the same cosine: faces that turn on about an axis are unrolled; sine between normals and such an axis
_FLAT = 1e-9  # difference of directions, of nodes in one plane or at one angle; distance of nodes at one place, over the size of the contact
_POINT = 6.0, 160.0  # least and largest area of a point, points^2
_PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}  # under names that arrows may cross
_FAR = 1.8  # times the edges at its corners: an edge that spans a hole or a notch of the face


def face_map(
    axes: Axes,
    system: ContactSystem,
    values: Array,
    name: str,
    most: float | None = None,
    *,
    slip: Array | None = None,
    slip_name: str = "",
    opened: Booleans | None = None,
    circled: tuple[Sequence[int], str] = ((), ""),
) -> Axes:
    """Values of the nodes, (N,) >= 0, as colours up to `most`, grey where NaN; slips (N, 2) as arrows, open nodes as rings, and some circled."""
    places, labels, names, turn = places_of(system)
    size = float(np.clip(25_000 / system.nodes / max(1, len(names)), *_POINT))
    closed = np.ones(system.nodes, dtype=bool) if opened is None else ~opened
    known = closed & np.isfinite(values)
    colours: Look = {"cmap": colormaps["cividis"].with_extremes(bad=GREY), "vmin": 0.0, "vmax": most or float(values.max()) or 1.0}
    if (mesh := _triangles(system, places, known)) is not None:
        axes.tripcolor(mesh, np.where(known, values, 0.0), shading="gouraud", zorder=0.5, rasterized=True, **colours)
        size = max(_POINT[0], size / 4)
    shown = axes.scatter(places[closed, 0], places[closed, 1], c=values[closed], s=size, plotnonfinite=True, **colours)
    if not closed.all():
        axes.scatter(places[~closed, 0], places[~closed, 1], s=0.6 * size, facecolors="none", edgecolors=GREY, linewidths=1.0, label="open node")
    if np.isnan(values[closed]).any():
        axes.scatter([], [], s=size, color=GREY, label="node without friction bound")
    half = _frame(axes, places, labels, names)
    axes.figure.colorbar(shown, ax=axes, label=name, shrink=min(1.0, max(0.5, 1.5 * half[1] / half[0])))  # no taller than a wide map
    if slip is not None:
        _slips(axes, places, turn, np.where(closed[:, None], slip, np.nan), slip_name)
    nodes, why = circled
    if len(nodes):
        axes.scatter(places[nodes, 0], places[nodes, 1], s=1.6 * size, facecolors="none", edgecolors=SERIES[1]["color"], linewidths=1.4, label=why)
    if axes.get_legend_handles_labels()[1]:
        below = offset_copy(axes.transAxes, axes.figure, y=-30.0, units="points")  # type: ignore[arg-type]  # the height of the labels; any kind of figure will do
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, ncols=2)
    return axes


def _frame(axes: Axes, places: Array, labels: tuple[str, str], names: dict[str, Array]) -> Array:
    """Labels of the axes, names above the contacts, and room for all of them; (2,) half the size of the map."""
    axes.set(xlabel=f"{labels[0]} (length)", ylabel=f"{labels[1]} (length)")
    look: Look = {"ha": "center"} | slanted(names, "left", "bottom")
    for contact, place in names.items():
        axes.annotate(contact, (place[0], place[1]), xytext=(0.0, 8.0), textcoords="offset points", zorder=4, bbox=_PLATE, **look)
    half = np.ptp(places, axis=0) / 2
    half = np.maximum(half, 0.25 * half.max() or 1.0)  # nodes on a line get a map as well
    axes.update_datalim((places.max(axis=0) + places.min(axis=0)) / 2 + half * np.array([[-1.0], [1.0]]))
    axes.margins(0.075, 0.2 if names else 0.075)
    axes.set_aspect("equal")
    return np.asarray(half)


def _slips(axes: Axes, places: Array, turn: Array, slip: Array, name: str) -> None:
    """Draw the slip of the nodes as arrows, as the map sees them, none where it is NaN."""
    longest = float(np.nanmax(np.linalg.norm(slip, axis=1), initial=0.0))
    if longest > 0:
        few = sorted(spread(places.T, 60))
        seen = np.einsum("nik,nk->ni", turn, slip)[few]
        reach = 0.12 * float(np.ptp(places[few], axis=0).max() or 1.0) / float(np.nanmax(np.linalg.norm(seen, axis=1)) or 1.0)
        arrows(axes, places[few], seen, reach, zorder=3, facecolor="white", edgecolor=BLACK, linewidth=0.5, width=0.007)
        axes.plot([], [], linestyle="none", marker=r"$\rightarrow$", markersize=11, color=BLACK, label=f"{name}, longest {longest:.3g} (length)")


def _triangles(system: ContactSystem, places: Array, known: Booleans) -> Triangulation | None:
    """Triangles between neighbours of one contact that have values; None where there are none."""
    if np.linalg.matrix_rank(places - places.mean(axis=0), tol=_FLAT * float(np.ptp(places))) < 2:
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


def places_of(system: ContactSystem) -> tuple[Array, tuple[str, str], dict[str, Array], Array]:
    """(N, 2) places of the nodes, names of the axes, names with places of contacts not in one plane, side by side, turns to the map."""
    contacts = {} if system.contact is None else {name: np.flatnonzero(system.contact == name) for name in dict.fromkeys(system.contact.tolist())}
    if len(contacts) < 2 or np.ptp(system.frames, axis=0).max() <= _FLAT:
        try:
            seen, labels, turn = _seen(system, np.arange(system.nodes))
            return seen, labels, {}, turn
        except ModelError:
            if len(contacts) < 2:
                raise
    places, turn, names, right = np.zeros((system.nodes, 2)), np.zeros((system.nodes, 2, 2)), {}, 0.0
    for name, own in contacts.items():
        seen, _, turn[own] = _seen(system, own)
        low, high = seen.min(axis=0), seen.max(axis=0)
        places[own] = seen + [right - low[0], -(low[1] + high[1]) / 2]
        names[name] = np.array([right + (high[0] - low[0]) / 2, (high[1] - low[1]) / 2])
        right += 1.25 * (high[0] - low[0])
    return places, ("first direction, contact by contact", "second direction"), names, turn


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
            raise ModelError("plot: the contact is not flat, and its sides face each other or away; make a contact of each side, or use to_frame()")
    if about:
        along = np.stack([around / radii[:, None], np.repeat(axis[None], len(own), axis=0)], axis=1)
        places = np.column_stack([_unrolled(points, along[:, 0], axis), points @ axis])
        labels = "unrolled around the axis of the face", "along that axis"
    else:
        along = np.repeat(view[None, :2], len(own), axis=0)
        places, labels = points @ view[:2].T, (_along(view[0], f"first {of}"), _along(view[1], f"second {of}"))
    if len(np.unique(np.round(places / (_FLAT * (np.ptp(places) or 1.0))), axis=0)) < len(own):
        raise ModelError("plot: the contact has nodes above each other, which one map would hide; use to_frame()")
    return places, labels, np.einsum("nij,nkj->nik", along, frames[:, :2])


def _unrolled(points: Array, around: Array, axis: Array) -> Array:
    """(n,) arcs, with the mean radius, of points around an axis in unit directions; cut in the widest gap."""
    first, second, _ = frames_of(axis[None])[0]
    angle = np.arctan2(around @ second, around @ first)
    sides = np.sort(angle)
    gaps = np.diff(sides, append=sides[0] + 2 * np.pi)
    widest = int((gaps > gaps.max() - _FLAT).argmax())  # the first one, where all are alike but for rounding
    outward = np.cross(around, axis)
    outward -= outward.mean(axis=0)
    radius = np.sum((points - points.mean(axis=0)) * outward) / np.sum(outward**2)
    return np.asarray(radius * ((angle - sides[widest] - gaps[widest] / 2) % (2 * np.pi) - np.pi))


def _along(tangent: Array, name: str) -> str:
    """Name of a direction: that of the coordinate axis where it is one."""
    axis = np.flatnonzero(tangent > 1.0 - _FLAT)
    return f"${'xyz'[axis[0]]}$" if len(axis) else f"position along the {name}"
