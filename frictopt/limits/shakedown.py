"""The shakedown limit: the largest load factor at which some residual slip keeps every node closed and stuck at every corner of the load cycle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import GROWN, RESIDUAL, Array, ContactSystem, LimitKind, LoadCycle, SolveRecord, bar_of, listed, warns_of_odd_values
from ..contact.checks import flags
from ..contact.diagnosis import growth_diagnosis
from ..errors import ModelError, NoContinuation, SolverError
from .answered import Mechanism, answered
from .lift_off import LiftOff, Ordered
from .models import least_load, shakedown
from .patterns import best_order, best_pattern, check_events
from .programs import Program
from .question import Question, with_open
from .safe_model import SafeModel, in_turn
from .shakedown_result import ShakedownLimit, upper_bound


class ShakedownModel(SafeModel):
    """The shakedown limit of one system under one load cycle for any friction; its program is compiled once. Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `|v|` that assembly can leave, one or one per node, length; None for no bound. A slide of the whole body counts:
        where nothing resists one, the program chooses it.
    simplify
        Leave out what cannot change the answer: corners within the hull of the others, and in the plane rows that others stand for.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM" (in space "CLARABEL_DIRECT", "CLARABEL", "INTERIOR_POINT", which for large contacts comes first);
        by default each in this order until an answer passes.

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
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units, and on variables of your own. They are linear, or
            of abs, max, norms and the like: the multipliers of rows and second-order cones prove the limit. `bound` and `residual` cover them. The
            nodes that stay open are those of the limit without them: q and p are 0 there, and the slip is that under the mean load.
        objective
            What shall be largest over the safe slips, instead of the load factor: a concave cvxpy expression on the same, of the same forms, such as
            `model.load_factor - 0.1 * cp.norm1(model.slip)`. See `ShakedownLimit.objective`.

        Raises
        ------
        ModelError, SolverError
            Bad friction; open nodes that the others do not hold; constraints that are not convex, need other cones, or are on another model; such an
            objective, or one without a largest value; no solver gave an answer that passes the checks.
        """
        own = listed("constraints", constraints)
        with bar_of(progress, "shakedown limit"):
            return self._shown(self.of_pattern(self._posed(friction), open, events, own, objective))

    def of_pattern(
        self, task: Question, open: Any, events: bool, own: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None
    ) -> ShakedownLimit:
        """The limit with given nodes open; or of the best pattern that is found, maybe with nodes that open and close in each cycle."""
        check_events(events, task, bool(own) or objective is not None or open is not None)
        if open is not None:
            rest = with_open(task, flags("open", open, len(task.open)))
            if rest is None or rest.open.all():
                raise ModelError("open: too few closed nodes, or none, would hold the open ones; leave more nodes closed")
            return self.of_set(rest, own, objective)
        limit = self.of_any_set(task, own, objective)
        return self.of_any_order(limit) if events else limit

    def of_any_order(self, best: ShakedownLimit, at: float = np.inf) -> ShakedownLimit:
        """The best limit with nodes that open and close in each cycle, see `best_order`, from one of nodes that stay as they are."""

        def of_order(asked: LiftOff, above: float) -> ShakedownLimit:
            program = Ordered(asked, lambda each: shakedown(each.x, each.rows), asked.load_unit)
            claim, record = program.chain.solve(partial(judged, program, above=above), self._solver, no_optimum=program.without_limit, above=above)
            return answered(claim, record, program)

        return best_order(best, of_order, at)

    def of_any_set(
        self, task: Question, own: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None, at: float = np.inf, enough: float = np.inf
    ) -> ShakedownLimit:
        """The limit of the best pattern of open nodes that the search finds, see `best_pattern`; with all closed where none wants to open."""
        if own or objective is not None:  # which change no pattern
            return self.of_set(with_open(task, self.of_any_set(task).open) or task, own, objective)
        tried = list[Question]()

        def counted(asked: Question, above: float) -> ShakedownLimit:
            tried.append(asked)
            return self.of_set(asked, above=above)

        best = best_pattern(counted, self.of_set(task), at, enough)
        if tried and tried[-1] is not best._task:  # its answer shall stand in its problem
            return replace(self.of_set(best._task), least=best.least)
        return best

    def of_set(
        self, task: Question, own: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None, above: float = -np.inf
    ) -> ShakedownLimit:
        """The limit with given nodes open; a SolverError once it is proven not to be `above` a load factor."""
        unit = task.load_unit if objective is None else 1.0
        program = self._program(task, own, objective, lambda each: shakedown(each.x, each.rows), "shakedown", unit)
        claimed = partial(judged, program, objective is not None, above=above)
        claim, record = program.chain.solve(claimed, self._solver, no_optimum=lambda: without_limit(program, objective is not None), above=above)
        limit = answered(claim, record, program)
        if limit.kind is LimitKind.NO_SAFE_SLIP or objective is not None:
            return limit
        slips = () if own else _likely_slips(limit)
        at_zero = any(task.violation(0.0, slip) <= RESIDUAL for slip in slips)
        return replace(limit, least=0.0) if at_zero else self._with_least(limit, program)

    def _with_least(self, limit: ShakedownLimit, program: Program) -> ShakedownLimit:
        """The limit with the least safe load factor, by a program of its own; nan where no solver gives one that passes the checks."""
        try:
            with program.chain.kept():
                downward = replace(program).compiled(least_load(program.x, program.rows), program.task.load_unit)
                lower, found = downward.chain.solve(lambda: judged(downward), self._solver)
        except SolverError:  # rounding hides whether some slip is safe under the mean load: the limit stands, the least one is not known
            return limit
        attempts, seconds = (*limit.record.attempts, *found.attempts), perf_counter() - program.task.started
        record = replace(limit.record, attempts=attempts, residual=max(limit.residual, lower.residual), seconds=seconds)
        return replace(limit, least=lower.load_factor, record=record)

    @warns_of_odd_values
    def sweep(self, frictions: Any, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True) -> pd.DataFrame:
        """The limit for many coefficients of friction (each one number or (N,)), one row each, under constraints of your own as in `solve`.

        Columns: friction (mean), load_factor, least, bound, residual, friction_rate, node and sense of the mechanism's largest share, solver. Raises
        what `solve` does; ModelError if not a sequence. Ctrl-C stays a KeyboardInterrupt with an attribute `table`, that of the limits by then.
        """
        own, wanted, rows = listed("constraints", constraints), listed("frictions", frictions), list[dict[str, Any]]()

        def kept(_: object) -> tuple[str, object, str] | None:
            said = f"the limits of {len(rows)} of {len(wanted)} frictions are in the attribute `table`"
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

    Safe means: every node closed and stuck at every corner of the cycle, or open all through it (`ShakedownLimit.open`), with `events` also open in a
    part of it. Which ones is searched near the settled mean load. With others, a contact may rest above it. Theory, eq. (7). Ctrl-C in a search stays
    a KeyboardInterrupt with an attribute `limit`, the best limit by then.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    open
        (N,) bool, which nodes stay open, the others closed; None for the search. All False asks for the limit with all nodes closed.
    events
        Whether nodes may also open and close in each cycle of a load that goes to and fro between two corners (`ShakedownLimit.events`). Their order
        is searched too, which takes some seconds. Not with fixed parts that differ, a slip bound, or constraints.
    slip_bound, simplify, solver
        See `ShakedownModel`.
    progress
        Whether to show after two seconds how far it is, and the best so far: a bar, or a line every five seconds where there is no terminal.

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
        model = ShakedownModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
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
    first, senses = limit.mechanism.iloc[0] if len(limit.mechanism) else None, ("direction",) if limit.system.tangents == 1 else ("slip1", "slip2")
    none = 0 if limit.system.tangents == 1 else 0.0
    along = {name: none if first is None else first[name] for name in senses}
    found = {name: getattr(limit, name) for name in ("load_factor", "least", "bound", "residual")}
    rate, node = float(limit.friction_rate.sum()), -1 if first is None else int(first["node"])
    return {"friction": float(np.mean(friction)), **found, "friction_rate": rate, "node": node, **along, "solver": limit.record.solver}


def judged(program: Program, chosen: bool = False, above: float = -np.inf) -> ShakedownLimit:
    """The limit in a program, judged by the referee and its multipliers; `chosen` by an objective; SolverError if it is proven not `above`."""
    task, load_factor, slip, proof = program.task, program.load_factor, program.slip, program.chain.proof
    residual = float(np.nan_to_num(np.max([task.violation(load_factor, slip), proof.gap, program.own_violation]), nan=np.inf))
    names = (*program.own, "objective") if chosen else tuple(program.own)
    record, bound = SolveRecord(residual=residual), upper_bound(proof, above)
    limit = ShakedownLimit(load_factor, slip, record, task, program.motion, LimitKind.FINITE, bound, constraints=names)
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(limit, _why=why, objective=proof.value) if chosen else limit


def without_limit(program: Program, chosen: bool) -> ShakedownLimit | None:
    """The proven answer that nothing is safe at any load factor, or all are from one on; else None; ModelError if an objective has no maximum."""
    task, names = program.task, (*program.own, "objective") if chosen else tuple(program.own)
    unsafe = np.full(task.system.slip_shape, np.nan)
    bare = replace(program, own={}).compiled(shakedown(program.x, program.rows), task.load_unit) if names else None
    none_at_all = bare.chain.contradiction() if bare else None
    if none_at_all:  # no row is to blame if none is safe without
        program.blame_no_own_row()
    if none := none_at_all or program.chain.contradiction():
        ruling, record = program.ruling(none.ruling), SolveRecord(residual=none.residual)
        limit = ShakedownLimit(np.nan, unsafe, record, task, program.motion, LimitKind.NO_SAFE_SLIP, np.nan)
        why = f"no residual slip that is safe at any load factor{task.pattern} obeys {', '.join(ruling)}: drop or relax them"
        return replace(limit, constraints=names, _why=why) if ruling else limit
    more = program.chain.growth()
    if not more:
        return None
    if chosen:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    still, record = Mechanism(np.zeros_like(task.r1), task.friction), SolveRecord(residual=more.residual)
    growth = program.chain.value_along(more, program.x.load_factor)
    slip = program.chain.value_along(more, program.x.slip) / growth
    why = growth_diagnosis(task.friction, task.parts[2:], task.change(slip), GROWN * task.mean_bound / task.load_unit) if not names else ""
    return ShakedownLimit(np.inf, unsafe, record, task, still, LimitKind.UNBOUNDED, np.inf, constraints=names, _why=why)
