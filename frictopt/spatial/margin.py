"""Existence of a safe residual slip at a given load factor, in three dimensions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import LoadCycle
from ..contact.checks import Array, finite_number, frozen
from ..contact.record import SolveRecord, WithSlip
from ..contact.show import Plotted, frame
from ..contact.system import ContactSystem
from ..contact.tolerances import NO_MARGIN, RESIDUAL
from ..solve.explain import Units, explain
from ..solve.solvers import Answer, Kind, solve
from .cones import ConeProgram, margin_cones
from .mechanism import Mechanism3D, mechanism_of
from .posed import ConeQuestion, pose
from .scaling import ConeLoads

__all__ = ["MarginState3D", "SafeSlip3D", "safe_slip", "solve_margin"]


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip3D(WithSlip, Plotted):
    """A residual slip that keeps the contact stuck, or the proof that there is none.

    Attributes
    ----------
    load_factor
        Load factor of the question.
    exists
        Whether a safe slip exists at the load factor: the margin is not negative by more than 1e-12 or its own residual.
    slip
        (N, 2) the slip that stays furthest inside the friction circles, length (the least unsafe one if none is safe).
    margin
        Its smallest reserve `f p - |q|` over nodes and corners, in mean friction bounds of the mean load, at most 1; negative: none is safe.
        With friction below 0.01 somewhere the reserve of p counts as well.
    bound
        Upper bound of the margin from the multipliers alone; equals `margin` up to `residual`.
    record
        How it was found. Its `residual` is the larger of the shortfall of the slip's reserve, recomputed, and the distance of `bound`; at most
        1e-9.
    problem
        The solved cvxpy problem; None in a copy.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"R": 1.0}])
    >>> safe = fo.safe_slip(node, cycle, friction=0.5, load_factor=0.5)
    >>> safe.exists, (safe.slip + 0.0).round(6).tolist()  # the middle between the corners
    (True, [[-0.25, -0.25]])
    """

    load_factor: float
    exists: bool
    slip: Array = field(repr=False)
    margin: float
    bound: float
    record: SolveRecord
    problem: cp.Problem | None = field(repr=False)
    _task: ConeQuestion = field(repr=False)
    _motion: Mechanism3D = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def certificate(self) -> pd.DataFrame | None:
        """Why no slip is safe (Farkas's lemma): slips whose friction cannot take up the work of the loads; None if one is safe."""
        return None if self.exists else self._motion.table(self._task.system.points)

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N, 2) and (K, N) reactions `q, p` at the corners under the slip, force."""
        return self._task.reactions(self.load_factor, self.slip)

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the slip; NaN where the pressure or the friction vanishes."""
        return self._task.traction_ratios(*self.reactions)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x, y, z, slip1 and slip2."""
        x, y, z = self._task.system.points.T
        return frame({"node": range(len(x)), "x": x, "y": y, "z": z, "slip1": self.slip[:, 0], "slip2": self.slip[:, 1]})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("exists", "margin", "bound", "largest_slip", "residual")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the circles that bind."""
        explain(
            "safe residual slip", self.problem, self.margin, self._units, self.record.left_out, self._motion.table(self._task.system.points), file
        )


def safe_slip(system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, *, solver: str | None = None) -> SafeSlip3D:
    """Find the residual slip with the largest reserve at every node and corner of the cycle.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    solver
        "CLARABEL" or "CLARABEL_DIRECT"; by default both in this order until an answer passes.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    start, task = perf_counter(), pose(system, cycle, friction)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    state, answer, model = solve_margin(task, load_factor, solver)
    return SafeSlip3D(
        load_factor=load_factor,
        exists=state.exists,
        slip=frozen(state.slip),
        margin=state.margin,
        bound=state.bound,
        record=SolveRecord(answer.solver, answer.attempts, state.residual, task.left_out, perf_counter() - start),
        problem=model.problem,
        _task=task,
        _motion=state.motion,
        _units={"margin": task.mean_bound, "traction": task.cones.traction_unit},
    )


class MarginState3D:
    """Solution of a margin problem: margin, slip, the mechanism of its multipliers, and its residual."""

    def __init__(self, task: ConeQuestion, load_factor: float | None, mean: float, model: ConeProgram) -> None:
        c, point = task.cones, model.point
        x = dict(zip(model.scalars, point.x, strict=True))
        self.margin, self.slip = float(x["margin"]), task.slip(point.traction)
        self.load_factor = float(x["load_factor"]) * c.load_unit if load_factor is None else load_factor
        full = task.loads
        loads = ConeLoads(mean * full.q0, mean * full.p0, full.q1, full.p1)
        motion = mechanism_of(point, c.unit, task.friction, task.kept, len(full.q1))
        cap, slips = point.caps["cap"], float((point.weight * c.clearance).sum())
        self.motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(loads)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        defect = task.defect(self.motion, point.traction)
        self.bound = cap + resistance - self.load_factor * drive + defect
        if not slips > 0 and cap < 1 - RESIDUAL:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        q, p = task.slip_reactions(self.slip)
        q = q - (1 - mean) * full.q0 + self.load_factor * full.q1
        p = p - (1 - mean) * full.p0 + self.load_factor * full.p1
        reserve = float(min((task.friction * p - np.linalg.norm(q, axis=-1)).min(), p.min() if c.opening else np.inf))
        pull = float(-p.min() / task.force) if self.margin >= 0 else 0.0
        shortfall = max(self.margin - reserve / task.mean_bound, pull, 0.0)
        gap = abs(self.bound - defect - self.margin) + defect  # a defect that closes the gap is one for slips like this one alone
        self.residual = float(np.nan_to_num(max(gap, shortfall), nan=np.inf))
        self.exists = bool(self.margin >= -max(NO_MARGIN, self.residual))


def solve_margin(
    task: ConeQuestion, load_factor: float | None, solver: str | None, mean: float = 1.0
) -> tuple[MarginState3D, Answer[MarginState3D], ConeProgram]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, with the mean load times `mean`."""
    model = margin_cones(task.cones, None if load_factor is None else load_factor / task.cones.load_unit, mean)
    answer = solve(model, lambda: MarginState3D(task, load_factor, mean, model), solver, kind=Kind.SOCP)
    return answer.claim, answer, model
