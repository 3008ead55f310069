"""Solving for one node on both its bounds, with proof of the least load factor or of its absence."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import cvxpy as cp
import numpy as np

from ..contact.checks import Array, frozen
from ..contact.record import Attempt
from ..contact.tolerances import COINCIDE, FLOOR, RESIDUAL, TIE, ZERO_LOAD_FACTOR
from ..solve.explain import Units
from ..solve.solvers import solve
from ..solve.standard_form import StandardForm
from .both_bounds import Aim, both_bounds_problem, set_node
from .program import SafeProgram
from .question import LimitQuestion
from .ruling_corners import ruling

__all__ = ["BothBoundsSearch", "NodeClaim", "pairs"]


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is on both its bounds under a safe slip; inf where there is none.

    Attributes
    ----------
    node, corners
        The node, and the corners of its forward and of its backward bound.
    load_factor, slip
        The least load factor and the (N,) slip there (NaN where there is none).
    residual
        Its largest violation, or the distance from what the multipliers prove.
    solver, attempts, problem, units
        As for `GuaranteedLimit`.
    values
        What then stands in the variables of the program over safe slips.
    coincide
        Whether it is on both bounds at the least safe load factor of the contact alone.
    above
        Of a least load factor that is the least safe one: a larger one at which the node is on both bounds too, and the (N,) slip there. Those
        between mix the two.
    """

    node: int
    corners: tuple[int, int]
    load_factor: float
    slip: Array
    residual: float
    solver: str = ""
    attempts: tuple[Attempt, ...] = ()
    problem: cp.Problem | None = None
    units: Units = field(default_factory=dict)
    values: Mapping[cp.Variable, Array] = field(default_factory=dict)
    coincide: bool = False
    above: tuple[float, Array] | None = None


class BothBoundsSearch:
    """The problems of all nodes over the safe slips of a program with its parameters set, compiled once for any friction.

    Parameters
    ----------
    solver
        Use this one alone.
    """

    def __init__(self, solver: str | None) -> None:
        self._solver = solver
        self._compiled: dict[Aim, tuple[cp.Problem, SafeProgram]] = {}

    def solve(self, safe: SafeProgram, node: int, corners: tuple[int, int], ends: tuple[float, float], *, expect_solution: bool) -> NodeClaim:
        """The claim of one node at two corners, see `pairs`, that passes its checks, of a contact that is safe between two load factors.

        Whether the node is `expect_solution` to be on both bounds anywhere decides only which of the problems comes first.

        Raises
        ------
        SolverError
            No solver gave an answer that passes.
        """
        denied = None if expect_solution else self._proof_of_absence(safe, node, corners)
        if denied is not None:
            return denied
        program = self._program(safe, node, corners, Aim.LEAST)

        def never() -> NodeClaim | None:
            return self._proof_of_absence(safe, node, corners)

        found = self._solved(lambda: _claimed(program, node, corners), program, never)
        values = {variable: variable.value for variable in safe.problem.variables()}
        found = replace(found, problem=program.problem, values=values, units=program.units)
        least, (beyond, _) = ends[0], _next_to(safe.task, ends)
        return self._beyond_least(safe, found, ends) if found.load_factor <= (beyond if least > 0 else 0.0) else found

    def values_of(self, safe: SafeProgram, claim: NodeClaim) -> Mapping[cp.Variable, Array]:
        """What stands in the variables for a claim, with the parameters of its program set."""
        self._program(safe, claim.node, claim.corners, Aim.LEAST)
        return claim.values

    def _beyond_least(self, safe: SafeProgram, found: NodeClaim, ends: tuple[float, float]) -> NodeClaim:
        """The claim of a limit at the least safe load factor, if the node can be on both bounds above it too; otherwise it is nowhere else.

        The load factors at which it can are an interval, for the problem is convex.
        """
        program, (beyond, step) = self._program(safe, found.node, found.corners, Aim.HIGHEST), _next_to(safe.task, ends)
        program.problem.param_dict["most_load_factor"].value = 1.0 + ends[0] / safe.task.load_unit
        highest = self._solved(lambda: _claimed(program, found.node, found.corners), program)
        attempts = (*found.attempts, *highest.attempts)
        if highest.load_factor > max(beyond, found.load_factor + step):
            return replace(
                found, attempts=attempts, residual=max(found.residual, highest.residual), above=(highest.load_factor, frozen(highest.slip))
            )
        nothing = np.full_like(found.slip, np.nan)
        return replace(found, load_factor=np.inf, slip=nothing, attempts=attempts, residual=highest.residual, coincide=True)

    def _solved(self, claimed: Callable[[], NodeClaim], program: SafeProgram, never: Callable[[], NodeClaim | None] | None = None) -> NodeClaim:
        answer = solve(program, claimed, self._solver, no_optimum=never)
        return replace(answer.claim, solver=answer.solver, attempts=answer.attempts)

    def _program(self, safe: SafeProgram, node: int, corners: tuple[int, int], aim: Aim) -> SafeProgram:
        if aim not in self._compiled or self._compiled[aim][0] is not safe.problem:
            self._compiled[aim] = safe.problem, both_bounds_problem(safe, aim)
        program = replace(self._compiled[aim][1], task=safe.task)
        set_node(program, node, corners)
        return program

    def _proof_of_absence(self, safe: SafeProgram, node: int, corners: tuple[int, int]) -> NodeClaim | None:
        """Proof that no safe slip at any load factor holds the node on both bounds; None where there is none."""
        program = self._program(safe, node, corners, Aim.EXCESS)

        def least_excess() -> tuple[float, float]:
            value, bound = StandardForm(program.problem).bounds
            return -value, -bound

        def claimed() -> NodeClaim:
            value, bound = least_excess()
            slip = np.full(safe.task.system.nodes, np.nan)
            return NodeClaim(node, corners, np.inf, slip, 0.0 if bound > RESIDUAL else abs(value - bound))

        claim = self._solved(claimed, program)
        return claim if least_excess()[1] > RESIDUAL else None


def _next_to(task: LimitQuestion, ends: tuple[float, float]) -> tuple[float, float]:
    """A load factor that cannot be told from the least safe one, and its distance from it, small beside the interval of safe ones."""
    step = COINCIDE * min(task.load_unit, ends[1] - ends[0])
    return ends[0] + step, step


def _claimed(program: SafeProgram, node: int, corners: tuple[int, int]) -> NodeClaim:
    """The claim that stands in a program, with the larger of the violations by its slip and the distance of what the multipliers prove."""
    task, factor, slip = program.task, float(program.v.load_factor.value), program.slip
    load_factor = (factor if factor > ZERO_LOAD_FACTOR else 0.0) * task.load_unit
    q, p = task.reactions(load_factor, slip)
    (forward, backward), f = corners, task.friction[node]
    off = max(abs(q[forward, node] + f * p[forward, node]), abs(q[backward, node] - f * p[backward, node])) / task.force
    value, bound = StandardForm(program.problem).bounds
    gap = abs(value - bound) / max(abs(value), FLOOR)
    residual = max(task.violation(load_factor, slip), off, gap, program.violation)
    return NodeClaim(node, corners, load_factor, slip, float(np.nan_to_num(residual, nan=np.inf)))


def pairs(task: LimitQuestion) -> list[list[tuple[int, int]]]:
    """For each node the corners at which it slips to and fro where a safe slip holds it on both its bounds: forward at one, backward at another.

    Where one corner rules both bounds, the node only lifts off there; without friction it dissipates nothing: there are none then, else one pair.
    Where a part of the cycle is fixed, all pairs of corners that rule at some load factor and have different loads.
    """
    f, loads, nodes = task.friction, task.loads, range(task.system.nodes)
    forward, backward = _rulers(task)
    if not loads.fixed:
        only = forward & ~backward, backward & ~forward
        both = only[0].any(axis=0) & only[1].any(axis=0) & (f > 0)
        return [[(int(only[0][:, i].argmax()), int(only[1][:, i].argmax()))] if both[i] else [] for i in nodes]
    own = np.stack([loads.q0, f * loads.p0, loads.q1, f * loads.p1])
    floor = TIE * np.abs(own).max(axis=1)
    found: list[list[tuple[int, int]]] = []
    for i in nodes:
        ends = product(*(np.flatnonzero(rules[:, i]).tolist() for rules in (forward, backward))) if f[i] > 0 else ()
        found.append([(k, j) for k, j in ends if k != j and (np.abs(own[:, k, i] - own[:, j, i]) > floor[:, i]).any()])
    return found


def _rulers(task: LimitQuestion) -> tuple[np.ndarray, np.ndarray]:
    """(K, N) whether a corner rules the forward and the backward bound of a node, ties included; at some load factor where a part is fixed."""
    f, q1, p1 = task.friction, task.loads.q1, task.loads.p1
    if task.loads.fixed:
        both = np.zeros((2, *p1.shape), dtype=bool)
        for rules, sense in zip(both, (1, -1), strict=True):
            rules[ruling(-(sense * task.loads.q0 + f * task.loads.p0), -(sense * q1 + f * p1))] = True
        return both[0], both[1]
    floor = TIE * (np.abs(q1) + f * np.abs(p1)).max(axis=0)
    forward, backward = -(q1 + f * p1), q1 - f * p1
    return forward >= forward.max(axis=0) - floor, backward >= backward.max(axis=0) - floor
