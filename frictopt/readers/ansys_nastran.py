"""Matrices of Ansys Mechanical APDL and of Nastran, through the libraries that read their files."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, triu

from ..base import Integers, number_of, shown, whole_array
from ..base.files import by_library, file_path, library
from ..errors import ModelError
from .bulk_data import bulk_deck, cards, free_fields
from .deck import Deck
from .deck_text import text_of
from .job import MatrixJob
from .listing import deck_of_points

_ANSYS = "ansys-mapdl-reader"
# Number in Ansys of each type of elements that is read -> how many different nodes an element of
# this type may have. Wedges, pyramids and tetrahedra of Ansys are bricks with nodes that coincide.
ANSYS_SOLIDS = {
    45: (8, 6, 5, 4),
    185: (8, 6, 5, 4),
    285: (4,),
    92: (10,),
    187: (10,),
    95: (20, 15),
    186: (20, 15),
}
# First four letters of commands of Ansys that change nodes or elements after their blocks.
_CHANGES = (
    *("NROT", "NMOD", "NSCA", "NGEN", "NSYM", "NDEL", "NUMM", "NUMC"),
    *("EMOD", "EGEN", "ESYM", "EDEL"),
)


def read_ansys(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read the stiffness that Ansys Mechanical APDL assembles, from its `.full` file.

    With `WRFULL,1` before `SOLVE`, Ansys stops after the assembly. Run it in one process,
    because each process writes a file of its own. The contact itself must not be in the model: each
    body keeps its own nodes there. Displacements that `D` holds are left out; with the deck, the
    reader knows that they are held. Rotations are generalised coordinates. The extra `ansys` of the
    installation brings ansys-mapdl-reader.

    Parameters
    ----------
    path
        Path of the file, `NAME.full`.
    deck
        Path of the archive that `CDWRITE,DB,NAME,cdb` writes, for nodes, components of nodes (as
        sets) and the faces of solids.

    Returns
    -------
    MatrixJob
        The matrix with its labels, nodes and sets, as arguments of `condense`.

    Raises
    ------
    ModelError
        The file is missing or damaged, its matrix is not symmetric or is distributed over several
        files, it has unknowns other than displacements and rotations, constraint equations (`CE`,
        `CP`), or nodes with rotated directions (`NROTAT`).

    Examples
    --------
    >>> import frictopt as fo
    >>> from ansys.mapdl.reader import examples
    >>> fo.readers.read_ansys(examples.fullfile, deck=examples.hexarchivefile)
    MatrixJob(unknowns=900, directions=3, sets=['NCOMP2', 'NODE_SELECTION'])
    """
    reader = library("ansys.mapdl.reader", _ANSYS, "ansys")
    file = file_path("path", path)
    full = by_library(_ANSYS, reader.read_binary, file, "stiffness")
    _check_full(full, file)
    # The library warns that a static file has no mass. A filter of warnings would affect all
    # threads. So the library gets the stiffness as the mass, too.
    header = full._header
    header |= {"ptrMAS": header["ptrSTF"]}
    header |= {f"ntermM{part}": header[f"ntermK{part}"] for part in "lh"}
    numbers, upper, _ = by_library(
        _ANSYS, lambda _: full.load_km(as_sparse=True, sort=True), file, "stiffness"
    )
    # The library counts directions from 0.
    labels = np.asarray(numbers + [0, 1], dtype=np.intp)
    held = np.asarray(full.const + [0, 1], dtype=np.intp)
    # Node and direction as one number: there are at most 6 directions.
    free = ~np.isin(labels @ [10, 1], held @ [10, 1])
    K = csr_matrix(upper + triu(upper, 1).T)
    archive = None if deck is None else _archive(reader, file_path("deck", deck), held)
    return MatrixJob(K[free][:, free], labels[free], archive)


def _check_full(full: Any, file: Path) -> None:
    if not hasattr(full, "load_km"):
        raise ModelError(
            f"stiffness: {file.name} is no .full file but a {type(full).__name__}; "
            "write the stiffness with WRFULL"
        )
    directions = int(full._header["numdof"])
    equations = int(full._header["ncefull"])
    if equations:
        problem = number_of(equations, "constraint equation")
    elif directions not in (2, 3, 6):
        problem = f"{number_of(directions, 'unknown')} at a node"
    else:
        return
    raise ModelError(
        f"stiffness: {file.name} has {problem}; "
        "give a model of displacements (and rotations) without CE and CP"
    )


def _check_commands(file: Path) -> None:
    """Refuse an archive with something that the library ignores.

    The library reads one block of elements, and no commands. Ansys reads only the first four
    letters of a command.
    """
    lines = text_of(file, "deck").splitlines()
    commands = [line.split(",")[0].strip().upper() for line in lines]
    problems = [
        f"{commands.count(block)} {block}, of which one is read"
        for block in ("NBLOCK", "EBLOCK")
        if commands.count(block) > 1
    ]
    problems += [
        f"the command {command}, after which the nodes or elements listed are others"
        for command in commands
        if command[:4] in _CHANGES
    ]
    if problems:
        raise ModelError(
            f"deck {file.name}: {problems[0]}; give the archive that CDWRITE,DB writes (not the "
            "input file of Workbench)"
        )


def _archive(reader: Any, file: Path, held: Integers) -> Deck:
    """Nodes, components and solids of an archive, and what is held."""
    archive = by_library(_ANSYS, lambda path: reader.Archive(path, parse_vtk=False), file, "deck")
    if not len(archive.nnum) or not archive.ekey.size:
        raise ModelError(
            f"deck {file.name}: no nodes or no elements; give the archive that CDWRITE,DB writes"
        )
    _check_commands(file)
    turned = np.flatnonzero(np.any(archive.node_angles, axis=1))
    if len(turned):
        raise ModelError(
            f"deck {file.name}: node {archive.nnum[turned[0]]} has directions of its own; "
            "write the matrix without NROTAT"
        )
    try:
        solids = _solids(archive.elem, dict(archive.ekey.tolist()))
    except (IndexError, KeyError) as error:
        raise ModelError(
            f"deck {file.name}: its EBLOCK is damaged, or names a type without ET ({error}); "
            "give the file as Ansys wrote it"
        ) from error
    sets = {name.strip().upper(): nodes.tolist() for name, nodes in archive.node_components.items()}
    points = dict(zip(archive.nnum.tolist(), archive.nodes, strict=True))
    deck = deck_of_points(points, elements=solids, sets=sets)
    held_nodes = [held[held[:, 1] == direction, 0] for direction in range(1, 7)]
    is_held = np.column_stack([np.isin(deck.numbers, nodes) for nodes in held_nodes])
    return replace(deck, held=is_held)


def _solids(elements: list[Any], kinds: dict[int, int]) -> dict[str, list[list[int]]]:
    """Type -> number and nodes of each element; `kinds` maps references to types of Ansys."""
    solids: dict[str, list[list[int]]] = defaultdict(list)
    for element in elements:
        # Entry 1 is the type of the element, entry 8 its number, and nodes start at entry 10.
        kind = kinds[int(element[1])]
        nodes = list(dict.fromkeys(element[10:].tolist()))
        name = f"{kind} of {number_of(len(nodes), 'node')}"
        if len(nodes) in ANSYS_SOLIDS.get(kind, ()):
            name = f"C3D{len(nodes)}"  # the type in Abaqus
        solids[name].append([int(element[8]), *nodes])
    return solids


def read_nastran(
    path: str | Path,
    *,
    name: str | None = None,
    deck: str | Path | None = None,
    labels: ArrayLike | None = None,
) -> MatrixJob:
    """Read a stiffness that Nastran writes, as DMIG cards of a punch file or as OUTPUT4.

    `EXTSEOUT(DMIGPCH)` or `PARAM,EXTOUT,DMIGPCH` with an ASET of the displacements of the contact
    and of the loads writes KAAX as DMIG. DMIG names the grid points of its rows. OUTPUT4 (`.op4`,
    text or binary) does not name them: pass `labels`. No labels are needed for the stiffness of all
    grid points of the deck (KGG), which has six rows per grid point, in the order of their numbers.
    Rotations and scalar points are generalised coordinates. If the matrix lacks a displacement, the
    reader does not know whether it is held, see `MatrixJob.unknowns`. The extra `nastran` of the
    installation brings pyyeti.

    Parameters
    ----------
    path
        Path of the file; a file that ends in `.op4` is OUTPUT4.
    name
        Name of the matrix, such as "KAAX"; None: the only matrix of the file.
    deck
        Path of the bulk data, for grid points (`GRID`, in the basic coordinates) and the faces of
        `CHEXA`, `CTETRA`, `CPENTA` and `CPYRAM`.
    labels
        (n, 2) for OUTPUT4: grid point and component of each row, 1 to 6, or 0 for a scalar point.

    Returns
    -------
    MatrixJob
        The matrix with its labels, nodes and sets, as arguments of `condense`.

    Raises
    ------
    ModelError
        The file is missing or damaged, has no matrix of this name, or is OUTPUT4 without labels; a
        grid point has a local coordinate system; or the matrix is complex or not symmetric.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.readers.read_nastran("tests/data/joint.pch", deck="tests/data/joint.bdf")
    >>> job
    MatrixJob(unknowns=66, directions=3, sets=[])
    """
    bulk, op4 = (library(f"pyyeti.nastran.{part}", "pyyeti", "nastran") for part in ("bulk", "op4"))
    file = file_path("path", path)
    grids = None if deck is None else bulk_deck(file_path("deck", deck))
    if file.suffix.lower() != ".op4":
        K, dmig_labels = _dmig(bulk, file, name)
        return MatrixJob(K, dmig_labels, grids)
    matrices = by_library("as OUTPUT4, pyyeti", op4.read, file, "stiffness")
    K = csr_matrix(_chosen(matrices, name, file))
    if labels is None:
        return MatrixJob(K, _labels_of_grid_points(K.shape[0], grids, file), grids)
    return MatrixJob(K, whole_array("labels", labels, (None, 2), least=0, most=10**8), grids)


def _dmig(bulk: Any, file: Path, name: str | None) -> tuple[csr_matrix, Integers]:
    """A matrix of DMIG cards, and the labels of its rows."""
    found = cards(file, "stiffness", ("DMIG",))
    if not found:
        # A superelement may have its matrices in another file.
        raise ModelError(
            f"stiffness: {file.name} has no DMIG cards; write the matrix there with "
            "EXTSEOUT(DMIGPCH) or PARAM,EXTOUT,DMIGPCH, or give an OUTPUT4 file, NAME.op4"
        )
    # pyyeti by itself loses lines that follow a comment, and large fields with commas. It needs all
    # cards of a matrix together. First comes the header, the card with 0 in place of a grid point.
    found.sort(key=lambda card: (card.field(1).upper(), card.field(2) != "0"))
    headers = Counter(card.field(1).upper() for card in found if card.field(2) == "0")
    for header, count in headers.items():
        if count > 1:
            raise ModelError(
                f"stiffness: {file.name} has {header} {count} times; give a file of one job"
            )
    text = free_fields(found)
    matrices = by_library(
        "as DMIG, pyyeti", lambda _: bulk.rddmig(StringIO(text)), file, "stiffness"
    )
    frame = _chosen(matrices, name, file)
    if frame.columns.nlevels != 2:
        raise ModelError(
            f"stiffness: {file.name} has a rectangular matrix {shown(name)}; "
            "give the name of a stiffness"
        )
    labels = frame.index.union(frame.columns)
    square = frame.reindex(index=labels, columns=labels, fill_value=0.0)
    return csr_matrix(square.to_numpy()), np.array(labels.tolist())


def _labels_of_grid_points(size: int, grids: Deck | None, file: Path) -> Integers:
    """(size, 2) labels of a matrix with six rows for each grid point."""
    numbers = np.zeros(0, dtype=np.intp) if grids is None else np.sort(grids.numbers)
    count = len(numbers)
    if count == 0 or size != 6 * count:
        raise ModelError(
            f"labels: none, and {file.name} has {number_of(size, 'row')}, not six for each of "
            f"{number_of(count, 'grid point')} of the deck; give grid point and component of each "
            "row, which OUTPUT4 does not say, or write DMIG"
        )
    return np.column_stack([np.repeat(numbers, 6), np.tile(np.arange(1, 7), count)])


def _chosen(matrices: Mapping[str, Any], name: str | None, file: Path) -> Any:
    """The matrix with this name; without a name, the only matrix."""
    key = next(iter(matrices), "") if name is None else str(name).lower()
    if key not in matrices or (name is None and len(matrices) > 1):
        names = ", ".join(sorted(matrices)).upper() or "of no name"
        raise ModelError(
            f"name: {shown(name)}; {file.name} has the matrices {names}: give one of these"
        )
    return matrices[key]
