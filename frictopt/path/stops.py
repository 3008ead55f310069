"""The corners of a load cycle at which the load path turns; a corner on the straight segment between its neighbours is left out."""

from collections.abc import Sequence

import numpy as np

from ..contact import LoadCycle

__all__ = ["left_out_corners", "turning_corners"]

_ROUNDING = 4 * np.finfo(float).eps  # distance from the straight segment, over the largest amplitude of the load case, that counts as rounding


def turning_corners(cycle: LoadCycle) -> list[int]:
    """Numbers of the corners at which the load changes its direction, the first and the last one in any case.

    A corner is left out only if it lies on the straight segment between its neighbours in every load case. Each load case is measured by its own
    largest amplitude, so other units give the same corners. A corner at which the load turns back stays.
    """
    cases = sorted({case for corner in cycle.corners for case in corner})
    loads = np.array([[corner.get(case, 0.0) for case in cases] for corner in cycle.corners])
    largest = np.abs(loads).max(axis=0, initial=0.0)
    loads = loads / np.where(largest > 0, largest, 1.0)
    kept, last = [0], len(loads) - 1
    for number in range(1, last):
        segment, part = loads[number + 1] - loads[kept[-1]], loads[number] - loads[kept[-1]]
        length = float(segment @ segment)
        share = float(part @ segment) / length if length > 0 else 0.0
        if not (0 <= share <= 1 and np.abs(part - share * segment).max(initial=0.0) <= _ROUNDING):
            kept.append(number)
    return [*kept, last] if last > 0 else kept


def left_out_corners(stops: Sequence[int], corners: int) -> tuple[str, ...]:
    """Sentences that say how many corners are left out."""
    if len(stops) == corners:
        return ()
    return (f"corners: {corners - len(stops)} of {corners} are on the straight segment between others, and no stops",)
