"""Mesh of two plates and a bolt, lengths in mm. Needs gmsh: `python -m pip install gmsh`."""

import gmsh

gmsh.initialize()
occ = gmsh.model.occ
upper, lower = (
    occ.addBox(-12, -12, 0, 40, 24, 8),
    occ.addBox(-28, -12, -8, 40, 24, 8),
)  # x, y, z of a corner, lengths
hole = occ.addCylinder(0, 0, -8, 0, 0, 16, 5.5)  # x, y, z of an end, the axis, radius
plates, _ = occ.cut([(3, upper), (3, lower)], [(3, hole)])
halves = []  # of the bolt: shank and head, shank and nut; they meet at z = 0
for side in (1, -1):
    shank, head = (
        occ.addCylinder(0, 0, 0, 0, 0, side * 8, 5),
        occ.addCylinder(0, 0, side * 8, 0, 0, side * 6, 9),
    )
    halves += occ.fuse([(3, shank)], [(3, head)])[0]
_, (upper, lower, *bolt) = occ.fragment(plates, halves)  # all share the nodes of their common faces
occ.synchronize()

for name, volumes in {"upper": upper, "lower": lower, "bolt": bolt[0] + bolt[1]}.items():  # bodies
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in volumes], name=name)
boxes = {
    "right": (28, -12, 0, 28, 12, 8),
    "left": (-28, -12, -8, -28, 12, 0),
    "section": (-5, -5, 0, 5, 5, 0),
}
for name, (x1, y1, z1, x2, y2, z2) in boxes.items():  # boundaries: all faces in a box
    faces = gmsh.model.getEntitiesInBoundingBox(
        x1 - 0.1, y1 - 0.1, z1 - 0.1, x2 + 0.1, y2 + 0.1, z2 + 0.1, dim=2
    )
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in faces], name=name)

gmsh.option.setNumber("Mesh.MeshSizeMax", 4.2)  # coarse, for a quick tutorial
gmsh.model.mesh.generate(3)  # linear tetrahedra, which is gmsh's default
gmsh.write("lap.msh")
gmsh.finalize()
