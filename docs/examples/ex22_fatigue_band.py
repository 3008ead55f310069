"""
The fatigue band
================

A dovetail that has come to rest still fatigues. How fast it fatigues depends on the residual slip
that assembly has left. Which values may a fatigue parameter have, over all states of rest?
"""

import matplotlib.pyplot as plt

import frictopt as fo

model = fo.scenes.Dovetail(elements=8, growth=1.4, grading=2.0, edge_radius=2.0).model()
cycle = fo.LoadCycle(mean={"pull": 1.0}, corners=[{"pull": 1.0}, {"pull": -1.0}])

# Below the face of the disc the band converges with the mesh. On the face (depth=0) the largest
# value grows with each refinement.
stresses = model.stress_map(depth=0.1, side=2)
band = fo.fatigue_band(stresses, cycle, friction=0.7, load_factor=0.2)
print(band.reason)

# %%
# Both ends of the band occur: a transient that starts with the residual slip of an end stays at rest.

for slip in (band.least_slip, band.worst_slip):
    steady = fo.steady_state(stresses.system, cycle, 0.7, 0.2, initial_slip=slip)
    print(steady.outcome.name, band.at(steady.slip).max())

# %%
# The picture shows the band on both flanks, node by node from the bottom of the right flank.

table = band.to_frame()
figure, axes = plt.subplots(layout="constrained")
axes.fill_between(table["point"], table["least"], table["most"], alpha=0.25, label="all rests")
axes.plot(table["point"], band.at(band.least_slip), "o-", label="least largest value")
axes.set(xlabel="node", xticks=table["point"], ylabel="SWT at a depth of 0.1 in the disc")
axes.legend()

# %%
# On the plane with the largest value, the normal stress of a cycle goes from `from` to `to`. Residual
# slip adds the same stress to both, so their difference is the same in all states of rest.

worst = table.loc[table["most"].idxmax()]
print(worst[["from_least", "to_least", "from_most", "to_most"]])
