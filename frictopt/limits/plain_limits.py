"""Shakedown limits that need no program over all nodes: of uncoupled plane contacts, and where one node in space decides."""

from dataclasses import replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from ..solve.solvers import Answer
from .circles import helpless
from .closed_form import uncoupled_ends
from .limit_claim import LimitClaim, certified
from .question import LimitQuestion
from .safe_slip import solve_margin
from .scaling import scaled_contact
from .shakedown_result import ShakedownLimit, limit_result

__all__ = ["by_one_node", "in_closed_form"]


def in_closed_form(task: LimitQuestion) -> ShakedownLimit | None:
    """The limit of an uncoupled plane contact; None where it has no closed form that passes the checks."""
    ends = uncoupled_ends(task.system, task.loads, task.friction) if task.system.tangents == 1 else None
    if ends is None:
        return None
    scaled, (lower, upper) = scaled_contact(task), ends
    claim = certified(task, scaled, upper.load_factor, upper.slip, upper.motion)
    if lower.load_factor > 0:
        least = certified(task, scaled, lower.load_factor, lower.slip, lower.motion, least=True)
        claim = replace(claim, residual=max(claim.residual, least.residual))
    if max(claim.residual, task.violation(lower.load_factor, lower.slip)) > RESIDUAL:
        return None
    left_out = ("linear program: the contact is uncoupled (B = 0), the limit has a closed form",)
    return limit_result(Answer(replace(claim, least=lower.load_factor), "closed form", ()), left_out, None, {})


def by_one_node(task: LimitQuestion, solver: str | None) -> ShakedownLimit | None:
    """The limit 0 of a contact in space with a node that no load factor above 0 leaves at rest, or the proof that nothing is safe at 0; else None."""
    found = helpless(task) if task.system.tangents > 1 else None
    if found is None:
        return None
    motion, why = found
    answer, program = solve_margin(task, 0.0, solver)
    state = answer.claim
    if state.exists:
        claim = certified(task, program.v.scaled, 0.0, task.own(state.slip), motion)
        claim = replace(claim, least=0.0, why=f"no residual slip is safe at any load factor above 0: {why}")
    else:
        unsafe = np.full(task.system.slip_shape, np.nan)
        claim = LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, state.motion, np.nan, state.residual)
    if not claim.residual <= RESIDUAL:
        raise SolverError(f"shakedown limit: the slip that is safe under the mean load violates the contact law by {claim.residual:.1e}")
    return limit_result(Answer(claim, answer.solver, answer.attempts), program.left_out, None, {})
