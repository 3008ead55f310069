"""Elements and named groups of mesh files, as meshio reads them.

meshio keeps only a part of the physical groups of gmsh, so this file reads them itself.
"""

import re
from collections import defaultdict
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Integers
from ..base.files import by_library, library
from ..errors import ModelError
from .deck import Deck, Elements

GROUPED = (
    "put the body beside it into a group too, and set Mesh.SaveAll = 0 "
    "(gmsh saves only what is in a group)"
)
_VERSION = re.compile(rb"\$MeshFormat\s+([0-9.]+)")
_FORMAT_4_1 = re.compile(rb"\$MeshFormat\s+4\.1 ([01]) (\d)\s")
# On Windows a line of text ends with two characters.
_ENTITIES = re.compile(rb"\$Entities\r?\n")
_NAME = re.compile(rb'^(\d)\s+(\d+)\s+"(.*)"\s*$', re.MULTILINE)

# Name of a group -> numbers of its elements, part by part.
Groups = dict[str, list[Integers]]
# Dimension, and number of a group or an entity: gmsh counts each dimension separately.
_Key = tuple[int, int]

_SAVED = (
    "in gmsh set Mesh.SaveAll = 0, and put each body and each named face into a physical group; "
    "set Mesh.SaveParametric = 0"
)
# Ends of the names of files that are not read -> how to get a file that is read.
_WAYS = {
    ".unv": "open it in gmsh and save it as .msh",
    ".mail": "in code_aster, read it with LIRE_MAILLAGE(FORMAT='ASTER') and write it with "
    "IMPR_RESU(FORMAT='MED')",
    ".feb": "in FEBio Studio, export the geometry as .vtk",
    ".frd": "give the .inp of the job; or, in cgx, `read NAME.frd` and `send all abq`, and rename "
    "all.msh, which is a deck, to all.inp",
}
_ANY_WAY = "convert it to .inp, .msh, .med, .bdf or .vtu; gmsh opens some files, and saves .msh"
# Cell data contain numbers of groups if their names end with one of these words.
_NUMBERS_OF_GROUPS = ("physical", "ref", "tag", "material", "index")

# Ends of the names of Exodus files, and elements whose nodes are mixed up there. Exodus lists the
# middle nodes of the upright edges of these elements before the middle nodes of the upper edges;
# meshio 5.3.5 expects the opposite order.
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
    # meshio tries one format after the other, and prints why the wrong ones do not fit.
    with redirect_stdout(StringIO()):
        contents = by_library("meshio", meshio.read, file, "mesh", remedy)

    elements: list[Elements] = []
    count = 0
    for block in contents.cells:
        if ending in _EXODUS and block.type in _MIXED_UP_IN_EXODUS:
            raise ModelError(
                f"mesh {file.name}: {block.type}: meshio mixes up the middle nodes of these bricks "
                "of Exodus files; write the mesh in another format, for instance .vtu or .inp"
            )
        numbers = count + np.arange(len(block.data))
        elements.append(Elements(block.type, numbers, block.data))
        count += len(block.data)

    if is_gmsh:
        groups = groups_of_gmsh(file, contents, elements)
        elements, groups = without_copies(elements, groups)
    else:
        groups = _groups(contents, elements)

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
    """The elements with their nodes in the order of decks: the end of a line is its last node."""
    if block.kind != "line3":
        return block
    return block._replace(nodes=block.nodes[:, [0, 2, 1]])


def _groups(contents: Any, elements: list[Elements]) -> Groups:
    """Groups of any format except gmsh: sets, families of Salome, numbered groups."""
    groups: Groups = defaultdict(list)
    for name, blocks in contents.cell_sets.items():
        for block, places in zip(elements, blocks, strict=True):
            groups[name].append(block.numbers[np.asarray(places, dtype=np.intp)])

    for number, names in getattr(contents, "cell_tags", {}).items():
        for block, tags in zip(elements, contents.cell_data["cell_tags"], strict=True):
            for name in names:
                groups[name].append(block.numbers[tags == number])

    for title, blocks in contents.cell_data.items():
        if title.split(":")[-1] not in _NUMBERS_OF_GROUPS:
            continue
        for block, of_groups in zip(elements, blocks, strict=True):
            for number, members in _members(block, of_groups).items():
                groups[f"{number:.0f}"].append(members)
    return groups


def _node_sets(contents: Any) -> dict[str, Integers]:
    """Groups of nodes: sets, and families of Salome."""
    sets = {name: np.asarray(nodes, dtype=np.intp) for name, nodes in contents.point_sets.items()}
    families: Groups = defaultdict(list)
    for number, names in getattr(contents, "point_tags", {}).items():
        for name in names:
            families[name].append(np.flatnonzero(contents.point_data["point_tags"] == number))
    return sets | {name: np.concatenate(parts) for name, parts in families.items()}


def check_version(file: Path) -> None:
    """Check that a gmsh file has no partitions, and is in a format version with readable groups."""
    contents = file.read_bytes() if file.is_file() else b""
    version = _VERSION.match(contents)
    if version and not version[1].startswith((b"2", b"4.1")):
        raise ModelError(
            f"mesh {file.name}: it has version {version[1].decode(errors='replace')} of gmsh's "
            "format; save it in version 4.1 or 2.2 (gmsh: Mesh.MshFileVersion = 4.1)"
        )
    if b"$PartitionedEntities" in contents:
        raise ModelError(
            f"mesh {file.name}: it is partitioned; save the mesh before it is partitioned, or "
            "after unpartition() of gmsh.model.mesh"
        )


def groups_of_gmsh(file: Path, contents: Any, elements: list[Elements]) -> Groups:
    """Physical groups: by name, or by number if they have none.

    `contents` are what meshio reads, and `elements` the elements of its blocks. meshio keeps only
    one dimension of each name, and one group of each entity, so both are read here.
    """
    raw = file.read_bytes()
    names = _names(raw)
    entities = _groups_of_entities(file, raw)
    groups: Groups = defaultdict(list)
    numbered = set[_Key]()
    dimensions = [block.dim for block in contents.cells]
    for i, (dim, block) in enumerate(zip(dimensions, elements, strict=True)):
        if entities:
            # A block of version 4.1 has the elements of one entity.
            entity = int(contents.cell_data["gmsh:geometrical"][i][0])
            members = dict.fromkeys(entities[dim, entity], block.numbers)
        elif "gmsh:physical" in contents.cell_data:
            # A minus means that a group contains an entity reversed.
            members = _members(block, np.abs(contents.cell_data["gmsh:physical"][i]))
        else:
            members = {}
        for number, in_group in members.items():
            numbered.add((dim, number))
            groups[names.get((dim, number), str(number))].append(in_group)

    _check_groups_have_elements(names, numbered, max(dimensions), file)
    return groups


def _names(raw: bytes) -> dict[_Key, str]:
    """Names of groups, without the blanks that gmsh appends to names from Salome."""
    section = raw.partition(b"$PhysicalNames")[2].partition(b"$EndPhysicalNames")[0]
    return {
        (int(dim), int(number)): name.decode(errors="replace").rstrip()
        for dim, number, name in _NAME.findall(section)
    }


def _members(block: Elements, of_groups: Integers) -> dict[int, Integers]:
    """Number of each group, above 0 -> the elements of a block that are in it, by their numbers."""
    return {
        number: block.numbers[np.flatnonzero(of_groups == number)]
        for number in np.unique(of_groups[of_groups > 0]).tolist()
    }


def _check_groups_have_elements(
    names: dict[_Key, str], numbered: set[_Key], highest: int, file: Path
) -> None:
    """Check that each named body or boundary has elements; other groups may be empty."""
    for (dim, number), name in names.items():
        if dim < highest - 1 or (dim, number) in numbered:
            continue
        kind, members = ("boundary", "faces") if dim < highest else ("subdomain", "elements")
        raise ModelError(f"mesh {file.name}: {kind} {name!r}: it names no {members}; {GROUPED}")


def _groups_of_entities(file: Path, raw: bytes) -> dict[_Key, list[int]]:
    """Numbers of all groups of each entity in a file of version 4.1; empty for other versions."""
    head = _FORMAT_4_1.search(raw)
    start = _ENTITIES.search(raw)
    if head is None or start is None:
        return {}
    read = library("meshio.gmsh._gmsh41")._read_entities
    with file.open("rb") as opened:
        opened.seek(start.end())
        by_dimension, _ = read(opened, head[1] == b"0", int(head[2]))
    # A minus means that the group contains the entity reversed.
    return {
        (dim, entity): list(dict.fromkeys(map(abs, numbers)))
        for dim, entities in enumerate(by_dimension)
        for entity, numbers in entities.items()
    }


def without_copies(elements: list[Elements], groups: Groups) -> tuple[list[Elements], Groups]:
    """Elements and groups in which each element occurs once.

    Version 2.2 of the format repeats an element for each group that it is in.
    """
    # (elements,) number of the first element with the same nodes
    same = np.arange(sum(len(block.numbers) for block in elements))
    for kind in dict.fromkeys(block.kind for block in elements):
        numbers = np.concatenate([block.numbers for block in elements if block.kind == kind])
        nodes = np.concatenate([block.nodes for block in elements if block.kind == kind])
        _, first, which = np.unique(
            np.sort(nodes, axis=1), axis=0, return_index=True, return_inverse=True
        )
        same[numbers] = numbers[first[which.ravel()]]
    distinct = []
    for kind, numbers, nodes in elements:
        is_first = same[numbers] == numbers
        distinct.append(Elements(kind, numbers[is_first], nodes[is_first]))
    members = {name: [np.unique(same[np.concatenate(parts)])] for name, parts in groups.items()}
    return distinct, members
