"""Why there is no finite limit: proven, never taken from a solver's word."""

from dataclasses import replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.coulomb import lengths
from ..contact.diagnosis import growth_diagnosis
from ..contact.parts import parted
from ..contact.record import SolveRecord
from ..contact.tolerances import GROWN, RESIDUAL
from ..errors import ModelError
from ..solve.contradiction import contradiction, is_unbounded
from .mechanism import Mechanism
from .question import LimitQuestion
from .safe_set import SafeSet
from .safe_slip import solve_margin
from .shakedown_result import ShakedownLimit


def no_limit(task: LimitQuestion, solver: str | None) -> ShakedownLimit | None:
    """The answer that there is no finite limit, by the margin of two problems that always have an optimum; None where neither reason can be proven.

    The mechanism proves that nothing is safe. Without the loads at load factor 0, a safe slip grows with the load.
    """
    whole = task.whole or task
    unsafe, existence = np.full(task.system.slip_shape, np.nan), solve_margin(task, None, solver)
    if existence.margin < -RESIDUAL:
        return ShakedownLimit(np.nan, LimitKind.NO_SAFE_SLIP, unsafe, np.nan, existence.record, whole, existence._motion)
    slip, growing = np.zeros(task.system.slip_shape), existence
    if not _carried(task, task.own(slip)):  # no slip, which programs find up to rounding alone, may grow with the load as well
        none = {name: np.zeros_like(getattr(task, name)) for name in ("q0", "p0", "w0")}
        still = None if task.most is None else np.zeros_like(task.most)  # a bounded slip cannot grow with the load
        growing = solve_margin(replace(task, **none, most=still), task.load_unit, solver)
        slip = growing.slip
        if not (growing.margin >= -RESIDUAL and _carried(task, task.own(slip))):
            return None
    slipped, rounding = whole.change(slip / task.load_unit), GROWN * whole.mean_bound / task.load_unit
    why = growth_diagnosis(whole.friction, (whole.q1, whole.p1), slipped, rounding)
    return ShakedownLimit(np.inf, LimitKind.UNBOUNDED, unsafe, np.inf, growing.record, whole, growing._motion.scaled(0.0), _why=why)


def _carried(task: LimitQuestion, slip: Array) -> bool:
    """Whether the slip that grows with the load keeps each node within its bound, up to a share of what acts on this node itself."""
    f, v = task.friction, np.abs(slip.T.ravel())
    q1, p1 = task.load_unit * task.q1, task.load_unit * task.p1
    sheared, pressed = parted(np.abs(task.AB) @ v, task.system.tangents + 1)
    own = np.maximum(lengths(q1, p1), f * np.abs(p1)).max(axis=0) + lengths(sheared, pressed) + f * pressed
    q, p = (cyclic_part + part for cyclic_part, part in zip((q1, p1), task.change(slip), strict=True))
    lift = np.zeros((0, len(v))) if task.lift is None else task.lift
    opens = task.load_unit * task.w1
    apart = (opens + lift @ slip.T.ravel() >= -RESIDUAL * (np.abs(opens) + np.abs(lift) @ v)).all()
    return bool(apart) and bool((np.maximum(lengths(q, p) - f * p, -p).max(axis=0) <= RESIDUAL * own).all())


def no_limit_under(v: SafeSet, solver: str | None) -> ShakedownLimit | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven.

    Raises
    ------
    ModelError
        An objective without a largest value.
    """
    task, names = v.task.whole or v.task, v.own.names
    unsafe, still = np.full(task.system.slip_shape, np.nan), Mechanism(np.zeros_like(task.q1), np.zeros_like(task.p1), task.friction)
    excess = contradiction(v.problem, solver)
    if excess.bound > RESIDUAL:
        ruling = ", ".join(name for name in names if name in excess.ruling)
        why = f"no residual slip that is safe at any load factor obeys {ruling}: drop or relax them"
        record = SolveRecord(residual=excess.residual)
        return ShakedownLimit(np.nan, LimitKind.NO_SAFE_SLIP, unsafe, np.nan, record, task, still, constraints=names, _why=why)
    growing = is_unbounded(v.problem, solver)
    if growing is None or excess.value > RESIDUAL:
        return None
    if v.own.objective_unit is not None:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    residual = max(excess.residual, growing.residual)
    return ShakedownLimit(np.inf, LimitKind.UNBOUNDED, unsafe, np.inf, SolveRecord(residual=residual), task, still, constraints=names)
