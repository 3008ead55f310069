"""One increment of friction, from one corner of the load cycle to the next: the package's engines, and Lemke's method."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from frictopt.transients.exact import ExactPath
from frictopt.transients.increments import ExactIncrement, FrozenBoundIncrement, NewtonIncrement

from ...paper import LOADS
from .exact import exact_increment
from .lemke import Lemke
from .methods import Method, Question, installed
from .parameters import Parameters
from .scenes import Scene

Array = np.ndarray[Any, Any]


def posed(parameters: Parameters, scene: Scene) -> tuple[ExactPath, Array]:
    """The exact path at the first corner, above the shakedown limit, and the slip (N,) that one increment to the second corner leads to."""
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path = ExactPath(system, LOADS, friction, parameters.overload * scene.limit)
    path.start()
    path.follow_to(path.corners[0], "the segment to the first corner")
    slip, pair = path.state.u[:n], (path.corners[1][:n], path.corners[1][n:])
    after = NewtonIncrement(system, friction).solve(slip, pair)
    return path, exact_increment(system, friction, slip, pair, np.sign(after.slip - slip))


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """From the state at the first corner, above the shakedown limit, to the second corner at once."""
    system, friction, n = scene.system, parameters.friction, scene.system.nodes
    path, exact = posed(parameters, scene)
    before, bonded = path.state.u.copy(), path.corners[1]
    slip, pair = before[:n], (bonded[:n], bonded[n:])
    engines = {"frozen bounds (QP)": ("CLARABEL", FrozenBoundIncrement), "newton": ("steps", NewtonIncrement)}

    def error(found: Array) -> float:
        return float(np.abs(found - exact).max() / np.abs(exact - slip).max())

    def ours(method: str, solver: str, engine: Any) -> Method:
        return Method(method, "solver", solver, partial(engine.solve, slip, pair), lambda made: error(made.slip))

    methods = [ours(f"frictopt, {name}", way, engine(system, friction)) for name, (way, engine) in engines.items()]
    methods.append(Method("frictopt, exact path", "none", "events", partial(_followed, path, before), lambda u: error(u[:n])))
    if elements in parameters.milp_elements:
        methods.append(ours("frictopt, complementarity (MILP)", "HIGHS", ExactIncrement(system, friction)))
    if installed("quantecon"):
        lemke = Lemke(system, friction, float(np.abs(bonded[n:]).mean()))
        methods.append(Method("Lemke", "none", "pivots", partial(lemke.increment, slip, bonded), lambda made: error(made[0]), rival="quantecon"))
    # reference: linear system of the final statuses in rational arithmetic, refined to 40 digits; the contact law checked on it
    yield Question("increment", "slip", scene.name, n, methods)


def _followed(path: ExactPath, before: Array) -> Array:
    """(2N,) slip and gap at the second corner, on the exact path from a state at the first."""
    here = path.at(before / path.unit)
    if here is None:
        raise ArithmeticError("the state at the first corner does not obey the contact law")
    here.follow_to(path.corners[1], "the segment to the second corner")
    return np.asarray(here.state.u)
