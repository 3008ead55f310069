"""Shakedown limits that need no program over all nodes: of uncoupled plane contacts, and where one node in space decides."""

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Array
from ..contact.tolerances import NO_COUPLING, RESIDUAL
from ..errors import SolverError
from ..solve.solvers import Answer
from .circles import helpless
from .limit_claim import LimitClaim, certified
from .mechanism import Mechanism
from .question import LimitQuestion
from .safe_slip import solve_margin
from .scaling import rigid_slides, scaled_contact
from .shakedown_result import ShakedownLimit, limit_result

__all__ = ["by_one_node", "in_closed_form", "is_uncoupled"]

End: TypeAlias = tuple[float, Array, Mechanism]
"""An end of the safe load factors, a slip that is safe there, and the mechanism that proves it (idle at load factor 0)."""


def is_uncoupled(task: LimitQuestion) -> bool:
    """Whether tangential motion does not change the friction bounds: f B is zero up to rounding, against A of the two nodes that it joins."""
    tangents = task.system.tangents
    stiffness = np.sqrt(np.diag(task.A).clip(0.0).reshape(tangents, -1).sum(axis=0))
    return bool((np.abs(task.friction[:, None] * task.B) <= NO_COUPLING * np.outer(stiffness, np.tile(stiffness, tangents))).all())


def in_closed_form(task: LimitQuestion) -> ShakedownLimit | None:
    """The limit of an uncoupled plane contact; None where it has no closed form that passes the checks."""
    ends = _ends(task)
    if ends is None:
        return None
    scaled, (lower, upper) = scaled_contact(task), ends
    claim = certified(task, scaled, *upper)
    if lower[0] > 0:
        claim = replace(claim, residual=max(claim.residual, certified(task, scaled, *lower, least=True).residual))
    if max(claim.residual, task.violation(*lower[:2])) > RESIDUAL:
        return None
    left_out = ("linear program: the contact is uncoupled (B = 0), the limit has a closed form",)
    return limit_result(Answer(replace(claim, least=lower[0]), "closed form", ()), left_out, None, {})


def _ends(task: LimitQuestion) -> tuple[End, End] | None:
    """The least and the largest safe load factor of an uncoupled contact in the plane, or None where this form does not hold.

    With B = 0 the shear changes `s = A v` are free, node by node: a node needs room for `s` between its ruling corners, and a contact that slides
    rigidly (a punch without supports, A 1 = 0) needs `sum s = 0` besides. Each of these needs is a row `lam drive <= resistance`. Holds where the
    largest load factor is finite and nothing of the cycle is fixed. (Klarbring, Ciavarella & Barber 2007: shakedown is guaranteed between both ends.)
    """
    loads, friction = task.loads, task.friction
    if friction.min() == 0 or loads.fixed:
        return None
    rigid, compliance = rigid_slides(task)
    floating = bool(rigid.size)
    if floating and (rigid.shape[1] > 1 or np.ptp(rigid) > 1e-6 / np.sqrt(len(friction))):
        return None

    q0, bound = loads.q0[0], friction * loads.p0[0]
    forward, backward = -(loads.q1 + friction * loads.p1), loads.q1 - friction * loads.p1
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
    """One node slipping forth and back, or (past the last node) all nodes slipping one way at their ruling corners.

    A node that slips forth and back at one corner opens by friction times that.
    """
    slips, nodes = np.zeros((2, *shape)), np.arange(shape[1])
    if which < shape[1]:
        for direction in (0, 1):
            slips[direction, rules[direction][which], which] = 1.0
    else:
        direction = which - shape[1]
        slips[direction, rules[direction], nodes] = 1.0
    return Mechanism(slips[0] - slips[1], 2 * friction * slips.min(axis=0), friction)


def by_one_node(task: LimitQuestion, solver: str | None) -> ShakedownLimit | None:
    """The limit 0 of a contact in space with a node that no load factor above 0 leaves at rest, or the proof that nothing is safe at 0; else None."""
    found = helpless(task)
    if found is None:
        return None
    motion, why = found
    answer, program = solve_margin(task, 0.0, solver)
    state = answer.claim
    if state.exists:
        claim = certified(task, program.v.scaled, 0.0, task.own(state.slip), motion)
        claim = replace(claim, least=0.0, why=f"no residual slip is safe at any load factor above 0: {why}")
    else:
        unsafe = np.full(task.loads.q1.shape[1:], np.nan)
        claim = LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, state.motion, np.nan, state.residual)
    if not claim.residual <= RESIDUAL:
        raise SolverError(f"shakedown limit: the slip that is safe under the mean load violates the contact law by {claim.residual:.1e}")
    return limit_result(Answer(claim, answer.solver, answer.attempts), program.left_out, None, {})
