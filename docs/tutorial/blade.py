"""Mesh of a blade and a sector of its disc, lengths in mm. Needs gmsh: `python -m pip install gmsh`."""

import gmsh

blade = [
    (4, 120),
    (4, 6),
    (10, 2),
    (10, 0),
    (16, -6),
    (8, -14),
    (14, -20),
    (6, -28),
]  # x, y of the right half, from the tip down
disc = [
    (40, -60),
    (40, 3),
    (12, 3),
    (11, -1),
    (15, -5),
    (18, -6),
    (18, -8),
    (9.3, -13.7),
    (9, -15),
    (13, -19),
    (16, -20),
    (16, -32),
]
flanks = {
    "R1": (11, -5, 15, -1),
    "L1": (-15, -5, -11, -1),
    "R2": (9, -19, 13, -15),
    "L2": (-13, -19, -9, -15),
}  # x, y of two corners
ends = {"bottom": (-40, -60, 40, -60), "left": (-40, -60, -40, 3), "right": (40, -60, 40, 3)}

gmsh.initialize()
occ, field = gmsh.model.occ, gmsh.model.mesh.field
faces = []
for right in (blade, disc):
    points = [occ.addPoint(x, y, 0) for x, y in right + [(-x, y) for x, y in reversed(right)]]
    lines = [
        occ.addLine(one, two) for one, two in zip(points, points[1:] + points[:1], strict=True)
    ]
    faces.append((2, occ.addPlaneSurface([occ.addCurveLoop(lines)])))
_, parts = occ.fragment(faces[:1], faces[1:])  # both share the nodes of the flanks
occ.synchronize()

for name, surfaces in zip(("blade", "disc"), parts, strict=True):  # bodies
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in surfaces], name=name)
found = {}
for name, (x1, y1, x2, y2) in (flanks | ends).items():  # boundaries: all curves in a box
    found[name] = [
        tag
        for _, tag in gmsh.model.getEntitiesInBoundingBox(
            x1 - 0.01, y1 - 0.01, -1, x2 + 0.01, y2 + 0.01, 1, dim=1
        )
    ]
    gmsh.model.addPhysicalGroup(1, found[name], name=name)

near, size = (
    field.add("Distance"),
    field.add("Threshold"),
)  # elements grow with the distance from the flanks
field.setNumbers(near, "CurvesList", [tag for name in flanks for tag in found[name]])
for option, value in {
    "InField": near,
    "SizeMin": 0.5,
    "SizeMax": 5,
    "DistMin": 0.5,
    "DistMax": 20,
}.items():
    field.setNumber(size, option, value)
field.setAsBackgroundMesh(size)
gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
gmsh.model.mesh.generate(2)
gmsh.write("blade.msh")
gmsh.finalize()
