"""
Limits of a punch on a half-plane
=================================

The scene of Flicek et al. (2015): which load does the contact survive without slipping for ever,
and which nodes limit it?
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
# The nodes at the edges limit the load. The mechanism lists them with the corner of the cycle and
# the direction of slip.

print(limit.mechanism.head())

# sphinx_gallery_thumbnail_number = 2
