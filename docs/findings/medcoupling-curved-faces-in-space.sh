#!/usr/bin/env bash
# MEDCoupling measures a quadratic face with curved edges in the plane, with straight ones in space.
#
# Guess: `getMeasureField` gives the same area for a face in the plane and for the same face in
# space, and the volume of a solid with that face and height 1 is the same number.
# Seen: in the plane the edges of quadratic cells are arcs of circles, so a quarter of a disc of
# three edges has its exact area. The same face with a third coordinate, and solids, are measured by
# their corners: the area is the area of the triangle. So areas of contact faces, and forces and
# mean pressures from them, change as a face is cut out of a solid and projected. Nothing warns of
# it.
# Versions: medcoupling 9.15.0, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: for a quarter of a disc of radius 1 the area of `TRI6` in the plane and in space, and the
# volume of `PENTA15` of height 1: "plane 0.785, space 0.500, solid 0.500", then "as described". By
# hand all are 0.785 for arcs, and 0.776 for the parabolas of finite elements.
. "$(dirname "$0")/common.sh"
packages medcoupling==9.15.0 numpy==2.3.5 2> /dev/null

cat > "$folder/measure.py" <<'PYTHON'
import medcoupling as mc
import numpy as np


def measure(cell, dimension, points):
    """Area or volume of one cell."""
    mesh = mc.MEDCouplingUMesh("body", dimension)
    mesh.setCoords(mc.DataArrayDouble(points.ravel().tolist(), *points.shape))
    mesh.allocateCells(1)
    mesh.insertNextCell(cell, list(range(len(points))))
    mesh.finishInsertingCells()
    return abs(mesh.getMeasureField(True).getArray().getValues()[0])


half = np.sqrt(0.5)
plane = np.array([(0, 0), (1, 0), (0, 1), (0.5, 0), (half, half), (0, 0.5)])
space = np.column_stack([plane, np.zeros(6)])
corners, middle = space[:3], space[3:]
up = np.array([0, 0, 1])
solid = np.vstack([corners, corners + up, middle, middle + up, corners + up / 2])
seen = {
    "plane": measure(mc.NORM_TRI6, 2, plane),
    "space": measure(mc.NORM_TRI6, 2, space),
    "solid": measure(mc.NORM_PENTA15, 3, solid),
}
print(", ".join(f"{name} {value:.3f}" for name, value in seen.items()))
PYTHON

"$folder/venv/bin/python" "$folder/measure.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
plane 0.785, space 0.500, solid 0.500
OUTPUT
echo "as described"
