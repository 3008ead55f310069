# Sourced by each script here: an empty folder that is removed at the end, and pinned software in it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Packages of Python, in an environment of their own: "$folder/venv/bin/python".
packages() {
  python3 -m venv "$folder/venv"
  "$folder/venv/bin/pip" install --quiet "$@"
}

# CalculiX of Debian 12, unpacked and not installed: "$folder/root/usr/bin/ccx" with "$libraries".
calculix() {
  (
    cd "$folder"
    apt-get download -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2 libarpack2 >/dev/null
    for package in *.deb; do dpkg --extract "$package" root; done
  )
  libraries=$(find "$folder/root" -name 'lib*.so*' -printf '%h\n' | sort --unique | paste --serial --delimiters=:)
}

# Runs a job of CalculiX in the folder: what it prints is in JOB.log. Argument: JOB.
ccx() {
  LD_LIBRARY_PATH="$libraries" "$folder/root/usr/bin/ccx" "$1" > "$1.log"
}

# Mesh, sets and faces of a block of side 1 above a larger one. Arguments: z of its lower and upper
# face; the larger one ends at z = 0.
two_blocks() {
  cat <<DECK
*NODE
1, -0.5, -0.5, -1.
2, 1.5, -0.5, -1.
3, 1.5, 1.5, -1.
4, -0.5, 1.5, -1.
5, -0.5, -0.5, 0.
6, 1.5, -0.5, 0.
7, 1.5, 1.5, 0.
8, -0.5, 1.5, 0.
11, 0., 0., $1
12, 1., 0., $1
13, 1., 1., $1
14, 0., 1., $1
15, 0., 0., $2
16, 1., 0., $2
17, 1., 1., $2
18, 0., 1., $2
*ELEMENT, TYPE=C3D8, ELSET=GROUND
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=BLOCK
2, 11, 12, 13, 14, 15, 16, 17, 18
*NSET, NSET=BELOW
1, 2, 3, 4
*NSET, NSET=TOP
15, 16, 17, 18
*SURFACE, NAME=UPPER
2, S1
*SURFACE, NAME=LOWER
1, S2
DECK
}
