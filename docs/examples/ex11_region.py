"""
Two loads that vary independently
=================================

A pin is shrunk into a plate. The tension of the plate and the force on the pin vary independently:
which amplitudes leave a safe slip?
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

system = fo.scenes.PinInPlate(elements=40, growth=1.3).condense()
fit = {"fit": 2 * np.pi / system.bonded["fit"][1].sum()}  # a mean pressure of one

figure, ax = plt.subplots(layout="constrained")
for friction in (0.3, 0.2, 0.1):
    region = fo.safe_region(system, fit, ("sigma", "Fx"), friction)
    ax.fill(*zip((0, 0), *region.vertices, strict=True), label=f"f = {friction}")
    print(friction, region)
ax.set(
    xlabel="amplitude of the tension over the mean pressure",
    ylabel="amplitude of the force",
    xlim=(0, None),
    ylim=(0, None),
)
ax.legend()

# %%
# Each side of a polygon belongs to a slip mechanism, and is proven. Which nodes govern the
# amplitudes for the lowest friction, f = 0.1?

region.plot()

# %%
# How much friction does one pair of amplitudes require, and where?

required = fo.required_friction(system, region.cycle(0.2, 1.0), load_factor=1.0)
print(required)
required.plot()
