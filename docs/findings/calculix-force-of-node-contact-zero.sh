#!/usr/bin/env bash
# CalculiX prints contact forces of zero for node to surface contact that presses.
#
# Guess: `*CONTACT PRINT` with CF, CFN and CFS gives force, normal and shear force of the pair, or
# a warning if the type of contact has no such output.
# Seen: in face-to-face contact it does. In a pair of TYPE=NODE TO SURFACE all numbers are zero,
# although the reaction of the block is 7.829, and no warning says so. The stresses of CSTR are
# printed, per node.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: for each type the reaction and the printed total force along z: "SURFACE TO SURFACE:
# reaction 7.829, printed 7.829", "NODE TO SURFACE: reaction 7.829, printed 0.000", then
# "as described".
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
*CONTACT PRINT, SLAVE=UPPER, MASTER=LOWER
CF, CFN, CFS
*END STEP
DECK
}

for type in 'SURFACE TO SURFACE' 'NODE TO SURFACE'; do
  job=${type%% *}
  blocks "$type" > "$job.inp"
  ccx "$job"
  reaction=$(awk '/total force .fx,fy,fz. for set TOP/ {getline; getline; force = -$3}
    END {printf "%.3f", force}' "$job.dat")
  printed=$(awk '/total surface force/ {getline; getline; force[++n] = $3}
    END {printf "%.3f", force[n - 2]}' "$job.dat")
  echo "$type: reaction $reaction, printed $printed"
  if grep --quiet --ignore-case --extended-regexp 'CFN|contact force' "$job.log"; then exit 1; fi
done | tee seen
diff - seen <<'OUTPUT'
SURFACE TO SURFACE: reaction 7.829, printed 7.829
NODE TO SURFACE: reaction 7.829, printed 0.000
OUTPUT
echo "as described"
