"""States of rest with nodes that open and close in each cycle, as a mixed-integer program of what holds at the corners.

The nodes that are open at a corner are switched by booleans. In full, with the corners k in their order round the cycle::

    max lam   s.t.   q_k = q0_k + lam q1_k + A v_k + B^T w_k,   |q_k| <= f p_k,   0 <= p_k <= most_pressure (1 - opened_k)
                     p_k = p0_k + lam p1_k + B v_k + C w_k,     0 <= w_k <= most_gap opened_k
                     |v_k - v_k-1| <= most_slip (opened_k + opened_k-1)

A node that is closed at two corners in a row keeps its slip, one that is open at either may touch down elsewhere. This is necessary for a state of
rest in which each node opens or closes at most once on the way from corner to corner: the largest load factor is an upper bound for this class. It is
not sufficient, for a node may slip between touching down and the next corner: a transient decides.

The largest forces and motions come from the load: with F the sum of all nodal forces of the closed contact at the worst corner, pressures are at most
2 F, and gap and slip are at most what 10 F does to one node alone, over the initial gap. `touches` says whether a solution comes to one of them.
"""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.explain import Units
from .question import LimitQuestion

_PRESSURE, _MOTION = 2.0, 10.0  # see above
_SOFT = 1e-3  # stiffness of a node alone, over the mean one, below which it counts as this
_SMALL = 1e-3  # rows are divided by the node's reactions; by this share of their mean where they are smaller
_TOUCHES = 1 - 1e-6  # share of the largest force or motion from which on a solution touches it


@dataclass(frozen=True, eq=False)
class CornerProgram:
    """The program for load factors up to `units["load_factor"]`, and what it considers up to a largest size: moves, gaps and pressures."""

    problem: cp.Problem
    units: Units
    limited: tuple[tuple[cp.Expression, Array], ...]

    @property
    def touches(self) -> bool:
        """Whether a slip, gap or pressure of the solution comes to the largest one considered."""
        return any(bool((np.abs(size.value) > _TOUCHES * most).any()) for size, most in self.limited)


def corner_program(task: LimitQuestion, least: float, most: float) -> CornerProgram:
    """The program for load factors from `least` to `most` > 0; forces, lengths and load factors are dimensionless."""
    system, (corners, _, n), f, S = task.system, task.r1.shape, task.friction, task.system.S / task.system.stiffness_scale
    at_zero, cyclic = task.r0.reshape(len(task.r0), -1), most * task.r1.reshape(corners, -1)
    largest = np.abs(at_zero).max(axis=0) + np.abs(cyclic).max(axis=0)
    force = float(largest.mean()) or 1.0
    length, whole = force / system.stiffness_scale, float(largest.sum()) / force
    each = np.ones((corners, 1))
    unit = each * np.maximum(np.maximum(largest[:n], largest[n:]) / force, _SMALL)
    moves = each * _MOTION * whole / np.maximum(np.diag(S), _SOFT)
    most_slip, most_gap, most_pressure = moves[:, :n], system.gap / length + moves[:, n:], _PRESSURE * whole / unit

    lam, v, w = cp.Variable(name="load_factor"), cp.Variable((corners, n), name="slip"), cp.Variable((corners, n), name="gap")
    opened = cp.Variable((corners, n), boolean=True, name="opened")
    r = each * at_zero / force + lam * (cyclic / force) + cp.hstack([v, w]) @ S
    q, p = cp.multiply(1 / unit, r[:, :n]), cp.multiply(1 / unit, r[:, n:])
    before = np.roll(np.eye(corners), -1, axis=0).T  # row k takes corner k - 1
    either, moved = opened + before @ opened, v - before @ v
    rows = {
        "forward_bound": cp.multiply(each * f, p) + q >= 0,
        "backward_bound": cp.multiply(each * f, p) - q >= 0,
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(most_pressure, 1 - opened),
        "no_overlap": w >= 0,
        "opens": w <= cp.multiply(most_gap, opened),
        "closed_sticks_forward": moved <= cp.multiply(most_slip, either),
        "closed_sticks_backward": -moved <= cp.multiply(most_slip, either),
        "least": lam >= least / most,
        "most": lam <= 1,
    }
    problem = cp.Problem(cp.Maximize(lam), [row.set_label(name) for name, row in rows.items()])
    units: Units = {"load_factor": most, "slip": length, "gap": length}
    return CornerProgram(problem, units, ((moved, most_slip), (w, most_gap), (p, most_pressure)))
