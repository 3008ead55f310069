"""What kind of limit there is and why: proven, never taken from a solver's word."""

from dataclasses import replace
from enum import Enum

import numpy as np

from ..contact.checks import Array
from ..contact.diagnosis import mean_load_diagnosis
from ..solve.solvers import TOLERANCE, Answer, solve
from .mechanism import expand_duals
from .posed import Task
from .ruling_corners import LoadRows
from .safe_set import SafeProblem, margin_problem
from .scaling import Interface, Loads

__all__ = ["LimitKind", "MarginState", "classify", "reason", "solve_margin"]


class LimitKind(Enum):
    """What kind of answer a limit is."""

    FINITE = "the limit is finite: stay below it"
    UNBOUNDED = "there is no limit: check that the corners of the cycle load the contact as they should"
    NO_SAFE_SLIP = "no load factor has a safe residual slip: change the mean load, the friction or the slip bound, see the reason"

    def __repr__(self) -> str:
        return str(self)


class MarginState:
    """Solution of a margin problem: margin, slip, the mechanism of its multipliers, and its residual."""

    def __init__(self, task: Task, rows: LoadRows, loads: Loads, load_factor: float | None, model: SafeProblem) -> None:
        self.margin = float(model.value("margin"))
        self.slip: Array = task.within_bound(model.slip)
        self.load_factor = float(model.value("load_factor")) * rows.load_unit if load_factor is None else load_factor
        motion = expand_duals(model, rows, task.system.nodes, loads.corners)
        cap, slips = float(model.dual("cap")), float(motion.total.sum() + motion.opening.sum()) * task.mean_bound
        self.motion = motion.scaled((1 - cap) / slips if slips > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(loads, task.friction, task.most)
        if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
            drive = min(drive, 0.0)
        self.bound = cap + resistance - self.load_factor * drive + task.defect(model.interface, self.motion, self.slip)
        if not slips > 0 and cap < 1 - TOLERANCE:  # multipliers that do not add up to one bound nothing
            self.bound = np.inf
        shortfall = _shortfall(task, loads, self.load_factor, self.slip, self.margin)
        self.residual = float(np.nan_to_num(max(abs(self.bound - self.margin), shortfall, task.beyond(self.slip)), nan=np.inf))


def solve_margin(
    task: Task, interface: Interface, loads: Loads, load_factor: float | None, solver: str | None
) -> tuple[MarginState, Answer[MarginState], SafeProblem]:
    """Largest margin of a safe slip at a load factor, or (None) at the best one, for the loads given."""
    rows = task.rows(interface, loads)
    model = margin_problem(interface, task.opening, task.bound(interface), free_load_factor=load_factor is None)
    model.set(rows, load_factor)
    model.problem.param_dict["clearance"].value = task.mean_bound / interface.unit

    answer = solve(model, lambda: MarginState(task, rows, loads, load_factor, model), solver)
    return answer.claim, answer, model


def classify(task: Task, interface: Interface, solver: str | None) -> tuple[LimitKind, MarginState] | None:
    """Decide why there is no finite limit, by the margin of two problems that always have an optimum; None if neither reason can be proven."""
    loads = task.loads
    existence, _, _ = solve_margin(task, interface, loads, None, solver)
    if existence.margin < -TOLERANCE:
        return LimitKind.NO_SAFE_SLIP, existence
    alone = Loads(np.zeros_like(loads.q0), np.zeros_like(loads.p0), loads.q1, loads.p1)
    growing = task if task.most is None else replace(task, most=np.zeros_like(task.most))  # a bounded slip cannot grow with the load
    cyclic, _, _ = solve_margin(growing, interface, alone, task.rows(interface).load_unit, solver)
    return (LimitKind.UNBOUNDED, cyclic) if cyclic.margin >= -TOLERANCE else None


def reason(task: Task, kind: LimitKind, load_factor: float) -> str:
    """Why the shakedown limit is what it is, in words."""
    within = "" if task.most is None else " within the slip bound"
    if kind is LimitKind.UNBOUNDED:
        loaded = bool(task.loads.q1.any() or task.loads.p1.any())
        why = "the corners shear no node beyond the friction that they press up" if loaded else "the corners carry no load"
        return f"every load factor has a safe residual slip{within}: {why}"
    if kind is LimitKind.FINITE and load_factor > 0:
        return f"no residual slip{within} is safe above it"
    remedy = "" if task.most is None else "a larger slip_bound may leave one; "
    diagnosis = remedy + mean_load_diagnosis(task.system, task.cycle, task.friction)
    return f"no residual slip{within} is safe at any load factor{' above 0' * (kind is LimitKind.FINITE)}: {diagnosis}"


def _shortfall(task: Task, loads: Loads, load_factor: float, slip: Array, margin: float) -> float:
    """By how much the reserve of the slip falls short of the margin, in mean friction bounds, or a node of a safe slip pulls, in force scales."""
    q = loads.q0 + load_factor * loads.q1 + task.system.A @ slip
    p = loads.p0 + load_factor * loads.p1 + task.system.B @ slip
    reserve = float(min((task.friction * p - np.abs(q)).min(), p.min() if task.opening else np.inf))
    pull = float(-p.min() / task.force) if margin >= 0 else 0.0
    return max(margin - reserve / task.mean_bound, pull, 0.0)
