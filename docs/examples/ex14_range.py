"""
The work of friction depends on the start
=========================================

Above the shakedown limit slip goes on from every start, but the work of friction depends on the
start. How far apart may the works of two starts be?
"""

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=16).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
limit = fo.shakedown_limit(system, cycle, friction=0.6)
found = fo.dissipation_range(system, cycle, friction=0.6, load_factor=1.2 * limit.load_factor)
print(found)
found.plot()

# %%
# Below the limit the start decides whether slip stops. Up to which load factor does slip stop if the
# mean load assembles the contact?

after = fo.limit_after_protocol(limit)
print(after)
after.plot()

# %%
# One unloading may help. Take the start with the most work among all slips that are no larger than
# the safe slip. Up to which load factor does slip stop after an unloading?

below = 0.9 * limit.load_factor
bounded = fo.dissipation_range(
    system, cycle, friction=0.6, load_factor=below, slip_bound=limit.largest_slip
)
cure = fo.limit_after_protocol(
    limit, protocol=[fo.starts.LoadStep({"P": 0.05})], start=bounded.worst_start
)
print(cure)
cure.plot()
