"""Decks of CalculiX and Abaqus: their text, and what they hold: nodes, sets, elements, and constraints, by which loads follow."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ..base import ROUNDING, Array, Booleans, Integers, Shown, shown, whole, whole_array
from ..errors import ModelError

Block: TypeAlias = tuple[
    str, dict[str, str], list[str]
]  # keyword and names of parameters without blanks, data lines
Faces: TypeAlias = tuple[
    tuple[Integers, int], ...
]  # numbers of elements, and which face of them is meant, in pairs
# in place of the number of a face: all faces of an element that lie on the outline of the mesh
FREE = 0

# Types of elements as CalculiX and Abaqus, or meshio, call them.
_PLANES = ("CPE", "CPS", "CAX")
PLANES = (
    *_PLANES,
    "triangle",
    "quad",
)  # beside solids they only name faces: gmsh writes named surfaces as CPS
_FLAT = {
    3: "triangle",
    4: "quad",
    6: "triangle6",
    8: "quad8",
}  # shapes as meshio names them, by number of nodes
SHAPES = {"C3D4": "tetra", "C3D8": "hexahedron", "C3D10": "tetra10", "C3D20": "hexahedron20"}
SHAPES |= {f"{kind}{n}": shape for kind in _PLANES for n, shape in _FLAT.items()}
PLANE = {
    "triangle": 3,
    "triangle6": 3,
    "quad": 4,
    "quad8": 4,
    "quad9": 4,
}  # shapes, as meshio names them, and their corners, which come first
SOLID = {"tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8}
SOLIDS = ("C3D", "tetra", "hexahedron")
LINES = (
    "T2D2",
    "T3D2",
    "T2D3",
    "T3D3",
    "line",
)  # gmsh writes named curves so; the ends come first and last
LINEAR = ("C3D4", "C3D5", "C3D6", "C3D8")  # solids all nodes of which are corners
FACELESS = (
    *LINES,
    "vertex",
    "SPRING",
    "MASS",
    "ROTARYI",
    "DASHPOT",
    "DCOUP",
    "GAP",
    "CONN",
)  # they carry no traction
_KNOWN = re.compile(r"(C3D|CPE|CPS|CAX|T2D|T3D)(\d+)")


def shape_of(kind: str) -> str | None:
    """The shape of a type of elements with faces; None if it is none of `SHAPES`."""
    match = _KNOWN.match(kind)
    return SHAPES.get(match.group()) if match else kind if kind in PLANE | SOLID else None


def node_count(kind: str) -> int | None:
    """How many nodes an element of a type has; None if it is neither solid nor truss."""
    match = _KNOWN.match(kind)
    return int(match[2]) if match else None


@dataclass(frozen=True, eq=False)
class Constraints:
    """Held displacements and rotations, and those that follow others; those of node i are the unknowns 6 i to 6 i + 5.

    They are those of `*BOUNDARY`, `*EQUATION`, `*RIGID BODY`, and of `*COUPLING` with `*KINEMATIC`,
    where `u_i = u_ref + rotation x (x_i - x_ref)`.
    """

    held: Booleans  # (nodes, 6)
    ends: Integers = field(
        default_factory=lambda: np.zeros((0, 2), dtype=np.intp)
    )  # (m, 2) unknowns, the first of which follows the second
    weights: Array = field(default_factory=lambda: np.zeros(0))  # (m,) how much
    rigid: tuple[
        tuple[int, int | None], ...
        # rows of the reference of a rigid part, and of the node of its rotation: None, the code makes
        # it
    ] = ()
    others: tuple[str, ...] = ()  # keywords whose equations are not in the deck

    def passed_on(self, forces: Array, present: Booleans, numbers: Integers) -> Array:
        """(nodes, 6) the same forces and moments, those on unknowns that follow others moved to these; `present` are those in the matrix."""
        wanting, moved = ~(present | self.held).ravel(), forces.ravel()
        own = wanting[self.ends[:, 0]]
        (row, column), follows = self.ends[own].T, np.zeros(forces.size, dtype=bool)
        follow = csr_matrix((self.weights[own], (row, column)), shape=(forces.size,) * 2)
        follows[row] = True
        for _ in row:  # a chain is not longer
            if not moved[follows].any():
                break
            moved = np.where(follows, 0.0, moved) + follow.T @ np.where(follows, moved, 0.0)
        lost = wanting & (np.abs(moved) > ROUNDING * np.abs(forces).max(initial=0.0))
        if lost.any():
            node, axis = divmod(int(lost.argmax()), 6)
            why = (
                f"the deck has {', '.join(self.others)}"
                if self.others
                else "give the deck of the same job"
            )
            raise ModelError(
                f"force: it acts on node {numbers[node]}, direction {axis + 1}, that neither the matrix nor *BOUNDARY has, and no *EQUATION says "
                f"what it follows ({why}); load nodes that follow no others, write the constraint as *EQUATION, or merge tied nodes"
            )
        return np.asarray(moved.reshape(forces.shape))

    def part(self, reference: int) -> tuple[Integers, Array]:
        """Unknowns (m,) that follow the displacements of a node, and (m, 6) how much they follow these and its rotation."""
        first = 6 * reference
        leads = (self.ends[:, 1] >= first) & (self.ends[:, 1] < first + 6)
        unknowns = np.unique(self.ends[leads & (self.ends[:, 1] < first + 3), 0])
        follow = csr_matrix(
            (self.weights[leads], (self.ends[leads, 0], self.ends[leads, 1] - first)),
            shape=(self.held.size, 6),
        )
        return unknowns, follow[unknowns].toarray()

    def following(self, ends: Integers, weights: Array) -> "Constraints":
        """The same, with more unknowns that follow others."""
        return replace(
            self,
            ends=np.concatenate([self.ends, ends]),
            weights=np.concatenate([self.weights, weights]),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Deck(Shown):
    """Nodes, sets and elements of a CalculiX or Abaqus deck. Names of sets are in capital letters, for neither code distinguishes cases.

    Examples
    --------
    >>> import frictopt as fo
    >>> deck = fo.read_calculix("tests/data/flat").deck
    >>> deck
    Deck(nodes=491, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH',
    'N_PUNCH', 'N_TOP'], elements=['CPE3'])
    >>> deck.numbers[deck.nodes("n_top")].tolist()
    [9, 10, 100, 101, 102, 103]
    """

    numbers: Integers  # (nodes,) of the nodes
    points: Array  # (nodes, 3) coordinates
    sets: Mapping[str, Integers]  # node set, or surface of nodes -> rows of `points`
    elements: tuple[
        tuple[str, Integers, Integers], ...
    ]  # of each block type, numbers (m,), and nodes (m, k) by row
    element_sets: Mapping[str, Integers]  # element set -> numbers of elements
    thicknesses: tuple[
        float, ...
    ]  # different ones of the sections of plane elements; nan for one that varies
    constraints: Constraints  # displacements and rotations that are held or follow others
    surfaces: Mapping[str, Faces] = field(default_factory=dict)  # surface of elements -> its faces

    def _answer(self) -> Mapping[str, object]:
        return {
            "nodes": len(self.numbers),
            "sets": sorted(self.sets),
            "elements": sorted({kind for kind, _, _ in self.elements}),
        }

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Rows of `points` of the nodes of a set; or the rows that are given, each once.

        Raises
        ------
        ModelError
            The deck has no such node set, or it is empty; numbers that are no rows of `points`.
        """
        if isinstance(where, str):
            if not len(self.sets.get(where.upper(), ())):
                raise ModelError(
                    f"node set {where!r}: unknown, or it has no nodes; this deck names {sorted({*self.sets, *self.surfaces})}"
                )
            return self.sets[where.upper()]
        rows = whole_array("nodes", where, (None,), least=0, most=len(self.points) - 1)
        if not len(rows) or len(np.unique(rows)) != len(rows):
            raise ModelError(
                f"nodes: {shown(where)}; give the name of a node set or different rows of `points`"
            )
        return rows

    @property
    def thickness(self) -> float:
        """Thickness of the plane elements; 1 if no section gives one, as in both codes.

        Raises
        ------
        ModelError
            Sections of several thicknesses, or of one that varies.
        """
        if len(self.thicknesses) > 1 or not all(0 < t < np.inf for t in self.thicknesses):
            raise ModelError(
                f"deck: sections of thickness {', '.join(f'{t:g}' for t in self.thicknesses)}; give all plane elements one thickness"
            )
        return self.thicknesses[0] if self.thicknesses else 1.0

    @property
    def faces(self) -> list[tuple[Integers, Integers]]:
        """Numbers (m,) and nodes (m, k) of the elements that only name facets, block by block: in the plane lines, in space plane elements."""
        if self._in_space:
            return [
                (numbers, nodes)
                for kind, numbers, nodes in self.elements
                if kind.startswith(PLANES)
            ]
        return [
            (numbers, nodes[:, [0, -1]])
            for kind, numbers, nodes in self.elements
            if kind.startswith(LINES)
        ]

    @property
    def midsides(self) -> Integers:
        """Rows of the nodes amid edges of quadratic elements."""
        found = [
            nodes[:, (PLANE | SOLID).get(str(shape_of(kind)), nodes.shape[1]) :].ravel()
            for kind, _, nodes in self.elements
        ]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *found]))

    @property
    def corners(self) -> Integers:
        """Rows of all other nodes."""
        return np.setdiff1d(np.arange(len(self.numbers)), self.midsides)

    @property
    def unclear(self) -> list[tuple[str, Integers]]:
        """Type and nodes (m, k) of elements some nodes of which may lie amid edges, but it is not known which."""
        found = list[tuple[str, Integers]]()
        for kind, _, nodes in self.elements:
            match = _KNOWN.match(kind)
            linear = nodes.shape[1] <= 4 or (match and match.group() in LINEAR)
            if shape_of(kind) is None and not linear:
                found.append((kind, nodes))
        return found

    @property
    def _in_space(self) -> bool:
        return any(kind.startswith(SOLIDS) for kind, _, _ in self.elements)

    def shaped(self) -> tuple[str, Integers, Integers]:
        """The shape that all elements with faces have (as meshio names it), their numbers (m,) and nodes (m, k); beside solids, planes only name.

        Raises
        ------
        ModelError
            No elements, elements of several shapes, or others than triangles, quadrilaterals,
            tetrahedra and hexahedra, linear or quadratic.
        """
        solids = [
            block
            for block in self.elements
            if not block[0].startswith((*FACELESS, *PLANES) if self._in_space else FACELESS)
        ]
        if odd := sorted({kind for kind, _, _ in solids if shape_of(kind) is None}):
            raise ModelError(
                f"deck: elements of type {', '.join(odd)}; give solids, {', '.join(SHAPES)} (gmsh: Mesh.SecondOrderIncomplete = 1)"
            )
        shapes = sorted({str(shape_of(kind)) for kind, _, _ in solids})
        if len(shapes) != 1:
            raise ModelError(
                f"deck: {'elements of several shapes, ' * bool(shapes)}{', '.join(shapes) or 'no elements'}; give elements of one shape"
            )
        return shapes[0], *(np.concatenate([block[i] for block in solids]) for i in (1, 2))  # type: ignore[return-value]


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct pairs of whole numbers, some of them displacements, and return them read-only."""
    labels = whole_array("labels", values, (None, 2), least=-(10**12), most=10**12)
    if not displaced(labels).any():
        raise ModelError(
            "labels: none is that of a displacement, a node and direction 1, 2 or 3; without any there is no contact"
        )
    if twice := len(labels) - len(np.unique(labels, axis=0)):
        raise ModelError(
            f"labels: {twice} labels are given twice; write the matrix of solids alone: shells, beams and trusses have several rows"
        )
    return whole(labels)


def displaced(labels: Integers) -> Booleans:
    """(n,) whether a label is that of a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, numbers: Integers, constraints: Constraints) -> Integers:
    """(nodes, 6) row of each node's displacements and rotations, -1 where the deck holds them, -2 where there is none else."""
    if len(lost := np.setdiff1d(labels[displaced(labels), 0], numbers)):
        raise ModelError(
            f"deck: node {lost[0]} of the matrix is not in it; give the deck of the same job, of solids alone, not shells or beams"
        )
    rows = np.flatnonzero(
        np.isin(labels[:, 0], numbers) & (labels[:, 1] >= 1) & (labels[:, 1] <= 6)
    )
    order = np.argsort(numbers)
    node = order[np.searchsorted(numbers, labels[rows, 0], sorter=order)]
    unknowns = np.where(constraints.held, -1, -2)
    unknowns[node, labels[rows, 1] - 1] = rows
    return whole(unknowns)


def text_of(path: Path, what: str) -> str:
    """Text of a file, without a byte-order mark."""
    try:
        return path.read_text(encoding="utf-8-sig", errors="replace")
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{what}: {str(path)!r} cannot be read ({error}); give the path of a file"
        ) from error


def blocks(path: Path) -> Iterator[Block]:
    """The blocks of a deck and of the files that it includes, in order; all in capitals except data lines."""
    lines = list(_lines(path))
    starts = [i for i, line in enumerate(lines) if line.startswith("*")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        head, first = lines[start][1:], start + 1
        while head.endswith(",") and first < end and _continues(lines[first]):
            head, first = head + lines[first], first + 1
        keyword, *rest = (part.strip() for part in head.split(","))
        pairs = [
            (_joined(name), value.strip().strip('"'))
            for name, _, value in (part.partition("=") for part in rest if part)
        ]
        yield _joined(keyword), {name: value.upper() for name, value in pairs}, lines[first:end]


def _lines(path: Path, depth: int = 0) -> Iterator[str]:
    """The lines of a deck that are no comments, those of a file that it includes in the place of *INCLUDE: it may go on with the block before."""
    if depth > 20:
        raise ModelError(f"deck {path.name}: it includes itself; take the *INCLUDE out")
    lines = (
        line
        for line in map(str.strip, text_of(path, "deck").splitlines())
        if line and not line.startswith("**")
    )
    for line in lines:
        if _joined(line.split(",")[0]) == "*INCLUDE":
            given = (line if "=" in line else next(lines, "")).split(",")
            files = [
                file.strip(' "')
                for name, _, file in (part.partition("=") for part in given)
                if _joined(name) == "INPUT"
            ]
            yield from _lines(path.parent / (files or [""])[0], depth + 1)
        else:
            yield line


def _continues(line: str) -> bool:
    """Whether a line after a comma goes on with parameters: Abaqus continues keyword lines so, CalculiX takes a last comma for nothing."""
    return "=" in line or line.split(",")[0].strip().upper() == "GENERATE"


def _joined(words: str) -> str:
    return "".join(words.split()).upper()


def entries(line: str) -> list[str]:
    """The entries of a data line, empty ones too."""
    return [entry.strip().strip('"') for entry in line.split(",")]


def fields(line: str) -> list[str]:
    """The entries of a data line that are not empty."""
    return [entry for entry in entries(line) if entry]


def number(entry: str) -> float:
    """The value of an entry, with an exponent of E or D."""
    return float(entry.upper().replace("D", "E"))
