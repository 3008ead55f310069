"""Pictures of a contact, and of the shear forces at its nodes."""

from collections.abc import Sequence
from math import ceil
from typing import Any, TypeAlias

import numpy as np

from ..base import RESIDUAL, Array, Booleans, Integers
from ..plots.along import along, friction_bounds, label_panels, lines_or_band
from ..plots.bodies import finish_axes
from ..plots.face import Face, face_map
from ..plots.style import (
    BLACK,
    BLUE,
    AnyAxes,
    Look,
    arrows,
    as_is,
    legend,
    new_axes,
    picture,
    rings,
    spread,
    together,
    unit,
)
from .components import frames_of
from .diagnosis import in_contact, names_of_several, nodes_of_contacts
from .law import lengths, most_shear
from .system import ContactSystem

# How faces of contacts are seen on maps: along their normal, or in space if they are curved.

# Differences of directions up to this number are rounding, and so are differences of places up to
# this share of the size of the contact.
_ROUNDING = 1e-9
# A face is seen along its mean normal if the cosine between each normal and the mean normal is
# above this number.
_NOT_STEEP = 0.5


def faces_of(system: ContactSystem) -> list[Face]:
    """A single face if all nodes lie beside each other in a plane; else a face for each contact.

    If one of the faces is curved, or some of its nodes hide others, all faces are drawn in space.
    """
    every_node = np.arange(system.nodes)
    groups = {"": every_node}
    if names_of_several(system) is not None:
        in_plane = np.ptp(system.frames, axis=0).max() <= _ROUNDING
        if not in_plane or _seen_along_normal(system, "", every_node) is None:
            contacts = nodes_of_contacts(system)
            groups = {name: np.flatnonzero(nodes) for name, nodes in contacts.items()}
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
    """(n,) share of each node in the area of all n nodes; equal shares if areas are unknown."""
    width = np.ones(len(nodes)) if system.width is None else system.width[nodes]
    return np.asarray(width / width.sum())


def _axis_name(tangent: Array, name: str) -> str:
    """Name of a direction: x, y or z if it is one of these."""
    for number, letter in enumerate("xyz"):
        if abs(tangent[number]) > 1.0 - _ROUNDING:
            return f"${letter}$" if tangent[number] > 0 else f"$-{letter}$"
    return name


Circles: TypeAlias = dict[int, tuple[Any, Any, Any]]
"""Corner -> nodes that limit the load there, their senses of slip, and areas of their circles."""

ONE_NODE = 60
"""Area of the circle round a node that limits the load by itself, points^2."""


def panels_of(ax: AnyAxes, system: ContactSystem) -> list[AnyAxes]:
    """Axes of a picture: one along a contact in the plane, in space a panel for each face."""
    if system.tangents == 1:
        return new_axes(ax)
    faces = faces_of(system)
    columns = ceil(len(faces) ** 0.5)
    side = 4.6 if len(faces) == 1 else 3.2  # inches
    size = (side * columns + 1.0, side * ceil(len(faces) / columns) + 0.6)
    in_space = faces[0].places.shape[1] == 3
    return new_axes(ax, len(faces), size, common_x=False, in_space=in_space, columns=columns)


def node_at(system: ContactSystem, node: int) -> str:
    """Text with the number and the place of a node."""
    name = f"node {node}{as_is(in_contact(system, node))}"
    if system.tangents == 1:
        return f"{name}, $x = {system.x[node]:.4g}$"
    place = ", ".join(f"{coordinate:.3g}" for coordinate in system.points[node])
    return f"{name} at ({place})"


def traction_axis(system: ContactSystem, traction: str, force: str) -> tuple[float | Array, str]:
    """The widths by which nodal forces are divided, 1 if unknown, and the name of their axis."""
    if system.width is None:
        return 1.0, f"{force}\n{unit('force', system.per_depth)}"
    return system.width, f"{traction}\n(force per area)"


def work_label(system: ContactSystem) -> str:
    """Name of the axis of the work of friction per cycle."""
    return f"work of friction per cycle\n{unit('force times length', system.per_depth)}"


def shear_ratios(
    panels: Sequence[AnyAxes],
    answer: Any,
    q: Array,
    p: Array,
    names: Sequence[str],
    circles: Circles,
    circles_label: str = "",
    at: int = 0,
    slip: Array | None = None,
    opened: Booleans | None = None,
) -> AnyAxes:
    """Draw the ratio of shear to friction bound at K corners, with circles at some nodes.

    No ratio is drawn where the bound is zero up to rounding. In the plane all corners are drawn; if
    there are many, only the corners with the largest circles. In space maps show the corner `at`,
    with the circles of all corners, and the slip as arrows.
    """
    system = answer.system
    bound = most_shear(system, answer.friction, p)
    name = r"\min(f p, c)" if system.capped else "(f p)"
    if system.tangents == 2:
        ratio = _ratios(lengths(q[at], p[at]), bound[at])
        areas = np.zeros(system.nodes)
        for nodes, _, area in circles.values():
            np.add.at(areas, np.ravel(nodes), area)
        return face_map(
            panels,
            faces_of(system),
            ratio,
            rf"$|q| / {name}$ at {names[at]}",
            most=float(np.nanmax(ratio, initial=1.0)),
            slip=None if slip is None else slip / system.stretch,
            slip_name="residual slip",
            opened=opened,
            circled=(areas, circles_label) if circles else None,
        )

    (axes,) = panels
    friction_bounds(axes, name)
    ratio = _ratios(q, bound)
    governing = sorted(circles, key=lambda corner: -float(np.sum(circles[corner][2]))) or [at]
    looks = lines_or_band(axes, system, ratio, names, governing)
    label: str | None = circles_label
    for corner in [corner for corner in looks if corner in circles]:
        nodes, senses, areas = circles[corner]
        # A node whose friction bound is zero has no ratio; its circle is drawn at +1 or -1, against
        # its slip.
        shown = ratio[corner, nodes]
        places = [system.x[nodes], np.where(np.isfinite(shown), shown, np.negative(senses))]
        rings(axes, np.column_stack(places), areas, label, looks[corner]["color"])
        label = None
    # The axis ends at 3 at most. Otherwise a node with almost no pressure would flatten all other
    # lines.
    height = np.clip(1.1 * float(np.nanmax(np.abs(ratio), initial=0.0)), 1.25, 3.0)
    axes.set_ylim(-height, height)
    label_panels([axes], system)
    if opened is not None and opened.any():
        # Open nodes carry no force.
        x = system.x[opened]
        axes.scatter(x, 0 * x, marker="v", s=20, zorder=3, label="open", color=BLACK)
    legend(axes)
    return axes


def _ratios(shear: Array, bound: Array) -> Array:
    """Shear divided by its friction bound; NaN if the bound is zero up to rounding."""
    ratio = np.full(shear.shape, np.nan)
    bears = bound > RESIDUAL * np.abs(bound).max()
    return np.asarray(np.divide(shear, bound, out=ratio, where=bears))


@picture.register
def _system(system: ContactSystem, ax: AnyAxes) -> AnyAxes:
    """The points of a contact with their normals; in the plane also pressures of the load cases.

    The pressures act in the bonded contact under each unit load. If the widths are not known, nodal
    forces are drawn.
    """
    in_space = system.tangents == 2
    size = (6.4, 4.8) if in_space else (6.4, 5.4)
    panels = new_axes(ax, 1 if in_space else 2, size, common_x=False, in_space=in_space)
    upper, *below = panels
    ends = np.array([system.points.min(axis=0), system.points.max(axis=0)])
    # More normals would hide each other. Each is drawn a tenth as long as the contact.
    drawn = spread(system.points.T, 60)
    length = 0.1 * float(np.ptp(ends, axis=0).max() or 1.0)
    upper.plot(*system.points.T, ".", color=BLACK)
    look: Look = {} if in_space else {"width": 0.003}
    arrows(upper, system.points[drawn], length * system.normals[drawn], color=BLUE, **look)
    upper.set_title("nodes, and normals into body 1")
    finish_axes(upper, ends, length)
    if below:
        upper.set(adjustable="datalim")
        width, name = traction_axis(system, "bonded pressure", "bonded normal force")
        pressures = {f"{as_is(case)} = 1": p / width for case, (_, p) in system.bonded.items()}
        along(below, system, [(name, pressures)])
    return together(panels)
