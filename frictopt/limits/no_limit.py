"""Proofs that a shakedown program has no optimum: nothing is safe, or every load factor is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import GROWN, LimitKind
from ..contact.diagnosis import growth_diagnosis
from ..errors import ModelError
from . import assembled
from .mechanism import Mechanism
from .question import Question
from .rest_program import RestProgram
from .sentences import CONTRADICTED
from .solution import Solution, contradiction, growth
from .solved import INFEASIBLE, UNBOUNDED, Solved


@dataclass(frozen=True, eq=False)
class NoLimit:
    """The proof that there is no largest safe load factor, with its error and its reason."""

    kind: LimitKind
    question: Question
    motion: Mechanism
    residual: float
    solved: Solved
    constraints: tuple[str, ...] = ()
    why: str = ""


def no_limit(program: RestProgram, goal: str, user: Any = None) -> NoLimit | None:
    """The proof that no load factor is safe, or that all above some value are; None without proof.

    `user`: the `UserRows`. ModelError if their objective grows without end.
    """
    question = program.question
    if user is not None:
        # If no slip is safe even without the constraints of the user, they are not the cause.
        proof = _nothing_is_safe(assembled.shakedown(question), "load_factor")
        if proof is not None:
            return proof
    proof = _nothing_is_safe(program, goal, user)
    if proof is not None:
        return proof
    grown = growth(program, goal)
    if grown is None:
        return None
    if goal != "load_factor":
        raise ModelError(
            "objective: it grows without bound over the safe slips; subtract a penalty, or bound "
            "it by a constraint"
        )
    along, residual = grown
    no_motion = Mechanism(np.zeros_like(question.r1), question.friction)
    solved = replace(along.solved("shakedown"), status=UNBOUNDED)
    names = () if user is None else user.names
    why = _cause_of_growth(along) if user is None else ""
    return NoLimit(LimitKind.UNBOUNDED, question, no_motion, residual, solved, names, why)


def _nothing_is_safe(program: RestProgram, goal: str, user: Any = None) -> NoLimit | None:
    """The proof that no slip is safe at any load factor."""
    found = contradiction(program, goal)
    if found is None:
        return None
    claim, residual = found
    question = program.question
    names: tuple[str, ...] = ()
    why = ""
    ruling = [] if user is None else user.ruling(claim)
    if ruling:
        names = user.names
        why = CONTRADICTED(node_states=question.node_states, rows=", ".join(ruling))
    solved = replace(claim.solved("shakedown"), status=INFEASIBLE)
    kind = LimitKind.NO_SAFE_SLIP
    return NoLimit(kind, question, claim.motion, residual, solved, names, why)


def _cause_of_growth(along: Solution) -> str:
    """The reason that the load may grow without end, from the slip that grows with it."""
    question = along.program.question
    slip = along.program.slip_at(along.x) / along.values("load_factor")
    return growth_diagnosis(
        question.friction,
        (question.q1, question.p1),
        question.reactions_of_slip(slip.reshape(question.system.slip_shape, order="F")),
        GROWN * question.mean_bound / question.load_unit,
    )
