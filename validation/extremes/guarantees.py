"""The guaranteed limit for extreme input, compared with plain linear programs, other units, or `simplify=False`."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

import frictopt as fo
from studies.paper import LOADS
from validation import oracles
from validation.extremes.probes import Answer, Probe

_FEW = 60  # nodes up to which a plain linear program is solved for each
_MANY = 130  # nodes up to which it is solved with nothing left out
_LP, _KEPT, _UNITS = "plain linear program per node, scipy", "nothing left out", "other units"


def _ask(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> Answer:
    limit = fo.guaranteed_limit(system, cycle, friction)
    return Answer.of(limit, limit.load_factor)


def _plain(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """By one program for each node, and the shakedown limit by another."""
    f = np.broadcast_to(friction, system.nodes)
    shakedown = oracles.largest_load_factor(system, cycle, f)
    if shakedown is None or np.isnan(shakedown):
        return shakedown
    least = oracles.least_on_both_bounds(system, cycle, f)
    return None if least is None else min(shakedown, least)


def _kept(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float:
    return float(fo.guaranteed_limit(system, cycle, friction, simplify=False).load_factor)


def _rescaled(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float:
    return _ask(oracles.redescribed(system, force=1e6, length=1e-3), cycle, friction).number


def guaranteed_probe(
    extreme: str,
    value: str,
    make: Callable[[], fo.ContactSystem],
    nodes: int,
    cycle: fo.LoadCycle = LOADS,
    friction: Any = 0.7,
) -> Probe:
    """The guaranteed limit of a contact of so many nodes, which say what it is compared with."""
    known, name = (
        (_plain, _LP)
        if nodes <= _FEW
        else (_kept, _KEPT)
        if nodes <= _MANY
        else (_rescaled, _UNITS)
    )
    ask, expected = (lambda: _ask(make(), cycle, friction)), lambda: known(make(), cycle, friction)
    return Probe(extreme, value, "guaranteed limit", ask, expected, name)


def guaranteed_units() -> Iterator[Probe]:
    """The guaranteed limit in other units."""
    base = fo.scenes.PunchOnHalfPlane(elements=8, grading=5.0, growth=1.5).condense()
    for force in (1e-15, 1.0, 1e15):
        for length in (1e-15, 1e-6, 1e6, 1e15):
            ask, value = (
                partial(_ask, oracles.redescribed(base, force=force, length=length), LOADS, 0.5),
                f"force {force:g}, length {length:g}",
            )
            yield Probe(
                "units",
                value,
                "guaranteed limit",
                ask,
                lambda: _plain(base, LOADS, 0.5),
                f"{_LP}, units of 1",
            )


def guaranteed_corners(
    extreme: str, value: str, system: fo.ContactSystem, cycle: fo.LoadCycle, points: Any
) -> Probe:
    """The guaranteed limit under corners that are these points in the plane of two load cases."""
    hull = fo.LoadCycle(cycle.mean, [cycle.corners[k] for k in ConvexHull(points).vertices])
    ask, plain = partial(_ask, system, cycle, 0.7), partial(_plain, system, hull, 0.7)
    return Probe(
        extreme, value, "guaranteed limit", ask, plain, f"{_LP}, on the convex hull of the corners"
    )
