"""The guaranteed limit: the package's search among the nodes, and a direct call of a linear program for each of them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

import frictopt as fo

from ...paper import LOADS
from .bare_lp import LinearProgram, highs, highs_cost, highs_vertex
from .exact import exact_guaranteed_limit, safe_rows
from .methods import Method, Question, relative
from .parameters import Parameters
from .scenes import Scene

Array = np.ndarray[Any, Any]

OPTIONS: dict[str, dict[str, Any]] = {"defaults": {}, "no presolve": {"presolve": "off"}}
"""Settings of HiGHS, by name."""


@dataclass(frozen=True, eq=False)
class NodePrograms:
    """For each node that two corners rule, the least load factor at which a safe slip holds it on both its bounds.

    Attributes
    ----------
    programs
        Node -> its linear program; the load factor is the last unknown, after the slips, which add up to zero.
    load_unit
        Unit of the load factor.
    """

    programs: dict[int, LinearProgram]
    load_unit: float

    @classmethod
    def of(cls, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> "NodePrograms":
        """The programs of a contact."""
        n, (slips, mean, cyclic) = system.nodes, (rows.astype(float) for rows in safe_rows(system, cycle, friction)[:3])
        load_unit = np.abs(mean).max() / np.abs(cyclic).max()
        matrix = csc_matrix(np.column_stack([-slips / np.abs(slips).max(), cyclic / np.abs(cyclic).max()]))
        right = -mean / np.abs(mean).max()
        cost = np.eye(n)[-1]
        lower = np.where(cost > 0, 0.0, -np.inf)
        programs = {}
        q, p = cycle.corner_reactions(system)
        for node in np.flatnonzero((q + friction * p).argmin(axis=0) != (friction * p - q).argmin(axis=0)).tolist():
            floor = np.full(len(right), -np.inf)
            floor[[node, n + node]] = right[[node, n + node]]
            programs[node] = LinearProgram(cost, matrix, right, lower, floor)
        return cls(programs, load_unit)

    def least(self, options: dict[str, Any]) -> tuple[float, int, Any]:
        """The least load factor over the nodes, its node, and HiGHS with the answer; programs without an optimum are skipped."""
        found: tuple[float, int, Any] = np.inf, -1, None
        for node, program in self.programs.items():
            try:
                solver = highs(program, options)
            except ArithmeticError:
                continue
            if highs_cost(solver) < found[0]:
                found = highs_cost(solver), node, solver
        return found[0] * self.load_unit, found[1], found[2]


def exact_least(system: fo.ContactSystem, friction: float) -> float:
    """The upper bound under bulk stress in rational arithmetic, at the node that HiGHS finds."""
    _, node, solver = NodePrograms.of(system, LOADS, friction).least({})
    return exact_guaranteed_limit(system, LOADS, friction, node, highs_vertex(solver))


def questions(parameters: Parameters, scene: Scene) -> Iterator[Question]:
    """The upper bound on one mesh; HiGHS decides that no other node has a smaller load factor."""
    system, friction = scene.system, parameters.guaranteed_friction
    bare, model = NodePrograms.of(system, LOADS, friction), fo.GuaranteedModel(system, LOADS)
    exact = exact_least(system, friction)

    runs = {"first time": partial(fo.guaranteed_limit, system, LOADS, friction), "compiled": partial(model.solve, friction)}
    methods = [Method(f"frictopt, {name}", "solver", "HIGHS", run, relative(exact, lambda limit: limit.load_factor)) for name, run in runs.items()]
    for name, options in OPTIONS.items():
        run, error = partial(bare.least, options), relative(exact, lambda found: found[0])
        methods.append(Method("HiGHS, a program for each node", "options", name, run, error, rival="highspy"))
    # reference: vertex of the program of its node in rational arithmetic, refined to 40 digits and proven optimal
    yield Question("lambda_1", "upper bound", scene.name, system.nodes, methods)
