"""Nodes, sets, elements and constraints of a deck or a mesh file, by rows of the nodes.

Types of elements have their names in Abaqus and CalculiX ("C3D8") or in meshio ("hexahedron").
"""

from __future__ import annotations

import re
from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..base import SAME_POINT, Array, Booleans, Integers, Shown, shown, whole_array
from ..errors import ModelError

# Number of corners of each shape, by its name in meshio. Corners come before midside nodes.
PLANE_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
CORNERS = PLANE_CORNERS | {"tetra": 4, "tetra10": 4, "wedge": 6, "wedge15": 6, "pyramid": 5}
CORNERS |= {"hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8}

# Types of Abaqus that are read with their faces, and their shapes.
SHAPES = {"C3D4": "tetra", "C3D8": "hexahedron", "C3D10": "tetra10", "C3D20": "hexahedron20"}
SHAPES |= {"C3D5": "pyramid", "C3D6": "wedge", "C3D15": "wedge15"}
for _family in ("CPE", "CPS", "CAX"):
    SHAPES |= {f"{_family}3": "triangle", f"{_family}4": "quad"}
    SHAPES |= {f"{_family}6": "triangle6", f"{_family}8": "quad8"}

# The types below are beginnings of names.
SOLIDS = ("C3D", "tetra", "hexahedron", "wedge", "pyramid")
# If there are solids, plane elements only name faces: gmsh writes named surfaces as CPS.
PLANES = ("CPE", "CPS", "CAX", "triangle", "quad")
# In the plane, lines name boundaries: gmsh writes named curves as lines, with their ends first and
# last.
LINES = ("T2D2", "T3D2", "T2D3", "T3D3", "line")
# Beams, shells, membranes, and rigid lines and surfaces.
THIN = (
    *("B2", "B3", "PIPE", "S3", "S4", "S6", "S8", "S9", "STRI", "M3D", "SFM", "F3D"),
    *("R2D", "R3D", "RAX", "RB2D", "RB3D"),
)
# These elements may lie on a face of a solid, but do not hide the face. Continuum shells (SC) have
# a volume.
SLENDER = (*THIN, "SC")
# These elements carry no traction.
FACELESS = (*LINES, "vertex", "SPRING", "MASS", "ROTARYI", "DASHPOT", "DCOUP", "GAP", "CONN")

# A letter that changes the formulation may follow: C3D8R, C3D8I.
_WITH_NODE_COUNT = re.compile(r"(C3D|CPE|CPS|CAX|T2D|T3D)(\d+)")


def shape_of(kind: str) -> str | None:
    """The shape (its name in meshio) of a type of elements; None if its faces are not known."""
    match = _WITH_NODE_COUNT.match(kind)
    if match:
        return SHAPES.get(match.group())
    return kind if kind in CORNERS else None


def is_linear(shape: str) -> bool:
    """Whether all nodes of a shape are corners."""
    return not shape[-1].isdecimal()


def corner_shape(shape: str) -> str:
    """The linear shape that has the corners of a shape."""
    return shape.rstrip("0123456789")


def node_count(kind: str) -> int | None:
    """Number of nodes of an element of a type; None if it is neither solid nor truss."""
    match = _WITH_NODE_COUNT.match(kind)
    return int(match[2]) if match else None


# Faces of a surface, as pairs: numbers of elements, and the number of their face (1 for S1).
Faces: TypeAlias = tuple[tuple[Integers, int], ...]
# In place of the number of a face: all faces of the element that lie on the outline of the mesh.
FREE = 0


class Elements(NamedTuple):
    """Elements of one type: their numbers (m,), and their nodes (m, k) as rows of the points."""

    kind: str
    numbers: Integers
    nodes: Integers


@dataclass(frozen=True, eq=False, repr=False)
class Deck(Shown):
    """Nodes, sets and elements of a deck or of a mesh file.

    CalculiX and Abaqus do not distinguish cases, so names of their sets are in capital letters.

    Examples
    --------
    >>> import frictopt as fo
    >>> deck = fo.readers.read_calculix("tests/data/flat").deck
    >>> deck
    Deck(nodes=491, sets=['NALL', 'N_BLOCK', 'N_BOTTOM', 'N_CONTACT_BLOCK', 'N_CONTACT_PUNCH',
    'N_PUNCH', 'N_TOP'], elements=['CPE3'])
    >>> deck.numbers[deck.nodes("n_top")].tolist()
    [9, 10, 100, 101, 102, 103]
    """

    # (nodes,) numbers of the nodes
    numbers: Integers
    # (nodes, 3) coordinates
    points: Array
    # node set, or surface of nodes -> rows of `points`
    sets: Mapping[str, Integers]
    elements: tuple[Elements, ...]
    # element set -> numbers of elements
    element_sets: Mapping[str, Integers]
    # distinct thicknesses of the sections of plane elements; nan if a thickness varies
    thicknesses: tuple[float, ...]
    # (nodes, 6) whether each displacement and rotation is held
    held: Booleans
    # keywords that make nodes follow others
    constraints: tuple[str, ...] = ()
    # surface of elements -> its faces
    surfaces: Mapping[str, Faces] = field(default_factory=dict)

    def _answer(self) -> Mapping[str, object]:
        return {
            "nodes": len(self.numbers),
            "sets": sorted(self.sets),
            "elements": sorted({block.kind for block in self.elements}),
        }

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Rows of `points` of the nodes of a set; or given rows, after a check that they differ.

        Raises
        ------
        ModelError
            The deck has no such node set, or it is empty; numbers that are no rows of `points`.
        """
        if isinstance(where, str):
            if not len(self.sets.get(where.upper(), ())):
                names = sorted({*self.sets, *self.surfaces})
                raise ModelError(
                    f"node set {where!r}: unknown, or it has no nodes; this deck names {names}"
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
        """Thickness of the plane elements; 1 if no section gives one, as in CalculiX and Abaqus.

        Raises
        ------
        ModelError
            Sections of several thicknesses, or a section whose thickness varies.
        """
        if not self.thicknesses:
            return 1.0
        if len(self.thicknesses) > 1 or not 0 < self.thicknesses[0] < np.inf:
            values = ", ".join(f"{value:g}" for value in self.thicknesses)
            raise ModelError(
                f"deck: sections of thickness {values}; give all plane elements one thickness"
            )
        return self.thicknesses[0]

    @property
    def faces(self) -> list[tuple[Integers, Integers]]:
        """Numbers (m,) and nodes (m, k) of elements that only serve to name faces, block by block.

        In the plane these elements are lines (here without midside nodes); in space they are plane
        elements.
        """
        in_space = self._in_space
        kinds = PLANES if in_space else LINES
        return [
            (block.numbers, block.nodes if in_space else block.nodes[:, [0, -1]])
            for block in self.elements
            if block.kind.startswith(kinds)
        ]

    @property
    def midsides(self) -> Integers:
        """Rows of the midside nodes of quadratic elements."""
        rows = [np.zeros(0, dtype=np.intp)]
        for block in self.elements:
            corners = CORNERS.get(str(shape_of(block.kind)))
            if corners is not None:
                rows.append(block.nodes[:, corners:].ravel())
        return np.unique(np.concatenate(rows))

    @property
    def corners(self) -> Integers:
        """Rows of all nodes that are not midside nodes."""
        return np.setdiff1d(np.arange(len(self.numbers)), self.midsides)

    @property
    def unclear(self) -> list[Elements]:
        """Elements that may have midside nodes, but it is unknown which nodes these are."""
        return [
            block
            for block in self.elements
            if shape_of(block.kind) is None and block.nodes.shape[1] > 4
        ]

    @property
    def _in_space(self) -> bool:
        return any(block.kind.startswith(SOLIDS) for block in self.elements)

    @property
    def _with_faces(self) -> list[Elements]:
        left_out = (*FACELESS, *PLANES) if self._in_space else FACELESS
        return [block for block in self.elements if not block.kind.startswith(left_out)]

    @property
    def without_faces(self) -> list[Elements]:
        """Elements that may have faces, but whose faces are not known."""
        return [block for block in self._with_faces if shape_of(block.kind) is None]

    def with_known_shapes(self) -> Deck:
        """The deck without elements whose faces are not known, if it also has other elements."""
        return self._without({block.kind for block in self.without_faces})

    def without_thin(self) -> Deck:
        """The deck without beams, shells and rigid surfaces, if other elements have faces."""
        kinds = {block.kind for block in self.elements}
        return self._without({kind for kind in kinds if kind.startswith(THIN)})

    def _without(self, kinds: Container[str]) -> Deck:
        """The deck without elements of some types, if other elements have faces."""
        if all(block.kind in kinds for block in self._with_faces):
            return self
        others = tuple(block for block in self.elements if block.kind not in kinds)
        return replace(self, elements=others)

    @property
    def is_linear(self) -> bool:
        """Whether all nodes of the elements with faces are corners."""
        return all(is_linear(block.kind) for block in self.by_shape())

    @property
    def is_axisymmetric(self) -> bool:
        """Whether the elements are axisymmetric.

        Raises
        ------
        ModelError
            There are plane elements, too: their forces are per depth. Or a node of an axisymmetric
            element has a negative radius.
        """
        kinds = sorted({block.kind for block in self.elements if block.kind.startswith(PLANES)})
        axisymmetric = [kind for kind in kinds if kind.startswith("CAX")]
        if not axisymmetric or self._in_space:
            return False
        if axisymmetric != kinds:
            raise ModelError(
                f"deck: elements {', '.join(kinds)}; give plane elements or axisymmetric ones (CAX)"
            )
        self._check_radii()
        return True

    def _check_radii(self) -> None:
        """Check that x, the radius of axisymmetric elements, is not negative beyond rounding."""
        rows = np.concatenate(
            [block.nodes.ravel() for block in self.elements if block.kind.startswith("CAX")]
        )
        radii = self.points[rows, 0]
        least = int(radii.argmin())
        if radii[least] < -SAME_POINT * np.abs(radii).max():
            raise ModelError(
                f"deck: x = {radii[least]:g} at node {self.numbers[rows[least]]} of an "
                "axisymmetric element; x is its radius, >= 0: measure x from the axis, and model "
                "only the half with x > 0"
            )

    def by_shape(self) -> list[Elements]:
        """All elements with faces, shape by shape: the shape's name in meshio, numbers and nodes.

        If there are solids, plane elements only serve to name faces, and are left out.

        Raises
        ------
        ModelError
            No elements, or elements that are not triangles, quadrilaterals, tetrahedra, pyramids,
            wedges or hexahedra, linear or quadratic.
        """
        solids = self._with_faces
        unknown = sorted({block.kind for block in self.without_faces})
        if unknown:
            raise ModelError(
                f"deck: elements of type {', '.join(unknown)}; give solids, {', '.join(SHAPES)} "
                "(gmsh: Mesh.SecondOrderIncomplete = 1), or read the matrix of the code, which "
                "includes all elements"
            )
        if not solids:
            raise ModelError("deck: no elements; give plane or solid elements")
        parts: dict[str, list[Elements]] = {}
        for block in solids:
            parts.setdefault(str(shape_of(block.kind)), []).append(block)
        return [
            Elements(
                shape,
                np.concatenate([block.numbers for block in parts[shape]]),
                np.concatenate([block.nodes for block in parts[shape]]),
            )
            for shape in sorted(parts)
        ]
