"""Existence of a safe residual slip at a given load factor."""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, flag, frozen, listed
from ..contact.coulomb import lengths
from ..contact.odd_values import warns_of_odd_values
from ..contact.tolerances import NO_MARGIN, RESIDUAL
from ..errors import ModelError
from ..solve.polish import Program as StandardForm
from ..solve.solvers import Answer, NoOptimum, solve, solver_order
from .loads import Loads, cycle_loads
from .own_constraints import Expressions, Extendable, Extended, contradiction
from .plane import PlaneProgram, PlaneQuestion
from .pose import bounded, kind_of, plane, pose
from .question import LimitQuestion
from .safe_slip_result import SafeSlip
from .space import ConeProgram, SpaceQuestion

__all__ = ["MarginState", "SafeSlipModel", "margin_problem", "safe_slip", "solve_margin"]


def margin_problem(v: Any, *, free_load_factor: bool = False) -> Any:
    """Residual slip v that stays furthest inside the friction bounds, at a given load factor lam or at whatever one is best.

    In full, with the margin counted in mean friction bounds of the mean load, each `clearance` of its node::

        max margin   s.t.   f p_k - |q_k| >= clearance margin,   margin <= 1   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    Negative: there is no safe slip. With little friction p has the margin too. For the rows see `shakedown_problem`.
    """
    lam, margin = cp.Variable(name="load_factor") if free_load_factor else None, cp.Variable(name="margin")
    rows = {**v.stuck(lam, margin), "cap": margin <= 1}
    if lam is not None:
        rows["load_factor_not_negative"] = lam >= 0
    return v.problem(cp.Maximize(margin), rows)


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

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: ArrayLike | None = None, simplify: bool = True, solver: str | None = None
    ) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify, self._solver = bounded(slip_bound, system), flag("simplify", simplify), solver
        solver_order(solver, kind_of(system))

    @cached_property
    def _expressions(self) -> Expressions:
        task = PlaneQuestion(self._system, self._cycle, self._loads, np.zeros(self._system.nodes), False, self._most)
        return Expressions(margin_problem(task.symbols()), self._loads, cp.Parameter(nonneg=True, name="load_factor"))

    @property
    def margin(self) -> cp.Expression:
        """The margin, see `SafeSlip`, a cvxpy expression for constraints of your own."""
        return self._expressions.unknown("margin")

    def solve(self, friction: ArrayLike, load_factor: float, constraints: Sequence[cp.Constraint] = ()) -> SafeSlip:
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
        task, extended = pose(self._system, self._cycle, friction, self._simplify and not own, self._most, self._loads), None
        task.check_load_factor(load_factor)
        if own:
            task = plane(task)
            extended = self._expressions.extended(own, None, task.rows(self._expressions.scaled), task.opening, load_factor)
        answer, program = solve_margin(task, task.loads, load_factor, self._solver, extended)
        state = answer.claim
        return SafeSlip(
            load_factor=load_factor,
            exists=state.exists,
            slip=frozen(state.slip),
            margin=state.margin,
            bound=state.bound,
            record=task.record(answer.solver, answer.attempts, state.residual, program.left_out),
            constraints=extended.names if extended else (),
            problem=program.problem,
            _task=task,
            _motion=state.motion,
            _units=program.units,
        )


@warns_of_odd_values
def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    slip_bound: ArrayLike | None = None,
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

    def __init__(self, program: PlaneProgram | ConeProgram, loads: Loads, load_factor: float | None, own: cp.Problem | None) -> None:
        task = program.task
        self.margin, self.slip = program.value("margin"), program.slip
        self.load_factor = program.value("load_factor") * task.load_unit if load_factor is None else load_factor
        motion, cap, slips = program.motion, program.cap("cap"), program.weight
        self.motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(loads, task.most)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        off = program.defect(self.motion, self.slip)
        self.bound = cap + resistance - self.load_factor * drive + off
        if not slips > 0 and cap < 1 - RESIDUAL:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        if own is not None:
            self.bound, off = StandardForm(own).bounds[1], 0.0
        gap = abs(self.bound - off - self.margin) + off  # a defect that closes the gap counts for slips like this one alone
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(gap, shortfall, task.beyond(self.slip), program.violation), nan=np.inf))
        self.exists = bool(self.margin >= -max(NO_MARGIN, self.residual))


def solve_margin(
    task: PlaneQuestion | SpaceQuestion, loads: Loads, load_factor: float | None, solver: str | None, extended: Extended | None = None
) -> tuple[Answer[MarginState], PlaneProgram | ConeProgram]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given; maybe under constraints of the user's own."""
    if extended:
        program: PlaneProgram | ConeProgram = plane(task).with_data(extended.model, loads, load_factor)
    else:
        program = task.posed(partial(margin_problem, free_load_factor=load_factor is None), loads, load_factor)
    own = program.problem if extended else None
    try:
        answer = solve(program, lambda: MarginState(program, loads, load_factor, own), solver, kind=kind_of(task.system))
    except NoOptimum:
        if extended and (excess := contradiction(program.problem, solver)).bound > RESIDUAL:
            ruling = ", ".join(name for name in extended.names if name in excess.ruling)
            raise ModelError(f"{ruling}: no residual slip, safe or not, obeys this at load factor {load_factor:g}; drop or relax it") from None
        raise
    if extended:
        extended.save()
    return answer, program


def _shortfall(task: LimitQuestion, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds, or a node of a safe slip pulls, in force scales."""
    q, p = task.reactions(load_factor, slip, loads)
    reserve = float(min((task.friction * p - lengths(q, p)).min(), p.min() if task.opening else np.inf))
    pull = float(-p.min() / task.force) if margin >= 0 else 0.0
    return max(margin - reserve / task.mean_bound, pull, 0.0)
