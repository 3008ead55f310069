"""Proofs that a shakedown program has no optimum: nothing is safe, or every load factor is."""

from dataclasses import dataclass

import numpy as np
from cvxpy import Problem

from ..base import CONDENSATION, GROWN, LimitKind
from ..contact.diagnosis import growth_diagnosis
from ..errors import ModelError
from ..solve.chain import NoAnswer
from .answered import Mechanism
from .ordered import Ordered
from .programs import Program
from .question import Question
from .sentences import CONTRADICTED


@dataclass(frozen=True, eq=False)
class NoLimit:
    """The proof that there is no largest safe load factor, with its error and its reason."""

    kind: LimitKind
    question: Question
    motion: Mechanism
    residual: float
    constraints: tuple[str, ...] = ()
    why: str = ""


def no_limit(program: Program, bare: Problem, chosen: bool) -> NoLimit | None:
    """The proof that no load factor is safe, or that all above some value are; None without proof.

    `bare` is the problem without constraints and objective of the user. `chosen`: whether an
    objective of the user is maximized. ModelError if this objective grows without end.
    """
    proof = _nothing_is_safe(program, bare, chosen)
    if proof is not None:
        return proof
    growth = program.chain.growth(CONDENSATION)
    if not growth:
        return None
    if chosen:
        raise ModelError(
            "objective: it grows without bound over the safe slips; subtract a penalty, or bound "
            "it by a constraint"
        )
    question = program.question
    why = "" if program.user_rows else _cause_of_growth(program, growth)
    no_motion = Mechanism(np.zeros_like(question.r1), question.friction)
    names = tuple(program.user_rows)
    return NoLimit(LimitKind.UNBOUNDED, question, no_motion, growth.residual, names, why)


def _nothing_is_safe(program: Program, bare: Problem, chosen: bool) -> NoLimit | None:
    """The proof that no slip is safe at any load factor."""
    question = program.question
    contradiction = None
    if program.user_rows or chosen:
        # If no slip is safe even without the constraints of the user, they are not the cause.
        without_user_rows = Program(question, program.x, program.f, program.corners, program.rows)
        compiled = without_user_rows.compiled(bare, question.load_unit)
        contradiction = compiled.chain.contradiction()
        if contradiction:
            program.blame_no_user_row()
    contradiction = contradiction or program.chain.contradiction()
    if not contradiction:
        return None
    names: tuple[str, ...] = ()
    why = ""
    ruling = program.ruling(contradiction.ruling)
    if ruling:
        names = constraint_names(program, chosen)
        why = CONTRADICTED(node_states=question.node_states, rows=", ".join(ruling))
    kind = LimitKind.NO_SAFE_SLIP
    return NoLimit(kind, question, program.motion, contradiction.residual, names, why)


def _cause_of_growth(program: Program, growth: NoAnswer) -> str:
    """The reason that the load may grow without end, from the slip that grows with it."""
    question = program.question
    load_factor = program.chain.value_along(growth, program.x.load_factor)
    slip = program.chain.value_along(growth, program.x.slip) / load_factor
    return growth_diagnosis(
        question.friction,
        (question.q1, question.p1),
        question.reactions_of_slip(slip),
        GROWN * question.mean_bound / question.load_unit,
    )


def every_load_is_safe(program: Ordered) -> NoLimit | None:
    """The proof that all load factors are safe with an order of events; None if there is none."""
    chain = program.chain
    growth = chain.growth(CONDENSATION)
    if growth is None:
        return None
    places = [chain.value_along(growth, place) for place in program.way]
    question = program.placed(places, chain.value_along(growth, program.x.load_factor))
    no_motion = np.zeros((len(program.corners), *question.r1.shape[1:]))
    motion = Mechanism(no_motion, question.friction)
    return NoLimit(LimitKind.UNBOUNDED, question, motion, growth.residual)


def constraint_names(program: Program, chosen: bool) -> tuple[str, ...]:
    """Names of the constraints of the user, and "objective"."""
    return (*program.user_rows, "objective") if chosen else tuple(program.user_rows)
