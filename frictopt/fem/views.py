"""Views of models by PyVista: the bodies, the faces of their contacts, and a field on them."""

import ctypes
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import choice, finite_number, shown
from ..errors import ModelError
from ..plots.style import BLACK, GREY, as_is, in_units, series
from .model import ContactModel
from .paraview import contact_face
from .recovery import BodyFields, Steady, in_meshio

_BODIES = {
    "von_mises": "von Mises stress (force per area)",
    "displacement": "displacement (length)",
}
_CONTACTS = {
    "pressure": "pressure (force per area)",
    "shear": "shear traction (force per area)",
    "slip": "slip (length)",
    "gap": "gap (length)",
    "work_density": "work per cycle (force times length per area)",
}
_BAR = {"vertical": False, "fmt": "%.3g", "width": 0.38, "position_x": 0.55, "position_y": 0.9}
_EDGES = {"lighting": False, "show_edges": True, "edge_color": GREY, "line_width": 0.5}
_LOOK = {"cmap": "cividis", "scalar_bar_args": _BAR, **_EDGES}


def _can_draw() -> bool:
    """Whether VTK has a library to draw with. Without one, a plotter ends the process."""
    if not sys.platform.startswith("linux"):
        return True
    names = ["libEGL.so.1", "libOSMesa.so.8", *(["libGL.so.1"] if "DISPLAY" in os.environ else [])]
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def view(
    model: ContactModel,
    result: object,
    show: str,
    scale: float,
) -> Any:
    """Draw a model, see `ContactModel.view`."""
    try:
        import pyvista as pv
    except ImportError as error:
        raise ImportError("views need pyvista: python -m pip install 'frictopt[view]'") from error
    fields, extra = _state(model, result)
    face = contact_face(model, fields, extra)
    factor = finite_number("scale", scale)
    known = _titles(None if fields is None else face.point_data)
    title = in_units(known[choice("show", show, tuple(known))], model.units)
    if not _can_draw():
        raise ImportError("views need a library of OpenGL such as libEGL: apt-get install libegl1")
    scene = pv.Plotter()
    scene.add_axes()
    if fields is None:
        _draw_meshes(pv, scene, model, face)
    else:
        grids = [pv.wrap(fields._in_meshio(name)) for name in fields.bodies]
        contacts = pv.wrap(face)
        for grid in [*grids, contacts]:
            grid.points = grid.points + factor * grid["displacement"]
        if show in _CONTACTS:
            _draw_field(scene, [contacts], show, title)
            # The contacts are seen through the bodies.
            for grid in grids:
                scene.add_mesh(grid, color=GREY, opacity=0.25)
        else:
            _draw_field(scene, grids, show, title)
    return scene


def _titles(at_contacts: Mapping[str, NDArray[Any]] | None) -> dict[str, str]:
    """Titles of the fields that can be shown; None: without a result, all."""
    if at_contacts is None:
        return _BODIES | _CONTACTS
    return _BODIES | {name: title for name, title in _CONTACTS.items() if name in at_contacts}


def _draw_meshes(pv: Any, scene: Any, model: ContactModel, face: Any) -> None:
    """Draw the bodies in their colours, and the contacts, which are seen through the bodies."""
    for number, (name, body) in enumerate(model.bodies.items()):
        color = series(number, len(model.bodies))["color"]
        grid = pv.wrap(in_meshio(body.mesh))
        scene.add_mesh(grid, color=color, opacity=0.25, label=as_is(name), **_EDGES)
    scene.add_mesh(pv.wrap(face), color=BLACK, label="contact", **_EDGES)
    scene.add_legend(bcolor=None, face="rectangle", size=(0.15, 0.15))


def _draw_field(scene: Any, grids: Sequence[Any], show: str, title: str) -> None:
    """Draw a field on grids in the same colours, of vectors the length."""
    for grid in grids:
        values = grid[show]
        grid[title] = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    low = min(grid[title].min() for grid in grids)
    high = max(grid[title].max() for grid in grids)
    for grid in grids:
        scene.add_mesh(grid, scalars=title, clim=(low, high), **_LOOK)
    # The line break keeps the title above the numbers.
    scene.scalar_bars[title].SetTitle(f"{as_is(title)}\n")


def _state(
    model: ContactModel, result: object
) -> tuple[BodyFields | None, Mapping[str, NDArray[Any]]]:
    """Fields of a result (of a steady state at its last corner), and further values at contacts."""
    if result is None or isinstance(result, BodyFields):
        return result, {}
    if not isinstance(result, Steady):
        raise ModelError(
            f"result: {shown(result)}; give fields of ContactModel.recover, a steady state, or None"
        )
    *_, (_, fields, extra) = model._over(result, every=False)
    return fields, extra
