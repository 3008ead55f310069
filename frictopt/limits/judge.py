"""Judging what stands in a program from both sides: by its slip, and by its mechanism, or under constraints of one's own by all multipliers."""

from dataclasses import replace
from time import perf_counter
from typing import TypeAlias, TypeVar

import numpy as np

from ..contact import FLOOR, RESIDUAL, Array, LimitKind, SolveRecord
from ..errors import SolverError
from ..solve.standard_form import StandardForm
from .answered import Answered, Mechanism
from .parts import on_whole
from .safe_set import SafeSet
from .safe_slip_result import SafeSlip
from .shakedown_result import ShakedownLimit

End: TypeAlias = tuple[float, Array, Mechanism]
"""An end of the safe load factors, a slip that is safe there, and the mechanism that proves it (idle at load factor 0)."""

FAR = 1e3  # the proof that nothing is safe holds for slips at least `1 / FAR / RESIDUAL` times as large as those of the loads


def judged(v: SafeSet, end: End | None = None, *, least: bool = False, above: float = -np.inf) -> ShakedownLimit:
    """Judge the limit that stands in a program, or another end, by the referee, and from above by its mechanism, which is scaled to unit drive.

    At the least safe load factor, which is judged from below, more load helps, so that its mechanism has a negative drive.

    Raises
    ------
    SolverError
        The mechanism proves that no limit is `above` a load factor: however far it is from the best one, no better one is looked for.
    """
    task, sense = v.task, -1 if least else 1
    load_factor, slip, motion = end or (v.solved_load_factor, v.solved_slip, v.motion()[0])
    resistance, drive = motion.work(task)
    if not sense * drive > 0:
        return ShakedownLimit(load_factor, slip, SolveRecord(), task, motion, LimitKind.FINITE, np.inf)
    motion = motion.scaled(sense / drive)
    bound, off = resistance / drive, defect(v, motion, slip)
    if bound + off / FAR / RESIDUAL <= above:
        raise SolverError(f"the limit is at most {bound:g}, so not above {above:g}")
    gap = (abs(bound - load_factor) + off) / max(load_factor, FLOOR * task.load_unit)
    task, slip, motion = on_whole(task, slip, motion)
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), gap), nan=np.inf))
    return ShakedownLimit(load_factor, slip, SolveRecord(residual=residual), task, motion, LimitKind.FINITE, float(bound + sense * off))


def defect(v: SafeSet, motion: Mechanism, slip: Array) -> float:
    """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

    Counted for all slips whose tractions are, node by node, at most those of `slip`, or at most `1 + f` times the node's own pressure where
    that is more; and for rigid slides, which gaps and the slip bound feel, as large as that in `slip` or as the unit of `v.rigid`, or, under a slip
    bound, for all within it.
    """
    task, tangents = v.task, v.task.system.tangents
    shear_unit = np.tile(v.unit, tangents)
    (*slips, lift), along = motion.moves.sum(axis=0), np.zeros(len(shear_unit))
    if motion.hold is not None:
        along -= motion.hold.ravel()
    if task.lift is not None and motion.press is not None:
        along += motion.press.sum(axis=0) @ task.lift
    work = (shear_unit * np.ravel(slips)) @ v.to_shear + (v.unit * lift) @ v.to_pressure + along @ v.to_slip
    carried = np.abs(task.AB[v.loaded] @ slip.T.ravel()) / shear_unit[v.loaded]
    off = float(np.abs(work) @ (np.maximum(carried, 1.0 + np.tile(task.friction, tangents)[v.loaded]) / v.size))
    to_slide = np.linalg.pinv(v.rigid)  # what holds a slide and what a gap presses may balance each other
    slid = np.maximum(np.abs(to_slide @ slip.T.ravel()), 1.0) if task.most is None else np.abs(to_slide) @ np.tile(task.most, tangents)
    return off + float(np.abs(along @ v.rigid) @ slid)


def judged_by_rows(v: SafeSet) -> ShakedownLimit:
    """Judge an answer under constraints, or with an objective, of the user's own by the multipliers of all rows, theirs too."""
    task, load_factor, slip, unit = v.task, v.solved_load_factor, v.solved_slip, v.own.objective_unit or v.task.load_unit
    form = StandardForm(v.problem)
    (value, bound), (task, slip, motion) = form.bounds, on_whole(task, slip, v.motion()[0].scaled(unit))
    residual = float(np.nan_to_num(max(task.violation(load_factor, slip), form.gap, v.own.violation), nan=np.inf))
    record = SolveRecord(residual=residual)
    limit = ShakedownLimit(load_factor, slip, record, task, motion, LimitKind.FINITE, bound * unit, constraints=v.own.names)
    if v.own.objective_unit is None:
        return limit
    why = "no safe residual slip makes the objective larger; the load factor is the one that it chooses, no limit"
    return replace(limit, _why=why, objective=value * unit)


def judged_margin(v: SafeSet, load_factor: float | None) -> SafeSlip:
    """The slip that stands in a program of the margin at a load factor, or (None) at the best one, judged by its reserve, and by its multipliers."""
    task, margin, slip, cap = v.task, float(v.margin.value), v.solved_slip, v.cap("cap")
    at = float(v.load_factor.value) * task.load_unit if load_factor is None else load_factor
    motion, bounds, slips = _weighed(v)
    share = (1 - cap) / slips if slips > 0 and cap < 1 else 0.0
    motion, rate = motion.scaled(share), share * float(np.sum(bounds * task.states(at, slip)[1][:, -1]))
    resistance, drive = motion.work(task)
    if load_factor is None:  # a free load factor >= 0 can only help against a drive below zero
        drive = min(drive, 0.0)
    off = defect(v, motion, slip)
    bound = cap + resistance - at * drive + off
    if not slips > 0 and cap < 1 - RESIDUAL:  # multipliers that do not add up to one bound nothing
        bound = np.inf
    if v.own.rows:
        form = StandardForm(v.problem)
        bound, off = form.bounds[1], form.defect
    gap = abs(bound - off - margin) + off  # a defect that closes the gap counts for slips like this one alone
    whole, every, motion = on_whole(task, slip, motion)
    asked, own = (whole, every) if task.lift is None else (task, slip)  # the reserve of closed nodes, and of gaps, is that of their own question
    pull = float(-asked.states(at, own)[1][:, -1].min() / asked.force) if margin >= 0 else 0.0
    residual = float(np.nan_to_num(max(gap, margin - asked.reserve(at, own), pull, asked.beyond(own), v.own.violation), nan=np.inf))
    if load_factor is None and bound < -RESIDUAL:  # nothing is safe at any load factor: no more is asked, and the upper bound alone proves it
        residual = off / -bound / FAR
    return SafeSlip(at, every, SolveRecord(residual=residual), whole, motion, margin, float(bound), rate, constraints=v.own.names)


def refuted(v: SafeSet) -> ShakedownLimit | None:
    """The claim that nothing is safe at any load factor, by the multipliers with which a solver found that; None where these do not prove it.

    They are a mechanism on which the mean load does work, while more cyclic load does not take it up.
    """
    task = v.task
    if any(part.value is None for row in v.rows.values() for part in row.dual_variables):
        return None
    motion, _, slips = _weighed(v)
    motion, none = motion.scaled(1 / slips if slips > 0 else 0.0), np.zeros(task.r1[0, :-1].T.shape)
    resistance, drive = motion.work(task)
    off = defect(v, motion, none) + task.load_unit * max(-drive, 0.0)
    if not resistance + off < -RESIDUAL or off / -(resistance + off) / FAR > RESIDUAL:
        return None
    record, (whole, _, motion) = SolveRecord(residual=off / -(resistance + off) / FAR), on_whole(task, none, motion)
    return ShakedownLimit(np.nan, np.full(whole.system.slip_shape, np.nan), record, whole, motion, LimitKind.NO_SAFE_SLIP, np.nan)


def _weighed(v: SafeSet) -> tuple[Mechanism, Array, float]:
    """The mechanism that the multipliers of a program stand for, those of the friction bounds, and the weight of a margin of 1 in all rows."""
    motion, bounds = v.motion()
    weight = float((bounds + motion.moves[:, -1] - motion.friction * bounds).sum())
    return motion, bounds, weight * v.task.mean_bound + (0.0 if motion.press is None else float(motion.press.sum()) * v.task.clearance)


A = TypeVar("A", bound=Answered)


def answered(found: tuple[A, SolveRecord], v: SafeSet) -> A:
    """The claim that has passed, with its program and how it was found."""
    (claim, record), task, left_out = found, v.task, [v.idle] * bool(v.idle)
    if task.images is not None:
        which = ["mirror symmetry: the slip is its own image"] * (len(task.images[0]) > 1)
        which += ["nodes that are open under the mean load"] * (task.lift is not None)
        left_out = [f"{', and '.join(which)}, {len(task.friction)} of {task.system.nodes} nodes are in the program", *left_out]
    record = replace(record, left_out=tuple(left_out), seconds=perf_counter() - task.started)
    return replace(claim, record=record, problem=v.problem, _units=v.units)  # type: ignore[call-arg]  # which all that are judged have
