#!/usr/bin/env bash
# meshio changes the type of elements when it writes a deck of Abaqus: CPS4 becomes CAX4P.
#
# Guess: `read` and `write` keep the types of a deck, or write the plain type of each shape.
# Seen: plane stress quadrilaterals become axisymmetric ones with pore pressure, triangles become
# rigid, bricks become reduced and hybrid, and a `vtu` with quadrilaterals gives the same CAX4P.
# There is no warning. Abaqus has all these types; CalculiX does not know `C3D8RH`, `CAX4P`, `R3D3`
# and `C3D10MH`, and stops.
# Versions: meshio 5.3.5, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: a line for each type, "CPS4 -> CAX4P" and so on, then "as described".
. "$(dirname "$0")/common.sh"
packages meshio==5.3.5 numpy==2.3.5
cd "$folder"

cat > kinds.py <<'PYTHON'
import re
from pathlib import Path

import meshio
import numpy as np

square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
cube = square + [(x, y, 1) for x, y, _ in square]
tetrahedron = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
middles = [(0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0), (0, 0, 0.5), (0.5, 0, 0.5), (0, 0.5, 0.5)]
nodes = {
    "CPS3": square[:3],
    "CPS4": square,
    "S4": square,
    "C3D8": cube,
    "C3D4": tetrahedron,
    "C3D10": tetrahedron + middles,
}
for kind, places in nodes.items():
    lines = ["*NODE"]
    lines += [f"{number}, {x}, {y}, {z}" for number, (x, y, z) in enumerate(places, 1)]
    lines += [f"*ELEMENT, TYPE={kind}", "1, " + ", ".join(map(str, range(1, len(places) + 1)))]
    Path("given.inp").write_text("\n".join(lines) + "\n")
    meshio.write("written.inp", meshio.read("given.inp"))
    written = re.search(r"\*ELEMENT, TYPE=(\w+)", Path("written.inp").read_text())
    print(kind, "->", written[1])
meshio.write("square.vtu", meshio.Mesh(np.array(square, float), [("quad", [[0, 1, 2, 3]])]))
meshio.write("written.inp", meshio.read("square.vtu"))
print("vtu ->", re.search(r"\*ELEMENT, TYPE=(\w+)", Path("written.inp").read_text())[1])
PYTHON

venv/bin/python -W ignore kinds.py | tee seen
diff - seen <<'OUTPUT'
CPS3 -> R3D3
CPS4 -> CAX4P
S4 -> CAX4P
C3D8 -> C3D8RH
C3D4 -> C3D4
C3D10 -> C3D10MH
vtu -> CAX4P
OUTPUT
echo "as described"
