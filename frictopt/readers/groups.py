"""Elements and named groups of mesh files, as meshio reads them."""

from collections import defaultdict
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Integers
from ..base.libraries import by_library, library
from ..errors import ModelError
from .deck import Deck, Elements
from .gmsh import Groups, check_version, groups_of_gmsh, without_copies

_SAVED = (
    "in gmsh set Mesh.SaveAll = 0, and put each body and each named face into a physical group; "
    "set Mesh.SaveParametric = 0"
)
# Ends of the names of files that are not read -> a way to files that are.
_WAYS = {
    ".unv": "open it in gmsh and save it as .msh",
    ".mail": "in code_aster, read it with LIRE_MAILLAGE(FORMAT='ASTER') and write it with "
    "IMPR_RESU(FORMAT='MED')",
    ".feb": "in FEBio Studio, export the geometry as .vtk",
    ".frd": "give the .inp of the job; or, in cgx, `read NAME.frd` and `send all abq`, and rename "
    "all.msh, which is a deck, to all.inp",
}
_ANY_WAY = "convert it to .inp, .msh, .med, .bdf or .vtu; gmsh opens some files, and saves .msh"
# Ends of names of cell data that number groups.
_NUMBERS_OF_GROUPS = ("physical", "ref", "tag", "material", "index")

# Ends of the names of Exodus files. Exodus has the middle nodes of the upright edges of these
# elements before the middle nodes of the upper edges; meshio 5.3.5 takes them for the upper ones.
_EXODUS = (".e", ".ex2", ".exo")
_MIXED_UP_IN_EXODUS = ("hexahedron20", "hexahedron27")


def deck_of_file(file: Path) -> Deck:
    """Nodes, elements and groups of a mesh file; its elements are numbered block after block."""
    meshio = _meshio()
    ending = file.suffix.lower()
    if not file.name.lower().endswith(tuple(meshio.extension_to_filetypes)):
        raise ModelError(
            f"mesh {file.name}: files {ending or 'without an ending'} are not read; "
            f"{_WAYS.get(ending, _ANY_WAY)}"
        )
    is_gmsh = ending == ".msh"
    remedy = "give the file as the code wrote it, or open it in gmsh and save it as .msh"
    if ending == ".med":
        remedy = "files of older versions may be unreadable: open it in gmsh and save it as .msh"
    if is_gmsh:
        remedy = _SAVED
        check_version(file)
    # meshio tries several formats, and prints why each of the first ones does not fit.
    with redirect_stdout(StringIO()):
        contents = by_library("meshio", meshio.read, file, "mesh", remedy)

    elements: list[Elements] = []
    starts: list[int] = []
    count = 0
    for block in contents.cells:
        if ending in _EXODUS and block.type in _MIXED_UP_IN_EXODUS:
            raise ModelError(
                f"mesh {file.name}: {block.type}: meshio mixes up the middle nodes of these bricks "
                "of Exodus files; write the mesh in another format, for instance .vtu or .inp"
            )
        starts.append(count)
        numbers = count + np.arange(len(block.data))
        elements.append(Elements(block.type, numbers, block.data))
        count += len(block.data)

    if is_gmsh:
        groups = groups_of_gmsh(file, contents, starts)
        elements, groups = without_copies(elements, groups)
    else:
        groups = _groups(contents, starts)

    points = np.pad(contents.points, ((0, 0), (0, 3 - contents.points.shape[1])))
    return Deck(
        numbers=np.arange(len(points)),
        points=points,
        sets=_node_sets(contents),
        elements=tuple(_ends_last(block) for block in elements if len(block.numbers)),
        element_sets={name: np.concatenate(parts) for name, parts in groups.items()},
        thicknesses=(),
        held=np.zeros((len(points), 6), dtype=bool),
    )


def _meshio() -> Any:
    """The library meshio, with all shapes in its table of dimensions.

    meshio 5.3.5 knows the nodes of quadratic wedges and pyramids, but not their dimension.
    """
    dimensions = library("meshio._mesh").topological_dimension
    for shape in ("wedge15", "pyramid13"):
        dimensions.setdefault(shape, 3)
    return library()


def _ends_last(block: Elements) -> Elements:
    """The elements with their nodes as a deck has them: a line ends at its last node."""
    if block.kind != "line3":
        return block
    return block._replace(nodes=block.nodes[:, [0, 2, 1]])


def _groups(contents: Any, starts: list[int]) -> Groups:
    """Groups of any format but that of gmsh: sets, families of Salome, and numbers of groups."""
    groups: Groups = defaultdict(list)
    for name, blocks in contents.cell_sets.items():
        for start, members in zip(starts, blocks, strict=True):
            groups[name].append(start + np.asarray(members, dtype=np.intp))

    for number, names in getattr(contents, "cell_tags", {}).items():
        for start, tags in zip(starts, contents.cell_data["cell_tags"], strict=True):
            for name in names:
                groups[name].append(start + np.flatnonzero(tags == number))

    for title, blocks in contents.cell_data.items():
        if title.split(":")[-1] not in _NUMBERS_OF_GROUPS:
            continue
        for start, numbers in zip(starts, blocks, strict=True):
            for number in np.unique(numbers[numbers > 0]).tolist():
                groups[f"{number:.0f}"].append(start + np.flatnonzero(numbers == number))
    return groups


def _node_sets(contents: Any) -> dict[str, Integers]:
    """Groups of nodes: sets, and families of Salome."""
    sets = {name: np.asarray(nodes, dtype=np.intp) for name, nodes in contents.point_sets.items()}
    families: Groups = defaultdict(list)
    for number, names in getattr(contents, "point_tags", {}).items():
        for name in names:
            families[name].append(np.flatnonzero(contents.point_data["point_tags"] == number))
    return sets | {name: np.concatenate(parts) for name, parts in families.items()}
