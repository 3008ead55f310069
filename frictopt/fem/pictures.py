"""Pictures of models with their contacts, supports and loads, and of fields in their bodies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform

from ..base import Array, Integers
from ..contact.face import together
from ..plots.draw import draw as draw
from ..plots.style import (
    BESIDE,
    BLACK,
    GREY,
    AnyAxes,
    Look,
    as_is,
    finish_axes,
    legend,
    new_axes,
    picture,
    series,
    slanted,
    spread,
)
from .bodies import Body
from .couplings import Coupling, DistributingCoupling, RigidCoupling
from .cyclic import Cyclic
from .load_pictures import load_arrows
from .model import ContactModel
from .modes import Modes
from .recovery import BodyFields, von_mises
from .supports import Support, nodes_of

Mesh: TypeAlias = Any  # of scikit-fem

# Frame of a name.
_NAME = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "pad": 2.0}


@dataclass(frozen=True)
class PictureSettings:
    """The numbers of the pictures of models."""

    # Order of names in space: above all faces, whose order matplotlib takes from their distance.
    above: float = 1e3
    # Speeds of sound of solids from rubber to diamond, metres per second.
    speeds_of_sound: tuple[float, float] = (20.0, 2e4)
    # Largest displacement of a field in a picture, as a share of the size of the bodies.
    deformed: float = 0.1
    # The title for a mode, whose size has no meaning.
    bent: float = 0.15
    # Sides of neighbouring faces are outlines in space if the cosine between the normals is at most
    # this: cos 30 degrees.
    outline: float = 0.87


_PICTURE = PictureSettings()

# Length units in metres.
_METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
# Mark of a support that holds one direction.
_MARKS = {"x": ">", "y": "^", "z": "v"}


def draw_edges(axes: Axes, mesh: Mesh, facets: Integers, scale: float = 1.0, **look: Any) -> None:
    """Draw some facets of a plane mesh; coordinates are divided by `scale`."""
    # One line with gaps is drawn far faster than many lines.
    edges = np.insert(mesh.p[:, mesh.facets[:, facets]] / scale, 2, np.nan, axis=1)
    axes.plot(*edges.transpose(0, 2, 1).reshape(2, -1), solid_capstyle="round", snap=False, **look)


def draw_mesh(
    axes: Axes,
    mesh: Mesh,
    color: str,
    scale: float = 1.0,
    *,
    thin: float = 0.12,
    label: str | None = None,
) -> None:
    """Draw the lines of a plane mesh, with its outline; coordinates are divided by `scale`."""
    look: Look = {"color": color, "zorder": 0.5}
    draw_edges(axes, mesh, np.arange(mesh.facets.shape[1]), scale, lw=thin, **look)
    draw_edges(axes, mesh, mesh.boundary_facets(), scale, lw=1.0, label=label, **look)


def _corners(mesh: Mesh, facets: Integers) -> Array:
    """(n, corners, 3) places of the corners of facets of a mesh in space."""
    return np.asarray(mesh.p[:, mesh.facets[:, facets]].transpose(2, 1, 0))


def _draw_bodies(
    axes: AnyAxes,
    meshes: Mapping[str, Mesh],
    count: int,
    *,
    in_space: bool,
    face: float,
    edge: float,
) -> None:
    """Bodies in the colours of their numbers: their meshes, in space their surfaces.

    `count` is the number of colours of the picture. `face` and `edge` are the opacities of the
    faces and of their sides in space.
    """
    if not in_space:
        for number, (name, mesh) in enumerate(meshes.items()):
            draw_mesh(axes, mesh, series(number, count)["color"], thin=0.2, label=as_is(name))
        return
    # All faces are one collection: matplotlib hides faces behind others only within one.
    polygons = list[Array]()
    faces = list[tuple[str, float]]()
    edges = list[tuple[str, float]]()
    for number, (name, mesh) in enumerate(meshes.items()):
        color = series(number, count)["color"]
        corners = _corners(mesh, mesh.boundary_facets())
        polygons += [*corners]
        faces += [(color, face)] * len(corners)
        edges += [(color, edge)] * len(corners)
        # A patch of the legend as pale as the faces would not show which body is meant.
        axes.plot([], [], [], marker="s", linestyle="none", color=color, label=as_is(name))
    axes.add_collection3d(
        Poly3DCollection(polygons, facecolors=faces, edgecolors=edges, linewidth=0.3)
    )


def _axes_of(bodies: Mapping[str, Body], ax: AnyAxes, panels: int = 1) -> tuple[Any, Array]:
    """Axes for bodies, and the (2, d) least and largest of their coordinates."""
    points = np.concatenate([body.mesh.p for body in bodies.values()], axis=1)
    in_space = len(points) == 3
    columns = ceil(panels**0.5)
    width, height = (8.0, 5.4) if in_space else (6.4, 4.8)
    if panels > 1:
        width, height = 0.6 * width * columns, 0.6 * height * ceil(panels / columns)
    axes = new_axes(ax, panels, (width, height), common_x=False, in_space=in_space, columns=columns)
    return axes, np.array([points.min(axis=1), points.max(axis=1)])


def _with_legend(axes: AnyAxes, ax: AnyAxes, in_space: bool) -> AnyAxes:
    """The axes with their legend, which stands beside the axes if the figure is new."""
    if ax is not None:
        legend(axes)
        return axes
    if not in_space:
        axes.figure.set_layout_engine("compressed")
        place: Look = {"loc": "outside right upper"}
    else:
        # Long joints need the whole width, so their legend is below them.
        place = {"loc": "outside lower center", "ncols": 4}
    axes.figure.legend(*axes.get_legend_handles_labels(), handlelength=2.2, **place)
    return axes


@picture.register
def model_picture(model: ContactModel, ax: AnyAxes | None = None) -> AnyAxes:
    """Each body in its colour, contacts in black, held nodes as marks, and loads as arrows.

    In space the surfaces of the bodies are drawn. Arrows show the directions of each load case.
    """
    (axes,), ends = _axes_of(model.bodies, ax)
    in_space = ends.shape[1] == 3
    length = (0.12 if in_space else 0.08) * float((ends[1] - ends[0]).max())
    meshes = {name: body.mesh for name, body in model.bodies.items()}
    count = len(meshes) + len(model.loads)
    _draw_bodies(axes, meshes, count, in_space=in_space, face=0.04, edge=0.5)
    _contacts(axes, model, in_space)
    _supports(axes, model, in_space)
    for number, case in enumerate(model.loads, start=len(model.bodies)):
        load_arrows(axes, model, case, length, series(number, count)["color"])
    if in_space:
        # Room for the arrows, where there are some.
        x, y, z = axes.xy_dataLim.intervalx, axes.xy_dataLim.intervaly, axes.zz_dataLim.intervalx
        drawn = np.transpose([x, y, z])
        ends = np.array([np.minimum(ends[0], drawn[0]), np.maximum(ends[1], drawn[1])])
    finish_axes(axes, ends, 0.1 * length)
    _with_legend(axes, ax, in_space)
    if in_space:
        _move_names_apart(axes)
    return axes


def _move_names_apart(axes: AnyAxes) -> None:
    """Move names in space upwards until none covers another, each with a line to its place."""
    axes.figure.draw_without_rendering()
    # Height of a name with its frame is 16 points.
    line_height = 16.0 * axes.figure.dpi / 72

    def on_screen(x: float, y: float, z: float) -> Array:
        return np.asarray(axes.transData.transform(proj_transform(x, y, z, axes.get_proj())[:2]))

    # Places and half widths of the names so far.
    taken = list[tuple[Array, float]]()

    def covers(spot: Array, half: float) -> bool:
        return any(
            abs(other[1] - spot[1]) < line_height and abs(other[0] - spot[0]) < half + other_half
            for other, other_half in taken
        )

    for text in sorted(axes.texts, key=lambda text: float(on_screen(*text.get_position_3d())[1])):
        x, y, z = text.get_position_3d()
        half = text.get_window_extent().width / 2
        height_of_unit = float(on_screen(x, y, z + 1.0)[1] - on_screen(x, y, z)[1])
        lifted = z
        while covers(on_screen(x, y, lifted), half):
            lifted += line_height / 4 / height_of_unit
        taken.append((on_screen(x, y, lifted), half))
        if lifted > z:
            text.set_position_3d((x, y, lifted))
            axes.plot([x, x], [y, y], [z, lifted], color=BLACK, lw=0.8, zorder=_PICTURE.above - 1)


def _contacts(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """The faces of body 1 of each contact, with their names if there are several contacts."""
    tilt = slanted([str(contact.name) for contact in model.contacts], "right", "top")
    for number, contact in enumerate(model.contacts):
        mesh = model.bodies[contact.body_1].mesh
        label = "contact" if number == 0 else None
        facets = mesh.boundaries[contact.boundary_1]
        middle = mesh.p[:, mesh.facets[:, facets]].mean(axis=(1, 2))
        if in_space:
            corners = _corners(mesh, facets)
            look: Look = {"facecolor": (BLACK, 0.6), "edgecolor": BLACK, "linewidth": 0.3}
            axes.add_collection3d(Poly3DCollection(corners, label=label, **look))
        else:
            draw_edges(axes, mesh, facets, color=BLACK, lw=2.5, label=label)
        if len(model.contacts) == 1:
            continue
        name = as_is(contact.name)
        if in_space:
            direction = "z" if tilt else None
            axes.text(*middle, name, direction, bbox=_NAME, zorder=_PICTURE.above)
        else:
            axes.annotate(
                name,
                middle,
                (0, -28),
                textcoords="offset points",
                bbox=_NAME,
                arrowprops={"arrowstyle": "-", "lw": 0.8},
                **({"ha": "center", "va": "top"} | tilt),
            )


def _supports(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """A mark at some nodes of each support, by the directions that it holds."""
    look: Look = {"markersize": 3.5} if in_space else {"markersize": 4.5, "clip_on": False}
    most_marks = 25 if in_space else 17
    labels = set[str]()
    for support in model.supports:
        body = model.bodies[support.body]
        if isinstance(support, Cyclic):
            nodes = [body.boundary_nodes(cut, "supports") for cut in (support.low, support.high)]
        else:
            nodes = [nodes_of(body, support.body, support.where)]
        marker, label = _mark(support, "xyz" if in_space else "xy")
        points = []
        for group in nodes:
            places = body.mesh.p[:, group]
            points.append(places[:, spread(places, most_marks)])
        axes.plot(
            *np.hstack(points),
            linestyle="none",
            marker=marker,
            color=BLACK,
            label=None if label in labels else label,
            **look,
        )
        labels.add(label)


def _mark(support: Support | Cyclic | Coupling, axes: str) -> tuple[str, str]:
    """Marker and label of a support."""
    if isinstance(support, Cyclic):
        return "o", "cut of a sector"
    if isinstance(support, RigidCoupling):
        return "P", "rigid"
    if isinstance(support, DistributingCoupling):
        return "X", "held in the mean"
    if support.normal:
        return "D", "held along normals"
    held = support.directions or axes
    marker = "s" if held == axes else _MARKS.get(held, "D")
    return marker, f"held in {', '.join(held)}"


@picture.register
def _fields(fields: BodyFields, ax: AnyAxes | None = None) -> AnyAxes:
    """Nodal von Mises stress in all bodies, in space on their surfaces.

    The colours end at the value that 99 of 100 nodes do not exceed.
    """
    (axes,), ends = _axes_of(fields.bodies, ax)
    in_space = ends.shape[1] == 3
    stress = {name: von_mises(rows) for name, rows in fields.stress.items()}
    highest = float(np.quantile(np.concatenate(list(stress.values())), 0.99))
    draw_stress = _stress_on_surfaces if in_space else _stress_in_plane
    colours = draw_stress(axes, fields.bodies, stress, highest)
    label = "von Mises stress (force per area)"
    place: Look = BESIDE if in_space else {}
    axes.figure.colorbar(colours, ax=axes, extend="max", label=label, **place)
    finish_axes(axes, ends, 0.0)
    if ax is None and not in_space:
        axes.figure.set_layout_engine("compressed")
    return axes


def _stress_on_surfaces(
    axes: AnyAxes, bodies: Mapping[str, Body], stress: Mapping[str, Array], highest: float
) -> Any:
    """Colour the surfaces of bodies in space by the mean stress of each face."""
    # All faces are one collection: matplotlib hides faces behind others only within one.
    faces = list[Array]()
    means = list[Array]()
    for name, body in bodies.items():
        facets = body.mesh.boundary_facets()
        faces += [*_corners(body.mesh, facets)]
        means.append(stress[name][body.mesh.facets[:, facets]].mean(axis=0))
    collection = Poly3DCollection(
        faces, array=np.concatenate(means), clim=(0.0, highest), cmap="viridis", rasterized=True
    )
    # Sides of faces show the shapes of bodies that have the same dark colour.
    collection.set(edgecolor=("white", 0.3), linewidth=0.3)
    return axes.add_collection3d(collection)


def _stress_in_plane(
    axes: AnyAxes, bodies: Mapping[str, Body], stress: Mapping[str, Array], highest: float
) -> Any:
    """Colour plane bodies by nodal stress, and draw their outlines."""
    look: Look = {"cmap": "viridis", "rasterized": True, "shading": "gouraud"}
    for name, body in bodies.items():
        t = body.mesh.t
        # A quadrilateral is drawn as two triangles.
        triangles = t.T if len(t) == 3 else np.concatenate([t[[0, 1, 2]].T, t[[0, 2, 3]].T])
        colours = axes.tripcolor(
            *body.mesh.p, triangles, stress[name], vmin=0.0, vmax=highest, **look
        )
        draw_edges(axes, body.mesh, body.mesh.boundary_facets(), color=BLACK, lw=0.6)
    return colours


def deformed(
    fields: BodyFields, ax: AnyAxes | None = None, enlarged: float | None = None
) -> AnyAxes:
    """Each body in its colour under its displacements, and in grey its outline as it was.

    In space the surfaces are drawn. `enlarged` is a factor on the displacements.
    """
    (axes,), ends = _axes_of(fields.bodies, ax)
    title = "displacements {scale:.4g} times enlarged; the largest is {largest:.4g} (length)"
    _moved(axes, ends, fields.bodies, fields.displacement, enlarged, title, _PICTURE.deformed)
    return _with_legend(axes, ax, ends.shape[1] == 3)


def mode(modes: Modes, ax: AnyAxes | None = None, numbers: Sequence[int] = (0,)) -> AnyAxes:
    """The shapes of some modes: each body in its colour, and in grey its outline at rest."""
    panels, ends = _axes_of(modes.bodies, ax, len(numbers))
    for axes, number in zip(panels, numbers, strict=True):
        shape = {name: shapes[number] for name, shapes in modes.shapes.items()}
        title = f"mode {number}: {modes.frequency[number]:.5g} {_unit_of_frequency(modes)}"
        _moved(axes, ends, modes.bodies, shape, None, title, _PICTURE.bent)
    _with_legend(panels[-1], ax, ends.shape[1] == 3)
    return together(panels)


def _unit_of_frequency(modes: Modes) -> str:
    """Hz, if the units of length and density are those of seconds.

    The speeds of sound of all bodies, in metres per unit of time, are then those of solids. With
    other units of time they are smaller or larger by a factor of a thousand.
    """
    length = (modes.units or ", ").split(", ")[1]
    materials = [body.material for body in modes.bodies.values()]
    speeds = [_METRES.get(length, np.nan) * np.sqrt(m.E / (m.density or np.nan)) for m in materials]
    low, high = _PICTURE.speeds_of_sound
    return "Hz" if all(low <= speed <= high for speed in speeds) else "cycles per unit of time"


def _moved(
    axes: AnyAxes,
    ends: Array,
    bodies: Mapping[str, Body],
    displacement: Mapping[str, Array],
    enlarged: float | None,
    title: str,
    share: float,
) -> None:
    """Draw bodies under displacements, enlarged by a factor.

    None: the largest displacement is a share of the size of the bodies.
    """
    in_space = ends.shape[1] == 3
    size = float((ends[1] - ends[0]).max())
    largest = max(float(np.linalg.norm(u, axis=0).max()) for u in displacement.values())
    scale = enlarged
    if scale is None:
        scale = share * size / largest if largest > 0 else 1.0
    outline: Look = {"color": GREY, "linewidth": 0.8, "zorder": 0.4}
    moved = dict[str, Mesh]()
    for number, (name, body) in enumerate(bodies.items()):
        mesh = body.mesh
        label = "as it was" if number == 0 else None
        if in_space:
            _outline(axes, mesh, label, **outline)
        else:
            draw_edges(axes, mesh, mesh.boundary_facets(), label=label, **outline)
        moved[name] = replace(mesh, doflocs=mesh.doflocs + scale * displacement[name])
    # Faces behind others must not shine through, so that bodies and bolts are told apart.
    _draw_bodies(axes, moved, len(moved), in_space=in_space, face=0.9, edge=0.4)
    axes.set_title(title.format(scale=scale, largest=largest))
    finish_axes(axes, ends, share * size)


def _outline(axes: AnyAxes, mesh: Mesh, label: str | None, **look: Any) -> None:
    """Draw the sides at which neighbouring faces of a body in space make an angle."""
    facets = mesh.facets[:, mesh.boundary_facets()]
    points = mesh.p[:, facets]
    # The diagonals of a triangle with a repeated corner are two of its sides.
    normals = np.cross(points[:, 2] - points[:, 0], points[:, -1] - points[:, 1], axis=0)
    normals /= np.linalg.norm(normals, axis=0)
    corners = len(facets)
    sides = np.concatenate(
        [facets[[corner, (corner + 1) % corners]].T for corner in range(corners)]
    )
    face = np.tile(np.arange(facets.shape[1]), corners)
    sides.sort(axis=1)
    order = np.lexsort(sides.T)
    order = order[sides[order, 0] != sides[order, 1]]
    sides, face = sides[order], face[order]
    # A closed surface has each side twice.
    first, second = face[::2], face[1::2]
    angled = np.abs((normals[:, first] * normals[:, second]).sum(axis=0)) <= _PICTURE.outline
    lines = mesh.p[:, sides[::2][angled]].transpose(1, 2, 0)
    axes.add_collection3d(Line3DCollection(lines, label=label, **look))
