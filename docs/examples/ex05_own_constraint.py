"""
A user constraint
=================

The limits are cvxpy problems in your units. You can add constraints that state what you know of the
joint: here, how much slip its assembly can leave.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=40).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
model = fo.ShakedownModel(system, cycle)

free = model.solve(0.7)
bounds = np.ptp(free.slip) * np.linspace(0.02, 1.2, 15)
limits = [
    model.solve(0.7, constraints=[model.slip <= bound, model.slip >= -bound]).load_factor
    for bound in bounds
]

figure, ax = plt.subplots(layout="constrained")
ax.plot(bounds, limits, "o-", label="slip within the bound")
ax.axhline(free.load_factor, linestyle="--", color="black", label="any slip")
ax.set(xlabel="largest residual slip", ylabel=r"shakedown limit $\lambda_2$")
ax.legend()

# %%
# The proof of each limit includes your constraints; ``explain`` names the active constraints.

print(model.solve(0.7, constraints=[model.slip <= bounds[0]]).explain())
