"""The shakedown limit lambda_2: no residual slip is safe above it (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987), the same nodes closed.

Safe slips and load factors are a convex set, so the safe load factors are an interval. It begins at 0 if some slip is safe under the mean load
alone, else at::

    min lam   s.t.   v safe at lam, see below

Its dual is a mechanism of negative drive: the mean load does work on it, which more cyclic load takes up.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import RESIDUAL, Array, ContactSystem, LimitKind, LoadCycle, SolveRecord, listed, warns_of_odd_values
from ..errors import ModelError, SolverError
from ..solve.solvers import solve
from .judge import answered, judged, judged_by_rows, refuted
from .parts import half_of, on_whole, rest_under_mean
from .plain_limits import by_one_node, by_scaling, in_closed_form, no_limit, no_limit_under
from .question import LimitQuestion
from .safe_model import SafeModel, in_turn
from .safe_set import SafeSet
from .shakedown_result import ShakedownLimit


def shakedown_problem(v: SafeSet) -> cp.Problem:
    """Largest load factor lam at which some residual slip v keeps every node closed and stuck at every corner k of the load cycle.

    In full::

        max lam   s.t.   |q_k| <= f p_k,  p_k >= 0   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    The rows of `v.stuck` are intervals in the plane, of the corners that rule them (`Intervals`), and circles in space (`Circles`).
    """
    lam = v.load_factor
    return v.program(cp.Maximize(lam), {**v.stuck(lam), "load_factor_not_negative": lam >= 0})


class ShakedownModel(SafeModel):
    """The shakedown limit of one system under one load cycle for any friction; in the plane its program is compiled once.

    Threads that ask one model wait for each other. Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `|v|` that assembly can leave, one or one per node, length; None for no bound. A slide of the whole body counts:
        where nothing resists one, the program chooses it.
    simplify
        Leave out what cannot change the answer: the linear program of an uncoupled plane contact; the images of nodes of a contact that one or two
        planes mirror, loads too; in space corners within the hull of the others. Corners that rule no node never have rows in the plane.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM" (in space "CLARABEL_DIRECT", "CLARABEL", "INTERIOR_POINT", which for large contacts comes first);
        by default each in this order until an answer passes.
        Asking for a solver asks for the linear program even where there is a closed form.

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

    @warns_of_odd_values
    @in_turn
    def solve(self, friction: Any, constraints: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None) -> ShakedownLimit:
        """The limit for a coefficient of friction, one or one per node, under constraints of your own, or the slip that your objective chooses.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node.
        constraints
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units, and on variables of your own. They are linear, or
            of abs, max, norms and the like: the multipliers of rows and second-order cones prove the limit. `bound` and `residual` cover them. The
            whole contact is solved then, and in the plane the program is compiled once for the same constraints. Nodes may stay open where no slip
            keeps all closed without the constraints: q and p are 0 there, and the slip is that under the mean load.
        objective
            What shall be largest over the safe slips, instead of the load factor: a concave cvxpy expression on the same, also linear or of abs, max,
            norms and the like, such as `model.load_factor - 0.1 * cp.norm1(model.slip)`. See `ShakedownLimit.objective`.

        Raises
        ------
        ModelError
            Bad friction; constraints that are not convex, need other cones, or are on another model; such an objective, or one without a largest
            value.
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
        own = listed("constraints", constraints)
        return self._shown(self.of_any_set(self._posed(friction), own, objective))

    def of_any_set(self, task: LimitQuestion, own: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None) -> ShakedownLimit:
        """The limit with all nodes closed; where no slip is safe then, that of those which the mean load leaves closed, if there is one."""
        limit, none = self.of_set(task, own, objective), (LimitKind.NO_SAFE_SLIP, ())
        if (limit.kind, limit.constraints) == none and (rest := rest_under_mean(task)):  # no slip is safe, whatever constraints of the user's own ask
            opened = self.of_set(rest, own, objective)
            limit = limit if (opened.kind, opened.constraints) == none else opened
        return limit

    def of_set(
        self, task: LimitQuestion, own: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None, above: float = -np.inf
    ) -> ShakedownLimit:
        """The limit of closed nodes, see `rest_of`, maybe by the user's rows or objective; a SolverError once it is proven not to be `above` one."""
        under, solver = bool(own) or objective is not None, self._solver
        plane, known = task.system.tangents == 1, None
        if plane and task.simplify and not under and solver is None and task.lift is None and task.uncoupled and (known := in_closed_form(task)):
            return known
        v = self._program(shakedown_problem, task if under else half_of(task), own, objective)
        unpressed = not (plane or task.r0.any() or task.w0.any())
        if found := v.helpless():
            known = by_one_node(v, *found, solver)
        elif unpressed and not under:
            known = by_scaling(task, solver)
        if known and not (under and known.kind is LimitKind.FINITE):
            return known

        def no_limit_here() -> ShakedownLimit | None:
            claim = (None if under else refuted(v)) or no_limit(task, solver)
            return claim if not under or (claim and claim.kind is LimitKind.NO_SAFE_SLIP) else no_limit_under(v, solver)

        claimed = partial(judged_by_rows, v) if under else partial(judged, v, above=above)
        try:
            limit = known or answered(solve(v.problem, claimed, solver, no_optimum=no_limit_here, above=above / v.task.load_unit), v)
        except SolverError:  # circles that end in their apex leave solvers few digits
            known = by_scaling(task, solver) if unpressed and under else None
            if not known:
                raise
        if known:
            raise ModelError(f"constraints, objective: whatever they ask, {known.reason}; leave them out")
        if under:
            v.own.save()
        if limit.kind is not LimitKind.NO_SAFE_SLIP and limit.objective is None:
            plain = limit.kind is LimitKind.FINITE and not v.own.rows and limit._task.violation(0.0, limit.slip) <= RESIDUAL
            limit = replace(limit, least=0.0) if plain else with_least_load(limit, v, solver)
        if limit.kind is LimitKind.FINITE:  # in space the limit is what its slip carries
            v.load_factor.save_value(np.array(limit.load_factor / v.task.load_unit))
        return limit

    @warns_of_odd_values
    def sweep(self, frictions: Any, constraints: Sequence[cp.Constraint] = ()) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each, under constraints of your own as in `solve`.

        Columns: friction (mean over the nodes), load_factor, least, bound, residual, friction_rate, node and direction (slip1 and slip2 in space)
        of the largest share of the mechanism (-1 and 0 without one), solver.

        Raises
        ------
        ModelError
            Not a sequence, or bad friction in it.
        SolverError
            No solver gave an answer that passes the checks.
        """
        own = listed("constraints", constraints)
        return pd.DataFrame([_row(friction, self.solve(friction, own)) for friction in listed("frictions", frictions)])


@warns_of_odd_values
def shakedown_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

    Safe means: every node closed and stuck at every corner of the cycle. Where no slip does that, nodes that are open under the mean load may stay
    open (`ShakedownLimit.open`). With others open, or opening and closing in each cycle, a contact may rest above it. Theory, eq. (7).

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
    'no residual slip is safe above it with all nodes closed'
    """
    model = ShakedownModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
    return model.of_any_set(model._posed(friction))


def _row(friction: Any, limit: ShakedownLimit) -> dict[str, Any]:
    first = limit.mechanism.iloc[0] if len(limit.mechanism) else None
    names = ("direction",) if limit.system.tangents == 1 else ("slip1", "slip2")
    along = {name: 0 if first is None else first[name] for name in names}
    found = {name: getattr(limit, name) for name in ("load_factor", "least", "bound", "residual")}
    rate, node = float(limit.friction_rate.sum()), -1 if first is None else int(first["node"])
    return {"friction": float(np.mean(friction)), **found, "friction_rate": rate, "node": node, **along, "solver": limit.record.solver}


def with_least_load(limit: ShakedownLimit, v: SafeSet, solver: str | None) -> ShakedownLimit:
    """The limit that a program has given, with the least safe load factor: by one more program only if nothing at hand shows that it is 0.

    It is 0 if the slip of the limit, or no slip, is safe under the mean load; nan where no solver gave one that passes the checks. What stands in the
    variables and multipliers stays there.
    """
    slips = ([limit.slip] if limit.kind is LimitKind.FINITE else []) + ([] if limit.constraints else [np.zeros_like(limit.slip)])
    if any(_excess_under_mean(limit, v, slip) <= RESIDUAL for slip in slips):
        return replace(limit, least=0.0)
    with _kept(v.problem):
        downward = v.posed(cp.Problem(cp.Minimize(v.load_factor), v.problem.constraints), v.own)
        try:
            lower, found = solve(downward.problem, lambda: _claimed(limit, downward), solver)
        except SolverError:  # rounding hides whether some slip is safe under the mean load: the limit stands, the least load factor is not known
            return limit
    attempts, seconds = (*limit.record.attempts, *found.attempts), perf_counter() - v.task.started
    record = replace(limit.record, attempts=attempts, residual=max(limit.residual, lower.residual), seconds=seconds)
    return replace(limit, least=lower.load_factor, record=record)


def _claimed(limit: ShakedownLimit, v: SafeSet) -> ShakedownLimit:
    """The least load factor that stands in the program, judged by the referee and by its mechanism; 0 if its slip is safe under the mean load."""
    if (excess := _excess_under_mean(limit, v, on_whole(v.task, v.solved_slip, None)[1])) <= RESIDUAL:
        return replace(limit, load_factor=0.0, record=SolveRecord(residual=excess))
    return judged_by_rows(v) if limit.constraints else judged(v, least=True)


def _excess_under_mean(limit: ShakedownLimit, v: SafeSet, slip: Array) -> float:
    """By how much a slip is not safe under the mean load alone, or violates the user's own rows there, if they are: then it stands in them."""
    load_factor = v.load_factor
    value = load_factor.value
    load_factor.save_value(np.zeros(()))
    excess = max(limit._task.violation(0.0, slip), v.own.violation)
    load_factor.save_value(value)
    return float(np.nan_to_num(excess, nan=np.inf))


@contextmanager
def _kept(problem: cp.Problem) -> Iterator[None]:
    """Puts back what stands in the variables and multipliers of a program."""
    duals = [variable for row in problem.constraints for variable in row.dual_variables]
    values = [(variable, variable.value) for variable in (*problem.variables(), *duals)]
    yield
    for variable, value in values:
        variable.save_value(value)
