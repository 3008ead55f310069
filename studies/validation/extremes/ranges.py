"""Questions about all starts, with extreme input.

The questions are the range of dissipation, the least slip, and the limit after a protocol.
"""

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np

import frictopt as fo
from studies.paper import LOADS
from studies.validation.closed_forms import (
    masing_dissipation,
    single_node_dissipation,
    single_node_limit,
)
from studies.validation.extremes.probes import Answer, Probe, Sizes, one_node, punch_in_units

_FRICTION = 0.7


def range_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions about all starts."""
    for part in (_units, _friction, _near_limit, _stiffness, _nodes):
        yield from part(sizes)


def _most(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    unit: float = 1.0,
) -> Answer:
    """The most work of the range, in a unit."""
    span = fo.dissipation_range(system, cycle, friction, load_factor)
    return Answer(span.most / unit, span.residual, "exact paths, linear programs")


def _least(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> Answer:
    """The least work of the range."""
    span = fo.dissipation_range(system, cycle, friction, load_factor)
    return Answer(span.least, span.residual, "exact paths, linear programs")


def _ratio(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, start: Any) -> Answer:
    """The limit after a protocol over the shakedown limit."""
    limit = fo.shakedown_limit(system, cycle, friction)
    after = fo.limit_after_protocol(limit, start=start, scan=5, tolerance=1e-3)
    return Answer(after.ratio, after.residual, "exact paths")


def _units(sizes: Sizes) -> Iterator[Probe]:
    def most(force: float, length: float) -> Answer:
        return _most(
            *punch_in_units(force, length, sizes.unit_elements), _FRICTION, 3.0, force * length
        )

    def ratio(force: float, length: float) -> Answer:
        return _ratio(*punch_in_units(force, length, sizes.unit_elements), _FRICTION, "assembled")

    known = cache(lambda ask: ask(1.0, 1.0).number)
    for force in (1e-15, 1.0, 1e15):
        for length in (1e-15, 1e15):
            value = f"force {force:g}, length {length:g}"
            yield Probe(
                "units",
                value,
                "found range",
                partial(most, force, length),
                partial(known, most),
                "units of 1",
                1e-5,
            )
            yield Probe(
                "units",
                value,
                "limit after a protocol",
                partial(ratio, force, length),
                partial(known, ratio),
                "units of 1",
                1e-3,
            )


def _friction(_: Sizes) -> Iterator[Probe]:
    for f in (1e-6, 1e-3, 0.1, 1.0, 1.9):
        node = 2.0, 0.5, 0.1 * f, 1.0
        system = one_node(2.0, 0.5, 1.125, 0.1 * f, 1.0)
        limit = single_node_limit(*node, 1.0, 0.2, f)
        if f < 1.0:
            closed = partial(single_node_dissipation, *node, 1.0, 0.2, f, 1.2 * limit)
            ask = partial(_most, system, LOADS, f, 1.2 * limit)
            yield Probe(
                "friction",
                f"{f:g}",
                "found range, one node",
                ask,
                closed,
                "closed form, one node",
                floor=1e-12,
            )
        safe = partial(_ratio, system, LOADS, f, fo.shakedown_limit(system, LOADS, f).slip)
        yield Probe(
            "friction",
            f"{f:g}",
            "limit after the safe slip, one node",
            safe,
            lambda: 1.0,
            "definition of the limit",
            1e-2,
        )


def _near_limit(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    limit = fo.shakedown_limit(system, LOADS, _FRICTION)

    def bound(factor: float) -> Answer:
        least = limit.least_slip(factor)
        return Answer(least.bound / limit.load_factor, least.residual, "multipliers of the limit")

    extreme = "load factor over lambda_2, less 1"
    for distance in (-1e-3, -1e-6, 1e-6, 1e-3):
        factor = limit.load_factor * (1 + distance)
        value = f"{distance:+g}"
        # Below the limit some start dissipates nothing.
        rest = (lambda: 0.0) if distance < 0 else None
        yield Probe(
            extreme,
            value,
            "found range, least",
            partial(_least, system, LOADS, _FRICTION, factor),
            rest,
            "a safe slip stays",
        )
        yield Probe(
            extreme,
            value,
            "least slip",
            partial(bound, factor),
            partial(float, distance),
            "definition of the bound",
            1e-5,
        )


def _stiffness(_: Sizes) -> Iterator[Probe]:
    """Questions about sliders in parallel: without coupling all starts dissipate the same work."""
    for ratio in (1e-9, 1e-3, 1e3, 1e9):
        k = np.array([1.0, ratio])
        bound = np.array([0.5, 0.4 * ratio])
        loads = {"P": (np.zeros(2), bound), "sigma": (-0.8 * k, np.zeros(2))}
        system = fo.ContactSystem.from_blocks(
            np.diag(k), np.zeros((2, 2)), np.diag(k), np.arange(2.0), loads
        )
        closed = partial(masing_dissipation, k, bound, 0.8)
        yield Probe(
            "stiffness of one slider over another",
            f"{ratio:g}",
            "found range",
            partial(_most, system, LOADS, 1.0, 1.0),
            closed,
            "closed form",
        )


def _nodes(sizes: Sizes) -> Iterator[Probe]:
    for elements in [number for number in sizes.most_nodes if number <= sizes.most_guaranteed]:
        system = fo.scenes.PunchOnHalfPlane(
            elements=elements, growth=1.5, grading=20.0 if elements > 2 else 1.0
        ).condense()
        factor = 0.9 * fo.shakedown_limit(system, LOADS, _FRICTION).load_factor
        yield Probe(
            "nodes",
            f"{elements + 1}",
            "found range, least",
            partial(_least, system, LOADS, _FRICTION, factor),
            lambda: 0.0,
            "a safe slip stays",
        )
