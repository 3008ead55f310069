"""
Limits against friction
=======================

Compile the problem once, solve it for many coefficients of friction, and compare with the onset of
slip.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=40).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
frictions = np.linspace(0.2, 1.2, 21)

shakedown = fo.ShakedownModel(system, cycle).sweep(frictions)
guaranteed = [fo.guaranteed_limit(system, cycle, f).load_factor for f in frictions]
onset = [fo.onset(system, cycle, f).slip.load_factor for f in frictions]

figure, ax = plt.subplots(layout="constrained")
ax.plot(frictions, shakedown["load_factor"], label=r"shakedown limit $\lambda_2$")
ax.plot(frictions, guaranteed, "--", label=r"guaranteed limit $\lambda_1$")
ax.plot(frictions, onset, ":", label="onset of slip in the bonded contact")
ax.set(
    xlabel="coefficient of friction $f$", ylabel=r"load factor $\sigma / (P / 2a)$", ylim=(0, None)
)
ax.legend()

# %%
# Between the two limits, the residual slip from assembly decides whether the contact stops slipping.
