#!/usr/bin/env bash
# CalculiX lets node to surface contact stick in the modes of a joint, also where it slides.
#
# Guess: a step `*FREQUENCY` with `PERTURBATION` after a static step keeps the tangential stiffness
# of nodes that stick, and has none where the static step ends in slip.
# Seen: face-to-face contact does so. In a pair of TYPE=NODE TO SURFACE all nodes that touch stick
# in the modes, also those that slide in the static step. So a joint under slip is too stiff. (The
# shear of a sliding block is 0.99 of its bound along x because the ground tilts below it.)
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: for each type, with a small and a large way, the shear force at the end of the static step
# over its bound, and the first angular frequency of the block that is free to move
# along x: 18.7 if the contact sticks, 0 if it slides. For SURFACE TO SURFACE 18.7 and 0.0, for
# NODE TO SURFACE 18.7 and 18.7, then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A block is pressed on a larger one and moved. Arguments: type of contact and way.
blocks() {
  cat <<DECK
$(two_blocks 0. 1.)
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*DENSITY
1.
*SOLID SECTION, ELSET=GROUND, MATERIAL=M
*SOLID SECTION, ELSET=BLOCK, MATERIAL=M
*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1.E5
*FRICTION
0.3, 1.E3
*CONTACT PAIR, INTERACTION=I, TYPE=$1
UPPER, LOWER
*BOUNDARY
BELOW, 1, 3
*STEP, NLGEOM
*STATIC
0.1, 1.
*BOUNDARY
TOP, 1, 1, $2
TOP, 2, 2, 0.
TOP, 3, 3, -0.01
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*END STEP
*STEP, PERTURBATION
*FREQUENCY
2
*BOUNDARY, OP=NEW
BELOW, 1, 3
TOP, 2, 3
*END STEP
DECK
}

for type in 'SURFACE TO SURFACE' 'NODE TO SURFACE'; do
  blocks "$type" 0.0005 > sticks.inp
  blocks "$type" 0.05 > slides.inp
  for job in sticks slides; do
    ccx "$job"
    awk -v job="$type, $job:" '
      /total force/ && !modes {getline; getline; shear = $1 < 0 ? -$1 : $1; bound = -0.3 * $3}
      /E I G E N V A L U E/ {modes = 1}
      modes && $1 == 1 && NF == 4 && !done {
        done = 1
        printf "%s shear %.2f of the bound, first frequency %.1f\n", job, shear / bound, $2
      }
    ' "$job.dat"
  done
done | tee seen
diff - seen <<'OUTPUT'
SURFACE TO SURFACE, sticks: shear 0.05 of the bound, first frequency 18.7
SURFACE TO SURFACE, slides: shear 0.99 of the bound, first frequency 0.0
NODE TO SURFACE, sticks: shear 0.05 of the bound, first frequency 18.7
NODE TO SURFACE, slides: shear 0.99 of the bound, first frequency 18.7
OUTPUT
echo "as described"
