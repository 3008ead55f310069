"""The shakedown limit: the largest load factor at which some residual slip is safe.

A slip is safe if every node either sticks and stays closed at every corner of the load cycle, or
stays open at every corner. The steps from `shakedown_limit` to its answer follow from top to
bottom: pose the question, assemble its arrays, solve them, check the solution, complete the answer.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    FLOOR,
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    LimitKind,
    Outcome,
    PerNode,
    SolveRecord,
    Table,
    frozen,
    progress_bar,
    warns_of_odd_values,
    worst,
)
from ..base.checks import finite_number, flag, flags, whole_number
from ..contact import ContactProducts, ContactSystem, LoadCycle
from ..errors import ModelError, ModelWarning, NoContinuation, SolverError
from ..solve.solvers import INFEASIBLE, UNBOUNDED, NoOptimum
from . import rest_intervals
from .answers.answered import answered
from .answers.reasons import cause_of_growth, shakedown_reason
from .answers.sentences import BETWEEN, CHOSEN, CONTRADICTED, STOPPED_WIDE
from .answers.shakedown_answer import ShakedownAnswer
from .between.cones import (
    Cones,
    Point,
    check_known,
    check_options,
    cones_of,
    judged,
    margins,
    mechanism_of,
    record_of,
    without_gap,
)
from .between.search import Method, search
from .events.lift_off import LiftOff
from .events.ordered import read_solution, solved_program
from .gross_slip import statics_alone
from .moving.moving_areas import moving_areas
from .probability import RandomLimit, ShakedownProbability, probability_of
from .program import assembled
from .program.question import Question, pose, with_open
from .program.rest_program import RestProgram
from .program.solution import (
    Mechanism,
    NotAbove,
    Solution,
    contradiction,
    growth,
    solve,
)
from .search.likely_sets import is_safe_at_mean_load, open_under_mean
from .search.order_search import Limits, best_with_events
from .search.set_search import best_open_set, may_open

# One file because a reader follows the question to its answer here, from top to bottom.


@warns_of_odd_values
def shakedown_limit(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    open_nodes: ArrayLike | None = None,
    events: bool = False,
    programs: int | None = None,
    slip_bound: PerNode | None = None,
    simplify: bool = True,
    solver: str | None = None,
    gap: float | None = None,
    progress: bool = True,
) -> ShakedownLimit:
    """Largest load factor with a safe slip; whether slip stops may then depend on the start.

    Between the guaranteed limit and this limit, slip stops from some starts and goes on from other
    starts; `limit_after_protocol` shows whether it stops after one assembly. Safe means: every node
    sticks at every corner of the cycle, or is open during the whole cycle (`ShakedownLimit.open`).
    With `events`, nodes may also be open during a part of the cycle. In a small contact all sets of
    open nodes are compared, and the best one is proven (`ShakedownLimit.best_of_all`). In a larger
    contact, the search tries only sets near the nodes that the settled mean load opens: with other
    nodes open, the contact may shake down above the limit. If the contact is uncoupled (B = 0),
    only loads open and close nodes. Then the limit holds for all openings and closings (theory,
    "Contact areas that move"). If the load factor scales normal loads, too, the contact may shake
    down again above the limit, see `ShakedownLimit.intervals`. Ctrl-C in a search raises
    KeyboardInterrupt with an attribute `limit`, the best limit so far. Theory, eq. (7); Flicek et
    al. 2015, section 4; Bjorkman & Klarbring 1987.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle. With a `gap` also a `ContactProducts`, closed at all nodes.
    friction
        Coefficient of friction: one for all nodes, one per node, or one per contact, as a mapping
        or a series of pandas by the names of the contacts.
    open_nodes
        (N,) bool, the nodes that stay open; all other nodes stay closed. None: search them. All
        False: the limit with all nodes closed.
    events
        Whether nodes may also open and close in each cycle (`ShakedownLimit.events`). Their order
        is searched by pivots and transients, which takes some seconds. If the load does not return
        along the same path, no order is searched, because events cannot raise the limit. Not
        allowed with a slip bound, a shear strength, `open_nodes`, constraints or an objective.
    programs
        Largest number of programs of the search of open nodes. If it is given, the search compares
        all sets as far as this number allows. None: 2000 if the contact has at most 14 nodes, in
        space 8, and if corners times nodes times axes are at most 240; all sets are then compared,
        too. Otherwise 60, and only sets near the nodes that the settled mean load opens are
        compared. `ShakedownLimit.bound_of_sets` is the upper bound that is proven for all sets.
    slip_bound, simplify, solver
        See `ShakedownModel`.
    gap
        Relative distance that two proven numbers may have, above 0 and below 1, such as 0.01; None:
        the limit itself, proven to 1e-9. With a gap, `ShakedownLimit.load_factor` is proven from
        below and `ShakedownLimit.bound` from above, by a first-order method that needs only
        products: in space, from some hundred nodes on, it takes a fraction of the time (theory, "A
        limit between two proven numbers"). The nodes that stay open are `open_nodes` or, if these
        are None, the nodes that the mean load opens. No other sets are searched, so `programs` is
        refused, like `events`, `slip_bound` and `solver`. A closed node without friction is
        refused, too. If the method ends with a wider gap, a `ModelWarning` and the reason say so.
    progress
        Whether to show the progress after two seconds, as a bar or in lines without a terminal.

    Returns
    -------
    ShakedownLimit
        The load factor with its proof, a safe slip, and the mechanism that limits it.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> limit = fo.shakedown_limit(rod, cycle, friction=0.5)
    >>> round(limit.load_factor, 6), limit.best_of_all
    (0.5, True)
    >>> close = fo.shakedown_limit(rod, cycle, friction=0.5, gap=0.01)
    >>> bool(0.495 <= close.load_factor <= 0.5 <= close.bound <= 0.505)
    True
    """
    with progress_bar(progress, "shakedown limit"):
        question = pose(
            system,
            cycle,
            friction,
            simplify=simplify,
            slip_bound=slip_bound,
            solver=solver,
            question_name="shakedown_limit",
        )
        if gap is not None:
            given = {"events": flag("events", events), "programs": programs is not None}
            given |= {"slip_bound": slip_bound is not None, "solver": solver is not None}
            check_options(given, without_gap(system))
            return limit_within(question, open_nodes, finite_number("gap", gap, above=0, below=1))
        if programs is not None:
            programs = whole_number("programs", programs, least=1)
        return limit_of_question(question, open_nodes, events, programs=programs)


def limit_of_question(
    question: Question,
    open_nodes: Any,
    events: bool,
    user: Any = None,
    programs: int | None = None,
) -> ShakedownLimit:
    """The limit with given nodes open, or with the best set of open nodes that a search finds.

    With `events` some nodes may open and close in each cycle. `user`: the `UserRows`.
    `programs`: see `best_open_set`.
    """
    restricted = user is not None or open_nodes is not None
    check_events(events, question, restricted)
    if not restricted:
        moving = rest_intervals.limit_of_moving_areas(question, limit_of_set)
        if moving is not None:
            return moving
    if open_nodes is not None:
        return limit_of_set(_with_given(question, open_nodes), user=user)
    limit = limit_of_any_set(question, programs=programs)
    if user is not None:
        return limit_of_set(limit._question, user=user)
    known = rest_intervals.up_to_last_rest(question, limit, limit_of_set)
    if not events:
        return known
    if known is limit:
        return best_with_events(LIMITS, limit)
    # `known` covers all openings and closings, from the load factor 0 on. If `limit` also begins at
    # 0, a search of orders from there can name the events of the same limit.
    if limit.least != 0:
        return known
    ordered = best_with_events(LIMITS, limit)
    as_high = ordered.load_factor >= known.load_factor * (1 - RESIDUAL)
    return replace(ordered, _ends_rests=True) if as_high else known


def limit_of_all_openings(question: Question) -> ShakedownLimit | None:
    """The limit for all openings and closings, if loads alone decide them; else None."""
    if moving_areas(question) is None and not rest_intervals.knows_all_pieces(question):
        return None
    return limit_of_question(question, None, False)


def limit_of_any_set(
    question: Question,
    start_by: float = np.inf,
    enough: float = np.inf,
    programs: int | None = None,
) -> ShakedownLimit:
    """The limit with the best open nodes that a search finds; see `best_open_set`."""
    closed = _in_search(question, -np.inf) if may_open(question) else limit_of_set(question)
    best = best_open_set(_in_search, closed, start_by, enough, programs)
    if best._solved is None:
        # It is not proven yet that no load factor is safe.
        proven = limit_of_set(best._question)
        return replace(proven, least=best.least, _searched=best._searched)
    return best


def _in_search(question: Question, above: float) -> ShakedownLimit:
    """A limit for the search, without a proof if no load factor is safe. May raise `NotAbove`."""
    return limit_of_set(question, above=above, proven=False)


def limit_of_set(
    question: Question,
    largest: float = np.inf,
    *,
    user: Any = None,
    above: float = -np.inf,
    proven: bool = True,
) -> ShakedownLimit:
    """The limit with given open nodes, at most `largest`.

    `NotAbove` if multipliers prove that it is at most `above`. Without `proven`, as for the many
    sets of a search, a solver need not prove its report that no load factor is safe, and plain
    cvxpy is not tried.
    """
    program = assembled.shakedown(question)
    if np.isfinite(largest):
        program.row("most", {"load_factor": -1.0}, largest)
    if user is not None:
        user.add_to(program)

    claimed = partial(checked_limit, question)

    def none(outcome: str) -> ShakedownLimit | None:
        if outcome == INFEASIBLE and not proven:
            return _not_finite(question, LimitKind.NO_SAFE_SLIP, 0.0)
        return without_limit(program)

    try:
        limit, record = solve(program, claimed, no_optimum=none, above=above)
    except SolverError as error:
        if (
            isinstance(error, (NoOptimum, NotAbove))
            or question.solver is not None
            or user is not None
            or np.isfinite(largest)
            or not proven
        ):
            raise
        # Imported here, because cvxpy is slow to import.
        from .printed.last_resort import by_plain_cvxpy

        limit, record = by_plain_cvxpy(question, claimed, error)
    if limit._solved is None:
        return limit
    if user is not None:
        limit = replace(limit, _solved=user.listed(limit._solved))
    limit = answered(limit, record)
    if limit.kind is LimitKind.NO_SAFE_SLIP or limit.objective is not None:
        return limit
    slip = limit.slip if limit.kind is LimitKind.FINITE else None
    if user is None and is_safe_at_mean_load(question, slip):
        return replace(limit, least=0.0)
    return _with_least(limit, program, claimed)


def _with_least(
    limit: ShakedownLimit,
    program: RestProgram,
    claimed: Callable[[Solution], ShakedownLimit],
) -> ShakedownLimit:
    """The limit, completed by the least safe load factor from a second program."""
    try:
        lower, record = solve(program, claimed, -1.0)
    except SolverError:
        # Rounding hides whether some slip is safe under the mean load. The limit stands, and the
        # least safe load factor is not known.
        return limit
    record = limit.record.joined([record], limit._question.started)
    return replace(limit, least=lower.load_factor, record=record)


def limit_of_order(
    question: LiftOff, program: RestProgram, sense: float, above: float = -np.inf
) -> ShakedownLimit:
    """The largest (sense 1) or least load factor of an order of events.

    `NotAbove` if multipliers prove that the largest one is at most `above`.
    """
    limit, record = solve(
        program,
        partial(checked_limit, question),
        sense,
        no_optimum=lambda outcome: _every_load_is_safe(question, program),
        above=above,
    )
    return answered(limit, record)


LIMITS = Limits(limit_of_set, limit_of_order)
"""The limits that a search of orders compares."""


def _all_intervals(question: Question) -> Array:
    """(n, 2) all load factors with a state of rest; see `ShakedownLimit.intervals`."""
    if rest_intervals.knows_all_pieces(question):
        rests = rest_intervals.rests(question, limit_of_set)
        found = [(rest.least, rest.largest) for rest in rests]
        if not found or found[0][0] > 0:
            # The walk misses an interval that begins at 0 and ends before its first step.
            limit = limit_of_question(question, None, False)
            if not limit.least:
                found.insert(0, (0.0, limit.load_factor))
        return np.array(found).reshape(-1, 2)
    limit = limit_of_question(question, None, False)
    if not limit._all_states:
        raise ModelError(
            "intervals: nodes may open and close in states of rest that no theorem covers. The "
            "theorems need a contact in which slip changes no pressure, Coulomb's law with "
            "friction at all nodes, and the same fixed loads at all corners if normal loads are "
            "scaled; `least` and `load_factor` belong to the openings of the limit"
        )
    known = [] if np.isnan(limit.load_factor) else [(limit.least, limit.load_factor)]
    return np.array(known, dtype=float).reshape(-1, 2)


def _with_given(question: Question, open_nodes: Any) -> Question:
    """The question with the open nodes that the user gives."""
    opened = with_open(question, flags("open_nodes", open_nodes, question.system.nodes))
    if opened is None or opened.open_nodes.all():
        raise ModelError(
            "open_nodes: the closed nodes are too few to hold the open nodes; leave more nodes "
            "closed"
        )
    return opened


def limit_within(question: Question, open_nodes: Any, gap: float) -> ShakedownLimit:
    """The limit between two proven numbers, with the open nodes given, or of the mean load."""
    remedy = without_gap(question.system)
    by_products = isinstance(question.system, ContactProducts)
    if open_nodes is not None:
        question = _with_given(question, open_nodes)
    elif not by_products:
        if moving_areas(question) is not None:
            raise ModelError(
                "gap: loads alone open and close nodes of this uncoupled contact in each cycle, "
                f"which a limit with a gap does not know; give open_nodes, or {remedy}"
            )
        # If fixed parts differ, the mean load has no single set.
        if may_open(question) and not question.fixed:
            for opened in open_under_mean(question):
                if not opened.all():
                    question = with_open(question, opened) or question
    check_known(question, remedy)
    cones = cones_of(question)
    found = search(cones, gap)
    safe, bound = found.safe.best, found.multipliers.bound
    if found.safe.grows or bound < 0:
        if not by_products:
            # The exact program proves that the limit is infinite, or that no slip is safe.
            return limit_of_set(question)
        limit = _not_finite_by_products(question, cones, found)
        if limit is not None:
            return limit
    if safe is None or not np.isfinite(bound):
        missing = "safe slip" if safe is None else "bound"
        raise SolverError(
            f"gap: {found.steps} steps found no {missing}, and nothing proves that there is none; "
            f"{remedy}"
        )
    return _between(question, cones, found, safe, gap)


def _not_finite_by_products(
    question: Question, cones: Cones, found: Method
) -> ShakedownLimit | None:
    """The proof that no slip is safe, or that every load factor is safe; None without a proof."""
    if found.multipliers.bound < 0:
        moves = found.multipliers.moves
        # The cyclic loads must not resist the mechanism; otherwise a large load factor may hold it.
        against = float((moves * cones.rate).sum().clip(0.0) / -(moves * cones.start).sum())
        motion = mechanism_of(question, cones, moves)
        limit = _not_finite(question, LimitKind.NO_SAFE_SLIP, against, motion)
        return limit if against <= RESIDUAL else None
    first, last = found.first, found.safe.best
    if last is None or margins(first.rows).min() < 0:
        return None
    # Residual shear that grows with the load factor, or that stays the same.
    along = (last.shear - first.shear) / max(last.load_factor - first.load_factor, FLOOR)
    for shear in (along, np.zeros_like(along)):
        unsafe = -float(margins(cones.rate + cones.effects(shear)).min().clip(max=0.0))
        if unsafe <= RESIDUAL:
            return _not_finite(question, LimitKind.UNBOUNDED, unsafe, least=0.0)
    return None


def _between(
    question: Question, cones: Cones, found: Method, safe: Point, gap: float
) -> ShakedownLimit:
    """The limit of a safe point and of multipliers, after both have been checked."""
    lower, slip, unsafe, motion, bound, defect = judged(
        question, cones, safe, found.multipliers.moves
    )
    upper = max(bound + defect, lower)
    size = max(upper, FLOOR * question.load_unit)
    record = record_of(question, lower, slip, worst([unsafe, defect / size]))
    proven = (upper - lower) / size
    stopped = ""
    if proven > gap:
        stopped = STOPPED_WIDE.format(gap=gap, remedy=without_gap(question.system))
        warnings.warn(f"shakedown_limit: {stopped[2:]}", ModelWarning, stacklevel=5)
    why = BETWEEN.format(
        lower=lower,
        upper=upper,
        gap=100 * proven,
        slip="residual slip",
        node_states=question.node_states,
        steps=found.steps,
        stopped=stopped,
    )
    limit = ShakedownLimit(
        lower,
        slip,
        record,
        question,
        motion,
        LimitKind.FINITE,
        upper,
        least=0.0 if margins(found.first.rows).min() >= 0 else np.nan,
        gap=proven,
        _why=why,
    )
    return answered(limit, record)


def check_events(events: object, question: Question, restricted: bool) -> None:
    """ModelError if the search for nodes that open and close in each cycle cannot be used.

    `restricted`: whether the user gives open nodes, constraints or an objective.
    """
    if not flag("events", events):
        return
    reasons = {
        "the slip is bounded": question.slip_bound is not None,
        "the surface has a shear strength": question.system.capped,
        "they cannot be combined with open_nodes, constraints or an objective": restricted,
    }
    for reason, holds in reasons.items():
        if holds:
            raise ModelError(f"events: {reason}; pass events=False")


def checked_limit(question: Question, solution: Solution) -> ShakedownLimit:
    """The limit of a solution, with its violations and its bound."""
    load_factor = solution.load_factor
    question, slip, motion = read_solution(question, solution)
    bound, defect = solution.bound
    objective = None if solution.program.goal == "load_factor" else solution.value
    return ShakedownLimit(
        load_factor,
        slip,
        SolveRecord(residual=solution.residual(question.violation(load_factor, slip))),
        question,
        motion,
        LimitKind.FINITE,
        bound + defect,
        objective=objective,
        _why="" if objective is None else CHOSEN,
        constraints=solution.program.constraints,
        _solved=solved_program(question, solution, "shakedown"),
    )


def without_limit(program: RestProgram) -> ShakedownLimit | None:
    """The proven answer that no load factor is safe, or that all above some value are safe.

    The result is None without a proof. ModelError if an objective of the user grows without end.
    """
    question = program.question
    if program.constraints:
        # If no slip is safe even without the constraints of the user, they are not the cause.
        limit = _nothing_is_safe(assembled.shakedown(question))
        if limit is not None:
            return limit
    limit = _nothing_is_safe(program)
    if limit is not None:
        return limit
    grown = growth(program)
    if grown is None:
        return None
    if program.goal != "load_factor":
        raise ModelError(
            "objective: it grows without bound over the safe slips; subtract a penalty, or bound "
            "it by a constraint"
        )
    along, residual = grown
    solved = replace(along.solved("shakedown"), status=UNBOUNDED, values=along.growing)
    return _not_finite(
        question,
        LimitKind.UNBOUNDED,
        residual,
        _why="" if program.constraints else cause_of_growth(solved),
        constraints=program.constraints,
        _solved=solved,
    )


def _nothing_is_safe(program: RestProgram) -> ShakedownLimit | None:
    """The answer that no slip is safe at any load factor, if it is proven."""
    found = contradiction(program)
    if found is None:
        return None
    claim, residual = found
    question = program.question
    why = ""
    rows = ", ".join(claim.ruling)
    if rows:
        why = CONTRADICTED.format(node_states=question.node_states, rows=rows)
    return _not_finite(
        question,
        LimitKind.NO_SAFE_SLIP,
        residual,
        claim.motion,
        _why=why,
        constraints=program.constraints if rows else (),
        _solved=replace(claim.solved("shakedown"), status=INFEASIBLE),
    )


def _every_load_is_safe(question: LiftOff, program: RestProgram) -> ShakedownLimit | None:
    """The limit of an order with which all load factors are safe, proven; else None."""
    grown = growth(program)
    if grown is None:
        return None
    along, residual = grown
    placed, _, motion = read_solution(question, along)
    found = replace(solved_program(question, along, "ordered"), status=UNBOUNDED)
    return _not_finite(placed, LimitKind.UNBOUNDED, residual, motion, _solved=found)


def _not_finite(
    question: Question,
    kind: LimitKind,
    residual: float,
    motion: Mechanism | None = None,
    **more: Any,
) -> ShakedownLimit:
    """The answer without a finite limit; `residual` is the error of its proof."""
    value = np.inf if kind is LimitKind.UNBOUNDED else np.nan
    return ShakedownLimit(
        value,
        np.full(question.system.slip_shape, np.nan),
        SolveRecord(residual=residual),
        question,
        motion or Mechanism(np.zeros_like(question.r1), question.friction),
        kind,
        value,
        **more,
    )


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(ShakedownAnswer):
    """Shakedown limit with its proof from both sides, for one set of `open` nodes.

    A search finds the set. If `best_of_all` is True, no other set is better; else `bound_of_sets`
    is the upper bound that is proven for all sets. With `events` some nodes may open and close in
    each cycle. With other open nodes, or another order of events, the contact may shake down above
    the limit, see `covers`. Theory, eq. (8).

    Attributes
    ----------
    load_factor, kind
        lambda_2, the largest load factor with a safe slip. It is inf if all load factors above some
        value have a safe slip, and nan if no load factor has one; see `kind`.
    least
        Load factors from `least` to `load_factor` have a safe slip. It is 0 for a contact that is
        safe under its mean load, and above 0 if no slip is safe under the mean load and the cyclic
        loads press the contact. Below `least` no slip is safe with these open nodes; with other
        open nodes, a slip may be safe (`safe_slip`). The proof is as for the limit, also with a
        slip bound and user constraints. Just above `least` the open nodes may differ from `open`.
        NaN if no load factor is safe, if rounding hides the value (see `reason`), with an
        objective, and if `bound` is infinite because of `events`. With a `gap` it is 0 or, if it is
        not known to be 0, NaN.
    slip
        (N,) or (N, 2) a residual slip that is safe at the limit, length; NaN if `load_factor` is
        not finite. See `largest_slip`. Open nodes have their slip under the mean load.
    bound
        Upper bound of the limit for this set of open nodes only. The bound follows from the
        mechanism, and with user constraints also from their multipliers. It equals `load_factor` up
        to `residual`, or up to `gap` if a gap is given. The bound is inf if all load factors above
        some value are safe, and also if nodes open or close while fixed and scaled loads both vary:
        the program is then not convex, and proves no bound.
    record
        Solver, attempts and time. If no answer of the arrays passes the checks, plain cvxpy solves
        `problem`, and the solver is "cvxpy: CLARABEL". The `residual`, at most 1e-9, is the larger
        of two errors: the violation of the contact law by `slip` at the corners, and the relative
        distance of `bound`. If `least` is above 0, the same two errors of `least` count, too.
        Without a finite limit it is the error of the proof.
    constraints
        Names of user constraints, and "objective" if you passed an objective. They are part of the
        program; slip, residual and bound take them into account.
    objective
        Largest value of your objective, or None without an objective. With an objective,
        `load_factor` is the load factor of the slip that maximizes it, `bound` is an upper bound of
        the objective, and `friction_rate` is the rate of the objective.
    gap
        Distance of `bound` from `load_factor`, relative to `bound` (to a thousandth of the unit of
        load factors if that is larger); None unless `gap` was passed. The limit is between the two.
        `residual` is then the error of each of the two proofs. The multipliers are rough, so
        that `problem`, `multipliers`, and all rates raise a ModelError.
    problem
        The solved cvxpy problem, in your units. A later solve of the same `ShakedownModel`
        overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.shakedown_limit(system, cycle, friction=0.5)
    >>> limit.kind.name, round(limit.load_factor, 6), round(limit.bound, 6)
    ('FINITE', 0.535714, 0.535714)
    >>> limit.mechanism[["node", "corner", "direction"]].sort_values("corner", ignore_index=True)
       node  corner  direction
    0     0       0          1
    1     0       1         -1
    2     1       1         -1

    If shear and pressure of a cylinder grow together, it sticks up to gross slip, though its edges
    open in every cycle:

    >>> arrays = fo.reference.half_plane_contact(20, half_length=1.6, E_star=1.0, R=1.0)
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays)
    >>> in_phase = fo.LoadCycle({"P": 1.0}, [{"P": 0.5, "Q": 0.1}, {"P": -0.5, "Q": -0.1}])
    >>> limit = fo.shakedown_limit(cylinder, in_phase, friction=0.4)
    >>> round(limit.load_factor, 6), round(0.4 / (0.4 * 0.5 + 0.1), 6)
    (1.333333, 1.333333)
    >>> limit.events["event"].value_counts().to_dict()
    {'opens': 10, 'closes': 10}
    """

    @cached_property
    def reason(self) -> str:
        """Explanation of the limit in words."""
        return shakedown_reason(self)

    @cached_property
    def bound_of_sets(self) -> float:
        """Load factor that no set of nodes that stay open all through the cycle exceeds.

        It is the bound of the search, or `bound_for_all` if that is less. Sets that are safe at no
        load factor up to the limit do not count. -inf if no set has a safe load factor.
        """
        if self.best_of_all:
            return self._searched.bound
        return min(self._searched.bound, self.bound_for_all)

    @cached_property
    def bound_for_all(self) -> float:
        """Load factor above which no state of rest exists, for any start and any open nodes.

        If the limit covers all states of rest, it is `bound`, or 0 if no state of rest exists.
        Otherwise it follows from equilibrium alone: `bound` of `gross_slip`, or 0 if equilibrium
        excludes every load factor. Inf if supports hold the bodies: then the states that `covers`
        leaves out have no proven bound. SolverError if no solver's answer passes the checks.
        """
        if self._all_states:
            return 0.0 if np.isnan(self.bound) else self.bound
        largest = statics_alone(self.system, self.cycle, self.friction)
        return 0.0 if np.isnan(largest) else largest

    @property
    def proven(self) -> bool:
        """Whether no state of rest exists above the limit: `bound_for_all` equals it up to 1e-6."""
        largest = self.load_factor * (1 + 1e-6)
        return bool(self.bound_for_all <= largest + ZERO_LOAD_FACTOR * self._question.load_unit)

    @cached_property
    def intervals(self) -> Array:
        """(n, 2) all load factors with a state of rest: from column 0 to column 1 of each row.

        All openings and closings count; a slip bound and constraints do not. If the load factor
        scales normal loads of an uncoupled contact, the contact may slip above the limit and come
        to rest again at higher load factors (theory, "Normal loads that are scaled, too"). A
        contact that is open at every corner counts as a contact at rest. An interval that is
        shorter than 1e-6 of its load factor, such as a single load factor, may be left out.

        ModelError if slip changes pressures, if a node has no friction, or if fixed parts differ
        while normal loads are scaled: then only `least` and `load_factor` are known. SolverError if
        no solver's answer passes the checks.

        Examples
        --------
        >>> import frictopt as fo
        >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
        >>> path = [(0, 0), (-1, 0), (-2, 0.1), (-2, -0.1), (-1, 0)]
        >>> cycle = fo.LoadCycle({"P": 1.0}, [{"P": p, "Q": q} for p, q in path])
        >>> fo.shakedown_limit(node, cycle, friction=0.5).intervals.round(4).tolist()
        [[0.0, 0.4545], [1.0, inf]]
        """
        question = pose(self.system, self.cycle, self.friction)
        return frozen(_all_intervals(question))

    def probability(
        self,
        *,
        friction: Any = None,
        preload: Mapping[str, Any] | None = None,
        load: Any = 1.0,
        correlation_length: float | None = None,
        assembled: bool = False,
        draws: int = 200,
        seed: int = 0,
    ) -> ShakedownProbability:
        """Probability that slip stops from some start, with random friction, preloads and load.

        FORM finds it with the rates of some five limits, and a sample of limits corrects it. All
        inputs are independent. If only the friction of all nodes is random,
        `RequiredFriction.probability` is exact and cheaper. Nodes are open and closed as in this
        limit. With other open nodes more joints may come to rest, so the exact probability for
        these open nodes is a lower bound. The answer also has the errors of FORM and of the sample.

        Parameters
        ----------
        friction
            Frozen distribution of `scipy.stats`, such as `lognorm(0.1, scale=0.3)`, or a mapping
            from names of contacts to such distributions. Contacts without a distribution have the
            friction of the limit.
        preload
            Load case of the mean load -> distribution of its amplitude.
        load
            Load factor, or its distribution.
        correlation_length
            Length over which the friction of a face varies from node to node. The correlation of
            two nodes is `exp(-distance / correlation_length)`; 0 makes nodes independent. None: a
            face has one coefficient. The scatter from node to node lowers the limit itself.
        assembled
            Whether to compute the probability from no slip, too, by a steady state for each draw. A
            draw whose transient finds no continuation counts as slip that does not stop.
        draws, seed
            Number of limits of the sample, at least 10, and the seed of its random numbers. A
            smaller probability of failure than `1 / draws` is known from FORM alone.

        Returns
        -------
        ShakedownProbability
            The probability, its method, and the share of each input in the scatter.

        Raises
        ------
        ModelError, SolverError
            Bad input; a limit that is not found.

        Examples
        --------
        >>> import frictopt as fo
        >>> from scipy.stats import lognorm, norm
        >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
        >>> cycle = fo.LoadCycle({"P": 2.0}, [{"Q": -0.4}, {"Q": 0.4}])
        >>> limit = fo.shakedown_limit(node, cycle, friction=0.3)
        >>> laws = {"friction": lognorm(0.2, scale=0.3), "preload": {"P": norm(2, 0.2)}}
        >>> random = limit.probability(**laws, draws=50)
        >>> round(random.form, 3), {name: round(x, 2) for name, x in random.importance.items()}
        (0.964, {'friction': 0.77, 'P': 0.23})
        """

        def ask(cycle: LoadCycle, friction: Array) -> ShakedownLimit:
            return shakedown_limit(self.system, cycle, friction, open_nodes=self.open)

        def stops_as_assembled(drawn: ShakedownAnswer, factor: float) -> bool:
            from ..transients.steady import steady_state  # imported here, because numba is slow

            try:
                steady = steady_state(self.system, drawn.cycle, drawn.friction, factor)
            except NoContinuation:
                return False
            return steady.outcome is Outcome.SHAKEDOWN

        stops = stops_as_assembled if flag("assembled", assembled) else None
        random = RandomLimit(self, ask, friction, preload, load, correlation_length)
        return probability_of(random, stops, draws, seed)

    def to_frame(self) -> Table:
        """A row for each node: node, its place, its safe slip at the limit, traction_ratio.

        traction_ratio is the largest `|q| / (f p)` over the corners at which the node is pressed.
        """
        ratio = self.traction_ratios
        if np.isfinite(self.load_factor):
            largest = np.where(np.isnan(ratio), 0.0, ratio).max(axis=0)
        else:
            largest = ratio[0]
        return super().to_frame().assign(traction_ratio=largest)

    def _answer(self) -> Mapping[str, object]:
        names = ["load_factor", "least", "kind", "bound", "largest_slip", "residual", "reason"]
        if self.objective is not None:
            names.insert(3, "objective")
        return {name: getattr(self, name) for name in names}

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        value = self.load_factor if self.objective is None else self.objective
        return "shakedown limit", value, self.mechanism, self.reason
