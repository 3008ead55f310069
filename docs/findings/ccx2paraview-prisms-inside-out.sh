#!/usr/bin/env bash
# ccx2paraview's prisms are inside out for VTK 9.7, and `C3D15` prisms lose their middle nodes.
#
# Guess: solid elements of an frd file keep their volume and their nodes in the vtu file, and the
# volume in a vtu file does not depend on the version of VTK.
# Seen: VTK 9.7 reversed the triangles of its prism, which contradicted its shape functions (its
# release notes call it a correction). The same file has a positive volume in VTK 9.5 and a negative
# one in 9.7, and integrals over bricks and prisms together then subtract the prisms. ccx2paraview
# reverses the prisms of CalculiX for the old order. It also makes prisms of six nodes of `C3D15`
# (the source says so, the manual does not). Bricks and tetrahedra keep volume and nodes. No
# message.
# Versions: ccx2paraview 3.2.0, pyvista 0.49.1, vtk 9.5.2 and 9.7.2, numpy 2.3.5, Python 3.11,
# CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: volume in VTK, and number of nodes of a cell, of elements with edges of length 1 along the
# axes: "C3D6, 6 nodes: -0.5 in VTK 9.7" and "C3D6, 6 nodes: 0.5 in VTK 9.5", the same for "C3D15, 6
# nodes", and twice "C3D10, 10 nodes: 0.2", then "as described".
. "$(dirname "$0")/common.sh"
packages ccx2paraview==3.2.0 pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5
cd "$folder"
calculix

# One element. Arguments: its type, and the numbers of its nodes.
solid() {
  cat <<DECK
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
5, 1., 0., 1.
6, 0., 1., 1.
7, .5, 0., 0.
8, .5, .5, 0.
9, 0., .5, 0.
10, .5, 0., 1.
11, .5, .5, 1.
12, 0., .5, 1.
13, 0., 0., .5
14, 1., 0., .5
15, 0., 1., .5
16, .5, 0., .5
17, 0., .5, .5
*ELEMENT, TYPE=$1, ELSET=SOLID
1, $2
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*SOLID SECTION, ELSET=SOLID, MATERIAL=M
*BOUNDARY
ALL, 1, 2
1, 3
*STEP
*STATIC
*CLOAD
2, 3, 1.
*NODE FILE
U
*END STEP
DECK
}

solid C3D6 '1, 2, 3, 4, 5, 6' > C3D6.inp
solid C3D15 '1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15' > C3D15.inp
solid C3D10 '1, 2, 3, 4, 7, 8, 9, 13, 16, 17' > C3D10.inp

cat > convert.py <<'PYTHON'
import sys

from ccx2paraview import Converter

Converter(f"{sys.argv[1]}.frd", ["vtu"]).run()
PYTHON

cat > volume.py <<'PYTHON'
import sys

import pyvista
import vtk

for name in sys.argv[1:]:
    grid = pyvista.read(f"{name}.vtu")
    volume = grid.compute_cell_sizes()["Volume"][0]
    version = vtk.vtkVersion.GetVTKVersion()[:3]
    print(f"{name}, {grid.get_cell(0).n_points} nodes: {volume:.1f} in VTK {version}")
PYTHON

types=(C3D6 C3D15 C3D10)
for name in "${types[@]}"; do
  ccx "$name"
  venv/bin/python convert.py "$name" > "$name.messages" 2>&1
done
venv/bin/python volume.py "${types[@]}" > seen
venv/bin/pip install --quiet vtk==9.5.2
venv/bin/python volume.py "${types[@]}" >> seen
cat seen
diff - seen <<'OUTPUT'
C3D6, 6 nodes: -0.5 in VTK 9.7
C3D15, 6 nodes: -0.5 in VTK 9.7
C3D10, 10 nodes: 0.2 in VTK 9.7
C3D6, 6 nodes: 0.5 in VTK 9.5
C3D15, 6 nodes: 0.5 in VTK 9.5
C3D10, 10 nodes: 0.2 in VTK 9.5
OUTPUT
echo "as described"
