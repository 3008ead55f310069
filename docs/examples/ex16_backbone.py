"""
The backbone curve of a joint
=============================

A load shakes a joint. Work of friction and slipping share grow with the amplitude, stiffness falls,
and damping depends on what assembly has left. With the load of a mode (`Modes.load`) and its
`natural_frequency` the curve has the frequency, too.
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
# At which load does a fifth of the contact slip? The answer is the steady state at the least load
# found, by transients between two load factors of the curve.

fifth = curve.load_at(slipping=0.2)
print(fifth.load_factor, fifth.slipping_share)
print(fifth.by_contact().T)

# %%
# The loop of the load in one of these steady cycles; its area is the work of friction.

steady = fo.steady_state(system, cycle, friction=0.6, load_factor=3.0)
loop = steady.loop("sigma")
print(loop.area, steady.dissipation)
loop.plot()

# %%
# With surfaces that give the corners are not singular.

soft = system.with_contact_stiffness(tangential=20.0, normal=20.0)
print(
    fo.shakedown_limit(system, cycle, friction=0.6), fo.shakedown_limit(soft, cycle, friction=0.6)
)
