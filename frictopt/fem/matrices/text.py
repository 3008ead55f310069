"""Text files of other codes: the blocks of a deck, and the types of elements as CalculiX and Abaqus, or meshio, call them."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias

from ...errors import ModelError

Block: TypeAlias = tuple[str, dict[str, str], list[str]]  # keyword and names of parameters without blanks, data lines
FLAT = "write a flat deck, all where it is (Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"

_PLANES = ("CPE", "CPS", "CAX")
PLANES = (*_PLANES, "triangle", "quad")  # beside solids they only name faces: gmsh writes named surfaces as CPS
_FLAT = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}  # shapes as meshio names them, by number of nodes
SHAPES = {"C3D4": "tetra", "C3D8": "hexahedron", "C3D10": "tetra10", "C3D20": "hexahedron20"}
SHAPES |= {f"{kind}{n}": shape for kind in _PLANES for n, shape in _FLAT.items()}
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


def text_of(path: Path, what: str) -> str:
    """Text of a file, without a byte-order mark."""
    try:
        return path.read_text(encoding="utf-8-sig", errors="replace")
    except (OSError, ValueError) as error:
        raise ModelError(f"{what}: {str(path)!r} cannot be read ({error}); give the path of a file") from error


def blocks(path: Path) -> Iterator[Block]:
    """The blocks of a deck and of the files that it includes, in order; all in capitals, but for data lines."""
    lines = list(_lines(path))
    starts = [i for i, line in enumerate(lines) if line.startswith("*")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        head, first = lines[start][1:], start + 1
        while head.endswith(",") and first < end and _continues(lines[first]):
            head, first = head + lines[first], first + 1
        keyword, *rest = (part.strip() for part in head.split(","))
        pairs = [(_joined(name), value.strip().strip('"')) for name, _, value in (part.partition("=") for part in rest if part)]
        yield _joined(keyword), {name: value.upper() for name, value in pairs}, lines[first:end]


def _lines(path: Path, depth: int = 0) -> Iterator[str]:
    """The lines of a deck that are no comments, those of a file that it includes in the place of *INCLUDE: it may go on with the block before."""
    if depth > 20:
        raise ModelError(f"deck {path.name}: it includes itself; take the *INCLUDE out")
    lines = (line for line in map(str.strip, text_of(path, "deck").splitlines()) if line and not line.startswith("**"))
    for line in lines:
        if _joined(line.split(",")[0]) == "*INCLUDE":
            given = (line if "=" in line else next(lines, "")).split(",")
            files = [file.strip(' "') for name, _, file in (part.partition("=") for part in given) if _joined(name) == "INPUT"]
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
