"""Arrows of the loads in pictures of models."""

import re
from collections import Counter

import numpy as np

from ..base import Array
from ..plots.style import AnyAxes, Look, arrows, spread
from .bodies import Body
from .bolts import BoltPreload
from .elasticity import integration_points
from .loads import Pressure, Traction
from .model import ContactModel


def load_arrows(axes: AnyAxes, model: ContactModel, case: str, length: float, color: str) -> None:
    """Arrows of equal length along loaded boundaries, and a line of the legend.

    Arrows of tractions that press end on the face, others begin there. The legend names loads that
    do not act on a surface.
    """
    others = Counter[str]()
    in_space = model.kinematics == "space"
    look: Look = {"units": "inches", "width": 0.014, "headwidth": 6, "zorder": 2.5}
    if in_space:
        look = {"linewidth": 1.0, "arrow_length_ratio": 0.35}
    for part in model.loads[case]:
        if isinstance(part, BoltPreload):
            begin, step = _pull_of_bolt(part, model.bodies[part.body], length)
            arrows(axes, begin, step, color=color, **look)
        if not isinstance(part, Traction | Pressure):
            # BoltPreload becomes "bolt preload".
            others[re.sub("(?<!^)(?=[A-Z])", " ", type(part).__name__).lower()] += 1
            continue
        points, traction, normals = _mean_tractions(part, model.bodies[part.body])
        strength = np.linalg.norm(traction, axis=0)
        chosen = [facet for facet in spread(points, 9) if strength[facet] > 0]
        points = points[:, chosen]
        step = traction[:, chosen] / strength[chosen] * length
        # A traction presses if it has a component, beyond rounding, against the outward normal.
        presses = (step * normals[:, chosen]).sum(axis=0) < -1e-3 * length
        starts = points - np.where(presses, step, 0.0)
        arrows(axes, starts.T, step.T, color=color, **look)
    label = f"load {case}"
    if others:
        kinds = [f"{count} x {kind}" if count > 1 else kind for kind, count in others.items()]
        label += f" ({', '.join(kinds)})"
    nowhere: list[list[float]] = [[]] * (3 if in_space else 2)
    axes.plot(*nowhere, color=color, marker=">", label=label)


def _pull_of_bolt(part: BoltPreload, body: Body, length: float) -> tuple[Array, Array]:
    """(2, d) begins and steps of two arrows that press both ends of a bolt along its axis.

    Inside the bolt they would be hidden.
    """
    nodes = np.unique(body.mesh.facets[:, body.mesh.boundaries[part.section]])
    places = body.mesh.p[:, nodes].T
    middle = places.mean(axis=0)
    # The axis is the direction in which the nodes of the section do not extend.
    axis = np.linalg.svd(places - middle)[2][-1]
    along = axis @ (body.mesh.p - middle[:, None])
    ends = middle + np.outer([along.min(), along.max()], axis)
    step = length * np.array([axis, -axis])
    return ends - step, step


def _mean_tractions(part: Traction | Pressure, body: Body) -> tuple[Array, Array, Array]:
    """(d, m) middles of the loaded facets, and mean traction and outward normal of each.

    Nodal forces would mislead: at corners of quadratic elements they are zero up to rounding, or
    point against the load.
    """
    facets = body.boundary(part.boundary, "loads")
    points, normals, sizes, *_ = integration_points(body.mesh, facets)
    share = sizes / sizes.sum(axis=1, keepdims=True)
    traction = part._on_face(points, normals)
    middle, mean, normal = ((values * share).sum(axis=2) for values in (points, traction, normals))
    return middle, mean, normal
