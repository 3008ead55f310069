"""Arrows of the loads in pictures of models."""

import re
from collections import Counter

import numpy as np

from ..base import ROUNDING, Array
from ..plots.style import AnyAxes, Look, arrows, as_is, spread
from .bodies import Body
from .bolts import BoltPreload
from .contacts import Interference
from .elasticity import integration_points
from .loads import Displacement, Pressure, Traction
from .model import ContactModel


def load_arrows(axes: AnyAxes, model: ContactModel, case: str, length: float, color: str) -> None:
    """Arrows of equal length along loaded boundaries, and a line of the legend.

    Arrows of tractions that press end on the face, others begin there. A load that does not act on
    a surface has at most one arrow, and the legend names its kind.
    """
    kinds = Counter[str]()
    in_space = model.kinematics == "space"
    look: Look = {"units": "inches", "width": 0.014, "headwidth": 6, "zorder": 2.5}
    if in_space:
        look = {"linewidth": 1.0, "arrow_length_ratio": 0.35}
    for part in model.loads[case]:
        if not isinstance(part, Traction | Pressure):
            # BoltPreload becomes "bolt preload".
            kinds[re.sub("(?<!^)(?=[A-Z])", " ", type(part).__name__).lower()] += 1
        if isinstance(part, BoltPreload | Displacement | Interference):
            continue
        body = model.bodies[part.body]
        if isinstance(part, Traction | Pressure):
            begin, step = _on_surface(part, body, length)
        else:
            forces = part._forces(body, model.kinematics or "plane_strain")
            begin, step = _resultant(forces, body.mesh.p, length)
        arrows(axes, begin, step, color=color, **look)
    label = f"load {as_is(case)}"
    if kinds:
        label += f" ({', '.join(f'{count} x {kind}' for kind, count in kinds.items())})"
    nowhere: list[list[float]] = [[]] * (3 if in_space else 2)
    axes.plot(*nowhere, color=color, marker=">", label=label)


def _on_surface(part: Traction | Pressure, body: Body, length: float) -> tuple[Array, Array]:
    """(n, d) begins and steps of arrows along the mean tractions of facets.

    Nodal forces would mislead: at corners of quadratic elements they are zero up to rounding, or
    point against the load.
    """
    facets = body.boundary(part.boundary, "loads")
    places, outward, sizes, *_ = integration_points(body.mesh, facets)
    share = sizes / sizes.sum(axis=1, keepdims=True)
    fields = places, part._on_face(places, outward), outward
    points, traction, normals = ((values * share).sum(axis=2) for values in fields)
    strength = np.linalg.norm(traction, axis=0)
    chosen = [facet for facet in spread(points, 9) if strength[facet] > 0]
    step = traction[:, chosen] / strength[chosen] * length
    # A traction presses if it has a component, beyond rounding, against the outward normal.
    presses = (step * normals[:, chosen]).sum(axis=0) < -1e-3 * length
    return (points[:, chosen] - np.where(presses, step, 0.0)).T, step.T


def _resultant(forces: Array, places: Array, length: float) -> tuple[Array, Array]:
    """(1, d) begin and step of an arrow along the sum of nodal forces (d, n).

    It begins where the loaded nodes end, because inside a body it would be hidden. Forces that
    balance each other, such as those of an expansion, have no arrow: (0, d).
    """
    strength = np.linalg.norm(forces, axis=0)
    total = forces.sum(axis=1)
    size = np.linalg.norm(total)
    if size <= ROUNDING * strength.sum():
        return np.empty((0, len(total))), np.empty((0, len(total)))
    direction = total / size
    middle = places @ strength / strength.sum()
    end = (direction @ places[:, strength > 0]).max()
    begin = middle + (end - direction @ middle) * direction
    return begin[None], length * direction[None]
