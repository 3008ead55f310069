#!/usr/bin/env bash
# gmsh writes the nodes of quadratic pyramids to Nastran in its own order: middles change edges.
#
# Guess: `write("mesh.bdf")` orders the nodes of all solids as Nastran numbers them.
# Seen: it does for CHEXA, CPENTA and CTETRA. The middle nodes of CPYRAM keep the order of gmsh:
# Nastran has the four nodes of the base edges first, and gmsh mixes them with the nodes of the
# other edges. So 5 of the 8 middle nodes lie on another edge than Nastran reads.
# Versions: gmsh 4.15.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: middles that are not in the middle of the edge of their place, "CHEXA: 0 of 12", "CPENTA:
# 0 of 9", "CTETRA: 0 of 6", "CPYRAM: 5 of 8", then "as described".
. "$(dirname "$0")/common.sh"
packages gmsh==4.15.2 numpy==2.3.5
cd "$folder"

cat > orders.py <<'PYTHON'
from pathlib import Path

import gmsh
import numpy as np

square, triangle = [(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 0), (2, 0), (0, 1)]


def at(places, height):
    return [(x, y, height) for x, y in places]


def ring(count, first=0):
    return [(first + k, first + (k + 1) % count) for k in range(count)]


def up(count):
    return [(k, k + count) for k in range(count)]


# Corners, and the edges whose middles follow the corners on a card of Nastran.
solids = {
    "CHEXA": ("Hexahedron", at(square, 0) + at(square, 3), ring(4) + up(4) + ring(4, 4)),
    "CPENTA": ("Prism", at(triangle, 0) + at(triangle, 3), ring(3) + up(3) + ring(3, 3)),
    "CTETRA": ("Tetrahedron", at(triangle, 0) + [(0, 0, 3)], ring(3) + [(k, 3) for k in range(3)]),
    "CPYRAM": ("Pyramid", at(square, 0) + [(1, 0.5, 3)], ring(4) + [(k, 4) for k in range(4)]),
}
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
gmsh.option.setNumber("Mesh.BdfFieldFormat", 0)
for card, (shape, corners, edges) in solids.items():
    gmsh.model.add(card)
    body = gmsh.model.addDiscreteEntity(3)
    numbers = list(range(1, len(corners) + 1))
    gmsh.model.mesh.addNodes(3, body, numbers, np.ravel(corners).astype(float))
    kind = gmsh.model.mesh.getElementType(shape, 1)
    gmsh.model.mesh.addElementsByType(body, kind, [1], numbers)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.addPhysicalGroup(3, [body], 1)
    gmsh.write("mesh.bdf")
    places, fields = {}, []
    for line in Path("mesh.bdf").read_text().splitlines():
        row = [word.strip() for word in line.split(",")]
        if row[0] == "GRID":
            places[int(row[1])] = np.array(row[3:6], dtype=float)
        elif row[0] == card or row[0].startswith("+"):
            fields += [word for word in row if word.isdigit()]
    nodes = [places[int(word)] for word in fields[2:]]  # behind the numbers of element and property
    middles = nodes[len(corners) :]
    wrong = 0
    for middle, (a, b) in zip(middles, edges, strict=True):
        wrong += bool(abs(middle - (nodes[a] + nodes[b]) / 2).max() > 1e-9)
    print(f"{card}: {wrong} of {len(edges)}")
gmsh.finalize()
PYTHON

venv/bin/python orders.py | tee seen
diff - seen <<'OUTPUT'
CHEXA: 0 of 12
CPENTA: 0 of 9
CTETRA: 0 of 6
CPYRAM: 5 of 8
OUTPUT
echo "as described"
