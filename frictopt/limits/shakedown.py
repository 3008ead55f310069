"""The shakedown limit: the largest load factor at which some residual slip is safe.

A slip is safe if every node stays closed, and stuck at every corner of the load cycle. The way from
`shakedown_limit` to its answer goes from top to bottom: pose the question, list its program, solve
it, judge what stands in the program, complete the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    LimitKind,
    SolveRecord,
    bar_of,
    frame,
    warns_of_odd_values,
)
from ..base.checks import flags
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from ..solve.compiled import Proof
from .answered import answered
from .lift_off import LiftOff, Ordered
from .models import least_load, shakedown
from .no_limit import NoLimit, constraint_names, every_load_is_safe, no_limit
from .open_nodes import is_safe_at_mean_load
from .patterns import best_order, best_pattern, check_events
from .programs import Program
from .question import Question, pose, with_open
from .safe_model import SafeModel
from .sentences import CHOSEN, shakedown_reason
from .shakedown_answer import ShakedownAnswer


@warns_of_odd_values
def shakedown_limit(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    *,
    open: ArrayLike | None = None,
    events: bool = False,
    slip_bound: Any = None,
    simplify: bool = True,
    solver: str | None = None,
    progress: bool = True,
) -> ShakedownLimit:
    """Largest load factor at which some residual slip is safe.

    Safe means: every node is closed and stuck at every corner of the cycle, or open all through it
    (`ShakedownLimit.open`), with `events` also open in a part of it. The open nodes are searched
    near the settled mean load. With other nodes open, a contact may rest above the limit. Ctrl-C in
    a search stays a KeyboardInterrupt with an attribute `limit`, the best limit by then. Theory,
    eq. (7); Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    open
        (N,) bool, which nodes stay open, the others closed; None for the search. All False asks for
        the limit with all nodes closed.
    events
        Whether nodes may also open and close in each cycle of a load that goes to and fro between
        two corners (`ShakedownLimit.events`). Their order is searched too, which takes some
        seconds. Not with fixed parts that differ, a slip bound, or constraints.
    slip_bound, simplify, solver
        See `ShakedownModel`.
    progress
        Whether to show after two seconds how far it is, and the best so far: a bar, or a line every
        five seconds where there is no terminal.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> fo.shakedown_limit(rod, cycle, friction=0.5).reason
    'no residual slip is safe above it with all nodes closed'
    """
    with bar_of(progress, "shakedown limit"):
        question = pose(
            system,
            cycle,
            friction,
            simplify=simplify,
            slip_bound=slip_bound,
            question_name="shakedown_limit",
        )
        return ShakedownLimits._on(question, solver).of_pattern(question, open, events)


class ShakedownLimits(SafeModel):
    """The shakedown limits of one system and cycle, for any friction and open nodes."""

    _public_question = "shakedown_limit"

    def of_pattern(
        self,
        question: Question,
        open: Any,
        events: bool,
        user_rows: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
    ) -> ShakedownLimit:
        """The limit with given nodes open, or of the best pattern that a search finds.

        With `events` the pattern may have nodes that open and close in each cycle.
        """
        restricted = bool(user_rows) or objective is not None or open is not None
        check_events(events, question, restricted)
        if open is not None:
            opened = with_open(question, flags("open", open, question.system.nodes))
            if opened is None or opened.open_nodes.all():
                raise ModelError(
                    "open: too few closed nodes, or none, would hold the open ones; "
                    "leave more nodes closed"
                )
            return self.of_set(opened, user_rows, objective)
        limit = self.of_any_set(question, user_rows, objective)
        return self.of_any_order(limit) if events else limit

    def of_any_set(
        self,
        question: Question,
        user_rows: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        at: float = np.inf,
        enough: float = np.inf,
    ) -> ShakedownLimit:
        """The limit with the open nodes of `best_pattern`, which are those without user rows."""
        if user_rows or objective is not None:
            open_nodes = self.of_any_set(question)._question.open_nodes
            return self.of_set(with_open(question, open_nodes) or question, user_rows, objective)
        questions = [question]

        def limit_of(question: Question, above: float) -> ShakedownLimit:
            questions.append(question)
            return self.of_set(question, above=above)

        best = best_pattern(limit_of, self.of_set(question), at, enough)
        if questions[-1] is not best._question:
            # The problem of the answer shall hold the values of the answer.
            return replace(self.of_set(best._question), least=best.least)
        return best

    def of_set(
        self,
        question: Question,
        user_rows: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        above: float = -np.inf,
    ) -> ShakedownLimit:
        """The limit with given open nodes; SolverError once it is proven not to be `above`."""
        chosen = objective is not None
        unit = 1.0 if chosen else question.load_unit
        program = self._program(question, user_rows, objective, _goal, "shakedown", unit)

        def proof() -> NoLimit | None:
            return no_limit(program, _goal(program), chosen)

        limit = self._solved(program, proof, above, chosen)
        if limit.kind is LimitKind.NO_SAFE_SLIP or chosen:
            return limit
        slip = limit.slip if limit.kind is LimitKind.FINITE else None
        if not user_rows and is_safe_at_mean_load(question, slip):
            return replace(limit, least=0.0)
        return self._with_least(limit, program)

    def _solved(
        self,
        program: Program,
        proof_of_none: Callable[[], NoLimit | None],
        above: float,
        chosen: bool = False,
    ) -> ShakedownLimit:
        """The first answer of a solver that passes, with its problem and record."""
        claim, record = program.chain.solve(
            partial(judged, program, chosen, above),
            self._solver,
            no_optimum=lambda: without_limit(proof_of_none()),
            above=above,
        )
        return answered(claim, record, program)

    def of_any_order(self, best: ShakedownLimit, at: float = np.inf) -> ShakedownLimit:
        """The best limit with nodes that open and close in each cycle, see `best_order`.

        `best` is the limit of nodes that stay as they are. The first limit not below `at` ends the
        search.
        """

        def limit_of(question: LiftOff, above: float) -> ShakedownLimit:
            program = Ordered(question, _goal, question.load_unit)
            return self._solved(program, partial(every_load_is_safe, program), above)

        return best_order(limit_of, best, at)

    def _with_least(self, limit: ShakedownLimit, program: Program) -> ShakedownLimit:
        """The limit with the least safe load factor, by a program of its own."""
        started = program.question.started
        try:
            with program.chain.kept():
                downward = replace(program)
                downward.compiled(least_load(program.x, program.rows), program.question.load_unit)
                lower, lower_record = downward.chain.solve(partial(judged, downward), self._solver)
        except SolverError:
            # Rounding hides whether some slip is safe under the mean load. The limit stands, and
            # the least safe load factor is not known.
            return limit
        record = replace(
            limit.record,
            attempts=(*limit.record.attempts, *lower_record.attempts),
            residual=max(limit.residual, lower.residual),
            seconds=perf_counter() - started,
        )
        return replace(limit, least=lower.load_factor, record=record)


def _goal(program: Program) -> cp.Problem:
    return shakedown(program.x, program.rows)


def judged(program: Program, chosen: bool = False, above: float = -np.inf) -> ShakedownLimit:
    """The limit that stands in a program, with its violations and its bound.

    `chosen`: whether an objective of the user chose the load factor. SolverError if the multipliers
    prove that the limit is not `above` a load factor.
    """
    question = program.question
    load_factor = program.load_factor
    slip = program.slip
    proof = program.chain.proof
    bound = upper_bound(proof, above)
    violations = [question.violation(load_factor, slip), proof.gap, program.own_violation]
    residual = float(np.nan_to_num(np.max(violations), nan=np.inf))
    return ShakedownLimit(
        load_factor,
        slip,
        SolveRecord(residual=residual),
        question,
        program.motion,
        LimitKind.FINITE,
        bound,
        objective=proof.value if chosen else None,
        _why=CHOSEN() if chosen else "",
        constraints=constraint_names(program, chosen),
    )


def upper_bound(proof: Proof, above: float = -np.inf) -> float:
    """The bound of a largest load factor that multipliers prove; SolverError if not `above`."""
    bound = proof.bound + proof.defect
    if bound <= above:
        raise SolverError(f"the limit is at most {bound:g}, so not above {above:g}")
    return bound


def without_limit(proof: NoLimit | None) -> ShakedownLimit | None:
    """The answer that there is no largest safe load factor, if that is proven."""
    if proof is None:
        return None
    value = np.inf if proof.kind is LimitKind.UNBOUNDED else np.nan
    return ShakedownLimit(
        value,
        np.full(proof.question.system.slip_shape, np.nan),
        SolveRecord(residual=proof.residual),
        proof.question,
        proof.motion,
        proof.kind,
        value,
        _why=proof.why,
        constraints=proof.constraints,
    )


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(ShakedownAnswer):
    """The shakedown limit with its proof from both sides, for one pattern of `open` nodes.

    The pattern is the best that a local search near the settled mean load finds. With `events` it
    also has nodes that open and close in each cycle. With other nodes open, or in another order, a
    contact may rest above the limit, see `covers`. Theory, eq. (8).

    Attributes
    ----------
    load_factor, kind
        lambda_2, the largest load factor with a safe slip; inf if all have one from some load
        factor on, nan if none has one. `kind` says which.
    least
        The least load factor with a safe slip: 0 for a contact that is safe under its mean load. It
        is above 0 where the mean load alone leaves no safe slip and the corners press; then load
        factors are safe from `least` to `load_factor`, and below `least` the contact slips or opens
        for ever. Proven like the limit, also under a slip bound and constraints of your own; just
        above it others than `open` may be the open nodes. NaN where nothing is safe, where rounding
        hides it (`reason` says so), and with an objective.
    slip
        (N,) or (N, 2) a residual slip that is safe at the limit, length; NaN where `load_factor` is
        not finite. See `largest_slip`. Nodes of `open` have the slip that the mean load gives them.
    bound
        Upper bound of the limit with the same nodes open, not of others, from the mechanism alone,
        or with constraints of your own from all multipliers, theirs too; equals `load_factor` up to
        `residual`.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the violations of the
        contact law by `slip` at the corners, and the relative distance of `bound`; without a finite
        limit, that of the proof; and the same two of `least` where it is above 0.
    constraints
        Names of the constraints of your own, and "objective" for an objective: slip, residual and
        dual bound are those of the program with them.
    objective
        Largest value of an objective of your own; None without. Then `load_factor` is the one that
        it chooses, `bound` is an upper bound of the objective, and `friction_rate` is its rate.
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
    """

    @cached_property
    def reason(self) -> str:
        """Why it is so, in words."""
        return shakedown_reason(self)

    def to_frame(self) -> pd.DataFrame:
        """A row for each node: node, its place, its safe slip at the limit, traction_ratio.

        traction_ratio is the largest `|q| / (f p)` over the corners at which the node carries
        something.
        """
        ratio = self.traction_ratios
        if np.isfinite(self.load_factor):
            largest = np.where(np.isnan(ratio), 0.0, ratio).max(axis=0)
        else:
            largest = ratio[0]
        columns = {**self._places(), "traction_ratio": largest}
        return frame(columns, units=self.system.units)

    def _answer(self) -> Mapping[str, object]:
        names = ["load_factor", "least", "kind", "bound", "largest_slip", "residual", "reason"]
        if self.objective is not None:
            names.insert(3, "objective")
        return {name: getattr(self, name) for name in names}

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        value = self.load_factor if self.objective is None else self.objective
        return "shakedown limit", value, self.mechanism, self.reason
