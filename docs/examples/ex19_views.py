"""
Seen from all sides
===================

PyVista (extra ``view``) shows bodies, contacts and fields in space. In a notebook the scene turns
with the mouse.
"""

import frictopt as fo

model = fo.scenes.SquarePunch(elements=8).model()
model.view().show()

# %%
# The meshes, and the contact in black. The pressure stays, the shear turns.

turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])
limit = fo.shakedown_limit(model.condense(), turning, friction=0.5)
limit.plot()

# %%
# The state at the last corner of the cycle at its limit: pressure on the contact, seen through the
# bodies.

loads = turning.at(limit.load_factor)[-1]
fields = model.recover(loads, limit.state.slip, limit.state.gap)
model.view(fields, "pressure").show()

# %%
# And the stresses of the bodies under a part of their displacements.

model.view(fields, scale=0.5).show()
# sphinx_gallery_thumbnail_number = 3
