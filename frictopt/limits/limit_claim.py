"""Claims of a limit, judged from both sides: by the contact law under their slip, and by their mechanism."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.tolerances import FLOOR, RESIDUAL
from ..errors import ModelError
from ..solve.polish import Program as StandardForm
from .kinds import classify, growth
from .mechanism import Mechanism
from .own_constraints import Extended, contradiction, is_unbounded
from .plane import PlaneProgram, PlaneQuestion
from .question import LimitQuestion
from .space import ConeProgram, SpaceQuestion

__all__ = ["LimitClaim", "Program", "certified", "judged", "judged_by_rows", "judged_extended", "no_limit", "no_limit_under"]

Program: TypeAlias = PlaneProgram | ConeProgram


@dataclass(frozen=True, eq=False)
class LimitClaim:
    """A claimed limit with what is known against it.

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


def judged(program: Program, *, least: bool = False) -> LimitClaim:
    """Judge what stands in a program of the largest load factor, or of the least."""
    return certified(program.task, program.load_factor, program.slip, program.motion, program.defect, least=least)


def certified(
    task: LimitQuestion, load_factor: float, slip: Array, motion: Mechanism, defect: Callable[[Mechanism, Array], float], *, least: bool = False
) -> LimitClaim:
    """Judge a limit by the referee, and from above by the mechanism, which is scaled to unit drive; or the least safe load factor, from below.

    At the least safe load factor more load helps, so that its mechanism has a negative drive.
    """
    resistance, drive = motion.work(task.loads, task.most)
    sense = -1 if least else 1
    if not sense * drive > 0:
        return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(sense / drive)
    bound, off = resistance / drive, defect(motion, slip)
    gap = (abs(bound - load_factor) + off) / max(load_factor, FLOOR * task.load_unit)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, bound + sense * off, residual)


def no_limit(task: PlaneQuestion | SpaceQuestion, solver: str | None) -> LimitClaim | None:
    """The claim that there is no finite limit, with the residual of its proof; None where neither reason can be proven.

    The mechanism proves that nothing is safe.
    """
    found = classify(task, solver)
    if found is None:
        return None
    (kind, proof), unsafe = found, np.full(task.system.slip_shape, np.nan)
    if kind is LimitKind.NO_SAFE_SLIP:
        return LimitClaim(task, kind, np.nan, unsafe, proof.motion, np.nan, proof.residual)
    return LimitClaim(task, kind, np.inf, unsafe, proof.motion.scaled(0.0), np.inf, proof.residual, growth=growth(task, proof))


def judged_by_rows(program: Program, names: tuple[str, ...]) -> LimitClaim:
    """Judge an answer under constraints of the user's own by the multipliers of all rows, theirs too."""
    task, load_factor, slip = program.task, program.load_factor, program.slip
    value, bound = StandardForm(program.problem).bounds
    gap = abs(bound - value) / max(abs(value), FLOOR)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap, program.violation), nan=np.inf))
    motion = program.motion.scaled(task.load_unit)
    return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, bound * task.load_unit, residual, constraints=names)


def judged_extended(program: PlaneProgram, extended: Extended) -> LimitClaim:
    """Judge an answer under constraints or an objective of the user's own."""
    claim = judged_by_rows(program, extended.names)
    if extended.objective_unit is None:
        return claim
    unit, why = extended.objective_unit, "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    value, bound = (side * unit for side in StandardForm(program.problem).bounds)
    return replace(claim, why=why, bound=bound, motion=claim.motion.scaled(unit / program.task.load_unit), objective=value)


def no_limit_under(extended: Extended, task: LimitQuestion, solver: str | None) -> LimitClaim | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven.

    Raises
    ------
    ModelError
        An objective without a largest value.
    """
    problem, names = extended.model.problem, extended.names
    unsafe, nothing = np.full(task.system.nodes, np.nan), np.zeros((task.loads.corners, task.system.nodes))
    still, excess = Mechanism(nothing, nothing, task.friction), contradiction(problem, solver)
    if excess.bound > RESIDUAL:
        ruling = ", ".join(name for name in names if name in excess.ruling)
        why = f"no residual slip that is safe at any load factor obeys {ruling}: drop or relax them"
        return LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, still, np.nan, excess.residual, why=why, constraints=names)
    growing = is_unbounded(problem, solver)
    if growing is None or excess.value > RESIDUAL:
        return None
    if extended.objective_unit is not None:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    residual = max(excess.residual, growing.residual)
    return LimitClaim(task, LimitKind.UNBOUNDED, np.inf, unsafe, still, np.inf, residual, constraints=names)
