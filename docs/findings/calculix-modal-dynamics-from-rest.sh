#!/usr/bin/env bash
# Modal dynamics of CalculiX starts from rest if the modes come from the same job.
#
# Guess: `*INITIAL CONDITIONS, TYPE=VELOCITY` starts a free vibration in a step `*MODAL DYNAMIC`, as
# it does in a step `*DYNAMIC`.
# Seen: in the usual job of a step `*FREQUENCY` and a step `*MODAL DYNAMIC` nothing moves, and no
# warning is printed. If a job of its own stores the modes, and the next job with the same name has
# the modal step alone, the velocity counts. Initial displacements behave in the same way.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-28.
# Output: displacement after the time 0.01 of the free end of a column, all of which moves with the
# speed 1: "one job: 0.0000", "two jobs: 0.0103" with five modes, "direct: 0.0100", then "as
# described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A column of ten cubes that move along z only, held at its foot. Arguments: its steps.
column() {
  echo '*NODE, NSET=ALL'
  for level in $(seq 0 10); do
    printf '%s, %s, %s, %s.\n' "$((4 * level + 1))" 0. 0. "$level" "$((4 * level + 2))" 1. 0. "$level" \
      "$((4 * level + 3))" 1. 1. "$level" "$((4 * level + 4))" 0. 1. "$level"
  done
  echo '*ELEMENT, TYPE=C3D8, ELSET=CUBES'
  for cube in $(seq 1 10); do
    seq --separator=', ' "$((4 * cube - 3))" "$((4 * cube + 4))" | sed "s/^/$cube, /"
  done
  cat <<'DECK'
*NSET, NSET=FREE, GENERATE
5, 44
*NSET, NSET=END
41
*MATERIAL, NAME=M
*ELASTIC
1.E4, 0.
*DENSITY
1.
*SOLID SECTION, ELSET=CUBES, MATERIAL=M
*BOUNDARY
ALL, 1, 2
1, 3
2, 3
3, 3
4, 3
*INITIAL CONDITIONS, TYPE=VELOCITY
FREE, 3, 1.
DECK
  for step in "$@"; do
    printf '*STEP, INC=1000\n%s\n' "$step"
    case $step in *FREQUENCY*) ;; *) printf '*NODE PRINT, NSET=END, FREQUENCY=20\nU\n' ;; esac
    echo '*END STEP'
  done
}

# Print the last displacement. Arguments: title, name of the job.
told() {
  awk -v title="$1" '$1 == 41 {last = $4} END {printf "%s: %.4f\n", title, last}' "$2.dat"
}

frequency=$'*FREQUENCY, STORAGE=YES\n5'
modal=$'*MODAL DYNAMIC\n0.0005, 0.01'
direct=$'*DYNAMIC, DIRECT\n0.0005, 0.01'
{
  column "$frequency" "$modal" > one.inp
  ccx one
  told 'one job' one
  column "$frequency" > two.inp
  ccx two
  column "$modal" > two.inp
  ccx two
  told 'two jobs' two
  column "$direct" > direct.inp
  ccx direct
  told direct direct
} | tee seen
diff - seen <<'OUTPUT'
one job: 0.0000
two jobs: 0.0103
direct: 0.0100
OUTPUT
echo "as described"
