"""Pictures of a contact, and of the shear forces at its nodes."""

from collections.abc import Sequence
from math import ceil
from typing import Any, TypeAlias

import numpy as np

from ..base import RESIDUAL, Array, Booleans
from ..plots.along import along, circle, friction_bounds, label_panels, lines_or_band
from ..plots.bodies import finish_axes
from ..plots.draw import draw as draw
from ..plots.face import face_map
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
    spread,
    together,
    unit,
)
from .diagnosis import in_contact
from .faces import faces_of
from .law import lengths, most_shear
from .system import ContactSystem

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
    """Draw shear over friction bound of the reactions at K corners, with circles at some nodes.

    No ratio is drawn where the bound is zero up to rounding. In the plane all corners are drawn, or
    those with the largest circles if there are many. In space maps show the corner `at`, with the
    circles of all corners, and the slip as arrows.
    """
    system = answer.system
    bound = most_shear(system, answer.friction, p)
    name = r"\min(f p, c)" if system.capped else "(f p)"
    if system.tangents == 2:
        ratio = _ratios(lengths(q[at], p[at]), bound[at])
        largest = float(np.nanmax(ratio, initial=0.0))
        areas = np.zeros(system.nodes)
        for nodes, _, area in circles.values():
            np.add.at(areas, np.ravel(nodes), area)
        return face_map(
            panels,
            faces_of(system),
            ratio,
            rf"$|q| / {name}$ at {names[at]}",
            most=largest if largest > 1.0 + RESIDUAL else 1.0,
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
        color = looks[corner]["color"]
        circle(axes, system.x[nodes], ratio[corner, nodes], senses, areas, color, label)
        label = None
    # The axis ends at 3, or a node with almost no pressure would flatten all other lines.
    height = np.clip(1.1 * float(np.nanmax(np.abs(ratio), initial=0.0)), 1.25, 3.0)
    axes.set_ylim(-height, height)
    label_panels([axes], system, zero=False)
    if opened is not None and opened.any():
        # They carry nothing.
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
def _system(system: ContactSystem, ax: AnyAxes = None) -> AnyAxes:
    """The points of a contact with their normals; in the plane also pressures of the load cases.

    The pressures are those of the bonded contact under each unit load. If the widths are not known,
    nodal forces are drawn.
    """
    in_space = system.tangents == 2
    size = (6.4, 4.8) if in_space else (6.4, 5.4)
    panels = new_axes(ax, 1 if in_space else 2, size, common_x=False, in_space=in_space)
    upper, *below = panels
    ends = np.array([system.points.min(axis=0), system.points.max(axis=0)])
    # More normals would hide each other. They are a tenth of the size of the contact.
    drawn = spread(system.points.T, 60)
    length = 0.1 * float(np.ptp(ends, axis=0).max() or 1.0)
    upper.plot(*system.points.T, ".", color=BLACK)
    look: Look = {} if in_space else {"width": 0.003}
    arrows(upper, system.points[drawn], length * system.normals[drawn], color=BLUE, **look)
    upper.set_title("nodes, and normals into body 1")
    finish_axes(upper, ends, length)
    if below:
        upper.set(adjustable="datalim")
        name = "bonded pressure\n(force per area)"
        if system.width is None:
            name = f"bonded normal force\n{unit('force', system.per_depth)}"
        width = 1.0 if system.width is None else system.width
        pressures = {f"{as_is(case)} = 1": p / width for case, (_, p) in system.bonded.items()}
        along(below, system, [(name, pressures)])
    return together(panels)
