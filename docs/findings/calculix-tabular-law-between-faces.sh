#!/usr/bin/env bash
# Face-to-face contact of CalculiX with a tabular law transmits no force.
#
# Guess: PRESSURE-OVERCLOSURE=TABULAR gives the pressure of the table in each type of contact, as
# LINEAR does.
# Seen: it does so in a pair of TYPE=NODE TO SURFACE. In a pair of TYPE=SURFACE TO SURFACE the bodies
# pass through each other: the contact elements exist and print the overlap, and their pressure is
# zero. The job ends normally, and no warning mentions it.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: pressure and overlap of two cubes (stiffness 1e5) that are pushed together by 0.002, with
# the table 1e5 times the overlap, where 67 at 0.0007 is the closed form for small strains:
# "NODE TO SURFACE, TABULAR: 67 at 0.0007", "SURFACE TO SURFACE, TABULAR: 0 at 0.0020", and the
# closed form within 1 for LINEAR in both, then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# Two cubes of side 1, with all sides held across. Arguments: type of contact, law, its data.
cubes() {
  cat <<DECK
*NODE, NSET=ALL
1, 0., 0., -1.
2, 1., 0., -1.
3, 1., 1., -1.
4, 0., 1., -1.
5, 0., 0., 0.
6, 1., 0., 0.
7, 1., 1., 0.
8, 0., 1., 0.
11, 0., 0., 0.
12, 1., 0., 0.
13, 1., 1., 0.
14, 0., 1., 0.
15, 0., 0., 1.
16, 1., 0., 1.
17, 1., 1., 1.
18, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=CUBES
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 11, 12, 13, 14, 15, 16, 17, 18
*NSET, NSET=FOOT
1, 2, 3, 4
*NSET, NSET=TOP
15, 16, 17, 18
*SURFACE, NAME=UPPER
2, S1
*SURFACE, NAME=LOWER
1, S2
*MATERIAL, NAME=M
*ELASTIC
1.E5, 0.
*SOLID SECTION, ELSET=CUBES, MATERIAL=M
*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=$2
$3
*CONTACT PAIR, INTERACTION=I, TYPE=$1
UPPER, LOWER
*BOUNDARY
ALL, 1, 2
FOOT, 3
*STEP, NLGEOM
*STATIC
1., 1.
*BOUNDARY
TOP, 3, 3, -0.002
*CONTACT PRINT
CDIS
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*END STEP
DECK
}

table='0., 0.
100., 0.001
1000., 0.01'
for type in 'NODE TO SURFACE' 'SURFACE TO SURFACE'; do
  for law in TABULAR LINEAR; do
    if [ "$law" = TABULAR ]; then data=$table; else data=1.E5; fi
    cubes "$type" "$law" "$data" > push.inp
    ccx push
    awk -v title="$type, $law" '
      /total force/ {getline; getline; force = -$3 + 1e-9}
      /relative contact displacement/ {getline; getline; overlap = -$(NF - 2)}
      END {printf "%s: %.0f at %.4f\n", title, force, overlap}
    ' push.dat
  done
done | tee seen
diff - seen <<'OUTPUT'
NODE TO SURFACE, TABULAR: 67 at 0.0007
NODE TO SURFACE, LINEAR: 66 at 0.0007
SURFACE TO SURFACE, TABULAR: 0 at 0.0020
SURFACE TO SURFACE, LINEAR: 67 at 0.0007
OUTPUT
echo "as described"
