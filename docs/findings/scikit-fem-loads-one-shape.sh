#!/usr/bin/env bash
# scikit-fem loads only one shape of a mixed mesh, and leaves holes where the others were.
#
# Guess: `Mesh.load` of hexahedra and wedges raises an error, or warns about the wedges.
# Seen: it takes the first shape of the file and drops the others, without a word. The order in the
# file decides which: quadrilaterals and triangles give a mesh of either, as gmsh leaves some
# triangles when it recombines.
# Versions: scikit-fem 12.0.2, meshio 5.3.5, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: what is loaded of a square of side 1 and a triangle of area 1/2, in both orders, and of a
# cube and a wedge: "MeshQuad1, area 1.0 of 1.5", "MeshTri1, area 0.5 of 1.5", "MeshHex1, volume
# 1.0 of 1.5", then "as described". Warnings would be seen as well.
. "$(dirname "$0")/common.sh"
packages scikit-fem==12.0.2 meshio==5.3.5 numpy==2.3.5
cd "$folder"

cat > shapes.py <<'PYTHON'
import logging

import meshio
import numpy as np
import skfem

logging.basicConfig(level=logging.WARNING, format="%(message)s")
flat = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0)], dtype=float)
tall = np.vstack([np.column_stack([flat, np.full(5, z)]) for z in (0.0, 1.0)])
quad, triangle = ("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]])
cube = ("hexahedron", [[0, 1, 2, 3, 5, 6, 7, 8]])
wedge = ("wedge", [[1, 4, 2, 6, 9, 7]])
files = (
    ("area", tall[:5], [quad, triangle]),
    ("area", tall[:5], [triangle, quad]),
    ("volume", tall, [cube, wedge]),
)
for measure, points, cells in files:
    meshio.write("mixed.vtu", meshio.Mesh(points, cells))
    mesh = skfem.Mesh.load("mixed.vtu")
    size = skfem.Basis(mesh, mesh.elem()).dx.sum()
    print(f"{type(mesh).__name__}, {measure} {size:.1f} of 1.5")
PYTHON

venv/bin/python -W default::UserWarning shapes.py 2>&1 | tee seen
diff - seen <<'OUTPUT'
MeshQuad1, area 1.0 of 1.5
MeshTri1, area 0.5 of 1.5
MeshHex1, volume 1.0 of 1.5
OUTPUT
echo "as described"
