#!/usr/bin/env bash
# pyvista's `sample` finds few of the points inside a plane mesh of curved quadratic cells.
#
# Guess: `sample` finds all points inside the mesh, the same as `find_containing_cell`, and returns
# the field of the shape functions there.
# Seen: on a quarter ring of 4 x 2 quadrilaterals of 8 nodes it misses most points. They get the
# value 0, and only the array "vtkValidPointMask" says so; a mean or a plot along a line is then
# wrong. A mesh with straight edges, or with 16 cells around, loses no point. VTK looks for the point
# in four linear pieces of the cell, evaluates the curved cell at the place found, and takes the
# distance between the two for a distance from the mesh, which must be below 0.1 % of the cell.
# `tolerance=0.01` finds all points, at places that are off by that distance.
# Versions: pyvista 0.49.1, vtk 9.7.2, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: for 4 x 2 cells with curved or straight edges, number of points out of 400 inside the mesh
# that are found, and mean of a field that is 1 at all nodes: "curved: containing 400, sample 28,
# mean 0.07", "straight: containing 400, sample 400, mean 1.00", "curved, tolerance 0.01: sample
# 400", then "as described".
. "$(dirname "$0")/common.sh"
packages pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5
cd "$folder"

cat > ring.py <<'PYTHON'
import numpy as np
import pyvista

AROUND, THROUGH = 4, 2


def ring(straight):
    """A quarter of a ring with the radii 1 and 2, whose edges are arcs or chords."""
    columns, rows = 2 * AROUND + 1, 2 * THROUGH + 1
    points = np.zeros((columns, rows, 3))
    for i in range(columns):
        angle = i / (columns - 1) * np.pi / 2
        for j in range(rows):
            radius = 1 + j / (rows - 1)
            points[i, j, :2] = radius * np.cos(angle), radius * np.sin(angle)
    if straight:
        points[1::2] = (points[:-1:2] + points[2::2]) / 2
    places = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0)]
    cells = [
        [(i + a) * rows + j + b for a, b in places]
        for i in range(0, columns - 1, 2)
        for j in range(0, rows - 1, 2)
    ]
    mesh = pyvista.UnstructuredGrid(
        {pyvista.CellType.QUADRATIC_QUAD: np.array(cells)}, points.reshape(-1, 3)
    )
    mesh["one"] = np.ones(mesh.n_points)
    return mesh


# The radii stay below the chords of the outer arc.
random = np.random.default_rng(0)
radius, angle = random.uniform(1.05, 1.95, 400), random.uniform(0.02, 1.55, 400)
inside = np.c_[radius * np.cos(angle), radius * np.sin(angle), 0 * radius]
for name, straight in (("curved", False), ("straight", True)):
    mesh = ring(straight)
    containing = (mesh.find_containing_cell(inside) >= 0).sum()
    sampled = pyvista.PolyData(inside).sample(mesh)
    found = sampled["vtkValidPointMask"].sum()
    print(f"{name}: containing {containing}, sample {found}, mean {sampled['one'].mean():.2f}")
sampled = pyvista.PolyData(inside).sample(ring(straight=False), tolerance=0.01)
print(f"curved, tolerance 0.01: sample {sampled['vtkValidPointMask'].sum()}")
PYTHON

venv/bin/python ring.py | tee seen
diff - seen <<'OUTPUT'
curved: containing 400, sample 28, mean 0.07
straight: containing 400, sample 400, mean 1.00
curved, tolerance 0.01: sample 400
OUTPUT
echo "as described"
