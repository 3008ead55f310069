#!/usr/bin/env bash
# exovista writes both sides of a closed contact as the same side set, with faces of both bodies.
#
# Guess: the side sets of a contact are the faces that were handed over, a set for each body: the
# faces that are cut from the lower body belong to its elements.
# Seen: `write_exo` looks for the nearest face of the mesh, and faces of two bodies that touch are
# at the same place. Both sets get the same faces, some of the lower body and some of the upper one.
# With them a contact of MOOSE or Sierra pairs a body with itself, or each body with a part of the
# other. Nothing is logged. With a small gap, both sets are right. So write closed contacts with a
# gap and move a body back in the file, or write the side sets with another tool.
# Versions: exovista 1.3.0, pyvista 0.49.1, vtk 9.7.2, netCDF4 1.7.4, scipy 1.16.3, numpy 2.3.5,
# Python 3.11; 2026-11-28.
# Output: bodies of the elements in the sets of both sides, for two blocks of four elements with a
# gap and without: "gap 0.001: lower in lower, upper in upper" and "gap 0: lower in both, upper in
# both, the same faces", then "as described".
. "$(dirname "$0")/common.sh"
packages exovista==1.3.0 pyvista==0.49.1 vtk==9.7.2 \
  netCDF4==1.7.4 scipy==1.16.3 numpy==2.3.5 2> /dev/null
cd "$folder"

cat > blocks.py <<'PYTHON'
import exovista
import netCDF4
import numpy as np
import pyvista as pv


def block(height, region):
    """A block of four bricks above a height."""
    grid = pv.ImageData(dimensions=(3, 3, 2), spacing=(0.5, 0.5, 1), origin=(0, 0, height))
    grid = grid.cast_to_unstructured_grid()
    grid.cell_data["region"] = np.full(grid.n_cells, region)
    return grid


def side(body, height, region):
    """Faces of a body at a height."""
    faces = body.extract_surface(algorithm="dataset_surface")
    there = np.isclose(faces.cell_centers().points[:, 2], height)
    faces = faces.extract_cells(there).extract_surface(algorithm="dataset_surface")
    faces.clear_data()
    faces.cell_data["region"] = np.full(faces.n_cells, region)
    return faces


for gap in (0.001, 0):
    lower, upper = block(0, 1), block(1 + gap, 2)
    sides = side(lower, 1, 1).merge(side(upper, 1 + gap, 2), merge_points=False)
    mesh = lower.merge(upper, merge_points=False)
    exovista.write_exo("blocks.exo", mesh, sides, side_set_names=["lower", "upper"])
    data = netCDF4.Dataset("blocks.exo").variables
    seen, faces = [], []
    for number, name in ((1, "lower"), (2, "upper")):
        elements = data[f"elem_ss{number}"][:].tolist()
        assert len(elements) == 4
        bodies = {"lower" if element <= 4 else "upper" for element in elements}
        seen.append(f"{name} in " + ("both" if len(bodies) == 2 else min(bodies)))
        faces.append(sorted(zip(elements, data[f"side_ss{number}"][:].tolist(), strict=True)))
    if faces[0] == faces[1]:
        seen.append("the same faces")
    print(f"gap {gap}:", ", ".join(seen))
PYTHON

venv/bin/python blocks.py | tee seen
diff - seen <<'OUTPUT'
gap 0.001: lower in lower, upper in upper
gap 0: lower in both, upper in both, the same faces
OUTPUT
echo "as described"
