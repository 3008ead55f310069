#!/usr/bin/env bash
# meshio writes and reads 20-node bricks of Exodus files with VTK's order of the middle nodes.
#
# Guess: meshio puts the middle nodes of `hexahedron20` into the order of Exodus, in which the four
# upright edges come before the four of the top, as it does for Abaqus.
# Seen: it copies the numbers of VTK, in which the top comes first. VTK's reader of Exodus then sees
# a brick with eight middle nodes on the wrong edges and another volume. The other way, meshio reads
# a brick that has Exodus' order without moving its nodes. Volumes and stiffnesses are wrong.
# Versions: meshio 5.3.5, netCDF4 1.7.4, pyvista 0.49.1, vtk 9.7.2, numpy 2.3.5, Python 3.11;
# 2026-11-28.
# Output: volume of a brick of volume 1 that meshio wrote: "vtu: 1.000", "exodus: 0.083", the middle
# of an upright edge of a brick in Exodus' order that meshio reads as the middle of a top edge:
# "top edge at height 0.5", then "as described".
. "$(dirname "$0")/common.sh"
packages \
  meshio==5.3.5 netCDF4==1.7.4 pyvista==0.49.1 vtk==9.7.2 numpy==2.3.5
cd "$folder"

cat > brick.py <<'PYTHON'
import meshio
import netCDF4
import numpy as np
import pyvista

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
BASE = [(0, 1), (1, 2), (2, 3), (3, 0)]
TOP = [(4, 5), (5, 6), (6, 7), (7, 4)]
UPRIGHT = [(0, 4), (1, 5), (2, 6), (3, 7)]


def brick(edges):
    """Coordinates of the corners and of the middles of the edges."""
    return np.vstack([CORNERS] + [(CORNERS[a] + CORNERS[b]) / 2 for a, b in edges])


mesh = meshio.Mesh(brick(BASE + TOP + UPRIGHT), [("hexahedron20", np.arange(20)[None])])
for name, ending in (("vtu", "vtu"), ("exodus", "e")):
    mesh.write(f"brick.{ending}")
    grid = pyvista.read(f"brick.{ending}")
    if isinstance(grid, pyvista.MultiBlock):
        grid = grid.combine()
    print(f"{name}: {grid.compute_cell_sizes()['Volume'].sum():.3f}")

# The coordinates of the file that meshio wrote, with the nodes in the order of Exodus.
with netCDF4.Dataset("brick.e", "a") as data:
    data["coord"][:] = brick(BASE + UPRIGHT + TOP).T
assert abs(pyvista.read("brick.e").combine().compute_cell_sizes()["Volume"].sum() - 1) < 1e-9
back = meshio.read("brick.e")
middle = back.cells[0].data[0][12]  # VTK's first middle node of the top
print(f"top edge at height {back.points[middle][2]}")
PYTHON

venv/bin/python brick.py 2>errors | tee seen
diff - seen <<'OUTPUT'
vtu: 1.000
exodus: 0.083
top edge at height 0.5
OUTPUT
echo "as described"
