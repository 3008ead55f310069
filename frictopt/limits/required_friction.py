"""The least friction with which a load factor is safe.

The safe slips of the load factor are kept as a function of friction (`SafeByFriction`).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import (
    RESIDUAL,
    Bar,
    Booleans,
    PerNode,
    SolveRecord,
    Table,
    distribution,
    finite_number,
    flag,
    frame,
    number_of,
    progress_bar,
    warns_of_odd_values,
    worst,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, ModelWarning, SolverError
from .answers.answered import Answered
from .answers.reasons import where, within_bound
from .answers.sentences import (
    ENOUGH_WITH_EVENTS,
    LESS_IS_NOT_SAFE,
    LOADS_OPEN,
    NONE_IS_ENOUGH,
    NONE_NEEDED,
    NONE_STOPS_IT,
    NOT_FROM_EVERY_START,
    REQUIRED_BETWEEN,
    STOPPED_WIDE,
)
from .between.cones import (
    check_known,
    check_options,
    cones_of,
    record_of,
    slip_of,
    without_gap,
)
from .between.search import TRIED, FrictionBracket
from .events.lift_off import LiftOff, Order, has_static_shear
from .moving.moving_areas import uncoupled
from .program.assembled import most_pressed
from .program.question import Question, pose, with_friction, with_open
from .program.solution import Judged, Solution, Solved, solve
from .rest_intervals import moving_areas_at
from .safe_slip import SafeSlip, checked_load_factor, safe_slip_of_question, safe_slip_of_set

if TYPE_CHECKING:
    import cvxpy as cp


# One file because a reader follows the question to its answer here.


class SafeByFriction:
    """The safe slips of one load factor for any friction and open nodes, each computed once.

    The progress bar counts the programs. An interrupt keeps the frictions tried.
    """

    def __init__(self, question: Question, load_factor: float, events: bool, bar: Bar) -> None:
        self.question = question
        self.load_factor = load_factor
        # The areas are the same for every friction above 0.
        self.areas = moving_areas_at(question, load_factor)
        self._bar = bar
        self._events = events
        self._solved: dict[tuple[float, bytes, bool], SafeSlip] = {}

    def at(
        self, friction: float, open_nodes: Booleans | None = None, events: bool = True
    ) -> SafeSlip:
        """The safe slip with the largest margin.

        `open_nodes=None`: the open nodes are searched until a slip is safe. If the user passes
        `events`, `events=True` also searches the orders in which nodes open and close. If loads
        alone open and close nodes (`areas`), `open_nodes` is ignored.
        """
        if self.areas is not None:
            open_nodes = None
        events = events and self._events
        key = friction, b"" if open_nodes is None else open_nodes.tobytes(), events
        if key not in self._solved:
            self._bar.update()
            safe = self._solve(with_friction(self.question, friction), open_nodes, events)
            self._solved[key] = safe
            # A search ends with the program of the open nodes that it finds.
            self._solved.setdefault((friction, safe.open.tobytes(), False), safe)
            less, more = self.bracket()
            best = f"between {less:.4g} and {more:.4g} so far"
            note = f"{best}; the frictions tried are in the attribute `table`"
            self._bar.keep("table", self._table, note, best)
        return self._solved[key]

    def _solve(self, question: Question, open_nodes: Booleans | None, events: bool) -> SafeSlip:
        if open_nodes is not None:
            opened = with_open(question, open_nodes)
            assert opened is not None  # it has a limit
            return safe_slip_of_set(opened, self.load_factor)
        return safe_slip_of_question(
            question, self.load_factor, events=events, enough=self.load_factor
        )

    def exists(
        self, friction: float, open_nodes: Booleans | None = None, events: bool = True
    ) -> bool | None:
        """Whether a safe slip exists: True and False are proven; None if there is no proof."""
        try:
            return self.at(friction, open_nodes, events).exists
        except SolverError:
            return None

    def bracket(self) -> tuple[float, float]:
        """The largest friction proven too little, and the smallest one proven enough."""
        tried = [(friction, safe.exists) for (friction, *_), safe in self._solved.items()]
        enough = min((friction for friction, exists in tried if exists), default=np.inf)
        too_little = (f for f, exists in tried if f < enough and not exists)
        return max(too_little, default=0.0), enough

    def largest_slip(self, friction: float) -> float:
        """Size of the first safe slip that was found with a friction."""
        slips = (safe for (f, *_), safe in self._solved.items() if f == friction and safe.exists)
        return next(slips).largest_slip

    def _table(self) -> Table:
        """The frictions tried so far."""
        rows = {(f, safe.exists, safe.margin) for (f, *_), safe in self._solved.items()}
        return frame(sorted(rows), names=["friction", "safe", "margin"])


_NEXT_TO_ZERO = (
    "required friction: {smallest:.0e} is enough and 0 is not; a shear load of this size does not "
    "matter, so use 0"
)
_UNDECIDED = (
    "required friction: no slip is safe with {less:g}, a slip of up to {slip:.3g} is safe with "
    "{more:g}, and rounding hides the least friction between the two; give a {smaller}slip_bound "
    "if assembly cannot leave such a slip; otherwise reactions may differ too much in size"
)


# Constants of the search for the least friction.

_SMALLEST = 1e-6  # the smallest friction that linear programs distinguish from 0
# Relative distances from the root at which the two frictions of a proof are tried: the first, and
# the largest. Nodes with little pressure need a larger distance, because the margin depends little
# on them.
_PROOF = 100 * RESIDUAL
_WIDEST_PROOF = 1e4 * RESIDUAL
_MOST_PLACES = 4  # places of nodes that a reason names


@dataclass(frozen=True, eq=False, repr=False)
class RequiredFriction(Answered):
    """The least friction with which a load factor is safe, with its proof from both sides.

    Attributes
    ----------
    required
        Coefficient of friction with which `slip` is safe; 0 if no friction is needed, inf if no
        friction is enough.
    bound
        Coefficient of friction with which no slip is safe, with all nodes closed or with the open
        nodes of `required`. Its relative distance from `required` is below 1e-5, or at most `gap`
        if this is given. NaN if no friction is needed. If nodes open and close in each cycle
        (`events`), other states may need less friction.
    slip
        (N,) or (N, 2) a residual slip that is safe with `required`, length; NaN if no friction is
        enough. See `largest_slip`.
    mechanism
        The proof (Farkas's lemma) that `bound` is not enough, or that no friction is enough. It
        consists of motions on which the loads do more work than friction can dissipate, while the
        forces of a residual slip do no work. Columns are as in `ShakedownLimit.mechanism`; a node
        with direction 0 opens.
    load_factor, reason
        The given load factor, and an explanation of the answer in words.
    record
        Solver, attempts and time. Its `residual`, at most 1e-9, is the larger residual of the two
        proofs.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> cycle = fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}])
    >>> fo.required_friction(node, cycle, 1.0).mechanism["direction"].tolist()
    [1, -1]
    """

    _shown_names = ("required", "bound", "largest_slip", "residual", "reason")
    required: float
    bound: float
    mechanism: Table
    reason: str
    _solved: Solved | None = None

    @cached_property
    def problem(self) -> cp.Problem:
        """The cvxpy problem of `safe_slip` with `required`, with its values.

        Its value is the margin, which is above 0 by rounding alone. With `bound` as the friction
        `f`, the margin is below 0. ModelError if no friction is enough.
        """
        if self._solved is None:
            raise ModelError(
                "problem: this answer has none; ask for a load factor for which some friction is "
                "enough, with gap=None"
            )
        # Imported here, because cvxpy is slow to import, and answers do not need it.
        from .printed.listing import problem_of

        return problem_of(self._solved)

    def probability(self, friction: Any) -> float:
        """Probability that some residual slip is safe at the load factor, exactly.

        It is the probability that the friction is above `required`: with more friction some slip is
        safe, and with less none is, for the node states of the answer. With a `gap` some slip may
        be safe with a little less friction, so that the result is a lower bound.

        Parameters
        ----------
        friction
            Coefficient of friction of all nodes, as a frozen distribution of `scipy.stats`, such as
            `norm(0.3, 0.03)` or `lognorm(0.1, scale=0.3)`.

        Raises
        ------
        ModelError
            Not a frozen distribution of one number.

        Examples
        --------
        >>> import frictopt as fo
        >>> from scipy.stats import uniform
        >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(4, EA=1.0, h=1.0))
        >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
        >>> required = fo.required_friction(rod, cycle, load_factor=1.0)  # 1
        >>> round(required.probability(uniform(0.8, 0.4)), 4)  # from 0.8 to 1.2
        0.5
        """
        return float(distribution("friction", friction).sf(self.required))

    @property
    def _has_safe_slip(self) -> bool:
        return bool(np.isfinite(self.required))

    def check_kept(self) -> None:
        """Check the slip and the frictions of an answer from a file; ValueError if one is wrong."""
        super().check_kept()
        if not (self._question.friction == self.required).all():
            raise ValueError(f"it requires the friction {self.required:g}, its slip another one")
        # Unless a gap is given, both frictions are close to the least one, as far as a proof needs.
        exact = self._solved is not None or np.isinf(self.required)
        nearest = (1 - 3 * _WIDEST_PROOF) * self.required if exact else 0.0
        if not (nearest <= self.bound <= self.required or self.required == 0):
            raise ValueError(f"it requires {self.required:g}, and {self.bound:g} is not enough")


@warns_of_odd_values
def required_friction(
    system: ContactSystem,
    cycle: LoadCycle,
    load_factor: float,
    *,
    events: bool = False,
    slip_bound: PerNode | None = None,
    gap: float | None = None,
    progress: bool = True,
) -> RequiredFriction:
    """Least uniform friction with a safe slip; whether slip stops may depend on the start.

    With this friction or more, the load factor is at most the shakedown limit. Between the
    guaranteed limit and the shakedown limit, slip stops from some starts and goes on from other
    starts; `limit_after_protocol` shows whether it stops after one assembly.

    A slip that is safe with friction f (f = 0 included) presses every node at every corner. It
    stays safe with more friction, because the bounds f p grow. So there is one coefficient above
    which some slip is safe and below which no slip is safe: the friction at which the margin of
    `safe_slip` is zero. This coefficient is finite if some slip presses every node at every corner.
    Otherwise no friction is enough.

    A larger load may need less friction, if the mean load is not safe and the cyclic loads press
    the contact. The load factors that are safe with one friction form an interval, see
    `ShakedownLimit.least`.

    If nodes stay open, the search of `shakedown_limit` finds a set of open nodes, and the result is
    the least friction for this set. If the search finds another set with slightly less friction,
    the same is done for that set. Just above the answer, some slip is proven safe with the open
    nodes of the answer. Just below it, no slip is safe with these open nodes, or with the open
    nodes that the search finds there. Theory, eq. (16). Ctrl-C raises KeyboardInterrupt with an
    attribute `table`, the frictions tried so far.

    Parameters
    ----------
    system, cycle, slip_bound
        See `ShakedownModel`. Without a `slip_bound`, wedged faces may need far more slip than
        assembly can leave. With a `gap` the system may also be a `ContactProducts`.
    load_factor
        Load factor, >= 0.
    events
        See `shakedown_limit`. The answer without events is checked by a search just below it; each
        friction that needs events has a search of its own. True is not needed if slip changes no
        pressure (B = 0): then loads alone open and close nodes.
    gap
        Relative distance that `RequiredFriction.required` and `RequiredFriction.bound` may have,
        above 0 and below 1, such as 0.01; None: below 1e-5. With a gap, all nodes stay closed, and
        `events` and `slip_bound` are refused. The method of `shakedown_limit` proves, for some ten
        frictions, that a slip is safe or that none is. If the two frictions remain farther apart, a
        `ModelWarning` and the reason say so.
    progress
        Whether to show the progress after two seconds, see `shakedown_limit`.

    Returns
    -------
    RequiredFriction
        The coefficient, and the slip that is safe with it.

    Raises
    ------
    ModelError, SolverError
        Bad input; the two bounds of the friction differ by more than a relative 1e-5, or rounding
        hides whether any friction is enough.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> cycle = fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}])

    A slip of 1 leaves a shear of 2 at both corners, and the pressure is 2:

    >>> required = fo.required_friction(node, cycle, 1.0)
    >>> round(required.required, 5), required.bound < required.required
    (1.0, True)
    >>> close = fo.required_friction(node, cycle, 1.0, gap=0.01)
    >>> 0.99 <= close.bound <= 1.0 <= close.required <= 1.01
    True
    """
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    question = pose(system, cycle, 1.0, slip_bound=slip_bound)
    with_events = flag("events", events)
    if gap is not None:
        given = {"events": with_events, "slip_bound": slip_bound is not None}
        check_options(given, without_gap(system))
        gap = finite_number("gap", gap, above=0, below=1)
        with progress_bar(progress, "required friction"):
            return _within(question, checked_load_factor(question, load_factor), gap)
    with progress_bar(progress, "required friction", "program") as bar:
        safe_slips = SafeByFriction(question, load_factor, with_events, bar)

        # A slip can remove the shear at all corners only if the shear is the same at all corners.
        if has_static_shear(safe_slips.question, load_factor) and safe_slips.exists(0.0):
            return _none_needed(safe_slips)

        if safe_slips.areas is not None and safe_slips.areas.slipping_at(load_factor) is not None:
            return _slips_at_any(safe_slips)
        # Events are searched if no friction is enough without them.
        enough = next(
            (
                friction
                for searched in (False, True)
                for friction in TRIED
                if safe_slips.exists(friction, events=searched)
            ),
            None,
        )
        if enough is None:
            return _none_is_enough(safe_slips)

        root, open_nodes = _least_friction(safe_slips, enough)
        if root >= _SMALLEST:
            return _proven_from_both_sides(safe_slips, root, open_nodes)
        if not safe_slips.exists(0.0):
            raise SolverError(_NEXT_TO_ZERO.format(smallest=_SMALLEST))
        return _none_needed(safe_slips)


def _least_friction(safe_slips: SafeByFriction, enough: float) -> tuple[float, Booleans | None]:
    """Root of the margin as a function of friction, and the open nodes there.

    The margin grows with friction while the set of open nodes stays the same. Less friction may be
    enough with another set: if a search just below the root finds one, its root is computed. The
    open nodes are None if they open and close in each cycle: each friction has its own order.
    """
    while True:
        safe = safe_slips.at(enough)
        open_nodes = safe.open if safe.events.empty else None
        root = _root_of_margin(safe_slips, enough, open_nodes)
        just_below = root * (1 - _PROOF)
        if root < _SMALLEST or not safe_slips.exists(just_below):
            return root, open_nodes
        if _open_nodes_of(safe_slips.at(just_below)) == _open_nodes_of(safe_slips.at(enough)):
            return root, open_nodes
        enough = just_below


def _open_nodes_of(safe: SafeSlip) -> tuple[bytes, Order | None]:
    """The open nodes, and the order in which nodes open and close in each cycle."""
    question = safe._question
    order = question.order if isinstance(question, LiftOff) else None
    return safe.open.tobytes(), order


def _root_of_margin(
    safe_slips: SafeByFriction, enough: float, open_nodes: Booleans | None
) -> float:
    """Root of the margin with given open nodes; a value below `_SMALLEST` if there is none.

    Newton's method is used: the multipliers give the rate of the margin with friction. If a step
    leaves the bracket, or is longer than half of the step before, bisection replaces it.
    """
    low, high = 0.0, enough
    friction = enough
    last_step = np.inf
    safe = safe_slips.at(enough, open_nodes)
    while friction >= _SMALLEST:
        if safe.margin >= 0:
            high = friction
        else:
            low = friction
        rate = safe.friction_rate
        # Where nodes open and close, the margin may be 0 for many frictions, and its rate rounding.
        step = -safe.margin / rate if rate * friction > RESIDUAL else np.inf
        if abs(step) <= RESIDUAL * friction or high - low <= _PROOF * friction:
            break
        inside = max(low, _SMALLEST) < friction + step < high
        if not inside or abs(step) >= last_step / 2:
            step = (low + high) / 2 - friction
        friction += step
        last_step = abs(step)
        try:
            safe = safe_slips.at(friction, open_nodes)
        # The checks may refuse all answers close to the root. This also happens close to a critical
        # friction, above which slips of any size are safe. The proof that follows decides.
        except SolverError:
            break
    return friction


def _proven_from_both_sides(
    safe_slips: SafeByFriction, root: float, open_nodes: Booleans | None
) -> RequiredFriction:
    """The answer, proven: a slip is safe just above the root, and no slip is safe just below it.

    Just below, no slip is safe with the open nodes of the answer, or with the open nodes that a
    search finds there. If a proof fails, a larger distance from the root is tried.
    """
    width = _PROOF
    while width <= _WIDEST_PROOF:
        above = root * (1 + width)
        below = root * (1 - width)
        if (
            safe_slips.exists(above, open_nodes) is True
            and safe_slips.exists(below) is False
            and safe_slips.exists(below, open_nodes) is False
        ):
            enough = safe_slips.at(above, open_nodes)
            too_little = safe_slips.at(below, open_nodes)
            mechanism = too_little._mechanism
            reason = _reason(safe_slips, enough, too_little)
            return _answer(safe_slips, above, below, enough, mechanism, reason, too_little.record)
        width *= 4

    less, more = safe_slips.bracket()
    slip = safe_slips.largest_slip(more)
    smaller = "" if safe_slips.question.slip_bound is None else "smaller "
    raise SolverError(_UNDECIDED.format(less=less, more=more, slip=slip, smaller=smaller))


def _reason(safe_slips: SafeByFriction, enough: SafeSlip, too_little: SafeSlip) -> str:
    """Why no less friction is enough, and what this does not cover."""
    opened = int(too_little.open.sum())
    node_states = "all nodes closed"
    if safe_slips.areas is not None:
        node_states = "for all openings and closings"
    elif opened:
        node_states = f"{number_of(opened, 'node')} open and the others closed"
    reason = LESS_IS_NOT_SAFE.format(
        within=within_bound(safe_slips.question), node_states=node_states
    )
    if safe_slips.areas is None and not enough.events.empty:
        reason += ENOUGH_WITH_EVENTS
    if not uncoupled(enough._question):
        reason += NOT_FROM_EVERY_START
    return reason


def _answer(
    safe_slips: SafeByFriction,
    required: float,
    bound: float,
    enough: SafeSlip,
    mechanism: Table,
    reason: str,
    *others: SolveRecord,
) -> RequiredFriction:
    """The answer with the slip of `enough`; `others` are the records of further programs."""
    return RequiredFriction(
        load_factor=safe_slips.load_factor,
        slip=enough.slip,
        record=enough.record.joined(others, safe_slips.question.started),
        _question=enough._question,
        required=required,
        bound=bound,
        mechanism=mechanism,
        reason=reason,
        _solved=enough._solved,
    )


def _within(question: Question, load_factor: float, gap: float) -> RequiredFriction:
    """The answer between two proven frictions, with all nodes closed."""
    remedy = without_gap(question.system)
    check_known(question, remedy)
    bracket = FrictionBracket(cones_of(question), load_factor / question.load_unit)
    bracket.narrow(gap, _SMALLEST)
    if bracket.enough <= RESIDUAL and has_static_shear(question, load_factor):
        bracket.enough = 0.0
        return _answer_within(question, load_factor, bracket, np.nan, NONE_NEEDED.format(within=""))
    if bracket.enough <= _SMALLEST:
        raise SolverError(_NEXT_TO_ZERO.format(smallest=_SMALLEST))
    enough_is_known = np.isfinite(bracket.enough)
    if bracket.too_little == 0 or not enough_is_known:
        missing = "too little" if enough_is_known else "enough with all nodes closed"
        raise SolverError(
            f"gap: {bracket.steps} steps do not prove that some friction is {missing}; {remedy}"
        )
    stopped = ""
    if not bracket.is_within(gap):
        stopped = STOPPED_WIDE.format(gap=gap, remedy=remedy)
        warnings.warn(f"required_friction: {stopped[2:]}", ModelWarning, stacklevel=4)
    reason = REQUIRED_BETWEEN.format(
        lower=bracket.too_little,
        upper=bracket.enough,
        gap=100 * (1 - bracket.too_little / bracket.enough),
        steps=bracket.steps,
        stopped=stopped,
    )
    return _answer_within(question, load_factor, bracket, bracket.too_little, reason)


def _answer_within(
    question: Question, load_factor: float, bracket: FrictionBracket, bound: float, reason: str
) -> RequiredFriction:
    """The answer of a bracket of frictions, after both proofs have been checked."""
    at_enough = with_friction(question, bracket.enough)
    slip = slip_of(at_enough, bracket.shear)
    motion, error = bracket.proof(with_friction(question, bracket.too_little))
    record = record_of(at_enough, load_factor, slip, error)
    return RequiredFriction(
        load_factor=load_factor,
        slip=slip,
        record=record.joined([], question.started),
        _question=at_enough,
        required=bracket.enough,
        bound=bound,
        mechanism=motion.table(question.system, question.names),
        reason=reason,
    )


def _none_needed(safe_slips: SafeByFriction) -> RequiredFriction:
    """The answer 0, after a slip has been proven safe without friction."""
    safe = safe_slips.at(0.0)
    reason = NONE_NEEDED.format(within=within_bound(safe_slips.question))
    return _answer(safe_slips, 0.0, np.nan, safe, safe._mechanism[:0], reason)


def _slips_at_any(safe_slips: SafeByFriction) -> RequiredFriction:
    """The answer inf, if some node closes and opens under different shear loads."""
    safe = safe_slips.at(TRIED[0])
    reason = NONE_STOPS_IT.format(why=safe.reason)
    return _infinite(safe_slips, safe._question, safe.record, safe._mechanism, reason)


def _none_is_enough(safe_slips: SafeByFriction) -> RequiredFriction:
    """The answer inf, if a mechanism proves that the loads open a node under any slip."""
    question = safe_slips.question
    system = question.system
    load_factor = safe_slips.load_factor
    without = with_friction(question, 0.0)

    def claimed(solution: Solution) -> Judged:
        """The least normal force under the best slip, relative to the mean; and the mechanism."""
        slip = solution.slip_of_nodes
        bound, defect = solution.bound
        _, r = without.states(load_factor, slip)
        reached = float(min(r[:, -1].min() / without.force, 1.0))
        gap = abs(bound - reached) + defect
        residual = worst([gap, without.excess_over_slip_bound(slip)])
        return Judged((reached, solution.motion), residual)

    pressed, record = solve(most_pressed(without, load_factor), claimed)
    least, motion = pressed.said
    # A tension within the error of an answer is no proof.
    if not least < -RESIDUAL:
        raise SolverError(
            f"required friction: none up to {TRIED[-1]:g} is enough, although no node has to open: "
            f"with the best residual slip, the pressure at one node is only {least:.1e} force "
            "scales; press nodes of little pressure, or leave them out"
        )
    mechanism = motion.table(system, question.cycle.corner_names)
    nodes = mechanism["node"].unique()
    why = LOADS_OPEN.format(
        within=within_bound(safe_slips.question), where=where(system, nodes, _MOST_PLACES)
    )
    return _infinite(safe_slips, question, record, mechanism, NONE_IS_ENOUGH.format(why=why))


def _infinite(
    safe_slips: SafeByFriction,
    question: Question,
    record: SolveRecord,
    mechanism: Table,
    reason: str,
) -> RequiredFriction:
    return RequiredFriction(
        load_factor=safe_slips.load_factor,
        slip=np.full(question.system.slip_shape, np.nan),
        record=record.joined([], safe_slips.question.started),
        _question=replace(question, friction=question.friction * np.inf),
        required=np.inf,
        bound=np.inf,
        mechanism=mechanism,
        reason=reason,
    )
