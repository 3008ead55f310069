#!/usr/bin/env bash
# meshio writes quadratic solids to Nastran with cards that do not exist; pyNastran then reads none.
#
# Guess: a mesh of `hexahedron20` or `tetra10` becomes CHEXA or CTETRA cards.
# Seen: the cards are `CHEXA_` and `CTETRA_`. meshio itself reads them back. pyNastran reads the
# deck without an error and has all nodes and no element. Linear solids are written rightly.
# Versions: meshio 5.3.5, pyNastran 1.3.4, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: card, and nodes and elements that pyNastran reads: "tetra: CTETRA, 4 nodes, 1 elements",
# "tetra10: CTETRA_, 10 nodes, 0 elements", "hexahedron20: CHEXA_, 20 nodes, 0 elements", then
# "as described".
. "$(dirname "$0")/common.sh"
packages meshio==5.3.5 pyNastran==1.3.4 numpy==2.3.5
cd "$folder"

cat > cards.py <<'PYTHON'
import re
from pathlib import Path

import meshio
import numpy as np
from pyNastran.bdf.bdf import BDF

tetrahedron = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
sides = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
base = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
cube = np.vstack([base, base + (0, 0, 1)])
around = [(0, 1), (1, 2), (2, 3), (3, 0)]
edges = around + [(a + 4, b + 4) for a, b in around] + [(k, k + 4) for k in range(4)]
bodies = {
    "tetra": tetrahedron,
    "tetra10": np.vstack([tetrahedron, [tetrahedron[list(pair)].mean(0) for pair in sides]]),
    "hexahedron20": np.vstack([cube, [cube[list(pair)].mean(0) for pair in edges]]),
}
for kind, points in bodies.items():
    cells = [(kind, [list(range(len(points)))])]
    mesh = meshio.Mesh(points, cells, cell_data={"nastran:ref": [[1]]})
    meshio.write("mesh.bdf", mesh, file_format="nastran")
    deck = Path("mesh.bdf").read_text()
    card = re.search(r"^(C[A-Z]+_?)", deck, flags=re.MULTILINE)[1]
    Path("deck.bdf").write_text("SOL 101\nCEND\n" + deck[deck.index("BEGIN BULK") :])
    model = BDF(debug=None)
    model.read_bdf("deck.bdf", xref=False)
    print(f"{kind}: {card}, {len(model.nodes)} nodes, {len(model.elements)} elements")
PYTHON

venv/bin/python -W ignore cards.py 2> errors | tee seen
diff - seen <<'OUTPUT'
tetra: CTETRA, 4 nodes, 1 elements
tetra10: CTETRA_, 10 nodes, 0 elements
hexahedron20: CHEXA_, 20 nodes, 0 elements
OUTPUT
echo "as described"
