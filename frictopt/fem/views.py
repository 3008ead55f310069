"""Views of models by PyVista: the bodies, the faces of their contacts, and a field on them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import choice, finite_number, shown
from ..errors import ModelError
from ..plots.style import BLACK, GREY, in_units, series
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
_GLASS = 0.25  # opacity of bodies through which contacts are seen
_BAR = {"vertical": False, "fmt": "%.3g", "width": 0.38, "position_x": 0.55, "position_y": 0.9}
_LOOK = {
    "cmap": "cividis",
    "lighting": False,
    "show_edges": True,
    "edge_color": GREY,
    "line_width": 0.5,
    "scalar_bar_args": _BAR,
}


def view(model: ContactModel, result: object, show: str, scale: float, plotter: Any) -> Any:
    """Draw a model, see `ContactModel.view`."""
    try:
        import pyvista as pv
    except ImportError as error:
        raise ImportError("views need pyvista: python -m pip install 'frictopt[view]'") from error
    if plotter is not None and not isinstance(plotter, pv.Plotter):
        raise ModelError(f"plotter: a {type(plotter).__name__}; give a pyvista.Plotter, or None")
    fields, more = _state(model, result)
    face, factor = contact_face(model, fields, more), finite_number("scale", scale)
    known = _BODIES | {
        name: title
        for name, title in _CONTACTS.items()
        if fields is None or name in face.point_data
    }
    title = in_units(known[choice("show", show, tuple(known))], model.units)
    scene = pv.Plotter() if plotter is None else plotter
    scene.add_axes()
    if fields is None:
        for number, (name, body) in enumerate(model.bodies.items()):
            scene.add_mesh(
                pv.wrap(in_meshio(body.mesh)),
                style="wireframe",
                color=series(number)["color"],
                label=name,
            )
        scene.add_mesh(pv.wrap(face), color=BLACK, label="contact")
        scene.add_legend(bcolor=None, face="rectangle", size=(0.15, 0.15))
        return scene
    bodies = [pv.wrap(fields._in_meshio(name)) for name in fields.bodies]
    coloured, others = ([pv.wrap(face)], bodies) if show in _CONTACTS else (bodies, [])
    for grid in [*coloured, *others]:
        grid.points = grid.points + factor * grid["displacement"]
    for grid in coloured:
        grid[title] = grid[show] if grid[show].ndim == 1 else np.linalg.norm(grid[show], axis=1)
    ends = [(grid[title].min(), grid[title].max()) for grid in coloured]
    for grid in coloured:
        scene.add_mesh(
            grid,
            scalars=title,
            clim=(min(low for low, _ in ends), max(high for _, high in ends)),
            **_LOOK,
        )
    scene.scalar_bars[title].SetTitle(f"{title}\n")  # above the numbers, not on them
    for grid in others:
        scene.add_mesh(grid, color=GREY, opacity=_GLASS)
    return scene


def _state(
    model: ContactModel, result: object
) -> tuple[BodyFields | None, Mapping[str, NDArray[Any]]]:
    """Fields of a result, and more values at the nodes of the contacts."""
    if result is None or isinstance(result, BodyFields):
        return result, {}
    if not isinstance(result, Steady):
        raise ModelError(
            f"result: {shown(result)}; give fields of ContactModel.recover, a steady state, or None"
        )
    *_, (_, fields, more) = model._over(result, every=False)
    return fields, more
