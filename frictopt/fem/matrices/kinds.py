"""Types of elements as CalculiX and Abaqus, or meshio, call them: their shapes and nodes."""

import re

_PLANES = ("CPE", "CPS", "CAX")
PLANES = (*_PLANES, "triangle", "quad")  # beside solids they only name faces: gmsh writes named surfaces as CPS
_FLAT = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}  # shapes as meshio names them, by number of nodes
SHAPES = {"C3D4": "tetra", "C3D8": "hexahedron", "C3D10": "tetra10", "C3D20": "hexahedron20"} | {
    f"{kind}{n}": shape for kind in _PLANES for n, shape in _FLAT.items()
}
PLANE = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}  # shapes, as meshio names them, and their corners, which come first
SOLID = {"tetra": 4, "tetra10": 4, "hexahedron": 8, "hexahedron20": 8, "hexahedron27": 8}
SOLIDS = ("C3D", "tetra", "hexahedron")
LINES = ("T2D2", "T3D2", "T2D3", "T3D3", "line")  # gmsh writes named curves so; the ends come first and last
FACELESS = (*LINES, "vertex", "SPRING", "MASS", "ROTARYI", "DASHPOT", "DCOUP", "GAP", "CONN")  # they carry no traction
_KNOWN = re.compile(r"(C3D|CPE|CPS|CAX|T2D|T3D)(\d+)")


def shape_of(kind: str) -> str | None:
    """The shape of a type of elements with faces; None if it is none of `SHAPES`."""
    match = _KNOWN.match(kind)
    return SHAPES.get(match.group()) if match else kind if kind in PLANE | SOLID else None


def node_count(kind: str) -> int | None:
    """How many nodes an element of a type has; None if it is neither solid nor truss."""
    match = _KNOWN.match(kind)
    return int(match[2]) if match else None
