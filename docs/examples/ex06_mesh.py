"""
Your own mesh
=============

The mesh file, made with gmsh, contains two bodies: a steel foot on a titanium block. Lengths are in
mm, stresses in MPa.
"""

from pathlib import Path

import frictopt as fo

root = (
    Path() if Path("docs").is_dir() else Path("../..")
)  # of the repository: you are there, or in `docs/examples`
mesh = fo.readers.read_mesh(root / "docs/tutorial/foot.msh")
bodies = fo.fem.split_bodies(
    mesh, {"foot": fo.fem.Material(E=210e3, nu=0.3), "block": fo.fem.Material(E=115e3, nu=0.33)}
)
model = fo.fem.ContactModel(
    bodies,
    contacts=[fo.fem.Contact("foot", "block", "block", "foot")],
    supports=[fo.fem.Support("block", "bottom")],
    loads={
        "press": [fo.fem.Traction("foot", "top", y=-100.0)],
        "stretch": [
            fo.fem.Traction("block", "left", x=-10.0),
            fo.fem.Traction("block", "right", x=10.0),
        ],
    },
)
model.plot()

# %%
# At load factor 1 the stress in the block changes between -10 and 10 MPa. The limit is the largest
# load factor with which the foot can stop slipping.

cycle = fo.LoadCycle(mean={"press": 1.0}, corners=[{"stretch": 1.0}, {"stretch": -1.0}])
limit = fo.shakedown_limit(model.condense(), cycle, friction=0.5)
print(limit)
limit.plot()

# sphinx_gallery_thumbnail_number = 2
