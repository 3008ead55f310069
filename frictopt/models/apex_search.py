"""Solving for one node on both its bounds, with proof of the least load factor or of its absence."""

from dataclasses import dataclass, field, replace
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact.checks import Array, finite_array, real_array
from ..errors import ModelError
from .apex import ApexProblem, SlipBound, apex_problem
from .explain import Units
from .interface import NULL, Interface
from .rows import LoadRows
from .solve import TOLERANCE, Attempt, solve
from .task import Task

__all__ = ["FLOOR", "ApexClaim", "ApexSearch", "slip_bounds", "two_corners"]

FLOOR = 1e-3
"""Load factors count relative to themselves from this share of the load unit on."""

_TIE = 1e-12  # corners whose rows differ by less than this share rule together
_ZERO = 1e-12  # dimensionless load factors up to this are rounding of 0


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


class ApexSearch:
    """The problems of all nodes, compiled once for any friction.

    Parameters
    ----------
    most
        (N,) largest slip; None for no bound.
    solver
        Use this one alone.
    """

    def __init__(self, most: Array | None, solver: str | None) -> None:
        self._most, self._solver = most, solver
        self._compiled: dict[tuple[bool, bool], ApexProblem] = {}

    def solve(self, task: Task, interface: Interface, ruling: LoadRows, node: int, *, likely: bool) -> ApexClaim:
        """The claim of one node that passes its checks.

        Whether the node is `likely` to be on both bounds anywhere decides only which of the two problems comes first.

        Raises
        ------
        SolverError
            No solver gave an answer that passes.
        """
        rows = task.rows(interface)
        denied = None if likely else self._never(task, interface, rows, ruling, node)
        if denied is not None:
            return denied
        model = self._model(task, interface, rows, reach=False)
        model.set(rows, ruling, node)

        def never() -> ApexClaim | None:
            return self._never(task, interface, rows, ruling, node)

        answer = solve(model, lambda: self._claimed(task, model, ruling, node), self._solver, no_optimum=never)
        units = {"load_factor": ruling.load_unit, "traction": interface.unit[interface.loaded]}
        return replace(answer.claim, solver=answer.solver, attempts=answer.attempts, problem=model.problem, units=units)

    def _model(self, task: Task, interface: Interface, rows: LoadRows, *, reach: bool) -> ApexProblem:
        kind = task.opening, reach
        if kind not in self._compiled:
            bound = None if self._most is None else SlipBound(interface.slip, _rigid(task), self._most)
            self._compiled[kind] = apex_problem(interface, rows.node, task.opening, bound, reach=reach)
        return self._compiled[kind]

    def _claimed(self, task: Task, model: ApexProblem, ruling: LoadRows, node: int) -> ApexClaim:
        corners = _pair(task, node)
        load_factor, slip = (model.load_factor if model.load_factor > _ZERO else 0.0) * ruling.load_unit, model.slip
        q, p = task.reactions(load_factor, slip)
        (forward, backward), f = corners, task.friction[node]
        off = max(abs(q[forward, node] + f * p[forward, node]), abs(q[backward, node] - f * p[backward, node])) / task.force
        value, bound = model.bounds
        gap = abs(value - bound) / max(value, FLOOR)
        beyond = 0.0
        if self._most is not None:
            rigid = _rigid(task)
            beyond = float(((np.abs(slip) - self._most) / max(float(self._most.max()), float(np.abs(slip).max()), np.finfo(float).tiny)).max())
            slip = slip if rigid.shape[1] or beyond > TOLERANCE else np.clip(slip, -self._most, self._most)
        residual = max(task.violation(load_factor, slip), off, gap, beyond)
        return ApexClaim(node, corners, load_factor, slip, float(np.nan_to_num(residual, nan=np.inf)))

    def _never(self, task: Task, interface: Interface, rows: LoadRows, ruling: LoadRows, node: int) -> ApexClaim | None:
        """Proof that no safe slip at any load factor holds the node on both bounds; None where there is none."""
        model = self._model(task, interface, rows, reach=True)
        model.set(rows, ruling, node)

        def claimed() -> ApexClaim:
            value, bound = model.bounds
            slip = np.full(task.system.nodes, np.nan)
            return ApexClaim(node, _pair(task, node), np.inf, slip, 0.0 if bound > TOLERANCE else abs(value - bound))

        answer = solve(model, claimed, self._solver)
        return replace(answer.claim, solver=answer.solver, attempts=answer.attempts) if model.bounds[1] > TOLERANCE else None


def two_corners(task: Task) -> np.ndarray:
    """(N,) whether a node that is on both its bounds under a safe slip slips to and fro: forward at one corner, backward at another.

    Where one corner rules both bounds, the node only lifts off there; without friction it dissipates nothing.
    """
    forward, backward = _rulers(task)
    return np.asarray((forward & ~backward).any(axis=0) & (backward & ~forward).any(axis=0) & (task.friction > 0))


def slip_bounds(slip_bound: Any, nodes: int) -> Array | None:
    """Check a slip bound, one or one per node, and return it as (N,).

    Raises
    ------
    ModelError
        Not real finite numbers, negative, or of a length other than 1 and N.
    """
    if slip_bound is None:
        return None
    shape = real_array("slip_bound", slip_bound).shape
    if shape not in ((), (nodes,)):
        raise ModelError(f"slip_bound: shape {shape}; give one length or one for each of the {nodes} nodes")
    most = finite_array("slip_bound", slip_bound, shape)
    if most.min() < 0:
        raise ModelError(f"slip_bound: {most.min():g}; it bounds the size of the slip, give a length >= 0, or None for no bound")
    return np.broadcast_to(most, (nodes,))


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


def _rigid(task: Task) -> Array:
    """(N, k) slips that need no force."""
    values, vectors = np.linalg.eigh(task.system.A)
    return np.asarray(vectors[:, values <= NULL * max(np.abs(task.system.A).max(), np.abs(task.system.C).max())])
