"""Solving for one node on both its bounds, with proof of the least load factor or of its absence."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import cvxpy as cp
import numpy as np

from ..contact.checks import Array, frozen
from ..solve.explain import Units
from ..solve.polish import Program
from ..solve.solvers import TOLERANCE, Attempt, solve
from .both_bounds import Aim, apex_problem, set_apex
from .posed import Task
from .ruling_corners import LoadRows
from .safe_set import SafeProblem
from .scaling import Interface

__all__ = ["ApexClaim", "ApexSearch", "two_corners"]

_FLOOR = 1e-3  # load factors count relative to themselves from this share of the load unit on
_TIE = 1e-12  # corners whose rows differ by less than this share rule together
_ZERO = 1e-12  # dimensionless load factors up to this are rounding of 0
_COINCIDE = 1e-6  # dimensionless load factors up to this are told from 0 by less than the residuals allow


@dataclass(frozen=True, eq=False)
class ApexClaim:
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
    coincide
        Whether it is on both bounds at load factor 0 alone, where it carries nothing.
    above
        Of a least load factor of 0: a larger one at which the node is on both bounds too, and the (N,) slip there. Those between mix the two.
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
    coincide: bool = False
    above: tuple[float, Array] | None = None


class ApexSearch:
    """The problems of all nodes, compiled once for any friction.

    Parameters
    ----------
    solver
        Use this one alone.
    """

    def __init__(self, solver: str | None) -> None:
        self._solver = solver
        self._compiled: dict[tuple[bool, Aim], SafeProblem] = {}

    def solve(self, task: Task, interface: Interface, rows: LoadRows, node: int, *, likely: bool) -> ApexClaim:
        """The claim of one node that passes its checks.

        Whether the node is `likely` to be on both bounds anywhere decides only which of the problems comes first.

        Raises
        ------
        SolverError
            No solver gave an answer that passes.
        """
        denied = None if likely else self._never(task, interface, rows, node)
        if denied is not None:
            return denied
        model = self._model(task, interface, rows, node, Aim.LEAST)

        def never() -> ApexClaim | None:
            return self._never(task, interface, rows, node)

        found = self._solved(lambda: self._claimed(task, model, rows, node), model, never)
        found = replace(found, problem=model.problem, units={"load_factor": rows.load_unit, "traction": interface.unit[interface.loaded]})
        return found if found.load_factor > 0 else self._beyond_zero(task, interface, rows, found)

    def _beyond_zero(self, task: Task, interface: Interface, rows: LoadRows, found: ApexClaim) -> ApexClaim:
        """The claim of a limit of 0 itself, if the node can be on both bounds above 0 too; otherwise it is nowhere but where the bounds coincide.

        The load factors at which it can are an interval, for the problem is convex. Within, above 0, the node presses at both corners.
        """
        model = self._model(task, interface, rows, found.node, Aim.HIGHEST)
        highest = self._solved(lambda: self._claimed(task, model, rows, found.node), model)
        attempts = (*found.attempts, *highest.attempts)
        if highest.load_factor > _COINCIDE * rows.load_unit:
            return replace(
                found, attempts=attempts, residual=max(found.residual, highest.residual), above=(highest.load_factor, frozen(highest.slip))
            )
        nothing = np.full_like(found.slip, np.nan)
        return replace(found, load_factor=np.inf, slip=nothing, attempts=attempts, residual=highest.residual, coincide=True)

    def _solved(self, claimed: Callable[[], ApexClaim], model: SafeProblem, never: Callable[[], ApexClaim | None] | None = None) -> ApexClaim:
        answer = solve(model, claimed, self._solver, no_optimum=never)
        return replace(answer.claim, solver=answer.solver, attempts=answer.attempts)

    def _model(self, task: Task, interface: Interface, rows: LoadRows, node: int, aim: Aim) -> SafeProblem:
        kind = task.opening, aim
        if kind not in self._compiled:
            self._compiled[kind] = apex_problem(interface, task.opening, task.bound(interface), aim)
        set_apex(self._compiled[kind], rows, node)
        return self._compiled[kind]

    def _claimed(self, task: Task, model: SafeProblem, rows: LoadRows, node: int) -> ApexClaim:
        corners, factor, slip = _pair(task, node), float(model.value("load_factor")), task.within_bound(model.slip)
        load_factor = (factor if factor > _ZERO else 0.0) * rows.load_unit
        q, p = task.reactions(load_factor, slip)
        (forward, backward), f = corners, task.friction[node]
        off = max(abs(q[forward, node] + f * p[forward, node]), abs(q[backward, node] - f * p[backward, node])) / task.force
        value, bound = Program(model.problem).bounds
        gap = abs(value - bound) / max(abs(value), _FLOOR)
        residual = max(task.violation(load_factor, slip), off, gap)
        return ApexClaim(node, corners, load_factor, slip, float(np.nan_to_num(residual, nan=np.inf)))

    def _never(self, task: Task, interface: Interface, rows: LoadRows, node: int) -> ApexClaim | None:
        """Proof that no safe slip at any load factor holds the node on both bounds; None where there is none."""
        model = self._model(task, interface, rows, node, Aim.EXCESS)

        def least_excess() -> tuple[float, float]:
            value, bound = Program(model.problem).bounds
            return -value, -bound

        def claimed() -> ApexClaim:
            value, bound = least_excess()
            slip = np.full(task.system.nodes, np.nan)
            return ApexClaim(node, _pair(task, node), np.inf, slip, 0.0 if bound > TOLERANCE else abs(value - bound))

        claim = self._solved(claimed, model)
        return claim if least_excess()[1] > TOLERANCE else None


def two_corners(task: Task) -> np.ndarray:
    """(N,) whether a node that is on both its bounds under a safe slip slips to and fro: forward at one corner, backward at another.

    Where one corner rules both bounds, the node only lifts off there; without friction it dissipates nothing.
    """
    forward, backward = _rulers(task)
    return np.asarray((forward & ~backward).any(axis=0) & (backward & ~forward).any(axis=0) & (task.friction > 0))


def _rulers(task: Task) -> tuple[np.ndarray, np.ndarray]:
    """(K, N) whether a corner rules the forward and the backward bound of a node, ties included."""
    f, q1, p1 = task.friction, task.loads.q1, task.loads.p1
    floor = _TIE * (np.abs(q1) + f * np.abs(p1)).max(axis=0)
    forward, backward = -(q1 + f * p1), q1 - f * p1
    return forward >= forward.max(axis=0) - floor, backward >= backward.max(axis=0) - floor


def _pair(task: Task, node: int) -> tuple[int, int]:
    """The corners of the forward and the backward bound of a node."""
    forward, backward = (rules[:, node] for rules in _rulers(task))
    return int(np.argmax(forward & ~backward)), int(np.argmax(backward & ~forward))
