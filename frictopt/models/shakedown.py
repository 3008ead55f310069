"""The shakedown limit lambda_2: the load factor above which no residual slip is safe."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, flag, frozen, listed
from ..errors import SolverError
from .explain import Units, explain
from .interface import Interface
from .mechanism import Mechanism, expand_duals
from .outcome import MarginState, NoLimit, classify
from .portable import Portable
from .rows import load_factor_unit
from .safe import SafeProblem, shakedown_problem
from .solve import TOLERANCE, Attempt, solve, solver_order
from .task import Corners, Task, cycle_loads, every_corner
from .uncoupled import uncoupled_limit

__all__ = ["ShakedownLimit", "ShakedownModel", "shakedown_limit"]


@dataclass(frozen=True, eq=False)
class ShakedownLimit(Portable):
    """The shakedown limit with its proof from both sides.

    Attributes
    ----------
    load_factor
        lambda_2; inf if every load factor has a safe slip, nan if none has, not even 0.
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
        explain("shakedown limit", self.problem, self.load_factor, self._units, self.left_out, self.mechanism, file)


class ShakedownModel:
    """The shakedown limit of one system under one load cycle, compiled once and solved for any friction.

    Not for use by several threads at once: give each its own.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    simplify
        Leave out what the scene does not need: the linear program of an uncoupled contact, half of a mirror-symmetric one, corners that rule no
        node. The answer is the same either way.
    corners
        "ruling": one row for each node and sense; "all": the same for every corner. By default "ruling", and "all" without `simplify`.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes. Asking for a solver, or for corners, asks for
        the linear program even where there is a closed form.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options.
    """

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, simplify: bool = True, corners: Corners | None = None, solver: str | None = None
    ) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._simplify, self._every_corner, self._solver = flag("simplify", simplify), every_corner(corners, simplify), solver
        self._closed_form = simplify and corners is None and len(solver_order(solver)) > 1  # a choice of either asks for the program
        self._compiled: dict[tuple[bool, bool], tuple[Interface, SafeProblem]] = {}  # by what friction can change, see `Task`

    def solve(self, friction: Any) -> ShakedownLimit:
        """The limit for a coefficient of friction, one or one per node.

        Raises
        ------
        ModelError
            Bad friction.
        SolverError
            No solver gave an answer that passes the checks.
        """
        task = Task(self._system, self._cycle, self._loads, friction, self._simplify, self._every_corner)
        closed = _closed_form(task) if self._closed_form else None
        if closed is not None:
            return closed
        try:
            return self._linear_program(task)
        except SolverError:  # a scene that is symmetric only up to its own tolerance may not meet that of the proof
            if not task.mirror:
                raise
            return self._linear_program(replace(task, simplify=False))

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
            self._compiled[kind] = interface, shakedown_problem(interface, task.rows(interface).node, task.opening)
        interface, model = self._compiled[kind]
        rows = task.rows(interface)
        model.set(rows)

        def claimed() -> _Claim:
            motion = expand_duals(interface, rows, model.duals, task.system.nodes, task.loads.corners)
            load_factor = max(float(model.value("load_factor")), 0.0) * rows.load_unit
            return _judged(task, interface, load_factor, interface.slip @ model.value("traction"), motion)

        def reason() -> _Claim | None:
            proof = classify(task, interface, self._solver)
            return None if proof is None else _no_limit(task, *proof)

        answer = solve(model, claimed, self._solver, no_optimum=reason)
        units = {"load_factor": rows.load_unit, "traction": interface.unit[interface.loaded]}
        return answer.claim.result(answer.solver, answer.attempts, task.left_out(rows), model.problem, units)


def shakedown_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, simplify: bool = True, corners: Corners | None = None, solver: str | None = None
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

    Safe means: every node closed and stuck at every corner of the cycle. For a sweep over friction compile a `ShakedownModel` once.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    simplify, corners, solver
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
    return ShakedownModel(system, cycle, simplify=simplify, corners=corners, solver=solver).solve(friction)


@dataclass(frozen=True, eq=False)
class _Claim:
    """A claimed limit with what is known against it."""

    task: Task
    load_factor: float
    slip: Array
    motion: Mechanism
    bound: float
    residual: float

    def result(
        self, solver: str, attempts: tuple[Attempt, ...], left_out: tuple[str, ...], problem: cp.Problem | None, units: Units
    ) -> ShakedownLimit:
        slip, bound, residual = frozen(self.slip), float(self.bound), self.residual
        return ShakedownLimit(self.load_factor, slip, bound, residual, solver, attempts, left_out, problem, self.task, self.motion, units)


def _judged(task: Task, interface: Interface, load_factor: float, slip: Array, motion: Mechanism) -> _Claim:
    """Judge a limit from below by the referee and from above by the mechanism, which is scaled to unit drive."""
    resistance, drive = motion.work(task.loads, task.friction)
    if not drive > 0:
        return _Claim(task, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(1 / drive)
    bound = resistance / drive + task.defect(interface, motion, slip)
    gap = abs(bound - load_factor) / max(load_factor, 1e-3 * load_factor_unit(task.loads, task.friction, task.force))
    return _Claim(task, load_factor, slip, motion, bound, float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf)))


def _no_limit(task: Task, why: NoLimit, proof: MarginState) -> _Claim:
    """The claim that there is no finite limit, with the residual of its proof; the mechanism proves that nothing is safe."""
    value = np.inf if why is NoLimit.UNBOUNDED else np.nan
    motion = proof.motion if why is NoLimit.NO_SAFE_SLIP else proof.motion.scaled(0.0)
    return _Claim(task, value, np.full(task.system.nodes, np.nan), motion, value, proof.residual)


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
