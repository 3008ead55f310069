"""
The best crown of a punch
=========================

How much material should be taken off a face, and where, so that slip can stop up to the largest
possible load? One convex program finds and proves the answer.
"""

import cvxpy as cp
import matplotlib.pyplot as plt

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=40).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
model = fo.DesignModel(system, cycle, profile=True)
depth = cp.Parameter(nonneg=True)
bounds = [model.profile >= 0, (model.profile <= depth).set_label("depth")]

depths, limits = [0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5], []
for depth.value in depths:
    design = model.solve(0.5, bounds)
    limits.append(design.load_factor)

figure, ax = plt.subplots(layout="constrained")
ax.plot(depths, limits, "o-")
ax.set(xlabel="largest depth", ylabel=r"shakedown limit $\lambda_2$")

# %%
# The design with its profile is a contact like any other. The price of the constraint "depth" is
# the gain of the limit per unit of depth.

print(design, design.prices["depth"].sum())
print(fo.guaranteed_limit(design.system, design.cycle, 0.5))
design.plot()
