"""Whether some residual slip presses every node at every corner: without one, no friction is enough."""

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.record import SolveRecord
from ..contact.tolerances import RESIDUAL
from ..solve.solvers import solve
from .answered import Mechanism
from .friction_bounds import safe_set
from .judge import defect
from .question import pose
from .safe_set import SafeSet, ruling

_NO_LEAST_PRESSURE = RESIDUAL  # pressure, over the force scale, that counts as none: it has the error of an answer


def pressing_problem(v: SafeSet, p: cp.Expression, share: Array) -> cp.Problem:
    """Residual slip v under which the least normal reaction p, over all nodes and the corners that rule them, is largest.

    In full, with `force` the mean normal force of the mean load, its `share` in the unit of each node::

        max least   s.t.   p_k >= least force,   least <= 1   where   p_k = p0 + lam p1_k + B v

    The bound is `|v| <= slip_bound`.
    """
    least = cp.Variable(name="least")
    return v.program(cp.Maximize(least), {"pressed": p >= cp.multiply(share, least), "cap": least <= 1})


class Pressing:
    """Solution of a pressing problem, judged from both sides.

    Attributes
    ----------
    least
        The least normal reaction under its slip, in mean normal forces of the mean load, at most 1.
    motion
        Openings for which the loads do work although no residual slip resists them, where `least` is negative.
    residual
        The larger of the distance of `least` from the bound that `motion` proves, and the excess of its slip over the slip bound.
    """

    def __init__(self, v: SafeSet, load_factor: float) -> None:
        task, slip = v.task, v.solved_slip
        p = task.states(load_factor, slip)[3]
        self.least = float(min(p.min() / task.force, 1.0))
        cap, rule = v.cap("cap"), ruling(-task.p0, -task.p1, load_factor)
        opening = np.zeros(task.p1.shape)
        opening[rule] = np.maximum(v.rows["pressed"].dual_value, 0.0) / v.unit
        motion = Mechanism(np.zeros(task.q1.shape), opening, task.friction, v.held()[0])
        opened = float(motion.opening.sum()) * task.force
        self.motion = motion.scaled((1 - cap) / opened if opened > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(task)
        off = defect(v, self.motion, slip)
        gap = abs(cap + resistance - load_factor * drive - self.least) + off  # a defect that closes the gap counts for slips like this one alone
        proves = opened > 0 or cap >= 1 - RESIDUAL  # multipliers that do not add up to one bound nothing
        self.residual = float(np.nan_to_num(max(gap, task.beyond(slip)), nan=np.inf)) if proves else np.inf

    @property
    def impossible(self) -> bool:
        """Whether no slip presses every node at every corner."""
        return self.least < -_NO_LEAST_PRESSURE


def best_pressed(system: ContactSystem, cycle: LoadCycle, load_factor: float, slip_bound: ArrayLike | None) -> tuple[Pressing, SolveRecord]:
    """The slip, within its bound, that presses the nodes best at a load factor.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    task = pose(system, cycle, 0.0, slip_bound=slip_bound)
    v = safe_set(task)
    p = (task.p0 + load_factor * task.p1).min(axis=0)  # of the corner that rules
    v = v.posed(pressing_problem(v, p / v.unit + v.pressure, task.force / v.unit))
    return solve(v.problem, lambda: Pressing(v, load_factor))
