"""Transients and steady states above the shakedown limit: the exact path, engines in increments, and Lemke's method."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import frictopt as fo

from ...paper import LOADS
from .lemke import Lemke
from .methods import Method, Question, installed
from .parameters import Parameters
from .scenes import CYLINDER, CYLINDER_LOADS, SHEAR, Scene, cylinder

Array = np.ndarray[Any, Any]

CYCLES = 2
"""Cycles of a transient; the work in the last one is asked for."""
_STEPS = "increments from corner to corner"


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """Work in the second cycle, and in the steady one, on one mesh."""
    yield _transient(parameters, scene, elements)
    yield _steady(parameters, scene)


def cylinders(parameters: Parameters) -> Iterator[Question]:
    """The same two on a scene with a closed form, over its number of cells."""
    exact = CYLINDER.dissipation(SHEAR)

    def followed(cells: int) -> fo.results.Trajectory:
        path: fo.results.Trajectory = fo.march(cylinder(cells), CYLINDER_LOADS, CYLINDER.f, SHEAR, cycles=CYCLES)
        return path

    def proven(cells: int) -> fo.results.SteadyState:
        steady: fo.results.SteadyState = fo.steady_state(cylinder(cells), CYLINDER_LOADS, CYLINDER.f, SHEAR)
        return steady

    def methods(run: Any, work: Any) -> list[Method]:
        def method(cells: int) -> Method:
            return Method("frictopt", "cells", f"{cells}", partial(run, cells), lambda made: abs(work(made) / exact - 1), lambda made: made.residual)

        return [method(cells) for cells in parameters.cells]

    reference = "closed form of Cattaneo and Mindlin"
    yield Question("transient", "work in the second cycle", "cylinder on a half-plane", 0, reference, methods(followed, last_work))
    yield Question("steady state", "work in a cycle", "cylinder on a half-plane", 0, reference, methods(proven, lambda state: state.dissipation))


def start_slip(parameters: Parameters, system: fo.ContactSystem) -> Array:
    """(N,) initial slip: random coefficients of the six lowest Chebyshev polynomials, times the slip scale of the study."""
    modes = np.polynomial.chebyshev.chebvander(system.x / system.x[-1], 6)[:, 1:]
    return np.asarray(parameters.start * modes @ np.random.default_rng(parameters.seed).normal(size=modes.shape[1]))


def _transient(parameters: Parameters, scene: Scene, elements: int) -> Question:
    system, friction, factor = scene.system, parameters.friction, parameters.overload * scene.limit
    march = partial(fo.march, system, LOADS, friction, factor, cycles=CYCLES)
    exact = last_work(march())

    def error(work: float) -> float:
        return abs(work / exact - 1)

    def ours(engine: str, steps: int) -> Method:
        run = partial(march, engine=engine, steps=steps)
        return Method(f"frictopt, {engine}", _STEPS, f"{steps}", run, lambda made: error(last_work(made)), lambda made: made.residual)

    methods = [Method("frictopt, exact path", "none", "events", march, _energy_error, lambda made: made.residual)]
    methods += [ours("qp", steps) for steps in parameters.steps]
    methods += [ours("milp", steps) for steps in parameters.milp_steps if elements in parameters.milp_elements]
    methods += _lemke(parameters, scene, factor, np.zeros(system.nodes), CYCLES, error)
    reference = "exact path; that of the path itself is its largest energy residual over the work"
    return Question("transient", "work in the second cycle", scene.name, system.nodes, reference, methods)


def _steady(parameters: Parameters, scene: Scene) -> Question:
    system, friction, factor = scene.system, parameters.friction, parameters.steady_overload * scene.limit
    start = start_slip(parameters, system)
    march = partial(fo.march, system, LOADS, friction, factor, initial_slip=start)
    exact = last_work(march(cycles=parameters.reference_cycles))

    def error(work: float) -> float:
        return abs(work / exact - 1)

    run = partial(fo.steady_state, system, LOADS, friction, factor, initial_slip=start)
    methods = [Method("frictopt, proven", "none", "proof", run, lambda state: error(state.dissipation), lambda state: state.residual)]
    for cycles in parameters.steady_cycles:
        follow = partial(march, cycles=cycles)
        methods.append(
            Method("frictopt, so many cycles", "cycles", f"{cycles}", follow, lambda made: error(last_work(made)), lambda made: made.residual)
        )
    methods += _lemke(parameters, scene, factor, start, max(parameters.steady_cycles), error)
    reference = f"work in cycle {parameters.reference_cycles} of the exact path"
    return Question("steady state", "work in a cycle", scene.name, system.nodes, reference, methods)


def _lemke(parameters: Parameters, scene: Scene, factor: float, start: Array, cycles: int, error: Any) -> Iterator[Method]:
    """Lemke's method over that many cycles."""
    if installed("quantecon") is None:
        return
    system = scene.system
    mean = np.concatenate(system.reaction(LOADS.mean))
    corners = [mean + factor * np.concatenate(pair) for pair in zip(*LOADS.corner_reactions(system), strict=True)]
    force = float(np.abs(mean[system.nodes :]).mean())
    carried = np.r_[np.zeros(system.nodes), np.full(system.nodes, force)] - system.S[:, : system.nodes] @ start
    loads = [carried, mean, *corners * cycles]
    rival = Lemke(system, parameters.friction, force)
    for steps in parameters.steps:
        run = partial(rival.cycle_work, start, loads, steps, len(corners))
        yield Method(f"Lemke, {cycles} cycles", _STEPS, f"{steps}", run, error, rival="quantecon")


def last_work(path: fo.results.Trajectory | fo.results.Trajectory) -> float:
    """Work of friction in the last cycle of a transient."""
    return float(path.cycle_work[-1].sum())


def _energy_error(path: fo.results.Trajectory) -> float:
    return float(np.abs(path.energy_error).max()) / last_work(path)
