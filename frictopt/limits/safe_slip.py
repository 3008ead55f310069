"""Existence of a safe residual slip at a given load factor."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, flag, frozen, listed
from ..contact.dispatch import answered_by_kind
from ..contact.tolerances import NO_MARGIN, RESIDUAL
from ..errors import ModelError
from ..solve.polish import Program
from ..solve.solvers import Answer, NoOptimum, solve, solver_order
from .mechanism import expand_duals
from .own_constraints import Expressions, Extendable, Extended, contradiction
from .posed import LimitQuestion, cycle_loads
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem, SafeSymbols
from .safe_slip_result import SafeSlip
from .scaling import Loads, ScaledContact
from .slip_bound import SlipBound, slip_bounds

__all__ = ["MarginState", "SafeSlipModel", "margin_problem", "safe_slip", "solve_margin"]


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


class SafeSlipModel(Extendable):
    """The safe residual slips of one system under one load cycle, for any friction and load factor, also under constraints of your own.

    Not for use by several threads at once: give each its own. Theory, eq. (9).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound, simplify, solver
        See `ShakedownModel`.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
    >>> model = fo.SafeSlipModel(rod, cycle)
    >>> round(model.solve(0.5, load_factor=0.8).margin, 6)
    0.2
    >>> round(model.solve(0.5, load_factor=0.8, constraints=[model.slip[0] - model.slip[1] <= 0.25]).margin, 6)
    -0.1
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify, self._solver = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify), solver
        solver_order(solver)

    @cached_property
    def _expressions(self) -> Expressions:
        task = LimitQuestion(self._system, self._cycle, self._loads, np.zeros(self._system.nodes), False, self._most)
        safe = margin_problem(scaled := task.scaled(), True, task.bound(scaled), free_load_factor=False)
        return Expressions(safe, self._loads, cp.Parameter(nonneg=True, name="load_factor"))

    @property
    def margin(self) -> cp.Expression:
        """The margin, see `SafeSlip`, a cvxpy expression for constraints of your own."""
        return self._expressions.unknown("margin")

    def solve(self, friction: Any, load_factor: float, constraints: Sequence[cp.Constraint] = ()) -> SafeSlip:
        """The residual slip with the largest reserve at every node and corner of the cycle, under constraints of your own.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node.
        load_factor
            Load factor, >= 0.
        constraints
            cvxpy constraints on `slip`, `q`, `p` and `margin` of this model, see `ShakedownModel.solve`; `bound` and `residual` cover them.

        Raises
        ------
        ModelError
            Bad input; a load factor so large that the mean load is lost in rounding; constraints that no slip obeys, safe or not, or that are not
            convex, not linear, or on another model.
        SolverError
            No solver gave an answer that passes the checks.
        """
        load_factor, own = finite_number("load_factor", load_factor, least=0.0), listed("constraints", constraints)
        task = LimitQuestion(self._system, self._cycle, self._loads, friction, self._simplify, self._most)
        task = replace(task, simplify=False) if own else task
        task.check_load_factor(load_factor)
        scaled = self._expressions.scaled if own else task.scaled()
        rows, extended = task.rows(scaled), None
        if own:
            extended = self._expressions.extended(own, None, rows, task.opening, load_factor)
        state, answer, model = solve_margin(task, scaled, task.loads, load_factor, self._solver, extended)
        return SafeSlip(
            load_factor=load_factor,
            exists=bool(state.margin >= -max(NO_MARGIN, state.residual)),
            slip=frozen(state.slip),
            margin=state.margin,
            bound=state.bound,
            record=task.record(answer.solver, answer.attempts, state.residual, task.left_out(rows)),
            constraints=extended.names if extended else (),
            problem=model.problem,
            _task=task,
            _motion=state.motion,
            _units={"margin": task.mean_bound, "traction": scaled.unit[scaled.loaded]},
        )


@answered_by_kind
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

    For constraints of your own see `SafeSlipModel`. Theory, eq. (9).

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

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.safe_slip(system, cycle, friction=0.5, load_factor=0.9).exists
    False
    """
    return SafeSlipModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver).solve(friction, load_factor)


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
        defect = task.defect(model.scaled, self.motion, self.slip)
        self.bound = cap + resistance - self.load_factor * drive + defect
        if not slips > 0 and cap < 1 - RESIDUAL:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        if model.own:
            self.bound, defect = Program(model.problem).bounds[1], 0.0
        gap = abs(self.bound - defect - self.margin) + defect  # a defect that closes the gap counts for slips like this one alone
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(gap, shortfall, task.beyond(self.slip), model.violation()), nan=np.inf))


def solve_margin(
    task: LimitQuestion, scaled: ScaledContact, loads: Loads, load_factor: float | None, solver: str | None, extended: Extended | None = None
) -> tuple[MarginState, Answer[MarginState], SafeProblem]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given; maybe under constraints of the user's own."""
    rows = task.rows(scaled, loads)
    model = extended.model if extended else margin_problem(scaled, task.opening, task.bound(scaled), free_load_factor=load_factor is None)
    model.set(rows, load_factor)
    model.problem.param_dict["clearance"].value = task.mean_bound / scaled.unit
    try:
        answer = solve(model, lambda: MarginState(task, rows, loads, load_factor, model), solver)
    except NoOptimum:
        if extended and (excess := contradiction(model.problem, solver)).bound > RESIDUAL:
            ruling = ", ".join(name for name in extended.names if name in excess.ruling)
            raise ModelError(f"{ruling}: no residual slip, safe or not, obeys this at load factor {load_factor:g}; drop or relax it") from None
        raise
    if extended:
        extended.save()
    return answer.claim, answer, model


def _shortfall(task: LimitQuestion, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds, or a node of a safe slip pulls, in force scales."""
    q = loads.q0 + load_factor * loads.q1 + task.system.A @ slip
    p = loads.p0 + load_factor * loads.p1 + task.system.B @ slip
    reserve = float(min((task.friction * p - np.abs(q)).min(), p.min() if task.opening else np.inf))
    pull = float(-p.min() / task.force) if margin >= 0 else 0.0
    return max(margin - reserve / task.mean_bound, pull, 0.0)
