"""The sliding-off load: above it no contact forces within friction balance the loads.

The forces have to balance the loads in the rigid motions of the bodies that no support guides, at
every corner of the cycle: one program for each corner (`balance/statics.py`). If contact forces can
balance themselves, statics does not determine how hard they press, and transients answer
(`balance/self_stress.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..base import (
    RESIDUAL,
    ROUNDING,
    Array,
    PerNode,
    SolveRecord,
    Table,
    finite_number,
    progress_bar,
    warns_of_odd_values,
    worst,
)
from ..contact import ContactSystem, LoadCycle, reactions
from ..errors import SolverError
from ..solve.explained import Explained
from ..transients.balance import self_stress
from ..transients.statics import nodal_motions
from .answers.sentences import (
    ABOVE,
    ALL_BALANCED,
    APART,
    BELOW,
    GOES_ON,
    HELD,
    NO_STATE,
    SELF_STRESSED,
    SLIDES_OFF_ABOVE,
    SLIDES_OFF_AT_ANY,
    STOPPED,
    UNBALANCED,
)
from .balance.self_stress import sliding_off
from .balance.statics import (
    CornerAnswer,
    CornerQuestion,
    corner_answer,
    drives,
    error_of_motion,
    motion_table,
    motions_in_words,
)
from .program.question import Question, outer_corners, pose

# One file because a reader follows the question to its answer here.


@dataclass(frozen=True, eq=False, repr=False)
class GrossSlip(Explained):
    """The load factor above which bodies slide off, turn over or lift off as a whole.

    A rigid motion proves it.

    Attributes
    ----------
    load_factor
        Above it no state of rest exists, from any start, for all slips and openings. Inf if
        supports hold the bodies, or if contact forces within friction balance the loads at all load
        factors from `least` on; NaN if no load factor has a state of rest. With a `self_stress`,
        the transient that starts without slip may slide off above a smaller load factor, which is
        then the result.
    bound
        Upper bound of the load factor from equilibrium, also with a `self_stress`. It is `phi`
        times the reactions at load factor 0, divided by minus `phi` times the reactions of the
        cyclic load.
    least
        Below it no state of rest exists either. It is above 0 if the mean load and the fixed part
        alone slide a body off.
    corner, loads
        The corner that governs, and its loads in words; -1 and "" if no corner governs.
    phi
        (t + 1, N) the motion of body 1 relative to body 2 that proves the load factor: slips along
        the tangents, then lifts. The largest motion of a node has the size 1. The motion strains no
        body, and lifts each node by at least f times its slip; the loads do work on it. `phi` is
        zero if no motion exists.
    motion
        The motion, one row for each contact that moves. Columns: contact; nodes, the number of
        moving nodes; x, y (and z), the direction of the slide, or in space the axis of the turn;
        slide, along this direction; lift, off a flat face; turn, the angle, in the plane from x to
        y; at_x, at_y (and at_z), a point at rest in a turn, otherwise NaN. If the nodes of a
        contact do not move as one body, all numbers from x on are NaN.
    reason
        Explanation of the load factor in words.
    self_stress
        (t + 1, N) contact forces within friction that balance themselves, their pressures adding up
        to 1: shear along the tangents, then pressure. None if no body moves. If such forces exist,
        equilibrium does not determine the pressure of a fit.
    record, problem
        Solver, attempts and time. Its `residual`, at most 1e-9, is the largest error of the forces
        that balance the loads, and of the motion that proves the bound. The cvxpy problem of the
        corner, in your units, or None.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])}
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], loads)
    >>> cycle = fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}])
    >>> slide = fo.gross_slip(block, cycle, friction=0.5)
    >>> slide.phi.round(3).tolist(), slide.loads  # it rises by the angle of friction
    ([[0.894], [0.447]], 'Q = +1')
    """

    _shown_names = ("load_factor", "bound", "loads", "residual", "reason")
    load_factor: float
    bound: float
    least: float
    corner: int
    loads: str
    phi: Array
    motion: Table
    reason: str
    record: SolveRecord
    _asked: CornerQuestion | None
    _forces: Array
    self_stress: Array | None = None

    def check_kept(self) -> None:
        """Check that the motion of an answer from a file proves its bound; ValueError if not."""
        if self._asked is None or not np.isfinite(self.bound):
            return
        phi = self.phi.ravel()
        forces = np.array([self._asked.r0, self.bound * self._asked.r1])
        # No node moves by more than 1.
        error = abs(float((forces @ phi).sum())) / (np.abs(forces).sum() or 1.0)
        error = worst([error, error_of_motion(self._asked.question, phi)])
        if error > 10 * RESIDUAL or self.load_factor > max(0.0, self.bound) * (1 + RESIDUAL):
            raise ValueError(f"its motion does not prove the load factor {self.bound:g}")

    @cached_property
    def problem(self) -> Any:
        """The cvxpy problem of the corner in your units; None if supports hold the bodies."""
        if self._asked is None:
            return None
        # Imported here, because cvxpy is slow to import, and answers do not need it.
        from .printed.listing import corner_problem

        return corner_problem(self._asked, self.load_factor, self._forces)

    def carried(self) -> Array:
        """(N,) share of each node in the work of friction on the motion; NaN without a motion."""
        shape = self.phi.shape
        if self._forces.size != self.phi.size:
            return np.full(shape[1], np.nan)
        work = -(self._forces.reshape(shape)[:-1] * self.phi[:-1]).sum(axis=0)
        return np.asarray(work / (work.sum() or np.nan))

    def rests_at(self, load_factor: float) -> bool:
        """Whether a state of rest may exist at a load factor: from `least` to `load_factor`."""
        largest = self.load_factor * (1 + ROUNDING)
        return self.least * (1 - ROUNDING) <= load_factor <= largest

    def to_frame(self) -> Table:
        """The table `motion`."""
        return self.motion.copy()

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        title = f"sliding-off load: load factor {self.load_factor:.12g}, bound {self.bound:.12g}"
        answer = self.load_factor if np.isfinite(self.load_factor) else None
        return title, answer, None, self.reason


@warns_of_odd_values
def gross_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    seconds: float = 300.0,
    progress: bool = True,
) -> GrossSlip:
    """The load factor above which bodies slide off, turn over or lift off as a whole.

    Above it no state of rest exists, from any start, for all slips and openings. The load factor
    follows from equilibrium: at each corner, contact forces have to balance the loads on all bodies
    that only the contact holds. These forces obey friction, `|q| <= f p`, and the shear strength of
    the surface. Stiffness, gaps and residual slips do not matter, so the result converges with the
    mesh. The result is inf if supports hold the bodies. A contact may slip for ever at far smaller
    load factors, and wedged bodies may slide off at smaller ones, because Coulomb's law does not
    choose the most favourable forces. Theory, eq. (33).

    If contact forces can balance themselves or press against supports, equilibrium does not
    determine the pressure. Examples are a press fit, a clip, a joint with a locked bolt, or a body
    that supports guide along its face. Then transients without initial slip are followed until they
    settle, for at most 100 cycles. If they slide off at a lower load factor, the result is this
    load factor, and `reason` says so. The relative error of this load factor is 2e-4. In space it
    is 3e-3: 1e-3 from the search, and 2e-3 from the transients, which take only two increments from
    corner to corner. Transients may take minutes; if equilibrium decides, the answer comes at once.

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`. A contact without friction still presses. So with the friction
        `{"flange": 0.15, "heads": 0.0}` the bolts clamp the flange, and the load at the result is
        the slip load of the flange: its friction times the clamping force.
    seconds
        Time after which transients end. The load factor is then the largest one at which they went
        on, and `reason` says so. 0: equilibrium alone, without transients.
    progress
        Whether to show the progress after two seconds. An interrupt keeps the answer of equilibrium
        as its attribute `gross_slip`.

    Returns
    -------
    GrossSlip
        The load factor, and the motion of the bodies that proves it.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks. With forces that balance
        themselves, also errors of `steady_state`, or no transient goes on in time.

    Examples
    --------
    A block of weight P = 4 on a plane is pushed by Q:

    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])}
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], loads)
    >>> cycle = fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}])
    >>> slide = fo.gross_slip(block, cycle, friction=0.5)
    >>> round(slide.load_factor, 9)
    2.0
    >>> print(slide.problem)
    maximize load_factor
    subject to balance: N.T @ [q, p] == N.T @ (r0 + load_factor * r1[0])
               stuck: abs(q) <= f * p
               pressed: 0.0 <= p
               load_factor: 0.0 <= load_factor
    """
    seconds = finite_number("seconds", seconds, least=0.0)
    with progress_bar(progress, "gross slip") as bar:
        question = pose(system, cycle, friction, question_name="gross_slip")
        answer = _with_self_stress(_statics(question), question)
        if answer.self_stress is None or seconds == 0:
            return answer
        note = "the answer of equilibrium alone is in the attribute `gross_slip`"
        bar.keep("gross_slip", answer, note, best=f"at most {answer.bound:.4g}")
        return _with_transients(answer, question, seconds)


def statics_alone(system: ContactSystem, cycle: LoadCycle, friction: Any) -> float:
    """`GrossSlip.bound`: the load factor of statics, without transients."""
    return _statics(pose(system, cycle, friction, question_name="gross_slip")).load_factor


def _bounds(question: Question) -> str:
    """The bounds of contact forces, in words."""
    return "friction and the strength of the surface" if question.system.capped else "friction"


def _load(answer: CornerAnswer) -> str:
    """The corner of an answer, in words."""
    asked = answer.asked
    return f"the load at the corner ({asked.question.cycle.corner_names[asked.corner]})"


def _motion(answer: CornerAnswer) -> str:
    """The motion of an answer, in words."""
    system = answer.asked.question.system
    return motions_in_words(motion_table(system, answer.phi.reshape(-1, system.nodes)))


def _unbalanced(answer: CornerAnswer) -> str:
    """The load that no contact forces balance, and the motion that proves it."""
    bounds = _bounds(answer.asked.question)
    return UNBALANCED.format(bounds=bounds, load=_load(answer), motion=_motion(answer))


def _statics(question: Question) -> GrossSlip:
    """The answer of statics: the load factors at which forces balance all corners."""
    system = question.system
    N = nodal_motions(system.rigid_motions)
    if not N.size:
        return _held_by_supports(question)
    corners = outer_corners(question.cycle)
    r1 = question.bonded[1]
    # Gaps do no work in rigid motions.
    r0 = np.broadcast_to(reactions(system, question.cycle.unscaled), r1.shape)

    upper = [corner_answer(CornerQuestion(question, N, k, r0[k], r1[k], 1.0)) for k in corners]
    for answer in upper:
        if np.isnan(answer.load_factor):
            reason = NO_STATE.format(unbalanced=_unbalanced(answer))
            return _result(question, answer, np.nan, reason, upper)
    largest = min(answer.load_factor for answer in upper)
    governs = next(answer for answer in upper if answer.load_factor <= largest * (1 + RESIDUAL))

    lower = _least_load_factors(question, N, corners, r0, r1)
    first = max(lower, key=lambda answer: answer.load_factor)
    least = first.load_factor
    reason = _reason(governs, largest, first, least)
    if least > largest * (1 + RESIDUAL):
        governs = replace(governs, load_factor=np.nan, bound=np.nan)
        least = np.nan
    return _result(question, governs, least, reason, [*upper, *lower])


def _reason(governs: CornerAnswer, largest: float, first: CornerAnswer, least: float) -> str:
    """The reason, in words, of the largest load factor (`governs`) and of the least (`first`)."""
    if least > largest * (1 + RESIDUAL):
        return APART.format(lower=_load(first), least=least, upper=_load(governs), largest=largest)
    if largest == np.inf:
        start = f" from {least:.4g} on" if least > 0 else ""
        reason = ALL_BALANCED.format(bounds=_bounds(governs.asked.question), start=start)
    else:
        reason = ABOVE.format(unbalanced=_unbalanced(governs))
    if least > 0:
        reason += BELOW.format(least=least, load=_load(first), motion=_motion(first))
    return reason


def _least_load_factors(
    question: Question, N: Array, corners: Sequence[int], r0: Array, r1: Array
) -> list[CornerAnswer]:
    """The answers for the least load factor of each corner; a single answer if all are 0."""
    lower: list[CornerAnswer] = []
    for k in corners:
        # At load factor 0 all corners are alike, unless their fixed parts differ.
        if lower and lower[0].load_factor == 0 and not question.fixed:
            break
        lower.append(corner_answer(CornerQuestion(question, N, k, r0[k], r1[k], -1.0)))
    return lower


def _held_by_supports(question: Question) -> GrossSlip:
    phi = np.zeros((question.system.tangents + 1, question.system.nodes))
    return GrossSlip(
        load_factor=np.inf,
        bound=np.inf,
        least=0.0,
        corner=-1,
        loads="",
        phi=phi,
        motion=motion_table(question.system, phi),
        reason=HELD,
        record=SolveRecord("statics", residual=0.0),
        _asked=None,
        _forces=np.zeros(0),
    )


def _result(
    question: Question,
    governs: CornerAnswer,
    least: float,
    reason: str,
    answers: Sequence[CornerAnswer],
) -> GrossSlip:
    """The answer of the corner that governs, with the records of all programs."""
    phi = governs.phi.reshape(-1, question.system.nodes)
    corners = question.cycle.corner_names
    idle = len(corners) - len({answer.asked.corner for answer in answers})
    left_out: tuple[str, ...] = ()
    if idle:
        left_out = (f"corners: {idle} of {len(corners)} are within the hull of the others",)
    first, *others = (answer.record for answer in answers)
    return GrossSlip(
        load_factor=governs.load_factor,
        bound=governs.bound,
        least=least,
        corner=governs.asked.corner if np.isfinite(phi).all() and phi.any() else -1,
        loads=corners[governs.asked.corner] if phi.any() else "",
        phi=phi,
        motion=motion_table(question.system, phi),
        reason=reason,
        record=replace(
            first.joined(others, question.started), solver=governs.record.solver, left_out=left_out
        ),
        _asked=governs.asked,
        _forces=governs.forces,
    )


def _with_self_stress(statics: GrossSlip, question: Question) -> GrossSlip:
    """The answer of statics, with contact forces that balance themselves if there are any.

    Without friction, or if the cyclic loads drive no body, statics alone gives the answer.
    """
    system = question.system
    friction = question.friction
    if statics._asked is None or np.isnan(statics.load_factor) or not friction.any():
        return statics
    N = system.rigid_motions
    if not any(drives(N, r) for r in question.bonded[1]):
        return statics
    forces = self_stress(system, friction, N)
    if forces is None:
        return statics
    return replace(statics, self_stress=forces, reason=SELF_STRESSED.format(statics=statics.reason))


def _with_transients(statics: GrossSlip, question: Question, seconds: float) -> GrossSlip:
    """The answer of statics, corrected by transients for at most so many seconds."""
    found = sliding_off(
        question.system, question.cycle, question.friction, statics.load_factor, seconds
    )
    load_factor = found.low
    unknown = statics.reason
    if not found.complete:
        if load_factor == 0:
            raise SolverError(
                f"gross slip: no transient went on within {seconds:g} s, so it is only known that "
                f"the load factor is at most {statics.bound:.6g}, by equilibrium; give more "
                "`seconds`, or seconds=0 for equilibrium alone"
            )
        end = f", but not at {found.high:.4g} ({found.why})" if found.why else ""
        cycles = "they go on" if found.cycles else "their first cycle goes on"
        reason = STOPPED.format(
            seconds=seconds, cycles=cycles, load_factor=load_factor, end=end, unknown=unknown
        )
    elif not found.why:
        return replace(statics, reason=GOES_ON.format(unknown=unknown))
    elif load_factor == 0:
        reason = SLIDES_OFF_AT_ANY.format(why=found.why, unknown=unknown)
        load_factor = np.nan
    else:
        reason = SLIDES_OFF_ABOVE.format(load_factor=load_factor, why=found.why, unknown=unknown)
    return replace(statics, load_factor=load_factor, reason=reason)
