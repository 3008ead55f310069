"""Pictures of models: the meshes of their bodies, contacts, supports and loads; and of fields in the bodies."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..contact import Array, Integers
from ..fem.assembly import nodes_of
from ..fem.bodies import Body
from ..fem.loads import Pressure, Traction, surface_forces
from ..fem.model import ContactModel
from ..fem.recovery import BodyFields, von_mises
from ..scenes.scene import Scene
from .style import BLACK, GREY, legend, new_axes, picture, series, slanted

AnyAxes: TypeAlias = Any  # of matplotlib, in the plane or in space
Mesh: TypeAlias = Any  # of scikit-fem

_MOST_MARKS = 17, 25  # of each support, in the plane and in space
_ARROWS = 9  # of each loaded boundary
_NAME = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "pad": 2.0}
_TO_NAME = {"arrowstyle": "-", "lw": 0.8}
_ABOVE = 1e3  # of names in space: above all faces, to which matplotlib gives numbers by their distance
_SIZE = 6.4, 4.8  # inches
_LENGTH = 0.08, 0.12  # of an arrow, over the size of the model, in the plane and in space


def draw_edges(axes: Axes, mesh: Mesh, facets: Integers, scale: float = 1.0, **look: Any) -> None:
    """Draw some facets of a plane mesh; coordinates are divided by `scale`."""
    edges = np.insert(mesh.p[:, mesh.facets[:, facets]] / scale, 2, np.nan, axis=1)  # one line with gaps is drawn far faster than many lines
    axes.plot(*edges.transpose(0, 2, 1).reshape(2, -1), solid_capstyle="round", snap=False, **look)


def draw_mesh(axes: Axes, mesh: Mesh, color: str, scale: float = 1.0, *, thin: float = 0.12, label: str | None = None) -> None:
    """Draw the lines of a plane mesh, with its outline; coordinates are divided by `scale`."""
    draw_edges(axes, mesh, np.arange(mesh.facets.shape[1]), scale, color=color, lw=thin, zorder=0.5)
    draw_edges(axes, mesh, mesh.boundary_facets(), scale, color=color, lw=1.0, zorder=0.5, label=label)


@picture.register
def _model(model: ContactModel, ax: AnyAxes | None = None) -> AnyAxes:
    """Each body in its colour (in space its surface), contacts in black, held nodes as marks, and the directions of each load case as arrows."""
    in_space = model.kinematics == "space"
    axes: AnyAxes = new_axes(ax, size=_SIZE, in_space=in_space)[0]
    ends = _ends(model.bodies)
    length = _LENGTH[in_space] * float((ends[1] - ends[0]).max())
    for number, (name, body) in enumerate(model.bodies.items()):
        _body(axes, body.mesh, number, name, 0.04, 0.5)
    tilt = slanted([str(contact.name) for contact in model.contacts], "right", "top")
    for number, contact in enumerate(model.contacts):
        mesh, label = model.bodies[contact.body_1].mesh, "contact" if number == 0 else None
        facets = mesh.boundaries[contact.boundary_1]
        if in_space:
            _faces(axes, mesh, facets, facecolor=(BLACK, 0.6), edgecolor=BLACK, linewidth=0.3, label=label)
        else:
            draw_edges(axes, mesh, facets, color=BLACK, lw=2.5, label=label)
        if len(model.contacts) > 1:
            middle = mesh.p[:, mesh.facets[:, facets]].mean(axis=(1, 2))
            if in_space:
                axes.text(*middle, contact.name, "z" if tilt else None, bbox=_NAME, zorder=_ABOVE)
            else:
                look = {"ha": "center", "va": "top"} | tilt
                axes.annotate(contact.name, middle, (0, -28), textcoords="offset points", bbox=_NAME, arrowprops=_TO_NAME, **look)
    _supports(axes, model)
    for number, case in enumerate(model.loads, start=len(model.bodies)):
        _load(axes, model, case, length, series(number)["color"])
    finish(axes, ends, length)
    return _named(axes, in_space, own=ax is None)


@picture.register
def _scene(scene: Scene, ax: AnyAxes | None = None) -> AnyAxes:
    """Draw its model."""
    return picture(scene.model(), ax)


@picture.register
def _fields(fields: BodyFields, ax: AnyAxes | None = None) -> AnyAxes:
    """Von Mises stress in all bodies, in space on their surfaces, nodal values; the colours end at the value that 99 of 100 nodes do not exceed."""
    in_space = next(iter(fields.bodies.values())).mesh.dim() == 3
    axes: AnyAxes = new_axes(ax, size=_SIZE, in_space=in_space)[0]
    stress = {name: von_mises(rows) for name, rows in fields.stress.items()}
    look = {"cmap": "viridis", "rasterized": True}
    most = float(np.quantile(np.concatenate(list(stress.values())), 0.99))
    if in_space:  # one collection, for matplotlib hides faces behind others only within one
        corners = {name: body.mesh.facets[:, body.mesh.boundary_facets()] for name, body in fields.bodies.items()}
        faces = [face for name, body in fields.bodies.items() for face in body.mesh.p[:, corners[name]].transpose(2, 1, 0)]
        means = np.concatenate([stress[name][nodes].mean(axis=0) for name, nodes in corners.items()])
        colours = axes.add_collection3d(Poly3DCollection(faces, array=means, clim=(0.0, most), **look))
    else:
        for name, body in fields.bodies.items():
            t = body.mesh.t
            triangles = t.T if len(t) == 3 else np.concatenate([t[[0, 1, 2]].T, t[[0, 2, 3]].T])
            colours = axes.tripcolor(*body.mesh.p, triangles, stress[name], shading="gouraud", vmin=0.0, vmax=most, **look)
            draw_edges(axes, body.mesh, body.mesh.boundary_facets(), color=BLACK, lw=0.6)
    place = {"shrink": 0.6, "pad": 0.12} if in_space else {}  # beside the labels of the axis z
    axes.figure.colorbar(colours, ax=axes, extend="max", label="von Mises stress (force per area)", **place)
    finish(axes, _ends(fields.bodies), 0.0)
    if ax is None and not in_space:
        axes.figure.set_layout_engine("compressed")
    return axes


def deformed(fields: BodyFields, ax: AnyAxes | None = None, enlarged: float | None = None) -> AnyAxes:
    """Each body in its colour under its displacements, in space its surface; in grey its outline as it was."""
    ends = _ends(fields.bodies)
    in_space, size = ends.shape[1] == 3, float((ends[1] - ends[0]).max())
    axes: AnyAxes = new_axes(ax, size=_SIZE, in_space=in_space)[0]
    largest = max(float(np.linalg.norm(u, axis=0).max()) for u in fields.displacement.values())
    scale = (0.1 * size / largest if largest > 0 else 1.0) if enlarged is None else enlarged
    for number, (name, body) in enumerate(fields.bodies.items()):
        if not in_space:
            draw_edges(axes, body.mesh, body.mesh.boundary_facets(), color=GREY, lw=0.8, zorder=0.4, label="as it was" if number == 0 else None)
        _body(axes, replace(body.mesh, doflocs=body.mesh.doflocs + scale * fields.displacement[name]), number, name, 0.25, 0.6)
    axes.set_title(f"displacements {scale:.4g} times enlarged; the largest is {largest:.4g} (length)")
    finish(axes, ends, 0.1 * size)
    return _named(axes, in_space, own=ax is None)


def _ends(bodies: Mapping[str, Body]) -> Array:
    """(2, d) least and largest coordinates of bodies."""
    points = np.concatenate([body.mesh.p for body in bodies.values()], axis=1)
    return np.array([points.min(axis=1), points.max(axis=1)])


def _body(axes: AnyAxes, mesh: Mesh, number: int, name: str, face: float, edge: float) -> None:
    """A body in the colour of its number: its mesh, in space its surface, with the opacities of faces and edges."""
    color = series(number)["color"]
    if mesh.dim() == 3:
        _faces(axes, mesh, mesh.boundary_facets(), facecolor=(color, face), edgecolor=(color, edge), linewidth=0.3, label=name)
    else:
        draw_mesh(axes, mesh, color, thin=0.2, label=name)


def _named(axes: AnyAxes, in_space: bool, *, own: bool) -> AnyAxes:
    """The axes with their legend, beside them where the figure is our own."""
    if not own:
        legend(axes)
        return axes
    if not in_space:
        axes.figure.set_layout_engine("compressed")
    axes.figure.legend(loc="outside right upper", handlelength=2.2)
    return axes


def finish(axes: AnyAxes, ends: Array, length: float) -> None:
    """Names and limits of the axes, in space with room for the arrows."""
    axes.set(xlabel="$x$ (length)", ylabel="$y$ (length)")
    if ends.shape[1] == 2:
        axes.set_aspect("equal")
        return
    low, high = ends[0] - length, ends[1] + length
    axes.set_box_aspect(high - low)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), zlabel="$z$ (length)")
    axes.grid(False)
    for axis, share in zip((axes.xaxis, axes.yaxis, axes.zaxis), (high - low) / (high - low).max(), strict=True):
        axis.set_major_locator(MaxNLocator(max(1, round(5 * share))))  # as many numbers as the axis has room for


def _faces(axes: AnyAxes, mesh: Mesh, facets: Integers, **look: Any) -> Poly3DCollection:
    """Draw facets of a mesh in space."""
    return axes.add_collection3d(Poly3DCollection(mesh.p[:, mesh.facets[:, facets]].transpose(2, 1, 0), **look))


def _supports(axes: AnyAxes, model: ContactModel) -> None:
    named: set[str] = set()
    for support in model.supports:
        body = model.bodies[support.body]
        points = body.mesh.p[:, nodes_of(body, support)]
        chosen = points[:, spread(points, _MOST_MARKS[len(points) - 2])]
        held = support.directions or "xyz"[: len(points)]
        marker = "s" if len(held) == len(points) else {"x": ">", "y": "^", "z": "v"}.get(held, "D")
        label = None if held in named else f"held in {', '.join(held)}"
        named.add(held)
        look = {"markersize": 4.5, "clip_on": False} if len(points) == 2 else {"markersize": 3.5}
        axes.plot(*chosen, linestyle="none", marker=marker, color=BLACK, label=label, **look)


def _load(axes: AnyAxes, model: ContactModel, case: str, length: float, color: str) -> None:
    """Draw one load case; what acts on no surface is named in the legend."""
    others = []
    for part in model.loads[case]:
        if isinstance(part, Traction | Pressure):
            body = model.bodies[part.body]
            nodes = body.boundary_nodes(part.boundary, "loads")
            _arrows(axes, body.mesh, nodes, surface_forces(part, body, model.kinematics)[:, nodes], length, color)
        else:
            others.append(re.sub("(?<!^)(?=[A-Z])", " ", type(part).__name__).lower())
    nowhere: list[list[float]] = [[]] * (3 if model.kinematics == "space" else 2)
    axes.plot(*nowhere, color=color, marker=">", label=f"load {case}" + (f" ({', '.join(others)})" if others else ""))


def _arrows(axes: AnyAxes, mesh: Mesh, nodes: Integers, force: Array, length: float, color: str) -> None:
    """Draw arrows of equal length along the loaded boundary: those that press end on it, the others begin there."""
    points, strength = mesh.p[:, nodes], np.linalg.norm(force, axis=0)
    chosen = [node for node in spread(points, _ARROWS) if strength[node] > 0]
    step = force[:, chosen] / strength[chosen] * length
    inward = mesh.p.mean(axis=1)[:, None] - points[:, chosen]
    tails = points[:, chosen] - np.where((step * inward).sum(axis=0) > 0, 1.0, 0.0) * step
    if len(points) == 3:
        axes.quiver(*tails, *step, color=color, linewidth=1.0, arrow_length_ratio=0.35)
        return
    for tail, arrow in zip(tails.T, step.T, strict=True):
        axes.annotate("", tail + arrow, tail, arrowprops={"arrowstyle": "-|>", "color": color, "shrinkA": 0, "shrinkB": 0, "lw": 1.0})
    axes.update_datalim(np.concatenate([tails.T, (tails + step).T]))
    axes.autoscale_view()


def spread(points: Array, most: int) -> list[int]:
    """Numbers of at most so many points, each as far as possible from those before it: on a straight side evenly spaced."""
    chosen = [int(points.sum(axis=0).argmin())]
    distance = np.linalg.norm(points - points[:, chosen], axis=0)
    while len(chosen) < most and distance.max() > 0:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[:, chosen[-1:]], axis=0))
    return chosen
