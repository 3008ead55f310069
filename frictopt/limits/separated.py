"""States of rest with nodes that open and close in each cycle, as a mixed-integer program of what holds at the corners.

The nodes that are open at a corner are switched by booleans. In full, with the corners k in their order round the cycle::

    max lam   s.t.   q_k = q0_k + lam q1_k + A v_k + B^T (w_k - g0),   |q_k| <= f p_k,   0 <= p_k <= most_pressure (1 - opened_k)
                     p_k = p0_k + lam p1_k + B v_k + C (w_k - g0),     0 <= w_k <= most_gap opened_k
                     |v_k - v_k-1| <= most_slip (opened_k + opened_k-1)

A node that is closed at two corners in a row keeps its slip, one that is open at either may touch down elsewhere. This is necessary for a state of
rest in which each node opens or closes at most once on the way from corner to corner: the largest load factor is an upper bound for this class. It is
not sufficient, for a node may slip between touching down and the next corner: a transient decides.

The largest forces and motions come from the load: with F the sum of all nodal forces of the bonded contact at the worst corner, pressures are at most
2 F, and gap and slip are at most what 10 F does to one node alone, over the initial gap. `touches` says whether a solution comes to one of them.
"""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.cycle import reactions
from ..solve.bounds import Bounds, bounds
from ..solve.explain import Units

_PRESSURE, _MOTION = 2.0, 10.0  # see above
_SOFT = 1e-3  # stiffness of a node alone, over the mean one, below which it counts as this
_SMALL = 1e-3  # rows are divided by the node's reactions; by this share of their mean where they are smaller
_TOUCHES = 1 - 1e-6  # share of the largest force or motion from which on a solution touches it


@dataclass(frozen=True, eq=False)
class CornerStates:
    """A load factor with slip and gap (K, N) at the corners, length."""

    load_factor: float
    slip: Array
    gap: Array


@dataclass(frozen=True, eq=False)
class _Corners:
    """A contact at the corners of its load cycle, dimensionless: forces over `force`, lengths over `length`, load factors over `load_unit`.

    Attributes
    ----------
    S
        (2N, 2N) stiffness.
    unscaled, cyclic
        (K, 2N), or (1, 2N) where nothing is fixed, and (K, 2N) bonded reactions.
    friction, gap, unit
        (N,) coefficients of friction, initial gap, and size of each node's reactions, which its rows are divided by.
    most_pressure, most_gap, most_slip
        (N,) see above.
    """

    S: Array
    unscaled: Array
    cyclic: Array
    friction: Array
    gap: Array
    unit: Array
    most_pressure: Array
    most_gap: Array
    most_slip: Array


def corner_problem(contact: _Corners, opened: cp.Variable) -> cp.Problem:
    """The program, with booleans `opened` (K, N); lengths and forces are dimensionless."""
    (corners, n), f = opened.shape, contact.friction[None, :]
    lam, v, w = cp.Variable(name="load_factor"), cp.Variable((corners, n), name="slip"), cp.Variable((corners, n), name="gap")
    least, most = cp.Parameter(nonneg=True, name="least_load_factor"), cp.Parameter(nonneg=True, name="most_load_factor")

    each = np.ones((corners, 1))
    r = np.broadcast_to(contact.unscaled, contact.cyclic.shape) + lam * contact.cyclic + cp.hstack([v, w - each @ contact.gap[None, :]]) @ contact.S
    q, p = r[:, :n] @ np.diag(1 / contact.unit), r[:, n:] @ np.diag(1 / contact.unit)
    before = np.roll(np.eye(corners), -1, axis=0).T  # row k takes corner k - 1
    either, moved = opened + before @ opened, v - before @ v
    rows = {
        "forward_bound": cp.multiply(each @ f, p) + q >= 0,
        "backward_bound": cp.multiply(each @ f, p) - q >= 0,
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(each @ (contact.most_pressure / contact.unit)[None, :], 1 - opened),
        "no_overlap": w >= 0,
        "opens": w <= cp.multiply(each @ contact.most_gap[None, :], opened),
        "closed_sticks_forward": moved <= cp.multiply(each @ contact.most_slip[None, :], either),
        "closed_sticks_backward": -moved <= cp.multiply(each @ contact.most_slip[None, :], either),
        "least": lam >= least,
        "most": lam <= most,
    }
    return cp.Problem(cp.Maximize(lam), [row.set_label(name) for name, row in rows.items()])


class SeparatedProblem:
    """The corner conditions of one contact for load factors up to `most`.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle and (N,) coefficients of friction.
    most
        Largest load factor to consider, above 0.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, friction: Array, most: float) -> None:
        n, unscaled, cyclic = system.nodes, np.hstack(reactions(system, cycle.unscaled)), np.hstack(cycle.corner_reactions(system))
        self.most, self.shape = most, (len(cyclic), n)
        largest = np.abs(unscaled).max(axis=0) + most * np.abs(cyclic).max(axis=0)
        self.force = float(largest.mean()) or 1.0
        self.length = self.force / system.stiffness_scale
        whole = float(largest.sum()) / self.force
        stiff = np.maximum(np.r_[np.diag(system.A), np.diag(system.C)] / system.stiffness_scale, _SOFT)
        size = np.maximum(np.maximum(largest[:n], largest[n:]) / self.force, _SMALL)
        self.contact = _Corners(
            S=system.S / system.stiffness_scale,
            unscaled=unscaled / self.force,
            cyclic=cyclic * most / self.force,
            friction=friction,
            gap=system.gap / self.length,
            unit=size,
            most_pressure=np.full(n, _PRESSURE * whole),
            most_gap=system.gap / self.length + _MOTION * whole / stiff[n:],
            most_slip=_MOTION * whole / stiff[:n],
        )

    @property
    def units(self) -> Units:
        """Units of the variables."""
        return {"load_factor": self.most, "slip": self.length, "gap": self.length}

    def search(self, least: float, most_nodes: int) -> tuple[Bounds, CornerStates | None, cp.Problem]:
        """Bound of the largest load factor from `least` to `most`, the states of its solution, and the mixed-integer program."""
        problem = corner_problem(self.contact, cp.Variable(self.shape, boolean=True, name="opened"))
        answer = self._solve(problem, least, most_nodes)
        return Bounds(answer.bound * self.most, answer.status), self._states(problem) if answer.status.has_solution else None, problem

    def touches(self, states: CornerStates) -> bool:
        """Whether a slip, gap or pressure of a solution comes to the largest one considered."""
        contact, n, lam = self.contact, self.shape[1], states.load_factor / self.most
        v, w = states.slip / self.length, states.gap / self.length
        p = (contact.unscaled + lam * contact.cyclic + np.hstack([v, w - contact.gap]) @ contact.S)[:, n:]
        pairs = (np.abs(v - np.roll(v, 1, axis=0)), contact.most_slip), (w, contact.most_gap), (p, contact.most_pressure)
        return any(bool((value > _TOUCHES * most).any()) for value, most in pairs)

    def _solve(self, problem: cp.Problem, least: float, most_nodes: int) -> Bounds:
        problem.param_dict["least_load_factor"].value, problem.param_dict["most_load_factor"].value = least / self.most, 1.0
        return bounds(problem, most_nodes)

    def _states(self, problem: cp.Problem) -> CornerStates:
        values = {name: np.asarray(variable.value, dtype=np.float64) for name, variable in problem.var_dict.items()}
        gap = np.maximum(values["gap"], 0.0) * self.length
        return CornerStates(float(values["load_factor"]) * self.most, values["slip"] * self.length, gap)
