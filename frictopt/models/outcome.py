"""Why a shakedown problem has no optimum: proven, never taken from a solver's word."""

from enum import Enum

import numpy as np

from ..contact.checks import Array
from .interface import Interface, Loads
from .mechanism import expand_duals
from .rows import LoadRows
from .safe import SafeProblem, margin_problem
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
        cap, slips = float(model.dual("cap")), float(motion.total.sum() + motion.opening.sum()) * task.mean_bound
        self.motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(loads, task.friction)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        self.bound = cap + resistance - self.load_factor * drive + task.defect(interface, self.motion, self.slip)
        if not slips > 0 and cap < 1 - TOLERANCE:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(abs(self.bound - self.margin), shortfall), nan=np.inf))


def solve_margin(
    task: Task, interface: Interface, loads: Loads, load_factor: float | None, solver: str | None
) -> tuple[MarginState, Answer[MarginState], SafeProblem]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given."""
    rows = task.rows(interface, loads)
    model = margin_problem(interface, rows.node, task.opening, free_load_factor=load_factor is None)
    model.set(rows, load_factor)
    model.problem.param_dict["clearance"].value = task.mean_bound / interface.unit[rows.node]

    answer = solve(model, lambda: MarginState(task, interface, rows, loads, load_factor, model), solver)
    return answer.claim, answer, model


def classify(task: Task, interface: Interface, solver: str | None) -> tuple[NoLimit, MarginState] | None:
    """Decide why there is no finite limit, by the margin of two problems that always have an optimum; None if neither reason can be proven."""
    loads = task.loads
    existence, _, _ = solve_margin(task, interface, loads, None, solver)
    if existence.margin < -TOLERANCE:
        return NoLimit.NO_SAFE_SLIP, existence
    alone = Loads(np.zeros_like(loads.q0), np.zeros_like(loads.p0), loads.q1, loads.p1)
    cyclic, _, _ = solve_margin(task, interface, alone, task.rows(interface).load_unit, solver)
    return (NoLimit.UNBOUNDED, cyclic) if cyclic.margin >= -TOLERANCE else None


def _shortfall(task: Task, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds, or a node of a safe slip pulls, in force scales."""
    q = loads.q0 + load_factor * loads.q1 + task.system.A @ slip
    p = loads.p0 + load_factor * loads.p1 + task.system.B @ slip
    reserve = float(min((task.friction * p - np.abs(q)).min(), p.min() if task.opening else np.inf))
    pull = float(-p.min() / task.force) if margin >= 0 else 0.0
    return max(margin - reserve / task.mean_bound, pull, 0.0)
