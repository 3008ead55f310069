"""Shakedown limits that no optimum of a program gives: closed forms, one node that decides, and proofs that there is no finite limit.

That there is none is proven, never taken from a solver's word.
"""

from dataclasses import replace
from time import perf_counter

import numpy as np

from ..contact import GROWN, RESIDUAL, Array, LimitKind, SolveRecord
from ..contact.diagnosis import growth_diagnosis
from ..errors import ModelError, SolverError
from ..solve.solvers import contradiction, is_unbounded
from .answered import Mechanism
from .friction_bounds import safe_set
from .judge import FAR, End, judged
from .question import LimitQuestion, rigid_slides
from .safe_set import SafeSet
from .safe_slip import margin_problem, solve_margin
from .shakedown_result import ShakedownLimit


def in_closed_form(task: LimitQuestion) -> ShakedownLimit | None:
    """The limit of an uncoupled plane contact; None where it has no closed form that passes the checks."""
    ends = _ends(task)
    if ends is None:
        return None
    v, (lower, upper) = safe_set(task), ends
    claim = judged(v, upper)
    residual = max(claim.residual, judged(v, lower, least=True).residual if lower[0] > 0 else 0.0)
    if max(residual, task.violation(*lower[:2])) > RESIDUAL:
        return None
    left_out = ("linear program: the contact is uncoupled (B = 0), the limit has a closed form",)
    return replace(claim, least=lower[0], record=SolveRecord("closed form", (), residual, left_out, perf_counter() - task.started))


def _ends(task: LimitQuestion) -> tuple[End, End] | None:
    """The least and the largest safe load factor of an uncoupled contact in the plane, or None where this form does not hold.

    With B = 0 the shear changes `s = A v` are free, node by node: a node needs room for `s` between its ruling corners, and a contact that slides
    rigidly (a punch without supports, A 1 = 0) needs `sum s = 0` besides. Each of these needs is a row `lam drive <= resistance`. Holds where the
    largest load factor is finite and nothing of the cycle is fixed. (Klarbring, Ciavarella & Barber 2007: shakedown is guaranteed between both ends.)
    """
    friction = task.friction
    if friction.min() == 0 or task.fixed:
        return None
    rigid, compliance = rigid_slides(task)
    floating = bool(rigid.size)
    if floating and (rigid.shape[1] > 1 or np.ptp(rigid) > 1e-6 / np.sqrt(len(friction))):
        return None

    (q0, p0), (q1, p1) = task.r0[0], task.r1.swapaxes(0, 1)
    bound, forward, backward = friction * p0, -(q1 + friction * p1), q1 - friction * p1
    rules = forward.argmax(axis=0), backward.argmax(axis=0)
    rise, fall = forward.max(axis=0), backward.max(axis=0)
    resistance, drive = 2 * bound, rise + fall
    if floating:
        resistance, drive = np.r_[resistance, (bound + q0).sum(), (bound - q0).sum()], np.r_[drive, rise.sum(), fall.sum()]
    with np.errstate(divide="ignore", invalid="ignore"):
        limits = resistance / drive
    above, below = np.where(drive > 0, limits, np.inf), np.where(drive < 0, limits, -np.inf)
    if not np.isfinite(above.min()) or below.max() > above.min() or (resistance[drive == 0] < 0).any():
        return None

    def end(load_factor: float, row: int) -> End:
        least, most = load_factor * rise - bound - q0, bound - q0 - load_factor * fall
        room = most - least
        share = 0.5 if not floating or room.sum() <= 0 else float(np.clip(-least.sum() / room.sum(), 0.0, 1.0))
        return (load_factor, compliance @ (least + share * room), _mechanism(row, rules, forward.shape, friction))

    return end(max(float(below.max()), 0.0), int(below.argmax())), end(float(above.min()), int(above.argmin()))


def _mechanism(which: int, rules: tuple[np.ndarray, np.ndarray], shape: tuple[int, int], friction: Array) -> Mechanism:
    """One node slipping forth and back, or (past the last node) all nodes slipping one way at their ruling corners."""
    slips, n = np.zeros((2, *shape)), shape[1]
    moved = np.arange(n) if which >= n else which
    for way in (which - n,) if which >= n else (0, 1):
        slips[way, rules[way][moved], moved] = 1.0
    return Mechanism(np.stack([slips[0] - slips[1], friction * slips.sum(axis=0)], axis=1), friction)


def by_one_node(v: SafeSet, motion: Mechanism, why: str, solver: str | None) -> ShakedownLimit:
    """The limit 0 of a contact with a node that is `helpless` at any load factor above 0, or the proof that nothing is safe at 0.

    Raises
    ------
    SolverError
        The safe slip at load factor 0 is none.
    """
    task = v.task
    v.ask(task, 0.0)
    v = v.posed(margin_problem(v))
    state = solve_margin(task, 0.0, solver, v)
    if not state.exists:
        unsafe = np.full(task.system.slip_shape, np.nan)
        return ShakedownLimit(np.nan, unsafe, state.record, state._task, state._motion, LimitKind.NO_SAFE_SLIP, np.nan)
    limit = judged(v, (0.0, v.solved_slip, motion))
    if not limit.residual <= RESIDUAL:
        raise SolverError(f"shakedown limit: the slip that is safe under the mean load violates the contact law by {limit.residual:.1e}")
    why = f"no residual slip is safe at any load factor above 0{limit._task.pattern}: {why}"
    return replace(limit, least=0.0, _why=why, record=replace(state.record, residual=limit.residual))


def by_scaling(task: LimitQuestion, solver: str | None) -> ShakedownLimit | None:
    """The limit 0 of a contact without load at load factor 0; None where it is larger, or this proof fails.

    Load factor and safe slip may grow in proportion there, so if nothing is safe at one load factor, nothing is at any above 0. A slip bound only
    makes fewer slips safe.
    """
    found = solve_margin(replace(task, most=None), task.load_unit, solver)
    if not found.bound < 0 or (residual := found.residual / -found.bound / FAR) > RESIDUAL:
        return None
    motion = found._motion.scaled(1 / found._motion.work(found._task)[1])
    record = replace(found.record, residual=residual)
    return ShakedownLimit(0.0, np.zeros(task.system.slip_shape), record, task, motion, LimitKind.FINITE, 0.0, least=0.0)


def no_limit(task: LimitQuestion, solver: str | None) -> ShakedownLimit | None:
    """The answer that there is no finite limit, by the margin of two problems that always have an optimum; None where neither reason can be proven.

    The mechanism proves that nothing is safe. Without the loads at load factor 0, a safe slip grows with the load.
    """
    whole = task.whole or task
    unsafe, existence = np.full(task.system.slip_shape, np.nan), solve_margin(task, None, solver)
    if existence.margin < -RESIDUAL:
        return ShakedownLimit(np.nan, unsafe, existence.record, whole, existence._motion, LimitKind.NO_SAFE_SLIP, np.nan)
    slip, growing = np.zeros(task.system.slip_shape), existence
    if not _carried(task, task.own(slip)):  # no slip, which programs find up to rounding alone, may grow with the load as well
        none = {name: np.zeros_like(getattr(task, name)) for name in ("r0", "w0")}
        still = None if task.most is None else np.zeros_like(task.most)  # a bounded slip cannot grow with the load
        growing = solve_margin(replace(task, **none, most=still), task.load_unit, solver)
        slip = growing.slip
        if not (growing.margin >= -RESIDUAL and _carried(task, task.own(slip))):
            return None
    slipped, rounding = whole.change(slip / task.load_unit), GROWN * whole.mean_bound / task.load_unit
    why = growth_diagnosis(whole.friction, whole.parts[2:], slipped, rounding)
    return ShakedownLimit(np.inf, unsafe, growing.record, whole, growing._motion.scaled(0.0), LimitKind.UNBOUNDED, np.inf, _why=why)


def _carried(task: LimitQuestion, slip: Array) -> bool:
    """Whether the slip that grows with the load keeps each node within its bound, up to a share of what acts on this node itself."""
    f, v, r1 = task.friction, slip.T.ravel(), task.load_unit * task.r1
    r = r1 + (task.AB @ v).reshape(r1[0].shape)
    most = (np.abs(task.AB) @ np.abs(v)).reshape(r1[0].shape)
    own = np.maximum(np.linalg.norm(r1[:, :-1], axis=1), f * np.abs(r1[:, -1])).max(axis=0) + np.linalg.norm(most[:-1], axis=0) + f * most[-1]
    lift = np.zeros((0, len(v))) if task.lift is None else task.lift
    opens = task.load_unit * task.w1
    apart = (opens + lift @ v >= -RESIDUAL * (np.abs(opens) + np.abs(lift) @ np.abs(v))).all()
    beyond = np.maximum(np.linalg.norm(r[:, :-1], axis=1) - f * r[:, -1], -r[:, -1])
    return bool(apart) and bool((beyond.max(axis=0) <= RESIDUAL * own).all())


def no_limit_under(v: SafeSet, solver: str | None) -> ShakedownLimit | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven.

    Raises
    ------
    ModelError
        An objective without a largest value.
    """
    task, names = v.task.whole or v.task, v.own.names
    unsafe, still = np.full(task.system.slip_shape, np.nan), Mechanism(np.zeros_like(task.r1), task.friction)
    excess = contradiction(v.problem, solver)
    if excess.bound > RESIDUAL:
        ruling = ", ".join(name for name in names if name in excess.ruling)
        why = f"no residual slip that is safe at any load factor{task.pattern} obeys {ruling}: drop or relax them"
        record = SolveRecord(residual=excess.residual)
        return ShakedownLimit(np.nan, unsafe, record, task, still, LimitKind.NO_SAFE_SLIP, np.nan, constraints=names, _why=why)
    growing = is_unbounded(v.problem, solver)
    if growing is None or excess.value > RESIDUAL:
        return None
    if v.own.objective_unit is not None:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    residual = max(excess.residual, growing.residual)
    return ShakedownLimit(np.inf, unsafe, SolveRecord(residual=residual), task, still, LimitKind.UNBOUNDED, np.inf, constraints=names)
