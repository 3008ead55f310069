"""The sizes of load cases, by which their work is divided to give a motion."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from ..base import Array
from .bodies import Body
from .elasticity import Kinematics, boundary_forces, volume_forces
from .loads import BodyForce, Pressure, Traction, components
from .node_forces import PointForce, RemoteForce

_Sized: TypeAlias = Traction | Pressure | BodyForce | PointForce | RemoteForce


def load_sizes(
    loads: Mapping[str, Sequence[object]], bodies: Mapping[str, Body], kinematics: Kinematics
) -> dict[str, float]:
    """Load case name -> integral of the absolute values of its tractions and forces per volume.

    Forces on nodes count with their absolute values. Load cases that contain moments or other
    loads, or have no size, are left out.
    """
    sizes = {}
    for name, parts in loads.items():
        forces = [part for part in parts if isinstance(part, _Sized)]
        size = sum(_size(part, bodies[part.body], kinematics) for part in forces)
        if len(forces) == len(parts) and size > 0:
            sizes[name] = size
    return sizes


def _size(part: _Sized, body: Body, kinematics: Kinematics) -> float:
    if isinstance(part, PointForce | RemoteForce):
        return part._size(body, kinematics)
    if isinstance(part, BodyForce):

        def in_volume(points: Array) -> Array:
            return np.asarray(np.linalg.norm(components(part, points), axis=0)[None])

        return float(volume_forces(body.mesh, in_volume, kinematics).sum())

    def on_face(points: Array, normals: Array) -> Array:
        return np.asarray(np.linalg.norm(part._on_face(points, normals), axis=0)[None])

    facets = body.boundary(part.boundary, "loads")
    return float(boundary_forces(body.mesh, facets, on_face, kinematics).sum())
