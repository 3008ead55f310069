#!/usr/bin/env bash
# The contact shear that CalculiX prints points against the force that it prints for the same faces.
#
# Guess: CSTR, the contact stress on the slave face, is the traction on the slave: it opposes the
# slip, and its product with the area is the shear force CFS of the slave.
# Seen: CFS opposes the slip of the slave. CSTR has the direction of the slip, like the traction on
# the master. So work as CSTR times slip is positive, and a sum of CSTR and CFS cancels.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: signs along x as the slave slides along +x: "slip +, CSTR +, CFS -", then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

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
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*CONTACT PRINT
CDIS, CSTR
*CONTACT PRINT, SLAVE=UPPER, MASTER=LOWER
CFS
*END STEP
DECK
}

blocks 'SURFACE TO SURFACE' > slide.inp
ccx slide
awk '
  function sign(value) {return value > 0 ? "+" : "-"}
  /relative contact displacement/ {getline; getline; slip = $4}
  /contact stress/ {getline; getline; stress = $4}
  /total surface force/ {getline; getline; force = $1}
  END {printf "slip %s, CSTR %s, CFS %s\n", sign(slip), sign(stress), sign(force)}
' slide.dat | tee seen
diff - seen <<'OUTPUT'
slip +, CSTR +, CFS -
OUTPUT
echo "as described"
