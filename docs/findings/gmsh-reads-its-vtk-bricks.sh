#!/usr/bin/env bash
# gmsh reads quadratic bricks and prisms of VTK files with their middle nodes mixed up.
#
# Guess: gmsh reads the mesh that it wrote to a legacy VTK file as the same mesh.
# Seen: it writes the middle nodes of 20-node bricks and 15-node prisms in VTK's order, and takes
# them in its own order when it reads. The elements turn inside out in part, and a brick of volume 3
# has another volume. Each VTK file of such elements is affected. Tetrahedra are read rightly, and so
# is the same brick from CGNS, UNV and Nastran decks. There is no warning.
# Versions: gmsh 4.15.2 (with libglu1-mesa and others of Debian 12), numpy 2.3.5, Python 3.11;
# 2026-11-28.
# Output: volumes after writing and reading: "hexahedra: bdf 3.00, vtk -0.90", "prisms: bdf 3.00,
# vtk 2.03", "tetrahedra: bdf 3.00, vtk 3.00", then "as described".
. "$(dirname "$0")/common.sh"
packages gmsh==4.15.2 numpy==2.3.5
cd "$folder"

cat > bricks.py <<'PYTHON'
import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)


def block(quadrilaterals, layers):
    """A block of 1 x 1 x 3 of quadratic elements, one element along each edge."""
    gmsh.clear()
    parts = [(0, gmsh.model.geo.addPoint(0, 0, 0))]
    for axis, recombine in ((0, True), (1, quadrilaterals), (2, layers)):
        step = [0, 0, 0]
        step[axis] = (1, 1, 3)[axis]
        made = gmsh.model.geo.extrude(parts, *step, numElements=[1], recombine=recombine)
        parts = [part for part in made if part[0] == axis + 1]
    gmsh.model.geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [parts[0][1]], 1)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)


def volume():
    total = 0.0
    for kind in gmsh.model.mesh.getElementTypes(3):
        points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss4")
        determinants = gmsh.model.mesh.getJacobians(kind, points)[1]
        total += (np.reshape(determinants, (-1, len(weights))) * weights).sum()
    return total


for name, quadrilaterals, layers in (
    ("hexahedra", True, True),
    ("prisms", False, True),
    ("tetrahedra", False, False),
):
    seen = []
    for ending in ("bdf", "vtk"):
        block(quadrilaterals, layers)
        gmsh.write(f"{name}.{ending}")
        gmsh.clear()
        gmsh.merge(f"{name}.{ending}")
        seen.append(f"{ending} {volume():.2f}")
    print(f"{name}:", ", ".join(seen))
PYTHON

venv/bin/python bricks.py | tee seen
diff - seen <<'OUTPUT'
hexahedra: bdf 3.00, vtk -0.90
prisms: bdf 3.00, vtk 2.03
tetrahedra: bdf 3.00, vtk 3.00
OUTPUT
echo "as described"
