"""A limit problem as posed: system, load cycle and friction, checked, and the part of the contact that is solved for."""

from dataclasses import astuple, dataclass, field
from time import perf_counter

import numpy as np

from ..contact import ContactSystem, LoadCycle, friction_coefficients, referee
from ..contact.checks import Array, check_shear, flag
from ..contact.cycle import checked_cycle
from ..contact.record import Attempt, SolveRecord, WithSlip
from ..contact.show import Plotted
from ..contact.symmetry import Part, halve, whole
from ..contact.system import checked_plane
from ..contact.tolerances import CONDENSATION, RESIDUAL
from ..errors import ModelError
from .mechanism import Mechanism
from .ruling_corners import RulingLoads, ruling_loads
from .scaling import Loads, ScaledContact, scaled_contact
from .slip_bound import SlipBound, scaled_slip_bound

__all__ = ["Answered", "LimitQuestion", "cycle_loads"]

_MOST_CYCLIC = 1e15  # cyclic loads above so many mean normal forces have none of their digits
_LITTLE_FRICTION = 0.01  # below it, the bounds on q keep p >= 0 only to a hundred times their own accuracy


def cycle_loads(system: ContactSystem, cycle: LoadCycle) -> Loads:
    """Reactions of a load cycle on a system.

    Raises
    ------
    ModelError
        Wrong types, or load cases that the system does not have.
    """
    checked_plane(system)
    checked_cycle(cycle)
    return Loads(*cycle.mean_reaction(system), *cycle.corner_reactions(system))


@dataclass(frozen=True, eq=False)
class LimitQuestion:
    """One friction coefficient on one system and load cycle.

    Parameters
    ----------
    system, cycle, loads
        The contact, its load cycle and the cycle's reactions.
    friction
        (N,) coefficients of friction.
    simplify
        Whether half of a mirror-symmetric contact is enough.
    most
        (N,) largest slip; None for no bound.
    started
        When it was posed, for the record.

    Attributes
    ----------
    part
        The part of the contact that is solved for. What is claimed of the whole contact is judged on the whole contact.
    """

    system: ContactSystem
    cycle: LoadCycle
    loads: Loads
    friction: Array
    simplify: bool
    most: Array | None = None
    started: float = field(default_factory=perf_counter)
    part: Part = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "simplify", flag("simplify", self.simplify))
        object.__setattr__(self, "friction", friction_coefficients(self.friction, self.system.nodes))
        reactions = (self.loads.q0, self.loads.p0), (self.loads.q1, self.loads.p1)
        half = halve(self.system, self.friction, reactions, self.most) if self.simplify else None
        object.__setattr__(self, "part", half or whole(self.system))
        check_shear(self.loads.q0, self.force)

    def check_load_factor(self, load_factor: float) -> None:
        """Check that the mean load is not lost in the rounding of the cyclic loads."""
        largest = load_factor / self.force * float(max(np.abs(self.loads.q1).max(), np.abs(self.loads.p1).max()))
        if largest > _MOST_CYCLIC:
            raise ModelError(
                f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean normal force {self.force:.3g} of the mean load, "
                "which is lost in their rounding; give less, or check the units of the load cases"
            )

    def same_input(self, other: "LimitQuestion") -> bool:
        """Whether another question has the same numbers."""
        mine, others = ((task.system.A, task.system.B, task.system.C, task.system.gap, task.friction, *astuple(task.loads)) for task in (self, other))
        return all(np.array_equal(one, another) for one, another in zip(mine, others, strict=True))

    def scaled(self) -> ScaledContact:
        """Unknowns and units of its programs."""
        return scaled_contact(self.part, self.loads.of(self.part), self.force)

    def rows(self, scaled: ScaledContact, loads: Loads | None = None) -> RulingLoads:
        """Right-hand sides of its programs, or those for other loads."""
        return ruling_loads(scaled, (loads or self.loads).of(self.part), self.part.of(self.friction))

    def bound(self, scaled: ScaledContact) -> SlipBound | None:
        """Rows of the slip bound, if there is one."""
        return None if self.most is None else scaled_slip_bound(scaled, self.part.of(self.most))

    def reactions(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` of the closed contact at the corners, under a residual slip."""
        return (
            self.loads.q0 + load_factor * self.loads.q1 + self.system.A @ slip,
            self.loads.p0 + load_factor * self.loads.p1 + self.system.B @ slip,
        )

    def within_bound(self, slip: Array) -> Array:
        """The slip, cut to its bound where it exceeds it by no more than the tolerance of solvers."""
        return slip if self.most is None or self.beyond(slip) > RESIDUAL else np.clip(slip, -self.most, self.most)

    def beyond(self, slip: Array) -> float:
        """By how much the slip exceeds its bound, over the largest slip or bound; at most 0 if it does not."""
        if self.most is None:
            return 0.0
        return float(((np.abs(slip) - self.most) / max(float(self.most.max()), float(np.abs(slip).max()), np.finfo(float).tiny)).max())

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far the slip is from being safe: the largest violation of the contact law over the corners, and the excess over the slip bound."""
        q, p = self.reactions(load_factor, slip)
        mean_q, mean_p = self.system.reaction(self.cycle.mean)
        bonded = mean_q + load_factor * self.loads.q1, mean_p + load_factor * self.loads.p1
        closed = np.zeros(self.system.nodes)
        verdict = referee(self.system, bonded, self.friction, v=slip, w=closed, q=q, p=p, force_scale=self.force)
        return max(verdict.residual, self.beyond(slip))

    @property
    def opening(self) -> bool:
        """Whether there is so little friction somewhere that keeping nodes closed needs rows of its own."""
        return bool(self.friction.min() < _LITTLE_FRICTION)

    @property
    def force(self) -> float:
        """Mean normal force of the mean load (or a force of the same size where there is none), force per depth."""
        loads = self.loads
        return float(np.abs(loads.p0).mean() or max(np.abs(loads.q0).mean(), np.abs(loads.q1).mean(), np.abs(loads.p1).mean()) or 1.0)

    @property
    def mean_bound(self) -> float:
        """Mean friction bound `f p` under the mean load: the unit of margins (the mean normal force where there is no friction)."""
        bound = float((self.friction * self.loads.p0).mean())
        return bound if bound > CONDENSATION * float((self.friction * np.abs(self.loads.p0)).mean()) else self.force  # a shear alone leaves rounding

    def defect(self, scaled: ScaledContact, mechanism: Mechanism, slip: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

        Counted for all slips whose tractions are, node by node, at most those of `slip`, or at most `1 + f` times the node's own pressure where
        that is more; and under a slip bound, for all rigid slides within it.
        """
        stress = mechanism.stress(self.system, self.friction)
        nodes = scaled.loaded
        tractions = np.maximum(np.abs(self.system.A[nodes] @ slip) / scaled.unit[nodes], 1.0 + self.friction[nodes])
        off = float(np.abs(stress @ scaled.part.odd(scaled.slip.T).T) @ tractions)
        if self.most is not None and scaled.rigid.shape[1]:
            rigid = scaled.part.odd(scaled.rigid.T).T
            off += float(np.abs(mechanism.hold @ rigid) @ (np.abs(np.linalg.pinv(rigid)) @ self.most))
        return off

    def record(self, solver: str, attempts: tuple[Attempt, ...], residual: float, left_out: tuple[str, ...]) -> SolveRecord:
        """How the question was answered, now."""
        return SolveRecord(solver, attempts, residual, left_out, perf_counter() - self.started)

    def left_out(self, rows: RulingLoads) -> tuple[str, ...]:
        """What the program leaves out, in words."""
        corners = self.loads.corners
        idle = corners - len(np.union1d(*rows.corners[:2]))
        return (*self.part.left_out, *([f"corners: {idle} of {corners} rule no node"] if idle else []))


class Answered(WithSlip, Plotted):
    """Base of results that answer a limit question by a residual slip at a load factor."""

    load_factor: float
    slip: Array
    _task: LimitQuestion

    @property
    def system(self) -> ContactSystem:
        """The contact."""
        return self._task.system

    @property
    def friction(self) -> Array:
        """(N,) coefficients of friction."""
        return self._task.friction

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the slip at the load factor, force per depth; NaN where it is not finite."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.load_factor, self.slip)
