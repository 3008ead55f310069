"""
A dovetail root
===============

How much may the pull on a blade vary, for three angles of its flanks? The flanks lock if the friction
is at least the cotangent of their angle.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictopt as fo

fo.scenes.Dovetail(elements=8, growth=1.4).plot()

# %%

cycle = fo.LoadCycle(mean={"pull": 1.0}, corners=[{"pull": 1.0}, {"pull": -1.0}])
shares = np.linspace(0.2, 0.99, 5)  # friction over the cotangent of the angle
figure, ax = plt.subplots(layout="constrained")
for angle in (35, 45, 60):
    system = fo.scenes.Dovetail(angle=angle, elements=6, growth=1.4).condense()
    limits = fo.ShakedownModel(system, cycle).sweep(shares / np.tan(np.radians(angle)))
    ax.plot(shares, limits["load_factor"], "o-", label=f"{angle} degrees")
ax.set(xlabel="friction over the cotangent of the angle", ylabel="amplitude over mean of the pull")
ax.legend()

# sphinx_gallery_thumbnail_number = 2
