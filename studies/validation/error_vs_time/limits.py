"""Onset, limits and safe slip by frictopt and by direct calls of solvers on the same matrices.

frictopt is called with and without a compiled model.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

import frictopt as fo
from frictopt.limits import pose
from frictopt.limits.program import assembled
from frictopt.solve import LP_SOLVERS
from studies.paper import LOADS
from studies.validation.error_vs_time.bare_lp import (
    SIMPLEX,
    LinearProgram,
    highs,
    highs_cost,
    highs_vertex,
    methods,
)
from studies.validation.error_vs_time.exact import (
    exact_guaranteed_limit,
    fractions,
    largest,
    safe_rows,
)
from studies.validation.error_vs_time.methods import Method, Question, relative
from studies.validation.error_vs_time.parameters import Parameters, Scene
from studies.validation.error_vs_time.plain import plain_limit

Array = np.ndarray[Any, Any]

_DIRECTION = {"sigma": -1.0}


def questions(parameters: Parameters, scene: Scene) -> Iterator[Question]:
    """The four questions on one mesh."""
    yield _onset(parameters, scene)
    yield _limit(parameters, scene)
    yield _safe_slip(parameters, scene)
    yield _guaranteed(parameters, scene)


def exact_onset(system: fo.ContactSystem, friction: float) -> float:
    """Load factor of the first slip of the bonded contact under pressure on the bulk, exactly.

    The arithmetic is rational. The mean load alone must not cause slip.
    """
    q0, p0 = (fractions(values) for values in system.reaction(LOADS.mean))
    q1, p1 = (fractions(values) for values in system.reaction(_DIRECTION))
    f = Fraction(friction)
    slacks = np.concatenate([q0 + f * p0, f * p0 - q0])
    rates = np.concatenate([q1 + f * p1, f * p1 - q1])
    return float(min(-slack / rate for slack, rate in zip(slacks, rates, strict=True) if rate < 0))


def exact_limit(system: fo.ContactSystem, friction: float) -> float:
    """Shakedown limit under bulk stress, in rational arithmetic."""
    slips, mean, cyclic, _ = safe_rows(system, LOADS, friction)
    return _largest(slips, -cyclic, mean)


def exact_largest_margin(system: fo.ContactSystem, friction: float, load_factor: float) -> float:
    """Largest margin of a safe slip under bulk stress, in rational arithmetic."""
    slips, mean, cyclic, bound = safe_rows(system, LOADS, friction)
    margins = np.array([-bound] * len(mean), dtype=object)
    return _largest(slips, margins, mean + Fraction(load_factor) * cyclic)


def _largest(*program: Array) -> float:
    """Largest z of `slips v + last z >= right`, from the vertex that HiGHS finds."""
    slips, last, right = (
        values.astype(float) / np.abs(values.astype(float)).max() for values in program
    )
    scaled = LinearProgram.maximum(np.column_stack([slips, last]), right)
    active = highs_vertex(highs(scaled, SIMPLEX))
    return largest(np.column_stack(program[:2]), program[2], active)


def _onset(parameters: Parameters, scene: Scene) -> Question:
    """The onset on one mesh."""
    run = partial(
        fo.onset, scene.system, fo.LoadCycle(LOADS.mean, [_DIRECTION]), parameters.friction
    )
    exact = exact_onset(scene.system, parameters.friction)
    method = Method(
        "frictopt",
        "none",
        "closed form",
        run,
        relative(exact, lambda onset: onset.slip.load_factor),
    )
    return Question("onset", "load factor of first slip", scene.name, scene.system.nodes, [method])


def _limit(parameters: Parameters, scene: Scene) -> Question:
    """The shakedown limit on one mesh."""
    system, friction = scene.system, parameters.friction
    exact = exact_limit(system, friction)
    models = {solver: fo.ShakedownModel(system, LOADS, solver=solver) for solver in LP_SOLVERS}
    kept = fo.ShakedownModel(system, LOADS, simplify=False)
    first = partial(fo.shakedown_limit, system, LOADS, friction)
    program = assembled.shakedown(pose(system, LOADS, friction))

    runs = [
        ("first time", "HIGHS", first),
        *(("compiled", solver, partial(model.solve, friction)) for solver, model in models.items()),
    ]
    runs.append(("compiled, nothing left out", "HIGHS", partial(kept.solve, friction)))
    error = relative(exact, lambda limit: limit.load_factor)
    ours = [Method(f"frictopt, {name}", "solver", solver, run, error) for name, solver, run in runs]
    bare = methods(
        LinearProgram.of(program),
        parameters.tolerances,
        relative(exact, lambda cost: -cost),
    )
    plain = [
        Method(
            f"plain cvxpy, {solver}",
            "solver",
            solver,
            partial(plain_limit, system, LOADS, friction, solver),
            relative(exact, float),
            rival="cvxpy",
        )
        for solver in ("HIGHS", "CLARABEL")
    ]
    return Question("lambda_2", "load factor", scene.name, system.nodes, [*ours, *bare, *plain])


def _safe_slip(parameters: Parameters, scene: Scene) -> Question:
    """The margin of a safe slip on one mesh."""
    system = scene.system
    friction = parameters.friction
    factor = parameters.margin_share * scene.limit
    exact = exact_largest_margin(system, friction, factor)
    safe_slip = partial(fo.safe_slip, system, LOADS, friction, factor)
    error = relative(exact, lambda safe: safe.margin)
    ours = [
        Method("frictopt", "solver", solver, partial(safe_slip, solver=solver), error)
        for solver in LP_SOLVERS
    ]
    program = assembled.safe_slip(pose(system, LOADS, friction), factor)
    bare = methods(
        LinearProgram.of(program),
        parameters.tolerances,
        relative(exact, lambda cost: -cost),
    )
    return Question("safe slip", "margin", scene.name, system.nodes, [*ours, *bare])


OPTIONS: dict[str, dict[str, Any]] = {"defaults": {}, "no presolve": {"presolve": "off"}}
"""Settings of HiGHS, by name."""


@dataclass(frozen=True, eq=False)
class NodePrograms:
    """Programs for the least load factor at which a safe slip holds a node on both its bounds.

    There is a program for each node whose two bounds govern at different corners.

    Attributes
    ----------
    programs
        Node -> its linear program; the load factor is the last unknown, after the slips, which add
        up to zero.
    load_unit
        Unit of the load factor.
    """

    programs: dict[int, LinearProgram]
    load_unit: float

    @classmethod
    def of(cls, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> "NodePrograms":
        """The programs of a contact."""
        n = system.nodes
        slips, mean, cyclic = (
            rows.astype(float) for rows in safe_rows(system, cycle, friction)[:3]
        )
        load_unit = np.abs(mean).max() / np.abs(cyclic).max()
        matrix = csc_matrix(
            np.column_stack([-slips / np.abs(slips).max(), cyclic / np.abs(cyclic).max()])
        )
        right = -mean / np.abs(mean).max()
        cost = np.eye(n)[-1]
        lower = np.where(cost > 0, 0.0, -np.inf)
        programs = {}
        q, p = cycle.corner_reactions(system)
        forward = (q + friction * p).argmin(axis=0)
        backward = (friction * p - q).argmin(axis=0)
        for node in np.flatnonzero(forward != backward).tolist():
            floor = np.full(len(right), -np.inf)
            floor[[node, n + node]] = right[[node, n + node]]
            programs[node] = LinearProgram(cost, matrix, right, lower, floor)
        return cls(programs, load_unit)

    def least(self, options: dict[str, Any]) -> tuple[float, int, Any]:
        """The least load factor over the nodes, its node, and HiGHS with this answer.

        Programs without an optimum are skipped.
        """
        least = np.inf
        governing_node = -1
        best_solver = None
        for node, program in self.programs.items():
            try:
                solver = highs(program, options)
            except ArithmeticError:
                continue
            if highs_cost(solver) < least:
                least = highs_cost(solver)
                governing_node = node
                best_solver = solver
        return least * self.load_unit, governing_node, best_solver


def exact_least(system: fo.ContactSystem, friction: float) -> float:
    """The upper bound under bulk stress in rational arithmetic, at the node that HiGHS determines."""
    _, node, solver = NodePrograms.of(system, LOADS, friction).least({})
    return exact_guaranteed_limit(system, LOADS, friction, node, highs_vertex(solver))


def _guaranteed(parameters: Parameters, scene: Scene) -> Question:
    """The upper bound on one mesh; HiGHS decides that no other node has a smaller load factor."""
    system, friction = scene.system, parameters.guaranteed_friction
    bare = NodePrograms.of(system, LOADS, friction)
    model = fo.GuaranteedModel(system, LOADS)
    exact = exact_least(system, friction)

    runs = {
        "first time": partial(fo.guaranteed_limit, system, LOADS, friction),
        "compiled": partial(model.solve, friction),
    }
    methods = [
        Method(
            f"frictopt, {name}",
            "solver",
            "HIGHS",
            run,
            relative(exact, lambda limit: limit.load_factor),
        )
        for name, run in runs.items()
    ]
    for name, options in OPTIONS.items():
        run, error = partial(bare.least, options), relative(exact, lambda found: found[0])
        methods.append(
            Method("HiGHS, a program for each node", "options", name, run, error, rival="highspy")
        )
    # The reference is the vertex of the program of this node in rational arithmetic, refined to
    # 40 digits and proven optimal.
    return Question("lambda_1", "upper bound", scene.name, system.nodes, methods)
