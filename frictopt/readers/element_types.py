"""Types of elements, by their names in Abaqus and CalculiX ("C3D8") or in meshio ("hexahedron")."""

import re

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
# Beside solids, plane elements only name faces: gmsh writes named surfaces as CPS.
PLANES = ("CPE", "CPS", "CAX", "triangle", "quad")
# In the plane, lines name boundaries: gmsh writes named curves so. Their ends come first and last.
LINES = ("T2D2", "T3D2", "T2D3", "T3D3", "line")
# Beams, shells, membranes, and rigid lines and surfaces.
THIN = (
    *("B2", "B3", "PIPE", "S3", "S4", "S6", "S8", "S9", "STRI", "M3D", "SFM", "F3D"),
    *("R2D", "R3D", "RAX", "RB2D", "RB3D"),
)
# They may lie on a face of a solid, but they hide none. Continuum shells (SC) have a volume.
SLENDER = (*THIN, "SC")
# These elements carry no traction.
FACELESS = (*LINES, "vertex", "SPRING", "MASS", "ROTARYI", "DASHPOT", "DCOUP", "GAP", "CONN")

# Solids all nodes of which are corners.
_LINEAR_SOLIDS = ("C3D4", "C3D5", "C3D6", "C3D8")
# A letter may follow that changes the formulation: C3D8R, C3D8I.
_WITH_NODE_COUNT = re.compile(r"(C3D|CPE|CPS|CAX|T2D|T3D)(\d+)")


def shape_of(kind: str) -> str | None:
    """The shape of a type of elements whose faces are known, by its name in meshio; else None."""
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


def may_have_midsides(kind: str, nodes: int) -> bool:
    """Whether nodes may lie amid edges of an element, though it is not known which."""
    match = _WITH_NODE_COUNT.match(kind)
    is_linear = nodes <= 4 or (match is not None and match.group() in _LINEAR_SOLIDS)
    return shape_of(kind) is None and not is_linear
