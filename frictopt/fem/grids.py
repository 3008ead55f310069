"""The bodies and the face of the contact as grids of PyVista, with the fields of a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..base import Array, Integers, shown
from ..base.files import library
from ..errors import ModelError
from .faces import facets_around
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
    """The faces of bodies 1 of all contacts as one mesh of meshio, with fields at its nodes.

    `extra` are further values at the nodes of the contacts. A node at the tip of a crack is in no
    pair: it moves with its body and does not slip, and has the other values of the nearest pair. A
    node on the cut of a sector that is a copy of another node has the values of that node, turned.
    """
    parts = model._assembly
    points = parts.points
    pairs = parts.pairs.nodes
    faces, tips = _faces(model)
    places = _in_space(points[np.r_[pairs, tips]])
    mesh = library().Mesh(places, [(_CELLS[face.shape[1]], face) for face in faces])
    mesh.cell_data["contact"] = [
        np.full(len(face), number, dtype=np.int32) for number, face in enumerate(faces)
    ]
    if fields is None:
        return mesh

    # Values at the pairs.
    frames = fields._frames
    moved = np.concatenate([*fields.displacement.values()], axis=1).T
    mesh.point_data.update(
        {
            "displacement": _in_space(fields._sides[0] @ moved),
            "normal": _in_space(frames[:, -1]),
            "slip": _in_space(_along_tangents(fields.slip.T, frames)),
            "shear": _in_space(_along_tangents(fields.q.T / parts.width, frames)),
            "gap": fields.gap,
            "pressure": fields.p / parts.width,
            **extra,
        }
    )

    # The values at crack tips are listed after the values at the pairs.
    sector = parts.sector
    is_copy = sector.copies[tips] >= 0
    originals = np.where(is_copy, sector.copies[tips], tips)
    distance, nearest = cKDTree(points[pairs]).query(points[originals])
    pair_of_node = np.r_[np.arange(len(pairs)), nearest]
    for name, values in mesh.point_data.items():
        mesh.point_data[name] = values[pair_of_node]
    mesh.point_data["displacement"][len(pairs) :] = _in_space(moved[tips])
    alone = len(pairs) + np.flatnonzero(distance > 2 * parts.errors.max())
    for name in mesh.point_data.keys() & {"slip", "gap"}:
        mesh.point_data[name][alone] = 0.0
    copies = len(pairs) + np.flatnonzero(is_copy)
    for name in ("normal", "slip", "shear"):
        mesh.point_data[name][copies, : points.shape[1]] @= sector.turn.T
    return mesh


def _along_tangents(values: Array, frames: Array) -> Array:
    """(N, d) vectors of components (N,) or (2, N) along the tangents."""
    return np.asarray(np.einsum("tn,nta->na", np.atleast_2d(values), frames[:, :-1]))


def _faces(model: Any) -> tuple[list[Integers], Integers]:
    """Facets of body 1 of each contact, as (m, k) numbers of nodes, and the nodes in no pair.

    The pairs have the first numbers, and nodes that are in no pair the numbers after them.
    """
    parts = model._assembly
    places = parts.points[parts.pairs.nodes]
    near = 2 * parts.errors.max()
    faces = []
    for number, contact in enumerate(model.contacts):
        body = parts.bodies[contact.body_1]
        facets = body.boundary(contact.boundary_1, "contacts")
        corners = parts.own_nodes[contact.body_1][facets_around(body.mesh, facets)]
        pairs = np.flatnonzero(parts.contact == number)
        pair_of_node = np.full(len(parts.points), -1)
        pair_of_node[parts.pairs.nodes[pairs]] = pairs
        # A corner node may be in a pair of another contact.
        distance, nearest = cKDTree(places).query(parts.points[corners])
        elsewhere = (pair_of_node[corners] < 0) & (distance <= near)
        faces.append((corners, np.where(elsewhere, nearest, pair_of_node[corners])))
    tips = np.unique(np.concatenate([corners[pair < 0] for corners, pair in faces]))
    numbered = [
        np.where(pair < 0, len(places) + np.searchsorted(tips, corners), pair)
        for corners, pair in faces
    ]
    return numbered, tips


def _in_space(vectors: Array) -> Array:
    """(N, 3) vectors of space from vectors (N, d)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
