"""How the faces of contacts in space are seen on a map: along their normal, or unrolled."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base import Array, Integers
from ..errors import ModelError
from .frames import frames_of
from .system import ContactSystem


@dataclass(frozen=True)
class ViewSettings:
    """The numbers that choose the view of a face."""

    # Differences of directions up to this number are rounding, and so are differences of places up
    # to this share of the size of the contact.
    rounding: float = 1e-9
    # A face is curved about an axis if the second spread of its normals is at least this share of
    # the first one. The normals of two flat sides spread in one direction only.
    spread: float = 0.1
    # A face is seen along its mean normal if the cosines between this mean and all normals exceed
    # this limit. Else it is unrolled.
    cap: float = 0.5
    # The same limit for faces that cannot be unrolled.
    not_steep: float = 0.1


_VIEW = ViewSettings()


class Face(NamedTuple):
    """A map: a contact, or several contacts in one plane, without a name.

    `nodes` (n,) are the numbers of its nodes, `places` (n, 2) their places on the map, `labels`
    names the axes of the map, and `turn` (n, 2, 2) takes slips to directions on the map.
    """

    contact: str
    nodes: Integers
    places: Array
    labels: tuple[str, str]
    turn: Array


def faces_of(system: ContactSystem) -> list[Face]:
    """A single face if all nodes lie beside each other in a plane; else a face for each contact."""
    names = [] if system.contact is None else list(dict.fromkeys(system.contact.tolist()))
    every_node = np.arange(system.nodes)
    if len(names) < 2:
        return [_face_of(system, "", every_node)]
    if np.ptp(system.frames, axis=0).max() <= _VIEW.rounding:
        try:
            return [_face_of(system, "", every_node)]
        except ModelError:
            pass  # contacts above each other have a map each
    return [_face_of(system, name, np.flatnonzero(system.contact == name)) for name in names]


def _face_of(system: ContactSystem, contact: str, nodes: Integers) -> Face:
    """The map of some nodes: seen along their mean normal, or unrolled about an axis."""
    frames = system.frames[nodes]
    points = system.points[nodes]
    normals = frames[:, 2]
    if np.abs(frames - frames[0]).max() <= _VIEW.rounding:
        places, labels, directions = _seen_along(points, frames[0], "tangent")
    else:
        mean = normals.mean(axis=0)
        axis, turns_on = _axis_of(normals)
        smallest_cosine = _VIEW.cap if turns_on else _VIEW.not_steep
        if (normals @ mean).min() > smallest_cosine * np.linalg.norm(mean):
            view = frames_of(mean[None])[0]
            places, labels, directions = _seen_along(points, view, "tangent of the mean plane")
        elif turns_on:
            places, labels, directions = _seen_unrolled(points, normals, axis)
        else:
            raise ModelError(
                "plot: the contact is not flat, and its sides face in opposite directions; make a "
                "contact of each side, or use to_frame()"
            )
    grid = np.round(places / (_VIEW.rounding * (np.ptp(places) or 1.0)))
    if len(np.unique(grid, axis=0)) < len(nodes):
        raise ModelError(
            "plot: some nodes of the contact would hide others on a map; use to_frame()"
        )
    return Face(
        contact, nodes, places, labels, np.einsum("nij,nkj->nik", directions, frames[:, :2])
    )


def _axis_of(normals: Array) -> tuple[Array, bool]:
    """The axis about which a face is curved, and whether the face is curved about it.

    No normal of a face that is curved about an axis is nearly parallel to it.
    """
    _, sizes, directions = np.linalg.svd(normals - normals.mean(axis=0), full_matrices=False)
    axis = directions[-1]
    axis = axis * np.sign(axis[np.abs(axis).argmax()])
    sines = np.linalg.norm(np.cross(axis, normals), axis=1)
    return axis, bool(sizes[1] > _VIEW.spread * sizes[0] and sines.min() > _VIEW.cap)


def _seen_along(points: Array, view: Array, tangent: str) -> tuple[Array, tuple[str, str], Array]:
    """Places on a plane with the tangents `view`; names of the axes; (n, 2, 3) directions."""
    labels = _axis_name(view[0], f"first {tangent}"), _axis_name(view[1], f"second {tangent}")
    directions = np.repeat(view[None, :2], len(points), axis=0)
    return points @ view[:2].T, labels, directions


def _seen_unrolled(
    points: Array, normals: Array, axis: Array
) -> tuple[Array, tuple[str, str], Array]:
    """Places on a face unrolled about an axis; names of the axes; (n, 2, 3) directions."""
    around = np.cross(axis, normals)
    around = around / np.linalg.norm(around, axis=1)[:, None]
    directions = np.stack([around, np.repeat(axis[None], len(points), axis=0)], axis=1)
    places = np.column_stack([_arcs(points, around, axis), points @ axis])
    return places, ("unrolled around the axis of the face", "along that axis"), directions


def _arcs(points: Array, around: Array, axis: Array) -> Array:
    """(n,) arcs of points about an axis, with the mean radius, cut in the widest gap.

    `around` (n, 3) are the unit directions about the axis.
    """
    first, second, _ = frames_of(axis[None])[0]
    angle = np.arctan2(around @ second, around @ first)
    sides = np.sort(angle)
    gaps = np.diff(sides, append=sides[0] + 2 * np.pi)
    # If gaps are equal up to rounding, the first of them is taken.
    widest = int((gaps > gaps.max() - _VIEW.rounding).argmax())
    cut = sides[widest] + gaps[widest] / 2

    outward = np.cross(around, axis)
    outward -= outward.mean(axis=0)
    radius = np.sum((points - points.mean(axis=0)) * outward) / np.sum(outward**2)
    return np.asarray(radius * ((angle - cut) % (2 * np.pi) - np.pi))


def _axis_name(tangent: Array, name: str) -> str:
    """Name of a direction: x, y or z if it is one of these."""
    for number, letter in enumerate("xyz"):
        if tangent[number] > 1.0 - _VIEW.rounding:
            return f"${letter}$"
        if tangent[number] < _VIEW.rounding - 1.0:
            return f"$-{letter}$"
    return f"position along the {name}"
