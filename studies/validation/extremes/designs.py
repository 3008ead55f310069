"""The best profile for extreme input.

A plain linear program computes the limit of the contact with the profile built in, for the nodes that
the design leaves open.
"""

from collections.abc import Iterator
from functools import cache

import cvxpy as cp

import frictopt as fo
from studies.paper import LOADS
from studies.validation import oracles
from studies.validation.extremes.probes import Answer, Probe, Sizes
from studies.validation.stays_open import interval_of_set

_LP = "plain linear program with the design built in, scipy"


def design_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions about the best profile of the paper's punch.

    Depths of profiles are in units of width times mean pressure over stiffness.
    """
    punch = fo.scenes.PunchOnHalfPlane(elements=min(16, sizes.elements), growth=1.3)
    system = punch.condense()
    for depth in (0.0, 1e-9, 1e-3, 1.0, 1e3, 1e6):
        yield _probe("depth of a profile", f"{depth:g}", system, 0.5, depth)
    for friction in (1e-3, 0.1, 1.5, 3.0):
        yield _probe("friction of a design", f"f = {friction:g}", system, friction, 0.1)
    for force in (1e-15, 1e15):
        for length in (1e-15, 1e15):
            yield _probe(
                "units of a design",
                f"force {force:g}, length {length:g}",
                oracles.redescribed(system, force=force, length=length),
                0.5,
                0.1 * length,
            )


def _probe(
    extreme: str, value: str, system: fo.ContactSystem, friction: float, depth: float
) -> Probe:
    """The question about the best profile up to a depth."""

    @cache
    def design() -> fo.results.Design:
        model = fo.DesignModel(system, LOADS, profile=True)
        return model.solve(friction, [cp.abs(model.profile) <= depth])

    def plain() -> float | None:
        found = interval_of_set(design().system, design().cycle, friction, design().opens[0])
        return None if found is None else found[1]

    return Probe(
        extreme,
        value,
        "best profile",
        lambda: Answer.of(design(), design().load_factor),
        plain,
        _LP,
    )
