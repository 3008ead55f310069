"""Matrices of Ansys Mechanical APDL."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, triu

from ...errors import ModelError
from ..ordering import Integers
from .deck import Deck, deck_of_points
from .job import MatrixJob
from .meshes import file_path
from .rows import by_library, library

_LIBRARY = "ansys-mapdl-reader"
_SOLIDS = {(185, 8): "C3D8", (285, 4): "C3D4", (186, 20): "C3D20", (187, 10): "C3D10"}  # number of the element type and nodes; as Abaqus names them


def read_ansys(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read the stiffness that Ansys Mechanical APDL assembles, from its `.full` file.

    `WRFULL,1` before `SOLVE` stops after the assembly; run it in one process, for each of several writes its own file. The contact itself must not be
    in the model: each body keeps its own nodes there. Displacements that `D` holds are left out, and with the deck known as held; rotations are
    generalised coordinates. The extra `ansys` of the installation brings ansys-mapdl-reader.

    Parameters
    ----------
    path
        Path of the file, `NAME.full`.
    deck
        Path of the archive that `CDWRITE,DB,NAME,cdb` writes, for nodes, components of nodes (as sets) and the faces of solids.

    Raises
    ------
    ModelError
        A file that is missing or damaged, not symmetric or distributed, other unknowns than displacements and rotations, constraint equations (`CE`,
        `CP`), nodes with directions of their own (`NROTAT`).

    Examples
    --------
    >>> import frictopt as fo
    >>> from ansys.mapdl.reader import examples
    >>> fo.read_ansys(examples.fullfile, deck=examples.hexarchivefile)
    MatrixJob(unknowns=900, directions=3, sets=['NCOMP2', 'NODE_SELECTION'])
    """
    reader = library("ansys.mapdl.reader", _LIBRARY, "ansys")
    file = file_path("path", path)
    full = by_library(_LIBRARY, reader.read_binary, file, "stiffness")
    if not hasattr(full, "load_km"):
        raise ModelError(f"stiffness: {file.name} is no .full file but a {type(full).__name__}; write the stiffness with WRFULL")
    directions, equations = int(full._header["numdof"]), int(full._header["ncefull"])
    if directions not in (2, 3, 6) or equations:
        problem = f"{equations} constraint equations" if equations else f"{directions} unknowns at a node"
        raise ModelError(f"stiffness: {file.name} has {problem}; give a model of displacements (and rotations) without CE and CP")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a static file has no mass
        numbers, upper, _ = by_library(_LIBRARY, lambda _: full.load_km(as_sparse=True, sort=True), file, "stiffness")
    labels, held = (np.asarray(found + [0, 1], dtype=np.intp) for found in (numbers, full.const))
    free = np.flatnonzero(~np.isin(_code(labels), _code(held)))
    K = csr_matrix(upper + triu(upper, 1).T)
    return MatrixJob(K[free][:, free], labels[free], None if deck is None else _deck(reader, file_path("deck", deck), held))


def _code(labels: Integers) -> Integers:
    """One number for each label."""
    return np.asarray(10 * labels[:, 0] + labels[:, 1])


def _deck(reader: Any, file: Path, held: Integers) -> Deck:
    """Nodes, components and solids of an archive, and what is held."""
    archive = by_library(_LIBRARY, lambda path: reader.Archive(path, parse_vtk=False), file, "deck")
    if not len(archive.nnum) or not archive.ekey.size:
        raise ModelError(f"deck {file.name}: no nodes or no elements; give the archive that CDWRITE,DB writes")
    turned = np.flatnonzero(np.any(archive.node_angles, axis=1))
    if len(turned):
        raise ModelError(f"deck {file.name}: node {archive.nnum[turned[0]]} has directions of its own; write the matrix without NROTAT")
    routine = dict(archive.ekey.tolist())
    solids: dict[str, list[list[int]]] = {}
    for element in archive.elem:
        kind, nodes = routine[int(element[1])], element[10:].tolist()
        name = _SOLIDS.get((kind, len(set(nodes))), f"{kind} of {len(set(nodes))} nodes")
        solids.setdefault(name, []).append([int(element[8]), *nodes])
    sets = {name.strip().upper(): members.tolist() for name, members in archive.node_components.items()}
    return deck_of_points(dict(zip(archive.nnum.tolist(), archive.nodes, strict=True)), solids=solids, sets=sets, held=held.tolist())
