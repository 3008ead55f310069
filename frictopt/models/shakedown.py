"""The shakedown limit lambda_2: the load factor above which no residual slip is safe."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, frozen
from ..errors import SolverError
from .explain import explain
from .mechanism import Mechanism, expand_duals
from .outcome import NoLimit, classify
from .safe import SafeProblem, shakedown_problem
from .solve import TOLERANCE, Attempt, solve
from .task import Corners, Task, cycle_loads, every_corner
from .uncoupled import uncoupled_limit

__all__ = ["ShakedownLimit", "ShakedownModel", "shakedown_limit"]


@dataclass(frozen=True, eq=False)
class ShakedownLimit:
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
        Largest of: what the referee says of `slip` at every corner, and the relative distance of `dual_bound`. At most 1e-9.
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
    slip: Array
    dual_bound: float
    residual: float
    solver: str
    attempts: tuple[Attempt, ...]
    left_out: tuple[str, ...]
    problem: cp.Problem | None = field(repr=False)
    _task: Task = field(repr=False)
    _motion: Mechanism = field(repr=False)
    _units: dict[str, float] = field(repr=False)

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load: columns node, x, corner, direction (+1 slips along +x), share of the total slip; largest first."""
        return self._motion.table(self._task.system.x)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all), one-sided at a kink."""
        pressure = self._task.loads.p0 + self._task.system.B @ self.slip
        return frozen(self._motion.friction_rate(self._task.loads, pressure, self.load_factor))

    @cached_property
    def load_rates(self) -> pd.DataFrame:
        """Rate of the limit with each amplitude of the load cycle: columns load, part ("mean" or "corner k"), amplitude, rate."""
        return self._motion.load_rates(self._task.system, self._task.cycle, self._task.friction, self.load_factor)

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the safe slip, at the limit, force per depth."""
        return self._task.reactions(self.load_factor, self.slip)

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("shakedown limit", self.problem, self._units, self.left_out, self.mechanism, file)


class ShakedownModel:
    """The shakedown limit of one system under one load cycle, compiled once and solved for any friction.

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
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options.
    """

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, simplify: bool = True, corners: Corners | None = None, solver: str | None = None
    ) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._simplify, self._every_corner, self._solver = simplify, every_corner(corners, simplify), solver
        self._compiled: dict[bool, tuple[Any, SafeProblem]] = {}  # by mirror symmetry, which friction can spoil

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
        closed = uncoupled_limit(self._system, self._loads, task.friction) if self._simplify else None
        if closed is not None:
            return _closed_form(task, *closed)
        return self._linear_program(task)

    def sweep(self, frictions: Any) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each.

        Columns: friction (mean over the nodes), load_factor, dual_bound, residual, friction_rate, node and direction of the largest share
        of the mechanism (-1 and 0 without one), solver.
        """
        return pd.DataFrame([_row(friction, self.solve(friction)) for friction in frictions])

    def _linear_program(self, task: Task) -> ShakedownLimit:
        if task.mirror not in self._compiled:
            interface = task.interface()
            self._compiled[task.mirror] = interface, shakedown_problem(interface, task.rows(interface).node)
        interface, model = self._compiled[task.mirror]
        rows = task.rows(interface)
        model.set(rows)

        def claimed() -> _Claim:
            motion = expand_duals(interface, rows, model.duals, task.system.nodes, task.loads.corners)
            load_factor = float(model.value("load_factor")) * rows.load_unit
            return _judged(task, load_factor, interface.slip @ model.value("traction"), motion, rows.load_unit)

        answer = solve(model, claimed, self._solver)
        claim = answer.claim or _no_limit(task, classify(task, interface, self._solver))
        units = {"load_factor": rows.load_unit, "traction": interface.force}
        return claim.result(answer.solver, answer.attempts, task.left_out(rows), model.problem, units)


def shakedown_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, simplify: bool = True, corners: Corners | None = None, solver: str | None = None
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe; above it no contact stops slipping (Flicek et al. 2015, section 4).

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
        self, solver: str, attempts: tuple[Attempt, ...], left_out: tuple[str, ...], problem: cp.Problem | None, units: dict[str, float]
    ) -> ShakedownLimit:
        slip, bound, residual = frozen(self.slip), float(self.bound), self.residual
        return ShakedownLimit(self.load_factor, slip, bound, residual, solver, attempts, left_out, problem, self.task, self.motion, units)


def _judged(task: Task, load_factor: float, slip: Array, motion: Mechanism, load_unit: float) -> _Claim:
    """Judge a limit from below by the referee and from above by the mechanism, which is scaled to unit drive."""
    resistance, drive = motion.work(task.loads, task.friction)
    if not drive > 0:
        return _Claim(task, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(1 / drive)
    bound = resistance / drive + task.defect(motion, slip)
    gap = abs(bound - load_factor) / max(load_factor, 1e-3 * load_unit)
    return _Claim(task, load_factor, slip, motion, bound, float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf)))


def _no_limit(task: Task, why: NoLimit) -> _Claim:
    """The claim, proven already, that there is no finite limit."""
    value = np.inf if why is NoLimit.UNBOUNDED else np.nan
    shape = task.loads.corners, task.system.nodes
    return _Claim(task, value, np.full(shape[1], np.nan), Mechanism(np.zeros(shape), np.zeros(shape)), value, 0.0)


def _closed_form(task: Task, load_factor: float, slip: Array, motion: Mechanism) -> ShakedownLimit:
    claim = _no_limit(task, NoLimit.UNBOUNDED) if load_factor == np.inf else _judged(task, load_factor, slip, motion, load_factor)
    if claim.residual > TOLERANCE:
        raise SolverError(f"uncoupled limit: its closed form has residual {claim.residual:.1e}; solve with simplify=False")
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
