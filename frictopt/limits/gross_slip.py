"""The sliding-off load: above it no contact forces within friction balance the loads in the rigid motions of the bodies; one program each corner."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import (
    CONDENSATION,
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    Booleans,
    ContactSystem,
    LoadCycle,
    SolveRecord,
    bar_of,
    frozen,
    listed,
    most_shear,
    reactions,
    shown,
    warns_of_odd_values,
)
from ..errors import ModelError
from ..solve.chain import Chain
from ..solve.problem import Problem
from ..transients.statics import nodal_motions, rigid_motions
from . import models
from .gross_slip_result import GrossSlip, motion_table, moves_told
from .programs import outer_corners
from .question import Question, pose
from .self_stress import beyond_statics


@warns_of_odd_values
def gross_slip(system: ContactSystem, cycle: LoadCycle, friction: Any, contacts: Iterable[str] | None = None, *, progress: bool = True) -> GrossSlip:
    """The load factor above which no state of rest exists, from no start, whatever slips and opens: bodies slide off, turn over or lift off.

    By statics: on all that the contact alone holds, forces within friction, `|q| <= f p`, and within the shear strength of the surface have to
    balance the loads at each corner. Stiffness, gaps and residual slips do not matter, so the answer settles with the mesh. It is inf where supports
    hold the bodies. A contact may slip for ever far below it, and wedged bodies may slide off below it too: Coulomb's law does not choose forces as
    statics does. Theory, eq. (33).

    If contact forces can balance themselves or press against supports, as in a press fit, a clip, a joint with a locked bolt or under a body that
    supports guide along its face, statics cannot know how far the fit presses. Then transients from no slip are followed, and the answer is the load
    factor at which they slide off, if that is less; `reason` says so. It is found to 2e-4 of it, in space to 2e-3 with two increments from corner to
    corner, which may take minutes.

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    contacts
        Names of the contacts, of `system.contact`, in which friction counts; pressure counts in all. `["flange"]` gives the slip load of this joint,
        friction times the clamping force, without the heads of its bolts. None: all.
    progress
        Whether to show after two seconds that it is still at work.

    Raises
    ------
    ModelError, SolverError
        Bad input, contacts that the system does not have; no solver gave an answer that passes the checks; with forces that balance themselves, see
        also `steady_state`.

    Examples
    --------
    A block of weight P = 4 on a plane is pushed by Q:

    >>> import frictopt as fo
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])})
    >>> slide = fo.gross_slip(block, fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}]), friction=0.5)
    >>> round(slide.load_factor, 9)
    2.0
    >>> print(slide.problem)
    maximize load_factor
    subject to balance: N.T @ [q, p] == N.T @ (r0 + load_factor * r1[0])
               stuck: abs(q) <= f * p
               pressed: 0.0 <= p
               load_factor: 0.0 <= load_factor
    """
    with bar_of(progress, "gross slip"):
        task, only = _asked(system, cycle, friction, contacts)
        return beyond_statics(_of_corners(task, only), system, cycle, task.friction)


def statics_alone(system: ContactSystem, cycle: LoadCycle, friction: Any) -> float:
    """The load factor above which statics has no state of rest, whatever the fit presses: `bound` of `gross_slip`, without transients."""
    return _of_corners(*_asked(system, cycle, friction, None)).load_factor


def _asked(system: ContactSystem, cycle: LoadCycle, friction: Any, contacts: Iterable[str] | None) -> tuple[Question, str]:
    """The question, with friction in some contacts alone, and that in words."""
    task = pose(system, cycle, friction, strong=True)
    if contacts is None:
        return task, ""
    names, among = _checked(system, contacts)
    return replace(task, friction=frozen(task.friction * among)), f"with friction at {', '.join(names)} alone, "


def _of_corners(task: Question, only: str) -> GrossSlip:
    """The answer of statics, of what each corner allows."""
    system, cycle = task.system, task.cycle
    N, bounds = nodal_motions(rigid_motions(system.S, system.own_stiffness)), "friction" + " and the strength of the surface" * system.capped
    r1 = reactions(system, cycle.corners)  # without gaps, which do no work in rigid motions
    r0 = np.broadcast_to(reactions(system, cycle.unscaled), r1.shape)
    corners = outer_corners(cycle) if N.size else []
    held = _Answer(-1, np.inf, np.inf, np.zeros(len(N)), SolveRecord("statics", residual=0.0), None)
    answers = [_statics(task, N, k, r0[k], r1[k], cp.Maximize) for k in corners] or [held]
    load = [f"the load at the corner ({name})" for name in cycle.corner_names]
    if none := next((answer for answer in answers if np.isnan(answer.value)), None):
        unbalanced = f"{only}forces within {bounds} cannot balance {load[none.corner]}: {_moves(task, none)}"
        return _result(task, none, np.nan, f"no load factor has a state of rest, nor has 0: {unbalanced}", answers)
    most = min(answer.value for answer in answers)
    governs = next(answer for answer in answers if answer.value <= most * (1 + RESIDUAL))
    lower = list[_Answer]()
    for k in corners:  # without fixed parts none is at 0 if the first one is
        *q, p = r0[k].reshape(-1, system.nodes)
        rests = (np.linalg.norm(q, axis=0) <= most_shear(system, task.friction, p)).all()  # the closed contact, at load factor 0
        if not rests and (task.fixed or not lower or lower[0].value > 0):
            lower.append(_statics(task, N, k, r0[k], r1[k], cp.Minimize))
    first = max(lower, key=lambda answer: answer.value, default=held)
    least = first.value if lower else 0.0
    if least > most * (1 + RESIDUAL):
        why = f"no load factor has a state of rest: {only}{load[first.corner]} needs at least {least:.4g}, {load[governs.corner]} at most {most:.4g}"
        return _result(task, replace(governs, value=np.nan, bound=np.nan), np.nan, why, [*answers, *lower])
    if governs is held:
        why = "supports hold the bodies: no motion of theirs is left to the contact alone"
    elif most == np.inf:
        why = f"{only}forces within {bounds} balance the loads at all load factors{f' from {least:.4g} on' * (least > 0)}"
    else:
        unbalanced = f"{only}forces within {bounds} cannot balance {load[governs.corner]}: {_moves(task, governs)}"
        why = f"above it no state of rest exists, whatever slips and opens: {unbalanced}"
    if least > 0:
        why += f"; below {least:.4g} nothing balances {load[first.corner]}: {_moves(task, first)}"
    return _result(task, governs, least, why, [*answers, *lower])


@dataclass(frozen=True, eq=False)
class _Answer:
    """What a corner allows: a load factor, its bound, and the motion phi (M,) of size 1 that proves it."""

    corner: int
    value: float
    bound: float
    phi: Array
    record: SolveRecord
    problem: cp.Problem | None

    @property
    def residual(self) -> float:
        """The largest error of both proofs."""
        return self.record.residual


def _statics(task: Question, N: Array, k: int, r0: Array, r1: Array, sense: Any) -> _Answer:
    """The largest or least load factor at which forces balance corner k, r0 + load_factor r1, (M,), in the rigid motions N (M, m); nan where none."""
    held, drives = (float(size) if (size := np.linalg.norm(N.T @ r)) > CONDENSATION * np.linalg.norm(r) else 0.0 for r in (r0, r1))
    load = {f"r0{f'[{k}]' * task.fixed}": r0, f"r1[{k}]": r1 if drives else np.zeros_like(r1)}
    unit, n = _load_unit(task, N, r0, r1) if held and drives else 1.0, task.system.nodes
    f, strength = cp.Parameter(n, nonneg=True, name="f", value=task.friction), task.system.shear_strength
    rows = models.gross_slip(N, load, f, strength, task.system.slip_shape, sense)
    problem = Problem(rows.objective, rows.constraints)
    load_factor, q, p = (next(each for each in problem.variables() if each.name() == name) for name in ("load_factor", "q", "p"))
    sheared = task.node_unit * np.where((task.friction > 0) & (task.friction < 1), task.friction, 1.0)
    chain = Chain(problem, {load_factor: unit, q: sheared.reshape(n, *[1] * (q.ndim - 1)), p: task.node_unit}, unit=unit, defines=False)

    def still(value: float, bound: float, residual: float) -> _Answer:
        return _Answer(k, value, bound, np.zeros(len(N)), SolveRecord(residual=residual), problem)

    def moving(value: float, bound: float, residual: float) -> _Answer:
        """With the motion that the multipliers of balance are: how far it strains the bodies, or lifts less than friction needs, counts too."""
        S, phi = task.system.S, N @ problem.constraints[0].dual_value
        phi = phi / (float(np.linalg.norm(phi.reshape(-1, n), axis=0).max()) or np.nan)
        *v, w = phi.reshape(-1, n)
        lack = float(np.where(strength < np.inf, -w, task.friction * np.linalg.norm(v, axis=0) - w).max())  # what is strained off need not rise
        strain = float(np.abs(S @ phi).max()) / (float(np.diag(S).max()) or 1.0)
        worst = float(np.nan_to_num(np.max([residual, lack, strain]), nan=np.inf))
        return _Answer(k, value, bound, phi, SolveRecord(residual=worst), problem)

    def answered() -> _Answer:
        value = float(load_factor.value)
        found = value if value > ZERO_LOAD_FACTOR * unit else 0.0, chain.proof.bound, max(chain.proof.gap, chain.violation)
        return still(*found) if sense is cp.Minimize and not found[0] else moving(*found)  # no motion proves that it is at least 0

    def none() -> _Answer | None:
        if no := chain.contradiction():
            return moving(np.nan, np.nan, no.residual)
        more = chain.growth()
        return still(np.inf, np.inf, more.residual) if more else None

    answer, record = chain.solve(answered, no_optimum=none)
    return replace(answer, record=record)


def _load_unit(task: Question, N: Array, r0: Array, r1: Array) -> float:
    """Load factor at which the cyclic load reaches the friction of the mean load, or in the normal motions the mean load itself."""
    friction, shear = min(float(task.friction.max()), 1.0) or 1.0, len(r1) - task.system.nodes
    sheared, swung = (float(np.linalg.norm(part)) for part in (N[:shear].T @ r1[:shear], N[shear:].T @ r1[shear:]))
    return friction * float(np.linalg.norm(N.T @ r0)) / (sheared + friction * swung)


def _checked(system: ContactSystem, contacts: Iterable[str]) -> tuple[list[str], Booleans]:
    """Names of contacts of the system, at least one, and which nodes (N,) belong to them."""
    names = listed("contacts", contacts)
    if system.contact is None:
        raise ModelError(f"contacts: {shown(names)}, but the system has no names of contacts; give them as its `contact`, or leave contacts out")
    known = list(dict.fromkeys(system.contact.tolist()))
    if not names or (unknown := [name for name in names if name not in known]):
        raise ModelError(f"contacts: {shown(unknown[0] if names else names)}; give some of {known}, or None for all")
    return names, np.isin(system.contact, names)


def _moves(task: Question, answer: _Answer) -> str:
    return moves_told(motion_table(task.system, answer.phi.reshape(-1, task.system.nodes)))


def _result(task: Question, governs: _Answer, least: float, reason: str, answers: Sequence[_Answer]) -> GrossSlip:
    records, phi = [answer.record for answer in answers], governs.phi.reshape(-1, task.system.nodes)
    attempts = tuple(attempt for record in records for attempt in record.attempts)
    worst, seconds = max(record.residual for record in records), sum(record.seconds for record in records)
    idle = len(task.cycle.corners) - len({answer.corner for answer in answers})
    left_out = (f"corners: {idle} of {len(task.cycle.corners)} are within the hull of the others",) if idle and governs.problem else ()
    return GrossSlip(
        load_factor=governs.value,
        bound=governs.bound,
        least=least,
        corner=governs.corner if np.isfinite(governs.phi).all() and governs.phi.any() else -1,
        loads=task.cycle.corner_names[governs.corner] if governs.phi.any() else "",
        phi=phi,
        motion=motion_table(task.system, phi),
        reason=reason,
        record=replace(governs.record, attempts=attempts, residual=worst, left_out=left_out, seconds=seconds),
        problem=governs.problem,
    )
