"""The shakedown limit: the largest load factor at which some residual slip keeps every node closed and stuck at every corner of the load cycle."""
# One file because the answer, the model that asks for it and the judge that makes it name each
# other.

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    GROWN,
    RESIDUAL,
    ROUNDING,
    Array,
    LimitKind,
    SolveRecord,
    bar_of,
    finite_number,
    frame,
    frozen,
    listed,
    warns_of_odd_values,
)
from ..base.checks import flags
from ..contact import ContactSystem, LoadCycle, lengths
from ..contact.diagnosis import growth_diagnosis, in_contact
from ..errors import ModelError, NoContinuation, SolverError
from ..solve.compiled import Proof
from ..transients.statics import unscaled_diagnosis
from .answered import Mechanism, Rated, answered
from .gross_slip import statics_alone
from .least_slip import LeastSlip, least_slip
from .lift_off import LiftOff, Ordered
from .models import least_load, shakedown
from .open_nodes import border, stays_closed
from .patterns import best_order, best_pattern, check_events
from .programs import Program
from .question import Question, with_open
from .safe_model import SafeModel, in_turn

_ALL = 1e-6  # relative distance from the bound of all states up to which the limit is that of all


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(Rated):
    """The shakedown limit with its proof from both sides, for one pattern of nodes that stay closed or `open`, see `covers`.

    The pattern is the best that a local search near the settled mean load finds. Asked with events,
    it also has nodes that open and close in each cycle, see `events`. With others open, or in
    another order, a contact may rest above it. Theory, eq. (8).

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
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> limit = fo.shakedown_limit(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.5)
    >>> limit.kind.name, round(limit.load_factor, 6), round(limit.bound, 6)
    ('FINITE', 0.535714, 0.535714)
    >>> limit.mechanism[["node", "corner", "direction"]].sort_values("corner", ignore_index=True)
       node  corner  direction
    0     0       0          1
    1     0       1         -1
    2     1       1         -1
    """

    kind: LimitKind
    bound: float
    least: float = np.nan
    objective: float | None = None
    _why: str = (
        ""  # there is no largest safe load factor; or a reason that stands for the usual one
    )

    @cached_property
    def reason(self) -> str:
        """Why it is so, in words."""
        question, least, growth = self._question, self.least, self.kind is LimitKind.UNBOUNDED
        if self._why and not growth:
            return self._opened + self._why + self._border
        within, more = (
            ("", "")
            if question.slip_bound is None
            else (" within the slip bound", "a larger slip_bound may leave one; ")
        )
        slip, start, below = f"residual slip{within}", "", ""
        slip += f" that obeys {', '.join(self.constraints)}" * bool(self.constraints)
        if not self.load_factor > 0 or (least > 0 and not self.constraints):
            more += unscaled_diagnosis(question.system, question.cycle, question.friction)
        if not self.load_factor > 0:
            node, above = self._ruling, " above 0" * (self.kind is LimitKind.FINITE)
            where = in_contact(question.system, node)
            sheared, single = (
                self._motion.size[:, node].max() > ROUNDING * np.abs(self._motion.moves).max(),
                set(self.mechanism["node"]) == {node},
            )
            if above and question.friction[node] == 0 and sheared:
                more = f"node {node}{where} has no friction, and the cyclic load shears it"
            elif (
                above
                and single
                and np.abs(question.r0[:, -1, node]).max() <= ROUNDING * question.force
            ):
                more = f"node {node}{where} carries no pressure under the mean load, and the cyclic load {'shears' if sheared else 'lifts'} it"
            return f"{self._opened}no {slip} is safe at any load factor{above}{question.pattern}: {more}{self._border}"
        if least > 0:
            alone = f"{question.pattern[1:]} " * growth  # else it is said with the limit
            start, below = (
                f" from {least:.6g} on",
                f"; {alone}none is safe below {least:.6g}"
                + ("" if self.constraints else f": {more}"),
            )
        if np.isnan(least):
            start = " from some on"
            below = "; rounding hides from where on: take friction further from its critical value, or loads of like size"
        if growth:
            why = f"; {self._why}" if self._why else ""
            return f"{self._opened}the shakedown limit is infinite: every load factor{start} has a safe {slip}{why}{below}"
        rest = "; with others open it may be higher" * bool(
            self.open.any()
        ) + "; the dual bound covers them" * bool(self.constraints)
        if self._question.static and not self.constraints:
            rest += "; under this static load it may open nodes and rest above it, up to where a body slides off (bound_for_all)"
        return (
            f"{self._opened}no {slip} is safe above it{question.pattern}{rest}{below}{self._border}"
        )

    @property
    def covers(self) -> str:
        """What `bound` is a bound of, in words."""
        if self._question.events:
            return f"states of rest{self._question.pattern}; with others, or in another order, the contact may rest above it"
        opened = int(self.open.sum())
        states = (
            f"these {opened} nodes open and the others closed" if opened else "all nodes closed"
        )
        return f"states of rest with {states} all through the cycle; with others open, or nodes that open and close, the contact may rest above it"

    @cached_property
    def bound_for_all(self) -> float:
        """Load factor above which no state of rest exists, from no start, whatever opens: `bound` of `gross_slip`; 0 where the mean load slides off.

        Inf where supports hold the bodies: then nothing bounds the states that `covers` leaves out.
        SolverError if no solver's answer passes.
        """
        most = statics_alone(self.system, self.cycle, self.friction)
        return 0.0 if np.isnan(most) else most

    @property
    def proven(self) -> bool:
        """Whether no state of rest at all exists above the limit: `bound_for_all` is not above it by more than 1e-6 of it."""
        return bool(self.bound_for_all <= self.load_factor * (1 + _ALL))

    def stays_closed(self, load_factor: float) -> bool:
        """Whether it is proven that no start with all nodes closed opens one, at any load of the cycle up to a load factor, whatever slips.

        Then no such start comes to rest between the limit with all nodes closed and this load
        factor. A contact's path is continuous, and no slip that obeys `|q| <= f p` leaves a node
        without pressure: one convex program for each node (theory, "What is proven for which
        states"). False where nothing is proven: a node may open, or only rounding speaks against
        it; with nodes that stay open, and where fixed parts of the cycle differ. ModelError for a
        bad load factor.

        Examples
        --------
        >>> import frictopt as fo
        >>> system = fo.scenes.PunchOnHalfPlane(elements=12).condense()
        >>> limit = fo.shakedown_limit(system, fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}]), friction=0.3)
        >>> limit.stays_closed(2 * limit.load_factor)
        True
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        return not (self.open.any() or self._question.fixed) and stays_closed(
            self._question, load_factor
        )

    @cached_property
    def apart(self) -> float:
        """Largest distance of the slip from the one that the mean load leaves, from no slip, length; NaN where the limit is not finite.

        Where it is far larger than what assembly can leave, plain starts do not lead to the state
        of rest: it needs `slip` itself. NoContinuation or SolverError if the mean load comes to no
        state.
        """
        from ..transients.march import mean_state  # here, because a closed contact needs none

        settled = mean_state(self.system, self.cycle, self.friction).slip
        return float(lengths(np.reshape(settled, self.slip.shape) - self.slip, self.friction).max())

    @property
    def _ruling(self) -> int:
        """The node that moves most in the mechanism."""
        motion = self._motion
        return int(
            np.where(
                self._question.open_nodes if motion.open is None else motion.open,
                0.0,
                motion.size + motion.opening,
            )
            .sum(axis=0)
            .argmax()
        )

    @property
    def _border(self) -> str:
        """Words on the node that governs: the mesh beside open nodes, see `border`, or that it would be pulled open without slip."""
        question, node = self._question, self._ruling
        if self.kind is not LimitKind.FINITE:
            return ""
        if question.compliance is not None:
            return border(question.system, question.open_nodes, node, self.reactions[1])
        pulled = self._rated and question.r0[:, -1, node].max() < 0
        return (
            f"; residual slip alone presses node {node}{in_contact(question.system, node)}, which governs"
            if pulled
            else ""
        )

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load, largest share of the slip first: one of several proofs, as of a symmetric contact.

        Columns node, x, corner, its loads, direction (+1 slips along +x, -1 against it; in space
        slip1 and slip2), share.
        """
        return self._motion.table(self.system, self._question.names)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its
        supergradients. NaN without a finite limit.
        """
        return frozen(self._by_friction)

    def least_slip(self, load_factor: float) -> LeastSlip:
        """Proven lower bound of slip and gaps in every cycle at a load factor, from every start; it is positive above the limit.

        With open nodes it holds for cycles in which these carry nothing.

        Raises
        ------
        ModelError, SolverError
            Bad load factor; a limit that is not finite, with events, under a slip bound, or under
            constraints of your own, which proves nothing of other slips; multipliers that do not
            balance to the tolerance.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        if self._question.events:
            raise ModelError(
                "least_slip: nodes open and close at the limit, whose multipliers bound no slip; ask shakedown_limit without events"
            )
        if (
            not np.isfinite(self.load_factor)
            or self.constraints
            or self._question.slip_bound is not None
        ):
            asked = f"load factor {self.load_factor:g}" + (
                " under constraints on the slip" if np.isfinite(self.load_factor) else ""
            )
            raise ModelError(
                f"least_slip: the limit ({asked}) bounds no slip from below; ask a finite limit without slip bound and constraints"
            )
        return least_slip(self._question, self._motion, self.bound, load_factor, self.residual)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its safe slip at the limit, largest `|q| / (f p)` over the corners where it carries something."""
        ratio = self.traction_ratios
        ratio = (
            np.where(np.isnan(ratio), 0.0, ratio).max(axis=0)
            if np.isfinite(self.load_factor)
            else ratio[0]
        )
        return frame({**self._places(), "traction_ratio": ratio}, units=self.system.units)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        return {
            name: getattr(self, name)
            for name in (
                "load_factor",
                "least",
                "kind",
                *chosen,
                "bound",
                "largest_slip",
                "residual",
                "reason",
            )
        }

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return (
            "shakedown limit",
            self.load_factor if self.objective is None else self.objective,
            self.mechanism,
            self.reason,
        )


def upper_bound(proof: Proof, above: float = -np.inf) -> float:
    """The bound of a largest load factor that multipliers prove, with their defect; SolverError if it is not `above` a load factor."""
    bound = proof.bound + proof.defect
    if bound <= above:
        raise SolverError(f"the limit is at most {bound:g}, so not above {above:g}")
    return bound


class ShakedownModel(SafeModel):
    """The shakedown limit of one system under one load cycle for any friction; its program is compiled once. Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `|v|` that assembly can leave, one or one per node, length; None for no bound.
        A slide of the whole body counts: where nothing resists one, the program chooses it.
    simplify
        Leave out what cannot change the answer: corners within the hull of the others, and in the
        plane rows that others stand for.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM" (in space "CLARABEL_DIRECT", "CLARABEL",
        "INTERIOR_POINT", which for large contacts comes first); by default each in this order until
        an answer passes.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> model = fo.ShakedownModel(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]))
    >>> model.sweep([0.3, 0.5])["load_factor"].round(6).tolist()
    [0.313636, 0.535714]
    >>> round(model.solve(0.5, constraints=[model.slip[0] >= 0.1]).load_factor, 6)
    0.502381
    """

    _strong = True

    @warns_of_odd_values
    @in_turn
    def solve(
        self,
        friction: Any,
        constraints: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        *,
        open: ArrayLike | None = None,
        events: bool = False,
        progress: bool = True,
    ) -> ShakedownLimit:
        """The limit for a coefficient of friction, one or one per node, under constraints of your own, or the slip that your objective chooses.

        Parameters
        ----------
        friction, open, events, progress
            See `shakedown_limit`.
        constraints
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units,
            and on variables of your own. They are linear, or of abs, max, norms and the like: the
            multipliers of rows and second-order cones prove the limit. `bound` and `residual` cover
            them. The nodes that stay open are those of the limit without them: q and p are 0 there,
            and the slip is that under the mean load.
        objective
            What shall be largest over the safe slips, instead of the load factor: a concave cvxpy
            expression on the same, of the same forms, such as `model.load_factor - 0.1 *
            cp.norm1(model.slip)`. See `ShakedownLimit.objective`.

        Raises
        ------
        ModelError, SolverError
            Bad friction; open nodes that the others do not hold; constraints that are not convex,
            need other cones, or are on another model; such an objective, or one without a largest
            value; no solver gave an answer that passes the checks.
        """
        own = listed("constraints", constraints)
        with bar_of(progress, "shakedown limit"):
            return self._shown(self.of_pattern(self._posed(friction), open, events, own, objective))

    def of_pattern(
        self,
        question: Question,
        open: Any,
        events: bool,
        own: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
    ) -> ShakedownLimit:
        """The limit with given nodes open; or of the best pattern that is found, maybe with nodes that open and close in each cycle."""
        check_events(events, question, bool(own) or objective is not None or open is not None)
        if open is not None:
            rest = with_open(question, flags("open", open, len(question.open_nodes)))
            if rest is None or rest.open_nodes.all():
                raise ModelError(
                    "open: too few closed nodes, or none, would hold the open ones; leave more nodes closed"
                )
            return self.of_set(rest, own, objective)
        limit = self.of_any_set(question, own, objective)
        return self.of_any_order(limit) if events else limit

    def of_any_order(self, best: ShakedownLimit, at: float = np.inf) -> ShakedownLimit:
        """The best limit with nodes that open and close in each cycle, see `best_order`, from one of nodes that stay as they are."""

        def of_order(asked: LiftOff, above: float) -> ShakedownLimit:
            program = Ordered(asked, lambda each: shakedown(each.x, each.rows), asked.load_unit)
            claim, record = program.chain.solve(
                partial(judged, program, above=above),
                self._solver,
                no_optimum=partial(every_load_is_safe, program),
                above=above,
            )
            return answered(claim, record, program)

        limit: ShakedownLimit = best_order(best, of_order, at)
        return limit

    def of_any_set(
        self,
        question: Question,
        own: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        at: float = np.inf,
        enough: float = np.inf,
    ) -> ShakedownLimit:
        """The limit of the best pattern of open nodes that the search finds, see `best_pattern`; with all closed where none wants to open."""
        if own or objective is not None:  # which change no pattern
            return self.of_set(
                with_open(question, self.of_any_set(question).open) or question, own, objective
            )
        tried = list[Question]()

        def counted(asked: Question, above: float) -> ShakedownLimit:
            tried.append(asked)
            return self.of_set(asked, above=above)

        best: ShakedownLimit = best_pattern(counted, self.of_set(question), at, enough)
        if tried and tried[-1] is not best._question:  # its answer shall stand in its problem
            return replace(self.of_set(best._question), least=best.least)
        return best

    def of_set(
        self,
        question: Question,
        own: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        above: float = -np.inf,
    ) -> ShakedownLimit:
        """The limit with given nodes open; a SolverError once it is proven not to be `above` a load factor."""
        unit = question.load_unit if objective is None else 1.0
        program = self._program(
            question, own, objective, lambda each: shakedown(each.x, each.rows), "shakedown", unit
        )
        claimed = partial(judged, program, objective is not None, above=above)
        claim, record = program.chain.solve(
            claimed,
            self._solver,
            no_optimum=lambda: without_limit(program, objective is not None),
            above=above,
        )
        limit = answered(claim, record, program)
        if limit.kind is LimitKind.NO_SAFE_SLIP or objective is not None:
            return limit
        slips = () if own else _likely_slips(limit)
        at_zero = any(question.violation(0.0, slip) <= RESIDUAL for slip in slips)
        return replace(limit, least=0.0) if at_zero else self._with_least(limit, program)

    def _with_least(self, limit: ShakedownLimit, program: Program) -> ShakedownLimit:
        """The limit with the least safe load factor, by a program of its own; nan where no solver gives one that passes the checks."""
        try:
            with program.chain.kept():
                downward = replace(program).compiled(
                    least_load(program.x, program.rows), program.question.load_unit
                )
                lower, found = downward.chain.solve(lambda: judged(downward), self._solver)
        # rounding hides whether some slip is safe under the mean load: the limit stands, the least
        # one is not known
        except SolverError:
            return limit
        attempts, seconds = (
            (*limit.record.attempts, *found.attempts),
            perf_counter() - program.question.started,
        )
        record = replace(
            limit.record,
            attempts=attempts,
            residual=max(limit.residual, lower.residual),
            seconds=seconds,
        )
        return replace(limit, least=lower.load_factor, record=record)

    @warns_of_odd_values
    def sweep(
        self, frictions: Any, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True
    ) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each, under constraints of your own as in `solve`.

        Columns: friction (mean), load_factor, least, bound, residual, friction_rate, node and sense
        of the mechanism's largest share, solver. Raises what `solve` does; ModelError if not a
        sequence. Ctrl-C stays a KeyboardInterrupt with an attribute `table`, that of the limits by
        then.
        """
        own, wanted, rows = (
            listed("constraints", constraints),
            listed("frictions", frictions),
            list[dict[str, Any]](),
        )

        def kept(_: object) -> tuple[str, object, str] | None:
            said = (
                f"the limits of {len(rows)} of {len(wanted)} frictions are in the attribute `table`"
            )
            return ("table", pd.DataFrame(rows), said) if rows else None

        with bar_of(progress, "sweep", "friction", total=len(wanted), keeps=kept) as bar:
            for friction in wanted:
                rows.append(_row(friction, self.solve(friction, own)))
                bar.update()
        return pd.DataFrame(rows)


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
    """Largest load factor at which some residual slip is safe (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

    Safe means: every node closed and stuck at every corner of the cycle, or open all through it
    (`ShakedownLimit.open`), with `events` also open in a part of it. Which ones is searched near
    the settled mean load. With others, a contact may rest above it. Theory, eq. (7). Ctrl-C in a
    search stays a KeyboardInterrupt with an attribute `limit`, the best limit by then.

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
    >>> fo.shakedown_limit(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), friction=0.5).reason
    'no residual slip is safe above it with all nodes closed'
    """
    with bar_of(progress, "shakedown limit"):
        model = ShakedownModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        return model.of_pattern(model._posed(friction), open, events)


def _likely_slips(limit: ShakedownLimit) -> Iterator[Array]:
    """Slips that may well be safe under the mean load: none, that of the limit, and what the mean load itself leaves, coming at once."""
    yield np.zeros(limit.system.slip_shape)
    if limit.kind is LimitKind.FINITE:
        yield limit.slip
    from ..transients.march import mean_state  # here, because mostly one of these is safe

    with suppress(ModelError, NoContinuation, SolverError):
        yield mean_state(limit.system, limit.cycle, limit.friction, steps=1).slip


def _row(friction: Any, limit: ShakedownLimit) -> dict[str, Any]:
    first, senses = (
        limit.mechanism.iloc[0] if len(limit.mechanism) else None,
        ("direction",) if limit.system.tangents == 1 else ("slip1", "slip2"),
    )
    none = 0 if limit.system.tangents == 1 else 0.0
    along = {name: none if first is None else first[name] for name in senses}
    found = {name: getattr(limit, name) for name in ("load_factor", "least", "bound", "residual")}
    rate, node = float(limit.friction_rate.sum()), -1 if first is None else int(first["node"])
    return {
        "friction": float(np.mean(friction)),
        **found,
        "friction_rate": rate,
        "node": node,
        **along,
        "solver": limit.record.solver,
    }


def judged(program: Program, chosen: bool = False, above: float = -np.inf) -> ShakedownLimit:
    """The limit in a program, judged by the referee and its multipliers; `chosen` by an objective; SolverError if it is proven not `above`."""
    question, load_factor, slip, proof = (
        program.question,
        program.load_factor,
        program.slip,
        program.chain.proof,
    )
    residual = float(
        np.nan_to_num(
            np.max([question.violation(load_factor, slip), proof.gap, program.own_violation]),
            nan=np.inf,
        )
    )
    names = (*program.own, "objective") if chosen else tuple(program.own)
    record, bound = SolveRecord(residual=residual), upper_bound(proof, above)
    limit = ShakedownLimit(
        load_factor,
        slip,
        record,
        question,
        program.motion,
        LimitKind.FINITE,
        bound,
        constraints=names,
    )
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(limit, _why=why, objective=proof.value) if chosen else limit


def every_load_is_safe(program: Ordered) -> ShakedownLimit | None:
    """The proven answer that all load factors are safe with this order of events; None if that is not so."""
    growth = program.chain.growth()
    if growth is None:
        return None
    way = [program.chain.value_along(growth, part) for part in program.way]
    question = program.placed(way, program.chain.value_along(growth, program.x.load_factor))
    still = Mechanism(np.zeros((len(program.corners), *question.r1.shape[1:])), question.friction)
    no_slip, record = np.full(program.x.slip.shape, np.nan), SolveRecord(residual=growth.residual)
    return ShakedownLimit(np.inf, no_slip, record, question, still, LimitKind.UNBOUNDED, np.inf)


def without_limit(program: Program, chosen: bool) -> ShakedownLimit | None:
    """The proven answer that nothing is safe at any load factor, or all are from one on; else None; ModelError if an objective has no maximum."""
    question, names = (
        program.question,
        (*program.own, "objective") if chosen else tuple(program.own),
    )
    unsafe = np.full(question.system.slip_shape, np.nan)
    bare = (
        replace(program, own={}).compiled(shakedown(program.x, program.rows), question.load_unit)
        if names
        else None
    )
    none_at_all = bare.chain.contradiction() if bare else None
    if none_at_all:  # no row is to blame if none is safe without
        program.blame_no_own_row()
    if none := none_at_all or program.chain.contradiction():
        ruling, record = program.ruling(none.ruling), SolveRecord(residual=none.residual)
        limit = ShakedownLimit(
            np.nan, unsafe, record, question, program.motion, LimitKind.NO_SAFE_SLIP, np.nan
        )
        why = f"no residual slip that is safe at any load factor{question.pattern} obeys {', '.join(ruling)}: drop or relax them"
        return replace(limit, constraints=names, _why=why) if ruling else limit
    more = program.chain.growth()
    if not more:
        return None
    if chosen:
        raise ModelError(
            "objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint"
        )
    still, record = (
        Mechanism(np.zeros_like(question.r1), question.friction),
        SolveRecord(residual=more.residual),
    )
    growth = program.chain.value_along(more, program.x.load_factor)
    slip = program.chain.value_along(more, program.x.slip) / growth
    why = (
        growth_diagnosis(
            question.friction,
            (question.q1, question.p1),
            question.reactions_of_slip(slip),
            GROWN * question.mean_bound / question.load_unit,
        )
        if not names
        else ""
    )
    return ShakedownLimit(
        np.inf,
        unsafe,
        record,
        question,
        still,
        LimitKind.UNBOUNDED,
        np.inf,
        constraints=names,
        _why=why,
    )
