"""The shakedown limit lambda_2 in three dimensions: the load factor above which no residual slip is safe, from a second-order cone program."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import LoadCycle
from ..contact.answers import LimitKind
from ..contact.checks import Array, frozen
from ..contact.diagnosis import growth_diagnosis
from ..contact.record import SolveRecord, WithSlip
from ..contact.show import Plotted, frame
from ..contact.system import ContactSystem
from ..contact.tolerances import GROWN, RESIDUAL
from ..errors import SolverError
from ..solve.explain import Units, explain
from ..solve.solvers import Answer, Kind, solve
from .cones import shakedown_cones
from .limit_claim import LimitClaim, certified, judged, with_least_load
from .margin import MarginState3D, solve_margin
from .mechanism import Mechanism3D
from .posed import ConeQuestion, pose

__all__ = ["ShakedownLimit3D", "shakedown_limit"]


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit3D(WithSlip, Plotted):
    """The shakedown limit in three dimensions with its proof from both sides.

    Attributes
    ----------
    load_factor
        lambda_2: what `slip` carries at every corner; inf if all load factors have a safe slip from some on, nan if none has one.
    least
        The least load factor with a safe slip: 0 for a contact that is safe under its mean load, above 0 where only the corners press it. Below it
        the contact slips or opens for ever. Proven like the limit. NaN where nothing is safe.
    kind, reason
        Which of these it is, and why in words.
    slip
        (N, 2) a residual slip that is safe at the limit, length; NaN where `load_factor` is not finite.
    bound
        Upper bound of the limit from the mechanism alone; equals `load_factor` up to `residual`.
    record
        How it was found. Its `residual` is the larger of the violations of the contact law by `slip` at the corners and the relative distance of
        `bound`; without a finite limit, that of the proof; and the same two of `least` where it is above 0. At most 1e-9.
    problem
        The solved cvxpy problem; None in a copy, and where one node without friction or pressure keeps the limit at 0. Its objective is
        `load_factor` over the unit that `explain()` prints.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> corners = [{"Q": 1.0}, {"Q": -1.0}, {"R": 1.0}]
    >>> limit = fo.shakedown_limit(node, fo.LoadCycle({"P": 1.0}, corners), friction=0.5)
    >>> round(limit.load_factor, 9)  # f P over the radius of the smallest circle around the corners
    0.5
    """

    load_factor: float
    least: float
    kind: LimitKind
    reason: str
    slip: Array = field(repr=False)
    bound: float
    record: SolveRecord
    problem: cp.Problem | None = field(repr=False)
    _task: ConeQuestion = field(repr=False)
    _motion: Mechanism3D = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load: columns node, x, y, z, corner, slip1 and slip2 (unit vector), share of the total slip; largest first."""
        return self._motion.table(self._task.system.points)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its supergradients. NaN without a finite limit.
        """
        return frozen((self._motion.size * self.reactions[1]).sum(axis=0))

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N, 2) and (K, N) reactions `q, p` at the corners under the safe slip, at the limit, force; NaN without a finite limit."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.load_factor, self.slip)

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the safe slip; NaN where the pressure or the friction vanishes, or without a limit."""
        return self._task.traction_ratios(*self.reactions)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x, y, z, the slip that is safe at the limit, and the largest `|q| / (f p)` over the corners.

        Corners at which the node carries nothing do not count.
        """
        ratio, (x, y, z) = self.traction_ratios, self._task.system.points.T
        ratio = np.where(np.isnan(ratio), 0.0, ratio).max(axis=0) if np.isfinite(self.load_factor) else ratio[0]
        columns = {"x": x, "y": y, "z": z, "slip1": self.slip[:, 0], "slip2": self.slip[:, 1], "traction_ratio": ratio}
        return frame({"node": range(len(x)), **columns})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("load_factor", "least", "kind", "bound", "largest_slip", "residual", "reason")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the circles that bind."""
        explain("shakedown limit", self.problem, self.load_factor, self._units, self.record.left_out, self.mechanism, file, self.reason)


def shakedown_limit(system: ContactSystem, cycle: LoadCycle, friction: Any, *, solver: str | None = None) -> ShakedownLimit3D:
    """Largest load factor at which some residual slip is safe, for the friction circle (Bjorkman & Klarbring 1987, with cones).

    Above it the contact never stops slipping. Below it, down to the least safe load factor, some slip is safe; that every transient finds one is
    known for uncoupled contacts only (Klarbring, Ciavarella & Barber 2007).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    solver
        "CLARABEL" or "CLARABEL_DIRECT"; by default both in this order until an answer passes.

    Returns
    -------
    ShakedownLimit3D
        `load_factor` is finite, inf (no limit) or nan (no safe slip at any load factor): each is an answer.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    start, task = perf_counter(), pose(system, cycle, friction)
    units: Units = {"load_factor": task.cones.load_unit, "traction": task.cones.traction_unit}
    answer, problem = _by_one_node(task, *task.stop, solver) if task.stop else _by_cones(task, solver)
    claim = answer.claim
    return ShakedownLimit3D(
        load_factor=claim.load_factor,
        least=claim.least,
        kind=claim.kind,
        reason=_reason(task, claim),
        slip=frozen(claim.slip),
        bound=claim.bound,
        record=SolveRecord(answer.solver, answer.attempts, claim.residual, task.left_out, perf_counter() - start),
        problem=problem,
        _task=task,
        _motion=claim.motion,
        _units=units,
    )


def _by_cones(task: ConeQuestion, solver: str | None) -> tuple[Answer[LimitClaim], cp.Problem]:
    """The limit from its cone program, or the proof that it has no optimum."""
    model = shakedown_cones(task.cones)
    answer = solve(model, lambda: judged(task, model), solver, kind=Kind.SOCP, no_optimum=lambda: _no_limit(task, solver))
    answer = with_least_load(task, answer, solver)
    if answer.claim.kind is LimitKind.FINITE:  # what the slip carries
        model.problem.var_dict["load_factor"].save_value(np.array(answer.claim.load_factor / task.cones.load_unit))
    return answer, model.problem


def _by_one_node(task: ConeQuestion, motion: Mechanism3D, why: str, solver: str | None) -> tuple[Answer[LimitClaim], None]:
    """The limit 0 of a contact with a node that no load factor above 0 leaves at rest, or the proof that nothing is safe at 0 either."""
    state, answer, model = solve_margin(task, 0.0, solver)
    if state.exists:
        claim = certified(task, 0.0, state.slip, motion, model.point.traction)
        claim = replace(claim, least=0.0, why=f"no residual slip is safe at any load factor above 0: {why}")
    else:
        claim = _nothing_safe(task, state)
    if not claim.residual <= RESIDUAL:
        raise SolverError(f"shakedown limit: the slip that is safe under the mean load violates the contact law by {claim.residual:.1e}")
    return Answer(claim, answer.solver, answer.attempts), None


def _no_limit(task: ConeQuestion, solver: str | None) -> LimitClaim | None:
    """Decide why there is no finite limit, by the margin of two problems that always have an optimum; None if neither reason can be proven."""
    existence, _, _ = solve_margin(task, None, solver)
    if existence.margin < -RESIDUAL:
        return _nothing_safe(task, existence)
    cyclic, _, _ = solve_margin(task, task.cones.load_unit, solver, mean=0.0)
    if cyclic.margin < -RESIDUAL:
        return None
    (q, p), unit, loads = task.slip_reactions(cyclic.slip), task.cones.load_unit, task.loads
    slipped = (q - loads.q0) / unit, (p - loads.p0) / unit
    growth = growth_diagnosis(task.friction, (loads.q1, loads.p1), slipped, GROWN * task.mean_bound / unit, "")
    still, unsafe = cyclic.motion.scaled(0.0), np.full(task.system.slip_shape, np.nan)
    return LimitClaim(LimitKind.UNBOUNDED, np.inf, unsafe, still, np.inf, cyclic.residual, growth=growth)


def _nothing_safe(task: ConeQuestion, proof: MarginState3D) -> LimitClaim:
    unsafe = np.full(task.system.slip_shape, np.nan)
    return LimitClaim(LimitKind.NO_SAFE_SLIP, np.nan, unsafe, proof.motion, np.nan, proof.residual)


def _reason(task: ConeQuestion, claim: LimitClaim) -> str:
    if claim.why:
        return claim.why
    q, p, f = task.loads.q0, task.loads.p0, task.friction
    pulls, beyond = int((p < 0).sum()), int((np.linalg.norm(q, axis=-1) > f * p).sum())
    mean = (
        f"under the mean load, if nothing slips, {pulls} of {len(p)} nodes pull and {beyond} exceed their friction bound; press the contact, or give "
        "it more friction"
    )
    if not claim.load_factor > 0:
        return f"no residual slip is safe at any load factor{' above 0' * (claim.kind is LimitKind.FINITE)}: {mean}"
    start, below = (f" from {claim.least:.6g} on", f"; none is safe below {claim.least:.6g}: {mean}") if claim.least > 0 else ("", "")
    if claim.kind is LimitKind.UNBOUNDED:
        return f"the shakedown limit is infinite: every load factor{start} has a safe residual slip; {claim.growth}{below}"
    return f"no residual slip is safe above it{below}"
