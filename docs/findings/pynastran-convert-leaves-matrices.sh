#!/usr/bin/env bash
# pyNastran's conversion of units leaves matrices and the distances of contact in the old units.
#
# Guess: `convert` from mm, Mg, s to m, kg, s converts all lengths and stiffnesses of a deck, or
# complains about a card that it does not know.
# Seen: nodes, springs, gaps, materials and forces are converted. A stiffness matrix (`DMIG`, such as
# a reduced joint) keeps its numbers and is then 1000 times too soft beside a spring (`CELAS2`) of
# the same stiffness. The search distance of `BCTSET` stays 10 as well, now metres. No warning is
# logged; the documentation has no list of cards.
# Versions: pyNastran 1.4.1, numpy 1.26.4, Python 3.11; 2026-11-28.
# Output: node coordinate, spring, gap, matrix and search distance, each times what it should be:
# "GRID 1", "CELAS2 1", "PGAP 1", "DMIG 0.001", "BCTSET 1000", then "as described".
. "$(dirname "$0")/common.sh"
packages pyNastran==1.4.1 numpy==1.26.4
cd "$folder"

cat > deck.bdf <<'DECK'
CEND
BEGIN BULK
GRID,11,,0.,0.,0.
GRID,12,,8.,0.,0.
GRID,13,,0.,8.,0.
GRID,14,,0.,0.,8.
CTETRA,1,1,11,12,13,14
PSOLID,1,1
MAT1,1,210000.,,.3
CELAS2,2,5000.,11,1,12,1
CGAP,3,7,13,14,1.,0.,0.
PGAP,7,0.,0.,5000.,,,.3,.3
DMIG,KJOINT,0,6,1,0
DMIG,KJOINT,11,1,,11,1,5000.
BSURF,20,1
BSURF,21,1
BCTSET,30,20,21,.3,0.,10.
ENDDATA
DECK

cat > convert.py <<'PYTHON'
from pyNastran.bdf.bdf import read_bdf
from pyNastran.bdf.mesh_utils.convert import convert

model = read_bdf("deck.bdf", debug=False)
convert(model, units_to=["m", "kg", "s"], units=["mm", "Mg", "s"])
model.write_bdf("metres.bdf")

# From the file that a solver would read. N/mm are 1000 N/m.
new = read_bdf("metres.bdf", xref=False, debug=None)
print(f"GRID {new.nodes[12].xyz[0] / 0.008:g}")
print(f"CELAS2 {new.elements[2].k / 5e6:g}")
print(f"PGAP {new.properties[7].ka / 5e6:g}")
print(f"DMIG {new.dmig['KJOINT'].Real[0] / 5e6:g}")
print(f"BCTSET {new.bctsets[30].max_distances[0] / 0.01:g}")
PYTHON

venv/bin/python convert.py > log 2>&1
if grep -i 'warning' log; then exit 1; fi
grep -E '^(GRID|CELAS2|PGAP|DMIG|BCTSET) [0-9.]*$' log | tee seen
diff - seen <<'OUTPUT'
GRID 1
CELAS2 1
PGAP 1
DMIG 0.001
BCTSET 1000
OUTPUT
echo "as described"
