"""Questions with extreme input, each with an independently known answer."""

from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.transients.exact import ExactPath
from studies.paper import LOADS
from studies.validation import oracles
from studies.validation.closed_forms import single_node_limit
from studies.validation.extremes.designs import design_probes
from studies.validation.extremes.guarantees import (
    guaranteed_corners,
    guaranteed_probe,
    guaranteed_units,
)
from studies.validation.extremes.open_sets import open_set_probes
from studies.validation.extremes.probes import (
    SHEAR,
    Answer,
    Probe,
    Sizes,
    loose,
    nearly_separated,
    one_node,
    punch_in_units,
    shakedown,
)
from studies.validation.extremes.ranges import range_probes
from studies.validation.extremes.space import space_probes

_LP = "plain linear program, scipy"
_DRIFT = 1e-9
# Largest number of elements for which the plain linear program is solved. It takes minutes for more
# elements.
_DENSE = 300


def probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions of the study."""
    of_this_file = (
        _friction,
        _stiffness,
        _surface,
        _poisson,
        _grading,
        _unit,
        _near_limit,
        _free_punch,
        _critical,
        _separation,
        _nodes,
        _corners,
        _cycles,
    )
    for part in (*of_this_file, open_set_probes, range_probes, design_probes, space_probes):
        yield from part(sizes)


def _steady(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    start: Any = None,
) -> Answer:
    """The work of the steady state."""
    steady = fo.steady_state(system, cycle, friction, load_factor, initial_slip=start)
    return Answer(steady.dissipation, steady.residual, "exact path")


def _work_unit(system: fo.ContactSystem, cycle: fo.LoadCycle) -> float:
    return float(np.prod(oracles.units(system, cycle)))


def _work_of_last(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    cycles: int = 100,
) -> float | None:
    """Work of the last of many cycles; None if it still changes."""
    path = fo.march(system, cycle, friction, load_factor, cycles=cycles)
    *_, before, last = path.cycle_work.sum(axis=1)
    return float(last) if abs(last - before) <= 1e-10 * _work_unit(system, cycle) else None


def _steady_probe(
    extreme: str,
    value: str,
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
) -> Probe:
    """The question about a steady state."""
    return Probe(
        extreme,
        value,
        "steady state",
        partial(_steady, system, cycle, friction, load_factor),
        partial(_work_of_last, system, cycle, friction, load_factor),
        "100 cycles followed",
        floor=1e-2 * _work_unit(system, cycle),
    )


def _limit_probe(
    extreme: str, value: str, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> Probe:
    """The question about a shakedown limit with all nodes closed, as in the plain program."""
    limit = partial(shakedown, system, cycle, friction, np.zeros(system.nodes, dtype=bool))
    plain = partial(_plain, system, cycle, friction)
    return Probe(extreme, value, "shakedown limit", limit, plain, _LP)


def _exists(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> Answer:
    """Whether a safe slip exists, as 1 or 0."""
    safe = fo.safe_slip(system, cycle, friction, load_factor)
    return Answer.of(safe, float(safe.exists))


def _increment(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> Answer:
    """A weighted sum of the shear forces after an increment to the second corner."""
    load = oracles.corner_loads(system, cycle, load_factor)[1][1]
    engine = fo.increments.NewtonIncrement(system, friction)
    increment = engine.solve(np.zeros(system.nodes), np.split(load, 2))
    weighted_sum = float(increment.q @ np.arange(1, system.nodes + 1))
    force = oracles.units(system, cycle)[0]
    return Answer(weighted_sum / force, increment.residual, increment.record.solver)


def _all_statuses(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> float | None:
    """The same weighted sum by trying all combinations of statuses; None without a unique state."""
    n = system.nodes
    load = oracles.corner_loads(system, cycle, load_factor)[1][1]
    stepper = oracles.Stepper(system, cycle, np.broadcast_to(friction, n))
    states = stepper.states(np.zeros(n), load)
    if len(states) != 1:
        return None
    _, forces = states[0]
    return float(forces[:n] @ np.arange(1, n + 1))


def _plain(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    return oracles.largest_load_factor(system, cycle, np.broadcast_to(friction, system.nodes))


def _friction(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    small = fo.scenes.PunchOnHalfPlane(elements=2, growth=1.3).condense()
    for f in (0.0, 1e-6, 1e-3, 0.1, 0.7, 1.5, 3.0, 10.0):
        yield _limit_probe("friction", f"{f:g}", system, LOADS, f)
        yield guaranteed_probe("friction", f"{f:g}", lambda: system, system.nodes, friction=f)
        yield _steady_probe("friction", f"{f:g}", system, LOADS, f, 3.0)
        yield Probe(
            "friction",
            f"{f:g}",
            "increment",
            partial(_increment, small, LOADS, f, 3.0),
            partial(_all_statuses, small, LOADS, f, 3.0),
            "all statuses tried",
        )


def _scene_probes(
    extreme: str, value: str, scene: fo.scenes.PunchOnHalfPlane, most_guaranteed: int
) -> Iterator[Probe]:
    """Questions about the balance of the condensed reactions, and about the limits."""
    system = cache(scene.condense)

    def balance() -> Answer:
        width = 2 * scene.half_width
        shear = float(-system().bonded["Q"][0].sum() / width)
        error_of_pressure = float(abs(system().bonded["P"][1].sum() / width - 1))
        return Answer(shear, error_of_pressure, "SuperLU")

    yield Probe(extreme, value, "condensation", balance, lambda: 1.0, "equilibrium of the punch")
    plain = (lambda: _plain(system(), LOADS, 0.7)) if scene.elements <= _DENSE else None
    yield Probe(
        extreme, value, "shakedown limit", lambda: shakedown(system(), LOADS, 0.7), plain, _LP
    )
    if scene.elements <= most_guaranteed:
        yield guaranteed_probe(extreme, value, system, scene.elements + 1)


def _stiffness(sizes: Sizes) -> Iterator[Probe]:
    for ratio in (1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12):
        scene = fo.scenes.PunchOnHalfPlane(
            elements=sizes.elements, growth=1.3, punch_material=fo.fem.Material(ratio)
        )
        yield from _scene_probes(
            "stiffness of the punch over that of the block",
            f"{ratio:g}",
            scene,
            sizes.most_guaranteed,
        )


def _surface(sizes: Sizes) -> Iterator[Probe]:
    scene = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3)
    system = scene.condense()
    for ratio in (1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12):
        stiffness = ratio * float(system.E_star or np.nan) / scene.half_width
        soft = system.with_contact_stiffness(tangential=stiffness, normal=stiffness)
        for cycle, load in ((LOADS, "stretched"), (SHEAR, "sheared")):
            yield _limit_probe(
                "stiffness of the surface over E* / a", f"{ratio:g}, {load}", soft, cycle, 0.7
            )
        yield _steady_probe(
            "stiffness of the surface over E* / a", f"{ratio:g}", soft, LOADS, 0.7, 3.0
        )


def _poisson(sizes: Sizes) -> Iterator[Probe]:
    def scene(nu: float, element: Any) -> fo.scenes.PunchOnHalfPlane:
        material = fo.fem.Material(nu=nu)
        return fo.scenes.PunchOnHalfPlane(
            elements=sizes.elements,
            growth=1.3,
            punch_material=material,
            block_material=material,
            element=element,
        )

    base = shakedown(scene(0.1, "mean_dilatation").condense(), LOADS, 0.7).number
    for element in ("linear", "mean_dilatation"):
        for nu in (-0.9, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999):
            ask = partial(
                lambda nu, element: shakedown(scene(nu, element).condense(), LOADS, 0.7),
                nu,
                element,
            )
            known = "that of nu = 0.1, since stresses of similar bodies do not depend on nu: the error is that of the mesh"
            yield Probe(
                "Poisson's ratio",
                f"{nu:g}",
                f"shakedown limit, element {element}",
                ask,
                lambda: base,
                known,
                np.inf,
            )


def _grading(sizes: Sizes) -> Iterator[Probe]:
    for grading in sizes.gradings:
        scene = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.5, grading=grading)
        yield from _scene_probes(
            "grading of the contact", f"{grading:g}", scene, sizes.most_guaranteed
        )


def _unit(sizes: Sizes) -> Iterator[Probe]:
    def work(force: float, length: float) -> Answer:
        answer = _steady(*punch_in_units(force, length), 0.7, 3.0)
        return Answer(answer.number / (force * length), answer.residual, answer.solver)

    def limit(force: float, length: float) -> Answer:
        return shakedown(*punch_in_units(force, length), 0.7)

    for force in (1e-15, 1.0, 1e15):
        for length in (1e-15, 1e-6, 1e6, 1e15):
            value = f"force {force:g}, length {length:g}"
            yield Probe(
                "units",
                value,
                "shakedown limit",
                partial(limit, force, length),
                lambda: limit(1.0, 1.0).number,
                "units of 1",
            )
            yield Probe(
                "units",
                value,
                "steady state",
                partial(work, force, length),
                lambda: work(1.0, 1.0).number,
                "units of 1",
            )
    yield from guaranteed_units()


def _near_limit(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    limit = fo.shakedown_limit(system, LOADS, 0.7)
    extreme = "load factor over lambda_2, less 1"
    for distance in (-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3):
        factor = limit.load_factor * (1 + distance)
        value = f"{distance:+g}"
        yield Probe(
            extreme,
            value,
            "safe slip",
            partial(_exists, system, LOADS, 0.7, factor),
            partial(float, distance < 0),
            "definition of the limit",
        )
        yield _steady_probe(extreme, value, system, LOADS, 0.7, factor)
        start = fo.safe_slip(system, LOADS, 0.7, factor).slip if distance < 0 else limit.slip
        yield Probe(
            extreme,
            value,
            "steady state from the safe slip",
            partial(_steady, system, LOADS, 0.7, factor, start),
            (lambda: 0.0) if distance < 0 else None,
            "a safe slip stays",
        )


def _free_punch(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=sizes.elements, growth=1.3).condense()
    extreme = "punch held by its loads alone"
    for f in (0.1, 1.0):
        yield _limit_probe(extreme, f"f = {f:g}", system, SHEAR, f)
        over = partial(_steady, system, SHEAR, f, 1.5 * f)
        yield Probe(
            extreme,
            f"f = {f:g}",
            "steady state beyond gross slip",
            over,
            None,
            "none: it slides away",
        )
        yield guaranteed_probe(extreme, f"f = {f:g}", lambda: system, system.nodes, SHEAR, f)
    yield _limit_probe(extreme, "A = 0", loose(), LOADS, 0.5)
    yield guaranteed_probe(extreme, "A = 0", loose, 2, friction=0.5)


def _critical(_: Sizes) -> Iterator[Probe]:
    system = one_node(1.0, 0.5, 1.0, 0.1, 1.0)
    for distance in (-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-3):
        f = 2.0 * (1 + distance)
        value = f"{distance:+g}"
        expected: Callable[[], float | None] = partial(_plain, system, LOADS, f)
        reference = _LP
        if distance < 0:
            expected = partial(single_node_limit, 1.0, 0.5, 0.1, 1.0, 1.0, 0.2, f)
            reference = "closed form, one node"
        yield Probe(
            "friction over its critical value, less 1",
            value,
            "shakedown limit",
            partial(shakedown, system, LOADS, f),
            expected,
            reference,
        )
        yield _steady_probe(
            "friction over its critical value, less 1", value, system, LOADS, f, 5.0
        )


def _separation(sizes: Sizes) -> Iterator[Probe]:
    system, cycles = nearly_separated(sizes.elements)
    for left, cycle in cycles.items():
        name = "pressure that the mean load leaves at one node, relative"
        yield _limit_probe(name, left, system, cycle, 0.7)
        yield _steady_probe(name, left, system, cycle, 0.7, 3.0)
        yield guaranteed_probe(name, left, lambda: system, system.nodes, cycle)
    for p0 in (1e-6, 1e-9, 1e-12):
        node = one_node(2.0, 0.5, 1.0, 0.1 * p0, p0)
        closed = partial(single_node_limit, 2.0, 0.5, 0.1 * p0, p0, 1.0, 0.2, 0.4)
        ask = partial(shakedown, node, LOADS, 0.4)
        yield Probe(
            "mean pressure over cyclic shear, one node",
            f"{p0:g}",
            "shakedown limit",
            ask,
            closed,
            "closed form, one node",
            floor=0.0,
        )


def _nodes(sizes: Sizes) -> Iterator[Probe]:
    for elements in sizes.most_nodes:
        scene = fo.scenes.PunchOnHalfPlane(
            elements=elements, growth=1.5, grading=20.0 if elements > 2 else 1.0
        )
        yield from _scene_probes("nodes", f"{elements + 1}", scene, sizes.most_guaranteed)


def _corners(sizes: Sizes) -> Iterator[Probe]:
    rng = np.random.default_rng(0)
    system = fo.scenes.PunchOnHalfPlane(elements=16, growth=1.3).condense()
    points = rng.normal(size=(sizes.corners, 2))
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": float(a), "Q": 0.1 * float(b)} for a, b in points])
    extreme = "corners of the load cycle"
    value = f"{sizes.corners:,}"
    yield _limit_probe(extreme, value, system, cycle, 0.7)
    yield Probe(
        extreme,
        value,
        "steady state",
        partial(_steady, system, cycle, 0.7, 1.0),
        partial(_work_of_last, system, cycle, 0.7, 1.0, 6),
        "6 cycles followed",
    )
    yield guaranteed_corners(extreme, value, system, cycle, points)


def _cycles(sizes: Sizes) -> Iterator[Probe]:
    system = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.5, grading=5.0).condense()
    limit = fo.shakedown_limit(system, LOADS, 0.7).load_factor

    def last_work() -> Answer:
        path = ExactPath(system, LOADS, 0.7, 1.4 * limit).start()
        for _ in range(sizes.cycles):
            path.state.work[:] = 0.0
            path.follow(path.segments)
        drift = path.state.r - path.bonded - path.system.S @ path.state.u
        return Answer(
            float(path.state.work.sum()), float(np.abs(drift).max() / path.force), "exact path"
        )

    steady = partial(_steady, system, LOADS, 0.7, 1.4 * limit)
    yield Probe(
        "cycles followed",
        f"{sizes.cycles:,}",
        "work of the last cycle",
        last_work,
        lambda: steady().number,
        "steady state",
        _DRIFT,
    )
