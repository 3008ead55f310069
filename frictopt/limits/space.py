"""Limit problems in space: friction bounds are circles, and the corners that lie within the hull of the others need no rows."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import cvxpy as cp
import numpy as np
from scipy.optimize import linprog

from ..contact import LoadCycle
from ..contact.checks import Array
from ..contact.onset import reach
from ..contact.tolerances import CARRIED, INSIDE, NO_COUPLING, ROUNDING
from ..solve.explain import Units
from .cone_scaling import ScaledCones, scaled_cones
from .cones import Circles, ConeProblem
from .loads import Loads
from .mechanism import Mechanism
from .question import LimitQuestion

__all__ = ["ConeProgram", "SpaceQuestion"]


@dataclass(frozen=True, eq=False)
class SpaceQuestion(LimitQuestion):
    """A limit question on a contact in space."""

    def posed(self, listing: Callable[[Circles], ConeProblem], loads: Loads | None = None, load_factor: float | None = None) -> "ConeProgram":
        """A program over its safe slips, under its own loads or others; `load_factor` is the given one where the program has none of its own."""
        cones = self.cones if loads is None else self.cones.under(self._kept(loads))
        return ConeProgram(self, listing(Circles(cones, None if load_factor is None else load_factor / self.load_unit)))

    @cached_property
    def kept(self) -> list[int]:
        """The corners that have rows; the others lie in their hull, so that what is safe at the kept ones is safe at all."""
        return _outer_corners(self.cycle) if self.simplify else list(range(self.loads.corners))

    def _kept(self, loads: Loads) -> Loads:
        return Loads(loads.q0, loads.p0, loads.q1[self.kept], loads.p1[self.kept])

    @cached_property
    def cones(self) -> ScaledCones:
        """Unknowns and units."""
        system, scales = self.system, (self.force, self.load_unit, self.mean_bound)
        stiffness, bare = system.own_stiffness, self.bare[self.kept]
        return scaled_cones(system.A, system.B, stiffness, self.friction, self._kept(self.loads), scales, bare, self.opening)

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
    def stop(self) -> tuple[Mechanism, str] | None:
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
            return Mechanism(slips, opening, self.friction), f"node {node} carries no pressure under the mean load, and the cyclic load lifts it"
        slips[first[node], node] = q1[corner, node] - q1[first[node], node]
        slips[corner, node] = -slips[first[node], node]
        lack = "friction" if self.friction[node] == 0 else "pressure"
        return Mechanism(slips, opening, self.friction), f"node {node} has no {lack}, and the cyclic load shears it"

    def slip(self, traction: Array) -> Array:
        """(N, 2) slip of dimensionless tractions, length."""
        c, v = self.cones, self.cones.slip @ traction
        v = v + c.slip @ (traction - self.system.A @ v / (np.tile(c.unit, 2) * c.shear))  # without most of its rounding
        return np.stack(np.split(v, 2), axis=-1)

    def defect(self, motion: Mechanism, slip: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

        Counted for all slips whose shear forces are, node by node, at most those of `slip`, or at most `1 + f` times the node's own pressure
        where that is more.
        """
        c = self.cones
        units, v = np.tile(c.unit, 2), slip.T.ravel()
        net, lift = motion.slips.sum(axis=0).T.ravel() * units, motion.lift.sum(axis=0) * c.unit
        stress = c.shear * net + c.G.T @ lift
        stress = stress - c.balance.T @ np.linalg.lstsq(c.balance.T, stress)[0] if c.balance.size else stress
        return float(np.abs(stress) @ np.maximum(np.abs(self.system.A @ v / (units * c.shear)), np.tile(1.0 + self.friction, 2) / c.shear))

    @property
    def about_mean(self) -> bool:
        """Whether the corners have the mean load in their hull, so that what is safe at any load factor is so under the mean load alone."""
        points = _amplitudes(self.cycle)
        return _inside(np.zeros(points.shape[1]), points)

    @property
    def left_out(self) -> tuple[str, ...]:
        """What the program leaves out, in words."""
        corners = len(self.loads.q1)
        idle = corners - len(self.kept)
        return (f"corners: {idle} of {corners} are within the hull of the others",) if idle else ()


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """A cone program over safe slips, with the question that it answers."""

    task: SpaceQuestion
    model: ConeProblem

    @property
    def problem(self) -> cp.Problem:
        """The cvxpy problem."""
        return self.model.problem

    @property
    def left_out(self) -> tuple[str, ...]:
        """What it leaves out, in words."""
        return self.task.left_out

    @property
    def units(self) -> Units:
        """Units of its unknowns."""
        return {"load_factor": self.task.load_unit, "margin": self.task.mean_bound, "traction": self.model.cones.traction_unit}

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its active cones."""
        self.model.refine()

    def value(self, name: str) -> float:
        """Value of a named scalar, dimensionless."""
        return float(self.model.problem.var_dict[name].value)

    def cap(self, name: str) -> float:
        """Multiplier of a named scalar row."""
        return self.model.point.caps[name]

    @property
    def slip(self) -> Array:
        """(N, 2) slip of the solution."""
        return self.task.slip(self.model.point.traction)

    @property
    def load_factor(self) -> float:
        """The load factor of the solution, moved to what its slip carries."""
        sense = 1 if isinstance(self.problem.objective, cp.Maximize) else -1
        return max(carried(self.task, self.slip, self.value("load_factor") * self.task.load_unit, sense), 0.0)

    @property
    def weight(self) -> float:
        """Sum of the multipliers of all rows, each times the mean friction bound."""
        return float((self.model.point.weight * self.model.cones.clearance).sum())

    @property
    def motion(self) -> Mechanism:
        """The mechanism of all corners from the multipliers of the kept ones.

        Where the force multiplier of a circle exceeds its slip (a node that carries nothing), friction times the excess opens the node.
        """
        task, point, unit = self.task, self.model.point, self.model.cones.unit
        slips, opening = np.zeros(task.loads.q1.shape), np.zeros(task.loads.p1.shape)
        excess = np.maximum(point.force - np.linalg.norm(point.slips, axis=-1), 0.0)
        slips[task.kept], opening[task.kept] = point.slips / unit[:, None], (point.opening + task.friction * excess) / unit
        return Mechanism(slips, opening, task.friction)

    def defect(self, motion: Mechanism, slip: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero."""
        return self.task.defect(motion, slip)

    @property
    def violation(self) -> float:
        """Largest violation of the user's own rows: there are none."""
        return 0.0

    @property
    def downward(self) -> "ConeProgram":
        """The program of the least load factor under the same rows."""
        return replace(self, model=self.model.downward)

    @property
    def narrows(self) -> bool:
        """Whether the corners have the mean load in their hull, so that what is safe at any load factor is so at 0."""
        return self.task.about_mean


def carried(task: SpaceQuestion, slip: Array, load_factor: float, sense: int) -> float:
    """The load factor, lowered (or raised: sense -1) in closed form to where the slip keeps every node within its circle at every corner.

    Circles count from rounding on: where a node carries nothing, what it can carry is lost in it.
    """
    (q, p), f, q1, p1 = task.reactions(load_factor, slip), task.friction, sense * task.loads.q1, sense * task.loads.p1
    beyond = np.linalg.norm(q, axis=-1) - f * p > CARRIED * task.force
    pulls = task.opening & (p < -CARRIED * task.force) & (p1 < 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        back = np.where(beyond, reach(q, f * p, q1, f * p1), 0.0)
        shut = np.where(pulls, p / -p1, 0.0)
    return load_factor + sense * float(min(np.where(np.isfinite(back), back, 0.0).min(), shut.min(), 0.0))


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
    if np.abs(others.mean(axis=0) - point).max(initial=0.0) <= INSIDE:  # the plain mean, as of corners to and fro
        return True
    found = linprog(np.zeros(len(others)), A_eq=np.vstack([others.T, np.ones(len(others))]), b_eq=np.r_[point, 1.0])
    if found.status != 0:
        return False
    weights = np.maximum(found.x, 0.0)
    return bool(np.abs(weights @ others / weights.sum() - point).max(initial=0.0) <= INSIDE)
