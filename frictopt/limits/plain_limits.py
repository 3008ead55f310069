"""Shakedown limits that need no program over all nodes: of uncoupled plane contacts, and where one node in space decides."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.record import SolveRecord
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from .judge import End, judged
from .mechanism import Mechanism
from .question import LimitQuestion
from .rigid import rigid_slides
from .safe_model import safe_set
from .safe_slip import solve_margin
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

    q0, bound = task.q0[0], friction * task.p0[0]
    forward, backward = -(task.q1 + friction * task.p1), task.q1 - friction * task.p1
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
    return Mechanism(slips[0] - slips[1], friction * slips.sum(axis=0), friction)


def by_one_node(task: LimitQuestion, motion: Mechanism, why: str, solver: str | None) -> ShakedownLimit:
    """The limit 0 of a contact in space with a node that is `helpless` at any load factor above 0, or the proof that nothing is safe at 0."""
    state = solve_margin(task, 0.0, solver)
    if not state.exists:
        unsafe = np.full(task.system.slip_shape, np.nan)
        return ShakedownLimit(np.nan, LimitKind.NO_SAFE_SLIP, unsafe, np.nan, state.record, state._task, state._motion)
    limit = judged(safe_set(task), (0.0, task.own(state.slip), motion))
    if not limit.residual <= RESIDUAL:
        raise SolverError(f"shakedown limit: the slip that is safe under the mean load violates the contact law by {limit.residual:.1e}")
    why = f"no residual slip is safe at any load factor above 0: {why}"
    return replace(limit, least=0.0, _why=why, record=replace(state.record, residual=limit.residual))
