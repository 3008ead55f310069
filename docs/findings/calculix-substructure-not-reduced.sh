#!/usr/bin/env bash
# CalculiX does not reduce the matrix of a substructure: it holds all displacements that are not
# retained.
#
# Guess: the matrix of `*SUBSTRUCTURE GENERATE` is the stiffness for forces on the retained
# displacements, with no forces elsewhere (static condensation).
# Seen: it has the rows and columns of the whole matrix at the retained displacements. That is the
# stiffness if all other displacements are held at zero, and it is too stiff.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2), numpy 2.1.3;
# 2026-11-28.
# Output: "rows of the whole matrix: 0.000", "condensed matrix: 0.444", the largest differences
# relative to the largest entry; then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix
packages numpy==2.1.3

# A cube of one brick, held at its lower face.
cube() {
  cat <<DECK
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*MATERIAL, NAME=M
*ELASTIC
1000., 0.3
*DENSITY
1.
*SOLID SECTION, ELSET=E, MATERIAL=M
*BOUNDARY
1, 1, 3
2, 1, 3
3, 1, 3
4, 1, 3
DECK
}

{
  cube
  printf '%s\n' '*STEP' '*FREQUENCY, SOLVER=MATRIXSTORAGE' '1' '*END STEP'
} > whole.inp
# Nodes 5 and 6 are retained; nodes 7 and 8 are free.
{
  cube
  printf '%s\n' '*STEP' '*SUBSTRUCTURE GENERATE' '*RETAINED NODAL DOFS' '5, 1, 3' '6, 1, 3' \
    '*SUBSTRUCTURE MATRIX OUTPUT, FILE NAME=part, STIFFNESS=YES' '*END STEP'
} > part.inp
for job in whole part; do
  ccx "$job"
done

venv/bin/python - <<'PYTHON'
from pathlib import Path

import numpy as np

labels = Path("whole.dof").read_text().split()
K = np.zeros((len(labels), len(labels)))
for line in Path("whole.sti").read_text().splitlines():
    row, column, value = line.split()
    K[int(row) - 1, int(column) - 1] = float(value)
    K[int(column) - 1, int(row) - 1] = float(value)
kept = [labels.index(f"{node}.{direction}") for node in (5, 6) for direction in (1, 2, 3)]
other = [row for row in range(len(labels)) if row not in kept]
block = K[np.ix_(kept, kept)]
across = K[np.ix_(kept, other)]
condensed = block - across @ np.linalg.solve(K[np.ix_(other, other)], across.T)

written = Path("part.mtx").read_text().split("*MATRIX,TYPE=STIFFNESS")[1]
values = np.array([float(word) for word in written.replace(",", " ").split()])
lower = np.tril_indices(len(kept))
size = np.abs(block).max()
from_block = np.abs(values - block[lower]).max() / size
from_condensed = np.abs(values - condensed[lower]).max() / size
print(f"rows of the whole matrix: {from_block:.3f}")
print(f"condensed matrix: {from_condensed:.3f}")
raise SystemExit(0 if from_block < 1e-9 and from_condensed > 0.1 else 1)
PYTHON
echo "as described"
