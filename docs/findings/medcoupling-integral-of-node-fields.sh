#!/usr/bin/env bash
# MEDCoupling integrates a field on nodes as if each node had the same share of the cell.
#
# Guess: `integral` of a field on nodes integrates the shape functions of the cells, so that a
# nodal pressure gives its force, whether the faces are triangles or quadrilaterals, linear or
# quadratic.
# Seen: it adds up the nodal values, each times the area of the cell over the number of its nodes.
# That is exact for linear triangles and tetrahedra. A linear pressure on a quadrilateral that is
# no parallelogram is wrong, and a quadratic pressure on quadratic faces has 1.3 or 1.5 of its
# force. The averages of `getWeightedAverageValue` have the same weights. The documentation of
# `integral` in Python names the arguments only. `ON_NODES_FE`, which is named after finite
# elements, does not help: it raises an error. Integrate results of Code_Aster and Salome at Gauss
# points instead.
# Versions: medcoupling 9.15.0, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: force of a nodal pressure, and that by hand, for the pressure x on a triangle and on a
# trapezoid, and for the pressure x^2 on a 6-node triangle and an 8-node square, all with straight
# edges: "0.167 of 0.167", "2.000 of 2.167", "0.125 of 0.083", "0.438 of 0.333", then "as
# described".
. "$(dirname "$0")/common.sh"
packages medcoupling==9.15.0 numpy==2.3.5 2> /dev/null

cat > "$folder/force.py" <<'PYTHON'
import medcoupling as mc
import numpy as np


def force(cell, outline, power):
    """Integral of a power of x, given at the nodes of one cell with straight edges."""
    points = np.array(outline, dtype=float)
    if cell in (mc.NORM_TRI6, mc.NORM_QUAD8):
        points = np.vstack([points, (points + np.roll(points, -1, axis=0)) / 2])
    mesh = mc.MEDCouplingUMesh("face", 2)
    mesh.setCoords(mc.DataArrayDouble(points.ravel().tolist(), *points.shape))
    mesh.allocateCells(1)
    mesh.insertNextCell(cell, list(range(len(points))))
    mesh.finishInsertingCells()
    pressure = mc.MEDCouplingFieldDouble(mc.ON_NODES, mc.ONE_TIME)
    pressure.setMesh(mesh)
    pressure.setArray(mc.DataArrayDouble((points[:, 0] ** power).tolist(), len(points), 1))
    pressure.checkConsistencyLight()
    return pressure.integral(0, True)


triangle, square = [(0, 0), (1, 0), (0, 1)], [(0, 0), (1, 0), (1, 1), (0, 1)]
trapezoid = [(0, 0), (3, 0), (1, 1), (0, 1)]
for cell, outline, power, exact in (
    ("TRI3", triangle, 1, 1 / 6),
    ("QUAD4", trapezoid, 1, 13 / 6),
    ("TRI6", triangle, 2, 1 / 12),
    ("QUAD8", square, 2, 1 / 3),
):
    seen = force(getattr(mc, f"NORM_{cell}"), outline, power)
    print(f"{cell}: {seen + 1e-9:.3f} of {exact:.3f}")
PYTHON

"$folder/venv/bin/python" "$folder/force.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
TRI3: 0.167 of 0.167
QUAD4: 2.000 of 2.167
TRI6: 0.125 of 0.083
QUAD8: 0.438 of 0.333
OUTPUT
echo "as described"
