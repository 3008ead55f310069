"""How faces of contacts are seen on maps: along their normal, or in space if they are curved."""

import numpy as np

from ..base import Array, Integers
from ..plots.face import Face
from .frames import frames_of
from .system import ContactSystem

# Differences of directions up to this number are rounding, and so are differences of places up to
# this share of the size of the contact.
_ROUNDING = 1e-9
# A face is seen along its mean normal if the cosines between this mean and all normals exceed this.
_NOT_STEEP = 0.5


def faces_of(system: ContactSystem) -> list[Face]:
    """A single face if all nodes lie beside each other in a plane; else a face for each contact.

    If one of the faces is curved, or some of its nodes hide others, all places are in space.
    """
    every_node = np.arange(system.nodes)
    groups = {"": every_node}
    if system.contact is not None and len(set(system.contact)) > 1:
        in_plane = np.ptp(system.frames, axis=0).max() <= _ROUNDING
        if not in_plane or _seen_along_normal(system, "", every_node) is None:
            names = dict.fromkeys(system.contact.tolist())
            groups = {name: np.flatnonzero(system.contact == name) for name in names}
    faces = [_seen_along_normal(system, name, nodes) for name, nodes in groups.items()]
    flat = [face for face in faces if face is not None]
    if len(flat) == len(faces):
        return flat
    return [
        Face(
            name,
            nodes,
            system.points[nodes],
            ("$x$", "$y$"),
            system.frames[nodes, :2].transpose(0, 2, 1),
            _share(system, nodes),
        )
        for name, nodes in groups.items()
    ]


def _seen_along_normal(system: ContactSystem, contact: str, nodes: Integers) -> Face | None:
    """The map of some nodes, seen along their mean normal; None if it does not show all of them."""
    frames = system.frames[nodes]
    points = system.points[nodes]
    view, name = frames[0], "tangent"
    if np.abs(frames - view).max() > _ROUNDING:
        mean = frames[:, 2].mean(axis=0)
        if (frames[:, 2] @ mean).min() <= _NOT_STEEP * np.linalg.norm(mean):
            return None
        view, name = frames_of(mean[None])[0], "tangent of the mean plane"
    places = points @ view[:2].T
    grid = np.round(places / (_ROUNDING * (np.ptp(places) or 1.0)))
    if len(np.unique(grid, axis=0)) < len(nodes):
        return None
    labels = _axis_name(view[0], f"first {name}"), _axis_name(view[1], f"second {name}")
    turn = np.einsum("ij,nkj->nik", view[:2], frames[:, :2])
    return Face(contact, nodes, places, labels, turn, _share(system, nodes))


def _share(system: ContactSystem, nodes: Integers) -> Array:
    """(n,) share of each of some nodes in their area; alike if areas are unknown."""
    width = np.ones(len(nodes)) if system.width is None else system.width[nodes]
    return np.asarray(width / width.sum())


def _axis_name(tangent: Array, name: str) -> str:
    """Name of a direction: x, y or z if it is one of these."""
    for number, letter in enumerate("xyz"):
        if abs(tangent[number]) > 1.0 - _ROUNDING:
            return f"${letter}$" if tangent[number] > 0 else f"$-{letter}$"
    return name
