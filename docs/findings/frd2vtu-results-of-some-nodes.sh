#!/usr/bin/env bash
# frd2vtu moves results that CalculiX has for some nodes only, such as contact stresses, to others.
#
# Guess: a field of frd2vtu has a row for each node of the mesh, in its order, as CalculiX's file
# has the number of the node beside each row.
# Seen: that is so if CalculiX writes all nodes. If not, frd2vtu gives the rows to the first nodes
# of the mesh, and appends zeros. So node to surface contact, which has stresses for the slave
# nodes, presses somewhere else, and displacements of a set of nodes move to other nodes. Face to
# face contact is right. Nothing is logged. Ask CalculiX for all nodes, and for face to face
# contact, or read the file with pyvista-frd-reader.
# Versions: frd2vtu 0.2.1, pyvista 0.49.1, vtk 9.7.2, pandas 2.3.3, numpy 2.3.5, Python 3.11, and
# CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: nodes with a contact stress, for a block with the nodes 11 to 14 at its contact: "FACE: 11
# 12 13 14" and "NODE: 1 2 3 4", which are the fixed nodes of the ground. Nodes with a displacement,
# which was asked for 15 to 18: "moved: 1 2 3 4". Then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix
packages frd2vtu==0.2.1 pyvista==0.49.1 vtk==9.7.2 pandas==2.3.3 numpy==2.3.5

# A block of side 1 is pressed on a larger one and pulled along x.
blocks() {
  cat <<DECK
$(two_blocks 0. 1.)
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*SOLID SECTION, ELSET=GROUND, MATERIAL=M
*SOLID SECTION, ELSET=BLOCK, MATERIAL=M
*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1.E5
*FRICTION
0.3, 1.E5
*CONTACT PAIR, INTERACTION=I, TYPE=$1
UPPER, LOWER
*BOUNDARY
BELOW, 1, 3
*STEP, NLGEOM
*STATIC
0.25, 1.
*BOUNDARY
TOP, 1, 1, 0.02
TOP, 2, 2, 0.
TOP, 3, 3, -0.01
*NODE OUTPUT, NSET=TOP
U
*CONTACT OUTPUT
CSTR
*END STEP
DECK
}

blocks 'SURFACE TO SURFACE' > FACE.inp
blocks 'NODE TO SURFACE' > NODE.inp
for deck in FACE NODE; do
  ccx $deck
done

cat > nodes.py <<'PYTHON'
from frd2vtu import frdbin2vtu

for deck in ("FACE", "NODE"):
    grid = frdbin2vtu(f"{deck}.frd")
    pressed = abs(grid.point_data["CONTACT_1.000"]).max(axis=1) > 0
    print(f"{deck}:", *grid.point_data["ccx_id"][pressed])
moved = abs(grid.point_data["DISP_1.000"]).max(axis=1) > 0
print("moved:", *grid.point_data["ccx_id"][moved])
PYTHON

venv/bin/python nodes.py | tee seen
diff - seen <<'OUTPUT'
FACE: 11 12 13 14
NODE: 1 2 3 4
moved: 1 2 3 4
OUTPUT
echo "as described"
