"""A limit problem in three dimensions as posed: system, load cycle and friction, checked, with the corners that need no rows found out."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import linprog

from ..contact import LoadCycle, friction_coefficients, referee
from ..contact.checks import Array, check_shear
from ..contact.cycle import checked_cycle
from ..contact.system import ContactSystem, checked_system
from ..contact.tolerances import BARE, CONDENSATION, INSIDE, NO_COUPLING, ROUNDING
from .mechanism import Mechanism3D
from .scaling import ConeLoads, ScaledCones, scaled_cones

__all__ = ["ConeQuestion", "pose"]


@dataclass(frozen=True, eq=False)
class ConeQuestion:
    """One friction coefficient on one system and load cycle.

    Attributes
    ----------
    system, cycle, loads
        The contact, its load cycle and the cycle's reactions.
    friction
        (N,) coefficients of friction.
    kept
        The corners that have rows; the others lie in their hull, so that what is safe at the kept ones is safe at all.
    """

    system: ContactSystem
    cycle: LoadCycle
    loads: ConeLoads
    friction: Array
    kept: list[int]

    @property
    def force(self) -> float:
        """Mean normal force of the mean load (or a force of the same size where there is none)."""
        loads = self.loads
        sizes = (np.linalg.norm(loads.q0, axis=-1), np.linalg.norm(loads.q1, axis=-1), np.abs(loads.p1))
        return float(np.abs(loads.p0).mean() or max(part.mean() for part in sizes) or 1.0)

    @property
    def mean_bound(self) -> float:
        """Mean friction bound `f p` under the mean load: the unit of margins (the mean normal force where there is no friction)."""
        bound = float((self.friction * self.loads.p0).mean())
        return bound if bound > CONDENSATION * float((self.friction * np.abs(self.loads.p0)).mean()) else self.force  # a shear alone leaves rounding

    @cached_property
    def cones(self) -> ScaledCones:
        """Unknowns and units."""
        kept = ConeLoads(self.loads.q0, self.loads.p0, self.loads.q1[self.kept], self.loads.p1[self.kept])
        return scaled_cones(self.system.A, self.system.B, self.system.own_stiffness, self.friction, kept, self.force, self.bare[self.kept])

    @cached_property
    def unpressed(self) -> np.ndarray:
        """(N,) whether neither the mean load nor any slip makes a pressure at the node."""
        tangent, normal = np.split(np.sqrt(self.system.own_stiffness), [2 * self.system.nodes])
        alone = (np.abs(self.system.B) <= NO_COUPLING * np.outer(normal, tangent)).all(axis=1)
        return np.asarray(alone & (np.abs(self.loads.p0) <= ROUNDING * self.force))

    @cached_property
    def bare(self) -> np.ndarray:
        """(K, N) where the friction bound of a node vanishes at a corner, whatever the slip and the load factor."""
        p1 = np.abs(self.loads.p1)
        return np.asarray((self.friction == 0) | (self.unpressed & (p1 <= ROUNDING * p1.max(initial=0.0))))

    @cached_property
    def stop(self) -> tuple[Mechanism3D, str] | None:
        """A motion that no slip helps against at any load factor above 0, and why; None where nothing is so plain.

        A node without a bound slips to and fro between two corners whose shears differ; one that nothing presses is lifted by a corner that pulls.
        """
        q1, p1, nodes = self.loads.q1, self.loads.p1, np.arange(self.system.nodes)
        first = self.bare.argmax(axis=0)
        apart = np.linalg.norm(q1 - q1[first, nodes], axis=-1) * self.bare
        pull = np.maximum(-p1, 0.0) * self.unpressed
        moved = np.maximum(apart, pull)
        corner, node = np.unravel_index(int(moved.argmax()), moved.shape)
        if not moved[corner, node] > ROUNDING * max(float(np.abs(q1).max()), float(np.abs(p1).max())):
            return None
        slips, opening = np.zeros(q1.shape), np.zeros(p1.shape)
        if pull[corner, node] > apart[corner, node]:
            opening[corner, node] = 1.0
            return Mechanism3D(slips, opening, self.friction), f"node {node} carries no pressure under the mean load, and the cyclic load lifts it"
        slips[first[node], node] = q1[corner, node] - q1[first[node], node]
        slips[corner, node] = -slips[first[node], node]
        lack = "friction" if self.friction[node] == 0 else "pressure"
        return Mechanism3D(slips, opening, self.friction), f"node {node} has no {lack}, and the cyclic load shears it"

    def slip(self, traction: Array) -> Array:
        """(N, 2) slip of dimensionless tractions, length."""
        c, v = self.cones, self.cones.slip @ traction
        v = v + c.slip @ (traction - self.system.A @ v / (np.tile(c.unit, 2) * c.shear))  # without most of its rounding
        return np.stack(np.split(v, 2), axis=-1)

    def slip_reactions(self, slip: Array) -> tuple[Array, Array]:
        """(N, 2) and (N,) reactions of the closed contact under the mean load and a residual slip."""
        v = slip.T.ravel()
        q, p = self.system.A @ v, self.system.B @ v
        return self.loads.q0 + np.stack(np.split(q, 2), axis=-1), self.loads.p0 + p

    def reactions(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """(K, N, 2) and (K, N) reactions of the closed contact at the corners, under a residual slip."""
        q, p = self.slip_reactions(slip)
        return q + load_factor * self.loads.q1, p + load_factor * self.loads.p1

    def traction_ratios(self, q: Array, p: Array) -> Array:
        """(K, N) ratios `|q| / (f p)` of reactions; NaN where the pressure or the friction vanishes."""
        bound = self.friction * p
        pressed = bound > BARE * self.mean_bound
        return np.where(pressed, np.linalg.norm(q, axis=-1) / np.where(pressed, bound, 1.0), np.nan)

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far the slip is from being safe: the largest violation of the contact law over the corners."""
        q, p = self.reactions(load_factor, slip)
        mean_q, mean_p = self.system.reaction(self.cycle.mean)
        bonded = mean_q + load_factor * self.loads.q1, mean_p + load_factor * self.loads.p1
        closed = np.zeros(self.system.nodes)
        return referee(self.system, bonded, self.friction, v=slip, w=closed, q=q, p=p, force_scale=self.force).residual

    def defect(self, mechanism: Mechanism3D, traction: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

        Counted for all slips whose shear forces are, node by node, at most those of `traction`, or at most `1 + f` times the node's own pressure
        where that is more.
        """
        c = self.cones
        net, lift = mechanism.slips.sum(axis=0).T.ravel() * np.tile(c.unit, 2), mechanism.lift.sum(axis=0) * c.unit
        stress = c.shear * net + c.G.T @ lift
        stress = stress - c.balance.T @ np.linalg.lstsq(c.balance.T, stress)[0] if c.balance.size else stress
        return float(np.abs(stress) @ np.maximum(np.abs(traction), np.tile(1.0 + self.friction, 2) / c.shear))

    @property
    def about_mean(self) -> bool:
        """Whether the corners have the mean load in their hull, so that what is safe at any load factor is so under the mean load alone."""
        points = _amplitudes(self.cycle)
        return _inside(np.zeros(points.shape[1]), points)

    @property
    def left_out(self) -> tuple[str, ...]:
        """What the scene did not need, in words."""
        corners = len(self.loads.q1)
        idle = corners - len(self.kept)
        return (f"corners: {idle} of {corners} are within the hull of the others",) if idle else ()


def pose(system: Any, cycle: Any, friction: Any) -> ConeQuestion:
    """Check a limit problem.

    Raises
    ------
    ModelError
        Wrong types, load cases that the system does not have, bad friction, a mean load whose shear hides its pressure.
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    checked_cycle(cycle)
    loads = ConeLoads(*cycle.mean_reaction(system), *cycle.corner_reactions(system))
    question = ConeQuestion(system, cycle, loads, f, _outer_corners(cycle))
    check_shear(loads.q0, question.force)
    return question


def _outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners that are not in the hull of the others."""
    points = _amplitudes(cycle)
    kept = list(range(len(points)))
    for corner in range(len(points)):
        others = [k for k in kept if k != corner]
        if others and _inside(points[corner], points[others]):
            kept = others
    return kept


def _amplitudes(cycle: LoadCycle) -> Array:
    """(K, cases) amplitudes of the load cases at the corners, each over its largest one."""
    cases = sorted({case for corner in cycle.corners for case in corner})
    points = np.array([[corner.get(case, 0.0) for case in cases] for corner in cycle.corners]).reshape(len(cycle.corners), len(cases))
    largest = np.abs(points).max(axis=0, initial=0.0)
    return points / np.where(largest > 0, largest, 1.0)


def _inside(point: Array, others: Array) -> bool:
    """Whether a point is a mean of others, which is checked on the weights that a linear program finds."""
    found = linprog(np.zeros(len(others)), A_eq=np.vstack([others.T, np.ones(len(others))]), b_eq=np.r_[point, 1.0])
    if found.status != 0:
        return False
    weights = np.maximum(found.x, 0.0)
    return bool(np.abs(weights @ others / weights.sum() - point).max(initial=0.0) <= INSIDE)
