"""One increment, transients and steady states above the shakedown limit.

The methods are the exact path, engines in increments, and Lemke's method.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.transients.exact import ExactPath
from frictopt.transients.increments import NewtonIncrement
from studies.paper import LOADS
from studies.validation.error_vs_time.exact import exact_increment
from studies.validation.error_vs_time.frozen import FrozenBounds
from studies.validation.error_vs_time.lemke import Lemke
from studies.validation.error_vs_time.methods import Method, Question, installed, relative
from studies.validation.error_vs_time.parameters import (
    CYLINDER,
    CYLINDER_LOADS,
    SHEAR,
    Parameters,
    Scene,
    cylinder,
)
from studies.validation.oracles import corner_loads

Array = np.ndarray[Any, Any]

# From this number of nodes on, Clarabel takes minutes for all tolerances.
_LARGE = 200
CYCLES = 2
"""Number of cycles of a transient. The work in the last cycle is compared."""
STEPS = "increments from corner to corner"


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """Work in the second cycle and in the steady cycle, on one mesh."""
    yield _transient(parameters, scene, elements)
    yield _steady(parameters, scene)


def increments(parameters: Parameters, scene: Scene) -> Iterator[Question]:
    """One increment on one mesh, in which few nodes slip, and one in which most nodes slip."""
    for quantity, overload in (
        ("slip of few nodes", parameters.steady_overload),
        ("slip of most nodes", parameters.overload),
    ):
        yield _increment(parameters, scene, quantity, overload)


def cylinders(parameters: Parameters) -> Iterator[Question]:
    """Transient and steady state of a scene with a closed form, for several numbers of cells."""
    asked = CYLINDER_LOADS, CYLINDER.f, SHEAR
    for computation, quantity, ask, work in (
        (
            "transient",
            "work in the second cycle",
            lambda cells: fo.march(cylinder(cells), *asked, cycles=CYCLES),
            last_work,
        ),
        (
            "steady state",
            "work in a cycle",
            lambda cells: fo.steady_state(cylinder(cells), *asked),
            lambda state: state.dissipation,
        ),
    ):
        error = relative(CYLINDER.dissipation(SHEAR), work)
        methods = [
            Method("frictopt", "cells", f"{cells}", partial(ask, cells), error)
            for cells in parameters.cells
        ]
        yield Question(computation, quantity, "cylinder on a half-plane", 0, methods)


def start_slip(parameters: Parameters, system: fo.ContactSystem) -> Array:
    """(N,) initial slip: random coefficients of the six lowest Chebyshev polynomials.

    The coefficients are multiplied by the amplitude `start` of the parameters.
    """
    modes = np.polynomial.chebyshev.chebvander(system.x / system.x[-1], 6)[:, 1:]
    coefficients = np.random.default_rng(parameters.seed).normal(size=modes.shape[1])
    return np.asarray(parameters.start * modes @ coefficients)


def _transient(parameters: Parameters, scene: Scene, elements: int) -> Question:
    """The work of a transient on one mesh."""
    system, friction, factor = scene.system, parameters.friction, parameters.overload * scene.limit
    march = partial(fo.march, system, LOADS, friction, factor, cycles=CYCLES)
    exact = last_work(march())
    methods = [Method("frictopt, exact path", "none", "events", march, _energy_error)]
    methods += in_steps("frictopt, increments", march, parameters.steps, exact)
    methods += _lemke(parameters, scene, factor, np.zeros(system.nodes), CYCLES, exact)
    # The reference is the exact path. The error of the exact path is its largest energy
    # residual over the work.
    return Question("transient", "work in the second cycle", scene.name, system.nodes, methods)


def _steady(parameters: Parameters, scene: Scene) -> Question:
    """The work of a steady state on one mesh."""
    system = scene.system
    friction = parameters.friction
    factor = parameters.steady_overload * scene.limit
    start = start_slip(parameters, system)
    march = partial(fo.march, system, LOADS, friction, factor, initial_slip=start)
    exact = last_work(march(cycles=parameters.reference_cycles))
    run = partial(fo.steady_state, system, LOADS, friction, factor, initial_slip=start)
    error = relative(exact, last_work)
    methods = [
        Method(
            "frictopt, proven",
            "none",
            "proof",
            run,
            relative(exact, lambda state: state.dissipation),
        )
    ]
    methods += [
        Method("frictopt, so many cycles", "cycles", f"{n}", partial(march, cycles=n), error)
        for n in parameters.steady_cycles
    ]
    methods += _lemke(parameters, scene, factor, start, max(parameters.steady_cycles), exact)
    # The reference is the work in cycle `reference_cycles` of the exact path.
    return Question("steady state", "work in a cycle", scene.name, system.nodes, methods)


def _lemke(
    parameters: Parameters, scene: Scene, factor: float, start: Array, cycles: int, exact: float
) -> Iterator[Method]:
    """Lemke's method over a number of cycles."""
    if installed("quantecon") is None:
        return
    system = scene.system
    mean, corners = corner_loads(system, LOADS, factor)
    force = float(np.abs(mean[system.nodes :]).mean())
    pressed = np.r_[np.zeros(system.nodes), np.full(system.nodes, force)]
    carried = pressed - system.S[:, : system.nodes] @ start
    loads = [carried, mean, *corners * cycles]
    rival = Lemke(system, parameters.friction, force)
    for steps in parameters.steps:
        run = partial(rival.cycle_work, start, loads, steps, len(corners))
        yield Method(
            f"Lemke, {cycles} cycles",
            STEPS,
            f"{steps}",
            run,
            relative(exact, float),
            rival="quantecon",
        )


def in_steps(name: str, march: Any, counts: Sequence[int], exact: float) -> list[Method]:
    """Transients with several numbers of increments, and the error of the work in their last cycle."""
    return [
        Method(name, STEPS, f"{steps}", partial(march, steps=steps), relative(exact, last_work))
        for steps in counts
    ]


def last_work(path: fo.results.Trajectory) -> float:
    """Work of friction in the last cycle of a transient."""
    return float(path.cycle_work[-1].sum())


def _energy_error(path: fo.results.Trajectory) -> float:
    """Largest error of the energy of a path, divided by the work."""
    return float(np.abs(path.energy_error).max()) / last_work(path)


def posed(parameters: Parameters, scene: Scene, overload: float) -> tuple[ExactPath, Array]:
    """The exact path at the first corner, and the slip (N,) after one exact increment from there.

    The increment leads to the second corner. The load factor is `overload` times the shakedown
    limit.
    """
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path = ExactPath(system, LOADS, friction, overload * scene.limit).start()
    path.follow_to(path.corners[0], "the segment to the first corner")
    slip, pair = path.state.u[:n], (path.corners[1][:n], path.corners[1][n:])
    after = NewtonIncrement(system, friction).solve(slip, pair)
    return path, exact_increment(system, friction, slip, pair, after.status)


def _increment(parameters: Parameters, scene: Scene, quantity: str, overload: float) -> Question:
    """One increment from the state at the first corner, above the shakedown limit, to the second."""
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path, exact = posed(parameters, scene, overload)
    before, bonded = path.state.u.copy(), path.corners[1]
    slip, pair = before[:n], (bonded[:n], bonded[n:])

    def error(found: Array) -> float:
        return float(np.abs(found - exact).max() / np.abs(exact - slip).max())

    methods = [
        Method(
            "frictopt, newton",
            "solver",
            "steps",
            partial(NewtonIncrement(system, friction).solve, slip, pair),
            lambda made: error(made.slip),
        ),
        Method(
            "frictopt, exact path",
            "none",
            "events",
            partial(_followed, path, before),
            lambda u: error(u[:n]),
        ),
    ]
    bare = FrozenBounds(system, friction)
    every = parameters.increment_tolerances
    for name, way, tolerances in (
        ("OSQP", bare.osqp, every),
        ("Clarabel", bare.clarabel, every if n < _LARGE else every[::4]),
    ):
        for tolerance in tolerances:
            run = partial(way, slip, bonded, tolerance)
            methods.append(
                Method(
                    f"{name}, frozen bounds",
                    "tolerance",
                    f"{tolerance:.0e}",
                    run,
                    error,
                    rival=name.lower(),
                )
            )
    if installed("quantecon"):
        lemke = Lemke(system, friction, float(np.abs(bonded[n:]).mean()))
        methods.append(
            Method(
                "Lemke",
                "none",
                "pivots",
                partial(lemke.increment, slip, bonded),
                lambda made: error(made[0]),
                rival="quantecon",
            )
        )
    # The reference solves the linear system of the final statuses in rational arithmetic,
    # refined to 40 digits. The contact law is checked on it.
    return Question("increment", quantity, scene.name, n, methods)


def _followed(path: ExactPath, before: Array) -> Array:
    """(2N,) slip and gap at the second corner, on the exact path from a state at the first corner."""
    here = path.at(before / path.unit)
    if here is None:
        raise ArithmeticError("the state at the first corner does not obey the contact law")
    here.follow_to(path.corners[1], "the segment to the second corner")
    return np.asarray(here.state.u)
