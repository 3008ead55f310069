"""Limit problems of plane contacts: what their linear programs need, and what a solution of one means."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..contact.system import checked_plane
from ..solve.explain import Units
from .loads import Loads
from .mechanism import Mechanism
from .question import LimitQuestion
from .ruling_corners import RulingLoads, ruling_loads
from .safe_set import SafeProblem, SafeSymbols
from .scaling import ScaledContact, scaled_contact
from .slip_bound import SlipBound, scaled_slip_bound

__all__ = ["PlaneProgram", "PlaneQuestion"]


@dataclass(frozen=True, eq=False)
class PlaneQuestion(LimitQuestion):
    """A limit question on a contact in the plane, whose friction bounds are intervals: one corner rules each end of a node's interval."""

    def __post_init__(self) -> None:
        checked_plane(self.system)
        super().__post_init__()

    def scaled(self) -> ScaledContact:
        """Unknowns and units of its programs."""
        return scaled_contact(self.part, self.loads.of(self.part), self.force)

    def rows(self, scaled: ScaledContact, loads: Loads | None = None) -> RulingLoads:
        """Right-hand sides of its programs, or those for other loads."""
        return ruling_loads(scaled, (loads or self.loads).of(self.part), self.part.of(self.friction), self.load_unit, self.mean_bound)

    def symbols(self) -> SafeSymbols:
        """Unknowns and rows of its programs."""
        scaled = self.scaled()
        return SafeSymbols(scaled, self.opening, self.bound(scaled))

    def posed(self, listing: Callable[[SafeSymbols], SafeProblem], loads: Loads | None = None, load_factor: float | None = None) -> "PlaneProgram":
        """A program over its safe slips, under its own loads or others; `load_factor` is the given one where the program has none of its own."""
        return self.with_data(listing(self.symbols()), loads, load_factor)

    def with_data(self, model: SafeProblem, loads: Loads | None = None, load_factor: float | None = None) -> "PlaneProgram":
        """A program compiled before, with its parameters set for this question."""
        rows = self.rows(model.scaled, loads)
        model.set(rows, load_factor)
        return PlaneProgram(self, model, rows)

    def bound(self, scaled: ScaledContact) -> SlipBound | None:
        """Rows of the slip bound, if there is one."""
        return None if self.most is None else scaled_slip_bound(scaled, self.part.of(self.most))


@dataclass(frozen=True, eq=False)
class PlaneProgram:
    """A linear program over safe slips, with the question that it answers and the rows that stand in it."""

    task: PlaneQuestion
    model: SafeProblem
    rows: RulingLoads

    @property
    def problem(self) -> cp.Problem:
        """The cvxpy problem."""
        return self.model.problem

    @property
    def left_out(self) -> tuple[str, ...]:
        """What it leaves out, in words."""
        corners = self.task.loads.corners
        idle = corners - len(np.union1d(*self.rows.corners[:2]))
        return (*self.task.part.left_out, *([f"corners: {idle} of {corners} rule no node"] if idle else []))

    @property
    def units(self) -> Units:
        """Units of its unknowns."""
        scaled = self.model.scaled
        return {"load_factor": self.task.load_unit, "margin": self.task.mean_bound, "traction": scaled.unit[scaled.loaded]}

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its vertex."""
        self.model.refine()

    def value(self, name: str) -> float:
        """Value of a named scalar, dimensionless."""
        return float(self.model.value(name))

    def cap(self, name: str) -> float:
        """Multiplier of a named scalar row."""
        return float(self.model.dual(name))

    @property
    def slip(self) -> Array:
        """(N,) slip of the solution, within its bound."""
        return self.task.within_bound(self.model.slip)

    @property
    def load_factor(self) -> float:
        """The load factor of the solution, >= 0."""
        return max(0.0, self.value("load_factor")) * self.task.load_unit  # in this order -0 becomes 0

    @property
    def weight(self) -> float:
        """Sum of the multipliers of all rows, each times the mean friction bound."""
        return float(sum((dual / self.model.scaled.unit).sum() for dual in self.model.duals)) * self.task.mean_bound

    @property
    def motion(self) -> Mechanism:
        """The mechanism of the whole contact that the multipliers of its part stand for.

        Nodes of one source share its motion. An image slips forward where its source slips backward, and a middle node as far to and fro. A node that
        slips to and fro at one corner opens by friction times that.
        """
        model, part = self.model, self.model.scaled.part
        nodes, motions = len(model.scaled.unit), []
        for dual, corner in zip(model.duals, self.rows.corners, strict=True):
            motion = np.zeros((self.task.loads.corners, nodes))
            motion[corner, np.arange(nodes)] = dual / model.scaled.unit
            motions.append(part.share * part.even(motion))
        (one, other, opening), same = motions, (1 + part.sign) / 2
        forward, backward = same * one + (1 - same) * other, same * other + (1 - same) * one
        opening = opening + self.task.friction * 2 * np.minimum(forward, backward)
        hold = None if model.bound is None else part.share * part.odd(model.hold)
        return Mechanism(forward - backward, opening, self.task.friction, hold)

    def defect(self, motion: Mechanism, slip: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

        Counted for all slips whose tractions are, node by node, at most those of `slip`, or at most `1 + f` times the node's own pressure where
        that is more; and under a slip bound, for all rigid slides within it.
        """
        return defect(self.task, self.model.scaled, motion, slip)

    @property
    def violation(self) -> float:
        """Largest violation of the user's own rows."""
        return self.model.violation()

    @property
    def downward(self) -> "PlaneProgram":
        """The program of the least load factor under the same rows."""
        return replace(self, model=self.model.downward)

    @property
    def narrows(self) -> bool:
        """Whether the cyclic load only narrows the rows, so that what is safe at any load factor is so at 0."""
        rows = self.rows
        least = min(rows.forward.min(), rows.backward.min(), rows.opening.min() if self.task.opening else 0.0)
        return not self.model.own and bool(least >= 0)


def defect(task: PlaneQuestion, scaled: ScaledContact, motion: Mechanism, slip: Array) -> float:
    """See `PlaneProgram.defect`."""
    stress, nodes = motion.stress(task.system), scaled.loaded
    tractions = np.maximum(np.abs(task.system.A[nodes] @ slip) / scaled.unit[nodes], 1.0 + task.friction[nodes])
    off = float(np.abs(stress @ scaled.part.odd(scaled.slip.T).T) @ tractions)
    if task.most is not None and motion.hold is not None and scaled.rigid.shape[1]:
        rigid = scaled.part.odd(scaled.rigid.T).T
        off += float(np.abs(motion.hold @ rigid) @ (np.abs(np.linalg.pinv(rigid)) @ task.most))
    return off
