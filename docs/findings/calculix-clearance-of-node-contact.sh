#!/usr/bin/env bash
# CalculiX ignores `*CLEARANCE` of node to surface contact, without a warning.
#
# Guess: `*CLEARANCE` with VALUE=0 closes a gap of the mesh in each type of contact.
# Seen: it does so in face-to-face contact and in mortar contact. In a pair of TYPE=NODE TO SURFACE
# the gap of the mesh remains, the bodies do not touch, and the screen does not mention it.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: for each type the pressing force of a block that begins 0.01 above the ground and moves
# down by 0.005: "SURFACE TO SURFACE: 3.948", "MORTAR: 3.948", "NODE TO SURFACE: 0.000", then
# "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A block of side 1 begins 0.01 above the ground, and moves down by 0.005.
blocks() {
  cat <<DECK
$(two_blocks 0.01 1.01)
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
*CLEARANCE, MASTER=LOWER, SLAVE=UPPER, VALUE=0.
*BOUNDARY
BELOW, 1, 3
*STEP, NLGEOM
*STATIC
0.25, 1.
*BOUNDARY
TOP, 1, 1, 0.
TOP, 2, 2, 0.
TOP, 3, 3, -0.005
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*END STEP
DECK
}

for type in 'SURFACE TO SURFACE' 'MORTAR' 'NODE TO SURFACE'; do
  job=${type%% *}
  blocks "$type" > "$job.inp"
  ccx "$job"
  force=$(awk '/total force/ {getline; getline; force = -$3} END {printf "%.3f", force}' "$job.dat")
  echo "$type: ${force/#-0.000/0.000}"
  if grep --quiet --fixed-strings '*CLEARANCE' "$job.log"; then exit 1; fi
done | tee seen
diff - seen <<'OUTPUT'
SURFACE TO SURFACE: 3.948
MORTAR: 3.948
NODE TO SURFACE: 0.000
OUTPUT
echo "as described"
