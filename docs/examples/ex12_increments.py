"""
One transient, exactly and in increments
========================================

The exact path has no time step. A path in increments has steps, and therefore an error. Each
increment is a cvxpy problem that you can print.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=16).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
problem = system, cycle, 0.7, 2.2
exact = fo.march(*problem, cycles=2).cycle_work.sum(axis=1)[
    1
]  # work of friction in the second cycle

steps = np.array([2, 4, 8, 16])
errors = [
    abs(fo.march(*problem, cycles=2, steps=int(n)).cycle_work.sum(axis=1)[1] / exact - 1)
    for n in steps
]
figure, ax = plt.subplots(layout="constrained")
ax.loglog(steps, errors, "o-")
ax.set(xlabel="increments from corner to corner", ylabel="error of the work of friction")

# %%
# ``explain`` describes one increment, as a convex program with constant friction bounds.

increment = fo.increments.NewtonIncrement(system, friction=0.7)
load = system.reaction({"P": 1.0, "sigma": 3.0})
print(increment.solve(np.zeros(17), load, form="qp").explain())
