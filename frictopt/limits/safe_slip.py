"""A safe residual slip at a given load factor, with its margin; or the proof that there is none."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    ROUNDING,
    Booleans,
    SolveRecord,
    Table,
    finite_number,
    listed,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from ..solve.solvers import NoOptimum
from . import models
from .answered import Proven, answered
from .best_set import best_open_nodes
from .lift_off import LiftOff
from .models import Row
from .moving_safe_slip import safe_with_moving_areas
from .order_search import check_events
from .ordered import Ordered
from .programs import Program
from .question import Question, with_open
from .reasons import safe_slip_reason
from .safe_model import SafeModel, in_turn
from .shakedown import ShakedownLimit
from .shakedown_model import ShakedownModel


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
        load factor 0 (gaps shut), at most 1. If it is negative, no slip is safe. At nodes with
        friction below 0.01, a tension also counts as a violation, as if friction were 0.01. At open
        nodes the reserve is the gap, in units of the mean friction bound divided by the mean normal
        stiffness. Nodes that open or close at an event (`events`) have no reserve there.
    bound
        Upper bound of the margin, from the multipliers only; it equals `margin` up to `residual`.
    record
        Solver, attempts and time. Its `residual`, at most 1e-9, is the larger of two errors: the
        margin minus the recomputed reserve of the slip, and the relative distance of `bound`.
    constraints
        Names of user constraints, which slip, margin and `bound` take into account.
    problem
        The solved cvxpy problem. A later solve of the same `SafeSlipModel` overwrites its values.

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

    @cached_property
    def reason(self) -> str:
        """Effect of the slip, or diagnosis of the mean load if no slip is safe, in words."""
        return safe_slip_reason(self, self.exists)

    @cached_property
    def certificate(self) -> Table | None:
        """Proof that no slip is safe (Farkas's lemma), a table like `ShakedownLimit.mechanism`.

        It has slips on which the loads do more work than friction can dissipate. No residual slip
        does work on them. With a slip bound, its work is too small. None if a slip is safe, and
        with user constraints: then only `bound` is a proof.
        """
        if self.exists or self.constraints:
            return None
        return self._motion.table(self.system, self._question.names)

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        mechanism = self._motion.table(self.system, self._question.names)
        return "safe residual slip", self.margin, mechanism, self.reason


class SafeSlipModel(SafeModel):
    """Safe residual slips of one system under one load cycle, for any friction.

    Each call of `solve` has its own load factor and constraints. For parameters and errors see
    `ShakedownModel`. Theory, eq. (9).

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
    >>> model = fo.SafeSlipModel(rod, cycle)
    >>> round(model.solve(0.5, load_factor=0.8).margin, 6)
    0.2
    >>> rows = [model.slip[0] - model.slip[1] <= 0.25]
    >>> round(model.solve(0.5, load_factor=0.8, constraints=rows).margin, 6)
    -0.1
    """

    _given = True
    load_factor: cp.Parameter
    """The load factor that is given, a cvxpy parameter for user constraints."""
    margin: cp.Variable
    """The margin, see `SafeSlip`, a cvxpy variable for user constraints."""

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        *,
        slip_bound: ArrayLike | None = None,
        simplify: bool = True,
        solver: str | None = None,
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
        self._shakedown = ShakedownModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        # Friction, load factor and sufficient limit of the last search, and its open nodes.
        self._last: tuple[tuple[bytes, float, float], Booleans] | None = None
        self.margin = cp.Variable(name="margin")
        # Units of the margin: of friction bounds, of normal forces, and of gaps.
        self._mean_bound = cp.Parameter(system.nodes, nonneg=True, name="mean_bound")
        self._mean_pressure = cp.Parameter(system.nodes, nonneg=True, name="mean_pressure")
        self._clearance = cp.Parameter(nonneg=True, name="clearance")

    @property
    def _unknowns(self) -> list[cp.Variable]:
        return [*super()._unknowns, self.margin]

    @warns_of_odd_values
    @in_turn
    def solve(
        self,
        friction: ArrayLike,
        load_factor: float,
        constraints: Sequence[cp.Constraint] = (),
        *,
        events: bool = False,
        progress: bool = True,
    ) -> SafeSlip:
        """Residual slip with the largest margin, under user constraints.

        Parameters
        ----------
        friction, load_factor, events, progress
            See `safe_slip`.
        constraints
            cvxpy constraints on `slip`, `q`, `p` and `margin` of this model, see
            `ShakedownModel.solve`. `bound` and `residual` include them.

        Raises
        ------
        ModelError, SolverError
            As `ShakedownModel.solve`; a load factor so large that rounding hides the mean load;
            constraints that no slip satisfies, safe or not.
        """
        user_rows = listed("constraints", constraints)
        with progress_bar(progress, "safe slip"):
            safe = self.of_question(self._posed(friction), load_factor, user_rows, events)
        self.margin.save_value(np.array(safe.margin))
        return self._shown(safe)

    def of_question(
        self,
        question: Question,
        load_factor: float,
        user_rows: Sequence[Row] = (),
        events: bool = False,
        enough: float = np.inf,
    ) -> SafeSlip:
        """Safe slip with all nodes closed, otherwise with the open nodes of a limit.

        The limit is the best limit of the search, or the first limit that reaches `enough`. Nodes
        may open and close in each cycle: with `events`, or if loads alone open and close them.
        """
        check_events(events, question, bool(user_rows))
        load_factor = self._checked_load_factor(question, load_factor)
        if not user_rows:
            moving: SafeSlip | None = safe_with_moving_areas(
                question, load_factor, self._of_ordinary
            )
            if moving is not None:
                return moving
        closed = self._if_closed(question, load_factor, user_rows)
        if closed is not None and closed.exists:
            return closed
        limit = None
        if events:
            limit = self._shakedown.of_any_set(question, start_by=load_factor, enough=enough)
            open_nodes = limit.open
        else:
            open_nodes = self._best_open_nodes(question, load_factor, enough)
        safe = closed
        if safe is None or open_nodes.any():
            opened = with_open(question, open_nodes)
            assert opened is not None  # it has a limit
            safe = self.of_set(opened, load_factor, user_rows)
        if safe.exists or limit is None:
            return safe
        return self._with_events(limit, load_factor) or safe

    def _with_events(self, limit: ShakedownLimit, load_factor: float) -> SafeSlip | None:
        """The safe slip of an order of events, searched from a limit; None if none is found."""
        limit = self._shakedown.of_any_order(limit, load_factor)
        ordered = limit._question
        if isinstance(ordered, LiftOff) and limit.least <= load_factor <= limit.load_factor:
            return self._of_order(ordered, load_factor)
        if isinstance(ordered, LiftOff) and np.isnan(limit.least):
            # The least load factor is not known: the order may have no slip at this one.
            with suppress(SolverError):
                return self._of_order(ordered, load_factor)
        return None

    def _of_ordinary(self, question: Question, load_factor: float) -> SafeSlip:
        """The safe slip of a question of its own, see `safe_with_moving_areas`."""
        model = SafeSlipModel(
            question.system, question.cycle, simplify=question.simplify, solver=self._solver
        )
        return model.of_set(question, load_factor)

    def _checked_load_factor(self, question: Question, load_factor: float) -> float:
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        largest = load_factor / question.force * float(np.abs(question.r1).max())
        # Ratio of cyclic loads to the mean normal force above which rounding hides the mean load.
        largest_ratio = 1e15
        if largest > largest_ratio:
            raise ModelError(
                f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean "
                f"normal force {question.force:.3g}, so that rounding hides the mean load; give a "
                "smaller load factor, or check the units of the load cases"
            )
        return load_factor

    def _if_closed(
        self, question: Question, load_factor: float, user_rows: Sequence[Row]
    ) -> SafeSlip | None:
        """The safe slip with all nodes closed; None with user rows, or if no answer passes."""
        # Constraints of the user may be contradictory only with all nodes closed.
        if user_rows:
            return None
        # A slip with nearly no resistance, such as rolling, can hide the margin.
        with suppress(SolverError):
            return self.of_set(question, load_factor)
        return None

    def _best_open_nodes(self, question: Question, load_factor: float, enough: float) -> Booleans:
        """The best open nodes of which the least safe load factor is <= `load_factor`."""
        key = question.friction.tobytes(), load_factor, enough
        if self._last is None or self._last[0] != key:
            open_nodes = best_open_nodes(self._shakedown, question, load_factor, enough)
            self._last = key, open_nodes
        return self._last[1]

    def of_set(
        self, question: Question, load_factor: float, user_rows: Sequence[cp.Constraint] = ()
    ) -> SafeSlip:
        """The slip with the largest margin, with the open nodes of the question."""
        closed = ~question.open_nodes
        self._mean_bound.value = question.mean_bound * closed
        self._mean_pressure.value = question.mean_pressure * closed
        self._clearance.value = question.clearance
        self.load_factor.value = load_factor
        program = self._program(
            question,
            user_rows,
            None,
            lambda program: models.safe_slip(self.margin, program.rows),
            "safe slip",
            1.0,
            friction=self._friction_with_margin,
        )
        try:
            claim, record = program.chain.solve(
                lambda: checked_slip(program, self.margin, load_factor), self._solver
            )
        except NoOptimum:
            self._raise_contradiction(program, load_factor)
            raise
        return answered(claim, record, program)

    def _friction_with_margin(self, x: models.Unknowns, corners: list[int]) -> list[Row]:
        spare = dict.fromkeys(corners, models.times(self.margin, self._mean_bound))
        press = dict.fromkeys(corners, models.times(self.margin, self._mean_pressure))
        return models.inside(x, self._f, corners, spare, press, self.margin * self._clearance)

    def _raise_contradiction(self, program: Program, load_factor: float) -> None:
        """ModelError if the user's constraints admit no slip at all, safe or not."""
        if not program.user_rows:
            return
        contradiction = program.chain.contradiction()
        names = program.ruling(contradiction.ruling) if contradiction else []
        if names:
            raise ModelError(
                f"{', '.join(names)}: no residual slip, safe or not, obeys this at load factor "
                f"{load_factor:g}; drop or relax it"
            ) from None

    def _of_order(self, question: LiftOff, load_factor: float) -> SafeSlip:
        """The slip with the largest margin, with nodes that open and close in a given order.

        A node has no reserve at the event at which it opens or closes.
        """
        margin = cp.Variable(name="margin")
        factor = cp.Parameter(nonneg=True, name="load_factor", value=load_factor)
        spare: dict[int, cp.Expression] = {}
        press: dict[int, cp.Expression] = {}
        for m, sticks in enumerate(question.statuses[0]):
            bound = models.constant(question.mean_bound * sticks, f"mean_bound[{m}]")
            pressure = models.constant(question.mean_pressure * sticks, f"mean_pressure[{m}]")
            spare[m] = models.times(margin, bound)
            press[m] = models.times(margin, pressure)
        gap_margin = models.times(margin, models.constant(question.clearance, "clearance"))

        def friction(x: models.Unknowns, f: cp.Parameter, instants: list[int]) -> list[Row]:
            return models.inside(x, f, instants, spare, press, gap_margin)

        program = Ordered(
            question, lambda program: models.safe_slip(margin, program.rows), 1.0, friction, factor
        )
        claim, record = program.chain.solve(
            lambda: checked_slip(program, margin, load_factor), self._solver
        )
        return answered(claim, record, program)


@warns_of_odd_values
def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    events: bool = False,
    slip_bound: ArrayLike | None = None,
    simplify: bool = True,
    solver: str | None = None,
    progress: bool = True,
) -> SafeSlip:
    """Find the residual slip with the largest margin at the corners of a cycle. Theory, eq. (9).

    Parameters
    ----------
    system, cycle, friction, slip_bound, simplify, solver, progress
        See `shakedown_limit`; for user constraints see `SafeSlipModel`.
    load_factor
        Load factor, >= 0.
    events
        Whether nodes may also open and close in each cycle, see `shakedown_limit`, if no slip is
        safe with nodes that stay as they are. Always, if slip changes no pressure (B = 0) and all
        nodes have friction.

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
        model = SafeSlipModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        return model.of_question(model._posed(friction), load_factor, events=events)


def checked_slip(program: Program, margin: cp.Variable, load_factor: float) -> SafeSlip:
    """The slip from a solved program of the margin, checked by its reserve and the multipliers."""
    question = program.question
    slip = program.slip
    value = float(margin.value)
    u, r = question.instants(load_factor, slip)
    sticks, opened = question.statuses
    q = np.linalg.norm(r[:, :-1], axis=1)
    p = r[:, -1]
    reserves = np.minimum(
        (question.friction * p - q) / question.mean_bound, p / question.mean_pressure
    )
    reserve = min(
        np.min(reserves, where=sticks, initial=np.inf),
        np.min(u[:, -1], where=opened, initial=np.inf) / question.clearance,
    )

    proof = program.chain.proof
    gap = (abs(proof.bound - value) + proof.defect) / max(1.0, abs(value))
    violation = question.violation(load_factor, slip) if question.events else 0.0
    excess = question.excess_over_slip_bound(slip)
    residual = np.max([gap, value - reserve, violation, excess, program.user_violation])
    return SafeSlip(
        load_factor=load_factor,
        slip=slip,
        record=SolveRecord(residual=float(np.nan_to_num(residual, nan=np.inf))),
        _question=question,
        _motion=program.motion,
        margin=value,
        bound=proof.bound + proof.defect,
        constraints=tuple(program.user_rows),
    )
