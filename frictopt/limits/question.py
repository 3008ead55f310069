"""A limit problem as posed: system, load cycle and friction, checked, with the units in which it is solved, and the slips that nothing resists."""

from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky, lu_factor, lu_solve
from scipy.linalg.lapack import dpotri

from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients, lengths, off_law, parted, reactions
from ..contact.checks import Array, Booleans, Integers, flag, per_node
from ..contact.tolerances import CONDENSATION, NO_COUPLING, RIGID
from ..errors import ModelError

Images: TypeAlias = tuple[Integers, Integers, Array]
"""Where a part of a contact is on the whole one, G times: (G, K) corners, (G, m) unknowns and their signs."""

_MOST_SHEAR = 1e6  # a mean shear force above so many mean normal forces leaves fewer digits of them than the proofs need
_FIRST, _ITERATIONS = 8, 4  # of an inverse iteration: slips at first, twice as many where all are soft, and steps
_LITTLE_FRICTION = 0.01  # below it, the bounds on q keep p >= 0 only to a hundred times their own accuracy


@dataclass(frozen=True, eq=False)
class LimitQuestion:
    """One friction coefficient on one system and load cycle, see `pose`.

    Attributes
    ----------
    system, cycle
        The whole contact and its load cycle.
    friction
        (N,) coefficients of friction of the N nodes of the question.
    r0, r1
        Closed reactions `[q, p]` of the cycle on these nodes, (K, t + 1, N), the normal ones last, force: at load factor 0, (1, t + 1, N) where they
        are the same at all corners; and what a load factor of 1 adds. `parts` has them apart.
    AB, stiffness
        (M, t N) forces by slips of these nodes, A over B, and (M,) the size of their own stiffness, see `ContactSystem`.
    simplify
        Whether to leave out what cannot change the answer: half of a mirror-symmetric contact, corners that others stand for.
    most
        (N,) largest size of the slip; None for no bound.
    force, load_unit, mean_bound
        Mean normal force at load factor 0 (a force of the same size where there is none); load factor at which the cyclic reactions reach the mean
        friction bound; and this bound at load factor 0, the unit of margins (`force` where there is no friction).
    opening
        Whether there is so little friction somewhere that keeping nodes closed needs rows of its own.
    uncoupled
        Whether slip changes no pressure of the whole contact: B is zero up to rounding, against A of the two nodes that it joins. That of the closed
        nodes alone, or f B, is not enough: a start that opens or closes nodes would couple the others.
    fixed
        Whether the corners differ at load factor 0.
    started
        When it was posed, for the record.
    closed
        (N,) which of these nodes are closed.
    give
        (M, M) compliance of the open nodes alone, zero elsewhere, of a question on the whole contact; None where all are closed.
    whole
        Of a question on a part of a contact, half of it or its closed nodes: that on the whole one, see `half_of`, `rest_of` and `on_whole`.
    images
        Of such a question: where its unknowns, slips and lifts of its nodes and then gaps of open ones, are on the whole; else None.
    lift
        (O, t N) gaps of the open nodes by slips of the closed ones, ordered by component, of a question on these; else None.
    w0, w1
        (K, O) or (1, O), and (K, O) the same gaps where nothing slips, length: at load factor 0, and what a load factor of 1 adds.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    r0: Array
    r1: Array
    AB: Array
    stiffness: Array
    simplify: bool
    most: Array | None
    force: float
    load_unit: float
    mean_bound: float
    opening: bool
    uncoupled: bool
    fixed: bool
    closed: Booleans
    started: float = field(default_factory=perf_counter)
    whole: "LimitQuestion | None" = None
    images: Images | None = None
    give: Array | None = None
    lift: Array | None = None
    w0: Array = field(default_factory=lambda: np.zeros((1, 0)))
    w1: Array = field(default_factory=lambda: np.zeros((1, 0)))

    @property
    def parts(self) -> tuple[Array, Array, Array, Array]:
        """The same reactions as `q0, p0, q1, p1`: the shear forces (K, N) or (K, N, 2), the normal ones (K, N)."""
        (q0, p0), (q1, p1) = (parted(r.reshape(len(r), -1), self.system.tangents + 1) for r in (self.r0, self.r1))
        return q0, p0, q1, p1

    @property
    def pattern(self) -> str:
        """Which states of the nodes an answer is about, as a part of a sentence: it says nothing of others."""
        return " with all nodes closed" if self.closed.all() else " with these nodes open and the others closed"

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Slips and gaps `[v, w]` and reactions `[q, p]` at the corners, each (K, t + 1, N), under a residual slip, (N,) or (N, 2).

        Open nodes leave it, and carry nothing.
        """
        u = np.zeros(self.r1.shape[1:])
        u[:-1] = slip.T * self.closed
        r = self.r0 + load_factor * self.r1 + (self.AB @ u[:-1].ravel()).reshape(u.shape)
        if self.give is not None:
            follow = r.reshape(len(r), -1) @ self.give
            u, r = u - follow.reshape(r.shape), (r - (follow @ self.system.S).reshape(r.shape)) * self.closed
        return np.broadcast_to(u, r.shape), r

    def change(self, slip: Array) -> tuple[Array, Array]:
        """Reactions `A v, B v` that a residual slip, (N,) or (N, 2), adds to those of the closed contact."""
        return parted(self.AB @ slip.T.ravel(), self.system.tangents + 1)

    def own(self, slip: Array) -> Array:
        """What a slip of the whole contact is on the closed nodes of a question on these."""
        return slip if self.whole is None else slip[self.whole.closed]

    def beyond(self, slip: Array) -> float:
        """By how much the slip exceeds its bound, over the largest slip or bound; at most 0 if it does not."""
        if self.most is None:
            return 0.0
        size = np.where(self.closed, lengths(slip, self.most), 0.0)
        return float(((size - self.most) / max(float(self.most.max()), float(size.max()), np.finfo(float).tiny)).max())

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far the slip of a whole contact is from being safe: its largest violation of the contact law over the corners, or of its bound."""
        S, gap = self.system.S, np.pad(self.system.gap, (self.r1[0, :-1].size, 0))
        r0, r1, u, r = (part.reshape(len(part), -1) for part in (self.r0, self.r1, *self.states(load_factor, slip)))
        off = off_law(self.system, self.friction, r0 + load_factor * r1 + S @ gap, u - gap, r, self.force)
        return float(np.nan_to_num(max(off.max(), self.beyond(slip)), nan=np.inf))

    def reserve(self, load_factor: float, slip: Array) -> float:
        """The margin of a slip, see `SafeSlip.margin`."""
        r = self.states(load_factor, slip)[1]
        q, p = np.linalg.norm(r[:, :-1], axis=1), r[:, -1]
        closed = float(min((self.friction * p - q).min(), p.min() if self.opening else np.inf)) / self.mean_bound
        return min(closed, float(self.gaps(load_factor, slip).min(initial=np.inf)) / self.clearance)

    def gaps(self, load_factor: float, slip: Array) -> Array:
        """(K, O) gaps of the open nodes by the slip of the closed ones, of a question on these."""
        gaps = self.w0 + load_factor * self.w1
        return gaps if self.lift is None else gaps + self.lift @ slip.T.ravel()

    @property
    def clearance(self) -> float:
        """Unit of margins as a gap, length: what the mean friction bound does to the mean normal stiffness."""
        return self.mean_bound / (float(np.diag(self.system.C).mean()) or self.system.stiffness_scale)


def pose(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, simplify: bool = True, slip_bound: Any = None) -> LimitQuestion:
    """Check a limit problem and pose it; `slip_bound` is one largest slip, or one per node, None for no bound.

    Raises
    ------
    ModelError
        Wrong types, load cases that the system does not have, bad friction, a bad slip bound, a mean load whose shear hides its pressure.
    """
    nodes, unscaled = checked_system(system).nodes, checked_cycle(cycle).unscaled
    unscaled = unscaled if any(loads != unscaled[0] for loads in unscaled) else unscaled[:1]  # equal fixed parts are a mean load
    r0, r1 = (reactions(system, part).reshape(len(part), -1, nodes) for part in (unscaled, cycle.corners))
    r0 = r0 - (system.S[:, -nodes:] @ system.gap).reshape(-1, nodes)  # all gaps are pressed shut
    f, bounds = friction_coefficients(friction, system.nodes), "it bounds the size of the slip, give a length >= 0, or None for no bound"
    most = None if slip_bound is None else per_node("slip_bound", slip_bound, system.nodes, bounds)
    AB, lean, closed = system.S[:, : -system.nodes], flag("simplify", simplify), np.ones(system.nodes, dtype=bool)
    units, fixed = units_of(f, r0, r1), len(r0) > 1
    stiffness = np.sqrt(np.diag(AB).clip(0.0).reshape(-1, nodes).sum(axis=0))
    coupled = np.maximum(f, 1.0)[:, None] * np.abs(AB[-nodes:]) > NO_COUPLING * np.outer(stiffness, np.resize(stiffness, AB.shape[1]))
    return LimitQuestion(
        system, cycle, f, r0, r1, AB, system.own_stiffness, lean, most, **units, uncoupled=not coupled.any(), fixed=fixed, closed=closed
    )


def units_of(f: Array, r0: Array, r1: Array) -> dict[str, Any]:
    """Force, load_unit, mean_bound and opening of a `LimitQuestion`.

    Raises
    ------
    ModelError
        A mean load whose shear hides its pressure.
    """
    held, sheared = (np.linalg.norm(r[:, :-1], axis=1) for r in (r0, r1))
    p0, pressed, swung = r0[:, -1], np.abs(r0[:, -1]), np.abs(r1[:, -1])
    force = float(pressed.mean() or max(held.mean(), sheared.mean(), swung.mean()) or 1.0)
    demand = float(sheared.mean() + (f * swung).mean()) + float(swung[:, f == 0].sum()) / len(f)
    bound, size = float((f * p0).mean()), float((f * pressed).mean())
    load_unit = (size or force) / demand if demand > 0 else 1.0
    mean_bound = bound if bound > CONDENSATION * size else force  # a shear alone leaves rounding
    if held.max() > _MOST_SHEAR * force:
        raise ModelError(
            f"mean: its shear force at node {int(held.max(axis=0).argmax())} is {held.max() / force:.1e} times the mean normal force {force:.3g}, "
            "and rounding of the one hides the other; press the contact, or check the units of the load cases"
        )
    return {"force": force, "load_unit": load_unit, "mean_bound": mean_bound, "opening": bool(f.min() < _LITTLE_FRICTION)}


def rigid_slides(task: LimitQuestion) -> tuple[Array, Array]:
    """Orthonormal slips that A does not resist, (t N, k), and the compliance (t N, t N) of forces that do no work on them, to slips free of them.

    Each slip and each pressure counts in units of its own stiffness, so that a soft node beside stiff ones is not taken for a free one. A slip that
    changes a pressure is resisted, however little, or S would not be positive semi-definite.
    """
    tangent, normal = np.split(np.sqrt(task.stiffness), [-len(task.friction)])
    t = len(tangent)
    scaled, pressure = task.AB[:t] / np.outer(tangent, tangent), task.AB[t:] / np.outer(normal, tangent)
    idle = ~(scaled.any(axis=0) | (np.abs(pressure).max(axis=0) > RIGID))
    scaled[idle, idle] = 1.0  # what nothing feels at all, such as slip across a mirror plane, is a slide by itself, so that the others stay exact
    factor, rng, count, stiffest = lu_factor(scaled + RIGID * np.eye(t)), np.random.default_rng(0), 0, 0.0
    while stiffest <= RIGID and count < t:  # inverse iteration of more slips than there are soft ones, which many small eigenvalues cannot slow
        count = min(2 * count or _FIRST, t)
        soft = rng.normal(size=(t, count))
        for _ in range(_ITERATIONS):
            soft = np.linalg.qr(lu_solve(factor, soft))[0]
        values, turn = np.linalg.eigh(soft.T @ scaled @ soft)
        stiffest = values[-1]
    values, soft = values[values <= RIGID], (soft @ turn)[:, values <= RIGID]
    held = (values > 0) & (np.abs(pressure @ soft).max(axis=0) > RIGID)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    root = cholesky((scaled + soft @ soft.T).T, lower=True, overwrite_a=True, check_finite=False)  # soft slips have the stiffness 1 + value
    compliance = np.tril(dpotri(root, lower=1, overwrite_c=1)[0])
    compliance += np.tril(compliance, -1).T + (soft * share) @ soft.T
    compliance /= np.outer(tangent, tangent)
    rigid = np.hstack([np.linalg.qr(soft[:, ~held] / tangent[:, None])[0], np.eye(len(tangent))[:, idle]])
    compliance -= rigid @ (rigid.T @ compliance)
    return rigid, np.asarray(compliance - (compliance @ rigid) @ rigid.T)
