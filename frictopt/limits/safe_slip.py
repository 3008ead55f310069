"""Existence of a safe residual slip at a given load factor."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, frozen
from ..contact.record import Recorded, SolveRecord
from ..contact.show import frame
from ..solve.explain import Units, explain
from ..solve.portable import Portable
from ..solve.solvers import TOLERANCE, Answer, solve
from .mechanism import Mechanism, expand_duals
from .posed import LimitQuestion, cycle_loads
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem, SafeSymbols
from .scaling import Loads, ScaledContact
from .slip_bound import SlipBound, slip_bounds

__all__ = ["MarginState", "SafeSlip", "margin_problem", "safe_slip", "solve_margin"]

_ROUNDING = 1e-12  # margins this little below zero are zero: those at the shakedown limit itself


def margin_problem(contact: ScaledContact, opening: bool, bound: SlipBound | None, free_load_factor: bool) -> SafeProblem:
    """Residual slip v that stays furthest inside the friction bounds, at a given load factor lam or at whatever one is best.

    In full, with the margin counted in mean friction bounds of the mean load, each `clearance` of its node::

        max margin   s.t.   f p_k - |q_k| >= clearance margin,   margin <= 1   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    Negative: there is no safe slip. For forward, backward, opening and the bound see `shakedown_problem`; with little friction p has the margin too.
    """
    lam, margin, v = cp.Variable(name="load_factor") if free_load_factor else 1.0, cp.Variable(name="margin"), SafeSymbols(contact)
    reserve = cp.multiply(cp.Parameter(v.q.size, nonneg=True, name="clearance"), margin)
    rows = {
        "no_forward_slip": v.q + v.fp >= v.forward * lam + reserve,
        "no_backward_slip": v.fp - v.q >= v.backward * lam + reserve,
        "no_opening": v.p >= v.opening * lam + reserve,
        "cap": margin <= 1,
    }
    if free_load_factor:
        rows["load_factor_not_negative"] = lam >= 0
    return v.problem(cp.Maximize(margin), rows, opening, bound)


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Recorded, Portable):
    """A residual slip that keeps the contact stuck, or the proof that there is none.

    Attributes
    ----------
    exists
        Whether a safe slip exists at the load factor: the margin is not negative by more than 1e-12 or its own residual.
    slip
        (N,) the slip that stays furthest inside the friction bounds, length (the least unsafe one if none is safe); within the slip bound.
    margin
        Its smallest reserve `f p - |q|` over nodes and corners, in mean friction bounds of the mean load, at most 1; negative: none is safe.
        With friction below 0.01 somewhere the reserve of p counts as well.
    margin_bound
        Upper bound of the margin from the multipliers alone; equals `margin` up to `residual`.
    record
        How it was found. Its `residual` is the largest of: the shortfall of the slip's reserve, recomputed, and the distance of `margin_bound`. At
        most 1e-9.
    problem
        The solved cvxpy problem; None in a copy.
    """

    exists: bool
    slip: Array = field(repr=False)
    margin: float
    margin_bound: float
    record: SolveRecord
    problem: cp.Problem | None = field(repr=False)
    _task: LimitQuestion = field(repr=False)
    _motion: Mechanism = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def certificate(self) -> pd.DataFrame | None:
        """Why no slip is safe (Farkas's lemma); None if one is.

        A table like `ShakedownLimit.mechanism`: slips whose friction cannot take up the work of the loads, while no residual slip does work
        on them, or with a slip bound too little.
        """
        return None if self.exists else self._motion.table(self._task.system.x)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x and slip."""
        return frame({"node": range(len(self.slip)), "x": self._task.system.x, "slip": self.slip})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("exists", "margin", "margin_bound", "residual")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("safe residual slip", self.problem, self.margin, self._units, self.record.left_out, self._motion.table(self._task.system.x), file)


def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    slip_bound: Any = None,
    simplify: bool = True,
    solver: str | None = None,
) -> SafeSlip:
    """Find the residual slip with the largest reserve at every node and corner of the cycle.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    slip_bound, simplify, solver
        See `ShakedownModel`.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    loads = cycle_loads(system, cycle)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    task = LimitQuestion(system, cycle, loads, friction, simplify, slip_bounds(slip_bound, system.nodes))
    scaled = task.scaled()
    state, answer, model = solve_margin(task, scaled, task.loads, load_factor, solver)
    return SafeSlip(
        exists=bool(state.margin >= -max(_ROUNDING, state.residual)),
        slip=frozen(state.slip),
        margin=state.margin,
        margin_bound=state.bound,
        record=task.record(answer.solver, answer.attempts, state.residual, task.left_out(task.rows(scaled))),
        problem=model.problem,
        _task=task,
        _motion=state.motion,
        _units={"margin": task.mean_bound, "traction": scaled.unit[scaled.loaded]},
    )


class MarginState:
    """Solution of a margin problem: margin, slip, the mechanism of its multipliers, and its residual."""

    def __init__(self, task: LimitQuestion, rows: RulingLoads, loads: Loads, load_factor: float | None, model: SafeProblem) -> None:
        self.margin = float(model.value("margin"))
        self.slip: Array = task.within_bound(model.slip)
        self.load_factor = float(model.value("load_factor")) * rows.load_unit if load_factor is None else load_factor
        motion = expand_duals(model, rows, loads.corners)
        cap, slips = float(model.dual("cap")), float(motion.total.sum() + motion.opening.sum()) * task.mean_bound
        self.motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(loads, task.friction, task.most)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        self.bound = cap + resistance - self.load_factor * drive + task.defect(model.scaled, self.motion, self.slip)
        if not slips > 0 and cap < 1 - TOLERANCE:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(abs(self.bound - self.margin), shortfall, task.beyond(self.slip)), nan=np.inf))


def solve_margin(
    task: LimitQuestion, scaled: ScaledContact, loads: Loads, load_factor: float | None, solver: str | None
) -> tuple[MarginState, Answer[MarginState], SafeProblem]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given."""
    rows = task.rows(scaled, loads)
    model = margin_problem(scaled, task.opening, task.bound(scaled), free_load_factor=load_factor is None)
    model.set(rows, load_factor)
    model.problem.param_dict["clearance"].value = task.mean_bound / scaled.unit

    answer = solve(model, lambda: MarginState(task, rows, loads, load_factor, model), solver)
    return answer.claim, answer, model


def _shortfall(task: LimitQuestion, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds, or a node of a safe slip pulls, in force scales."""
    q = loads.q0 + load_factor * loads.q1 + task.system.A @ slip
    p = loads.p0 + load_factor * loads.p1 + task.system.B @ slip
    reserve = float(min((task.friction * p - np.abs(q)).min(), p.min() if task.opening else np.inf))
    pull = float(-p.min() / task.force) if margin >= 0 else 0.0
    return max(margin - reserve / task.mean_bound, pull, 0.0)
