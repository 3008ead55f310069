"""
A transient into its steady state
=================================

Above the shakedown limit the contact slips for ever. This example follows the slip exactly, from
event to event, without a time step.
"""

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=24).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])

path = fo.march(system, cycle, friction=0.7, load_factor=2.2, cycles=4)
path.plot()

# %%
# The steady state is proven, because a cycle that starts from this state returns to it.

steady = fo.steady_state(system, cycle, friction=0.7, load_factor=2.2)
print(steady)
steady.plot()
