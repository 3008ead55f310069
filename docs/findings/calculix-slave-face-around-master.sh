#!/usr/bin/env bash
# In CalculiX a slave face that is larger than the whole master passes through it without contact.
#
# Guess: swapping slave and master changes the contact force of two blocks by a few per cent, at
# least in face-to-face contact, which integrates over faces.
# Seen: if one face of the slave covers the whole master, with all its nodes outside, the force is
# zero in all types of contact, and no warning is printed. The other order gives the full force.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: for each type the pressing force of a block of side 1 on a face of side 2, moved by 0.01:
# "SURFACE TO SURFACE: 7.857, swapped 0.000", and likewise for MORTAR and NODE TO SURFACE, then
# "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A block of side 1 on a larger one. Arguments: type of contact, slave and master.
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
$2
*BOUNDARY
BELOW, 1, 3
*STEP, NLGEOM
*STATIC
0.25, 1.
*BOUNDARY
TOP, 1, 1, 0.
TOP, 2, 2, 0.
TOP, 3, 3, -0.01
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*END STEP
DECK
}

force() {
  awk '/total force/ {getline; getline; force = -$3} END {printf "%.3f", force}' "$1.dat" \
    | sed 's/^-0.000/0.000/'
}

for type in 'SURFACE TO SURFACE' 'MORTAR' 'NODE TO SURFACE'; do
  blocks "$type" 'UPPER, LOWER' > given.inp
  blocks "$type" 'LOWER, UPPER' > swapped.inp
  ccx given
  ccx swapped
  echo "$type: $(force given), swapped $(force swapped)"
done | tee seen
diff - seen <<'OUTPUT'
SURFACE TO SURFACE: 7.857, swapped 0.000
MORTAR: 7.857, swapped 0.000
NODE TO SURFACE: 7.857, swapped 0.000
OUTPUT
echo "as described"
