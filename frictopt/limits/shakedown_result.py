"""A shakedown limit with its proof from both sides: safe from below by the contact law, and from above by the mechanism."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact.answers import LimitKind
from ..contact.checks import Array, finite_number, frozen
from ..contact.record import Attempt, SolveRecord
from ..contact.show import frame
from ..contact.tolerances import FLOOR, RESIDUAL
from ..errors import ModelError
from ..solve.explain import Units, explain
from ..solve.polish import Program
from .kinds import growth, reason
from .least_slip import LeastSlip, least_slip
from .mechanism import Mechanism
from .own_constraints import Extended, contradiction, is_unbounded
from .posed import Answered, LimitQuestion
from .ruling_corners import load_factor_unit
from .safe_set import SafeProblem
from .safe_slip import MarginState
from .scaling import ScaledContact

__all__ = ["LimitClaim", "ShakedownLimit", "judged", "judged_by_rows", "judged_extended", "no_limit_claim", "no_limit_under"]


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(Answered):
    """The shakedown limit with its proof from both sides.

    Theory, eq. (8).

    Attributes
    ----------
    load_factor
        lambda_2, the largest load factor with a safe slip; inf if all have one from some load factor on, nan if none has one.
    least
        The least load factor with a safe slip: 0 for a contact that is safe under its mean load. It is above 0 where the mean load alone leaves no
        safe slip and the corners press; then load factors are safe from `least` to `load_factor`, and below `least` the contact slips or opens for
        ever. Proven like the limit, also under a slip bound and constraints of your own. NaN where nothing is safe, where rounding
        hides it (`reason` says so), and with an objective.
    kind, reason
        Which of these it is, and why in words.
    slip
        (N,) a residual slip that is safe at the limit, length; NaN where `load_factor` is not finite. `largest_slip` is its size: compare it with
        what assembly can leave, and bound it by `slip_bound`.
    bound
        Upper bound of the limit from the mechanism alone, or with constraints of your own from all multipliers, theirs too; equals
        `load_factor` up to `residual`.
    record
        How it was found. Its `residual` is the largest of: the violations of the contact law by `slip` at the corners, and the relative distance of
        `bound`; without a finite limit, that of the proof; and the same two of `least` where it is above 0. At most 1e-9.
    constraints
        Names of the constraints of your own, and "objective" for an objective: slip, residual and dual bound are those of the program with them.
    objective
        Largest value of an objective of your own; None without. Then `load_factor` is the one that it chooses, `bound` is an upper bound of the
        objective, and `friction_rate` is its rate.
    problem
        The solved cvxpy problem; None for a closed form. Its objective is `load_factor` over the unit that `explain()` prints.
        A later solve of the same `ShakedownModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
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

    load_factor: float
    least: float
    kind: LimitKind
    reason: str
    slip: Array = field(repr=False)
    bound: float
    record: SolveRecord
    constraints: tuple[str, ...]
    objective: float | None
    problem: cp.Problem | None = field(repr=False)
    _task: LimitQuestion = field(repr=False)
    _motion: Mechanism = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load: columns node, x, corner, direction (+1 slips along +x), share of the total slip; largest first."""
        return self._motion.table(self.system)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its supergradients. NaN without a finite limit.
        """
        if not np.isfinite(self.load_factor):
            return self.slip
        pressure = self._task.loads.p0 + self._task.system.B @ self.slip
        return frozen(self._motion.friction_rate(self._task.loads, pressure, self.load_factor))

    @cached_property
    def load_rates(self) -> pd.DataFrame:
        """Rate of the limit with each amplitude of the load cycle: columns load, part ("mean" or "corner k"), amplitude, rate.

        NaN without a finite limit, and with constraints of your own, for those may change with the loads.
        """
        load_factor = np.nan if self.constraints else self.load_factor
        rates = self._motion.load_rates(self._task.system, self._task.cycle, self._task.friction, load_factor)
        return rates.assign(rate=np.nan) if self.constraints else rates

    def least_slip(self, load_factor: float) -> LeastSlip:
        """Proven lower bound of the slip in every cycle at a load factor, from every start; it is positive above the limit.

        Raises
        ------
        ModelError
            Bad load factor; a limit that is not finite, under a slip bound, or under constraints of your own, which proves nothing of other slips.
        SolverError
            The multipliers of the limit do not balance to the tolerance.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        if not np.isfinite(self.load_factor) or self.constraints or self._task.most is not None:
            asked = f"load factor {self.load_factor:g}" + (" under constraints on the slip" if np.isfinite(self.load_factor) else "")
            raise ModelError(f"least_slip: the limit ({asked}) bounds no slip from below; ask a finite limit without slip bound and constraints")
        return least_slip(self._task.system, self._task.friction, self._motion, self.bound, load_factor, self.residual)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x and the slip that is safe at the limit."""
        return frame({"node": range(len(self.slip)), "x": self.system.x, "slip": self.slip})

    def _answer(self) -> Mapping[str, Any]:
        chosen = () if self.objective is None else ("objective",)
        return {name: getattr(self, name) for name in ("load_factor", "least", "kind", *chosen, "bound", "largest_slip", "residual", "reason")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        value = self.load_factor if self.objective is None else self.objective
        explain("shakedown limit", self.problem, value, self._units, self.record.left_out, self.mechanism, file, self.reason)


@dataclass(frozen=True, eq=False)
class LimitClaim:
    """A claimed limit with what is known against it.

    Attributes
    ----------
    growth, why
        Why there is no largest safe load factor, and a reason that stands for that of `kinds.reason`; in words.
    """

    task: LimitQuestion
    kind: LimitKind
    load_factor: float
    slip: Array
    motion: Mechanism
    bound: float
    residual: float
    least: float = np.nan
    growth: str = ""
    why: str = ""
    constraints: tuple[str, ...] = ()
    objective: float | None = None

    def result(
        self, solver: str, attempts: tuple[Attempt, ...], left_out: tuple[str, ...], problem: cp.Problem | None, units: Units
    ) -> ShakedownLimit:
        """The limit that is claimed, with how it was found."""
        why = self.why or reason(self.task, self.kind, (self.least, self.load_factor), self.growth, self.constraints)
        record = self.task.record(solver, attempts, self.residual, left_out)
        found = self.load_factor, self.least, self.kind, why, frozen(self.slip), float(self.bound), record
        return ShakedownLimit(*found, self.constraints, self.objective, problem, self.task, self.motion, units)


def judged(task: LimitQuestion, scaled: ScaledContact, load_factor: float, slip: Array, motion: Mechanism, *, least: bool = False) -> LimitClaim:
    """Judge a limit by the referee, and from above by the mechanism, which is scaled to unit drive; or the least safe load factor, from below.

    At the least safe load factor more load helps, so that its mechanism has a negative drive.
    """
    resistance, drive = motion.work(task.loads, task.friction, task.most)
    sense = -1 if least else 1
    if not sense * drive > 0:
        return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, np.inf, np.inf)
    motion = motion.scaled(sense / drive)
    bound, defect = resistance / drive, task.defect(scaled, motion, slip)
    gap = (abs(bound - load_factor) + defect) / max(load_factor, FLOOR * load_factor_unit(task.loads, task.friction, task.force))
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, bound + sense * defect, residual)


def judged_by_rows(task: LimitQuestion, model: SafeProblem, load_unit: float, motion: Mechanism, names: tuple[str, ...]) -> LimitClaim:
    """Judge an answer under constraints of the user's own by the multipliers of all rows, theirs too."""
    load_factor, slip = max(0.0, float(model.value("load_factor"))) * load_unit, task.within_bound(model.slip)
    value, bound = Program(model.problem).bounds
    gap = abs(bound - value) / max(abs(value), FLOOR)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap, model.violation()), nan=np.inf))
    return LimitClaim(task, LimitKind.FINITE, load_factor, slip, motion, bound * load_unit, residual, constraints=names)


def judged_extended(task: LimitQuestion, extended: Extended, load_unit: float, motion: Mechanism) -> LimitClaim:
    """Judge an answer under constraints or an objective of the user's own."""
    claim = judged_by_rows(task, extended.model, load_unit, motion, extended.names)
    if extended.objective_unit is None:
        return claim
    unit, why = extended.objective_unit, "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    value, bound = (side * unit for side in Program(extended.model.problem).bounds)
    return replace(claim, why=why, bound=bound, motion=motion.scaled(unit / load_unit), objective=value)


def no_limit_under(extended: Extended, task: LimitQuestion, solver: str | None) -> LimitClaim | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven.

    Raises
    ------
    ModelError
        An objective without a largest value.
    """
    problem, names = extended.model.problem, extended.names
    unsafe, nothing = np.full(task.system.nodes, np.nan), np.zeros((task.loads.corners, task.system.nodes))
    still, excess = Mechanism(nothing, nothing, nothing, nothing[0]), contradiction(problem, solver)
    if excess.bound > RESIDUAL:
        ruling = ", ".join(name for name in names if name in excess.ruling)
        why = f"no residual slip that is safe at any load factor obeys {ruling}: drop or relax them"
        return LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, still, np.nan, excess.residual, why=why, constraints=names)
    growing = is_unbounded(problem, solver)
    if growing is None or excess.value > RESIDUAL:
        return None
    if extended.objective_unit is not None:
        raise ModelError("objective: it grows without end over the safe slips; subtract what it costs, or bound it by a constraint")
    residual = max(excess.residual, growing.residual)
    return LimitClaim(task, LimitKind.UNBOUNDED, np.inf, unsafe, still, np.inf, residual, constraints=names)


def no_limit_claim(task: LimitQuestion, kind: LimitKind, proof: MarginState) -> LimitClaim:
    """The claim that there is no finite limit, with the residual of its proof; the mechanism proves that nothing is safe."""
    value = np.inf if kind is LimitKind.UNBOUNDED else np.nan
    motion = proof.motion if kind is LimitKind.NO_SAFE_SLIP else proof.motion.scaled(0.0)
    why = growth(task, proof) if kind is LimitKind.UNBOUNDED else ""
    return LimitClaim(task, kind, value, np.full(task.system.nodes, np.nan), motion, value, proof.residual, growth=why)
