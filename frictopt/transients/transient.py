"""The base class of transients: the loads, the state at the start, and scales of forces and slips.

`ExactPath` (`exact/path.py`) and `SteppedPath` (`stepped.py`) follow a transient. Both derive from
this class, which also has the texts of their errors.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ..base import NO_DRIVE, RESIDUAL, Array, Booleans, PerNode, finite_array, finite_number
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    contact_law,
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
"""Statuses of a node. In the plane, slip against +x has the status -1."""
HOLD = "hold the body by supports, press it more, or load it less"
"""The remedy for a body that slides or opens as a whole."""


# Limits of the ratio of the reactions at the start to the largest force of the loads.

# A larger ratio is refused: rounding hides the events (1e30 gave wrong results).
_REFUSED_STRESS = 1e18
# Above this ratio an error names the start as the cause of a large residual.
_SUSPECTED_STRESS = 1e3


@dataclass(frozen=True, eq=False)
class FollowedCycle:
    """A return of a transient: one load cycle, or two, with the states at which it stopped.

    Attributes
    ----------
    before, after, change
        (m,) the states before and after the cycle, in slip scales: slip and gap on the exact path;
        in increments only the slip, because the gap follows from it. `change` is the largest
        difference between the two states.
    work, slid, works
        (N,) work of friction of each node; (N,) path that each node slips while closed, length; and
        the work of all nodes in each load cycle.
    events
        A value that describes the changes of status. The value is equal for two cycles with the
        same changes; on the exact path their order within a segment does not count.
    bonded, u, r
        (T, M) loads, motions `[v, w - g0]` and reactions. On the exact path there is a row for each
        corner at which the load turns, in increments a row after each increment.
    previous
        (T, M) in increments, the motions `u` one increment before each of these states: friction
        opposes the slip from the earlier to the later state. None on the exact path, where slip
        also changes between stops.
    lost
        On the exact path the larger of two errors, relative to the largest energy in the balance:
        the error of the energy balance (work of the loads - work of friction - elastic energy
        gained), and negative work of friction at a node.
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
    """A contact under one load cycle, from an initial slip or from an earlier state.

    See `march` for the path of the load and for the parameters.

    Attributes
    ----------
    mean, corners
        Bonded reactions (M,) of the mean load, and of each corner.
    turns
        Numbers of the corners at which a cycle stops: all corners, or, on the exact path, only the
        corners at which the load turns.
    segments, begun
        Segments of the load path. Each has the bonded reactions at its end, and its name for
        errors. `segments` make up a cycle, and `begun` come before the first whole cycle.
    bonded
        (M,) bonded reactions of the present load.
    visited
        Number of corners visited so far; -1 until the transient reaches the mean load. After a
        start from an earlier state it includes the corners of the cycle before that state.
    nodes
        Number of node pairs, N.
    force, largest
        Scale of the nodal forces, the mean of |p^w| under the mean load; and the largest nodal
        force of all loads.
    length
        Scale of slips: the largest force divided by the stiffness scale.
    scales, unit
        Scales of forces and slips at each node; and the scales (m,) of the state, see
        `FollowedCycle`.
    events, unproven
        Number of changes of status, and how many of them have rates that are not proven to be
        unique.
    far_start
        Whether the stress of the start exceeds the stress of the loads so much that rounding may
        hide the loads.
    engine, steps
        "path" and 0 on the exact path. In increments, the method that solves them, and their number
        from corner to corner.
    started
        Time at which the transient was made, for the record.
    """

    unit: Array
    engine, steps = "path", 0

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: PerNode,
        load_factor: float,
        initial_slip: ArrayLike | None = None,
        initial_state: ContactState | None = None,
    ) -> None:
        self.started = perf_counter()
        self.system = checked_system(system)
        self.cycle = checked_cycle(cycle)
        slip = np.zeros(system.slip_shape)
        if initial_slip is not None:
            slip = finite_array("initial_slip", initial_slip, system.slip_shape)
        self.load_factor = finite_number("load_factor", load_factor, least=0.0)
        self.nodes = n = system.nodes
        self.friction = friction_coefficients(friction, system)
        self.law = contact_law(system, self.friction)

        self.mean, *cyclic = reactions(system, [cycle.mean, *cycle.corners])
        self._cyclic = np.array(cyclic)
        self._unscaled = self.mean
        if cycle.fixed is not None:
            self._unscaled = reactions(system, cycle.unscaled)
        self.corners = list(self._unscaled + self.load_factor * self._cyclic)
        self.turns = list(range(len(self.corners)))

        largest = float(np.abs(self.corners).max())
        self.force = float(np.abs(self.mean[-n:]).mean()) or largest or 1.0
        self.largest = max(self.force, largest)
        self.length = self.largest / system.stiffness_scale
        self.scales = scales(system.S, self.mean, np.array(self.corners), n)

        self.visited = -1
        self.events = 0
        self.unproven = 0
        if initial_state is None:
            self._start_name = "initial_slip"
            start = self._slipped(slip)
        elif initial_slip is not None:
            raise ModelError(
                "initial_slip, initial_state: both are given; a state includes a slip; give one "
                "of the two"
            )
        else:
            self._start_name = "initial_state"
            state = checked_state(initial_state, system, len(self.corners))
            start = self._resumed(state)
        self.far_start = self._start_stress > _SUSPECTED_STRESS

        self.segments = [
            (corner, f"the segment to the corner ({name})")
            for corner, name in zip(self.corners, cycle.corner_names, strict=True)
        ]
        if self.visited < 0:
            self.begun = [(self.mean, "the segment from the initial slip to the mean load")]
        elif self.visited > 0:
            self.begun = self.segments[self.visited :]
        else:
            self.begun = []
        self._begin(*start)

    @abstractmethod
    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        """Begin at a state: `u = [v, w - g0]` and reactions (M,), and (N,) the open nodes."""

    @abstractmethod
    def follow_to(self, bonded: Array, where: str) -> Sequence[Any] | None:
        """Follow the transient in a straight line to other bonded reactions (M,).

        `where` is the name of the segment in errors. SteppedPath returns the states.
        """

    @abstractmethod
    def cycle_on(self, count: int) -> FollowedCycle:
        """Follow `count` load cycles."""

    @abstractmethod
    def at(self, place: Array) -> Self | None:
        """A copy at the same load with another state (m,) in slip scales; None if there is none."""

    def start(self, overload: float | None = None) -> Self:
        """Follow the transient to the first whole cycle, and through one cycle of overload, if any.

        The first whole cycle begins at the mean load, or at the end of the cycle of an earlier
        state. `overload` is the load factor of the overload.
        """
        for segment in self.begun:
            self.follow_to(*segment)
        if overload is None:
            return self
        corners = self._unscaled + overload * self._cyclic
        self.check_near("overload", corners)
        numbers = self.turns
        if self.cycle.fixed is not None:
            # With fixed parts, the corners at which the load turns depend on the load factor.
            numbers = list(range(len(corners)))
        for number in numbers:
            name = self.cycle.corner_names[number]
            self.follow_to(corners[number], f"the overload's segment to the corner ({name})")
        return self

    def follow(self, segments: Iterable[tuple[Array, str]]) -> list[Any]:
        """Follow the transient through some `segments`, and return the states of its increments."""
        return [state for segment in segments for state in self.follow_to(*segment) or ()]

    def forces_there(self, r: Array) -> str:
        """Describe reactions (M,); before the mean load is reached, also diagnose this load."""
        q, p = parted(r, self.system.tangents + 1)
        text = f"there {pressing(self.system, self.friction, q, p, self.force)}"
        if self.visited < 0:
            text += f"; {mean_load_diagnosis(self.system, self.cycle, self.friction)}"
        return text

    def free_body(self, r: Array) -> str:
        """Describe the forces of reactions (M,) on a free body, with the remedy for it."""
        return f"{self.forces_there(r)}; {HOLD}"

    def check_near(self, name: str, stress: ArrayLike) -> float:
        """The ratio of reactions to the loads; ModelError if rounding would hide the loads."""
        ratio = float(np.abs(stress).max()) / self.largest
        if ratio > _REFUSED_STRESS:
            raise ModelError(
                f"{name}: it stresses the contact {ratio:.1e} times as much as the loads, so that "
                f"rounding would hide the loads; give a slip of at most {_REFUSED_STRESS:g} "
                "times, or check the units"
            )
        return ratio

    @property
    def cause_of_rounding(self) -> str:
        """The cause of large rounding errors, as a sentence."""
        if self.far_start:
            return (
                f"{self._start_name}: it stresses the contact {self._start_stress:.1e} times as "
                "much as the loads, so that rounding hides the loads; give a smaller slip"
            )
        return (
            "stiffnesses or loads differ too much in size, or the last closed nodes hardly hold "
            "the bodies: check the units, and whether a body tips"
        )

    def _slipped(self, slip: Array) -> tuple[Array, Array, Booleans]:
        """The state with an initial slip: `u`, reactions and open nodes, of which there are none.

        An artificial load balances it, with q = 0 and the same pressure at every node.
        """
        system, n = self.system, self.nodes
        stress = system.S @ joined(slip, np.zeros(n))
        self._start_stress = self.check_near("initial_slip", stress)
        u = joined(slip, -system.gap)
        r = np.concatenate([np.zeros(len(stress) - n), np.full(n, self.force)])
        self.bonded = r - system.S @ u
        return u, r, np.zeros(n, dtype=bool)

    def _resumed(self, state: ContactState) -> tuple[Array, Array, Booleans]:
        """`u`, reactions and open nodes at an earlier state; ModelError if it violates the law."""
        system, n = self.system, self.nodes
        self.bonded = joined(state.bonded_q, state.bonded_p)
        self.visited = state.next_corner
        u = joined(state.slip, state.gap - system.gap)
        stress = system.S @ u
        self._start_stress = self.check_near("initial_state", np.r_[stress, self.bonded])
        r = self.bonded + stress

        # Either the gap or the pressure of a node is rounding: the smaller one becomes zero.
        opened = state.gap * system.stiffness_scale > r[-n:]
        r[np.tile(opened, len(r) // n)] = 0.0
        u[-n:][~opened] = -system.gap[~opened]

        force = max(self.largest, float(np.abs(self.bonded).max()))
        residual = float(off_law(system, self.law, self.bonded, u, r, force).max())
        if not residual <= RESIDUAL:
            raise ModelError(
                f"initial_state: it violates the contact law by {residual:.1e}; give a state of "
                "this system under this friction, or an initial_slip"
            )
        return u, r, opened


class Scales(NamedTuple):
    """Scales (N,), equal at all nodes that the stiffness connects.

    `mean` is the force of the mean load, `force` the largest force, and `length` the slip under the
    largest force.
    """

    mean: Array
    force: Array
    length: Array


def scales(S: Array, mean: Array, corners: Array, n: int) -> Scales:
    """Scales of n nodes with stiffness `S` under a mean load (M,) and corners (K, M).

    Loads that are rounding relative to the largest one count as zero.
    """
    axes = len(S) // n
    pressure = np.abs(mean[-n:])
    largest = np.abs(corners).reshape(-1, axes, n).max(axis=(0, 1))
    stiffness = np.diag(S).reshape(axes, n).mean(axis=0)
    smallest = NO_DRIVE * max(float(pressure.mean()), float(largest.max())) or 1.0
    result = Scales(np.empty(n), np.empty(n), np.empty(n))
    for piece in _connected_pieces(S, n):
        cyclic = float(largest[piece].max())
        mean_force = max(float(pressure[piece].mean()) or cyclic, smallest)
        force = max(mean_force, cyclic)
        unit = float(stiffness[piece].mean()) or float(stiffness.mean()) or 1.0
        result.mean[piece] = mean_force
        result.force[piece] = force
        result.length[piece] = force / unit
    return result


def _connected_pieces(S: Array, n: int) -> list[Booleans]:
    """Masks (N,) of the nodes of each piece of the contact that the stiffness connects."""
    links = S.reshape(len(S) // n, n, len(S) // n, n)
    if links[:, 0].any(axis=(0, 1)).all():
        # The first node is coupled with all others, as in most contacts: there is one piece.
        return [np.ones(n, dtype=bool)]
    from scipy.sparse.csgraph import connected_components

    count, piece = connected_components((links != 0).any(axis=(0, 2)), directed=False)
    return [piece == number for number in range(count)]
