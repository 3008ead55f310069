"""The corners of a load cycle at which the load path turns; a corner on the straight segment between its neighbours is left out."""

from collections.abc import Sequence

import numpy as np

from ...contact import LoadCycle
from ...contact.history import turning_points

__all__ = ["left_out_corners", "turning_corners"]


def turning_corners(cycle: LoadCycle) -> list[int]:
    """Numbers of the corners at which the load changes its direction, the first and the last one in any case, see `turning_points`."""
    cases = sorted({case for corner in cycle.corners for case in corner})
    return turning_points(np.array([[corner.get(case, 0.0) for case in cases] for corner in cycle.corners]))


def left_out_corners(stops: Sequence[int], corners: int) -> tuple[str, ...]:
    """Sentences that say how many corners are left out."""
    if len(stops) == corners:
        return ()
    return (f"corners: {corners - len(stops)} of {corners} are on the straight segment between others, and no stops",)
