"""Judging what stands in a program from both sides: by its slip, and by its mechanism, or under constraints of one's own by all multipliers."""

from dataclasses import replace
from time import perf_counter
from typing import TypeVar

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.record import SolveRecord, judged_by
from ..contact.tolerances import FLOOR, RESIDUAL
from ..solve.solvers import Answer
from ..solve.standard_form import StandardForm, relative_gap
from .answered import Answered
from .mechanism import Mechanism
from .program import SafeProgram
from .question import LimitQuestion
from .reduced import on_whole
from .safe_slip_result import SafeSlip
from .scaling import ScaledContact
from .shakedown_result import ShakedownLimit

__all__ = ["answered", "certified", "judged", "judged_by_rows", "judged_margin"]

_FAR = 1e3  # the proof that nothing is safe holds for slips at least `1 / _FAR / RESIDUAL` times as large as those of the loads


def judged(program: SafeProgram, *, least: bool = False) -> ShakedownLimit:
    """The limit that stands in a program of the largest load factor, or of the least, with the residual of its proof."""
    return certified(program.task, program.v.scaled, program.load_factor, program.slip, program.v.motion(program.rows)[0], least=least)


def certified(
    task: LimitQuestion, scaled: ScaledContact, load_factor: float, slip: Array, motion: Mechanism, *, least: bool = False
) -> ShakedownLimit:
    """Judge a limit by the referee, and from above by the mechanism, which is scaled to unit drive; or the least safe load factor, from below.

    At the least safe load factor more load helps, so that its mechanism has a negative drive.
    """
    resistance, drive = task.work(motion)
    sense = -1 if least else 1
    if not sense * drive > 0:
        return ShakedownLimit(load_factor, LimitKind.FINITE, slip, np.inf, judged_by(np.inf), task, motion)
    motion = motion.scaled(sense / drive)
    bound, off = resistance / drive, scaled.defect(task, motion, slip)
    gap = (abs(bound - load_factor) + off) / max(load_factor, FLOOR * task.load_unit)
    task, slip, motion = on_whole(task, slip, motion)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return ShakedownLimit(load_factor, LimitKind.FINITE, slip, float(bound + sense * off), judged_by(residual), task, motion)


def judged_by_rows(program: SafeProgram, objective_unit: float | None = None) -> ShakedownLimit:
    """Judge an answer under constraints, or with an objective in some unit, of the user's own by the multipliers of all rows, theirs too."""
    task, load_factor, slip = program.task, program.load_factor, program.slip
    value, bound = StandardForm(program.problem).bounds
    off = max(task.violation(load_factor, slip), relative_gap(value, bound), program.violation)
    residual = float(np.nan_to_num(off, nan=np.inf))
    unit = task.load_unit if objective_unit is None else objective_unit
    motion, record = program.v.motion(program.rows)[0].scaled(unit), judged_by(residual)
    limit = ShakedownLimit(load_factor, LimitKind.FINITE, slip, bound * unit, record, task, motion, constraints=program.names)
    if objective_unit is None:
        return limit
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(limit, _why=why, objective=value * unit)


def judged_margin(program: SafeProgram, load_factor: float | None) -> SafeSlip:
    """The slip that stands in a program of the margin at a load factor, or (None) at the best one, judged by its reserve, and by its multipliers."""
    task, margin, slip, cap = program.task, float(program.v.margin.value), program.slip, program.cap("cap")
    at = float(program.v.load_factor.value) * task.load_unit if load_factor is None else load_factor
    motion, slips = program.motion
    motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
    resistance, drive = task.work(motion)
    if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
        drive = min(drive, 0.0)
    off = program.v.scaled.defect(task, motion, slip)
    bound = cap + resistance - at * drive + off
    if not slips > 0 and cap < 1 - RESIDUAL:  # multipliers that do not add up to one bound nothing
        bound = np.inf
    if program.own:
        bound, off = StandardForm(program.problem).bounds[1], 0.0
    gap = abs(bound - off - margin) + off  # a defect that closes the gap counts for slips like this one alone
    whole, every, motion = on_whole(task, slip, motion)
    asked, own = (whole, every) if task.lift is None else (task, slip)  # the reserve of closed nodes, and of gaps, is that of their own question
    pull = float(-asked.reactions(at, own)[1].min() / asked.force) if margin >= 0 else 0.0
    residual = float(np.nan_to_num(max(gap, margin - asked.reserve(at, own), pull, asked.beyond(own), program.violation), nan=np.inf))
    if load_factor is None and bound < -RESIDUAL:  # nothing is safe at any load factor: no more is asked, and the upper bound alone proves it
        residual = off / -bound / _FAR
    return SafeSlip(at, every, margin, float(bound), judged_by(residual), whole, motion, program.names)


A = TypeVar("A", bound=Answered)


def answered(answer: Answer[A], program: SafeProgram) -> A:
    """The claim that has passed, with its program and how it was found."""
    claim, seconds = answer.claim, perf_counter() - program.task.started
    record = SolveRecord(answer.solver, answer.attempts, claim.residual, program.left_out, seconds)
    return replace(claim, record=record, problem=program.problem, _units=program.units)  # type: ignore[type-var]
