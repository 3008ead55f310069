"""The least safe load factor: the lower end of an interval where the mean load alone leaves no safe slip, and the corners press.

Safe slips and load factors are a convex set, so the safe load factors are an interval. It begins at 0 if some slip is safe under the mean load
alone, else at::

    min lam   s.t.   v safe at lam, see `shakedown_problem`

Its dual is a mechanism of negative drive: the mean load does work on it, which more cyclic load takes up.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter

import cvxpy as cp
import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.record import SolveRecord
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from ..solve.solvers import solve
from .judge import judged, judged_by_rows
from .mirrors import slip_on_whole
from .safe_set import SafeSet
from .shakedown_result import ShakedownLimit


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
    if (excess := _excess_under_mean(limit, v, slip_on_whole(v.task, v.solved_slip))) <= RESIDUAL:
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
