"""Claims of a limit in three dimensions, judged by the referee and by the mechanism: of the largest and of the least safe load factor."""

from dataclasses import dataclass, replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.onset import reach
from ..contact.tolerances import CARRIED, FLOOR, RESIDUAL
from ..solve.solvers import Answer, Kind, solve
from .cones import ConeProgram, shakedown_cones
from .mechanism import Mechanism3D, mechanism_of
from .posed import ConeQuestion
from .scaling import load_factor_unit

__all__ = ["LimitClaim", "certified", "judged", "with_least_load"]


@dataclass(frozen=True, eq=False)
class LimitClaim:
    """A claimed limit with what is known against it.

    Attributes
    ----------
    least
        The least safe load factor.
    growth, why
        Why there is no largest safe load factor, and a reason that stands for all others; in words.
    """

    kind: LimitKind
    load_factor: float
    slip: Array
    motion: Mechanism3D
    bound: float
    residual: float
    least: float = np.nan
    growth: str = ""
    why: str = ""


def judged(task: ConeQuestion, model: ConeProgram, sense: int = 1) -> LimitClaim:
    """Judge what stands in a cone program of the largest load factor, or of the least (sense -1): the limit is what its slip carries."""
    c, point = task.cones, model.point
    slip, motion = task.slip(point.traction), mechanism_of(point, c.unit, task.friction, task.kept, len(task.loads.q1))
    if sense < 0 and (excess := task.violation(0.0, slip)) <= RESIDUAL:
        return LimitClaim(LimitKind.FINITE, 0.0, slip, motion, 0.0, excess)
    load_factor = max(_carried(task, slip, float(point.x[0]) * c.load_unit, sense), 0.0)
    return certified(task, load_factor, slip, motion, point.traction, sense)


def certified(task: ConeQuestion, load_factor: float, slip: Array, motion: Mechanism3D, traction: Array, sense: int = 1) -> LimitClaim:
    """Judge a limit by the referee, and from above by the mechanism, which is scaled to unit drive; the least safe load factor from below.

    At the least safe load factor more load helps, so that its mechanism has a negative drive.
    """
    loads = task.loads
    resistance, drive = motion.work(loads)
    if not sense * drive > 0:
        return LimitClaim(LimitKind.FINITE, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(sense / drive)
    bound, defect = resistance / drive, task.defect(motion, traction)
    gap = (abs(bound - load_factor) + defect) / max(load_factor, FLOOR * load_factor_unit(loads, task.friction, task.force))
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return LimitClaim(LimitKind.FINITE, load_factor, slip, motion, bound + sense * defect, residual)


def with_least_load(task: ConeQuestion, answer: Answer[LimitClaim], solver: str | None) -> Answer[LimitClaim]:
    """The answer with the least safe load factor: by one more program only if nothing at hand shows that it is 0.

    It is 0 if the slip of the limit, or no slip, is safe under the mean load; and if the corners have the mean load in their hull.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    claim = answer.claim
    if claim.kind is LimitKind.NO_SAFE_SLIP:
        return answer
    slips = ([claim.slip] if claim.kind is LimitKind.FINITE else []) + [np.zeros_like(claim.slip)]
    if any(task.violation(0.0, slip) <= RESIDUAL for slip in slips) or task.about_mean:
        return replace(answer, claim=replace(claim, least=0.0))
    model = shakedown_cones(task.cones, sense=-1)
    lower = solve(model, lambda: judged(task, model, sense=-1), solver, kind=Kind.SOCP)
    claim = replace(claim, least=lower.claim.load_factor, residual=max(claim.residual, lower.claim.residual))
    return replace(answer, claim=claim, attempts=(*answer.attempts, *lower.attempts))


def _carried(task: ConeQuestion, slip: Array, load_factor: float, sense: int) -> float:
    """The load factor, lowered (or raised: sense -1) in closed form to where the slip keeps every node within its circle at every corner.

    Circles count from rounding on: where a node carries nothing, what it can carry is lost in it.
    """
    (q, p), f, q1, p1 = task.reactions(load_factor, slip), task.friction, sense * task.loads.q1, sense * task.loads.p1
    beyond = np.linalg.norm(q, axis=-1) - f * p > CARRIED * task.force
    pulls = task.cones.opening & (p < -CARRIED * task.force) & (p1 < 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        back = np.where(beyond, reach(q, f * p, q1, f * p1), 0.0)
        shut = np.where(pulls, p / -p1, 0.0)
    return load_factor + sense * float(min(np.where(np.isfinite(back), back, 0.0).min(), shut.min(), 0.0))
