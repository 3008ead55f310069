"""Limits with open nodes for extreme input.

Each limit is compared with a plain linear program with the same open nodes.
"""

from collections.abc import Iterator
from functools import cache

import numpy as np

import frictopt as fo
from studies.paper import LOADS
from studies.validation import oracles
from studies.validation.extremes.probes import Answer, Probe, Sizes
from studies.validation.open_sets import largest_with_open

_LP = "plain linear program with its open nodes, scipy"


def open_set_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions about limits with open nodes, for a rounded punch of at most 9 nodes."""
    punch = fo.scenes.PunchOnHalfPlane(
        elements=min(8, 3 * sizes.elements // 4), grading=3.0, growth=1.3
    ).condense()
    for size in (1e-6, 1e-3, 1.0, 1e3, 1e6):
        yield _probe("rounding of the edge", f"{size:g}", _rounded(punch, size), 0.6)
    for friction in (1e-3, 0.1, 1.0):
        yield _probe("friction", f"{friction:g}", _rounded(punch, 2.0), friction)
    for force in (1e-15, 1e15):
        for length in (1e-15, 1e15):
            yield _probe(
                "units",
                f"force {force:g}, length {length:g}",
                _rounded(punch, 2.0, force, length),
                0.6,
            )


def _rounded(
    punch: fo.ContactSystem, size: float, force: float = 1.0, length: float = 1.0
) -> fo.ContactSystem:
    """The punch with rounded edges, in other units."""
    gap = size * np.maximum(np.abs(punch.x) - 0.6, 0.0) ** 2
    return oracles.redescribed(punch.with_gap(gap), force=force, length=length)


def _probe(extreme: str, value: str, system: fo.ContactSystem, friction: float) -> Probe:
    """The question about the limit of a system, with the program for its open nodes."""
    limit = cache(lambda: fo.shakedown_limit(system, LOADS, friction))

    def plain() -> float | None:
        opened = np.tile(limit().open, (len(LOADS.corners), 1))
        answer = largest_with_open(system, LOADS, friction, opened, 4 * limit().load_factor)
        return None if answer is None else answer[0]

    return Probe(
        extreme,
        value,
        "limit with open nodes",
        lambda: Answer.of(limit(), limit().load_factor),
        plain,
        _LP,
    )
