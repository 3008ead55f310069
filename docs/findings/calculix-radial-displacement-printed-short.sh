#!/usr/bin/env bash
# CalculiX prints radial displacements of axisymmetric elements times cos(1 degree).
#
# Guess: the displacements of a static step solve the equations with the matrix that CalculiX
# stores, to all printed digits, with forces divided by 180.
# Seen: axial displacements do so. Radial displacements are the solution times cos(1 degree) =
# 0.999848: CalculiX expands a ring to a slice of 2 degrees, and prints displacements of its middle
# plane.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2), numpy 2.1.3;
# 2026-11-28.
# Output: for each displacement the printed value over the solution: "radial 0.9998..." or "axial
# 1.0000..."; then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix
packages numpy==2.1.3

# A ring of radii 1 to 2 and height 1, held along the axis at one node. E = 1000, nu = 0.
ring() {
  cat <<DECK
*NODE, NSET=ALL
1, 1., 0.
2, 2., 0.
3, 2., 1.
4, 1., 1.
*ELEMENT, TYPE=CAX4, ELSET=E
1, 1, 2, 3, 4
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*DENSITY
1.
*SOLID SECTION, ELSET=E, MATERIAL=M
*BOUNDARY
1, 2, 2
DECK
}

{
  ring
  printf '%s\n' '*STEP' '*FREQUENCY, SOLVER=MATRIXSTORAGE' '1' '*END STEP'
} > matrix.inp
{
  ring
  printf '%s\n' '*STEP' '*STATIC' '*CLOAD' '2, 1, 180.' '3, 2, 50.' \
    '*NODE PRINT, NSET=ALL' 'U' '*END STEP'
} > static.inp
for job in matrix static; do
  ccx "$job"
done

venv/bin/python - <<'PYTHON'
from pathlib import Path

import numpy as np

labels = [tuple(map(int, line.split("."))) for line in Path("matrix.dof").read_text().split()]
K = np.zeros((len(labels), len(labels)))
for line in Path("matrix.sti").read_text().splitlines():
    row, column, value = line.split()
    K[int(row) - 1, int(column) - 1] = float(value)
    K[int(column) - 1, int(row) - 1] = float(value)
forces = {(2, 1): 180.0 / 180.0, (3, 2): 50.0 / 180.0}
u = np.linalg.solve(K, [forces.get(label, 0.0) for label in labels])

words = [line.split() for line in Path("static.dat").read_text().splitlines()]
printed = {int(row[0]): row[1:] for row in words if len(row) == 4 and row[0].isdigit()}
as_described = True
for (node, direction), value in zip(labels, u):
    ratio = float(printed[node][direction - 1]) / value
    print("radial" if direction == 1 else "axial", f"{ratio:.6f}")
    expected = np.cos(np.radians(1.0)) if direction == 1 else 1.0
    as_described &= abs(ratio - expected) < 1e-6
raise SystemExit(0 if as_described else 1)
PYTHON
echo "as described"
