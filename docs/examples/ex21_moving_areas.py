"""
Contact areas that move
=======================

The normal load of a cylinder on a half-plane varies, and nodes at the rim open and close in each
cycle. How much shear does the contact bear? It depends on the phase between shear and normal load.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

P = np.pi / 4  # half-width 1 of the contact of a cylinder with R = E* = 1
system = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(20, 1.6, 1.0, R=1.0))


def cycle(phase):
    """Normal load of P +- P / 5, which leads the shear by a phase in degrees."""
    angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    pressed = np.cos(angles + np.deg2rad(phase))
    return fo.LoadCycle(
        {"P": P},
        [{"Q": P * shear} for shear in np.cos(angles)],
        fixed=[{"P": 0.2 * P * part} for part in pressed],
    )


# If the loads are in phase, the limit is Q = f P / 5 (load factor f / 5) on any mesh. It covers all
# states of rest.
in_phase = fo.shakedown_limit(system, cycle(0), friction=0.35)
print(in_phase.load_factor, in_phase.covers)
print(in_phase.events.head())

# Out of phase the limit is 0: the outermost nodes slip in every cycle, however small the shear is.
print(fo.shakedown_limit(system, cycle(45), friction=0.35).reason)

# %%
# The work per cycle shows how little this slip matters at small shears.

shears = np.linspace(0.02, 0.1, 5)
figure, axes = plt.subplots(layout="constrained")
for phase in (0, 10, 45, 90):
    works = [
        fo.steady_state(system, cycle(phase), 0.35, shear, progress=False).dissipation
        for shear in shears
    ]
    axes.plot(shears, works, "o-", label=f"{phase} degrees")
axes.axvline(in_phase.load_factor, color="0.6", label="limit in phase")
axes.set(xlabel="shear Q / P", ylabel="work of a cycle")
axes.legend()
