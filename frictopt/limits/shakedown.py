"""The shakedown limit lambda_2: the load factor above which no residual slip is safe."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, flag, frozen, listed
from ..solve.explain import Units, explain
from ..solve.portable import Portable
from ..solve.solvers import TOLERANCE, Attempt, solve, solver_order
from .closed_form import uncoupled_limit
from .kinds import LimitKind, MarginState, classify, reason
from .mechanism import Mechanism, expand_duals
from .posed import Task, cycle_loads
from .ruling_corners import load_factor_unit
from .safe_set import SafeProblem, shakedown_problem
from .scaling import Interface
from .slip_bound import slip_bounds

__all__ = ["ShakedownLimit", "ShakedownModel", "shakedown_limit"]


@dataclass(frozen=True, eq=False)
class ShakedownLimit(Portable):
    """The shakedown limit with its proof from both sides.

    Attributes
    ----------
    load_factor
        lambda_2; inf if every load factor has a safe slip, nan if none has, not even 0.
    kind, reason
        Which of these it is, and why in words.
    slip
        (N,) a residual slip that is safe at the limit, length; NaN where `load_factor` is not finite.
    dual_bound
        Upper bound of the limit from the mechanism alone; equals `load_factor` up to `residual`.
    residual
        Largest of: what the referee says of `slip` at every corner, and the relative distance of `dual_bound`; without a finite limit, that of the
        proof. At most 1e-9.
    solver
        Who answered: a solver's name, or "closed form".
    attempts
        All solver runs, in order.
    left_out
        What the scene did not need.
    problem
        The solved cvxpy problem; None for a closed form. A later solve of the same `ShakedownModel` overwrites its values.
    """

    load_factor: float
    kind: LimitKind
    reason: str
    slip: Array = field(repr=False)
    dual_bound: float
    residual: float
    solver: str
    attempts: tuple[Attempt, ...] = field(repr=False)
    left_out: tuple[str, ...]
    problem: cp.Problem | None = field(repr=False)
    _task: Task = field(repr=False)
    _motion: Mechanism = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load: columns node, x, corner, direction (+1 slips along +x), share of the total slip; largest first."""
        return self._motion.table(self._task.system.x)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its supergradients. NaN without a finite limit.
        """
        if not np.isfinite(self.load_factor):
            return self.slip
        pressure = self._task.loads.p0 + self._task.system.B @ self.slip
        return frozen(self._motion.friction_rate(self._task.loads, pressure, self.load_factor))

    @cached_property
    def load_rates(self) -> pd.DataFrame:
        """Rate of the limit with each amplitude of the load cycle: columns load, part ("mean" or "corner k"), amplitude, rate.

        NaN without a finite limit.
        """
        return self._motion.load_rates(self._task.system, self._task.cycle, self._task.friction, self.load_factor)

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the safe slip, at the limit, force per depth; NaN without a finite limit."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.load_factor, self.slip)

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("shakedown limit", self.problem, self.load_factor, self._units, self.left_out, self.mechanism, file, self.reason)


class ShakedownModel:
    """The shakedown limit of one system under one load cycle, compiled once and solved for any friction.

    Not for use by several threads at once: give each its own.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `abs(v)` that assembly can leave, one or one per node, length; None for no bound. A slide of the whole body counts: where nothing
        resists one, the program chooses it.
    simplify
        Leave out what the scene does not need: the linear program of an uncoupled contact, half of a mirror-symmetric one. The answer is the same
        either way. Corners that rule no node never have rows.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes. Asking for a solver asks for the linear
        program even where there is a closed form.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify, self._solver = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify), solver
        self._closed_form = simplify and len(solver_order(solver)) > 1
        self._compiled: dict[tuple[bool, bool], SafeProblem] = {}  # by what friction can change, see `Task`

    def solve(self, friction: Any) -> ShakedownLimit:
        """The limit for a coefficient of friction, one or one per node.

        Raises
        ------
        ModelError
            Bad friction.
        SolverError
            No solver gave an answer that passes the checks.
        """
        task = Task(self._system, self._cycle, self._loads, friction, self._simplify, self._most)
        closed = _closed_form(task) if self._closed_form else None
        return self._linear_program(task) if closed is None else closed

    def sweep(self, frictions: Any) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each.

        Columns: friction (mean over the nodes), load_factor, dual_bound, residual, friction_rate, node and direction of the largest share
        of the mechanism (-1 and 0 without one), solver.

        Raises
        ------
        ModelError
            Not a sequence, or bad friction in it.
        SolverError
            No solver gave an answer that passes the checks.
        """
        return pd.DataFrame([_row(friction, self.solve(friction)) for friction in listed("frictions", frictions)])

    def _linear_program(self, task: Task) -> ShakedownLimit:
        kind = task.mirror, task.opening
        if kind not in self._compiled:
            interface = task.interface()
            self._compiled[kind] = shakedown_problem(interface, task.opening, task.bound(interface))
        model = self._compiled[kind]
        interface = model.interface
        rows = task.rows(interface)
        model.set(rows)

        def claimed() -> _Claim:
            motion = expand_duals(model, rows, task.system.nodes, task.loads.corners)
            load_factor = max(0.0, float(model.value("load_factor"))) * rows.load_unit  # in this order -0 becomes 0
            return _judged(task, interface, load_factor, task.within_bound(model.slip), motion)

        def no_limit() -> _Claim | None:
            proof = classify(task, interface, self._solver)
            return None if proof is None else _no_limit(task, *proof)

        answer = solve(model, claimed, self._solver, no_optimum=no_limit)
        units = {"load_factor": rows.load_unit, "traction": interface.unit[interface.loaded]}
        return answer.claim.result(answer.solver, answer.attempts, task.left_out(rows), model.problem, units)


def shakedown_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

    Safe means: every node closed and stuck at every corner of the cycle. For a sweep over friction compile a `ShakedownModel` once.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    slip_bound, simplify, solver
        See `ShakedownModel`.

    Returns
    -------
    ShakedownLimit
        `load_factor` is finite, inf (no limit) or nan (no safe slip at any load factor): each is an answer.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    return ShakedownModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver).solve(friction)


@dataclass(frozen=True, eq=False)
class _Claim:
    """A claimed limit with what is known against it."""

    task: Task
    kind: LimitKind
    load_factor: float
    slip: Array
    motion: Mechanism
    bound: float
    residual: float

    def result(
        self, solver: str, attempts: tuple[Attempt, ...], left_out: tuple[str, ...], problem: cp.Problem | None, units: Units
    ) -> ShakedownLimit:
        why, slip, bound = reason(self.task, self.kind, self.load_factor), frozen(self.slip), float(self.bound)
        return ShakedownLimit(
            self.load_factor, self.kind, why, slip, bound, self.residual, solver, attempts, left_out, problem, self.task, self.motion, units
        )


def _judged(task: Task, interface: Interface, load_factor: float, slip: Array, motion: Mechanism) -> _Claim:
    """Judge a limit from below by the referee and from above by the mechanism, which is scaled to unit drive."""
    resistance, drive = motion.work(task.loads, task.friction, task.most)
    if not drive > 0:
        return _Claim(task, LimitKind.FINITE, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(1 / drive)
    bound = resistance / drive + task.defect(interface, motion, slip)
    gap = abs(bound - load_factor) / max(load_factor, 1e-3 * load_factor_unit(task.loads, task.friction, task.force))
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return _Claim(task, LimitKind.FINITE, load_factor, slip, motion, bound, residual)


def _no_limit(task: Task, kind: LimitKind, proof: MarginState) -> _Claim:
    """The claim that there is no finite limit, with the residual of its proof; the mechanism proves that nothing is safe."""
    value = np.inf if kind is LimitKind.UNBOUNDED else np.nan
    motion = proof.motion if kind is LimitKind.NO_SAFE_SLIP else proof.motion.scaled(0.0)
    return _Claim(task, kind, value, np.full(task.system.nodes, np.nan), motion, value, proof.residual)


def _closed_form(task: Task) -> ShakedownLimit | None:
    """The limit of an uncoupled contact; None where it has no closed form that passes the checks."""
    closed = uncoupled_limit(task.system, task.loads, task.friction)
    if closed is None:
        return None
    claim = _judged(task, task.interface(), *closed)
    if claim.residual > TOLERANCE:
        return None
    return claim.result("closed form", (), ("linear program: the contact is uncoupled (B = 0), the limit has a closed form",), None, {})


def _row(friction: Any, limit: ShakedownLimit) -> dict[str, Any]:
    first = limit.mechanism.iloc[0] if len(limit.mechanism) else None
    return {
        "friction": float(np.mean(friction)),
        "load_factor": limit.load_factor,
        "dual_bound": limit.dual_bound,
        "residual": limit.residual,
        "friction_rate": float(limit.friction_rate.sum()),
        "node": -1 if first is None else int(first["node"]),
        "direction": 0 if first is None else int(first["direction"]),
        "solver": limit.solver,
    }
