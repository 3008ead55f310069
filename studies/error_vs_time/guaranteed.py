"""The guaranteed limit: the package's search among the nodes, and a bare linear program for each of them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

import frictopt as fo
from frictopt.limits.posed import LimitQuestion, cycle_loads

from ..paper import LOADS
from .bare_lp import LinearProgram, highs, highs_cost, highs_vertex
from .exact import exact_guaranteed_limit
from .parameters import Parameters
from .scenes import Scene
from .ways import Question, Way

__all__ = ["OPTIONS", "NodePrograms", "questions"]

Array = np.ndarray[Any, Any]

OPTIONS: dict[str, dict[str, Any]] = {"defaults": {}, "no presolve": {"presolve": "off"}}
"""Settings of HiGHS, by name."""


@dataclass(frozen=True, eq=False)
class NodePrograms:
    """For each node that two corners rule, the least load factor at which a safe slip holds it on both its bounds.

    Attributes
    ----------
    programs
        Node -> its linear program, in the package's units, nothing left out; the load factor is the last unknown.
    load_unit
        Unit of the load factor.
    """

    programs: dict[int, LinearProgram]
    load_unit: float

    @classmethod
    def of(cls, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> "NodePrograms":
        """The programs of a contact."""
        task = LimitQuestion(system, cycle, cycle_loads(system, cycle), np.full(system.nodes, friction), False)
        scaled = task.scaled()
        rows, n = task.rows(scaled), system.nodes
        lift, shear = rows.friction[:, None] * scaled.normal, scaled.shear
        matrix = csc_matrix(np.hstack([np.vstack([-lift - shear, shear - lift]), np.concatenate([rows.forward, rows.backward])[:, None]]))
        right = np.concatenate([rows.fp_mean + rows.q_mean, rows.fp_mean - rows.q_mean])
        cost = np.eye(matrix.shape[1])[-1]
        lower = np.where(cost > 0, 0.0, -np.inf)
        programs = {}
        for node in np.flatnonzero(rows.corners[0] != rows.corners[1]).tolist():
            floor = np.full(len(right), -np.inf)
            floor[[node, n + node]] = right[[node, n + node]]
            programs[node] = LinearProgram(cost, matrix, right, lower, floor)
        return cls(programs, rows.load_unit)

    def least(self, options: dict[str, Any]) -> tuple[float, int, Any]:
        """The least load factor over the nodes, its node, and HiGHS with the answer; programs without an optimum are passed over."""
        found: tuple[float, int, Any] = np.inf, -1, None
        for node, program in self.programs.items():
            try:
                solver = highs(program, options)
            except ArithmeticError:
                continue
            if highs_cost(solver) < found[0]:
                found = highs_cost(solver), node, solver
        return found[0] * self.load_unit, found[1], found[2]


def questions(parameters: Parameters, scene: Scene) -> Iterator[Question]:
    """The upper bound on one mesh; that no other node has a smaller load factor is HiGHS's word."""
    system, friction = scene.system, parameters.guaranteed_friction
    bare, model = NodePrograms.of(system, LOADS, friction), fo.GuaranteedModel(system, LOADS)
    _, node, solver = bare.least({})
    exact = exact_guaranteed_limit(system, LOADS, friction, node, highs_vertex(solver)).value

    def ours(method: str, run: Any) -> Way:
        return Way(method, "solver", "HIGHS", run, lambda limit: abs(limit.load_factor / exact - 1), lambda limit: limit.residual, rest="compile")

    ways = [
        ours("frictopt, first time", partial(fo.guaranteed_limit, system, LOADS, friction)),
        ours("frictopt, compiled", partial(model.solve, friction)),
    ]
    for name, options in OPTIONS.items():
        run = partial(bare.least, options)
        ways.append(Way("HiGHS, a program for each node", "options", name, run, lambda found: abs(found[0] / exact - 1), rival="highspy"))
    reference = "vertex of the program of its node in rational arithmetic, refined to 40 digits and proven optimal"
    yield Question("lambda_1", "upper bound", scene.name, system.nodes, reference, ways)
