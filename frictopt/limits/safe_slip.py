"""A safe residual slip at a given load factor, with its margin; or the proof that there is none."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ..base import (
    RESIDUAL,
    ROUNDING,
    PerNode,
    SolveRecord,
    Table,
    finite_number,
    progress_bar,
    warns_of_odd_values,
    worst,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from .answers.answered import Proven, answered, check_margin, reserve_of
from .answers.reasons import safe_slip_reason
from .events.lift_off import LiftOff
from .events.ordered import ordered_program, read_solution, solved_program
from .program import assembled
from .program.question import Question, pose
from .program.solution import Solution, solve
from .rest_intervals import safe_with_moving_areas
from .search.order_search import best_with_events
from .shakedown import (
    LIMITS,
    ShakedownLimit,
    check_events,
    limit_of_any_set,
)


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Proven):
    """Residual slip that keeps the contact stuck, or the proof that no such slip exists.

    Attributes
    ----------
    load_factor
        The given load factor.
    slip
        (N,) or (N, 2) the slip with the largest margin, length. It is unsafe if the margin is
        negative. See `largest_slip`.
    margin
        Smallest reserve `f p - |q|` over nodes and corners, divided by the mean friction bound at
        load factor 0 (gaps shut); at most 1. If it is negative, no slip is safe. At nodes with
        friction below 0.01, a tension also counts as a violation, as if friction were 0.01. At open
        nodes the reserve is the gap, in units of the mean friction bound divided by the mean normal
        stiffness. Nodes that open or close at an event (`events`) have no reserve there.
    bound
        Upper bound of the margin, from the multipliers only; it equals `margin` up to `residual`.
    record
        Solver, attempts and time. Its `residual`, at most 1e-9, is the largest of these errors: the
        margin minus the recomputed reserve of the slip; the relative distance of `bound` from
        `margin`; the excess over a slip bound; with events, the violation of the contact law.
    problem
        The solved cvxpy problem.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
    >>> safe = fo.safe_slip(rod, cycle, friction=0.5, load_factor=0.8)
    >>> safe.exists, safe.certificate is None, round(safe.margin, 6)
    (True, True, 0.2)
    """

    _shown_names = ("exists", "margin", "bound", "largest_slip", "residual", "reason")
    margin: float
    bound: float

    @cached_property
    def friction_rate(self) -> float:
        """Rate at which the margin grows if friction increases equally at all nodes."""
        return float(self._by_friction.sum())

    @property
    def exists(self) -> bool:
        """Whether a safe slip exists at the load factor.

        At the shakedown limit the margin is exactly 0. So a margin that is negative by 1e-12, or by
        its residual, still counts as safe.
        """
        return bool(self.margin >= -max(ROUNDING, self.residual))

    _has_safe_slip = exists

    def check_kept(self) -> None:
        """Check the slip and the margin of an answer from a file; ValueError if one is wrong."""
        super().check_kept()
        check_margin(self._question, self.load_factor, self.slip, self.margin, self.bound)

    @cached_property
    def reason(self) -> str:
        """Effect of the slip, or diagnosis of the mean load if no slip is safe, in words."""
        return safe_slip_reason(self, self.exists)

    @cached_property
    def certificate(self) -> Table | None:
        """Proof that no slip is safe (Farkas's lemma), a table like `ShakedownLimit.mechanism`.

        The table has slips on which the loads do more work than friction can dissipate. The forces
        of a residual slip do no work on these slips. Within a slip bound they do some work, but too
        little to keep the contact stuck. None if a slip is safe.
        """
        return None if self.exists else self._mechanism

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        return "safe residual slip", self.margin, self._mechanism, self.reason


def safe_slip_of_question(
    question: Question,
    load_factor: float,
    events: bool = False,
    enough: float = np.inf,
) -> SafeSlip:
    """Safe slip with all nodes closed or, if there is none, with the open nodes of a limit.

    The limit is the best limit of the search, or the first limit that reaches `enough`. With
    `events`, or if loads alone open and close nodes, nodes may open and close in each cycle.
    """
    check_events(events, question, False)
    load_factor = checked_load_factor(question, load_factor)
    moving: SafeSlip | None = safe_with_moving_areas(question, load_factor, safe_slip_of_set)
    if moving is not None:
        return moving
    closed = None
    # A slip that meets almost no resistance, such as rolling, can hide the margin in rounding.
    with suppress(SolverError):
        closed = safe_slip_of_set(question, load_factor)
    if closed is not None and closed.exists:
        return closed
    limit = limit_of_any_set(question, start_by=load_factor, enough=enough)
    safe = closed
    if safe is None or limit.open.any():
        safe = safe_slip_of_set(limit._question, load_factor)
    if safe.exists or not events:
        return safe
    return _with_events(limit, load_factor) or safe


def _with_events(limit: ShakedownLimit, load_factor: float) -> SafeSlip | None:
    """The safe slip of an order of events, searched from a limit; None if none is found."""
    limit = best_with_events(LIMITS, limit, load_factor)
    ordered = limit._question
    # At the limit itself, rounding must not decide.
    low, high = limit.least * (1 - RESIDUAL), limit.load_factor * (1 + RESIDUAL)
    if isinstance(ordered, LiftOff) and low <= load_factor <= high:
        return safe_slip_of_set(ordered, load_factor)
    if isinstance(ordered, LiftOff) and np.isnan(limit.least):
        # The least load factor is not known, so the order may have no slip at `load_factor`.
        with suppress(SolverError):
            return safe_slip_of_set(ordered, load_factor)
    return None


def safe_slip_of_set(question: Question, load_factor: float) -> SafeSlip:
    """The slip with the largest margin, with the open nodes or the order of events of the question.

    A node has no reserve at the event at which it opens or closes.
    """
    if isinstance(question, LiftOff):
        program = ordered_program(question, load_factor)
    else:
        program = assembled.safe_slip(question, load_factor)
    safe, record = solve(program, partial(checked_slip, question, load_factor))
    return answered(safe, record)


def checked_load_factor(question: Question, load_factor: float) -> float:
    """The load factor; ModelError if it is so large that rounding hides the mean load."""
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    largest = load_factor / question.force * float(np.abs(question.r1).max())
    # Ratio of cyclic loads to the mean normal force above which rounding hides the mean load.
    largest_ratio = 1e15
    if largest > largest_ratio:
        raise ModelError(
            f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean "
            f"normal force {question.force:.3g} of the mean load, so that rounding of the "
            "cyclic loads hides the mean load; give a smaller load factor, or check the units "
            "of the load cases"
        )
    return load_factor


@warns_of_odd_values
def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    events: bool = False,
    slip_bound: PerNode | None = None,
    simplify: bool = True,
    solver: str | None = None,
    progress: bool = True,
) -> SafeSlip:
    """Find the residual slip with the largest margin at the corners of a cycle. Theory, eq. (9).

    Parameters
    ----------
    system, cycle, friction, slip_bound, simplify, solver, progress
        See `shakedown_limit`.
    load_factor
        Load factor, >= 0.
    events
        Whether nodes may also open and close in each cycle (`shakedown_limit`), if no slip is safe
        with nodes that stay open or closed. If slip changes no pressure (B = 0), all nodes have
        friction, the law is Coulomb's, and no `slip_bound` is given, nodes may open and close even
        with `events=False`.

    Returns
    -------
    SafeSlip
        The slip and its margin, which is negative if no slip is safe.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> fo.safe_slip(rod, cycle, friction=0.5, load_factor=0.6).exists
    False
    """
    with progress_bar(progress, "safe slip"):
        question = pose(
            system, cycle, friction, simplify=simplify, slip_bound=slip_bound, solver=solver
        )
        return safe_slip_of_question(question, load_factor, events=events)


def checked_slip(question: Question, load_factor: float, solution: Solution) -> SafeSlip:
    """The slip of a solution for the largest margin, checked by its reserve and the multipliers."""
    question, slip, motion = read_solution(question, solution, load_factor)
    margin = solution.value
    reserve = reserve_of(question, load_factor, slip)

    bound, defect = solution.bound
    violations = [
        (abs(bound - margin) + defect) / max(1.0, abs(margin)),
        margin - reserve,
        question.violation(load_factor, slip) if question.events else 0.0,
        question.excess_over_slip_bound(slip),
    ]
    values = {"load_factor": load_factor, "margin": margin}
    return SafeSlip(
        load_factor=load_factor,
        slip=slip,
        record=SolveRecord(residual=worst(violations)),
        _question=question,
        _motion=motion,
        margin=margin,
        bound=bound + defect,
        _solved=solved_program(question, solution, "safe_slip", **values),
    )
