"""The sizes of loads: what turns their work into a motion."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..base import Array
from .bodies import Body
from .elasticity import Kinematics, boundary_forces, volume_forces
from .loads import BodyForce, Pressure, Traction, components


def load_sizes(
    loads: Mapping[str, Sequence[object]], bodies: Mapping[str, Body], kinematics: Kinematics
) -> dict[str, float]:
    """Load case name -> integral of the size of its tractions and forces per volume; load cases that consist of these alone, and have a size."""
    sizes = dict[str, float]()
    for name, parts in loads.items():
        forces = [part for part in parts if isinstance(part, Traction | Pressure | BodyForce)]
        size = sum(_size(part, bodies[part.body], kinematics) for part in forces)
        if len(forces) == len(parts) and size > 0:
            sizes[name] = size
    return sizes


def _size(part: Traction | Pressure | BodyForce, body: Body, kinematics: Kinematics) -> float:
    if isinstance(part, BodyForce):
        return float(
            volume_forces(
                body.mesh,
                lambda points: np.linalg.norm(components(part, points), axis=0)[None],
                kinematics,
            ).sum()
        )

    def size(points: Array, normals: Array) -> Array:
        return np.asarray(np.linalg.norm(part._on_face(points, normals), axis=0)[None])

    return float(
        boundary_forces(body.mesh, body.boundary(part.boundary, "loads"), size, kinematics).sum()
    )
