#!/usr/bin/env bash
# CalculiX spreads a pressure on an axisymmetric triangle (CAX3) evenly to both nodes of its edge.
#
# Guess: the nodal forces are the integral of the linear functions times 2 pi r, as with CAX4, so
# that a ring under uniform pressure shortens uniformly, with either element.
# Seen: with CAX4 all upper nodes of the ring move by the same -4e-4. With CAX3 they move by
# different amounts: too much at the inner edge, too little at the outer one. The sum is right.
# Versions: CalculiX 2.20 (Debian 2.20-1, with libspooles2.2 and libarpack2); 2026-11-27.
# Output: "CAX4 0 %", "CAX3 ... %" with the spread of the motions over their mean, more than 3 %;
# then "as described".
. "$(dirname "$0")/common.sh"
cd "$folder"
calculix

# A ring of radii 1 to 2 and height 1 in one row, E = 1000, nu = 0.3, pressure 0.4 from above.
ring() {
  cat <<DECK
*NODE, NSET=ALL
1, 1., 0.
2, 1.5, 0.
3, 2., 0.
4, 1., 1.
5, 1.5, 1.
6, 2., 1.
*NSET, NSET=LOW
1, 2, 3
*NSET, NSET=UP
4, 5, 6
*ELEMENT, TYPE=$1, ELSET=E
$2
*ELSET, ELSET=TOP
$3
*MATERIAL, NAME=M
*ELASTIC
1000., 0.3
*SOLID SECTION, ELSET=E, MATERIAL=M
*BOUNDARY
LOW, 2, 2
*STEP
*STATIC
*DLOAD
TOP, $4, 0.4
*NODE PRINT, NSET=UP
U
*END STEP
DECK
}

ring CAX4 $'1, 1, 2, 5, 4\n2, 2, 3, 6, 5' '1, 2' P3 > CAX4.inp
ring CAX3 $'1, 5, 4, 1\n2, 1, 2, 5\n3, 6, 5, 2\n4, 2, 3, 6' '1, 3' P1 > CAX3.inp
for kind in CAX4 CAX3; do
  ccx "$kind"
  awk -v kind="$kind" 'NF == 4 && $1 ~ /^[456]$/ {
      if (count == 0 || $3 < low) low = $3
      if (count == 0 || $3 > high) high = $3
      sum += $3; count++
    } END { printf "%s %.1f %%\n", kind, 100 * (high - low) / (-sum / count) }' "$kind.dat"
done | tee seen

read -r _ uniform _ < <(grep CAX4 seen)
read -r _ uneven _ < <(grep CAX3 seen)
awk -v uniform="$uniform" -v uneven="$uneven" 'BEGIN { exit !(uniform < 0.1 && uneven > 3) }'
echo "as described"
