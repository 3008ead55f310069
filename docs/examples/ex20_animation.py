"""
A film of a steady cycle
========================

The shear of each node moves between its friction bounds. The colour shows whether the node sticks,
slips or is open.
"""

from pathlib import Path
from tempfile import gettempdir

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

import frictopt as fo

system = fo.scenes.PunchOnHalfPlane(elements=24).condense()
cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
states = fo.steady_state(system, cycle, friction=0.7, load_factor=2.2).states()

# %%
# Between two states the reactions are linear in time, and each node keeps the status that it has at
# the first of the two states.

times = np.linspace(0.0, states.time[-1], 8)
q, p = (
    np.array([np.interp(times, states.time, node) for node in part.T]).T / system.width
    for part in (states.q, states.p)
)
status = states.status[
    np.searchsorted(states.time, times, side="right").clip(1, len(states.time) - 1) - 1
]
colours = np.array(
    ["lightgrey", "tab:blue", "black", "tab:orange"]
)  # of 0 stick, 1 slip +, 2 open, -1 slip -
figure, ax = plt.subplots(layout="constrained")


def draw(frame):
    ax.clear()
    ax.fill_between(
        system.x,
        -states.friction * p[frame],
        states.friction * p[frame],
        color="whitesmoke",
        edgecolor="grey",
    )
    ax.scatter(system.x, q[frame], c=colours[status[frame]], edgecolors="grey", zorder=3)
    ax.set(
        xlabel="$x$ (length)",
        ylabel="shear traction (force per area)",
        ylim=(-2.0, 2.0),
        title=f"{times[frame]:.2f} corners visited",
    )


FuncAnimation(figure, draw, frames=len(times)).save(
    Path(gettempdir()) / "cycle.gif", writer=PillowWriter(fps=4)
)
