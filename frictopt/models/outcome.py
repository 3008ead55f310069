"""Why a shakedown problem has no optimum: proven, never taken from a solver's word."""

from enum import Enum

import numpy as np

from ..contact.checks import Array
from ..errors import SolverError
from .interface import Interface
from .mechanism import expand_duals
from .rows import LoadRows, Loads
from .safe import SafeProblem, existence_problem, margin_problem
from .solve import TOLERANCE, Answer, solve
from .task import Task

__all__ = ["MarginState", "NoLimit", "classify", "solve_margin"]


class NoLimit(Enum):
    """The two ways in which a load cycle has no finite limit."""

    UNBOUNDED = "every load factor has a safe residual slip"
    NO_SAFE_SLIP = "no load factor has a safe residual slip"


class MarginState:
    """Solution of a margin problem: margin, slip, the mechanism of its multipliers, and its residual."""

    def __init__(self, task: Task, interface: Interface, rows: LoadRows, loads: Loads, load_factor: float | None, model: SafeProblem) -> None:
        self.margin = float(model.value("margin"))
        self.slip: Array = interface.slip @ model.value("traction")
        self.load_factor = float(model.value("load_factor")) * rows.load_unit if load_factor is None else load_factor
        motion = expand_duals(interface, rows, model.duals, task.system.nodes, loads.corners)
        cap = max(float(model.problem.constraints[2].dual_value), 0.0)
        self.motion = motion.scaled((1 - cap) / (float(motion.total.sum()) * task.mean_bound or 1.0))
        resistance, drive = self.motion.work(loads, task.friction)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        self.bound = cap + resistance - self.load_factor * drive + task.defect(self.motion, self.slip)
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(abs(self.bound - self.margin), shortfall), nan=np.inf))


def solve_margin(
    task: Task, interface: Interface, loads: Loads, load_factor: float | None, solver: str | None
) -> tuple[MarginState, Answer[MarginState], SafeProblem]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given."""
    rows = task.rows(interface, loads)
    model = (existence_problem if load_factor is None else margin_problem)(interface, rows.node)
    model.set(rows, load_factor)
    model.problem.param_dict["clearance"].value = task.mean_bound / interface.unit[rows.node]

    answer = solve(model, lambda: MarginState(task, interface, rows, loads, load_factor, model), solver)
    if answer.claim is None:
        raise SolverError(f"margin of the safe slip: {answer.solver} calls a problem without optimum that always has one; check the reactions")
    return answer.claim, answer, model


def classify(task: Task, interface: Interface, solver: str | None) -> NoLimit:
    """Decide why there is no finite limit, by the margin of two problems that always have an optimum.

    Raises
    ------
    SolverError
        Neither reason can be proven.
    """
    loads = task.loads
    existence, _, _ = solve_margin(task, interface, loads, None, solver)
    if existence.margin < -TOLERANCE:
        return NoLimit.NO_SAFE_SLIP
    alone = Loads(np.zeros_like(loads.q0), np.zeros_like(loads.p0), loads.q1, loads.p1)
    unit = task.rows(interface).load_unit
    cyclic, _, _ = solve_margin(task, interface, alone, unit, solver)
    if cyclic.margin >= -TOLERANCE:
        return NoLimit.UNBOUNDED
    raise SolverError(
        f"shakedown limit: a solver finds no optimum, yet safe slips exist (margin {existence.margin:.1e}) and the cyclic load alone has none "
        f"(margin {cyclic.margin:.1e}); the loads differ too much in size, or friction is close to the critical value"
    )


def _shortfall(task: Task, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds."""
    q = loads.q0 + load_factor * loads.q1 + task.system.A @ slip
    bound = task.friction * (loads.p0 + load_factor * loads.p1 + task.system.B @ slip)
    return float(max(margin - (bound - np.abs(q)).min() / task.mean_bound, 0.0))
