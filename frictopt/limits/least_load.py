"""The least safe load factor: the lower end of an interval where the mean load alone leaves no safe slip, and the corners press.

Safe slips and load factors are a convex set (its rows are linear in both), so the safe load factors are an interval. It begins at 0 if some slip is
safe under the mean load alone, else at::

    min lam   s.t.   v safe at lam, see `shakedown_problem`

Its dual is a mechanism of negative drive: the mean load does work on it, which more cyclic load takes up.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import cvxpy as cp
import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from ..solve.solvers import Answer, solve
from .mechanism import expand_duals
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem
from .shakedown_result import LimitClaim, judged, judged_by_rows

__all__ = ["with_least_load"]


def with_least_load(answer: Answer[LimitClaim], model: SafeProblem, rows: RulingLoads, solver: str | None) -> Answer[LimitClaim]:
    """The answer of a program of the limit, with the least safe load factor: by one more program only if nothing at hand shows that it is 0.

    It is 0 if the slip of the limit, or no slip, is safe under the mean load; and if the cyclic load at the ruling corners only narrows the rows, as
    where the corners have the mean load in their hull: then what is safe at any load factor is so at 0. What stands in the variables and multipliers
    stays there. The least load factor is nan where no solver gave one that passes the checks.
    """
    claim = answer.claim
    if claim.kind is LimitKind.NO_SAFE_SLIP or claim.objective is not None:
        return answer
    narrows = not model.own and min(rows.forward.min(), rows.backward.min(), rows.opening.min() if claim.task.opening else 0.0) >= 0
    slips = ([claim.slip] if claim.kind is LimitKind.FINITE else []) + ([] if model.own else [np.zeros_like(claim.slip)])
    if narrows or any(_excess_under_mean(claim, model, slip) <= RESIDUAL for slip in slips):
        return replace(answer, claim=replace(claim, least=0.0))
    with _kept(model):
        try:
            lower = solve(model.downward, lambda: _claimed(claim, model.downward, rows), solver)
        except SolverError:  # rounding hides whether some slip is safe under the mean load: the limit stands, the least load factor is not known
            return replace(answer, claim=replace(claim, least=np.nan))
    claim = replace(claim, least=lower.claim.load_factor, residual=max(claim.residual, lower.claim.residual))
    return replace(answer, claim=claim, attempts=(*answer.attempts, *lower.attempts))


def _claimed(claim: LimitClaim, model: SafeProblem, rows: RulingLoads) -> LimitClaim:
    """The least load factor that stands in the program, judged by the referee and by its mechanism; 0 if its slip is safe under the mean load."""
    task, slip = claim.task, claim.task.within_bound(model.slip)
    if (excess := _excess_under_mean(claim, model, slip)) <= RESIDUAL:
        return replace(claim, load_factor=0.0, residual=excess)
    motion = expand_duals(model, rows, task.loads.corners)
    if model.own:
        return judged_by_rows(task, model, rows.load_unit, motion, claim.constraints)
    return judged(task, model.scaled, float(model.value("load_factor")) * rows.load_unit, slip, motion, least=True)


def _excess_under_mean(claim: LimitClaim, model: SafeProblem, slip: Array) -> float:
    """By how much a slip is not safe under the mean load alone, or violates the user's own rows there, if they are: then it stands in them."""
    load_factor: cp.Variable = model.problem.var_dict["load_factor"]
    value = load_factor.value
    load_factor.save_value(np.zeros(()))
    excess = max(claim.task.violation(0.0, slip), model.violation())
    load_factor.save_value(value)
    return float(np.nan_to_num(excess, nan=np.inf))


@contextmanager
def _kept(model: SafeProblem) -> Iterator[None]:
    """Puts back what stands in the variables and multipliers of a program."""
    duals = [variable for row in model.problem.constraints for variable in row.dual_variables]
    values = [(variable, variable.value) for variable in (*model.problem.variables(), *duals)]
    yield
    for variable, value in values:
        variable.save_value(value)
