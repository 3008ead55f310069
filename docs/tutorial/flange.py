"""Mesh of a quarter of a pipe flange with one of its four bolts, lengths in mm. Needs gmsh: `python -m pip install gmsh`."""

import math

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
occ, quarter = gmsh.model.occ, math.pi / 2


def half(side):
    """Quarter of a flange with its pipe, on one side of z = 0."""
    ring = occ.addCylinder(
        0, 0, min(0, side * 12), 0, 0, 12, 60, angle=quarter
    )  # an end, the axis, radius
    pipe = occ.addCylinder(0, 0, min(0, side * 40), 0, 0, 40, 36, angle=quarter)
    bore = occ.addCylinder(0, 0, 0, 0, 0, side * 40, 30)
    return occ.cut(occ.fuse([(3, ring)], [(3, pipe)])[0], [(3, bore)])[0]


x = 48 * math.cos(quarter / 2)  # x and y of the bolt
flanges, _ = occ.cut(half(1) + half(-1), [(3, occ.addCylinder(x, x, -12, 0, 0, 24, 5.5))])
halves = []  # of the bolt: shank and head, shank and nut; they meet at z = 0
for side in (1, -1):
    shank, head = (
        occ.addCylinder(x, x, 0, 0, 0, side * 12, 5),
        occ.addCylinder(x, x, side * 12, 0, 0, side * 6, 8.5),
    )
    halves += occ.fuse([(3, shank)], [(3, head)])[0]
_, (upper, lower, *bolt) = occ.fragment(
    flanges, halves
)  # all share the nodes of their common faces
occ.synchronize()


def faces(x1, y1, z1, x2, y2, z2):
    """Faces in a box."""
    return [
        tag
        for _, tag in gmsh.model.getEntitiesInBoundingBox(
            x1 - 0.1, y1 - 0.1, z1 - 0.1, x2 + 0.1, y2 + 0.1, z2 + 0.1, dim=2
        )
    ]


for name, volumes in {"upper": upper, "lower": lower, "bolt": bolt[0] + bolt[1]}.items():  # bodies
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in volumes], name=name)
low, high = [], []  # cut faces: above and below z = 0
for z in (0, -40):
    low += faces(0, 0, z, 60, 0, z + 40)
    high += faces(0, 0, z, 0, 60, z + 40)
section = faces(x - 5, x - 5, 0, x + 5, x + 5, 0)
for name, tags in {
    "low": low,
    "high": high,
    "section": section,
    "top": faces(0, 0, 40, 60, 60, 40),
    "bottom": faces(0, 0, -40, 60, 60, -40),
}.items():
    gmsh.model.addPhysicalGroup(2, tags, name=name)
turn = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]  # by 90 degrees about z: rows of a matrix
gmsh.model.mesh.setPeriodic(2, high, low, turn)  # nodes of the cut faces match

gmsh.option.setNumber("Mesh.MeshSizeMax", 9)  # coarse, for a quick tutorial
gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)  # elements around a circle
gmsh.model.mesh.generate(3)  # linear tetrahedra, which is gmsh's default
gmsh.write("flange.msh")
gmsh.finalize()
