"""A limit question as data: system, load cycle, friction, open nodes, and all arrays that follow.

`pose` checks the input and computes the arrays of a question with all nodes closed. `with_open` and
`with_friction` compute those of the same question with some nodes open or other friction.
`Question.violation` is the referee: it says how far a residual slip is from being safe.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from inspect import signature
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..base import CONDENSATION, Array, Booleans, Integers, flag, kept
from ..base.checks import per_node
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_law,
    friction_coefficients,
    lengths,
    off_law,
    parted,
    reactions,
)
from ..contact.diagnosis import in_contact
from ..contact.stiffness import following
from ..errors import ModelError

# Largest mean shear force, in mean normal forces: rounding of more would hide the pressure.
_LARGEST_MEAN_SHEAR = 1e6

# Least friction in the unit of a margin of the pressure, which stays finite without friction.
_LEAST_FRICTION_OF_MARGIN = 0.01

# Least force unit of a node, in mean normal forces: answers have errors of this size.
_LEAST_NODE_UNIT = 1e-6


@kept
@dataclass(frozen=True, eq=False)
class Question:
    """A system, a load cycle, friction and open nodes, with the arrays that follow from them.

    N nodes have t tangents each, so that vectors have M = (t + 1) N entries, normal ones last. The
    cycle has K corners. K0 is K if fixed parts of the cycle differ, else 1. O nodes are open.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array  # (N,)
    slip_bound: Array | None  # (N,) length; None without a bound
    open_nodes: Booleans  # (N,) which nodes are open at all corners
    simplify: bool  # whether to leave out corners and rows that cannot change the answer
    started: float  # time at which the question was posed, seconds

    # Reactions of all nodes, all gaps pressed shut: (K0, M) at load factor 0, (K, M) added by 1.
    bonded: tuple[Array, Array]
    fixed: bool  # whether the corners differ at load factor 0
    static: bool  # whether all corners are the same load

    compliance: Array | None  # (M, M) of the open nodes, zero elsewhere; None if all are closed
    S: Array  # (M, M) stiffness of the closed nodes, which the open ones follow without force
    W: Array  # (O, t N) gaps of the open nodes by slip of the closed nodes

    # Reactions of the closed nodes at load factor 0, and those that a load factor of 1 adds.
    r0: Array  # (K0, t + 1, N) force, normal ones last
    r1: Array  # (K, t + 1, N)
    q0: Array  # (K0, N) or (K0, N, 2) shear forces
    p0: Array  # (K0, N) normal forces
    q1: Array  # (K, N) or (K, N, 2)
    p1: Array  # (K, N)
    # Gaps of the open nodes without slip, likewise.
    w0: Array  # (K0, O) length
    w1: Array  # (K, O)

    # Units of the unknowns and of margins.
    force: float  # mean normal force at load factor 0; a force of the same size if it is 0
    mean_bound: float  # mean friction bound at load factor 0; `force` if it is 0
    mean_pressure: Array  # (N,) normal forces whose friction bound is `mean_bound`
    load_unit: float  # load factor at which the cyclic reactions reach the mean friction bound
    node_unit: Array  # (N,) force at each node
    shear_unit: Array  # (N,) shear force at each node
    clearance: float  # gap, length, at which the mean friction bound would close it

    # Files hold the input alone, and the arrays are computed anew.
    KEPT_FIELDS: ClassVar[tuple[str, ...]] = (
        "system",
        "cycle",
        "friction",
        "slip_bound",
        "open_nodes",
        "simplify",
        "started",
    )
    FORMER_NAMES: ClassVar[dict[str, str]] = {"most": "slip_bound", "open": "open_nodes"}

    @classmethod
    def from_kept(cls, fields: Mapping[str, Any]) -> "Question":
        """The question of the fields in a file."""
        system = fields["system"]
        open_nodes = fields["open_nodes"]
        compliance = None
        if open_nodes.any():
            compliance = following(system.S, open_nodes, [*system.bonded.values()])
        bonded = _bonded(system, fields["cycle"])
        return _question(**fields, compliance=compliance, bonded=bonded)

    @property
    def A(self) -> Array:
        """(t N, t N) shear forces by slip."""
        return self.S[: -self.system.nodes, : -self.system.nodes]

    @property
    def B(self) -> Array:
        """(N, t N) normal forces by slip."""
        return self.S[-self.system.nodes :, : -self.system.nodes]

    def loads(self, k: int) -> dict[str, Array]:
        """Reactions q0, p0, q1, p1 and gaps w0, w1 of corner k, by their printed names."""
        suffix = f"[{k}]" if self.fixed else ""
        row = k if self.fixed else 0
        return {
            f"q0{suffix}": self.q0[row],
            f"p0{suffix}": self.p0[row],
            f"q1[{k}]": self.q1[k],
            f"p1[{k}]": self.p1[k],
            f"w0{suffix}": self.w0[row],
            f"w1[{k}]": self.w1[k],
        }

    def carried(self, r: Array) -> Array:
        """(K, t + 1, N) reactions of the closed nodes, from bonded reactions (K, M)."""
        return _carried(self.system, self.open_nodes, self.compliance, r)

    def reactions_of_slip(self, slip: Array) -> tuple[Array, Array]:
        """Reactions `A v, B v` of the closed nodes that a residual slip adds, (N,) or (N, 2)."""
        tangential = self.S[:, : -self.system.nodes]
        return parted(tangential @ slip.T.ravel(), self.system.tangents + 1)

    def slip_at_mean_load(self, slip: Array) -> Array:
        """The slip of the closed nodes, completed by the slip of the open ones at the mean load."""
        if self.compliance is None:
            return slip
        u, _ = Question.states(self, 0.0, slip)  # not those of a LiftOff
        return np.asarray(u[0, :-1].T.reshape(slip.shape))

    def excess_over_slip_bound(self, slip: Array) -> float:
        """Largest excess of the slip over its bound, over the largest size; <= 0 if it has none."""
        if self.slip_bound is None:
            return 0.0
        sizes = np.where(self.open_nodes, 0.0, lengths(slip, self.slip_bound))
        largest = max(float(self.slip_bound.max()), float(sizes.max()), np.finfo(float).tiny)
        return float(((sizes - self.slip_bound) / largest).max())

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions `[v, w]` and reactions `[q, p]` (K, t + 1, N) at the corners, under a slip."""
        axes, nodes = self.system.tangents + 1, self.system.nodes
        S = self.system.S
        closed_slip = np.concatenate([(slip.T * ~self.open_nodes).ravel(), np.zeros(nodes)])
        r = self.bonded[0] + load_factor * self.bonded[1] + S @ closed_slip
        u = np.broadcast_to(closed_slip, r.shape)
        if self.compliance is not None:
            follow = r @ self.compliance
            u = u - follow
            r = (r - follow @ S) * ~np.tile(self.open_nodes, axes)
        return u.reshape(-1, axes, nodes), r.reshape(-1, axes, nodes)

    # Instants are the corners; if nodes open and close in each cycle (`LiftOff`) also the events.

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at all instants, see `states`."""
        return self.states(load_factor, slip)

    def at_instants(self, load_factor: float) -> Array:
        """Bonded reactions at all instants, all gaps pressed shut."""
        return self.bonded[0] + load_factor * self.bonded[1]

    def by_corner(self, moves: Array) -> Array:
        """Motions at the instants, shared out to the corners whose loads act on them."""
        return moves

    @property
    def statuses(self) -> tuple[Booleans, Booleans]:
        """(K, N) or (1, N) which nodes stick at each instant, and which are open; others touch."""
        return ~self.open_nodes[None], self.open_nodes[None]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the instants: their loads."""
        return self.cycle.corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """Node, "opens" or "closes", place between the corners (0 to 1), and loads there."""
        return []

    @property
    def open_share(self) -> Array:
        """(N,) part of the cycle in which each node is open."""
        return self.open_nodes.astype(float)

    @property
    def pattern(self) -> str:
        """The states of the nodes that an answer is about, as a part of a sentence."""
        if self.open_nodes.any():
            return " with these nodes open and the others closed"
        return " with all nodes closed"

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far a slip is from being safe, dimensionless; 0 if it is safe.

        It is the largest violation of the contact law at an instant, or of the slip bound.
        """
        gap = np.pad(self.system.gap, (self.system.tangents * self.system.nodes, 0))
        u, r = (part.reshape(len(part), -1) for part in self.instants(load_factor, slip))
        bonded = self.at_instants(load_factor) + self.system.S @ gap
        off = off_law(self.system, self.friction, bonded, u - gap, r, self.force)
        worst = max(off.max(), self.excess_over_slip_bound(slip))
        return float(np.nan_to_num(worst, nan=np.inf))


def pose(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    *,
    simplify: bool = True,
    slip_bound: Any = None,
    question_name: str = "this question",
) -> Question:
    """Check a limit question and pose it with all nodes closed; ModelError for bad input.

    `slip_bound` is one largest slip, one per node, or None. `question_name` is that of the public
    question, which may know laws other than Coulomb's. A mean load whose shear hides its pressure
    is refused.
    """
    started = perf_counter()
    checked_law(system, question_name)
    checked_cycle(cycle)
    bound = None
    if slip_bound is not None:
        remedy = "it bounds the size of the slip, give a length >= 0, or None for no bound"
        bound = per_node("slip_bound", slip_bound, system.nodes, remedy)
    question = _question(
        system=system,
        cycle=cycle,
        friction=friction_coefficients(friction, system.nodes),
        slip_bound=bound,
        open_nodes=np.zeros(system.nodes, dtype=bool),
        compliance=None,
        simplify=flag("simplify", simplify),
        started=started,
        bonded=_bonded(system, cycle),
    )

    shear = np.linalg.norm(question.r0[:, :-1], axis=1)
    force = question.force
    if shear.max() > _LARGEST_MEAN_SHEAR * force:
        node = int(shear.max(axis=0).argmax())
        raise ModelError(
            f"mean: its shear force at node {node}{in_contact(system, node)} is "
            f"{shear.max() / force:.1e} times the mean normal force {force:.3g}, and rounding of "
            "the one hides the other; press the contact, or check the units of the load cases"
        )
    return question


def with_open(question: Question, open_nodes: Booleans) -> Question | None:
    """The question with some nodes open at all corners; None if the others do not hold them.

    If all nodes are open, only supports can hold them.
    """
    compliance = None
    if open_nodes.any():
        system = question.system
        compliance = following(system.S, open_nodes, [*system.bonded.values()])
        if compliance is None:
            return None
    return _changed(question, open_nodes=open_nodes, compliance=compliance)


def with_friction(question: Question, friction: ArrayLike) -> Question:
    """The question with other friction, posed now; ModelError for bad friction."""
    coefficients = friction_coefficients(friction, question.system.nodes)
    return _changed(question, friction=coefficients, started=perf_counter())


def _changed(question: Question, **changes: Any) -> Question:
    """The question with some of its inputs changed, and all arrays that follow."""
    inputs = signature(_question).parameters
    return _question(**{name: getattr(question, name) for name in inputs} | changes)


def _question(
    *,
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Array,
    slip_bound: Array | None,
    open_nodes: Booleans,
    compliance: Array | None,
    simplify: bool,
    started: float,
    bonded: tuple[Array, Array],
) -> Question:
    """All arrays of a question, one after the other."""
    axes = system.tangents + 1
    static = not any(np.ptp(part, axis=0).any() for part in bonded)

    # The closed nodes, which the open nodes follow without force.
    S = _stiffness_of_closed(system, open_nodes, compliance)
    r0 = _carried(system, open_nodes, compliance, bonded[0])
    r1 = _carried(system, open_nodes, compliance, bonded[1])
    q0, p0 = parted(r0.reshape(len(r0), -1), axes)
    q1, p1 = parted(r1.reshape(len(r1), -1), axes)

    # The gaps of the open nodes.
    rows_of_gaps = np.flatnonzero(open_nodes) + system.tangents * system.nodes
    W = motion_of_open_nodes(system, open_nodes, compliance, rows_of_gaps)
    w0 = _gaps_of_open(bonded[0], open_nodes, compliance)
    w1 = _gaps_of_open(bonded[1], open_nodes, compliance)

    # Units, from the reactions of the closed nodes.
    closed = ~open_nodes
    force = _mean_force(r0, r1, closed)
    mean_bound = _mean_bound(r0, friction, closed, force)
    mean_pressure = mean_bound / np.maximum(friction, _LEAST_FRICTION_OF_MARGIN)
    load_unit = _load_unit(r0, r1, friction, closed, force)
    node_unit = np.where(open_nodes, force, _node_unit(r0, r1, force))

    # In space the cones of friction end at the friction bound, if it is less than the pressure.
    small_cones = (friction > 0) & (friction < 1) & (system.tangents > 1)
    shear_unit = node_unit * np.where(small_cones, friction, 1.0)

    normal_stiffness = float(np.diag(system.C).mean())
    if not normal_stiffness > CONDENSATION * system.stiffness_scale:
        normal_stiffness = system.stiffness_scale
    return Question(
        system=system,
        cycle=cycle,
        friction=friction,
        slip_bound=slip_bound,
        open_nodes=open_nodes,
        simplify=simplify,
        started=started,
        bonded=bonded,
        fixed=len(bonded[0]) > 1,
        static=static,
        compliance=compliance,
        S=S,
        W=W,
        r0=r0,
        r1=r1,
        q0=q0,
        p0=p0,
        q1=q1,
        p1=p1,
        w0=w0,
        w1=w1,
        force=force,
        mean_bound=mean_bound,
        mean_pressure=mean_pressure,
        load_unit=load_unit,
        node_unit=node_unit,
        shear_unit=shear_unit,
        clearance=mean_bound / normal_stiffness,
    )


def _bonded(system: ContactSystem, cycle: LoadCycle) -> tuple[Array, Array]:
    """Bonded reactions (K0, M) at load factor 0, all gaps pressed shut, and (K, M) of the rest."""
    unscaled = cycle.unscaled
    if all(loads == unscaled[0] for loads in unscaled):
        unscaled = unscaled[:1]  # fixed parts that do not differ are a mean load
    shut = system.S[:, -system.nodes :] @ system.gap
    return reactions(system, unscaled) - shut, reactions(system, cycle.corners)


def _stiffness_of_closed(
    system: ContactSystem, open_nodes: Booleans, compliance: Array | None
) -> Array:
    """(M, M) stiffness of the closed nodes, zero elsewhere."""
    if compliance is None:
        return system.S
    opened = np.tile(open_nodes, system.tangents + 1)  # (M,)
    across = system.S[np.ix_(opened, ~opened)]
    follow = compliance[np.ix_(opened, opened)] @ across
    reduced = system.S[np.ix_(~opened, ~opened)] - across.T @ follow
    S = np.zeros_like(system.S)
    S[np.ix_(~opened, ~opened)] = (reduced + reduced.T) / 2
    return S


def _carried(
    system: ContactSystem, open_nodes: Booleans, compliance: Array | None, r: Array
) -> Array:
    """(K, t + 1, N) reactions of the closed nodes, from bonded reactions (K, M)."""
    if compliance is not None:
        r = (r - (r @ compliance) @ system.S) * ~np.tile(open_nodes, system.tangents + 1)
    return r.reshape(len(r), -1, system.nodes)


def motion_of_open_nodes(
    system: ContactSystem, open_nodes: Booleans, compliance: Array | None, rows: Integers
) -> Array:
    """(R, t N) slips or gaps of the open nodes by slips of the closed ones; `rows` (R,) of M."""
    columns = len(system.S) - system.nodes
    if compliance is None:
        return np.zeros((0, columns))
    motion = -(compliance[rows] @ system.S[:, :columns])
    motion[:, np.tile(open_nodes, system.tangents)] = 0.0
    return np.asarray(motion)


def _gaps_of_open(r: Array, open_nodes: Booleans, compliance: Array | None) -> Array:
    """(K, O) gaps of the open nodes under bonded reactions (K, M), if nothing slips."""
    if compliance is None:
        return np.zeros((len(r), 0))
    return np.asarray(-(r @ compliance)[:, -len(open_nodes) :][:, open_nodes])


def _mean_force(r0: Array, r1: Array, closed: Booleans) -> float:
    """Mean normal force at load factor 0; a force of the same size if there is none."""
    if not closed.any():
        return 1.0
    pressure = float(np.abs(r0[:, -1, closed]).mean())
    if pressure:
        return pressure
    shear = np.linalg.norm(r0[:, :-1, closed], axis=1)
    cyclic_shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    cyclic_pressure = np.abs(r1[:, -1, closed])
    return float(max(shear.mean(), cyclic_shear.mean(), cyclic_pressure.mean())) or 1.0


def _mean_bound(r0: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Mean friction bound at load factor 0; `force` if it is rounding, as under a shear alone."""
    if not closed.any():
        return force
    bound = float((friction * r0[:, -1])[:, closed].mean())
    size = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return bound if bound > CONDENSATION * size else force


def _load_unit(r0: Array, r1: Array, friction: Array, closed: Booleans, force: float) -> float:
    """Load factor at which the cyclic reactions reach the mean friction bound."""
    if not closed.any():
        return 1.0
    f = friction[closed]
    shear = np.linalg.norm(r1[:, :-1, closed], axis=1)
    pressure = np.abs(r1[:, -1, closed])
    without_friction = float(pressure[:, f == 0].sum()) / int(closed.sum())
    demand = float(shear.mean() + (f * pressure).mean()) + without_friction
    if not demand > 0:
        return 1.0
    bound = float((friction * np.abs(r0[:, -1]))[:, closed].mean())
    return (bound or force) / demand


def _node_unit(r0: Array, r1: Array, force: float) -> Array:
    """(N,) pressure of each node under the mean load; if it has none, the other forces on it."""
    least = _LEAST_NODE_UNIT * force
    pressure = np.abs(r0[:, -1]).max(axis=0)
    shear = np.linalg.norm(r0[:, :-1], axis=1).max(axis=0)
    cyclic = np.maximum(np.linalg.norm(r1[:, :-1], axis=1), np.abs(r1[:, -1])).max(axis=0)
    others = np.maximum(np.maximum(shear, cyclic), least)
    return np.asarray(np.where(pressure > least, pressure, others))
