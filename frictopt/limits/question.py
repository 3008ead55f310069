"""A limit problem as posed: system, load cycle, friction, and which nodes stay open; what its listing needs, and the referee of its answers."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import CONDENSATION, Array, Booleans, flag, kept
from ..base.checks import per_node
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    checked_uncapped,
    friction_coefficients,
    lengths,
    off_law,
    parted,
    reactions,
)
from ..contact.diagnosis import in_contact
from ..contact.stiffness import following
from ..errors import ModelError

# a mean shear force above so many mean normal forces leaves fewer digits of them than the proofs
# need
_MOST_SHEAR = 1e6
_OF_TENSION = 0.01  # friction with which a tension counts in a margin, at nodes that have less
# units of nodes are their pressures unless these are below this share of the mean one: an answer
# has its error
_NO_PRESSURE = 1e-6


@kept
@dataclass(frozen=True, eq=False)
class Question:
    """One friction coefficient on one system and load cycle, with the nodes that stay open, see `pose`."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array  # (N,)
    most: Array | None  # (N,) largest size of the slip
    open: Booleans  # (N,) which nodes are open at all corners
    simplify: bool  # whether to leave out corners and rows that others stand for
    started: float = field(default_factory=perf_counter)

    @cached_property
    def bonded(self) -> tuple[Array, Array]:
        """Closed reactions, all gaps pressed shut: (K, M) at load factor 0, (1, M) where they are the same at all corners, and what 1 adds."""
        unscaled = self.cycle.unscaled
        unscaled = (
            unscaled if any(loads != unscaled[0] for loads in unscaled) else unscaled[:1]
        )  # equal fixed parts are a mean load
        shut = self.system.S[:, -self.system.nodes :] @ self.system.gap
        return reactions(self.system, unscaled) - shut, reactions(self.system, self.cycle.corners)

    @property
    def fixed(self) -> bool:
        """Whether the corners differ at load factor 0."""
        return len(self.bonded[0]) > 1

    @property
    def static(self) -> bool:
        """Whether all corners are one load, maybe listed several times."""
        return not any(np.ptp(part, axis=0).any() for part in self.bonded)

    def moved(self, chosen: Booleans, first: int) -> Array:
        """What some of the slips and gaps, from a `first` one on, are by the slips of the closed nodes."""
        t = self.system.tangents * self.system.nodes
        moved = (
            np.zeros((0, t))
            if self.give is None
            else -(self.give[first:][: len(chosen)][chosen] @ self.system.S[:, :t])
        )
        moved[:, np.tile(self.open, self.system.tangents)] = 0.0
        return np.asarray(moved)

    @cached_property
    def give(self) -> Array | None:
        """(M, M) compliance of the open nodes alone, zero elsewhere; None where all are closed."""
        return (
            following(self.system.S, self.open, [*self.system.bonded.values()])
            if self.open.any()
            else None
        )

    @cached_property
    def S(self) -> Array:
        """(M, M) stiffness of the closed nodes, which the open ones follow without force."""
        S = self.system.S
        if self.give is None:
            return S
        out = np.tile(self.open, self.system.tangents + 1)
        closed, across = np.flatnonzero(~out), S[np.ix_(out, ~out)]
        left = S[np.ix_(~out, ~out)] - across.T @ (self.give[np.ix_(out, out)] @ across)
        every = np.zeros_like(S)
        every[np.ix_(closed, closed)] = (left + left.T) / 2
        return every

    @cached_property
    def r0(self) -> Array:
        """(K, t + 1, N) or (1, t + 1, N) reactions of the closed nodes at load factor 0, normal ones last, force."""
        return self.carried(self.bonded[0])

    @cached_property
    def r1(self) -> Array:
        """(K, t + 1, N) what a load factor of 1 adds."""
        return self.carried(self.bonded[1])

    def carried(self, r: Array) -> Array:
        """(K, t + 1, N) reactions of the closed nodes, of closed reactions (K, M)."""
        r = (
            r
            if self.give is None
            else (r - (r @ self.give) @ self.system.S)
            * ~np.tile(self.open, self.system.tangents + 1)
        )
        return r.reshape(len(r), -1, self.system.nodes)

    @cached_property
    def w(self) -> tuple[Array, Array]:
        """(K, O) or (1, O), and (K, O) gaps of the open nodes where nothing slips: at load factor 0, and what a load factor of 1 adds, length."""
        if self.give is None:
            return np.zeros((1, 0)), np.zeros((len(self.bonded[1]), 0))
        at_zero, cyclic = (
            -(r @ self.give)[:, -self.system.nodes :][:, self.open] for r in self.bonded
        )
        return at_zero, cyclic

    @property
    def A(self) -> Array:
        """(t N, t N) shear forces by slip."""
        return self.S[: -self.system.nodes, : -self.system.nodes]

    @property
    def B(self) -> Array:
        """(N, t N) normal forces by slip."""
        return self.S[-self.system.nodes :, : -self.system.nodes]

    @cached_property
    def W(self) -> Array:
        """(O, t N) gaps of the open nodes by slip."""
        return self.moved(self.open, self.system.tangents * self.system.nodes)

    def loads(self, k: int) -> dict[str, Array]:
        """Closed reactions and gaps of a corner by their names: at load factor 0, and what a load factor of 1 adds."""
        (q0, p0, q1, p1), (w0, w1), of = self.parts, self.w, f"[{k}]" * self.fixed
        at = k if self.fixed else 0
        load = {f"q0{of}": q0[at], f"p0{of}": p0[at], f"q1[{k}]": q1[k], f"p1[{k}]": p1[k]}
        return load | {f"w0{of}": w0[min(at, len(w0) - 1)], f"w1[{k}]": w1[k]}

    @cached_property
    def parts(self) -> tuple[Array, Array, Array, Array]:
        """Reactions `q0, p0, q1, p1`: the shear forces (K, N) or (K, N, 2), the normal ones (K, N)."""
        (q0, p0), (q1, p1) = (
            parted(r.reshape(len(r), -1), self.system.tangents + 1) for r in (self.r0, self.r1)
        )
        return q0, p0, q1, p1

    @cached_property
    def force(self) -> float:
        """Mean normal force at load factor 0, or a force of the same size where there is none."""
        closed = ~self.open
        held, sheared = (np.linalg.norm(r[:, :-1, closed], axis=1) for r in (self.r0, self.r1))
        pressed, swung = np.abs(self.r0[:, -1, closed]), np.abs(self.r1[:, -1, closed])
        return (
            float(pressed.mean() or max(held.mean(), sheared.mean(), swung.mean()) or 1.0)
            if closed.any()
            else 1.0
        )

    @cached_property
    def mean_bound(self) -> float:
        """Mean friction bound at load factor 0, the unit of margins; `force` where there is no friction."""
        closed, p0 = ~self.open, self.r0[:, -1]
        bound, size = (
            float((self.friction * p)[:, closed].mean()) if closed.any() else 0.0
            for p in (p0, np.abs(p0))
        )
        return bound if bound > CONDENSATION * size else self.force  # a shear alone leaves rounding

    @cached_property
    def mean_pressure(self) -> Array:
        """(N,) units of margins as normal forces: those whose friction bound is `mean_bound`, with no less friction than `_OF_TENSION`."""
        return np.asarray(self.mean_bound / np.maximum(self.friction, _OF_TENSION))

    @cached_property
    def load_unit(self) -> float:
        """Load factor at which the cyclic reactions reach the mean friction bound."""
        closed, f = ~self.open, self.friction
        if not closed.any():
            return 1.0
        sheared, swung = (
            np.linalg.norm(self.r1[:, :-1, closed], axis=1),
            np.abs(self.r1[:, -1, closed]),
        )
        demand = (
            float(sheared.mean() + (f[closed] * swung).mean())
            + float(swung[:, f[closed] == 0].sum()) / closed.sum()
        )
        size = float((f * np.abs(self.r0[:, -1]))[:, closed].mean())
        return (size or self.force) / demand if demand > 0 else 1.0

    @cached_property
    def node_unit(self) -> Array:
        """(N,) force unit of each node: its pressure under the mean load, or what else acts on it; of an open one the mean."""
        (sheared, swung), (held, pressed) = (
            (np.linalg.norm(r[:, :-1], axis=1), np.abs(r[:, -1])) for r in (self.r1, self.r0)
        )
        pressure, acts = (
            pressed.max(axis=0),
            np.maximum(held.max(axis=0), np.maximum(sheared, swung).max(axis=0)),
        )
        unit = np.where(
            pressure > _NO_PRESSURE * self.force,
            pressure,
            np.maximum(acts, _NO_PRESSURE * self.force),
        )
        return np.where(self.open, self.force, unit)

    @property
    def shear_unit(self) -> Array:
        """(N,) unit of shear forces: in space the friction bound where it is less than the force unit, for cones end by it; lines end in a vertex."""
        little = (self.friction > 0) & (self.friction < 1) & (self.system.tangents > 1)
        return np.asarray(self.node_unit * np.where(little, self.friction, 1.0))

    @property
    def pattern(self) -> str:
        """Which states of the nodes an answer is about, as a part of a sentence: it says nothing of others."""
        return (
            " with these nodes open and the others closed"
            if self.open.any()
            else " with all nodes closed"
        )

    @property
    def clearance(self) -> float:
        """Unit of margins as a gap, length: the mean friction bound over the mean normal stiffness, or over the scale if that is rounding."""
        normal, scale = float(np.diag(self.system.C).mean()), self.system.stiffness_scale
        return self.mean_bound / (normal if normal > CONDENSATION * scale else scale)

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Slips and gaps `[v, w]` and reactions `[q, p]` at the corners, each (K, t + 1, N), under a residual slip of the closed nodes."""
        axes, n, S = self.system.tangents + 1, self.system.nodes, self.system.S
        v = np.concatenate([(slip.T * ~self.open).ravel(), np.zeros(n)])
        r = self.bonded[0] + load_factor * self.bonded[1] + S @ v
        u = np.broadcast_to(v, r.shape)
        if self.give is not None:
            follow = r @ self.give
            u, r = u - follow, (r - follow @ S) * ~np.tile(self.open, axes)
        return u.reshape(-1, axes, n), r.reshape(-1, axes, n)

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """The same at all instants that have rows: the corners, and between them where nodes open or close in each cycle."""
        return self.states(load_factor, slip)

    def at_instants(self, load_factor: float) -> Array:
        """Closed reactions there, all gaps pressed shut."""
        return self.bonded[0] + load_factor * self.bonded[1]

    def by_corner(self, moves: Array) -> Array:
        """Motions there by the corners whose loads they are of."""
        return moves

    @property
    def statuses(self) -> tuple[Booleans, Booleans]:
        """(K, N) or (1, N) which nodes stick there, and which are open; others just touch."""
        return ~self.open[None], self.open[None]

    @property
    def names(self) -> tuple[str, ...]:
        """What these instants are called."""
        return self.cycle.corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """Node, "opens" or "closes", part of the way from the first corner to the last, and loads there, of nodes that do so in each cycle."""
        return []

    @property
    def open_share(self) -> Array:
        """(N,) part of the cycle in which each node is open."""
        return self.open.astype(float)

    def change(self, slip: Array) -> tuple[Array, Array]:
        """Reactions `A v, B v` that a residual slip, (N,) or (N, 2), adds to those of the closed nodes."""
        return parted(self.S[:, : -self.system.nodes] @ slip.T.ravel(), self.system.tangents + 1)

    def rested(self, slip: Array) -> Array:
        """A slip of the closed nodes with that of the open ones under the mean load."""
        return (
            slip
            if self.give is None
            else np.asarray(Question.states(self, 0.0, slip)[0][0, :-1].T.reshape(slip.shape))
        )  # nothing else opens

    def beyond(self, slip: Array) -> float:
        """By how much the slip exceeds its bound, over the largest slip or bound; at most 0 if it does not."""
        if self.most is None:
            return 0.0
        sizes = np.where(self.open, 0.0, lengths(slip, self.most))
        return float(
            (
                (sizes - self.most)
                / max(float(self.most.max()), float(sizes.max()), np.finfo(float).tiny)
            ).max()
        )

    def violation(self, load_factor: float, slip: Array) -> float:
        """How far a slip is from being safe: its largest violation of the contact law over the corners, or of its bound."""
        S, gap = (
            self.system.S,
            np.pad(self.system.gap, (self.system.tangents * self.system.nodes, 0)),
        )
        u, r = (part.reshape(len(part), -1) for part in self.instants(load_factor, slip))
        off = off_law(
            self.system,
            self.friction,
            self.at_instants(load_factor) + S @ gap,
            u - gap,
            r,
            self.force,
        )
        return float(np.nan_to_num(max(off.max(), self.beyond(slip)), nan=np.inf))


def pose(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    *,
    simplify: bool = True,
    slip_bound: Any = None,
    strong: bool = False,
) -> Question:
    """Check a limit problem and pose it with all nodes closed; `slip_bound` is one largest slip, or one per node, None for no bound.

    Refused: wrong types, unknown load cases, bad friction, a bad slip bound, a mean load whose
    shear hides its pressure; and a shear strength unless the question is `strong`, which knows it.
    """
    nodes = (checked_system(system) if strong else checked_uncapped(system, "this question")).nodes
    checked_cycle(cycle)
    bounds = "it bounds the size of the slip, give a length >= 0, or None for no bound"
    most = None if slip_bound is None else per_node("slip_bound", slip_bound, nodes, bounds)
    f, none = friction_coefficients(friction, nodes), np.zeros(nodes, dtype=bool)
    task = Question(system, cycle, f, most, none, flag("simplify", simplify))
    held = np.linalg.norm(task.r0[:, :-1], axis=1)
    if held.max() > _MOST_SHEAR * task.force:
        node = int(held.max(axis=0).argmax())
        raise ModelError(
            f"mean: its shear force at node {node}{in_contact(system, node)} is {held.max() / task.force:.1e} times the mean normal force "
            f"{task.force:.3g}, and rounding of the one hides the other; press the contact, or check the units of the load cases"
        )
    return task


def with_open(task: Question, opened: Booleans) -> Question | None:
    """The question with some nodes open at all corners; None if the others, or nothing where all are open, do not hold them."""
    asked = replace(task, open=opened)
    return None if opened.any() and asked.give is None else asked
