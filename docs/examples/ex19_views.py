"""
Seen from all sides
===================

A model gives its bodies, contacts and fields as grids of PyVista (extra ``view``). In a notebook
the scene turns with the mouse.
"""

import frictopt as fo

model = fo.scenes.SquarePunch(elements=8).model()
model.grids().plot(multi_colors=True)

# %%
# The meshes. The pressure stays, the shear turns.

turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])
limit = fo.shakedown_limit(model.condense(), turning, friction=0.5)
limit.plot()

# %%
# The state at the last corner of the cycle at its limit: pressure on the contact.

loads = turning.at(limit.load_factor)[-1]
fields = model.recover(loads, limit.state.slip, limit.state.gap)
grids = model.grids(fields)
grids["contact"].plot(scalars="pressure")

# %%
# And the stress of the punch under a part of its displacements.

grids["punch"].warp_by_vector("displacement", factor=0.5).plot(scalars="von_mises")
# sphinx_gallery_thumbnail_number = 3
