"""Pictures of models: the meshes of their bodies, contacts, supports and loads; fields in the bodies; and of contact systems."""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform

from ..base import Array, Integers
from ..plots.draw import draw as draw
from ..plots.style import (
    BESIDE,
    BLACK,
    GREY,
    AnyAxes,
    Look,
    arrows,
    finish_axes,
    legend,
    new_axes,
    picture,
    series,
    slanted,
    spread,
)
from .bodies import Body
from .cyclic import Cyclic
from .elasticity import integration_points
from .loads import Pressure, Traction
from .model import ContactModel
from .modes import Modes
from .recovery import BodyFields, von_mises
from .supports import nodes_of

Mesh: TypeAlias = Any  # of scikit-fem

_NAME = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "pad": 2.0}
_ABOVE = (
    1e3  # of names in space: above all faces, to which matplotlib gives numbers by their distance
)
_LINE = 16.0  # height of a name in space with its frame, points
_PRESSES = (
    1e-3  # cosine between a traction and the inward normal from which on its arrow ends on the face
)


def draw_edges(axes: Axes, mesh: Mesh, facets: Integers, scale: float = 1.0, **look: Any) -> None:
    """Draw some facets of a plane mesh; coordinates are divided by `scale`."""
    edges = np.insert(
        mesh.p[:, mesh.facets[:, facets]] / scale, 2, np.nan, axis=1
    )  # one line with gaps is drawn far faster than many lines
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
    draw_edges(axes, mesh, np.arange(mesh.facets.shape[1]), scale, color=color, lw=thin, zorder=0.5)
    draw_edges(
        axes, mesh, mesh.boundary_facets(), scale, color=color, lw=1.0, zorder=0.5, label=label
    )


def _faces(
    axes: AnyAxes,
    mesh: Mesh,
    facets: Integers,
    color: str,
    face: float,
    edge: float,
    label: str | None,
) -> None:
    """Draw facets of a mesh in space, with the opacities of faces and edges."""
    corners = mesh.p[:, mesh.facets[:, facets]].transpose(2, 1, 0)
    axes.add_collection3d(
        Poly3DCollection(
            corners, facecolor=(color, face), edgecolor=(color, edge), linewidth=0.3, label=label
        )
    )


def _body(axes: AnyAxes, mesh: Mesh, number: int, name: str, face: float, edge: float) -> None:
    """A body in the colour of its number: its mesh, in space its surface."""
    color = series(number)["color"]
    if mesh.dim() == 3:
        _faces(axes, mesh, mesh.boundary_facets(), color, face, edge, name)
    else:
        draw_mesh(axes, mesh, color, thin=0.2, label=name)


def _axes_of(bodies: Mapping[str, Body], ax: AnyAxes) -> tuple[AnyAxes, Array]:
    """Axes for bodies, and the (2, d) least and largest of their coordinates."""
    points = np.concatenate([body.mesh.p for body in bodies.values()], axis=1)
    in_space = len(points) == 3
    return new_axes(ax, size=(8.0, 5.4) if in_space else (6.4, 4.8), in_space=in_space)[
        0
    ], np.array([points.min(axis=1), points.max(axis=1)])


def _named(axes: AnyAxes, ax: AnyAxes, in_space: bool) -> AnyAxes:
    """The axes with their legend, beside them where the figure is our own."""
    if ax is not None:
        legend(axes)
        return axes
    if not in_space:
        axes.figure.set_layout_engine("compressed")
    beside: Look = (
        {"borderpad": 2.5} if in_space else {}
    )  # the layout leaves no room for the names of axes in space
    axes.figure.legend(loc="outside right upper", handlelength=2.2, **beside)
    return axes


@picture.register
def model_picture(model: ContactModel, ax: AnyAxes | None = None) -> AnyAxes:
    """Each body in its colour (in space its surface), contacts in black, held nodes as marks, and the directions of each load case as arrows."""
    axes, ends = _axes_of(model.bodies, ax)
    in_space = ends.shape[1] == 3
    length = (0.12 if in_space else 0.08) * float((ends[1] - ends[0]).max())
    for number, (name, body) in enumerate(model.bodies.items()):
        _body(axes, body.mesh, number, name, 0.04, 0.5)
    _contacts(axes, model, in_space)
    _supports(axes, model, in_space)
    for number, case in enumerate(model.loads, start=len(model.bodies)):
        _load(axes, model, case, length, series(number)["color"])
    finish_axes(axes, ends, length)
    _named(axes, ax, in_space)
    if in_space:
        _apart(axes)
    return axes


def _apart(axes: AnyAxes) -> None:
    """Move names in space upwards until none covers another one, each with a line to its place."""
    axes.figure.draw_without_rendering()
    place, up = axes.transData, axes.figure.dpi / 72 * _LINE

    def seen(x: float, y: float, z: float) -> Array:
        return np.asarray(place.transform(proj_transform(x, y, z, axes.get_proj())[:2]))

    taken = list[tuple[Array, float]]()
    for text in sorted(axes.texts, key=lambda text: float(seen(*text.get_position_3d())[1])):
        x, y, z = text.get_position_3d()
        half, lifted = text.get_window_extent().width / 2, z
        rise = float(seen(x, y, z + 1.0)[1] - seen(x, y, z)[1])
        while any(
            abs(at[1] - seen(x, y, lifted)[1]) < up
            and abs(at[0] - seen(x, y, lifted)[0]) < half + wide
            for at, wide in taken
        ):
            lifted += up / 4 / rise
        taken.append((seen(x, y, lifted), half))
        if lifted > z:
            text.set_position_3d((x, y, lifted))
            axes.plot([x, x], [y, y], [z, lifted], color=BLACK, lw=0.8, zorder=_ABOVE - 1)


def _contacts(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """The faces of body 1 of each contact; the names of several ones."""
    tilt = slanted([str(contact.name) for contact in model.contacts], "right", "top")
    for number, contact in enumerate(model.contacts):
        mesh, label = model.bodies[contact.body_1].mesh, "contact" if number == 0 else None
        facets = mesh.boundaries[contact.boundary_1]
        middle = mesh.p[:, mesh.facets[:, facets]].mean(axis=(1, 2))
        if in_space:
            _faces(axes, mesh, facets, BLACK, 0.6, 1.0, label)
        else:
            draw_edges(axes, mesh, facets, color=BLACK, lw=2.5, label=label)
        if len(model.contacts) > 1 and in_space:
            axes.text(*middle, contact.name, "z" if tilt else None, bbox=_NAME, zorder=_ABOVE)
        elif len(model.contacts) > 1:
            look = {"ha": "center", "va": "top"} | tilt
            axes.annotate(
                contact.name,
                middle,
                (0, -28),
                textcoords="offset points",
                bbox=_NAME,
                arrowprops={"arrowstyle": "-", "lw": 0.8},
                **look,
            )


def _supports(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """A mark at some nodes of each support, by the directions that it holds."""
    look: Look = {"markersize": 3.5} if in_space else {"markersize": 4.5, "clip_on": False}
    everything, named = "xyz" if in_space else "xy", set[str]()
    for support in model.supports:
        body, most = model.bodies[support.body], 25 if in_space else 17
        if isinstance(support, Cyclic):
            parts, marker, label = (
                [body.boundary_nodes(cut, "supports") for cut in (support.low, support.high)],
                "o",
                "cut of a sector",
            )
        else:
            parts, held = (
                [nodes_of(body, support.body, support.where)],
                support.directions or everything,
            )
            marker, label = (
                "s" if held == everything else {"x": ">", "y": "^", "z": "v"}.get(held, "D"),
                f"held in {', '.join(held)}",
            )
            marker, label = ("D", "held along normals") if support.normal else (marker, label)
        points = np.hstack(
            [body.mesh.p[:, nodes][:, spread(body.mesh.p[:, nodes], most)] for nodes in parts]
        )
        axes.plot(
            *points,
            linestyle="none",
            marker=marker,
            color=BLACK,
            label=None if label in named else label,
            **look,
        )
        named.add(label)


def _load(axes: AnyAxes, model: ContactModel, case: str, length: float, color: str) -> None:
    """Arrows of equal length along loaded boundaries: those that press end there, others begin there. The legend names what acts on no surface."""
    others, in_space = [], model.kinematics == "space"
    for part in model.loads[case]:
        if not isinstance(part, Traction | Pressure):
            others.append(re.sub("(?<!^)(?=[A-Z])", " ", type(part).__name__).lower())
            continue
        body = model.bodies[part.body]
        points, traction, normals = _mean_tractions(part, body)
        strength = np.linalg.norm(traction, axis=0)
        chosen = [facet for facet in spread(points, 9) if strength[facet] > 0]
        points, step = points[:, chosen], traction[:, chosen] / strength[chosen] * length
        pressing = (step * normals[:, chosen]).sum(axis=0) < -_PRESSES * length
        look: Look = {"linewidth": 1.0, "arrow_length_ratio": 0.35}
        if not in_space:
            look = {"units": "inches", "width": 0.014, "headwidth": 6, "zorder": 2.5}
        arrows(axes, (points - np.where(pressing, step, 0.0)).T, step.T, color=color, **look)
    nowhere: list[list[float]] = [[]] * (3 if in_space else 2)
    kinds = [f"{count} x {kind}" if count > 1 else kind for kind, count in Counter(others).items()]
    axes.plot(
        *nowhere,
        color=color,
        marker=">",
        label=f"load {case}" + (f" ({', '.join(kinds)})" if kinds else ""),
    )


def _mean_tractions(part: Traction | Pressure, body: Body) -> tuple[Array, Array, Array]:
    """(d, m) middles of the loaded facets, and the mean traction and the mean outward normal on each.

    Nodal forces would mislead: at corners of quadratic elements they are zero up to rounding, or
    point against the load.
    """
    points, normals, sizes, *_ = integration_points(
        body.mesh, body.boundary(part.boundary, "loads")
    )
    share = sizes / sizes.sum(axis=1, keepdims=True)
    at, traction, normal = (
        (values * share).sum(axis=2) for values in (points, part._on_face(points, normals), normals)
    )
    return at, traction, normal


@picture.register
def _fields(fields: BodyFields, ax: AnyAxes | None = None) -> AnyAxes:
    """Von Mises stress in all bodies, in space on their surfaces, nodal values; the colours end at the value that 99 of 100 nodes do not exceed."""
    axes, ends = _axes_of(fields.bodies, ax)
    stress = {name: von_mises(rows) for name, rows in fields.stress.items()}
    most, look = (
        float(np.quantile(np.concatenate(list(stress.values())), 0.99)),
        {"cmap": "viridis", "rasterized": True},
    )
    in_space = ends.shape[1] == 3
    if in_space:  # one collection, for matplotlib hides faces behind others only within one
        corners = {
            name: body.mesh.facets[:, body.mesh.boundary_facets()]
            for name, body in fields.bodies.items()
        }
        faces = [
            face
            for name, body in fields.bodies.items()
            for face in body.mesh.p[:, corners[name]].transpose(2, 1, 0)
        ]
        means = np.concatenate(
            [stress[name][nodes].mean(axis=0) for name, nodes in corners.items()]
        )
        colours = axes.add_collection3d(
            Poly3DCollection(faces, array=means, clim=(0.0, most), **look)
        )
    else:
        for name, body in fields.bodies.items():
            t = body.mesh.t
            triangles = t.T if len(t) == 3 else np.concatenate([t[[0, 1, 2]].T, t[[0, 2, 3]].T])
            colours = axes.tripcolor(
                *body.mesh.p,
                triangles,
                stress[name],
                shading="gouraud",
                vmin=0.0,
                vmax=most,
                **look,
            )
            draw_edges(axes, body.mesh, body.mesh.boundary_facets(), color=BLACK, lw=0.6)
    axes.figure.colorbar(
        colours,
        ax=axes,
        extend="max",
        label="von Mises stress (force per area)",
        **(BESIDE if in_space else {}),
    )
    finish_axes(axes, ends, 0.0)
    if ax is None and not in_space:
        axes.figure.set_layout_engine("compressed")
    return axes


def deformed(
    fields: BodyFields, ax: AnyAxes | None = None, enlarged: float | None = None
) -> AnyAxes:
    """Each body in its colour under its displacements, in space its surface; in grey its outline as it was."""
    return _moved(
        fields.bodies,
        fields.displacement,
        ax,
        enlarged,
        "displacements {scale:.4g} times enlarged; the largest is {largest:.4g} (length)",
    )


def mode(modes: Modes, ax: AnyAxes | None = None, number: int = 0) -> AnyAxes:
    """The shape of one mode: each body in its colour, in space its surface; in grey its outline at rest."""
    shape = {name: shapes[number] for name, shapes in modes.shapes.items()}
    return _moved(
        modes.bodies,
        shape,
        ax,
        None,
        f"mode {number}: {modes.frequency[number]:.5g} cycles per unit of time",
    )


def _moved(
    bodies: Mapping[str, Body],
    displacement: Mapping[str, Array],
    ax: AnyAxes | None,
    enlarged: float | None,
    title: str,
) -> AnyAxes:
    """Bodies under their displacements, so many times enlarged, or the largest a tenth of the size of the picture."""
    axes, ends = _axes_of(bodies, ax)
    in_space, size = ends.shape[1] == 3, float((ends[1] - ends[0]).max())
    largest = max(float(np.linalg.norm(u, axis=0).max()) for u in displacement.values())
    scale = (0.1 * size / largest if largest > 0 else 1.0) if enlarged is None else enlarged
    for number, (name, body) in enumerate(bodies.items()):
        if not in_space:
            draw_edges(
                axes,
                body.mesh,
                body.mesh.boundary_facets(),
                color=GREY,
                lw=0.8,
                zorder=0.4,
                label="as it was" if number == 0 else None,
            )
        _body(
            axes,
            replace(body.mesh, doflocs=body.mesh.doflocs + scale * displacement[name]),
            number,
            name,
            0.25,
            0.6,
        )
    axes.set_title(title.format(scale=scale, largest=largest))
    finish_axes(axes, ends, 0.1 * size)
    return _named(axes, ax, in_space)
