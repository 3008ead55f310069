"""
A rounded punch, open at its edges
==================================

If no slip keeps all nodes closed, ``shakedown_limit`` searches for the nodes that stay open. The
search begins with the nodes that the mean load opens.
"""

import frictopt as fo

punch = fo.scenes.PunchOnHalfPlane(elements=12).condense()
rounded = punch.with_gap(2.0 * punch.x**4)
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
limit = fo.shakedown_limit(rounded, cycle, friction=0.6)
print(limit.reason)

# %%
# The bound holds for this set of open nodes.

print(limit.covers)
limit.plot()
