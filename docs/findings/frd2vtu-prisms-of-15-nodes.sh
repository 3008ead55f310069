#!/usr/bin/env bash
# frd2vtu mixes up the middle nodes of 15-node prisms of CalculiX, so that they have a wrong volume.
#
# Guess: frd2vtu has put the nodes of `C3D15` in VTK's order, as it does for `C3D20`.
# Seen: CalculiX's file and VTK order the middle nodes of prisms differently: in the file, the nodes
# along the height come before the nodes of the top. frd2vtu keeps the order of the file. So the
# prism folds: half a unit cube has a twelfth of its volume, and integrals, samples and gradients of
# results are wrong. Faces look right as long as only the corners are drawn. pyvista-frd-reader
# reads the prism right.
# Versions: frd2vtu 0.2.1, pyvista 0.49.1, vtk 9.7.2, pandas 2.3.3, numpy 2.3.5, Python 3.11, and
# CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: volumes that frd2vtu and VTK give for a cube of side 1 of type `C3D20`, "C3D20 1.000", and
# for half of it of type `C3D15`, "C3D15 0.042", then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix
packages frd2vtu==0.2.1 pyvista==0.49.1 vtk==9.7.2 pandas==2.3.3 numpy==2.3.5

cat > solids.py <<'PYTHON'
import os
import subprocess

import numpy as np
from frd2vtu import frdbin2vtu

SHAPES = {"C3D15": [(0, 0), (1, 0), (0, 1)], "C3D20": [(0, 0), (1, 0), (1, 1), (0, 1)]}
for kind in ("C3D20", "C3D15"):
    outline = SHAPES[kind]
    n = len(outline)
    corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline])
    # The middle nodes in the order of decks: below, above, and along the height.
    ring = [(i, (i + 1) % n) for i in range(n)]
    ends = ring + [(i + n, j + n) for i, j in ring] + [(i, i + n) for i in range(n)]
    points = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in ends]])
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i}, {x:g}, {y:g}, {z:g}" for i, (x, y, z) in enumerate(points, 1)]
    numbers = [str(i) for i in range(1, len(points) + 1)]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=SOLID", "1, " + ", ".join(numbers[:10]) + ","]
    lines += [", ".join(numbers[10:]), "*MATERIAL, NAME=M", "*ELASTIC", "1000., 0."]
    lines += ["*SOLID SECTION, ELSET=SOLID, MATERIAL=M", "*BOUNDARY", "ALL, 1, 2", "1, 3", "2, 3"]
    lines += ["3, 3", "*STEP", "*STATIC", "*CLOAD", f"{n + 1}, 3, 1.", "*NODE OUTPUT", "U"]
    with open(f"{kind}.inp", "w") as deck:
        deck.write("\n".join([*lines, "*END STEP", ""]))
    with open(f"{kind}.log", "w") as log:
        environment = {**os.environ, "LD_LIBRARY_PATH": os.environ["CCX_LIBRARIES"]}
        subprocess.run(["root/usr/bin/ccx", kind], check=True, stdout=log, env=environment)
    grid = frdbin2vtu(f"{kind}.frd")
    print(kind, f"{grid.compute_cell_sizes()['Volume'][0]:.3f}")
PYTHON

CCX_LIBRARIES="$libraries" venv/bin/python solids.py | tee seen
diff - seen <<'OUTPUT'
C3D20 1.000
C3D15 0.042
OUTPUT
echo "as described"
