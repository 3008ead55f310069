#!/usr/bin/env bash
# meshio reads two parts of an Abaqus deck as elements that share the nodes of the last part.
#
# Guess: meshio places the parts of a deck as its instances say, or raises an error for `*PART` and
# `*INSTANCE`.
# Seen: each block `*NODE` replaces the nodes that were read before, and elements keep their places
# in the list. So the elements of all parts lie on the nodes of the last part: a small block below a
# large one becomes a second copy of the large one. The translation of the instance is dropped too.
# There is no warning, and the number of elements is right. The same happens to a deck without
# parts, with its own numbers for each body, if the nodes and elements of one body follow those of
# the other. Abaqus/CAE writes parts unless it is told not to, and sfepy 2026.3, which reads decks
# with meshio, is affected too. Write a deck without parts, and all its nodes in one block.
# Versions: meshio 5.3.5, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: volume of each of two blocks and the heights of its lowest and highest nodes: "parts: 18
# from 0 to 2, 18 from 0 to 2", "two blocks of nodes: 18 from 1 to 3, 18 from 1 to 3", "one block of
# nodes: 1 from 0 to 1, 18 from 1 to 3", then "as described".
. "$(dirname "$0")/common.sh"
packages meshio==5.3.5 numpy==2.3.5

cat > "$folder/read.py" <<'PYTHON'
import sys

import meshio
import numpy as np

CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def nodes(first, side, foot, height):
    """Lines of the nodes of an upright block."""
    places = [(*(side * corner), foot + z) for z in (0, height) for corner in CORNERS]
    return [f"{first + i}, {x}., {y}., {z}." for i, (x, y, z) in enumerate(places)]


def element(number, first):
    """Line of an element whose nodes have consecutive numbers."""
    return [", ".join(map(str, (number, *range(first, first + 8))))]


def part(name, *block):
    """A block as Abaqus/CAE writes it, with numbers from 1."""
    shape = ["*NODE", *nodes(1, *block), "*ELEMENT, TYPE=C3D8", *element(1, 1)]
    return [f"*PART, NAME={name}", *shape, "*END PART"]


def instance(name, *moved):
    """A part at its place in the assembly."""
    return [f"*INSTANCE, NAME={name}-1, PART={name}", *moved, "*END INSTANCE"]


bodies = [*part("LOWER", 1, 0, 1), *part("UPPER", 3, 0, 2)]
assembly = [*instance("LOWER"), *instance("UPPER", "0., 0., 1.")]
lower, upper = nodes(1, 1, 0, 1), nodes(11, 3, 1, 2)
brick = "*ELEMENT, TYPE=C3D8"
decks = {
    "parts": [*bodies, "*ASSEMBLY, NAME=A", *assembly, "*END ASSEMBLY"],
    "two blocks of nodes": ["*NODE", *lower, brick, *element(1, 1)]
    + ["*NODE", *upper, brick, *element(2, 11)],
    "one block of nodes": ["*NODE", *lower, *upper, brick, *element(1, 1), *element(2, 11)],
}
for name, lines in decks.items():
    deck = f"{sys.argv[1]}/deck.inp"
    with open(deck, "w") as file:
        file.write("\n".join(lines) + "\n")
    mesh = meshio.read(deck)
    seen = []
    for brick_nodes in mesh.cells_dict["hexahedron"]:
        points = mesh.points[brick_nodes]
        low, high = points[:, 2].min(), points[:, 2].max()
        seen.append(f"{np.prod(np.ptp(points, axis=0)):.0f} from {low:.0f} to {high:.0f}")
    print(f"{name}: {', '.join(seen)}")
PYTHON

"$folder/venv/bin/python" "$folder/read.py" "$folder" 2>&1 | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
parts: 18 from 0 to 2, 18 from 0 to 2
two blocks of nodes: 18 from 1 to 3, 18 from 1 to 3
one block of nodes: 1 from 0 to 1, 18 from 1 to 3
OUTPUT
echo "as described"
