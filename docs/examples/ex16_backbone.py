"""
The backbone curve of a joint
=============================

A load shakes a joint. As its amplitude grows, the work of friction and the slipping share grow, and
the stiffness falls. Damping depends on the residual slip from assembly. If the load excites a mode
(`Modes.load`) and its `natural_frequency` is passed, the curve has the frequency, too.
"""

import numpy as np

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=16).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": 1.0}, {"sigma": -1.0}])
curve = fo.joints.backbone_curve(
    system, cycle, friction=0.6, load_factors=np.geomspace(0.3, 4.0, 6), with_range=True
)
print(curve.to_frame())
curve.plot()

# %%
# At which load does a fifth of the contact slip? Transients between two load factors of the curve
# find the least such load. The result is the steady state at this load.

fifth = curve.load_at(slipping=0.2)
print(fifth.load_factor, fifth.slipping_share)
print(fifth.by_contact().T)

# %%
# This is the hysteresis loop of the load in one steady cycle. Its area is the work of friction.

steady = fo.steady_state(system, cycle, friction=0.6, load_factor=3.0)
loop = steady.loop("sigma")
print(loop.area, steady.dissipation)
loop.plot()

# %%
# If the surfaces have a contact stiffness, the stress at the corners is not singular.

soft = system.with_contact_stiffness(tangential=20.0, normal=20.0)
print(
    fo.shakedown_limit(system, cycle, friction=0.6), fo.shakedown_limit(soft, cycle, friction=0.6)
)
