"""A limit problem as posed: system, load cycle and friction, checked, and the part of the contact that is solved for."""

from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from ..contact import ContactSystem, LoadCycle, friction_coefficients, referee
from ..contact.checks import Array, check_shear, flag
from ..contact.coulomb import lengths
from ..contact.record import Attempt, SolveRecord, WithSlip
from ..contact.show import Plotted, components, places
from ..contact.symmetry import Part, halve, whole
from ..contact.tolerances import BARE, CONDENSATION, RESIDUAL
from ..errors import ModelError
from .loads import Loads, change, load_factor_unit

__all__ = ["Answered", "LimitQuestion"]

_MOST_CYCLIC = 1e15  # cyclic loads above so many mean normal forces have none of their digits
_LITTLE_FRICTION = 0.01  # below it, the bounds on q keep p >= 0 only to a hundred times their own accuracy


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
        Whether to leave out what cannot change the answer: half of a mirror-symmetric contact, corners that others stand for.
    most
        (N,) largest size of the slip; None for no bound.
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
        half = halve(self.system, self.friction, reactions, self.most) if self.simplify and self.system.tangents == 1 else None
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

    def change(self, slip: Array) -> tuple[Array, Array]:
        """Reactions `A v, B v` that a residual slip adds to those of the closed contact."""
        return change(self.system, slip)

    def reactions(self, load_factor: float, slip: Array, loads: Loads | None = None) -> tuple[Array, Array]:
        """(K, N) or (K, N, 2) and (K, N) reactions `q, p` of the closed contact at the corners, under a residual slip."""
        return (loads or self.loads).under_slip(self.system, load_factor, slip)

    def traction_ratios(self, q: Array, p: Array) -> Array:
        """(K, N) ratios `|q| / (f p)` of reactions; NaN where the pressure or the friction vanishes."""
        bound = self.friction * p
        pressed = bound > BARE * self.mean_bound
        return np.where(pressed, lengths(q, p) / np.where(pressed, bound, 1.0), np.nan)

    def within_bound(self, slip: Array) -> Array:
        """The slip, cut to its bound where it exceeds it by no more than the tolerance of solvers."""
        if self.most is None or self.beyond(slip) > RESIDUAL:
            return slip
        if slip.ndim == 1:
            return np.clip(slip, -self.most, self.most)
        size = lengths(slip, self.most)
        return np.asarray((slip.T * (np.minimum(size, self.most) / np.where(size > 0, size, 1.0))).T)

    def beyond(self, slip: Array) -> float:
        """By how much the slip exceeds its bound, over the largest slip or bound; at most 0 if it does not."""
        if self.most is None:
            return 0.0
        size = lengths(slip, self.most)
        return float(((size - self.most) / max(float(self.most.max()), float(size.max()), np.finfo(float).tiny)).max())

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

    @cached_property
    def force(self) -> float:
        """Mean normal force of the mean load, see `Loads`."""
        return self.loads.force

    @cached_property
    def load_unit(self) -> float:
        """Unit of load factors, see `load_factor_unit`."""
        return load_factor_unit(self.loads, self.friction, self.force)

    @property
    def mean_bound(self) -> float:
        """Mean friction bound `f p` under the mean load: the unit of margins (the mean normal force where there is no friction)."""
        bound = float((self.friction * self.loads.p0).mean())
        return bound if bound > CONDENSATION * float((self.friction * np.abs(self.loads.p0)).mean()) else self.force  # a shear alone leaves rounding

    def record(self, solver: str, attempts: tuple[Attempt, ...], residual: float, left_out: tuple[str, ...]) -> SolveRecord:
        """How the question was answered, now."""
        return SolveRecord(solver, attempts, residual, left_out, perf_counter() - self.started)


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
        """(K, N) or (K, N, 2) and (K, N) reactions `q, p` at the corners under the slip at the load factor, force; NaN where it is not finite."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.load_factor, self.slip)

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the slip; NaN where the pressure or the friction vanishes, or without a slip."""
        return self._task.traction_ratios(*self.reactions)

    def _places(self) -> dict[str, Any]:
        """Columns of a table with one row for each node: node, its place, and its slip."""
        return {"node": range(self.system.nodes), **places(self.system), **components("slip", self.slip)}
