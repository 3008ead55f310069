"""Pictures of models in three dimensions: the outlines of their bodies, contacts, supports and loads."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..contact.checks import shown
from ..errors import ModelError
from ..scenes import SquarePunch
from ..spatial import ContactModel3D, Traction3D
from .bodies import spread, words
from .picture import picture
from .style import BLACK, legend, series

__all__: list[str] = []

_MOST_MARKS = 25  # of each support
_ARROWS = 9  # of each loaded boundary
_LENGTH = 0.12  # of an arrow, over the size of the model


@picture.register
def _model(model: ContactModel3D, ax: Any = None) -> Any:
    """Outline of each body in its colour, contacts filled, held nodes as marks, and the directions of each load case as arrows."""
    axes = _axes(ax)
    ends = np.array([[end(body.mesh.p, axis=1) for end in (np.min, np.max)] for body in model.bodies.values()])
    low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
    length = _LENGTH * float((high - low).max())
    for number, (name, body) in enumerate(model.bodies.items()):
        color = series(number)["color"]
        _faces(axes, body.mesh, body.mesh.boundary_facets(), facecolor=(color, 0.04), edgecolor=(color, 0.5), linewidth=0.3, label=name)
    for number, contact in enumerate(model.contacts):
        mesh = model.bodies[contact.body_1].mesh
        look = {"facecolor": (BLACK, 0.6), "edgecolor": BLACK, "linewidth": 0.3, "label": "contact" if number == 0 else None}
        _faces(axes, mesh, mesh.boundaries[contact.boundary_1], **look)
    _supports(axes, model)
    for number, (case, parts) in enumerate(model.loads.items(), start=len(model.bodies)):
        color, others = series(number)["color"], []
        for part in parts:
            if isinstance(part, Traction3D):
                _arrows(axes, model.bodies[part.body].mesh, part, length, color)
            else:
                others.append(words(type(part).__name__.removesuffix("3D")))
        axes.plot([], [], [], color=color, marker=">", label=f"load {case}" + (f" ({', '.join(others)})" if others else ""))
    low, high = low - length, high + length  # room for the arrows
    axes.set_box_aspect(high - low)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="$x$ (length)", ylabel="$y$ (length)", zlabel="$z$ (length)")
    axes.grid(False)
    axes.locator_params(nbins=5)
    if ax is None:
        axes.figure.set_layout_engine("constrained")
        axes.figure.legend(loc="outside right upper", handlelength=2.2)
    else:
        legend(axes)
    return axes


@picture.register
def _punch(scene: SquarePunch, ax: Any = None) -> Any:
    """Draw its model."""
    return picture(scene.model(), ax)


def _axes(ax: Any) -> Any:
    if ax is None:
        return plt.figure(figsize=(6.4, 4.8)).add_subplot(projection="3d")
    if not isinstance(ax, Axes3D):
        raise ModelError(f"ax: {shown(ax)}; a model in space needs axes with projection='3d'")
    return ax


def _faces(axes: Any, mesh: Any, facets: Any, **look: Any) -> None:
    axes.add_collection3d(Poly3DCollection(mesh.p[:, mesh.facets[:, facets]].transpose(2, 1, 0), **look))


def _supports(axes: Any, model: ContactModel3D) -> None:
    named: set[str] = set()
    for support, nodes in zip(model.supports, model.held_nodes, strict=True):
        points = model.bodies[support.body].mesh.p[:, nodes]
        chosen = points[:, spread(points, _MOST_MARKS)]
        label = None if support.directions in named else f"held in {', '.join(support.directions)}"
        marker = {3: "s", 2: "D", 1: "^"}[len(support.directions)]
        named.add(support.directions)
        axes.plot(*chosen, linestyle="none", marker=marker, color=BLACK, markersize=3.5, label=label)


def _arrows(axes: Any, mesh: Any, load: Traction3D, length: float, color: str) -> None:
    """Draw arrows of equal length on a loaded boundary: those that press end on it, the others begin there."""
    force = np.array([load.x, load.y, load.z])
    strength = float(np.linalg.norm(force))
    if strength == 0:
        return
    middles = mesh.p[:, mesh.facets[:, mesh.boundaries[load.boundary]]].mean(axis=1)
    points = middles[:, spread(middles, _ARROWS)]
    step = force / strength * length
    presses = step @ (mesh.p.mean(axis=1) - middles.mean(axis=1)) > 0
    axes.quiver(*(points - step[:, None] if presses else points), *step, color=color, linewidth=1.0, arrow_length_ratio=0.35)
