"""Faces of contacts in space on one map: seen along their normals, or unrolled about an axis."""

import numpy as np

from ..contact import Array, ContactSystem, Integers
from ..errors import ModelError
from ..fem.interface import frames_of

_BETWEEN = 0.25  # distance of contacts that stand side by side, widths of the left one
_LEAST = 0.1  # spread of normals over the largest: that of two flat sides is none; cosine between normals and their mean
_CAP = 0.5  # the same cosine: faces that turn on about an axis are unrolled; sine between normals and such an axis
FLAT = 1e-9  # difference of directions, of nodes in one plane or at one angle; distance of nodes at one place, over the size of the contact


def places_of(system: ContactSystem) -> tuple[Array, tuple[str, str], dict[str, Array], Array]:
    """(N, 2) places of the nodes, names of the axes, names with places of contacts not in one plane, which stand side by side, turns for `turned`."""
    contacts = {} if system.contact is None else {name: np.flatnonzero(system.contact == name) for name in dict.fromkeys(system.contact.tolist())}
    if len(contacts) < 2 or np.ptp(system.frames, axis=0).max() <= FLAT:
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
        right += (1 + _BETWEEN) * (high[0] - low[0])
    return places, ("first direction, contact by contact", "second direction"), names, turn


def turned(turn: Array, vectors: Array) -> Array:
    """Vectors (..., N, 2) along the tangents as those of a map."""
    return np.asarray(np.einsum("nik,...nk->...ni", turn, vectors))


def _seen(system: ContactSystem, own: Integers) -> tuple[Array, tuple[str, str], Array]:
    """(n, 2) places of some nodes, names of the axes, and turns: seen along the mean normal, or unrolled about the axis of a face that turns on."""
    frames, points = system.frames[own], system.points[own]
    normals, mean = frames[:, 2], frames[:, 2].mean(axis=0)
    view, of, about = frames[0], "tangent", False
    if np.abs(frames - view).max() > FLAT:
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
    if len(np.unique(np.round(places / (FLAT * (np.ptp(places) or 1.0))), axis=0)) < len(own):
        raise ModelError("plot: the contact has nodes above each other, which one map would hide; use to_frame()")
    return places, labels, np.einsum("nij,nkj->nik", along, frames[:, :2])


def _unrolled(points: Array, around: Array, axis: Array) -> Array:
    """(n,) arcs, with the mean radius, of points around an axis in unit directions; cut in the widest gap."""
    first, second, _ = frames_of(axis[None])[0]
    angle = np.arctan2(around @ second, around @ first)
    sides = np.sort(angle)
    gaps = np.diff(sides, append=sides[0] + 2 * np.pi)
    widest = int((gaps > gaps.max() - FLAT).argmax())  # the first one, where all are alike but for rounding
    outward = np.cross(around, axis)
    outward -= outward.mean(axis=0)
    radius = np.sum((points - points.mean(axis=0)) * outward) / np.sum(outward**2)
    return np.asarray(radius * ((angle - sides[widest] - gaps[widest] / 2) % (2 * np.pi) - np.pi))


def _along(tangent: Array, name: str) -> str:
    """Name of a direction: that of the coordinate axis where it is one."""
    axis = np.flatnonzero(tangent > 1.0 - FLAT)
    return f"${'xyz'[axis[0]]}$" if len(axis) else f"position along the {name}"
