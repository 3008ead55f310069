#!/usr/bin/env bash
# In CalculiX, reactions and contact forces of axisymmetric bodies are forces of a slice of 2
# degrees.
#
# Guess: the reactions of a ring of CAX4 balance the concentrated forces on it, as in each other
# analysis, since both are lines of the same deck and its results.
# Seen: `*CLOAD` is a force on the whole ring, as the displacements show. RF of `*NODE PRINT` and CF
# of `*CONTACT PRINT` are 1/180 of it, because they are forces on the slice of 2 degrees to which
# CalculiX expands the ring. Nothing in the results says so.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: a ring on another, pressed by forces of 180 in all: "shortening 0.0382", as under 180 on
# the whole area of the ring, "reaction 1.000", "contact force 1.000", then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

cat > rings.inp <<'DECK'
*NODE, NSET=ALL
1, 1., 0.
2, 2., 0.
3, 2., 1.
4, 1., 1.
5, 1., 1.
6, 2., 1.
7, 2., 2.
8, 1., 2.
*ELEMENT, TYPE=CAX4, ELSET=RINGS
1, 1, 2, 3, 4
2, 5, 6, 7, 8
*NSET, NSET=FOOT
1, 2
*SURFACE, NAME=LOWER
1, S3
*SURFACE, NAME=UPPER
2, S1
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*SOLID SECTION, ELSET=RINGS, MATERIAL=M
*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1.E6
*CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE
UPPER, LOWER
*BOUNDARY
ALL, 1
FOOT, 2
*STEP
*STATIC
1., 1.
*CLOAD
7, 2, -100.
8, 2, -80.
*NODE PRINT, NSET=ALL
U
*NODE PRINT, NSET=FOOT, TOTALS=ONLY
RF
*CONTACT PRINT, SLAVE=UPPER, MASTER=LOWER
CF
*END STEP
DECK
ccx rings
awk NF rings.dat | awk '
  /displacements/ {for (line = 0; line < 8; line++) {getline; if ($1 > 6) sum -= $3}}
  /total force/ {getline; reaction = $2}
  /total surface force/ {getline; contact = $2}
  END {
    printf "shortening %.4f\nreaction %.3f\ncontact force %.3f\n", sum / 2, reaction, contact
  }
' | tee seen
diff - seen <<'OUTPUT'
shortening 0.0382
reaction 1.000
contact force 1.000
OUTPUT
echo "as described"
