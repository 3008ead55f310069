"""Elements and named groups of mesh files, as meshio reads them."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Integers
from ..base.libraries import by_library, library
from ..errors import ModelError
from .deck import Constraints, Deck

GROUPED = "put the body beside it into a group too, and set Mesh.SaveAll = 0 (gmsh saves only what is in a group)"
_SAVED = "in gmsh set Mesh.SaveAll = 0, and put each body and each named face into a physical group"
_NUMBERED = (
    "physical",
    "ref",
    "tag",
    "material",
    "index",
)  # ends of names of cell data that number groups
_VERSION = re.compile(rb"\$MeshFormat\s+([0-9.]+)")
_NAME = re.compile(rb'^(\d)\s+(\d+)\s+"(.*)"\s*$', re.MULTILINE)

Groups = dict[str, list[Integers]]  # name -> numbers of elements, part by part


def deck_of_file(file: Path) -> Deck:
    """Nodes, elements and groups of a mesh file, its elements numbered one block after the other."""
    of_gmsh = file.suffix.lower() == ".msh"
    remedy = _SAVED if of_gmsh else "give the file as the code wrote it"
    if of_gmsh:
        _check_version(file)
    with redirect_stdout(
        StringIO()
    ):  # meshio prints why each format that it tries first does not fit
        found = by_library("meshio", library().read, file, "mesh", remedy)
    points = np.pad(found.points, ((0, 0), (0, 3 - found.points.shape[1])))
    starts = np.cumsum([0, *(len(block.data) for block in found.cells)])[:-1].tolist()
    elements = [
        (block.type, start + np.arange(len(block.data)), block.data)
        for start, block in zip(starts, found.cells, strict=True)
    ]
    groups = _groups_of_gmsh(file, found, starts) if of_gmsh else _groups(found, starts)
    if of_gmsh:
        elements, groups = _without_copies(elements, groups)
    return Deck(
        np.arange(len(points)),
        points,
        _node_sets(found),
        tuple(
            (kind, own, nodes[:, [0, 2, 1]] if kind == "line3" else nodes)
            for kind, own, nodes in elements
            if len(own)
        ),
        {name: np.concatenate(parts) for name, parts in groups.items()},
        (),
        Constraints(np.zeros((len(points), 6), dtype=bool)),
    )


def _check_version(file: Path) -> None:
    """Check that a file of gmsh has a version of which all groups are known."""
    version = _VERSION.match(file.read_bytes() if file.is_file() else b"")
    if version and not version[1].startswith((b"2", b"4.1")):
        problem = f"it has version {version[1].decode(errors='replace')} of gmsh's format"
        raise ModelError(
            f"mesh {file.name}: {problem}; save it in version 4.1 or 2.2 (gmsh: Mesh.MshFileVersion = 4.1)"
        )


def _groups(found: Any, starts: list[int]) -> Groups:
    """Groups of any format but that of gmsh: sets, families of Salome, and numbers of groups."""
    groups: Groups = defaultdict(list)
    for name, cells in found.cell_sets.items():
        for start, own in zip(starts, cells, strict=True):
            groups[name].append(start + np.asarray(own, dtype=np.intp))
    for number, names in getattr(found, "cell_tags", {}).items():
        for start, tags in zip(starts, found.cell_data["cell_tags"], strict=True):
            for name in names:
                groups[name].append(start + np.flatnonzero(tags == number))
    for title, values in found.cell_data.items():
        if title.split(":")[-1] in _NUMBERED:
            for start, own in zip(starts, values, strict=True):
                for number in np.unique(own[own > 0]).tolist():
                    groups[f"{number:.0f}"].append(start + np.flatnonzero(own == number))
    return groups


def _node_sets(found: Any) -> dict[str, Integers]:
    """Groups of nodes: sets, and families of Salome."""
    sets = {name: np.asarray(own, dtype=np.intp) for name, own in found.point_sets.items()}
    parts: Groups = defaultdict(list)
    for number, names in getattr(found, "point_tags", {}).items():
        for name in names:
            parts[name].append(np.flatnonzero(found.point_data["point_tags"] == number))
    return sets | {name: np.concatenate(own) for name, own in parts.items()}


def _groups_of_gmsh(file: Path, found: Any, starts: list[int]) -> Groups:
    """Physical groups: by name, or by number if they have none.

    gmsh counts and names the groups of each dimension by themselves. A group that has an entity
    reversed has its number with a minus there. meshio keeps one dimension of each name, and one
    group of each entity.
    """
    raw = file.read_bytes()
    entities = _groups_of_entities(raw)
    section = raw.partition(b"$PhysicalNames")[2].partition(b"$EndPhysicalNames")[0]
    names = {
        (int(dim), int(number)): name.decode(errors="replace")
        for dim, number, name in _NAME.findall(section)
    }
    groups: Groups = defaultdict(list)
    numbered = set[tuple[int, int]]()
    for i, (start, block) in enumerate(zip(starts, found.cells, strict=True)):
        physical = np.abs(found.cell_data.get("gmsh:physical", {i: np.zeros(0, dtype=int)})[i])
        members = {
            number: np.flatnonzero(physical == number)
            for number in np.unique(physical[physical > 0]).tolist()
        }
        if entities:
            entity = int(found.cell_data["gmsh:geometrical"][i][0])
            members = dict.fromkeys(entities[block.dim, entity], np.arange(len(block.data)))
        for number, own in members.items():
            numbered.add((block.dim, number))
            groups[names.get((block.dim, number), str(number))].append(start + own)
    top = max(block.dim for block in found.cells)
    for (dim, number), name in names.items():
        if dim >= top - 1 and (dim, number) not in numbered:
            what = "boundary" if dim == top - 1 else "subdomain"
            raise ModelError(
                f"mesh {file.name}: {what} {name!r}: it names no {'faces' if dim < top else 'elements'}; {GROUPED}"
            )
    return groups


def _groups_of_entities(raw: bytes) -> dict[tuple[int, int], list[int]]:
    """Dimension and number of each entity of a file of version 4.1 -> numbers of all its groups; of another version none."""
    head = re.search(rb"\$MeshFormat\s+4\.1 ([01]) (\d)\s", raw)
    if head is None:
        return {}
    section = raw.partition(b"$Entities\n")[2].partition(b"$EndEntities")[0]
    take = _Numbers(section, binary=head[1] == b"1", size=int(head[2]))
    found = dict[tuple[int, int], list[int]]()
    for dim, count in enumerate(take.sizes(4) if section else []):
        for _ in range(count):
            (entity,) = take.integers(1)
            take.floats(6 if dim else 3)  # its box, or the place of a point
            found[dim, entity] = list(
                dict.fromkeys(abs(number) for number in take.integers(*take.sizes(1)))
            )
            if dim:
                take.integers(*take.sizes(1))  # what bounds it
    return found


class _Numbers:
    """The numbers of a section of a file, one after the other, as text or in binary form."""

    def __init__(self, section: bytes, binary: bool, size: int) -> None:
        self._size = f"u{size}"
        self._raw = section if binary else None
        self._words: Iterator[bytes] = iter(() if binary else section.split())
        self._at = 0

    def _next(self, kind: str, count: int) -> Any:
        if self._raw is None:
            return [next(self._words) for _ in range(count)]
        found = np.frombuffer(self._raw, np.dtype(kind), count, self._at)
        self._at += found.nbytes
        return found

    def sizes(self, count: int) -> list[int]:
        return [int(value) for value in self._next(self._size, count)]

    def integers(self, count: int) -> list[int]:
        return [int(value) for value in self._next("i4", count)]

    def floats(self, count: int) -> None:
        self._next("f8", count)


def _without_copies(
    elements: list[tuple[str, Integers, Integers]], groups: Groups
) -> tuple[list[tuple[str, Integers, Integers]], Groups]:
    """Elements and groups in which each element stands once: version 2.2 repeats it for each group that it is in."""
    same = np.arange(sum(len(own) for _, own, _ in elements))
    for kind in dict.fromkeys(kind for kind, _, _ in elements):
        numbers = np.concatenate([own for other, own, _ in elements if other == kind])
        nodes = np.concatenate([ends for other, _, ends in elements if other == kind])
        _, first, which = np.unique(
            np.sort(nodes, axis=1), axis=0, return_index=True, return_inverse=True
        )
        same[numbers] = numbers[first[which.ravel()]]
    if (same == np.arange(len(same))).all():
        return elements, groups
    alone = [(kind, own, nodes, same[own] == own) for kind, own, nodes in elements]
    parts = {name: [np.unique(same[np.concatenate(own)])] for name, own in groups.items()}
    return [
        (kind, own[first], nodes[first]) for kind, own, nodes, first in alone if first.any()
    ], parts
