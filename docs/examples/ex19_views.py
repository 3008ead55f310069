"""
A joint in space, from all sides
================================

A model returns its bodies, contacts and fields as grids of PyVista (extra ``view``). In a notebook
you can turn the picture with the mouse.
"""

import frictopt as fo

model = fo.scenes.SquarePunch(elements=8).model()
model.grids().plot(multi_colors=True)

# %%
# The picture shows the meshes. Now the pressure stays constant and the shear turns.

turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])
limit = fo.shakedown_limit(model.condense(), turning, friction=0.5)
limit.plot()

# %%
# This is the pressure on the contact at the last load corner, at the limit.

loads = turning.at(limit.load_factor)[-1]
fields = model.recover(loads, limit.state.slip, limit.state.gap)
grids = model.grids(fields)
grids["contact"].plot(scalars="pressure")

# %%
# This is the stress in the punch, which is drawn with half of its displacements.

grids["punch"].warp_by_vector("displacement", factor=0.5).plot(scalars="von_mises")
# sphinx_gallery_thumbnail_number = 3
