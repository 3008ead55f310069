"""What kind of limit there is and why: proven, never taken from a solver's word."""

from dataclasses import replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.coulomb import lengths
from ..contact.diagnosis import growth_diagnosis, unscaled_diagnosis
from ..contact.tolerances import GROWN, RESIDUAL
from .question import LimitQuestion
from .safe_slip import MarginClaim, solve_margin

__all__ = ["classify", "growth", "reason"]


def classify(task: LimitQuestion, solver: str | None) -> tuple[LimitKind, MarginClaim] | None:
    """Decide why there is no finite limit, by the margin of two problems that always have an optimum; None if neither reason can be proven."""
    loads = task.loads
    existence = solve_margin(task, None, solver)[0].claim
    if existence.margin < -RESIDUAL:
        return LimitKind.NO_SAFE_SLIP, existence
    alone = replace(loads, q0=np.zeros_like(loads.q0), p0=np.zeros_like(loads.p0), w0=np.zeros_like(loads.w0))
    still = None if task.most is None else np.zeros_like(task.most)  # a bounded slip cannot grow with the load
    cyclic = solve_margin(replace(task, loads=alone, most=still), task.load_unit, solver)[0].claim
    return (LimitKind.UNBOUNDED, cyclic) if cyclic.margin >= -RESIDUAL and _carried(task, cyclic.load_factor, task.own(cyclic.slip)) else None


def _carried(task: LimitQuestion, load_factor: float, slip: Array) -> bool:
    """Whether the slip that grows with the load keeps each node within its bound, up to a share of what acts on this node itself."""
    f, v, shape = task.friction, np.abs(slip.T.ravel()), slip.T.shape
    q1, p1 = load_factor * task.loads.q1, load_factor * task.loads.p1
    sheared, pressed = (np.abs(task.A) @ v).reshape(shape).T, np.abs(task.B) @ v
    own = np.maximum(lengths(q1, p1), f * np.abs(p1)).max(axis=0) + lengths(sheared, pressed) + f * pressed
    q, p = (cyclic_part + part for cyclic_part, part in zip((q1, p1), task.change(slip), strict=True))
    lift = np.zeros((0, len(v))) if task.lift is None else task.lift
    opens = load_factor * task.loads.w1
    apart = (opens + lift @ slip.T.ravel() >= -RESIDUAL * (np.abs(opens) + np.abs(lift) @ v)).all()
    return bool(apart) and bool((np.maximum(lengths(q, p) - f * p, -p).max(axis=0) <= RESIDUAL * own).all())


def growth(task: LimitQuestion, proof: MarginClaim) -> str:
    """Why the limit is infinite, in words, from the slip that grows with the load."""
    slipped, rounding = task.change(proof.slip / proof.load_factor), GROWN * task.mean_bound / proof.load_factor
    return growth_diagnosis(task.friction, (task.loads.q1, task.loads.p1), slipped, rounding)


def reason(task: LimitQuestion, kind: LimitKind, ends: tuple[float, float], growth: str, constraints: tuple[str, ...]) -> str:
    """Why the safe load factors end where they do, at the least and at the largest one, in words; `growth` says why there is no largest one."""
    least, largest = ends
    within, more = ("", "") if task.most is None else (" within the slip bound", "a larger slip_bound may leave one; ")
    slip, start, below = f"residual slip{within}", "", ""
    slip += f" that obeys {', '.join(constraints)}" * bool(constraints)
    if not largest > 0 or (least > 0 and not constraints):
        more += unscaled_diagnosis(task.system, task.cycle, task.friction)
    if not largest > 0:
        return f"no {slip} is safe at any load factor{' above 0' * (kind is LimitKind.FINITE)}: {more}"
    if least > 0:
        start, below = f" from {least:.6g} on", f"; none is safe below {least:.6g}" + ("" if constraints else f": {more}")
    if np.isnan(least):
        start, below = (
            " from some on",
            "; rounding hides from where on: take friction further from its critical value, or loads of like size",
        )
    if kind is LimitKind.UNBOUNDED:
        return f"the shakedown limit is infinite: every load factor{start} has a safe {slip}{f'; {growth}' * bool(growth)}{below}"
    return f"no {slip} is safe above it{'; the dual bound covers them' * bool(constraints)}{below}"
