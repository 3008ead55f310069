#!/usr/bin/env bash
# The force of `*SECTION PRINT` in CalculiX is half of the force for some plane elements.
#
# Guess: SOF, the force through a surface, is the sum of the reactions on the other side, for all
# elements.
# Seen: for CPS4, CPE4 and the quadratic reduced CPS8R, CPE8R it is half of that sum, and
# the printed area is half of the area too. It is right for their neighbours CPE4R, CPE8 and CPS8.
# So mean stress as force over area looks right, and no warning is printed.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: reaction and SOF of a square of side 1 and thickness 2 under the strain 0.01 with stiffness
# 1000, where both should be 20: "CPE4: 20.0 and 10.0", "CPE4R: 20.0 and 20.0" and so on, then "as
# described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A square that is held across and stretched along y. Argument: type of the element.
square() {
  local nodes='1, 2, 3, 4' foot='1, 2' top='3, 4'
  case $1 in *8*) nodes='1, 2, 3, 4, 5, 6, 7, 8' foot='1, 2, 5' top='3, 4, 7' ;; esac
  cat <<DECK
*NODE, NSET=ALL
1, 0., 0.
2, 1., 0.
3, 1., 1.
4, 0., 1.
5, 0.5, 0.
6, 1., 0.5
7, 0.5, 1.
8, 0., 0.5
*ELEMENT, TYPE=$1, ELSET=SQUARE
1, $nodes
*NSET, NSET=FOOT
$foot
*NSET, NSET=TOP
$top
*SURFACE, NAME=UPPER
1, S3
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*SOLID SECTION, ELSET=SQUARE, MATERIAL=M
2.
*BOUNDARY
ALL, 1
FOOT, 2
*STEP
*STATIC
*BOUNDARY
TOP, 2, 2, 0.01
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*SECTION PRINT, SURFACE=UPPER, NAME=CUT
SOF
*END STEP
DECK
}

for type in CPE4 CPE4R CPE8 CPE8R CPS4 CPS8 CPS8R; do
  square "$type" > cut.inp
  ccx cut
  awk NF cut.dat | awk -v type="$type" '
    /total force/ {getline; reaction = $2}
    /area, *normal force/ {getline; force = $2}
    END {printf "%s: %.1f and %.1f\n", type, reaction, force}
  '
done | tee seen
diff - seen <<'OUTPUT'
CPE4: 20.0 and 10.0
CPE4R: 20.0 and 20.0
CPE8: 20.0 and 20.0
CPE8R: 20.0 and 10.0
CPS4: 20.0 and 10.0
CPS8: 20.0 and 20.0
CPS8R: 20.0 and 10.0
OUTPUT
echo "as described"
