"""Uncoupled contacts whose areas open and close: the question of all states of rest.

If slip changes no pressure (B = 0) and the load factor scales only shear, the normal path is known
before the limit is. The path shows which nodes open and close, and when. In a state of rest the
slip of all nodes at all instants follows from the load factor and from the slip of the nodes that
never open (theory, "Contact areas that move"). `moving_areas` makes the question;
`rest_intervals.py` computes its limit.

The *rim* consists of the nodes of an uncoupled contact that are open at some time. While a rim node
has no pressure, it carries no shear force, and its slip follows the other nodes. While it presses,
it keeps its slip in a state of rest. So if the slip of all other nodes is zero, the slip y of the
rim obeys linear equations::

    z = q + A y,   z = 0 at nodes without pressure,   y constant from closing to opening

The equations have at most one solution. They contain neither friction nor the mean pressure nor the
other nodes. If they have no solution, some node slips in every cycle, because its shear load when
it closes is not its shear load when it opens.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ...base import (
    CONDENSATION,
    NO_COUPLING,
    RESIDUAL,
    ROUNDING,
    Array,
    Booleans,
    Integers,
    kept,
    make_read_only,
    unresisted,
    worst,
)
from ...contact import ContactProducts, off_law
from ..events.lift_off import (
    episodes_of,
    events_of,
    fields_of,
    names_of_instants,
    shares_of_corners,
)
from ..program.question import Question
from .normal_path import (
    NoPath,
    PathPiece,
    Statuses,
    follow,
    normal_path,
    piece_at,
    piece_of_path,
)


@dataclass(frozen=True, eq=False)
class Rim:
    """Slips and shear forces of R rim nodes with t tangents at M instants, if no other node slips.

    Index 0 is the part at load factor 0, index 1 the rate with the load factor. `residual` are the
    shear forces at nodes that open or close; they are zero in a state of rest.
    """

    nodes: Integers  # (R,)
    motion: Array  # (2, M, t, R) length
    shear: Array  # (2, M, t, R) force
    residual: Array  # (2, M, t, R) force


def rim_of(A: Array, shear: Array, statuses: Statuses) -> Rim:
    """The least squares solution of the equations of the rim.

    A (t N, t N) is the tangential stiffness; `shear` (2, M, t, N) are the shear forces without any
    slip. NoPath if the open nodes of some instant are not held.
    """
    tangents, count = shear.shape[2:]
    nodes = np.flatnonzero(statuses.rim)
    entries = (np.arange(tangents)[:, None] * count + nodes).ravel()
    loads = shear[..., nodes]
    stiffness = A[np.ix_(entries, entries)]
    equations = _Equations(stiffness, loads, statuses, nodes)
    slips = equations.solved()
    motion = np.stack([equations.motion(m, slips) for m in range(len(statuses.after))], axis=1)
    forces = loads + (motion @ stiffness).reshape(loads.shape)
    forces *= ~statuses.free[:, None, nodes]
    residual = forces * statuses.touching[:, None, nodes]
    return Rim(nodes, motion.reshape(loads.shape), forces, residual)


class _Equations:
    """The equations of the rim, for the slips of its nodes.

    A node has one slip from each closing to its next opening.
    """

    def __init__(self, A: Array, loads: Array, statuses: Statuses, nodes: Integers) -> None:
        tangents = loads.shape[2]
        opened = ~statuses.before[:, nodes], ~statuses.after[:, nodes]
        numbers = episodes_of(*opened, closed=True)
        counts = numbers.max(axis=0) + 1
        # Columns of the slips: the episodes of the first tangent, then the episodes of the next.
        count = int(counts.sum())
        columns = counts.cumsum() - counts + numbers
        by_tangent = [np.where(numbers < 0, -1, axis * count + columns) for axis in range(tangents)]
        self._count = tangents * count
        self._column = np.concatenate(by_tangent, axis=1)
        self._touching = np.tile(statuses.touching[:, nodes], tangents)
        self._A = A
        self._loads = loads.reshape(*loads.shape[:2], -1)

    def solved(self) -> Array:
        """(unknowns, 2) slips at load factor 0, and their rates with the load factor."""
        parts = [self._forces(m, touching) for m, touching in enumerate(self._touching)]
        rows, constants = (np.vstack(part) for part in zip(*parts, strict=True))
        return np.asarray(np.linalg.lstsq(rows, -constants, rcond=ROUNDING)[0])

    def _forces(self, m: int, touching: Booleans) -> tuple[Array, Array]:
        """Forces at touching nodes: coefficients of the unknown slips, and (rows, 2) constants.

        The nodes without pressure follow the nodes with pressure.
        """
        closed = self._column[m] >= 0
        motions = self._follow(m, self._A[np.ix_(~closed, touching)]).T
        coupling = self._A[touching] - motions @ self._A[~closed]
        force = (self._loads[:, m, touching] - self._loads[:, m, ~closed] @ motions.T).T
        row = np.zeros((len(force), self._count))
        row[:, self._column[m, closed]] = coupling[:, closed]
        return row, force

    def motion(self, m: int, slips: Array) -> Array:
        """(2, t R) slips of the rim at an instant, from the solution of the equations."""
        closed = self._column[m] >= 0
        slip = np.zeros((2, len(closed)))
        slip[:, closed] = slips[self._column[m, closed]].T
        forces = self._loads[:, m, ~closed] + slip @ self._A[:, ~closed]
        slip[:, ~closed] = -self._follow(m, forces.T).T
        return slip

    def _follow(self, m: int, forces: Array) -> Array:
        """Slips of the nodes without pressure under given forces on them."""
        opened = self._column[m] < 0
        return follow(self._A[np.ix_(opened, opened)], forces)


@kept
@dataclass(frozen=True, eq=False, kw_only=True)
class MovingAreas(Question):
    """A question whose normal loads alone open and close nodes in each cycle.

    `open_nodes` never press. Its M instants are the corners, and the places on the cycle where a
    pressure or a gap comes to zero (`normal_path.py`). The arrays inherited from `Question`, apart
    from `open_nodes`, belong to the contact with all nodes closed.
    """

    path: PathPiece
    rim: Rim
    alone: bool  # whether the path comes from `areas_at`, not from `areas_near`
    near: float  # the load factor at which the path was made
    told_at: float  # the load factor for which the places of events are given

    KEPT_FIELDS: ClassVar[tuple[str, ...]] = (*Question.KEPT_FIELDS, "near", "told_at", "alone")

    @classmethod
    def from_kept(cls, fields: Mapping[str, Any]) -> MovingAreas:
        """See `Question.from_kept`."""
        inputs = {name: fields[name] for name in Question.KEPT_FIELDS}
        none_open = np.zeros_like(inputs["open_nodes"])
        question = Question.from_kept({**inputs, "open_nodes": none_open})
        areas_of = areas_at if fields["alone"] else areas_near
        areas = replace(areas_of(question, fields["near"]), told_at=fields["told_at"])
        make_read_only([vars(part) for part in (areas, areas.path, areas.at_instant, areas.rim)])
        return areas

    moves: ClassVar[bool] = True

    @property
    def at_instant(self) -> Statuses:
        """The nodes that press around each instant."""
        return self.path.at_instant

    @cached_property
    def stays(self) -> Booleans:
        """(N,) nodes that never open."""
        stays = np.ones(self.system.nodes, dtype=bool)
        stays[self.rim.nodes] = False
        return stays

    @cached_property
    def entries(self) -> tuple[Integers, Integers]:
        """Indices in A of the nodes that never open, and of the rim."""
        stays = np.tile(self.stays, self.system.tangents)
        return np.flatnonzero(stays), np.flatnonzero(~stays)

    @cached_property
    def rim_compliance(self) -> Array:
        """Compliance of the rim, without free slides of a body whose nodes are all rim nodes."""
        _, rim = self.entries
        return unresisted(self.A[np.ix_(rim, rim)], self.system.own_stiffness[rim])[1]

    @cached_property
    def bonded_at_instants(self) -> Array:
        """(2, M, t + 1, N) bonded reactions at the instants.

        Index 0 is the part at load factor 0, index 1 the rate with the load factor.
        """
        return self.path.loads(self.r0, self.r1)

    @cached_property
    def unsolved(self) -> Array:
        """(2, M, t, R) shear forces by which the rim misses its equations; 0 if only rounding.

        Index 0 is the part at load factor 0, index 1 the rate with the load factor.
        """
        sizes = np.abs(self.bonded_at_instants[:, :, :-1]).max(axis=(1, 2, 3))
        sizes[0] = max(sizes[0], self.force)
        real = np.abs(self.rim.residual) > RESIDUAL * np.reshape(sizes, (2, 1, 1, 1))
        return np.where(real, self.rim.residual, 0.0)

    def slipping(self, part: int) -> int | None:
        """A rim node that slips in each cycle with any friction; None if the equations are solved.

        Part 1: such a node at load factors above 0. Part 0: at load factor 0.
        """
        off = np.abs(self.unsolved[part]).max(axis=(0, 1), initial=0.0)
        return int(self.rim.nodes[off.argmax()]) if off.any() else None

    def slipping_at(self, load_factor: float) -> int | None:
        """A rim node that slips in each cycle at a load factor with any friction, or None."""
        constant, rate = self.unsolved
        off = np.abs(constant + load_factor * rate)
        size = np.abs(constant).max(initial=0.0) + load_factor * np.abs(rate).max(initial=0.0)
        if not off.max(initial=0.0) > RESIDUAL * size:
            return None
        return int(self.rim.nodes[off.max(axis=(0, 1)).argmax()])

    def _states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the M instants, by component, rounding errors included."""
        inner, rim = self.entries
        stuck = slip.T.ravel()[inner]
        follow = -self.rim_compliance @ (self.A[np.ix_(rim, inner)] @ stuck)
        motion = self.rim.motion[0] + load_factor * self.rim.motion[1]
        u = np.zeros((len(self.path.segment), len(self.S)))
        u[:, inner] = stuck
        u[:, rim] = follow + motion.reshape(len(motion), -1)
        u[:, -self.system.nodes :] = self.path.gap[0] + load_factor * self.path.gap[1]
        r = self.at_instants(load_factor) + u @ self.system.S
        return u, r

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the instants; see `Question.instants`."""
        u, r = (part.reshape(-1, *self.r1.shape[1:]) for part in self._states(load_factor, slip))
        return u, r * self.path.presses[:, None]

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the corners."""
        u, r = self.instants(load_factor, slip)
        at_corner = self.path.at_corner
        return u[at_corner], r[at_corner]

    def completed(self, load_factor: float, slip: Array) -> Array:
        """A slip of the nodes that never open, completed by the rim's slip at the last corner."""
        u, _ = self.states(load_factor, slip)
        return u[-1, :-1].T.reshape(slip.shape)

    def at_instants(self, load_factor: float) -> Array:
        """See `Question.at_instants`."""
        at_zero, rate = self.bonded_at_instants
        return np.asarray(at_zero + load_factor * rate).reshape(len(rate), -1)

    @property
    def opened(self) -> tuple[Booleans, Booleans]:
        """See `Question.opened`: the nodes without pressure."""
        return ~self.at_instant.before, ~self.at_instant.after

    @property
    def way(self) -> Array:
        """(M,) places of the instants on the cycle: 2.5 is half way from corner 2 to the next."""
        return self.path.segment + self.path.part(self.told_at)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Loads of the cycle at the corners and events, at load factor 1."""
        corners = len(self.r1)
        segments = [(k, (k + 1) % corners) for k in range(corners)]
        segment = self.path.segment
        weights = shares_of_corners(segments, segment, self.way - segment, corners)
        return names_of_instants(self.cycle, weights)

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """See `Question.events`. A node that carries pressure before an event opens there."""
        return events_of(*self.opened, self.way, self.names)

    @property
    def node_states(self) -> str:
        """See `Question.node_states`."""
        return ", for all openings and closings"

    def violation(self, load_factor: float, slip: Array) -> float:
        """Distance of a slip from being safe, see `Question.violation`.

        The contact law is checked at the instants and half way between them, where a node must not
        have both pressure and gap. A node with pressure must keep its slip.
        """
        u, r = self._states(load_factor, slip)
        bonded = self.at_instants(load_factor) + self.system.pressing_shut(self.system.gap)
        states = np.stack([bonded, u - self.system.opening, r])
        between = (states + np.roll(states, -1, axis=1)) / 2
        loads, motions, reactions = np.concatenate([states, between], axis=1)
        off = off_law(self.system, self.law, loads, motions, reactions, self.force)
        nodes = self.system.nodes
        slid = np.abs(np.roll(u, -1, axis=0) - u)[:, :-nodes].reshape(len(u), -1, nodes)
        pressure = between[2][:, -nodes:]
        pressed = pressure > CONDENSATION * float(np.abs(bonded[:, -nodes:]).max())
        slid_while_pressed = slid.max(axis=1) * pressed
        slid_by_force = float(slid_while_pressed.max()) * self.system.stiffness_scale / self.force
        return worst([off.max(), slid_by_force])


def uncoupled(question: Question) -> bool:
    """Whether slip changes no pressure of the whole contact: B is zero up to rounding.

    Each entry of B is compared with the entries of A that belong to its two nodes.
    """
    system = question.system
    if isinstance(system, ContactProducts):
        # A system that gives only products does not show the entries of B.
        return False
    stiffness = np.sqrt(np.diag(system.A).clip(0.0).reshape(-1, system.nodes).sum(axis=0))
    of_slips = np.tile(stiffness, system.tangents)
    # Row by row, because in a large coupled contact the first row already decides.
    for factor, stiff, row in zip(
        np.maximum(question.friction, 1.0), stiffness, system.B, strict=True
    ):
        if (factor * np.abs(row) > NO_COUPLING * stiff * of_slips).any():
            return False
    return True


def holds_for_all_openings(question: Question) -> bool:
    """Whether slip changes no pressure, Coulomb's law alone holds, and no slip bound is given.

    If so, only the loads decide which nodes press. All nodes must have friction: in an ordinary
    question a node without friction would have to keep its slip. In a state of rest it need not.
    """
    if question.slip_bound is not None or not question.friction.all():
        return False
    return not question.system.capped and uncoupled(question)


def scales_shear_alone(question: Question) -> bool:
    """Whether neither the load factor nor slip changes a pressure (`holds_for_all_openings`)."""
    normal = np.abs(question.bonded[1][:, -question.system.nodes :]).max()
    if normal > ROUNDING * np.abs(question.bonded[1]).max():
        return False
    return holds_for_all_openings(question)


def has_all_states(question: Question) -> bool:
    """Whether all states of rest have the pressures of this question.

    They do if the load factor scales only shear, and each closed node always has pressure.
    """
    if question.events or question.moves:
        return isinstance(question, MovingAreas) and question.alone
    if not scales_shear_alone(question):
        return False
    pressure = question.r0[:, -1]
    pressed = pressure + np.roll(pressure, -1, axis=0) > CONDENSATION * question.force
    return bool((pressed | question.open_nodes).all())


def moving_areas(question: Question) -> MovingAreas | None:
    """The question of all states of rest, if normal loads alone open and close nodes.

    None if this question does not apply and the ordinary questions are used instead: the contact is
    not covered by `scales_shear_alone`, no node opens or closes, or nothing holds the open nodes.
    """
    if question.r0[:, -1].min() > 0 or not scales_shear_alone(question):
        return None
    return areas_if_moving(question, 0.0)


def areas_if_moving(question: Question, load_factor: float) -> MovingAreas | None:
    """The areas at one load factor; None if no node opens or closes, or if none are found."""
    try:
        areas = areas_at(question, load_factor)
    except NoPath:
        return None
    return areas if areas.at_instant.touching.any() else None


def areas_at(question: Question, load_factor: float) -> MovingAreas:
    """The areas at one load factor. NoPath if nothing holds the open nodes.

    If the load factor scales only shear, these areas hold at every load factor.
    """
    corners = (question.r0 + load_factor * question.r1)[:, -1]
    path = piece_of_path(normal_path(question.system.C, corners))
    return _areas(question, path, True, load_factor)


def areas_near(question: Question, load_factor: float) -> MovingAreas:
    """The areas as functions of the load factor, in the piece around a load factor above 0.

    The loads at load factor 0 must be the same at all corners. NoPath if nothing holds the open
    nodes.
    """
    at_zero, scaled = question.r0[0, -1], question.r1[:, -1]
    path = piece_at(question.system.C, at_zero, scaled, load_factor)
    return _areas(question, path, False, load_factor)


def _areas(question: Question, path: PathPiece, alone: bool, near: float) -> MovingAreas:
    shear = path.loads(question.r0, question.r1)[:, :, :-1]
    rim = rim_of(question.A, shear, path.at_instant)
    fields = fields_of(question) | {"open_nodes": ~path.at_instant.after.any(axis=0)}
    return MovingAreas(**fields, path=path, rim=rim, alone=alone, near=near, told_at=near)
