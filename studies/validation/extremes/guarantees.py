"""The guaranteed limit for extreme input, compared with plain linear programs, other units, or `simplify=False`."""

from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

import frictopt as fo

from ...paper import LOADS
from .. import oracles
from .probes import SHEAR, Answer, Probe, Sizes, loose, nearly_separated

_FEW = 60  # nodes up to which a plain linear program is solved for each
_MANY = 130  # nodes up to which it is solved with nothing left out
_LP, _KEPT, _UNITS = "plain linear program per node, scipy", "nothing left out", "other units"


def guarantee_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions about the guaranteed limit."""
    for part in (_friction, _stiffness, _grading, _unit, _free_punch, _separation, _nodes, _corners):
        yield from part(sizes)


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


def _probe(extreme: str, value: str, make: Callable[[], fo.ContactSystem], nodes: int, cycle: fo.LoadCycle = LOADS, friction: Any = 0.7) -> Probe:
    known, name = (_plain, _LP) if nodes <= _FEW else (_kept, _KEPT) if nodes <= _MANY else (_rescaled, _UNITS)
    ask, expected = (lambda: _ask(make(), cycle, friction)), lambda: known(make(), cycle, friction)
    return Probe(extreme, value, "guaranteed limit", ask, expected, name)


def _given(system: fo.ContactSystem) -> Callable[[], fo.ContactSystem]:
    return lambda: system


def _friction(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    for f in (0.0, 1e-6, 1e-3, 0.1, 0.7, 1.5, 3.0, 10.0):
        yield _probe("friction", f"{f:g}", _given(system), system.nodes, friction=f)


def _stiffness(sizes: Sizes) -> Iterator[Probe]:
    for ratio in (1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12):
        scene = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3, punch_material=fo.Material(ratio))
        yield _probe("stiffness of the punch over that of the block", f"{ratio:g}", cache(scene.condense), sizes.elements + 1)


def _grading(sizes: Sizes) -> Iterator[Probe]:
    for grading in sizes.gradings:
        scene = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.5, grading=grading)
        yield _probe("grading of the contact", f"{grading:g}", cache(scene.condense), sizes.elements + 1)


def _unit(sizes: Sizes) -> Iterator[Probe]:
    base = fo.scenes.PunchOnHalfPlane(elements=8, grading=5.0, growth=1.5).condense()
    for force in (1e-15, 1.0, 1e15):
        for length in (1e-15, 1e-6, 1e6, 1e15):
            ask, value = partial(_ask, oracles.redescribed(base, force=force, length=length), LOADS, 0.5), f"force {force:g}, length {length:g}"
            yield Probe("units", value, "guaranteed limit", ask, lambda: _plain(base, LOADS, 0.5), f"{_LP}, units of 1")


def _free_punch(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    extreme = "punch held by its loads alone"
    for f in (0.1, 1.0):
        yield _probe(extreme, f"f = {f:g}", _given(system), system.nodes, SHEAR, f)
    yield _probe(extreme, "A = 0", loose, 2, friction=0.5)


def _separation(sizes: Sizes) -> Iterator[Probe]:
    system, cycles = nearly_separated(sizes.elements)
    for left, cycle in cycles.items():
        yield _probe("pressure that the mean load leaves at one node, relative", left, _given(system), system.nodes, cycle)


def _nodes(sizes: Sizes) -> Iterator[Probe]:
    for elements in (n for n in sizes.most_nodes if n <= sizes.most_guaranteed):
        scene = fo.scenes.PunchOnHalfPlane(elements=elements, growth=1.5, grading=20.0 if elements > 2 else 1.0)
        yield _probe("nodes", f"{elements + 1}", cache(scene.condense), elements + 1)


def _corners(sizes: Sizes) -> Iterator[Probe]:
    rng = np.random.default_rng(0)
    system = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.3).condense()
    points = rng.normal(size=(sizes.corners, 2))
    cycle, hull = (fo.LoadCycle({"P": 1.0}, [{"sigma": float(a), "Q": 0.1 * float(b)} for a, b in some]) for some in (points, _hull(points)))
    ask, plain = partial(_ask, system, cycle, 0.7), partial(_plain, system, hull, 0.7)
    yield Probe("corners of the load cycle", f"{sizes.corners:,}", "guaranteed limit", ask, plain, f"{_LP}, on the convex hull of the corners")


def _hull(points: Any) -> Any:
    return points[ConvexHull(points).vertices]
