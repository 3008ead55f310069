"""A limit question as data: system, load cycle, friction, open nodes, and all arrays that follow.

`pose` checks the input and computes the arrays of a question with all nodes closed. `with_open` and
`with_friction` change the open nodes or the friction, and compute the arrays anew.
`Question.violation` checks answers: it measures how far a residual slip is from being safe.
`units_of` computes the units of the unknowns, `outer_corners` and `ruling` the corners that matter.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
import scipy  # its parts are imported when they are used

from ...base import (
    CONDENSATION,
    RESIDUAL,
    ROUNDING,
    Array,
    Booleans,
    Integers,
    PerNode,
    flag,
    kept,
    make_read_only,
    unresisted,
    worst,
)
from ...base.checks import per_node
from ...contact import (
    ContactLaw,
    ContactSystem,
    LoadCycle,
    amplitudes_of,
    checked_cycle,
    checked_law,
    contact_law,
    friction_coefficients,
    joined,
    lengths,
    off_law,
    parted,
    reactions,
)
from ...contact.diagnosis import in_contact
from ...errors import ModelError
from ...solve.solvers import LP, SOCP, solver_order

# One file because all arrays of a question, and their units, follow from each other.


@kept
@dataclass(frozen=True, eq=False)
class Question:
    """A system, a load cycle, friction and open nodes, with the arrays that follow from them.

    N nodes have t tangents each, so that vectors have M = (t + 1) N entries, normal ones last. The
    cycle has K corners. O nodes are open.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array  # (N,)
    slip_bound: Array | None  # (N,) length; None without a bound
    open_nodes: Booleans  # (N,) which nodes are open at all corners
    simplify: bool  # whether to leave out corners and rows that cannot change the answer
    solver: str | None  # name of the solver of its programs; None: all are tried
    started: float  # time at which the question was posed, seconds

    # (K, M) reactions of all nodes with all gaps pressed shut: at load factor 0, and of the scaled
    # loads at load factor 1.
    bonded: tuple[Array, Array]
    fixed: bool  # whether the corners differ at load factor 0
    static: bool  # whether all corners have the same load

    compliance: Array | None  # (M, M) of the open nodes, zero elsewhere; None if all are closed

    # The forces of a closed node are q and p. For an open node, q, which is 0, and the gap w take
    # their place. In the order of S, these forces are linear in the load factor and in the slips of
    # the closed nodes.
    start: Array  # (K, M) forces without slip at load factor 0
    rate: Array  # (K, M) forces that a load factor of 1 adds

    # Reactions of the closed nodes: index 0 at load factor 0, index 1 of the scaled loads.
    r0: Array  # (K, t + 1, N) force, normal ones last
    r1: Array  # (K, t + 1, N)
    q1: Array  # (K, N) or (K, N, 2) shear forces
    p1: Array  # (K, N) normal forces

    # Units of the unknowns and of margins.
    force: float  # mean normal force at load factor 0; if it is 0, the largest mean of other forces
    mean_bound: float  # mean friction bound at load factor 0; `force` if it is 0
    mean_pressure: Array  # (N,) normal forces whose friction bound is `mean_bound`
    load_unit: float  # load factor at which the cyclic reactions reach the mean friction bound
    node_unit: Array  # (N,) force at each node
    shear_unit: Array  # (N,) shear force at each node
    clearance: float  # unit of gaps, length: to close such a gap takes a force of `mean_bound`

    # Files hold only the input, and the arrays are computed anew.
    KEPT_FIELDS: ClassVar[tuple[str, ...]] = (
        "system",
        "cycle",
        "friction",
        "slip_bound",
        "open_nodes",
        "simplify",
        "started",
    )

    @classmethod
    def from_kept(cls, fields: Mapping[str, Any]) -> "Question":
        """The question, from the fields that a file holds."""
        system = fields["system"]
        compliance = _compliance(system, fields["open_nodes"])
        bonded = _bonded(system, fields["cycle"])
        question = _question(**fields, solver=None, compliance=compliance, bonded=bonded)
        make_read_only(vars(question))
        return question

    @cached_property
    def listed_corners(self) -> list[int]:
        """Corners whose rows imply the rows of all others; without `simplify`, all corners."""
        if self.simplify:
            return outer_corners(self.cycle)
        return list(range(len(self.r1)))

    @cached_property
    def law(self) -> ContactLaw:
        """The contact law with the friction of the question."""
        return contact_law(self.system, self.friction)

    @cached_property
    def S(self) -> Array:
        """(M, M) stiffness of the closed nodes, zero elsewhere; open nodes are free of force."""
        if self.compliance is None:
            return self.system.S
        opened = np.tile(self.open_nodes, self.system.tangents + 1)  # (M,)
        S = np.zeros_like(self.system.S)
        coupling = self.system.S[np.ix_(opened, ~opened)]
        follow = self.compliance[np.ix_(opened, opened)] @ coupling
        reduced = self.system.S[np.ix_(~opened, ~opened)] - coupling.T @ follow
        S[np.ix_(~opened, ~opened)] = (reduced + reduced.T) / 2
        return S

    @cached_property
    def A(self) -> Array:
        """(t N, t N) stiffness matrix: shear forces due to unit slips."""
        return self.S[: -self.system.nodes, : -self.system.nodes]

    @cached_property
    def B(self) -> Array:
        """(N, t N) stiffness matrix: normal forces due to unit slips."""
        return self.S[-self.system.nodes :, : -self.system.nodes]

    @cached_property
    def response(self) -> Array:
        """(M, t N) forces due to unit slips of the closed nodes."""
        slips = len(self.S) - self.system.nodes
        response = self.S[:, :slips]
        if self.compliance is not None:
            response = response.copy()
            rows = slips + np.flatnonzero(self.open_nodes)
            response[rows] = self.motions_of_open(rows)
        return response

    @property
    def W(self) -> Array:
        """(O, t N) gaps of the open nodes due to unit slips of the closed nodes."""
        return self.parts(self.response)[2]

    def motions_of_open(self, rows: Integers) -> Array:
        """(R, t N) slips or gaps of the open nodes due to unit slips of the closed ones.

        `rows` (R,) are the wanted entries of the motions (M,).
        """
        assert self.compliance is not None  # some nodes are open
        motion = -(self.compliance[rows] @ self.system.S[:, : -self.system.nodes])
        motion[:, np.tile(self.open_nodes, self.system.tangents)] = 0.0
        return motion

    def loads(self, k: int) -> dict[str, Array]:
        """Reactions q0, p0, q1, p1 and gaps w0, w1 of corner k, by their printed names."""
        suffix = f"[{k}]" if self.fixed else ""
        return self.named_loads((self.start[k], suffix), (self.rate[k], f"[{k}]"))

    def named_loads(self, start: tuple[Array, str], rate: tuple[Array, str]) -> dict[str, Array]:
        """Forces (M,) by their printed names, which end with the given texts; see `loads`."""
        loads = dict[str, Array]()
        for parts in ("qp", "w"):
            for number, (forces, suffix) in enumerate((start, rate)):
                shaped = self.shaped(forces)
                loads |= {f"{part}{number}{suffix}": shaped[part] for part in parts}
        return loads

    def shaped(self, forces: Array) -> dict[str, Array]:
        """Shear forces q, normal forces p and gaps w of forces (M,)."""
        q, p, w = self.parts(forces)
        return {"q": q.reshape(self.system.slip_shape, order="F"), "p": p, "w": w}

    def parts(self, forces: Array) -> tuple[Array, Array, Array]:
        """Forces (M, ...) split into shear forces, normal forces and gaps of open nodes."""
        shear, normal = np.split(forces, [-self.system.nodes])
        pressures = normal.copy()
        pressures[self.open_nodes] = 0.0
        return shear, pressures, normal[self.open_nodes]

    def forces_of(self, r: Array) -> Array:
        """(K, M) forces from bonded reactions (K, M)."""
        return _forces(self.system, self.open_nodes, self.compliance, r)

    def reactions_of_slip(self, slip: Array) -> tuple[Array, Array]:
        """Reactions `A v, B v` that a slip v, (N,) or (N, 2), adds at the closed nodes."""
        tangential = self.S[:, : -self.system.nodes]
        return parted(tangential @ slip.T.ravel(), self.system.tangents + 1)

    def slip_at_mean_load(self, slip: Array) -> Array:
        """The slip of all nodes: open nodes have their slip under the mean load."""
        if self.compliance is None:
            return slip
        # A subclass such as LiftOff has other states; here the same nodes are open at all corners.
        u, _ = Question.states(self, 0.0, slip)
        return u[0, :-1].T.reshape(slip.shape)

    def excess_over_slip_bound(self, slip: Array) -> float:
        """Largest excess of the slip over its bound, relative to the largest bound or slip.

        It is 0 or negative if the slip is within the bound.
        """
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
        """Motions at the corners; the ends of a segment share the motions at its events."""
        return moves

    @property
    def opened(self) -> tuple[Booleans, Booleans]:
        """(K, N) or (1, N) masks of the nodes that are open before, and after, each instant."""
        return self.open_nodes[None], self.open_nodes[None]

    @property
    def statuses(self) -> tuple[Booleans, Booleans]:
        """(K, N) or (1, N) masks of the nodes that stick, and of the open nodes, at each instant.

        Nodes in neither mask touch without force.
        """
        before, after = self.opened
        return ~(before | after), before & after

    # Whether the normal loads alone open and close nodes in each cycle, see `MovingAreas`.
    moves: ClassVar[bool] = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the instants, which list their loads."""
        return self.cycle.corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """A tuple for each event: node, "opens" or "closes", place on the way, and its loads."""
        return []

    @property
    def node_states(self) -> str:
        """The states of the nodes that an answer is about, as a part of a sentence."""
        if self.open_nodes.any():
            return " with these nodes open and the others closed"
        return " with all nodes closed"

    @property
    def both_vary(self) -> bool:
        """Whether fixed and scaled loads both vary where nodes open or close, see `LiftOff`."""
        return False

    @cached_property
    def settles_closed(self) -> bool:
        """Whether zero slip is safe under the mean load, which then opens no further nodes."""
        return self.violation(0.0, np.zeros(self.system.slip_shape)) <= RESIDUAL

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far a slip is from being safe, dimensionless; 0 if it is safe.

        It is the largest violation of the contact law at an instant, or of the slip bound.
        """
        system = self.system
        u, r = (part.reshape(len(part), -1) for part in self.instants(load_factor, slip))
        bonded = self.at_instants(load_factor) + system.pressing_shut(system.gap)
        off = off_law(system, self.law, bonded, u - system.opening, r, self.force)
        return worst([off.max(), self.excess_over_slip_bound(slip)])


def pose(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    simplify: bool = True,
    slip_bound: PerNode | None = None,
    solver: str | None = None,
    question_name: str = "this question",
) -> Question:
    """Check a limit question and pose it with all nodes closed; ModelError for bad input.

    `slip_bound` is one largest slip, one per node, or None. `question_name` is the name of the
    public question, which decides whether laws other than Coulomb's are allowed. A mean load is
    refused if its shear is so large that the pressure is lost in rounding.
    """
    started = perf_counter()
    checked_law(system, question_name)
    solver_order(solver, LP if system.tangents == 1 else SOCP)
    checked_cycle(cycle)
    bonded = _bonded(system, cycle)
    bound = None
    if slip_bound is not None:
        remedy = "it bounds the size of the slip, give a length >= 0, or None for no bound"
        bound = per_node("slip_bound", slip_bound, system, remedy)
        # The forces of smaller slips are rounding errors beside the forces of the mean load.
        smallest = ROUNDING * np.abs(bonded[0]).max() / system.own_stiffness[: system.nodes]
        bound = np.where(bound > smallest, bound, 0.0)
    question = _question(
        system=system,
        cycle=cycle,
        friction=friction_coefficients(friction, system),
        slip_bound=bound,
        open_nodes=np.zeros(system.nodes, dtype=bool),
        compliance=None,
        simplify=flag("simplify", simplify),
        solver=solver,
        started=started,
        bonded=bonded,
    )

    shear = np.linalg.norm(question.r0[:, :-1], axis=1)
    force = question.force
    # Largest ratio of the mean shear force to the mean normal force. With a larger ratio, rounding
    # errors of the shear would hide the pressure.
    largest_ratio = 1e6
    if shear.max() > largest_ratio * force:
        node = int(shear.max(axis=0).argmax())
        raise ModelError(
            f"mean: its shear force at node {node}{in_contact(system, node)} is "
            f"{shear.max() / force:.1e} times the mean normal force {force:.3g}, so that rounding "
            "hides the pressure; press the contact, or check the units of the load cases"
        )
    return question


def pose_like(
    question: Question,
    cycle: LoadCycle,
    friction: PerNode,
    system: ContactSystem | None = None,
    question_name: str = "this question",
) -> Question:
    """Pose a question with the options of another one, see `pose`."""
    return pose(
        question.system if system is None else system,
        cycle,
        friction,
        simplify=question.simplify,
        slip_bound=question.slip_bound,
        solver=question.solver,
        question_name=question_name,
    )


def with_open(question: Question, open_nodes: Booleans) -> Question | None:
    """The question with some nodes open at all corners; None if the closed ones do not hold them.

    If all nodes are open, only supports can hold them. If these nodes are open already, the given
    question itself is returned.
    """
    if (open_nodes == question.open_nodes).all():
        return question
    compliance = _compliance(question.system, open_nodes)
    if compliance is None and open_nodes.any():
        return None
    return _changed(question, open_nodes=open_nodes, compliance=compliance)


def _compliance(system: ContactSystem, open_nodes: Booleans) -> Array | None:
    """(M, M) compliance of the open nodes, which carry no force; zero elsewhere.

    The result is None if all nodes are closed. It is also None if nothing resists some motion of
    the open nodes while the closed nodes are held, and a load excites this motion or the motion
    changes a gap.
    """
    if not open_nodes.any():
        return None
    opened = np.tile(open_nodes, system.tangents + 1)
    block = np.ix_(opened, opened)
    free, inverse = unresisted(system.S[block], system.own_stiffness[opened])

    # A free motion is harmless if no load excites it, and if it changes no gap.
    excited = [np.abs(free[-int(open_nodes.sum()) :]).max(initial=0.0)]
    for pair in system.bonded.values():
        r = joined(*pair)
        work = r[opened] @ free / (np.abs(r).max() or 1.0)
        excited.append(np.abs(work).max(initial=0.0))
    if max(excited) > CONDENSATION:
        return None

    compliance = np.zeros_like(system.S)
    compliance[block] = inverse
    return compliance


def with_friction(question: Question, friction: PerNode) -> Question:
    """The question with other friction, posed now (`started`); ModelError for bad friction."""
    coefficients = friction_coefficients(friction, question.system)
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
    solver: str | None,
    started: float,
    bonded: tuple[Array, Array],
) -> Question:
    """All arrays of a question, one after the other."""
    axes = system.tangents + 1
    fixed, scaled = (bool(np.ptp(part, axis=0).any()) for part in bonded)

    # Open nodes carry no force. Their gaps are taken out exactly, because under a mean load of zero
    # a rounding error would be the only force.
    gap = system.gap * open_nodes
    # Corners that do not differ at load factor 0 share one row, so that rounding cannot part them.
    at_zero = bonded[0] if fixed else bonded[0][:1]
    start = _forces(system, open_nodes, compliance, at_zero + system.pressing_shut(gap))
    start[:, -system.nodes :] += gap
    rate = _forces(system, open_nodes, compliance, bonded[1])
    start = np.broadcast_to(start, rate.shape)
    of_closed = np.tile(~open_nodes, axes)
    q1, p1 = parted(rate * of_closed, axes)
    r0 = (start * of_closed).reshape(-1, axes, system.nodes)
    r1 = (rate * of_closed).reshape(-1, axes, system.nodes)

    return Question(
        system=system,
        cycle=cycle,
        friction=friction,
        slip_bound=slip_bound,
        open_nodes=open_nodes,
        simplify=simplify,
        solver=solver,
        started=started,
        bonded=bonded,
        fixed=fixed,
        static=not (fixed or scaled),
        compliance=compliance,
        start=start,
        rate=rate,
        r0=r0,
        r1=r1,
        q1=q1,
        p1=p1,
        **units_of(system, friction, open_nodes, r0, r1),
    )


def _bonded(system: ContactSystem, cycle: LoadCycle) -> tuple[Array, Array]:
    """(K, M) bonded reactions at load factor 0, all gaps shut, and of the scaled loads."""
    unscaled = cycle.unscaled
    if all(loads == unscaled[0] for loads in unscaled):
        unscaled = unscaled[:1]  # fixed parts that do not differ are a mean load
    at_zero = reactions(system, unscaled) - system.pressing_shut(system.gap)
    scaled = reactions(system, cycle.corners)
    return np.broadcast_to(at_zero, scaled.shape), scaled


def _forces(
    system: ContactSystem, open_nodes: Booleans, compliance: Array | None, r: Array
) -> Array:
    """(K, M) forces from bonded reactions (K, M), see `Question`."""
    if compliance is None:
        return r
    follow = r @ compliance
    forces = (r - follow @ system.S) * ~np.tile(open_nodes, system.tangents + 1)
    forces[:, -system.nodes :] -= follow[:, -system.nodes :] * open_nodes
    return np.asarray(forces)


def outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners outside the convex hull of the other corners, by the amplitudes of all load cases."""
    amplitudes = amplitudes_of(cycle.corners)
    if cycle.fixed is not None:
        amplitudes = np.hstack([amplitudes, amplitudes_of(cycle.fixed)])
    return vertices_of_hull(amplitudes)


def vertices_of_hull(points: Array) -> list[int]:
    """Indices of the points (K, any dimension) that are no mean of the other points.

    If the points spread in many directions, all points are returned.
    """
    count = len(points)
    # Coordinates in the directions in which the points differ.
    spread = np.ptp(points, axis=0)
    points = (points - points.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    _, size, directions = np.linalg.svd(points, full_matrices=False)
    differ = size > ROUNDING * max(size.max(initial=0.0), 1.0)
    along = points @ directions[differ].T
    dimension = along.shape[1]
    if dimension == 0:
        return [0]
    if dimension == 1:
        return sorted({int(along.argmin()), int(along.argmax())})
    # The hull is computed only if the points spread in at most this many directions. Otherwise each
    # corner has rows.
    most_directions = 6
    if dimension <= most_directions and count > dimension + 1:
        # The vertices of a hull that is nearly flat would depend on rounding.
        with suppress(scipy.spatial.QhullError):
            return sorted(scipy.spatial.ConvexHull(along).vertices.tolist())
    return list(range(count))


def ruling(constant: Array, rate: Array) -> Booleans:
    """(K, N) which rows govern `x >= constant_k + load_factor rate_k` at each of N nodes.

    A row governs if it is the largest of its node at some load factor >= 0. The loop starts with
    the largest row at load factor 0, and follows the upper envelope from row to row.
    """
    governs = np.zeros(rate.shape, dtype=bool)
    node = np.arange(rate.shape[1] if len(rate) else 0)
    if node.size:
        highest = constant == constant.max(axis=0)
        corner = np.where(highest, rate, -np.inf).argmax(axis=0)
    while node.size:
        governs[corner, node] = True
        rate_gain = rate[:, node] - rate[corner, node]
        lead = constant[corner, node] - constant[:, node]
        crossing = np.where(rate_gain > 0, lead / np.where(rate_gain > 0, rate_gain, 1.0), np.inf)
        crosses = np.isfinite(crossing.min(axis=0))
        corner = crossing.argmin(axis=0)[crosses]
        node = node[crosses]
    return governs


def units_of(
    system: ContactSystem, friction: Array, open_nodes: Booleans, r0: Array, r1: Array
) -> dict[str, Any]:
    """Name -> unit. The fields of `Question` with these names describe the units."""
    # Sizes of normal and shear forces (K, N), at load factor 0 and due to the scaled loads.
    normal, cyclic_normal = np.abs(r0[:, -1]), np.abs(r1[:, -1])
    shear, cyclic_shear = (np.linalg.norm(r[:, :-1], axis=1) for r in (r0, r1))
    # If no node is closed, the open nodes take their place.
    closed = ~open_nodes | open_nodes.all()

    def mean(forces: Array) -> float:
        return float(forces[:, closed].mean())

    force = mean(normal) or max(map(mean, (shear, cyclic_shear, cyclic_normal))) or 1.0
    bound, size = mean(friction * r0[:, -1]), mean(friction * normal)
    mean_bound = bound if bound > CONDENSATION * size else force
    # Pressure margins have the unit `mean_bound` / friction. Friction below this value is replaced
    # by this value, so that the unit is finite.
    least_friction = 0.01

    without_friction = cyclic_normal[:, closed & (friction == 0)].sum() / closed.sum()
    demand = mean(cyclic_shear) + mean(friction * cyclic_normal) + float(without_friction)

    # The least force unit of a node. It is a millionth of the mean normal force, because answers
    # have errors of this size. The unit of a node without pressure under the mean load is its
    # largest other force.
    smallest = 1e-6 * force
    others = np.max([part.max(axis=0) for part in (shear, cyclic_shear, cyclic_normal)], axis=0)
    pressure = normal.max(axis=0)
    node_unit = np.where(pressure > smallest, pressure, np.maximum(others, smallest))
    node_unit = np.where(open_nodes, force, node_unit)

    # In space the radius of a friction cone is the friction bound. The unit of the shear is this
    # bound if the bound is smaller than the pressure.
    small_cones = (friction > 0) & (friction < 1)
    normal_stiffness = float(system.own_stiffness[-system.nodes :].mean())
    if not normal_stiffness > CONDENSATION * system.stiffness_scale:
        normal_stiffness = system.stiffness_scale
    return {
        "force": force,
        "mean_bound": mean_bound,
        "mean_pressure": mean_bound / np.maximum(friction, least_friction),
        "load_unit": (size or force) / demand if demand > 0 else 1.0,
        "node_unit": node_unit,
        "shear_unit": node_unit * np.where(small_cones, friction, 1.0),
        "clearance": mean_bound / normal_stiffness,
    }
