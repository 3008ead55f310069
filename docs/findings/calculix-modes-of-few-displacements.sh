#!/usr/bin/env bash
# CalculiX gives a frequency of zero and exit status 0 for a model with few displacements.
#
# Guess: `*FREQUENCY` finds one mode of a model with four free displacements, or the job fails.
# Seen: the eigenvalue solver fails with "info=-3", which the screen shows as an error. The job goes
# on, writes a frequency and a mode shape of zero, finishes, and returns 0. The zero looks like a
# rigid body. Eight free displacements are enough for one mode.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: for columns of one and two cubes that move along z only: free displacements, exit status
# and first angular frequency, "4 free: status 0, frequency 0.00", where 54.77 is right, and
# "8 free: status 0, frequency 25.48", then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A column of cubes, E = 1000, density 1, held at its foot. Argument: their number.
column() {
  echo '*NODE, NSET=ALL'
  for level in $(seq 0 "$1"); do
    printf '%s, %s, %s, %s.\n' "$((4 * level + 1))" 0. 0. "$level" "$((4 * level + 2))" 1. 0. "$level" \
      "$((4 * level + 3))" 1. 1. "$level" "$((4 * level + 4))" 0. 1. "$level"
  done
  echo '*ELEMENT, TYPE=C3D8, ELSET=CUBES'
  for cube in $(seq 1 "$1"); do
    seq --separator=', ' "$((4 * cube - 3))" "$((4 * cube + 4))" | sed "s/^/$cube, /"
  done
  cat <<'DECK'
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*DENSITY
1.
*SOLID SECTION, ELSET=CUBES, MATERIAL=M
*NSET, NSET=FOOT
1, 2, 3, 4
*BOUNDARY
ALL, 1, 2
FOOT, 3
*STEP
*FREQUENCY
1
*END STEP
DECK
}

for cubes in 1 2; do
  column "$cubes" > modes.inp
  status=0
  ccx modes || status=$?
  awk -v free="$((4 * cubes))" -v status="$status" '$1 == 1 && NF == 5 {
    printf "%s free: status %s, frequency %.2f\n", free, status, $3
    exit
  }' modes.dat
done | tee seen
diff - seen <<'OUTPUT'
4 free: status 0, frequency 0.00
8 free: status 0, frequency 25.48
OUTPUT
echo "as described"
