"""
A pin that creeps round
=======================

A pin is shrunk into a plate, and the direction of the force on the pin rotates. Above the shakedown
limit the pin does not only slip: it turns a little in each cycle.
"""

import numpy as np

import frictopt as fo

scene = fo.scenes.PinInPlate(elements=40, growth=1.3)
system = scene.condense()
fit = 2 * np.pi / system.bonded["fit"][1].sum()  # a mean pressure of one
turns = 2 * np.pi * np.arange(8) / 8
cycle = fo.LoadCycle({"fit": fit}, [{"Fx": np.cos(turn), "Fy": np.sin(turn)} for turn in turns])

limit = fo.shakedown_limit(system, cycle, friction=0.2).load_factor
for load_factor in (0.9 * limit, 1.2 * limit):
    steady = fo.steady_state(system, cycle, friction=0.2, load_factor=load_factor)
    print(
        f"{load_factor:.3f}: {steady.outcome.name}, work of friction {steady.dissipation:.3g} a cycle"
    )

# %%
# The slip of all nodes grows by the same amount in each cycle.

path = fo.march(system, cycle, friction=0.2, load_factor=1.2 * limit, cycles=6)
path.plot()
