"""
A contact in three dimensions
=============================

A square punch is pressed on a block, and the shear on its top turns: along x, y, -x, -y. Where does
the contact slip, and up to which load can slip stop?
"""

import frictopt as fo

scene = fo.scenes.SquarePunch(elements=6)
scene.plot()

# %%
# The picture shows the mesh with its contact, supports and unit loads. Now the pressure stays
# constant and the shear turns.

system = scene.condense()
turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])

fo.onset(system, turning, friction=0.5).plot()

# %%
# The bonded contact would slip first at the circled nodes. This slip can stop at loads up to the
# shakedown limit.

limit = fo.shakedown_limit(system, turning, friction=0.5)
limit.plot()
print(limit)

# %%
# The circled nodes govern the limit. The arrows are the residual slip that is safe at the limit.
# Below the limit, a contact without residual slip stops slipping here. Above the limit, slip stops
# from no start while all nodes stay closed.

for ratio in (0.9, 1.15):
    steady = fo.steady_state(system, turning, friction=0.5, load_factor=ratio * limit.load_factor)
    print(ratio, steady.outcome.name, steady.dissipation)

# %%
# Above the limit, the work of friction shows where the contact wears.

steady.plot()
# sphinx_gallery_thumbnail_number = 3
