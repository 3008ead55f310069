"""Whether some residual slip presses every node at every corner: without one, no friction is enough."""

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.tolerances import NO_LEAST_PRESSURE, RESIDUAL
from ..solve.solvers import Answer, solve
from .loads import cycle_loads
from .plane import PlaneProgram, PlaneQuestion
from .safe_set import SafeProblem, SafeSymbols

__all__ = ["Pressing", "best_pressed", "pressing_problem"]


def pressing_problem(v: SafeSymbols) -> SafeProblem:
    """Residual slip v under which the least normal reaction, over all nodes and corners k, is largest.

    In full, with `force` the mean normal force of the mean load, and the corner that rules each node standing for all of them::

        max least   s.t.   p_k >= least force,   least <= 1   where   p_k = p0 + lam p1_k + B v

    The bound is `abs(v) <= slip_bound`.
    """
    least, share = cp.Variable(name="least"), cp.Parameter(v.p.size, nonneg=True, name="share")
    return v.problem(cp.Maximize(least), {"no_opening": v.p >= v.opening + cp.multiply(share, least), "cap": least <= 1})


class Pressing:
    """Solution of a pressing problem, judged from both sides.

    Attributes
    ----------
    least
        The least normal reaction under its slip, in mean normal forces of the mean load, at most 1.
    friction
        Coefficient of friction with which its slip is safe; inf where a node carries no pressure.
    motion
        Openings for which the loads do work although no residual slip resists them, where `least` is negative.
    residual
        The larger of the distance of `least` from the bound that `motion` proves, and the excess of its slip over the slip bound.
    """

    def __init__(self, program: PlaneProgram, load_factor: float) -> None:
        task, slip = program.task, program.slip
        q, p = task.reactions(load_factor, slip)
        self.least = float(min(p.min() / task.force, 1.0))
        self.friction = float((np.abs(q) / p).max()) if self.least > NO_LEAST_PRESSURE else np.inf
        motion, cap = program.motion, program.cap("cap")
        opened = float(motion.opening.sum()) * task.force
        self.motion = motion.scaled((1 - cap) / opened if opened > 0 and cap < 1 else 0.0)
        resistance, drive = self.motion.work(task.loads, task.most)
        defect = program.defect(self.motion, slip)
        gap = abs(cap + resistance - load_factor * drive - self.least) + defect  # a defect that closes the gap counts for slips like this one alone
        proves = opened > 0 or cap >= 1 - RESIDUAL  # multipliers that do not add up to one bound nothing
        self.residual = float(np.nan_to_num(max(gap, task.beyond(slip)), nan=np.inf)) if proves else np.inf

    @property
    def impossible(self) -> bool:
        """Whether no slip presses every node at every corner."""
        return self.least < -NO_LEAST_PRESSURE


def best_pressed(system: ContactSystem, cycle: LoadCycle, load_factor: float, most: Array | None) -> Answer[Pressing]:
    """The slip, of at most `most`, (N,), that presses the nodes best at a load factor.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    task = PlaneQuestion(system, cycle, cycle_loads(system, cycle), np.zeros(system.nodes), True, most)
    program = task.posed(pressing_problem, load_factor=load_factor)
    program.problem.param_dict["share"].value = task.force / program.model.scaled.unit
    return solve(program, lambda: Pressing(program, load_factor))
