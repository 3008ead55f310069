"""A transient before its first cycle: its loads, the state that it begins at, and its scales of forces and slips."""

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ..base import NO_DRIVE, RESIDUAL, Array, Booleans, finite_array, finite_number
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    joined,
    off_law,
    parted,
    reactions,
)
from ..contact.diagnosis import pressing
from ..contact.state import checked_state
from ..errors import ModelError
from .statics import mean_load_diagnosis

STICK, SLIP, OPEN = 0, 1, 2
"""Statuses of a node; slip against +x in the plane is -1."""
HOLD = "hold the body by supports, press it more, or load it less"
"""The remedy for a body that slides or opens as a whole."""

# largest initial stress over the loads: with more, rounding hides the events (1e30 gave wrong
# results)
_FAR = 1e18
# initial stress over the loads, above which an error names it as the cause of a large residual
_FAR_START = 1e3


@dataclass(frozen=True, eq=False)
class Cycle:
    """One return of a transient: one load cycle, or two, with the states at which it stopped.

    Attributes
    ----------
    before, after, change
        (m,) what the map of a cycle acts on, in slip scales: slip and gap on the exact path, slip
        in increments, where the gap follows from it; and the largest difference of the two.
    work, slid, works
        (N,) work of friction, and way slid by each closed node, length; and the work in each load
        cycle.
    events
        The same in two cycles where the same nodes slip and open: the changes of status, whose
        order within a segment of the path does not count.
    bonded, u, r
        (T, M) loads, `[v, w - g0]` and reactions: at the corners at which the exact path stops,
        after each increment.
    previous
        (T, M) in increments the states before those, where friction opposes the slip since; None on
        the exact path, which slips between stops.
    lost
        On the exact path the error of the energy balance (work of the loads, less work of friction,
        less elastic energy gained), or negative work of friction at a node, over the largest energy
        in the balance.
    """

    before: Array
    after: Array
    change: float
    work: Array
    slid: Array
    works: list[float]
    events: Hashable
    bonded: Array
    u: Array
    r: Array
    previous: Array | None = None
    lost: float = 0.0


class Transient(ABC):
    """One contact under one load cycle, from an initial slip or from an earlier state.

    The way of the load, and the parameters, are those of `march`.

    Attributes
    ----------
    mean, corners
        Bonded reactions (M,) of the mean load, and of each corner.
    turns
        Numbers of the corners that a cycle stops at.
    legs, begun
        The corners, and the loads before the first whole cycle, each with the words for the way to
        it.
    bonded
        (M,) that of the present load.
    visited
        Number of corners visited so far, from an earlier state those before its next corner, too;
        -1 until the transient reaches the mean load.
    nodes
        Number of node pairs, N.
    force, largest
        Scale of the nodal forces: the mean of |p^w| under the mean load; and the largest nodal
        force of all loads.
    length
        Scale of slips: the largest force over the stiffness scale.
    scales, unit
        The same at each node; and the scales (m,) of what the map of a cycle acts on, see `Cycle`.
    events, unproven
        Number of changes of status, and of those whose rates are not proven to be the only ones.
    far_start
        Whether the start stresses the contact so much more than the loads do that its rounding may
        hide them.
    engine, steps, coarser
        "path", 0 and none for the exact path; how increments are solved, and their numbers from
        corner to corner, of `coarser` ones to tell errors.
    started
        When it was made, for the record.
    """

    unit: Array
    engine, steps = "path", 0
    coarser: Sequence[int] = ()

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
        slip = (
            np.zeros(system.slip_shape)
            if initial_slip is None
            else finite_array("initial_slip", initial_slip, system.slip_shape)
        )
        self.load_factor = finite_number("load_factor", load_factor, least=0.0)
        self.nodes = n = system.nodes
        self.friction = np.array(friction_coefficients(friction, n))
        self.mean, *cyclic = reactions(system, [cycle.mean, *cycle.corners])
        self._cyclic, self._unscaled = (
            np.array(cyclic),
            self.mean if cycle.fixed is None else reactions(system, cycle.unscaled),
        )
        self.corners, self.turns = (
            list(self._unscaled + self.load_factor * self._cyclic),
            list(range(len(cyclic))),
        )
        largest = float(np.abs(self.corners).max())
        self.force = float(np.abs(self.mean[-n:]).mean()) or largest or 1.0
        self.largest = max(self.force, largest)
        self.length, self.scales = (
            self.largest / system.stiffness_scale,
            scales(system.S, self.mean, np.array(self.corners), n),
        )
        self.visited, self.events, self.unproven = -1, 0, 0
        self._start_name = "initial_slip" if initial_state is None else "initial_state"
        if initial_state is None:
            stress = system.S @ joined(slip, np.zeros(n))
            self._start_stress = self.check_near("initial_slip", stress)
            u, r = (
                joined(slip, -system.gap),
                np.concatenate([np.zeros(len(stress) - n), np.full(n, self.force)]),
            )
            self.bonded, start = r - system.S @ u, (u, r, np.zeros(n, dtype=bool))
        elif initial_slip is not None:
            raise ModelError(
                "initial_slip, initial_state: both are given; a state has its own slip, give one of the two"
            )
        else:
            start = self._standing(
                checked_state("initial_state", initial_state, system, len(self.corners))
            )
        self.far_start = self._start_stress > _FAR_START
        self.legs = [
            (corner, f"the segment to the corner ({name})")
            for corner, name in zip(self.corners, cycle.corner_names, strict=True)
        ]
        begun = [(self.mean, "the segment from the initial slip to the mean load")]
        self.begun = (
            begun if self.visited < 0 else self.legs[self.visited :] if self.visited > 0 else []
        )
        self._begin(*start)

    @abstractmethod
    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        """Stand at a state: `u = [v, w - g0]`, reactions, and which nodes are open."""

    @abstractmethod
    def follow_to(self, bonded: Array, where: str) -> Sequence[Any] | None:
        """Follow the transient in a straight line to other bonded reactions (M,), `where` in words; returns the states in increments."""

    @abstractmethod
    def cycle_on(self, count: int) -> Cycle:
        """Follow so many load cycles."""

    @abstractmethod
    def at(self, place: Array) -> Self | None:
        """A copy at the same load, elsewhere: (m,), in slip scales; None if no state stands there."""

    def forces_there(self, r: Array) -> str:
        """The forces of the reactions (M,) of a state; on the way to the mean load also the diagnosis of that."""
        forces = pressing(
            self.system, self.friction, *parted(r, self.system.tangents + 1), self.force
        )
        mean = (
            f"; {mean_load_diagnosis(self.system, self.cycle, self.friction)}"
            if self.visited < 0
            else ""
        )
        return f"there {forces}{mean}"

    def free_body(self, r: Array) -> str:
        """The same, and the remedy for a free body."""
        return f"{self.forces_there(r)}; {HOLD}"

    def follow(self, legs: Iterable[tuple[Array, str]]) -> list[Any]:
        """Follow the transient through some `legs`, see `follow_to`."""
        return [state for leg in legs for state in self.follow_to(*leg) or ()]

    def start(self, overload: float | None = None) -> Self:
        """Follow the transient to the mean load, or from an earlier state to the end of its cycle; then through a cycle at another load factor."""
        for leg in self.begun:
            self.follow_to(*leg)
        if overload is not None:
            corners = self._unscaled + overload * self._cyclic
            self.check_near("overload", corners)
            numbers = self.turns if self.cycle.fixed is None else range(len(corners))
            self.follow(
                (
                    corners[number],
                    f"the overload's segment to the corner ({self.cycle.corner_names[number]})",
                )
                for number in numbers
            )
        return self

    def check_near(self, name: str, stress: ArrayLike) -> float:
        """The ratio of reactions (M,) to the loads; ModelError if they are so large that their rounding hides the loads."""
        most = float(np.abs(stress).max())
        if most > _FAR * self.largest:
            raise ModelError(
                f"{name}: it stresses the contact {most / self.largest:.1e} times as much as the loads, so rounding would hide them; "
                f"give one of at most {_FAR:g} times, or check the units"
            )
        return most / self.largest

    @property
    def cause_of_rounding(self) -> str:
        """The cause of large rounding errors, as a sentence."""
        if self.far_start:
            more = f"{self._start_stress:.1e} times as much as the loads"
            return f"{self._start_name}: it stresses the contact {more}, so rounding hides them; give less"
        return "stiffnesses or loads differ too much in size"

    def _standing(self, begin: ContactState) -> tuple[Array, Array, Booleans]:
        """`u = [v, w - g0]`, reactions and open nodes at an earlier state; ModelError if it violates the contact law."""
        system, n = self.system, self.nodes
        self.bonded, self.visited = joined(begin.bonded_q, begin.bonded_p), begin.next_corner
        u = joined(begin.slip, begin.gap - system.gap)
        stress = system.S @ u
        self._start_stress = self.check_near("initial_state", np.r_[stress, self.bonded])
        r = self.bonded + stress
        opened = (
            begin.gap * system.stiffness_scale > r[-n:]
        )  # of gap and pressure the smaller one is rounding
        r[np.tile(opened, len(r) // n)] = 0.0
        u[-n:][~opened] = -system.gap[~opened]
        residual = float(
            off_law(
                system,
                self.friction,
                self.bonded,
                u,
                r,
                max(self.largest, float(np.abs(self.bonded).max())),
            ).max()
        )
        if not residual <= RESIDUAL:
            raise ModelError(
                f"initial_state: it violates the contact law by {residual:.1e}; give a state of this system under this friction, or an initial_slip"
            )
        return u, r, opened


class Scales(NamedTuple):
    """Scales (N,) that are the same at all nodes which the stiffness joins: force of the mean load, largest force, slip under the largest force."""

    mean: Array
    force: Array
    length: Array


def scales(S: Array, mean: Array, corners: Array, n: int) -> Scales:
    """Scales of n nodes with stiffness `S` under a mean load (M,) and corners (K, M); loads that are rounding beside the largest count as none."""
    shape, p = (len(S) // n, n), mean[-n:]
    largest, stiffness = (
        np.abs(corners).reshape(-1, *shape).max(axis=(0, 1)),
        np.diag(S).reshape(shape).mean(axis=0),
    )
    least = NO_DRIVE * max(float(np.abs(p).mean()), float(largest.max())) or 1.0
    links, number, part = S.reshape(shape * 2), 1, np.zeros(n)
    if not links[:, 0].any(axis=(0, 1)).all():
        from scipy.sparse.csgraph import (
            connected_components,
        )  # here, for a contact in one piece needs none

        number, part = connected_components((links != 0).any(axis=(0, 2)), directed=False)
    found = Scales(np.empty(n), np.empty(n), np.empty(n))
    for k in range(number):
        block = part == k
        most = float(largest[block].max())
        found.mean[block] = mean_force = max(float(np.abs(p[block]).mean()) or most, least)
        found.force[block] = force = max(mean_force, most)
        found.length[block] = force / (
            float(stiffness[block].mean()) or float(stiffness.mean()) or 1.0
        )
    return found
