"""Pictures of models: the meshes of their bodies, contacts, supports and loads; and of fields in the bodies."""

import re
from typing import Any

import numpy as np

from ..contact.checks import Array
from ..fem import BodyFields, ContactModel, Pressure, Traction
from ..scenes.scene import Scene
from .picture import picture
from .style import BLACK, legend, new_axes, series

__all__ = ["draw_edges", "draw_mesh", "spread", "words"]

_HELD = {"xy": "s", "x": ">", "y": "^"}  # directions -> marker
_MOST_MARKS = 17  # along each support
_ARROWS = 9  # along each loaded boundary
_NAME = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "pad": 2.0}
_TO_NAME = {"arrowstyle": "-", "lw": 0.8}
_LENGTH = 0.08  # of an arrow, over the size of the model


def draw_edges(axes: Any, mesh: Any, facets: Any, scale: float = 1.0, **look: Any) -> None:
    """Draw some facets of a mesh; coordinates are divided by `scale`."""
    edges = np.insert(mesh.p[:, mesh.facets[:, facets]] / scale, 2, np.nan, axis=1)  # one line with gaps is drawn far faster than many lines
    axes.plot(*edges.transpose(0, 2, 1).reshape(2, -1), solid_capstyle="round", snap=False, **look)


def draw_mesh(axes: Any, mesh: Any, color: str, scale: float = 1.0, *, thin: float = 0.12, label: str | None = None) -> None:
    """Draw the lines of a mesh, with its outline; coordinates are divided by `scale`."""
    draw_edges(axes, mesh, np.arange(mesh.facets.shape[1]), scale, color=color, lw=thin, zorder=0.5)
    draw_edges(axes, mesh, mesh.boundary_facets(), scale, color=color, lw=1.0, zorder=0.5, label=label)


@picture.register
def _model(model: ContactModel, ax: Any = None) -> Any:
    """Each body in its colour, contacts as thick lines, held nodes as marks, and the directions of each load case as arrows."""
    (axes,) = new_axes(ax, size=(6.4, 4.8))
    size = float(max(np.ptp(np.concatenate([body.mesh.p for body in model.bodies.values()], axis=1), axis=1)))
    for number, (name, body) in enumerate(model.bodies.items()):
        draw_mesh(axes, body.mesh, series(number)["color"], thin=0.2, label=name)
    for number, contact in enumerate(model.contacts):
        mesh = model.bodies[contact.body_1].mesh
        facets = mesh.boundaries[contact.boundary_1]
        draw_edges(axes, mesh, facets, color=BLACK, lw=2.5, label="contact" if number == 0 else None)
        if len(model.contacts) > 1:
            middle = mesh.p[:, mesh.facets[:, facets]].mean(axis=(1, 2))
            axes.annotate(contact.name, middle, (0, -28), textcoords="offset points", ha="center", va="top", bbox=_NAME, arrowprops=_TO_NAME)
    _supports(axes, model)
    for number, case in enumerate(model.loads, start=len(model.bodies)):
        _load(axes, model, case, size, series(number)["color"])
    axes.set_aspect("equal")
    axes.set(xlabel="$x$ (length)", ylabel="$y$ (length)")
    if ax is None:
        axes.figure.set_layout_engine("compressed")
        axes.figure.legend(loc="outside right upper", handlelength=2.2)
    else:
        legend(axes)
    return axes


@picture.register
def _scene(scene: Scene, ax: Any = None) -> Any:
    """Draw its model."""
    return picture(scene.model(), ax)


@picture.register
def _fields(fields: BodyFields, ax: Any = None) -> Any:
    """Von Mises stress in all bodies, nodal values; the colours end at the value that 99 of 100 nodes do not exceed."""
    (axes,) = new_axes(ax, size=(6.4, 4.8))
    stress = {name: _von_mises(rows) for name, rows in fields.stress.items()}
    most = float(np.quantile(np.concatenate(list(stress.values())), 0.99))
    for name, body in fields.bodies.items():
        t = body.mesh.t
        triangles = t.T if len(t) == 3 else np.concatenate([t[[0, 1, 2]].T, t[[0, 2, 3]].T])
        look = {"shading": "gouraud", "cmap": "viridis", "vmin": 0.0, "vmax": most, "rasterized": True}
        colours = axes.tripcolor(*body.mesh.p, triangles, stress[name], **look)
        draw_edges(axes, body.mesh, body.mesh.boundary_facets(), color=BLACK, lw=0.6)
    axes.figure.colorbar(colours, ax=axes, extend="max", label="von Mises stress (force per area)")
    axes.set_aspect("equal")
    axes.set(xlabel="$x$ (length)", ylabel="$y$ (length)")
    if ax is None:
        axes.figure.set_layout_engine("compressed")
    return axes


def _von_mises(stress: Array) -> Array:
    xx, yy, xy, zz = stress
    return np.asarray(np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2))


def _supports(axes: Any, model: ContactModel) -> None:
    named: set[str] = set()
    for support, nodes in zip(model.supports, model.held_nodes, strict=True):
        points = model.bodies[support.body].mesh.p[:, nodes]
        chosen = spread(points, _MOST_MARKS)
        label = None if support.directions in named else f"held in {' and '.join(support.directions)}"
        named.add(support.directions)
        axes.plot(*points[:, chosen], linestyle="none", marker=_HELD[support.directions], color=BLACK, markersize=4.5, label=label, clip_on=False)


def _load(axes: Any, model: ContactModel, case: str, size: float, color: str) -> None:
    """Draw one load case; what acts on no surface is named in the legend."""
    others = [words(type(part).__name__) for part in model.loads[case] if not isinstance(part, Traction | Pressure)]
    for name, body, nodes, force in model.surface_loads:
        if name == case:
            _arrows(axes, model.bodies[body].mesh, nodes, force, _LENGTH * size, color)
    axes.plot([], [], color=color, marker=">", label=f"load {case}" + (f" ({', '.join(others)})" if others else ""))


def words(name: str) -> str:
    """The name of a class as words."""
    return re.sub("(?<!^)(?=[A-Z])", " ", name).lower()


def _arrows(axes: Any, mesh: Any, nodes: Any, force: Array, length: float, color: str) -> None:
    """Draw arrows of equal length along the loaded boundary: those that press end on it, the others begin there."""
    points, strength = mesh.p[:, nodes], np.hypot(*force)
    chosen = [node for node in spread(points, _ARROWS) if strength[node] > 0]
    step = force[:, chosen] / strength[chosen] * length
    inward = mesh.p.mean(axis=1)[:, None] - points[:, chosen]
    tails = points[:, chosen] - np.where((step * inward).sum(axis=0) > 0, 1.0, 0.0) * step
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
