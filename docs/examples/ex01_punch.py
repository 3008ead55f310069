"""
Limits of a punch on a half-plane
=================================

The contact of Flicek et al. (2015): up to which load can it stop slipping, and which nodes govern
this limit?
"""

import frictopt as fo

scene = fo.scenes.PunchOnHalfPlane(elements=40)
scene.plot()

# %%
# Condense the mesh to its interface, press the punch, and pull the half-plane to and fro.

system = scene.condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
limit = fo.shakedown_limit(system, cycle, friction=0.7)
limit.plot()

# %%
# The nodes at the edges govern the limit. The mechanism lists these nodes, with the load corner and
# the direction of their slip.

print(limit.mechanism.head())

# sphinx_gallery_thumbnail_number = 2
