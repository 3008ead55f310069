"""Files for ParaView: all bodies and the face of the contact in one, at one state or over a steady cycle."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..base import Array, Integers
from ..base.libraries import file_path, library
from ..errors import ModelError
from .faces import facets_around
from .model import ContactModel
from .recovery import BodyFields, Steady

_CELLS = {2: "line", 3: "triangle", 4: "quad"}


def write_paraview(
    path: str | Path, model: ContactModel, result: BodyFields | Steady, *, every: bool = False
) -> None:
    """Write all bodies of a model and the face of its contact as one file that ParaView opens, at one state or over a steady cycle.

    The bodies have the fields displacement, stress, strain (symmetric tensors) and von_mises. The
    face of the contact, that of bodies 1, has the vectors displacement, normal, slip (of body 1
    relative to body 2) and shear (traction on body 1), pressure, gap, and contact, the number in
    the order of the model. Over a cycle it also has status (2 open, 1 has slipped since the state
    before in the file, 0 stuck), work and work_density (work of friction since the cycle began, of
    the node, and by area). Beside the file stands a folder of its name with the parts. The extra
    `mesh` of the installation brings meshio.

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
        Every state of the cycle, after each event or increment; False: the states at the corners.

    Raises
    ------
    ModelError
        A path of another ending, or that cannot be written, a result of another kind, a model that
        the steady state does not belong to.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import frictopt as fo
    >>> model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    >>> cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
    >>> steady = fo.steady_state(model.condense(), cycle, friction=0.5, load_factor=2.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fo.write_paraview(f"{folder}/corners.pvd", model, steady)
    ...     fo.write_paraview(f"{folder}/events.pvd", model, steady, every=True)
    ...     [len([*Path(folder, name).glob("*.vtm")]) for name in ("corners", "events")]
    [3, 9]
    """
    file = file_path("path", path)
    if not isinstance(model, ContactModel):
        raise ModelError(
            f"model: a {type(model).__name__}; give the ContactModel that was condensed, of a scene its .model()"
        )
    ending = ".vtm" if isinstance(result, BodyFields) else ".pvd"
    if not isinstance(result, BodyFields | Steady):
        raise ModelError(
            f"result: a {type(result).__name__}; give fields of ContactModel.recover, or a steady state"
        )
    if file.suffix.lower() != ending:
        raise ModelError(f"path: {file.name!r}; give a file name that ends in {ending}")
    if isinstance(result, BodyFields):
        return _write_state(file, model, result, {})
    entries = []
    for number, (time, fields, more) in enumerate(model._over(result, every=every)):
        part = file.with_suffix("") / f"{number:04d}.vtm"
        _write_state(part, model, fields, more)
        entries.append(
            {
                "timestep": f"{time:.9g}",
                "part": "0",
                "file": part.relative_to(file.parent).as_posix(),
            }
        )
    _write_list(file, "Collection", entries)


def _write_state(
    file: Path, model: ContactModel, fields: BodyFields, more: Mapping[str, NDArray[Any]]
) -> None:
    """Write one state, with more values at the nodes of the contact."""
    folder, entries = file.with_suffix(""), []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ModelError(
            f"path: the folder {str(folder)!r} cannot be made ({error}); give a place where files may be written"
        ) from error
    for i, name in enumerate(fields.bodies):
        part = folder / f"{i}_{''.join(letter if letter.isalnum() else '_' for letter in name)}.vtu"
        fields.save(part, name)
        entries.append(
            {"index": str(i), "name": name, "file": part.relative_to(file.parent).as_posix()}
        )
    part = folder / "contact.vtu"
    contact_face(model, fields, more).write(part)
    entries.append(
        {
            "index": str(len(entries)),
            "name": "contact",
            "file": part.relative_to(file.parent).as_posix(),
        }
    )
    _write_list(file, "vtkMultiBlockDataSet", entries)


def contact_face(
    model: ContactModel, fields: BodyFields | None, more: Mapping[str, NDArray[Any]]
) -> Any:
    """The face of the contacts, that of bodies 1, with fields and more values at its nodes, as a mesh of meshio.

    A node at the tip of a crack, which is in no pair, moves with its body and does not slip; all
    else there is that of the nearest pair. A node on the cut of a sector that is a turned copy has
    the values of the node that it copies, turned.
    """
    (cells, tips), points, pairs = _faces(model), model._parts.points, model._parts.pairs.nodes
    mesh = library().Mesh(
        _in_space(points[np.r_[pairs, tips]]), [(_CELLS[own.shape[1]], own) for own in cells]
    )
    mesh.cell_data["contact"] = [
        np.full(len(own), number, dtype=np.int32) for number, own in enumerate(cells)
    ]
    if fields is None:
        return mesh
    width, frames = model._parts.width, fields._frames
    moved = np.concatenate([*fields.displacement.values()], axis=1).T
    vectors = {"displacement": fields._sides[0] @ moved, "normal": frames[:, -1]}
    for name, values in (("slip", fields.slip.T), ("shear", fields.q.T / width)):
        vectors[name] = np.einsum("tn,nta->na", np.atleast_2d(values), frames[:, :-1])
    mesh.point_data.update({name: _in_space(values) for name, values in vectors.items()})
    mesh.point_data.update({"gap": fields.gap, "pressure": fields.p / width, **more})
    sector = model._parts.sector
    originals = np.where(sector.copies[tips] >= 0, sector.copies[tips], tips)
    distance, nearest = cKDTree(points[pairs]).query(points[originals])
    own = np.r_[np.arange(len(pairs)), nearest]
    mesh.point_data.update({name: values[own] for name, values in mesh.point_data.items()})
    mesh.point_data["displacement"][len(pairs) :] = _in_space(moved[tips])
    for name in mesh.point_data.keys() & {"slip", "gap", "work"}:
        mesh.point_data[name][
            len(pairs) + np.flatnonzero(distance > 2 * model._parts.errors.max())
        ] = 0.0
    for name in ("normal", "slip", "shear"):
        mesh.point_data[name][
            len(pairs) + np.flatnonzero(originals != tips), : points.shape[1]
        ] @= sector.turn.T
    return mesh


def _faces(model: ContactModel) -> tuple[list[Integers], Integers]:
    """(m, k) pairs at the corners of each facet of body 1, for each contact, and the nodes that are in no pair: these are counted after the pairs."""
    parts, found = model._parts, list[tuple[Integers, Integers]]()
    at, near = parts.points[parts.pairs.nodes], 2 * parts.errors.max()
    for number, contact in enumerate(model.contacts):
        body, own = parts.bodies[contact.body_1], np.flatnonzero(parts.contact == number)
        corners = parts.first_node[contact.body_1] + facets_around(
            body.mesh, body.boundary(contact.boundary_1, "contacts")
        )
        pair = np.full(len(parts.points), -1)
        pair[parts.pairs.nodes[own]] = own
        distance, nearest = cKDTree(at).query(
            parts.points[corners]
        )  # a corner may be in a pair of another contact
        place = np.where((pair[corners] < 0) & (distance <= near), nearest, pair[corners])
        found.append((corners, place))
    tips = np.unique(np.concatenate([corners[place < 0] for corners, place in found]))
    return [
        np.where(place < 0, len(at) + np.searchsorted(tips, corners), place)
        for corners, place in found
    ], tips


def _in_space(vectors: Array) -> Array:
    """(N, 3) vectors, from those of the plane too."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _write_list(file: Path, kind: str, entries: Sequence[Mapping[str, str]]) -> None:
    """Write a list of files as VTK has it."""
    root = ElementTree.Element("VTKFile", type=kind, version="1.0")
    part = ElementTree.SubElement(root, kind)
    for entry in entries:
        ElementTree.SubElement(part, "DataSet", dict(entry))
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(file, xml_declaration=True)
