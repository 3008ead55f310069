"""Existence of a safe residual slip at a given load factor."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import RESIDUAL, Array, ContactSystem, LoadCycle, finite_number, listed, warns_of_odd_values
from ..errors import ModelError, SolverError
from ..solve.solvers import NoOptimum, contradiction, solve
from .friction_bounds import safe_set
from .judge import answered, judged_margin
from .own_rows import OF_A_MODEL
from .parts import half_of, rest_under_mean
from .question import LimitQuestion
from .safe_model import SafeModel, in_turn
from .safe_set import SafeSet
from .safe_slip_result import SafeSlip

_MOST_CYCLIC = 1e15  # cyclic loads above so many mean normal forces have none of their digits


def margin_problem(v: SafeSet, *, free_load_factor: bool = False) -> cp.Problem:
    """Residual slip v that stays furthest inside the friction bounds, at a given load factor lam or at whatever one is best.

    In full, with the margin counted in mean friction bounds of the mean load, each `clearance` of its node::

        max margin   s.t.   f p_k - |q_k| >= clearance margin,   margin <= 1   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    Negative: there is no safe slip. With little friction p has the margin too. For the rows see `shakedown_problem`.
    """
    lam, margin = v.load_factor if free_load_factor else None, v.margin
    rows = {**v.stuck(lam, margin), "cap": margin <= 1}
    if lam is not None:
        rows["load_factor_not_negative"] = lam >= 0
    return v.program(cp.Maximize(margin), rows)


class SafeSlipModel(SafeModel):
    """The safe residual slips of one system under one load cycle, for any friction and load factor, also under constraints of your own.

    Threads that ask one model wait for each other. Theory, eq. (9).

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

    _closing: float | Array = np.inf
    """Friction with which some slip is known to be safe at some load factor, all nodes closed; it is so with more."""

    _opening: float | Array = -np.inf
    """Friction with which none is known to be; it is so with less."""

    _left: tuple[bytes, LimitQuestion | None] = b"", None
    """The question of what the mean load leaves closed, and the friction of which it was asked last."""

    _given = True
    load_factor: cp.Parameter
    """The load factor that is given, a cvxpy parameter for constraints of your own."""

    @cached_property
    def margin(self) -> cp.Variable:
        """The margin, see `SafeSlip`, a cvxpy variable for constraints of your own."""
        return cp.Variable(name=OF_A_MODEL + "margin")

    def _meant(self, v: SafeSet) -> dict[cp.Variable, cp.Expression]:
        return {**super()._meant(v), self.margin: v.margin}

    @warns_of_odd_values
    @in_turn
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
            convex, need other cones, or are on another model.
        SolverError
            No solver gave an answer that passes the checks.
        """
        safe = self.of_any_set(self._posed(friction), load_factor, listed("constraints", constraints))
        return self._shown(safe, margin=safe.margin)

    def of_any_set(self, task: LimitQuestion, load_factor: float, own: Sequence[cp.Constraint] = ()) -> SafeSlip:
        """The slip with all nodes closed; where none is safe then at any load factor, that of those which the mean load leaves closed."""
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        task = replace(task, simplify=False) if own else task
        largest = load_factor / task.force * float(np.abs(task.r1).max())
        if largest > _MOST_CYCLIC:
            raise ModelError(
                f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean normal force {task.force:.3g} of the mean load, "
                "which is lost in their rounding; give less, or check the units of the load cases"
            )

        def safe_of(task: LimitQuestion) -> SafeSlip:
            program = self._program(margin_problem, half_of(task), own, load_factor=load_factor)
            return solve_margin(task, load_factor, self._solver, program)

        unsafe = bool((task.friction <= self._opening).all())
        try:
            safe = None if own or unsafe else safe_of(task)  # own constraints may contradict each other where all nodes are closed
        except SolverError:  # a slip that hardly anything resists, as a roll, can hide the margin, and not that none is safe
            if self._closed_somewhere(task):
                raise
            safe, unsafe = None, True
        if safe is None or not safe.exists:
            rest = self._rest(task) if unsafe or not self._closed_somewhere(task) else None
            safe = safe_of(rest) if rest else safe or safe_of(task)
        return safe

    def _rest(self, task: LimitQuestion) -> LimitQuestion | None:
        """See `rest_under_mean`."""
        friction = task.friction.tobytes()
        if friction != self._left[0]:
            self._left = friction, rest_under_mean(task)
        return self._left[1]

    def _closed_somewhere(self, task: LimitQuestion) -> bool:
        """Whether some slip is safe with all nodes closed at some load factor; it is taken to be so where that cannot be told."""
        if (task.friction >= self._closing).all() or task.violation(0.0, np.zeros(task.system.slip_shape)) <= RESIDUAL:
            return True
        try:
            closed = solve_margin(task, None, self._solver).exists
        except SolverError:
            return True
        if closed:
            self._closing = task.friction
        else:
            self._opening = task.friction
        return closed


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
    model = SafeSlipModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
    return model.of_any_set(model._posed(friction), load_factor)


def solve_margin(task: LimitQuestion, load_factor: float | None, solver: str | None, program: SafeSet | None = None) -> SafeSlip:
    """Largest margin of a safe slip at a load factor, or (None) at the best one; in a program that is there already, or in one of its own."""
    v = program
    if v is None:
        v = safe_set(half_of(task))
        v.ask(v.task, load_factor)
        v = v.posed(margin_problem(v, free_load_factor=load_factor is None))
    try:
        found = solve(v.problem, lambda: judged_margin(v, load_factor), solver)
    except NoOptimum:
        if v.own.rows and (excess := contradiction(v.problem, solver)).bound > RESIDUAL:
            ruling = ", ".join(name for name in v.own.names if name in excess.ruling)
            raise ModelError(f"{ruling}: no residual slip, safe or not, obeys this at load factor {load_factor:g}; drop or relax it") from None
        raise
    v.own.save()
    return answered(found, v)
