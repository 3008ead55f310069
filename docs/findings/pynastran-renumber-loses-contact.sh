#!/usr/bin/env bash
# pyNastran's `bdf_renumber` renumbers elements and nodes, and leaves those of contact surfaces.
#
# Guess: cards that refer to elements follow them, and a card that is not supported raises an error:
# the documentation says that the function "usually brutally crashes if it's not supported".
# Seen: `BSURF` and `BSURFS` keep the old numbers. In the new deck they name elements and nodes that
# are absent, or, if the new numbers overlap the old ones, those of the other body. `BCTSET` is
# unchanged too, as it should be. `CGAP` and `PLOAD4` follow. No warning is logged. Contact is in
# neither of the two lists of cards, done and not done; `DMIG`, which keeps its nodes too, is in the
# second.
# Versions: pyNastran 1.4.1, numpy 1.26.4, Python 3.11; 2026-11-28.
# Output: number of the element of the body before and after, and those of the cards after: "element
# 1, was 2", "PLOAD4 1", "BSURF 2", then "as described". Element 2 is now the gap.
. "$(dirname "$0")/common.sh"
packages pyNastran==1.4.1 numpy==1.26.4
cd "$folder"

cat > deck.bdf <<'DECK'
CEND
BEGIN BULK
GRID,11,,0.,0.,0.
GRID,12,,1.,0.,0.
GRID,13,,0.,1.,0.
GRID,14,,0.,0.,1.
GRID,15,,0.,0.,2.
CTETRA,2,1,11,12,13,14
PSOLID,1,1
MAT1,1,210000.,,.3
CGAP,9,7,14,15,1.,0.,0.
PGAP,7,0.,0.,1.+6,,,.3,.3
PLOAD4,5,2,1.,,,,11,14
BSURF,20,2
BCTSET,30,20,20,.3
ENDDATA
DECK

cat > renumber.py <<'PYTHON'
from pyNastran.bdf.bdf import read_bdf
from pyNastran.bdf.mesh_utils.bdf_renumber import bdf_renumber

bdf_renumber("deck.bdf", "new.bdf")
old, new = (read_bdf(name, xref=False, debug=None) for name in ("deck.bdf", "new.bdf"))


def body(model):
    (number,) = [n for n, element in model.elements.items() if element.type == "CTETRA"]
    return number


print(f"element {body(new)}, was {body(old)}")
print("PLOAD4", *(load.eids[0] for load in sum(new.loads.values(), [])))
print("BSURF", *new.bsurf[20].eids)
print("element 2 is now a", new.elements[2].type)
PYTHON

venv/bin/python renumber.py > log 2> errors
if grep -i 'bsurf.*warn\|warn.*bsurf\|contact' errors; then exit 1; fi
grep -E '^(element|PLOAD4|BSURF) ' log | tee seen
diff - seen <<'OUTPUT'
element 1, was 2
PLOAD4 1
BSURF 2
element 2 is now a CGAP
OUTPUT
echo "as described"
