"""Judging a limit from both sides: by the contact law under its slip, and by its mechanism, or under constraints of one's own by all multipliers."""

from dataclasses import replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.record import judged_by
from ..contact.tolerances import FLOOR
from ..solve.standard_form import StandardForm
from .mechanism import Mechanism
from .program import SafeProgram
from .question import LimitQuestion
from .reduced import on_whole
from .scaling import ScaledContact
from .shakedown_result import ShakedownLimit

__all__ = ["certified", "judged", "judged_by_rows"]


def judged(program: SafeProgram, *, least: bool = False) -> ShakedownLimit:
    """The limit that stands in a program of the largest load factor, or of the least, with the residual of its proof."""
    return certified(program.task, program.v.scaled, program.load_factor, program.slip, program.motion[0], least=least)


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
    gap = abs(bound - value) / max(abs(value), FLOOR)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap, program.violation), nan=np.inf))
    unit = task.load_unit if objective_unit is None else objective_unit
    motion, record = program.motion[0].scaled(unit), judged_by(residual)
    limit = ShakedownLimit(load_factor, LimitKind.FINITE, slip, bound * unit, record, task, motion, constraints=program.names)
    if objective_unit is None:
        return limit
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(limit, _why=why, objective=value * unit)
