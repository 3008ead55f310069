"""The shakedown limit lambda_2: the load factor above which no residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987)."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.answers import LimitKind
from ..contact.checks import flag, listed
from ..contact.dispatch import answered_by_kind
from ..contact.tolerances import RESIDUAL
from ..solve.explain import Units
from ..solve.solvers import solve, solver_order
from .closed_form import uncoupled_ends
from .kinds import classify
from .least_load import with_least_load
from .mechanism import expand_duals
from .own_constraints import Expressions, Extendable
from .posed import LimitQuestion, cycle_loads
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem, SafeSymbols
from .scaling import ScaledContact
from .shakedown_result import LimitClaim, ShakedownLimit, judged, judged_extended, no_limit_claim, no_limit_under
from .slip_bound import SlipBound, slip_bounds

__all__ = ["ShakedownModel", "shakedown_limit", "shakedown_problem"]


def shakedown_problem(contact: ScaledContact, opening: bool, bound: SlipBound | None) -> SafeProblem:
    """Largest load factor lam at which some residual slip v keeps every node closed and stuck at every corner k of the load cycle.

    In full::

        max lam   s.t.   |q_k| <= f p_k,  p_k >= 0   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        forward = max_k -(q1_k + f p1_k),   backward = max_k (q1_k - f p1_k),   opening = max_k -p1_k

    `p >= 0` follows from the other two where there is friction; for little or none, `opening` keeps its rows. The bound is `abs(v) <= slip_bound`.
    """
    lam, v = cp.Variable(name="load_factor"), SafeSymbols(contact)
    rows = {
        "no_forward_slip": v.q + v.fp >= v.forward * lam,
        "no_backward_slip": v.fp - v.q >= v.backward * lam,
        "no_opening": v.p >= v.opening * lam,
        "load_factor_not_negative": lam >= 0,
    }
    return v.problem(cp.Maximize(lam), rows, opening, bound)


class ShakedownModel(Extendable):
    """The shakedown limit of one system under one load cycle, compiled once and solved for any friction.

    Not for use by several threads at once: give each its own. Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `abs(v)` that assembly can leave, one or one per node, length; None for no bound. A slide of the whole body counts: where nothing
        resists one, the program chooses it.
    simplify
        Leave out what cannot change the answer: the linear program of an uncoupled contact, half of a mirror-symmetric one. Corners that rule no node
        never have rows.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes. Asking for a solver asks for the linear
        program even where there is a closed form.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.

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
    >>> model = fo.ShakedownModel(system, cycle)
    >>> model.sweep([0.3, 0.5])[["friction", "load_factor"]].round(6)
       friction  load_factor
    0       0.3     0.313636
    1       0.5     0.535714
    >>> round(model.solve(0.5, constraints=[model.slip[0] >= 0.1]).load_factor, 6)
    0.502381
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify, self._solver = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify), solver
        self._closed_form = simplify and len(solver_order(solver)) > 1
        self._compiled: dict[tuple[int, bool], SafeProblem] = {}  # by what friction can change: the part of the contact, and the rows of opening

    def solve(self, friction: Any, constraints: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None) -> ShakedownLimit:
        """The limit for a coefficient of friction, one or one per node, under constraints of your own, or the slip that your objective chooses.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node.
        constraints
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units, and on variables of your own. They are linear, or of
            abs, max, norm1 and the like: the program stays linear, and its multipliers prove the limit. `bound` and `residual` cover them. The
            whole contact is solved then, and the program is compiled once for the same constraints.
        objective
            What shall be largest over the safe slips, instead of the load factor: a concave cvxpy expression on the same, also linear or of abs, max,
            norm1 and the like, such as `model.load_factor - 0.1 * cp.norm1(model.slip)`. See `ShakedownLimit.objective`.

        Raises
        ------
        ModelError
            Bad friction; constraints that are not convex, not linear, or on another model; an objective that is not so, or has no largest value.
        SolverError
            No solver gave an answer that passes the checks.

        Examples
        --------
        The smallest residual slip that is safe at a load factor:

        >>> import cvxpy as cp
        >>> import frictopt as fo
        >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
        >>> model = fo.ShakedownModel(rod, cycle)
        >>> limit = model.solve(0.5, [model.load_factor == 0.8], objective=-cp.norm1(model.slip))
        >>> round(limit.objective, 6)
        -0.3
        """
        task = LimitQuestion(self._system, self._cycle, self._loads, friction, self._simplify, self._most)
        own = listed("constraints", constraints)
        if own or objective is not None:
            return self._extended_program(replace(task, simplify=False), own, objective)
        closed = _closed_form(task) if self._closed_form else None
        return self._linear_program(task) if closed is None else closed

    def sweep(self, frictions: Any, constraints: Sequence[cp.Constraint] = ()) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each, under constraints of your own as in `solve`.

        Columns: friction (mean over the nodes), load_factor, least, bound, residual, friction_rate, node and direction of the largest share
        of the mechanism (-1 and 0 without one), solver.

        Raises
        ------
        ModelError
            Not a sequence, or bad friction in it.
        SolverError
            No solver gave an answer that passes the checks.
        """
        own = listed("constraints", constraints)
        return pd.DataFrame([_row(friction, self.solve(friction, own)) for friction in listed("frictions", frictions)])

    def _program(self, task: LimitQuestion) -> SafeProblem:
        """The program over safe slips, compiled once for all frictions."""
        kind = task.part.nodes, task.opening
        if kind not in self._compiled:
            scaled = task.scaled()
            self._compiled[kind] = shakedown_problem(scaled, task.opening, task.bound(scaled))
        return self._compiled[kind]

    def _linear_program(self, task: LimitQuestion) -> ShakedownLimit:
        model = self._program(task)
        scaled = model.scaled
        rows = task.rows(scaled)
        model.set(rows)

        def claimed() -> LimitClaim:
            motion = expand_duals(model, rows, task.loads.corners)
            load_factor = max(0.0, float(model.value("load_factor"))) * rows.load_unit  # in this order -0 becomes 0
            return judged(task, scaled, load_factor, task.within_bound(model.slip), motion)

        def no_limit() -> LimitClaim | None:
            proof = classify(task, scaled, self._solver)
            return None if proof is None else no_limit_claim(task, *proof)

        answer = with_least_load(solve(model, claimed, self._solver, no_optimum=no_limit), model, rows, self._solver)
        return answer.claim.result(answer.solver, answer.attempts, task.left_out(rows), model.problem, _units(scaled, rows))

    @cached_property
    def _expressions(self) -> Expressions:
        task = LimitQuestion(self._system, self._cycle, self._loads, np.zeros(self._system.nodes), False, self._most)
        safe = shakedown_problem(scaled := task.scaled(), True, task.bound(scaled))
        return Expressions(safe, self._loads, cp.Parameter(nonneg=True, name="load_unit") * safe.problem.var_dict["load_factor"])

    def _extended_program(self, task: LimitQuestion, constraints: list[Any], objective: Any) -> ShakedownLimit:
        scaled = self._expressions.scaled
        rows = task.rows(scaled)
        extended = self._expressions.extended(constraints, objective, rows, task.opening)
        model = extended.model

        def claimed() -> LimitClaim:
            return judged_extended(task, extended, rows.load_unit, expand_duals(model, rows, task.loads.corners).scaled(rows.load_unit))

        def no_limit() -> LimitClaim | None:
            proof = classify(task, scaled, self._solver)
            if proof is not None and proof[0] is LimitKind.NO_SAFE_SLIP:
                return no_limit_claim(task, *proof)
            return no_limit_under(extended, task, self._solver)

        answer = with_least_load(solve(model, claimed, self._solver, no_optimum=no_limit), model, rows, self._solver)
        extended.save()
        units = {**_units(scaled, rows), "objective": extended.objective_unit or 1.0}
        return answer.claim.result(answer.solver, answer.attempts, task.left_out(rows), model.problem, units)


@answered_by_kind
def shakedown_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

    Safe means: every node closed and stuck at every corner of the cycle. For a sweep over friction compile a `ShakedownModel` once. Theory, eq. (7).

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
    >>> fo.shakedown_limit(system, cycle, friction=0.5).reason
    'no residual slip is safe above it'
    """
    return ShakedownModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver).solve(friction)


def _closed_form(task: LimitQuestion) -> ShakedownLimit | None:
    """The limit of an uncoupled contact; None where it has no closed form that passes the checks."""
    ends = uncoupled_ends(task.system, task.loads, task.friction)
    if ends is None:
        return None
    scaled, (lower, upper) = task.scaled(), ends
    claim = judged(task, scaled, upper.load_factor, upper.slip, upper.motion)
    if lower.load_factor > 0:
        claim = replace(claim, residual=max(claim.residual, judged(task, scaled, lower.load_factor, lower.slip, lower.motion, least=True).residual))
    if max(claim.residual, task.violation(lower.load_factor, lower.slip)) > RESIDUAL:
        return None
    return replace(claim, least=lower.load_factor).result(
        "closed form", (), ("linear program: the contact is uncoupled (B = 0), the limit has a closed form",), None, {}
    )


def _units(scaled: ScaledContact, rows: RulingLoads) -> Units:
    return {"load_factor": rows.load_unit, "traction": scaled.unit[scaled.loaded]}


def _row(friction: Any, limit: ShakedownLimit) -> dict[str, Any]:
    first = limit.mechanism.iloc[0] if len(limit.mechanism) else None
    return {
        "friction": float(np.mean(friction)),
        "load_factor": limit.load_factor,
        "least": limit.least,
        "bound": limit.bound,
        "residual": limit.residual,
        "friction_rate": float(limit.friction_rate.sum()),
        "node": -1 if first is None else int(first["node"]),
        "direction": 0 if first is None else int(first["direction"]),
        "solver": limit.record.solver,
    }
