"""The least load factor with a periodic sequence of friction increments from corner to corner in which some node slips to and fro.

One increment leads from each corner of the load cycle to the next, the last one back to the first. Each node sticks, slips along or against +x, or is
open at the end of an increment, with booleans as in `ExactIncrement`. Some node must slip in one increment and come back, by slip or while open, in
another one; amplitudes may be zero, which is where the upper bound of the guaranteed limit lies. All bounds are derived (`PeriodicBounds`).

What this says: below the least such load factor no sequence of these increments dissipates in a periodic state. That is a statement about increments
as long as the way between two corners; the exact path may stop and reverse slip in between. And it is as good as the solver's branching: the bound
is a number from floating-point arithmetic with a feasibility tolerance of 1e-8, no proof in exact arithmetic.
"""

from dataclasses import dataclass, field

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .periodic_bounds import PeriodicBounds, periodic_bounds
from .portable import Portable
from .rows import load_factor_unit
from .solve import least_bound
from .task import Task

__all__ = ["CyclicBound", "cyclic_bound", "cyclic_problem"]

_ROOM = 1e-6  # by this share load factors may exceed the upper bound, which keeps the program feasible
_STATUS = ("forward", "backward", "opened")


@dataclass(frozen=True, eq=False)
class CyclicBound(Portable):
    """What is known from periodic sequences of increments.

    Attributes
    ----------
    load_factor
        No sequence dissipates below it; 0 where nothing is known.
    found
        Least load factor of a sequence that was found, inf where none was.
    status
        What became of the program, in words.
    slips
        (K, N) slips at the corners in the sequence that was found, length; NaN where none was.
    problem
        The mixed-integer program; None where no bounds could be derived, or in a copy.
    """

    load_factor: float
    found: float
    status: str
    slips: Array = field(repr=False)
    problem: cp.Problem | None = field(repr=False)


def cyclic_bound(task: Task, upper: float, most: Array | None, time_limit: float) -> CyclicBound:
    """The least load factor, up to `upper`, of a periodic sequence of increments with dissipation.

    Parameters
    ----------
    task
        System, cycle and friction.
    upper
        Upper bound of the load factors that are looked at.
    most
        (N,) largest slip at the corners; None for no bound.
    time_limit
        Seconds for the mixed-integer program.
    """
    nothing = np.full_like(task.loads.q1, np.nan)
    unit = load_factor_unit(task.loads, task.friction, task.force)
    bounds = periodic_bounds(task, upper * (1 + _ROOM))
    if bounds is None:
        why = "no bound on the reactions can be derived: S is singular (nothing holds the body), friction is too large, or there are too many nodes"
        return CyclicBound(0.0, np.inf, why, nothing, None)
    problem = cyclic_problem(task, bounds, most, upper * (1 + _ROOM) / unit, unit)
    least, found, status = least_bound(problem, time_limit)
    slips = nothing if not np.isfinite(found) else np.asarray(problem.var_dict["slip"].value) * bounds.length
    return CyclicBound(float(min(max(least, 0.0) * unit, upper)), found * unit, status, slips, problem)


def cyclic_problem(task: Task, bounds: PeriodicBounds, most: Array | None, highest: float, unit: float) -> cp.Problem:
    """The mixed-integer program; forces in units of the mean normal force, slips in that over the stiffness scale, load factors in `unit`."""
    n, corners, f = task.system.nodes, task.loads.corners, task.friction
    S = task.system.S / task.system.stiffness_scale
    before = np.roll(np.arange(corners), 1)
    load_factor = cp.Variable(name="load_factor")
    slip, gap = cp.Variable((corners, n), name="slip"), cp.Variable((corners, n), name="gap")
    forward, backward, opened = (cp.Variable((corners, n), boolean=True, name=name) for name in _STATUS)
    returns = cp.Variable(n, boolean=True, name="returns")

    def everywhere(row: Array) -> Array:
        return np.broadcast_to(row, (corners, n))

    mean, cyclic = (
        np.hstack([np.atleast_2d(q), np.atleast_2d(p)]) / task.force for q, p in ((task.loads.q0, task.loads.p0), (task.loads.q1, task.loads.p1))
    )
    r = np.repeat(mean, corners, axis=0) + unit * cyclic * load_factor + cp.hstack([slip, gap]) @ S
    q, p, moved = r[:, :n], r[:, n:], slip - slip[before]
    bound, reach = cp.multiply(everywhere(f), p), everywhere(bounds.slip_high - bounds.slip_low)
    room = everywhere(2 * f * bounds.pressure_high)
    slides = forward + backward
    rows = {
        "load_factor_high": load_factor <= highest,
        "load_factor_not_negative": load_factor >= 0,
        "one_status": slides + opened <= 1,
        "moves_forward": moved <= cp.multiply(reach, forward + opened),
        "moves_backward": -moved <= cp.multiply(reach, backward + opened),
        "slip_low": slip >= everywhere(bounds.slip_low),
        "slip_high": slip <= everywhere(bounds.slip_high),
        "no_overlap": gap >= 0,
        "opens": gap <= cp.multiply(everywhere(bounds.gap_high), opened),
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(everywhere(bounds.pressure_high), 1 - opened),
        "forward_bound": bound + q >= 0,
        "on_forward_bound": bound + q <= cp.multiply(room, 1 - forward - opened),
        "backward_bound": bound - q >= 0,
        "on_backward_bound": bound - q <= cp.multiply(room, 1 - backward - opened),
        "some_node_returns": cp.sum(returns) >= 1,
        "returning_node_slips": returns <= cp.sum(slides, axis=0),
        "returning_node_goes": returns <= cp.sum(forward + opened, axis=0),
        "returning_node_comes_back": returns <= cp.sum(backward + opened, axis=0),
    }
    if most is not None:
        rows["slip_bound"] = cp.abs(slip) <= everywhere(most / bounds.length)
    return cp.Problem(cp.Minimize(load_factor), [row.set_label(name) for name, row in rows.items()])
