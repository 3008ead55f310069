"""Existence of a safe residual slip at a given load factor: the slip with its margin, or the proof that there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import ROUNDING, SolveRecord, bar_of, finite_number, listed, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from ..solve.solvers import NoOptimum
from ..transients.statics import unscaled_diagnosis
from . import models
from .answered import Proven, answered
from .lift_off import LiftOff, Ordered
from .models import Row
from .patterns import check_events
from .programs import Program
from .question import Question, with_open
from .safe_model import SafeModel, in_turn
from .shakedown import ShakedownLimit
from .shakedown_model import ShakedownModel

_MOST_CYCLIC = 1e15  # cyclic loads above so many mean normal forces have none of their digits
_NO_MARGIN = (
    ROUNDING  # a margin this little below zero is zero: that of the slip at the shakedown limit
)


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Proven):
    """A residual slip that keeps the contact stuck, or the proof that there is none.

    Attributes
    ----------
    load_factor
        The load factor that was asked for.
    slip
        (N,) or (N, 2) the slip that stays furthest inside the friction bounds, length (the least
        unsafe one if none is safe). See `largest_slip`.
    margin
        Its smallest reserve `f p - |q|` over nodes and corners, in mean friction bounds at load
        factor 0 (gaps shut), at most 1; negative: none is safe. At nodes with friction below 0.01 a
        tension counts as well, as if it were 0.01; with open nodes their gap, in what the mean
        friction bound does to the mean normal stiffness. Nodes that just touch where they open or
        close (`events`) have none.
    bound
        Upper bound of the margin from the multipliers alone; equals `margin` up to `residual`.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the shortfall of the
        slip's reserve, recomputed, and the distance of `bound`.
    constraints
        Names of the constraints of your own: slip, margin and margin bound are those of the program
        with them.
    problem
        The solved cvxpy problem. A later solve of the same `SafeSlipModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> safe = fo.safe_slip(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}]), friction=0.5, load_factor=0.8)
    >>> safe.exists, safe.certificate is None, round(safe.margin, 6)
    (True, True, 0.2)
    """

    _said = ("exists", "margin", "bound", "largest_slip", "residual", "reason")
    margin: float
    bound: float

    @cached_property
    def friction_rate(self) -> float:
        """Rate of the margin with friction, added alike at all nodes, in mean friction bounds as they are."""
        return float(self._by_friction.sum())

    @property
    def exists(self) -> bool:
        """Whether a safe slip exists at the load factor: the margin is not negative by more than 1e-12 or its own residual."""
        return bool(self.margin >= -max(_NO_MARGIN, self.residual))

    @cached_property
    def reason(self) -> str:
        """What the slip does, or why there is none: which nodes stay open, or which way the mean load pulls."""
        question, bound = (
            self._question,
            [] if self._question.slip_bound is None else ["the slip bound"],
        )
        within = (
            f" within {' and '.join([*bound, *self.constraints])}"
            if bound or self.constraints
            else ""
        )
        opened = int(self.open.sum())
        if self.exists:
            if moving := self.events["node"].nunique():
                return f"this slip{within} keeps all nodes stuck while they are closed; {moving} of them open and close in each cycle (events)"
            others = f"the {self.system.nodes - opened} closed nodes" if opened else "every node"
            return f"this slip{within} keeps {others} closed and stuck at every corner{', and the others open' * bool(opened)}"
        left = (
            f" with all nodes closed, or with the {opened} open that the search finds; with others open one may be"
            if opened
            else question.pattern
        )
        mean = unscaled_diagnosis(question.system, question.cycle, question.friction)
        return f"no residual slip{within} is safe at this load factor{left}; shakedown_limit says which have one; without residual slip {mean}"

    @cached_property
    def certificate(self) -> pd.DataFrame | None:
        """Why no slip is safe (Farkas's lemma); None if one is, and under constraints of your own.

        A table like `ShakedownLimit.mechanism`: slips whose friction cannot take up the work of the
        loads, while no residual slip does work on them, or with a slip bound too little. Under
        constraints of your own such slips alone prove nothing: `bound` covers all.
        """
        return (
            None
            if self.exists or self.constraints
            else self._motion.table(self.system, self.cycle.corner_names)
        )

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return (
            "safe residual slip",
            self.margin,
            self._motion.table(self.system, self.cycle.corner_names),
            self.reason,
        )


class SafeSlipModel(SafeModel):
    """The safe residual slips of one system under one load cycle, for any friction, load factor and constraints of your own. Theory, eq. (9).

    Parameters and what they raise are those of `ShakedownModel`.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> model = fo.SafeSlipModel(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}]))
    >>> round(model.solve(0.5, load_factor=0.8).margin, 6)
    0.2
    >>> round(model.solve(0.5, load_factor=0.8, constraints=[model.slip[0] - model.slip[1] <= 0.25]).margin, 6)
    -0.1
    """

    _given = True
    load_factor: cp.Parameter
    """The load factor that is given, a cvxpy parameter for constraints of your own."""
    margin: cp.Variable
    """The margin, see `SafeSlip`, a cvxpy variable for constraints of your own."""

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
        self._last: tuple[tuple[bytes, float, float], ShakedownLimit] | None = (
            None  # what was asked last, and the limit then
        )
        self.margin = cp.Variable(name="margin")
        self._spare, self._press = (
            cp.Parameter(system.nodes, nonneg=True, name=name)
            for name in ("mean_bound", "mean_pressure")
        )
        self._apart = cp.Parameter(nonneg=True, name="clearance")

    @property
    def _unknowns(self) -> list[cp.Variable]:
        return [*super()._unknowns, self.margin]

    def _safe(
        self, question: Question, load_factor: float, own: Sequence[cp.Constraint] = ()
    ) -> SafeSlip:
        """The slip with the largest margin, with given nodes open."""

        def friction(x: models.Unknowns, corners: list[int]) -> list[Row]:
            spare, press = (
                dict.fromkeys(corners, models.times(self.margin, unit))
                for unit in (self._spare, self._press)
            )
            return models.inside(x, self._f, corners, spare, press, self.margin * self._apart)

        self._spare.value, self._press.value = (
            question.mean_bound * ~question.open_nodes,
            question.mean_pressure * ~question.open_nodes,
        )
        self._apart.value, self.load_factor.value = question.clearance, load_factor
        program = self._program(
            question,
            own,
            None,
            lambda each: models.safe_slip(self.margin, each.rows),
            "safe slip",
            1.0,
            friction=friction,
        )
        try:
            claim, record = program.chain.solve(
                lambda: judged(program, self.margin, load_factor), self._solver
            )
        except NoOptimum:
            ruling = (
                ()
                if not own or not (none := program.chain.contradiction())
                else program.ruling(none.ruling)
            )
            if ruling:
                asked = f"no residual slip, safe or not, obeys this at load factor {load_factor:g}; drop or relax it"
                raise ModelError(f"{', '.join(ruling)}: {asked}") from None
            raise
        return answered(claim, record, program)

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
        """The residual slip with the largest reserve at every node and corner of the cycle, under constraints of your own.

        Parameters
        ----------
        friction, load_factor, events, progress
            See `safe_slip`.
        constraints
            cvxpy constraints on `slip`, `q`, `p` and `margin` of this model, see
            `ShakedownModel.solve`; `bound` and `residual` cover them.

        Raises
        ------
        ModelError, SolverError
            As `ShakedownModel.solve`; a load factor so large that rounding loses the mean load;
            constraints that no slip obeys, safe or not.
        """
        with bar_of(progress, "safe slip"):
            safe = self.of_pattern(
                self._posed(friction), load_factor, listed("constraints", constraints), events
            )
        self.margin.save_value(np.array(safe.margin))
        return self._shown(safe)

    def of_pattern(
        self,
        question: Question,
        load_factor: float,
        own: Sequence[Row] = (),
        events: bool = False,
        enough: float = np.inf,
    ) -> SafeSlip:
        """The slip with all nodes closed; where none is safe, with those open of the best limit or the first that is `enough`, or events."""
        check_events(events, question, bool(own))
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        largest = load_factor / question.force * float(np.abs(question.r1).max())
        if largest > _MOST_CYCLIC:
            raise ModelError(
                f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean normal force {question.force:.3g} of the mean load, "
                "which is lost in their rounding; give less, or check the units of the load cases"
            )

        try:
            safe = (
                None if own else self._safe(question, load_factor)
            )  # own constraints may contradict each other where all nodes are closed
        # a slip that hardly anything resists, as a roll, can hide the margin, and not that none is
        # safe
        except SolverError:
            safe = None
        if safe is None or not safe.exists:
            limit = self._limit(question, load_factor, enough)
            if safe is None or limit.open.any():
                rest = with_open(question, limit.open)
                assert rest is not None  # it has a limit
                safe = self._safe(rest, load_factor, own)
            if events and not safe.exists:
                limit = self._shakedown.of_any_order(limit, load_factor)
                if (
                    isinstance(limit._question, LiftOff)
                    and limit.least <= load_factor <= limit.load_factor
                ):
                    safe = self._in_order(limit._question, load_factor)
        return safe

    def _limit(self, question: Question, load_factor: float, enough: float) -> ShakedownLimit:
        """That of the best set of open nodes that is safe from the load factor on, or from less."""
        key = question.friction.tobytes(), load_factor, enough
        if self._last is None or self._last[0] != key:
            self._last = key, self._shakedown.of_any_set(question, at=load_factor, enough=enough)
        return self._last[1]

    def _in_order(self, asked: LiftOff, load_factor: float) -> SafeSlip:
        """The slip with the largest margin, with nodes that open and close in a given order. What just touches has nothing to spare."""
        margin, given = (
            cp.Variable(name="margin"),
            cp.Parameter(nonneg=True, name="load_factor", value=load_factor),
        )
        spare, press = dict[int, cp.Expression](), dict[int, cp.Expression]()
        for m, stuck in enumerate(asked.statuses[0]):
            spare[m] = models.times(
                margin, models.constant(asked.mean_bound * stuck, f"mean_bound[{m}]")
            )
            press[m] = models.times(
                margin, models.constant(asked.mean_pressure * stuck, f"mean_pressure[{m}]")
            )
        apart = models.times(margin, models.constant(asked.clearance, "clearance"))

        def friction(x: models.Unknowns, f: cp.Parameter, instants: list[int]) -> list[Row]:
            return models.inside(x, f, instants, spare, press, apart)

        program = Ordered(
            asked, lambda each: models.safe_slip(margin, each.rows), 1.0, friction, given
        )
        return answered(
            *program.chain.solve(lambda: judged(program, margin, load_factor), self._solver),
            program,
        )


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
    """Find the residual slip with the largest reserve at every node and corner of the cycle. Theory, eq. (9).

    Parameters
    ----------
    system, cycle, friction, slip_bound, simplify, solver, progress
        See `shakedown_limit`; for constraints of your own see `SafeSlipModel`.
    load_factor
        Load factor, >= 0.
    events
        Whether nodes may also open and close in each cycle, see `shakedown_limit`, where no slip is
        safe with nodes that stay as they are.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> fo.safe_slip(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), friction=0.5, load_factor=0.6).exists
    False
    """
    with bar_of(progress, "safe slip"):
        model = SafeSlipModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        return model.of_pattern(model._posed(friction), load_factor, events=events)


def judged(program: Program, margin: cp.Variable, load_factor: float) -> SafeSlip:
    """The slip that stands in a program of the margin, judged by its reserve, and by the multipliers."""
    question, value, slip, proof = (
        program.question,
        float(margin.value),
        program.slip,
        program.chain.proof,
    )
    (u, r), (stuck, opened) = question.instants(load_factor, slip), question.statuses
    q, p = np.linalg.norm(r[:, :-1], axis=1), r[:, -1]
    held = np.minimum((question.friction * p - q) / question.mean_bound, p / question.mean_pressure)
    reserve = min(
        np.min(held, where=stuck, initial=np.inf),
        np.min(u[:, -1], where=opened, initial=np.inf) / question.clearance,
    )
    gap = (abs(proof.bound - value) + proof.defect) / max(1.0, abs(value))
    off = question.violation(load_factor, slip) if question.events else 0.0
    residual = np.max(
        [gap, value - reserve, off, question.excess_over_slip_bound(slip), program.own_violation]
    )
    record = SolveRecord(residual=float(np.nan_to_num(residual, nan=np.inf)))
    return SafeSlip(
        load_factor,
        slip,
        record,
        question,
        program.motion,
        value,
        proof.bound + proof.defect,
        constraints=tuple(program.own),
    )
