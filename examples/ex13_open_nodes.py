"""
A rounded punch, open at its edges
==================================

The shakedown limit asks that all nodes stay closed. Where the mean load leaves a gap, ask for states of rest with open nodes.
"""

import frictopt as fo

punch = fo.scenes.PunchOnHalfPlane(elements=12).condense()
rounded = punch.with_gap(2.0 * punch.x**4)
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
print(fo.shakedown_limit(rounded, cycle, friction=0.6).reason)

# %%
# The load factor is proven by a state of rest; the bound comes from a mixed-integer program.

limit = fo.separated_limit(rounded, cycle, friction=0.6)
print(limit.reason)
limit.plot()
