"""Claims of a limit, judged from both sides: by the contact law under their slip, and by their mechanism."""

from dataclasses import dataclass, replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.tolerances import FLOOR, RESIDUAL
from ..errors import ModelError
from ..solve.standard_form import StandardForm
from .kinds import classify, growth
from .mechanism import Mechanism
from .own_constraints import OwnProgram, contradiction, is_unbounded
from .program import SafeProgram
from .question import LimitQuestion
from .reduced import on_whole
from .scaling import ScaledContact

__all__ = ["LimitClaim", "certified", "judged", "judged_by_rows", "no_limit", "no_limit_under"]


@dataclass(frozen=True, eq=False)
class LimitClaim:
    """A claimed limit of the whole contact with what is known against it.

    Attributes
    ----------
    growth, why
        Why there is no largest safe load factor, and a reason that stands for that of `kinds.reason`; in words.
    """

    task: LimitQuestion
    kind: LimitKind
    load_factor: float
    slip: Array
    motion: Mechanism
    bound: float
    residual: float
    least: float = np.nan
    growth: str = ""
    why: str = ""
    constraints: tuple[str, ...] = ()
    objective: float | None = None


def judged(program: SafeProgram, *, least: bool = False) -> LimitClaim:
    """Judge what stands in a program of the largest load factor, or of the least."""
    return certified(program.task, program.v.scaled, program.load_factor, program.slip, program.motion[0], least=least)


def certified(task: LimitQuestion, scaled: ScaledContact, load_factor: float, slip: Array, motion: Mechanism, *, least: bool = False) -> LimitClaim:
    """Judge a limit by the referee, and from above by the mechanism, which is scaled to unit drive; or the least safe load factor, from below.

    At the least safe load factor more load helps, so that its mechanism has a negative drive.
    """
    resistance, drive = task.work(motion)
    sense = -1 if least else 1
    if not sense * drive > 0:
        return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(sense / drive)
    bound, off = resistance / drive, scaled.defect(task, motion, slip)
    gap = (abs(bound - load_factor) + off) / max(load_factor, FLOOR * task.load_unit)
    task, slip, motion = on_whole(task, slip, motion)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, bound + sense * off, residual)


def no_limit(task: LimitQuestion, solver: str | None) -> LimitClaim | None:
    """The claim that there is no finite limit, with the residual of its proof; None where neither reason can be proven.

    The mechanism proves that nothing is safe.
    """
    found = classify(task, solver)
    if found is None:
        return None
    kind, proof = found
    task = task.whole or task
    unsafe = np.full(task.system.slip_shape, np.nan)
    if kind is LimitKind.NO_SAFE_SLIP:
        return LimitClaim(task, kind, np.nan, unsafe, proof.motion, np.nan, proof.residual)
    return LimitClaim(task, kind, np.inf, unsafe, proof.motion.scaled(0.0), np.inf, proof.residual, growth=growth(task, proof))


def judged_by_rows(program: SafeProgram, objective_unit: float | None = None) -> LimitClaim:
    """Judge an answer under constraints, or with an objective in some unit, of the user's own by the multipliers of all rows, theirs too."""
    task, load_factor, slip = program.task, program.load_factor, program.slip
    value, bound = StandardForm(program.problem).bounds
    gap = abs(bound - value) / max(abs(value), FLOOR)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap, program.violation), nan=np.inf))
    unit = task.load_unit if objective_unit is None else objective_unit
    claim = LimitClaim(task, LimitKind.FINITE, load_factor, slip, program.motion[0].scaled(unit), bound * unit, residual, constraints=program.names)
    if objective_unit is None:
        return claim
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(claim, why=why, objective=value * unit)


def no_limit_under(program: OwnProgram, solver: str | None) -> LimitClaim | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven.

    Raises
    ------
    ModelError
        An objective without a largest value.
    """
    task, names = program.task, program.names
    unsafe, still = np.full(task.system.slip_shape, np.nan), Mechanism(np.zeros_like(task.loads.q1), np.zeros_like(task.loads.p1), task.friction)
    excess = contradiction(program.problem, solver)
    if excess.bound > RESIDUAL:
        ruling = ", ".join(name for name in names if name in excess.ruling)
        why = f"no residual slip that is safe at any load factor obeys {ruling}: drop or relax them"
        return LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, still, np.nan, excess.residual, why=why, constraints=names)
    growing = is_unbounded(program.problem, solver)
    if growing is None or excess.value > RESIDUAL:
        return None
    if program.objective_unit is not None:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    residual = max(excess.residual, growing.residual)
    return LimitClaim(task, LimitKind.UNBOUNDED, np.inf, unsafe, still, np.inf, residual, constraints=names)
