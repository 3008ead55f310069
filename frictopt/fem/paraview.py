"""Files for ParaView with all bodies and the face of the contact, at one state or over a cycle."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..base import Array, Integers
from ..base.files import written
from ..base.libraries import file_path, library
from ..errors import ModelError
from .faces import facets_around
from .model import ContactModel
from .recovery import BodyFields, Steady

# Number of nodes -> name of a cell.
_CELLS = {2: "line", 3: "triangle", 4: "quad"}


def write_paraview(
    path: str | Path, model: ContactModel, result: BodyFields | Steady, *, every: bool = False
) -> None:
    """Write all bodies of a model and the face of its contact as one file for ParaView.

    The file holds one state or the states of a steady cycle. Beside it a folder of its name holds
    the parts. The extra `mesh` of the installation brings meshio.

    - The bodies have the fields displacement, stress, strain (symmetric tensors) and von_mises.
    - The face of the contact, that of bodies 1, has the vectors displacement, normal, slip (of body
      1 relative to body 2) and shear (traction on body 1); pressure; gap; and contact, its number
      in the order of the model.
    - Over a cycle the face also has status (2 open, 1 slipped since the state before in the file, 0
      stuck), and work and work_density: work of friction since the cycle began, per node and per
      area.

    Parameters
    ----------
    path
        The file: `.vtm` for fields, `.pvd` for a steady state, whose time is the number of corners
        visited since the last one.
    model
        The model that was condensed.
    result
        Fields that `ContactModel.recover` gave, or a steady state of the condensed model.
    every
        Whether to write every state of the cycle, after each event or increment. False: the states
        at the corners.

    Raises
    ------
    ModelError
        The path has another ending or cannot be written, or the result is of another kind or of
        another model.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    >>> cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
    >>> steady = fo.steady_state(model.condense(), cycle, friction=0.5, load_factor=2.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fo.fem.write_paraview(f"{folder}/corners.pvd", model, steady)
    ...     fo.fem.write_paraview(f"{folder}/events.pvd", model, steady, every=True)
    ...     [len([*Path(folder, name).glob("*.vtm")]) for name in ("corners", "events")]
    [3, 9]
    """
    file = file_path("path", path)
    if not isinstance(model, ContactModel):
        raise ModelError(
            f"model: a {type(model).__name__}; give the ContactModel that was condensed; "
            "for a scene, give its .model()"
        )
    ending = ".vtm" if isinstance(result, BodyFields) else ".pvd"
    if not isinstance(result, BodyFields | Steady):
        raise ModelError(
            f"result: a {type(result).__name__}; give fields of ContactModel.recover, or a steady "
            "state"
        )
    if file.suffix.lower() != ending:
        raise ModelError(f"path: {file.name!r}; give a file name that ends in {ending}")
    with written(file, ending) as whole:
        if isinstance(result, BodyFields):
            _write_state(whole, model, result, {})
            return
        entries = []
        for number, (time, fields, extra) in enumerate(model._over(result, every=every)):
            part = whole.with_suffix("") / f"{number:04d}.vtm"
            _write_state(part, model, fields, extra)
            place = part.relative_to(whole.parent).as_posix()
            entries.append({"timestep": f"{time:.9g}", "part": "0", "file": place})
        _write_list(whole, "Collection", entries)


def _write_state(
    file: Path, model: ContactModel, fields: BodyFields, extra: Mapping[str, NDArray[Any]]
) -> None:
    """Write one state, with more values at the nodes of the contact."""
    folder = file.with_suffix("")
    folder.mkdir(parents=True)
    files = {}
    for number, name in enumerate(fields.bodies):
        letters = re.sub(r"[\W_]", "_", name)
        files[name] = folder / f"{number}_{letters}.vtu"
        fields._in_meshio(name).write(files[name])
    blocks = [*files.items(), ("contact", folder / "contact.vtu")]
    contact_face(model, fields, extra).write(folder / "contact.vtu")
    entries = [
        {"index": str(index), "name": name, "file": part.relative_to(file.parent).as_posix()}
        for index, (name, part) in enumerate(blocks)
    ]
    _write_list(file, "vtkMultiBlockDataSet", entries)


def contact_face(
    model: ContactModel, fields: BodyFields | None, extra: Mapping[str, NDArray[Any]]
) -> Any:
    """The face of the contacts, that of bodies 1, as a mesh of meshio with fields at its nodes.

    `extra` are further values at the nodes of the contacts. A node at the tip of a crack is in no
    pair: it moves with its body and does not slip, and has the other values of the nearest pair. A
    node on the cut of a sector that is a turned copy has the values of its original, turned.
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

    # Values at the tips, after those at the pairs.
    sector = parts.sector
    is_copy = sector.copies[tips] >= 0
    originals = np.where(is_copy, sector.copies[tips], tips)
    distance, nearest = cKDTree(points[pairs]).query(points[originals])
    pair_of_node = np.r_[np.arange(len(pairs)), nearest]
    for name, values in mesh.point_data.items():
        mesh.point_data[name] = values[pair_of_node]
    mesh.point_data["displacement"][len(pairs) :] = _in_space(moved[tips])
    alone = len(pairs) + np.flatnonzero(distance > 2 * parts.errors.max())
    for name in mesh.point_data.keys() & {"slip", "gap", "work"}:
        mesh.point_data[name][alone] = 0.0
    copies = len(pairs) + np.flatnonzero(is_copy)
    for name in ("normal", "slip", "shear"):
        mesh.point_data[name][copies, : points.shape[1]] @= sector.turn.T
    return mesh


def _along_tangents(values: Array, frames: Array) -> Array:
    """(N, d) vectors of components (N,) or (2, N) along the tangents."""
    return np.asarray(np.einsum("tn,nta->na", np.atleast_2d(values), frames[:, :-1]))


def _faces(model: ContactModel) -> tuple[list[Integers], Integers]:
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
        corners = parts.first_node[contact.body_1] + facets_around(body.mesh, facets)
        pairs = np.flatnonzero(parts.contact == number)
        pair_of_node = np.full(len(parts.points), -1)
        pair_of_node[parts.pairs.nodes[pairs]] = pairs
        # A corner may be in a pair of another contact.
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


def _write_list(file: Path, kind: str, entries: Sequence[Mapping[str, str]]) -> None:
    """Write a list of files in the format of VTK."""
    root = ElementTree.Element("VTKFile", type=kind, version="1.0")
    part = ElementTree.SubElement(root, kind)
    for entry in entries:
        ElementTree.SubElement(part, "DataSet", dict(entry))
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(file, xml_declaration=True)
