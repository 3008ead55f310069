"""The guaranteed limit for extreme input.

Each limit is compared with plain linear programs, or with the limit in other units or without
simplification.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

import frictopt as fo
from studies.paper import LOADS
from studies.validation import oracles
from studies.validation.extremes.probes import Answer, Probe

# Largest number of nodes for which a plain linear program is solved for each node.
_FEW = 60
# Largest number of nodes for which the limit is computed without simplification.
_MANY = 130
_LP = "plain linear program per node, scipy"
_KEPT = "nothing left out"
_UNITS = "other units"


def _limit(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> Answer:
    limit = fo.guaranteed_limit(system, cycle, friction)
    return Answer.of(limit, limit.load_factor)


def _plain(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """The limit by plain linear programs: one for each node, and one for the shakedown limit."""
    f = np.broadcast_to(friction, system.nodes)
    shakedown = oracles.largest_load_factor(system, cycle, f)
    if shakedown is None or np.isnan(shakedown):
        return shakedown
    least = oracles.least_on_both_bounds(system, cycle, f)
    return None if least is None else min(shakedown, least)


def _unsimplified(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float:
    return float(fo.guaranteed_limit(system, cycle, friction, simplify=False).load_factor)


def _rescaled(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float:
    return _limit(oracles.redescribed(system, force=1e6, length=1e-3), cycle, friction).number


def guaranteed_probe(
    extreme: str,
    value: str,
    make: Callable[[], fo.ContactSystem],
    nodes: int,
    cycle: fo.LoadCycle = LOADS,
    friction: Any = 0.7,
) -> Probe:
    """The question about the guaranteed limit of a contact.

    The number of nodes determines the reference.
    """
    known: Callable[..., float | None]
    if nodes <= _FEW:
        known, reference = _plain, _LP
    elif nodes <= _MANY:
        known, reference = _unsimplified, _KEPT
    else:
        known, reference = _rescaled, _UNITS
    return Probe(
        extreme,
        value,
        "guaranteed limit",
        lambda: _limit(make(), cycle, friction),
        lambda: known(make(), cycle, friction),
        reference,
    )


def guaranteed_units() -> Iterator[Probe]:
    """The guaranteed limit in other units."""
    base = fo.scenes.PunchOnHalfPlane(elements=8, grading=5.0, growth=1.5).condense()
    for force in (1e-15, 1.0, 1e15):
        for length in (1e-15, 1e-6, 1e6, 1e15):
            system = oracles.redescribed(base, force=force, length=length)
            yield Probe(
                "units",
                f"force {force:g}, length {length:g}",
                "guaranteed limit",
                partial(_limit, system, LOADS, 0.5),
                lambda: _plain(base, LOADS, 0.5),
                f"{_LP}, units of 1",
            )


def guaranteed_corners(
    extreme: str, value: str, system: fo.ContactSystem, cycle: fo.LoadCycle, points: Any
) -> Probe:
    """The question about the guaranteed limit under a cycle with many corners.

    The corners are `points` in the plane of two load cases. The reference has the corners on their
    convex hull.
    """
    hull = fo.LoadCycle(cycle.mean, [cycle.corners[k] for k in ConvexHull(points).vertices])
    return Probe(
        extreme,
        value,
        "guaranteed limit",
        partial(_limit, system, cycle, 0.7),
        partial(_plain, system, hull, 0.7),
        f"{_LP}, on the convex hull of the corners",
    )
