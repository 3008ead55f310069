"""Mesh of a foot, 10 mm wide, on a block. Needs gmsh: `python -m pip install gmsh`."""

import gmsh

gmsh.initialize()
occ = gmsh.model.occ
foot, block = (
    occ.addRectangle(-5, 0, 0, 10, 10),
    occ.addRectangle(-30, -25, 0, 60, 25),
)  # x, y, z of a corner, width, height
occ.fragment([(2, foot)], [(2, block)])  # the bodies share the nodes of their common edge
occ.synchronize()

gmsh.model.addPhysicalGroup(2, [foot], name="foot")  # bodies
gmsh.model.addPhysicalGroup(2, [block], name="block")
edges = {
    "top": (-5, 10, 5, 10),
    "bottom": (-30, -25, 30, -25),
    "left": (-30, -25, -30, 0),
    "right": (30, -25, 30, 0),
}
for name, (x1, y1, x2, y2) in edges.items():  # boundaries: all curves in a box
    curves = gmsh.model.getEntitiesInBoundingBox(
        x1 - 0.1, y1 - 0.1, -0.1, x2 + 0.1, y2 + 0.1, 0.1, dim=1
    )
    gmsh.model.addPhysicalGroup(1, [tag for _, tag in curves], name=name)

(contact,) = [
    tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-5.1, -0.1, -0.1, 5.1, 0.1, 0.1, dim=1)
]
# elements of 0.25 mm at the contact, a fifth of the distance larger away from it
field = gmsh.model.mesh.field
field.add("Distance", 1)
field.setNumbers(1, "CurvesList", [contact])
field.setNumber(1, "Sampling", 200)
field.add("MathEval", 2)
field.setString(2, "F", "0.25 + 0.2 * F1")
field.setAsBackgroundMesh(2)
gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
gmsh.model.mesh.generate(2)  # linear elements, which is gmsh's default
gmsh.write("foot.msh")
gmsh.finalize()
