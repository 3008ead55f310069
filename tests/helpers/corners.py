"""Corners at which a load does not turn."""

import numpy as np

import frictopt as fo
from helpers.systems import unit_nodes


def left_out(cycle, load_factor=1.0):
    """The number of corners that a transient under a load cycle leaves out."""
    names = {name for loads in (cycle.mean, *cycle.corners, *(cycle.fixed or ())) for name in loads}
    loads = {name: (np.zeros(1), np.zeros(1)) for name in names}
    loads["pressing"] = np.zeros(1), np.ones(1)
    node = unit_nodes(loads)
    pressed = fo.LoadCycle({**cycle.mean, "pressing": 1.0}, cycle.corners, cycle.fixed)
    notes = fo.steady_state(node, pressed, 0.5, load_factor).record.left_out
    return sum(int(note.split()[1]) for note in notes if note.startswith("corners: "))
