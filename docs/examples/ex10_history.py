"""
From a load history to what frets where
=======================================

A blade root carries a measured history of loads. Which nodes slip, how far, and how much work does
friction do there? Lengths are in mm, stresses in MPa.
"""

import matplotlib.pyplot as plt
import pandas as pd

import frictopt as fo

steel = fo.fem.Material(E=210e3, nu=0.3)
sizes = {
    "flank_length": 8.0,
    "neck_half_width": 8.0,
    "neck_height": 16.0,
    "foot_height": 6.0,
    "lug_height": 6.0,
    "edge_length": 1.0,
}
blade = fo.scenes.Dovetail(
    elements=20,
    growth=1.3,
    disc_half_width=40.0,
    disc_depth=40.0,
    blade_material=steel,
    disc_material=steel,
    **sizes,
)
system = blade.condense()
history = pd.DataFrame(
    {"pull": [80.0, 120.0, 90.0, 115.0, 85.0, 100.0], "sway": [-3.0, 4.0, -4.0, 3.0, 0.0, 2.0]}
)
problem = system, fo.LoadCycle.from_history(history, mean={"pull": 100.0}), 0.5, 1.0

steady = fo.steady_state(*problem)
print(steady)
table = steady.fretting_table()
print(
    table.sort_values("work", ascending=False)[
        ["contact", "x", "slip_range", "tau_amplitude", "work", "F1"]
    ].head()
)

# %%

figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
for flank, rows in table.groupby("contact"):
    axes[0].plot(rows["x"], 1e3 * rows["slip_range"], "o-", label=flank)
    axes[1].plot(rows["x"], rows["F1"], "o-")
axes[0].set(ylabel="slip range, um")
axes[1].set(xlabel="arc length, flank after flank, mm", ylabel="Ruiz's first parameter, N/mm")
axes[0].legend()
