#!/usr/bin/env bash
# pyuff reads a 20-node brick of a universal file as a brick of 8 nodes and an invented element.
#
# Guess: dataset 2412 gives each element with all its nodes, or an error for a type that pyuff does
# not know.
# Seen: pyuff takes one line of 8 nodes for each element, also if the element says that it has 20.
# The lines that follow become headers: an element appears whose number, type and nodes are node
# numbers. There is no error. A file with two bricks also has two invented elements. Bricks of 8
# nodes are read rightly.
# Versions: pyuff 2.5.8, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: element, type and count of nodes that are read: "8 nodes: 1 of type 115 with 8",
# "20 nodes: 1 of type 116 with 8; 9 of type 10 with 4", then "as described".
. "$(dirname "$0")/common.sh"
packages pyuff==2.5.8 numpy==2.3.5
cd "$folder"

cat > bricks.py <<'PYTHON'
from pathlib import Path

import pyuff


def numbers(*values):
    return "".join(f"{value:10d}" for value in values) + "\n"


for count, kind in ((8, 115), (20, 116)):  # linear and parabolic brick
    nodes = range(1, count + 1)
    text = "    -1\n  2412\n" + numbers(1, kind, 1, 1, 7, count)
    for start in range(0, count, 8):
        text += numbers(*nodes[start : start + 8])
    Path("brick.unv").write_text(text + "    -1\n")
    elements = pyuff.UFF("brick.unv").read_sets(0)
    told = [
        f"{one['element_nums']} of type {kind} with {len(one['nodes_nums'])}"
        for kind, members in elements.items()
        if kind != "type"
        for one in members
    ]
    print(f"{count} nodes:", "; ".join(told))
PYTHON

venv/bin/python bricks.py | tee seen
diff - seen <<'OUTPUT'
8 nodes: 1 of type 115 with 8
20 nodes: 1 of type 116 with 8; 9 of type 10 with 4
OUTPUT
echo "as described"
