#!/usr/bin/env bash
# meshio reads solid elements of Salome's MED files inside out: their volumes are negative.
#
# Guess: a hexahedron that Salome calls well oriented has a positive Jacobian in meshio's order.
# Seen: MED numbers the base of a solid the other way round than meshio, VTK and Abaqus, and
# meshio copies the numbers. Volumes come out negative, and normals that follow the order point
# inwards. The other way, a brick that meshio writes is inside out for Salome's library.
# Versions: medcoupling 9.15.0 (Salome's library of meshes), meshio 5.3.5, h5py 3.16.0,
# numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: volumes of a unit cube: "hexahedron: Salome 1.0, meshio -1.0", "tetra: Salome 1.0,
# meshio -1.0", "written by meshio: Salome -1.0", then "as described".
. "$(dirname "$0")/common.sh"
packages medcoupling==9.15.0 meshio==5.3.5 h5py==3.16.0 numpy==2.3.5
cd "$folder"

cat > volumes.py <<'PYTHON'
import medcoupling
import meshio
import numpy as np

places = medcoupling.DataArrayDouble([0.0, 1.0])
grid = medcoupling.MEDCouplingCMesh("cube")
grid.setCoords(places, places, places)
cube = grid.buildUnstructured()
pieces = cube.deepCopy()
pieces.simplexize(medcoupling.PLANAR_FACE_5)
axes = {"hexahedron": [1, 3, 4], "tetra": [1, 2, 3]}  # neighbours of a cell's first node
parts = {"hexahedron": 1, "tetra": 6}
for kind, mesh in (("hexahedron", cube), ("tetra", pieces)):
    salome = sum(mesh.getMeasureField(False).getArray().getValues())
    medcoupling.WriteUMesh(f"{kind}.med", mesh, True)
    read = meshio.read(f"{kind}.med")
    corners = read.points[read.cells_dict[kind]]
    edges = corners[:, axes[kind]] - corners[:, :1]
    print(f"{kind}: Salome {salome:.1f}, meshio {np.linalg.det(edges).sum() / parts[kind]:.1f}")

square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
points = np.vstack([np.column_stack([square, np.full(4, z)]) for z in (0.0, 1.0)])
meshio.write("written.med", meshio.Mesh(points, [("hexahedron", [list(range(8))])]))
mesh = medcoupling.ReadMeshFromFile("written.med")
print(f"written by meshio: Salome {mesh.getMeasureField(False).getArray()[0]:.1f}")
PYTHON

venv/bin/python -W ignore volumes.py | tee seen
diff - seen <<'OUTPUT'
hexahedron: Salome 1.0, meshio -1.0
tetra: Salome 1.0, meshio -1.0
written by meshio: Salome -1.0
OUTPUT
echo "as described"
