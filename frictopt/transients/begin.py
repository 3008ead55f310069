"""A transient before its first cycle: its loads, and the state that it begins at."""

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactState, ContactSystem, LoadCycle, Verdict, friction_coefficients, referee
from ..contact.checks import Array, finite_array, finite_number
from ..contact.cycle import checked_cycle
from ..contact.parts import joined, parted
from ..contact.state import checked_state
from ..contact.system import checked_system
from ..contact.tolerances import RESIDUAL
from ..errors import ModelError

__all__ = ["OPEN", "SLIP", "STICK", "Transient"]

STICK, SLIP, OPEN = 0, 1, 2
"""Statuses of a node; slip against +x in the plane is -1."""

_FAR = 1e18  # largest initial stress over the loads: with more, rounding hides the events (1e30 gave wrong results)
_FAR_START = 1e3  # initial stress over the loads, above which an error names it as the cause of a large residual

Start = tuple[Array, Array, np.ndarray[Any, np.dtype[np.bool_]]]


class Transient:
    """One contact under one load cycle, from an initial slip or from an earlier state.

    It begins at an artificial load that carries the initial slip with q = 0 and, at every node, p equal to the mean of |p^w| under the mean load. It
    goes to the mean load, and then visits the corners in their order, again and again. From an earlier state, whose nodes may be open, it goes
    straight on to the corner that comes next.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor of the cycle, >= 0.
    initial_slip
        Slip left from assembly, (N,) or (N, 2), length; None for none.
    initial_state
        An earlier state, instead of a slip.

    Attributes
    ----------
    mean, corners
        Bonded reactions (M,) of the mean load, and of each corner.
    bonded
        (M,) those of the present load.
    visited
        Number of corners visited so far; -1 until the transient reaches the mean load. An earlier state has visited those before its next corner.
    nodes
        Number of node pairs, N.
    force, largest
        Scale of the nodal forces: the mean of |p^w| under the mean load; and the largest nodal force of all loads.
    length
        Scale of slips: the largest force over the stiffness scale.
    started
        When it was made, for the record.

    Raises
    ------
    ModelError
        Bad input.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: ArrayLike,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        initial_state: ContactState | None = None,
    ) -> None:
        self.started = perf_counter()
        self.system, self.cycle = checked_system(system), checked_cycle(cycle)
        slip = np.zeros(system.slip_shape) if initial_slip is None else finite_array("initial_slip", initial_slip, system.slip_shape)
        self.load_factor = finite_number("load_factor", load_factor, least=0.0)
        self.friction = np.array(friction_coefficients(friction, system.nodes))
        self.mean, self._cyclic = joined(*system.reaction(cycle.mean)), joined(*cycle.corner_reactions(system))
        self.corners = self.corners_at(self.load_factor)
        largest = max(float(np.abs(corner).max()) for corner in self.corners)
        self.force = float(np.abs(self.mean[-system.nodes :]).mean()) or largest or 1.0
        self.largest = max(self.force, largest)
        self.nodes, self.length = system.nodes, self.largest / system.stiffness_scale
        self.visited = -1
        if initial_state is None:
            self._start_name = "initial_slip"
            self._start = self._from_slip(slip)
        elif initial_slip is not None:
            raise ModelError("initial_slip, initial_state: both are given; a state has its own slip, give one of the two")
        else:
            self._start_name = "initial_state"
            self._start = self._standing(checked_state("initial_state", initial_state, system, len(self.corners)))

    def corners_at(self, load_factor: float) -> list[Array]:
        """Bonded reactions (M,) at the corners of the cycle under a load factor."""
        return [self.mean + load_factor * corner for corner in self._cyclic]

    def legs(self, cycles: int) -> list[Array]:
        """The loads (M,) that it visits from here to the end of so many whole cycles."""
        begun = [self.mean] if self.visited < 0 else self.corners[self.visited :] if self.visited > 0 else []
        return [*begun, *self.corners * cycles]

    def check_near(self, name: str, stress: Any) -> float:
        """Check that reactions (M,) are not so large that their rounding hides the loads; return their ratio to the loads.

        Raises
        ------
        ModelError
            They are larger than 1e18 times the largest load.
        """
        most = float(np.abs(stress).max())
        if most > _FAR * self.largest:
            raise ModelError(
                f"{name}: it stresses the contact {most / self.largest:.1e} times as much as the loads, so rounding would hide them; "
                f"give one of at most {_FAR:g} times, or check the units"
            )
        return most / self.largest

    @property
    def far_start(self) -> bool:
        """Whether the start stresses the contact so much more than the loads do that its rounding may hide them."""
        return self._start_stress > _FAR_START

    @property
    def cause_of_rounding(self) -> str:
        """The cause of large rounding errors, as a sentence."""
        if self.far_start:
            name, stress = self._start_name, self._start_stress
            return f"{name}: it stresses the contact {stress:.1e} times as much as the loads, so rounding hides them; give less"
        return "stiffnesses or loads differ too much in size"

    def _from_slip(self, slip: Array) -> Start:
        """`u = [v, w - g0]`, reactions and open nodes under the artificial load."""
        n, S = self.nodes, self.system.S
        self._start_stress = self.check_near("initial_slip", S @ joined(slip, np.zeros(n)))
        u, r = joined(slip, -self.system.gap), np.concatenate([np.zeros(len(S) - n), np.full(n, self.force)])
        self.bonded = r - S @ u
        return u, r, np.zeros(n, dtype=bool)

    def _standing(self, begin: ContactState) -> Start:
        """The same at an earlier state.

        Raises
        ------
        ModelError
            It violates the contact law.
        """
        system, n = self.system, self.nodes
        self.bonded, self.visited = joined(begin.bonded_q, begin.bonded_p), begin.next_corner
        u = joined(begin.slip, begin.gap - system.gap)
        stress = system.S @ u
        self._start_stress = self.check_near("initial_state", np.r_[stress, self.bonded])
        r = self.bonded + stress
        opened = begin.gap * system.stiffness_scale > r[-n:]  # of gap and pressure the smaller one is rounding
        r[np.tile(opened, len(r) // n)] = 0.0
        u[-n:][~opened] = -system.gap[~opened]
        verdict = self.judged(u, r, self.bonded, max(self.largest, float(np.abs(self.bonded).max())))
        if not verdict.residual <= RESIDUAL:
            raise ModelError(
                f"initial_state: it violates the contact law by {verdict.residual:.1e} ({verdict}); give a state of this system under this friction, "
                "or an initial_slip"
            )
        return u, r, opened

    def judged(self, u: Array, r: Array, bonded: Array, force: float, previous: Array | None = None) -> Verdict:
        """The referee's verdict on states `u = [v, w - g0]` and reactions, (..., M), under loads; the unit of force; and the slips before them."""
        axes = self.system.tangents + 1
        (v, w), (q, p) = parted(u, axes), parted(r, axes)
        claim = {"v": v, "w": w + self.system.gap, "q": q, "p": p}
        return referee(self.system, parted(bonded, axes), self.friction, **claim, previous_slip=previous, force_scale=force)
