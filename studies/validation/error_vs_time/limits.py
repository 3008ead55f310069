"""Onset, shakedown limit and safe slip: the package with and without a compiled model, and direct calls of solvers on the same matrices."""

from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.solve import LP_SOLVERS

from ...paper import LOADS
from .bare_lp import SIMPLEX, LinearProgram, highs, highs_vertex, methods
from .exact import fractions, largest, safe_rows
from .methods import Method, Question, relative
from .parameters import Parameters
from .scenes import Scene

Array = np.ndarray[Any, Any]

_DIRECTION = {"sigma": -1.0}


def questions(parameters: Parameters, scene: Scene) -> Iterator[Question]:
    """The three questions on one mesh."""
    yield _onset(parameters, scene)
    yield _limit(parameters, scene)
    yield _safe_slip(parameters, scene)


def exact_onset(system: fo.ContactSystem, friction: float) -> float:
    """Load factor of the first slip of the bonded contact as the bulk is pressed, in rational arithmetic; the mean load alone must not slip it."""
    (q0, p0), (q1, p1) = ([fractions(values) for values in system.reaction(loads)] for loads in (LOADS.mean, _DIRECTION))
    f = Fraction(friction)
    slacks, rates = np.concatenate([q0 + f * p0, f * p0 - q0]), np.concatenate([q1 + f * p1, f * p1 - q1])
    return float(min(-slack / rate for slack, rate in zip(slacks, rates, strict=True) if rate < 0))


def exact_limit(system: fo.ContactSystem, friction: float) -> float:
    """Shakedown limit under bulk stress, in rational arithmetic."""
    slips, mean, cyclic, _ = safe_rows(system, LOADS, friction)
    return _largest(slips, -cyclic, mean)


def exact_largest_margin(system: fo.ContactSystem, friction: float, load_factor: float) -> float:
    """Largest margin of a safe slip under bulk stress, in rational arithmetic."""
    slips, mean, cyclic, bound = safe_rows(system, LOADS, friction)
    return _largest(slips, np.array([-bound] * len(mean), dtype=object), mean + Fraction(load_factor) * cyclic)


def _largest(*program: Array) -> float:
    """Largest z of `slips v + last z >= right`, from the vertex that HiGHS finds."""
    slips, last, right = (values.astype(float) / np.abs(values.astype(float)).max() for values in program)
    active = highs_vertex(highs(LinearProgram.maximum(np.column_stack([slips, last]), right), SIMPLEX))
    return largest(np.column_stack(program[:2]), program[2], active)


def _onset(parameters: Parameters, scene: Scene) -> Question:
    run = partial(fo.onset, scene.system, fo.LoadCycle(LOADS.mean, [_DIRECTION]), parameters.friction)
    exact = exact_onset(scene.system, parameters.friction)
    method = Method("frictopt", "none", "closed form", run, relative(exact, lambda onset: onset.slip.load_factor))
    return Question("onset", "load factor of first slip", scene.name, scene.system.nodes, [method])


def _limit(parameters: Parameters, scene: Scene) -> Question:
    system, friction = scene.system, parameters.friction
    exact = exact_limit(system, friction)
    compiled = {solver: fo.ShakedownModel(system, LOADS, solver=solver) for solver in LP_SOLVERS}
    kept = fo.ShakedownModel(system, LOADS, simplify=False)
    first = partial(fo.shakedown_limit, system, LOADS, friction)
    found = first()
    problem: Any = found.problem  # solved, because the contact is coupled
    unit = found.load_factor / problem.value

    runs = [("first time", "HIGHS", first), *(("compiled", solver, partial(model.solve, friction)) for solver, model in compiled.items())]
    runs.append(("compiled, nothing left out", "HIGHS", partial(kept.solve, friction)))
    error = relative(exact, lambda limit: limit.load_factor)
    ours = [Method(f"frictopt, {name}", "solver", solver, run, error) for name, solver, run in runs]
    bare = methods(LinearProgram.of(problem), parameters.tolerances, relative(exact, lambda cost: -cost * unit))
    return Question("lambda_2", "load factor", scene.name, system.nodes, [*ours, *bare])


def _safe_slip(parameters: Parameters, scene: Scene) -> Question:
    system, friction, factor = scene.system, parameters.friction, parameters.margin_share * scene.limit
    exact = exact_largest_margin(system, friction, factor)
    ask, error = partial(fo.safe_slip, system, LOADS, friction, factor), relative(exact, lambda safe: safe.margin)
    ours = [Method("frictopt", "solver", solver, partial(ask, solver=solver), error) for solver in LP_SOLVERS]
    found = ask()
    problem: Any = found.problem
    unit = found.margin / problem.value
    bare = methods(LinearProgram.of(problem), parameters.tolerances, relative(exact, lambda cost: -cost * unit))
    return Question("safe slip", "margin", scene.name, system.nodes, [*ours, *bare])
