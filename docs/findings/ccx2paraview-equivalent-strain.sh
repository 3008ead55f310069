#!/usr/bin/env bash
# The equivalent strain of ccx2paraview is 3/2 of von Mises' equivalent strain.
#
# Guess: `E_Mises`, which the code calls von Mises equivalent strain, is the axial strain of an
# incompressible bar in tension, and stress over three times the shear modulus.
# Seen: it is 1.5 times as large, because the formula for stress is used for strain.
# Versions: ccx2paraview 3.2.0, pyvista 0.49.1, vtk 9.7.2, numpy 2.3.5, Python 3.11, and
# CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: "axial strain 0.0100, S_Mises / 3G 0.0100, E_Mises 0.0150", then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix
packages ccx2paraview==3.2.0 pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5

# A cube in tension with Poisson's ratio 0.4999.
cat > pull.inp <<'DECK'
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=CUBE
1, 1, 2, 3, 4, 5, 6, 7, 8
*MATERIAL, NAME=M
*ELASTIC
1000., 0.4999
*SOLID SECTION, ELSET=CUBE, MATERIAL=M
*BOUNDARY
1, 1, 3
2, 2, 3
3, 3
4, 3
4, 1
5, 1, 2
8, 1
6, 2
*STEP
*STATIC
*BOUNDARY
5, 3, 3, 0.01
6, 3, 3, 0.01
7, 3, 3, 0.01
8, 3, 3, 0.01
*EL FILE
S, E
*END STEP
DECK
ccx pull
venv/bin/ccx2paraview pull.frd vtu > convert.log 2>&1

venv/bin/python - <<'PYTHON' | tee seen
import pyvista

mesh = pyvista.read("pull.vtu")
shear_modulus = 1000.0 / (2 * 1.4999)
axial = mesh["E"][0, 2]
stress, strain = mesh["S_Mises"][0], mesh["E_Mises"][0]
ratio = stress / (3 * shear_modulus)
print(f"axial strain {axial:.4f}, S_Mises / 3G {ratio:.4f}, E_Mises {strain:.4f}")
PYTHON
[ "$(cat seen)" = "axial strain 0.0100, S_Mises / 3G 0.0100, E_Mises 0.0150" ]
echo "as described"
