"""The bodies and the faces of the contacts as grids of PyVista, with the fields of a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..base import Array, Integers, shown
from ..base.files import library
from ..errors import ModelError
from .elasticity import in_space
from .mortar import faces_of
from .recovery import BodyFields, Steady, in_meshio

# Number of nodes -> name of a cell.
_CELLS = {2: "line", 3: "triangle", 4: "quad"}


def grids_of(model: Any, result: BodyFields | Steady | None) -> Any:
    """The grids of a model, see `ContactModel.grids`."""
    pv = library("pyvista", "pyvista", "view")
    fields = result
    of_cycle = {}
    if isinstance(result, Steady):
        *_, fields = model._over(result, every=False)
        steady: Any = result
        of_cycle = {"work_density": steady.dissipation_per_node / model._assembly.width}
    if fields is None:
        meshes = {name: in_meshio(body.mesh) for name, body in model.bodies.items()}
    elif isinstance(fields, BodyFields):
        meshes = {name: fields._in_meshio(name) for name in fields.bodies}
    else:
        raise ModelError(
            f"result: {shown(result)}; give fields of ContactModel.recover, a steady state, or None"
        )
    grids = pv.MultiBlock()
    for name, mesh in meshes.items():
        grids.append(pv.wrap(mesh), name)
    grids.append(pv.wrap(_contact_face(model, fields, of_cycle)), "contact")
    return grids


def _contact_face(model: Any, fields: BodyFields | None, extra: Mapping[str, Array]) -> Any:
    """The face of body 1 of every contact, all in one mesh of meshio, with fields at its nodes.

    `extra` are further values at the nodes of the contacts. A node that is in no pair of its
    contact has the displacement of its body, and all other values of the nearest pair; at the tip
    of a crack its slip and gap are zero. On the cut of a sector, a node that copies another node
    has the values of that node, turned.
    """
    parts = model._assembly
    points = parts.points
    pairs = parts.pairs.nodes
    faces, others = _faces(model)
    nodes = np.r_[pairs, others]
    cells = [(_CELLS[face.shape[1]], face) for face in faces]
    mesh = library().Mesh(in_space(points[nodes]), cells)
    mesh.cell_data["contact"] = [
        np.full(len(face), number, dtype=np.int32) for number, face in enumerate(faces)
    ]
    if fields is None:
        return mesh

    frames = fields._frames
    of_pairs = {
        "normal": in_space(frames[:, -1]),
        "slip": in_space(_along_tangents(fields.slip.T, frames)),
        "shear": in_space(_along_tangents(fields.q.T / parts.width, frames)),
        "gap": fields.gap,
        "pressure": fields.p / parts.width,
        **extra,
    }
    sector = parts.sector
    is_copy = sector.copies[others] >= 0
    originals = np.where(is_copy, sector.copies[others], others)
    distance, nearest = cKDTree(points[pairs]).query(points[originals])
    pair_of_node = np.r_[np.arange(len(pairs)), nearest]
    mesh.point_data.update({name: values[pair_of_node] for name, values in of_pairs.items()})
    moved = np.concatenate([*fields.displacement.values()], axis=1).T
    mesh.point_data["displacement"] = in_space(moved[nodes])
    tips = len(pairs) + np.flatnonzero(distance > 2 * parts.errors.max())
    for name in ("slip", "gap"):
        mesh.point_data[name][tips] = 0.0
    copies = len(pairs) + np.flatnonzero(is_copy)
    for name in ("normal", "slip", "shear"):
        mesh.point_data[name][copies, : points.shape[1]] @= sector.turn.T
    return mesh


def _along_tangents(values: Array, frames: Array) -> Array:
    """(N, d) vectors from their components along the tangents, (N,) or (2, N)."""
    return np.asarray(np.einsum("tn,nta->na", np.atleast_2d(values), frames[:, :-1]))


def _faces(model: Any) -> tuple[list[Integers], Integers]:
    """Facets (m, k) of body 1 of each contact, by numbers of nodes, and the nodes without a pair.

    A node has the number of its pair in this contact. Nodes that are in no pair of their contact
    have the numbers after all pairs.
    """
    parts = model._assembly
    count = len(parts.pairs.nodes)
    faces = []
    for number, contact in enumerate(model.contacts):
        number_of_node = count + np.arange(len(parts.points))
        pairs = np.flatnonzero(parts.contact == number)
        number_of_node[parts.pairs.nodes[pairs]] = pairs
        face, _ = faces_of(contact, parts.bodies)
        faces.append(number_of_node[parts.own_nodes[contact.body_1]][face.facets])
    others = np.unique(np.concatenate([face[face >= count] for face in faces]))
    numbered = [
        np.where(face < count, face, count + np.searchsorted(others, face)) for face in faces
    ]
    return numbered, others - count
