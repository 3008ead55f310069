#!/usr/bin/env bash
# pyvista's `integrate_data` integrates linear pieces of each cell, not its shape functions.
#
# Guess: the integral of nodal values over a face is that of the element's shape functions, so the
# integral of a contact pressure is the force, and quadratic faces are exact for x^2.
# Seen: each cell is cut into triangles between its nodes, and values are linear on each. Over one
# linear quadrilateral x y has 4/3 of its integral, over one quadratic triangle x^2 has 5/4 of it.
# Curved edges become chords, so the area of a curved face is too small as well. The error falls
# with the square of the size of the cells.
# Versions: pyvista 0.49.1, vtk 9.7.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: integrals over one cell, over those of its shape functions: "4 nodes, x y: 1.333",
# "8 nodes, x^2: 1.125", "6 nodes, x^2: 1.250"; the area of a quarter of a ring as one cell of
# 8 nodes over the one of its shape functions: "curved: 0.911"; then "as described".
. "$(dirname "$0")/common.sh"
packages pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5

cat > "$folder/integrals.py" <<'PYTHON'
import numpy as np
import pyvista

square = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)])
triangle = np.array([(0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)])


def one_cell(places, kind):
    points = np.column_stack([places, np.zeros(len(places))])
    return pyvista.UnstructuredGrid([len(places), *range(len(places))], [kind], points)


def integral(places, kind, values):
    cell = one_cell(places, kind)
    cell["values"] = values
    return float(cell.integrate_data()["values"][0])


kinds = pyvista.CellType
x, y = square.T
print(f"4 nodes, x y: {integral(square[:4], kinds.QUAD, x[:4] * y[:4]) / (1 / 4):.3f}")
print(f"8 nodes, x^2: {integral(square, kinds.QUADRATIC_QUAD, x**2) / (1 / 3):.3f}")
x = triangle[:, 0]
print(f"6 nodes, x^2: {integral(triangle, kinds.QUADRATIC_TRIANGLE, x**2) / (1 / 12):.3f}")

# A quarter of a ring of radii 1 and 2. Its shape functions have parabolas for arcs.
half = np.sqrt(0.5)
ring = [(1, 0), (2, 0), (0, 2), (0, 1), (1.5, 0), (2 * half, 2 * half), (0, 1.5), (half, half)]
area = float(one_cell(np.array(ring), kinds.QUADRATIC_QUAD).compute_cell_sizes()["Area"][0])


def below(radius):
    """Area of the sector from the middle to the parabola through the ends and the middle."""
    chord, rise = radius * np.sqrt(2), radius * (1 - half)
    return radius**2 / 2 + 2 / 3 * chord * rise


print(f"curved: {area / (below(2) - below(1)):.3f}")
PYTHON

"$folder/venv/bin/python" "$folder/integrals.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
4 nodes, x y: 1.333
8 nodes, x^2: 1.125
6 nodes, x^2: 1.250
curved: 0.911
OUTPUT
echo "as described"
