"""
Below the limit the start decides
=================================

With the same contact and the same load, slip stops from some starts, and never stops from other
starts.
"""

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=16).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])

limit = fo.shakedown_limit(system, cycle, friction=0.7).load_factor
starts = (
    fo.starts.no_slip()
    + fo.starts.safe_slips([1.0, -1.0])
    + fo.starts.overloads([1.5 * limit, 2.0 * limit])
)
starts += fo.starts.random_slips(system, amplitudes=[0.3, 1.0, 3.0], count=6)
loads = [share * limit for share in (0.2, 0.4, 0.6, 0.8, 0.95, 1.05, 1.2)]
table = fo.dissipation_study(
    system, cycle, friction=0.7, load_factors=loads, starts=starts, limits=True
)
fo.plot_study(table)

# %%
# Count the outcomes at each load factor. The table has load factors divided by the shakedown
# limit.

table["of the limit"] = table["load_ratio"].round(2)
print(table.groupby(["of the limit", "outcome"]).size().unstack(fill_value=0))
