"""Programs for the least load factor at which a node is critical, and their results as claims.

Lower bounds of these load factors need no program. For each node j, one slip mechanism d gives a
bound. The multipliers d and a obey `A d + B^T (f a) = 0`, with `a = abs(d)` at all other nodes and
a_j = -1. Therefore no residual slip changes the sum of `d q + f a p` over the nodes. Let h(d) be
the largest `-(d q1 + f abs(d) p1)` over the corners. Then, with c and rho of `critical_state.py`::

    resistance = sum of d q0 + f a p0   >=   load_factor drive
    drive = d_j c - f rho + sum of h(d) over the other nodes

A fixed-point iteration looks for such multipliers. If it does not converge (large friction), the
bound of node j is 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base import CONDENSATION, RESIDUAL, Array, Booleans, SolveRecord, Table, frame, frozen
from ...solve.arrays import EQUATION
from ..program.assembled import at_corners, stuck
from ..program.question import Question
from ..program.rest_program import RestProgram, elastic
from ..program.solution import Solution, Solved, contradiction, solve
from .critical_state import CriticalState, critical_states, needed

# Labels that say where the load factor of a node comes from.
SOLVED = "solved"
NEVER = "never critical"
COINCIDE_ALONE = "only at the least safe load factor"
LEFT_OUT = "left out by its bound"
ONE_CORNER = "one corner alone governs"
NOT_NEEDED = "not needed"
OPEN = "open"

# Why some nodes needed no program: the text that follows their number.
_LEFT_OUT = {
    NOT_NEEDED: (
        "need no program: lambda_1 is lambda_2, because the contact is uncoupled (B = 0) or no "
        "load factors lie between the two"
    ),
    LEFT_OUT: "cannot be critical below the limit, by a lower bound",
    ONE_CORNER: "can only lift off when critical, or have no friction",
}


def critical(question: Question, state: CriticalState) -> RestProgram:
    """The program of the load factors at which a safe slip makes a node critical.

    Its goal is the least or the largest such load factor. At the node, the slip adds the reactions
    `at_zero + load_factor rate` of the state. If the fixed parts of the corners do not differ, the
    node then obeys the contact law, so that its rows are left out.
    """
    node = state.node
    program = stuck(at_corners(question, residual=True), but=-1 if question.fixed else node)
    n = question.system.nodes
    axes = len(state.rate)
    instant = np.array([len(program.start) - 1])
    load_factor = np.array([program.unknown("load_factor")])
    for axis in range(axes):
        force = program.force(instant, np.array([axis * n + node])), np.ones(1)
        needed = load_factor, -state.rate[[axis]]
        label = "critical_q" if axis < axes - 1 else "critical_p"
        unit = question.node_unit[[node]]
        constant = -state.at_zero[[axis]]
        program.add(label, EQUATION, [[force, needed]], constant, unit)
    return program


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is critical under a safe slip, and that slip.

    If there is no such slip, the load factor is inf or a lower bound, and the slip is NaN.
    """

    state: CriticalState
    load_factor: float
    slip: Array
    residual: float
    # The solved program; None if there is no such slip.
    solved: Solved | None = None
    solver: str = ""
    how: str = SOLVED
    # A larger load factor and its slip, if the load factor is the least safe one. At load factors
    # between the two, a weighted mean of both slips makes the node critical.
    above: tuple[float, Array] | None = None


def _without_slip(
    question: Question, state: CriticalState, load_factor: float, residual: float, how: str
) -> NodeClaim:
    """The claim that a node is not critical below a load factor."""
    no_slip = np.full(question.system.slip_shape, np.nan)
    return NodeClaim(state, load_factor, no_slip, residual, how=how)


def _claimed(solution: Solution, state: CriticalState, least_so_far: float) -> NodeClaim:
    """The claim of a node from a solution.

    If the slip fails the checks, but the multipliers prove that the node is not critical up to
    `least_so_far`, this proof is the claim.
    """
    question = solution.program.question
    slip = solution.slip_of_nodes
    load_factor = solution.load_factor
    distance = state.distance(question, load_factor, slip)
    residual = solution.residual(question.violation(load_factor, slip), distance)
    at_least, _ = solution.surely
    if not residual <= RESIDUAL and least_so_far < at_least < np.inf:
        return _without_slip(question, state, at_least, 0.0, LEFT_OUT)
    solved = solution.solved("critical", state=state)
    return NodeClaim(state, load_factor, slip, residual, solved)


class CriticalNodes:
    """Load factors of all nodes, and the critical node with the least load factor so far.

    `ends` are the least and the largest safe load factor. `user` are the `UserRows`. `records` has
    the records of all solved programs, in order.
    """

    def __init__(self, question: Question, ends: tuple[float, float], user: Any = None) -> None:
        nodes = question.system.nodes
        self._question = question
        self._user = user
        self._ends = ends
        self.records = list[SolveRecord]()
        self.states = critical_states(question)
        self.best: NodeClaim | None = None
        self.least = ends[1]
        self.load_factor = np.full(nodes, np.inf)
        has_state = np.array([bool(states) for states in self.states])
        self.may_be_critical = has_state & ~question.open_nodes
        self.how = np.full(nodes, ONE_CORNER, dtype=object)
        self.how[question.open_nodes] = OPEN
        self.how[self.may_be_critical] = LEFT_OUT

    def need_no_program(self) -> None:
        """Label all nodes as needing no program: the guaranteed limit is the shakedown limit."""
        self.load_factor[self.may_be_critical] = self.least
        self.how[self.may_be_critical] = NOT_NEEDED

    def left_out(self) -> tuple[str, ...]:
        """Sentences that count the nodes that needed no program, with the reason."""
        sentences = []
        for label, why in _LEFT_OUT.items():
            count = int((self.how == label).sum())
            if count:
                sentences.append(f"nodes: {count} of {len(self.how)} {why}")
        return tuple(sentences)

    def solve(self, node: int) -> None:
        """Find the least load factor at which a node is critical; keep the least of all nodes.

        With `simplify`, a proof that this load factor is above the least so far is enough.
        """
        for state in self.states[node]:
            claim = self._claim(state, self.least if self._question.simplify else np.inf)
            if claim.load_factor < self.load_factor[node] or state is self.states[node][0]:
                self.load_factor[node] = claim.load_factor
                self.how[node] = claim.how
            # A node that is critical only at the shakedown limit, up to rounding, is named, too.
            ties = self.best is None and claim.load_factor < self.least * (1 + RESIDUAL)
            if claim.load_factor < self.least or ties:
                self.best = claim
                self.least = min(self.least, claim.load_factor)

    def _claim(self, state: CriticalState, least_so_far: float) -> NodeClaim:
        """The claim of a node: a slip that makes it critical, or that no such slip matters.

        No such slip matters if a proof shows that the node is critical only above `least_so_far`,
        or never, or only at the least safe load factor.
        """
        least, largest = self._ends
        unit = self._question.load_unit
        # The step is small compared with the interval of safe load factors, and larger than the
        # errors of a solution.
        step = 1e3 * RESIDUAL * min(unit, largest - least)
        indistinct = least + step
        claim = self._solved(state, least_so_far)
        if claim.load_factor > (indistinct if least > 0 else 0.0):
            return claim
        # Up to errors, the load factor is the least safe one. It counts if the node can also be
        # critical above it: the program is convex, so critical load factors form an interval.
        highest = self._solved(state, np.inf, most=unit + least)
        if highest.load_factor > max(indistinct, claim.load_factor + step):
            return replace(claim, above=(highest.load_factor, frozen(highest.slip)))
        return _without_slip(self._question, state, np.inf, highest.residual, COINCIDE_ALONE)

    def _solved(
        self, state: CriticalState, least_so_far: float, most: float | None = None
    ) -> NodeClaim:
        """The claim of a node at its least critical load factor, or at its largest up to `most`."""
        question = self._question
        program = critical(question, state)
        if most is not None:
            program.row("at_most", {"load_factor": -1.0}, most)
        if self._user is not None:
            self._user.add_to(program)

        def claimed(solution: Solution) -> NodeClaim:
            return _claimed(solution, state, least_so_far)

        def never_critical(outcome: str) -> NodeClaim | None:
            found = contradiction(program)
            if found is None:
                return None
            return _without_slip(question, state, np.inf, found[1], NEVER)

        sense = -1.0 if most is None else 1.0
        claim, record = solve(program, claimed, sense, no_optimum=never_critical)
        self.records.append(record)
        return replace(claim, solver=record.solver)

    def table(self, order: list[int]) -> Table:
        """Table of the load factors of some nodes."""
        load_factors = self.load_factor[order]
        return frame({"node": order, "load_factor": load_factors, "how": self.how[order]})


# Numbers of the fixed-point iteration.

# Largest number of iterations.
_ITERATIONS = 300
# A mechanism has converged if an iteration changes it by at most this share.
_SETTLED = RESIDUAL
# Share by which the slips of a mechanism are enlarged, so that it is admissible before it
# converges.
_SPARE = 1e3 * RESIDUAL
# A mechanism that grows to this size diverges.
_LARGE = 1e6
# Number of weighted means of rigid slides in one iteration; more means hardly raise the bounds.
_MEANS = 3
# In the weights, smaller slips are raised to this share of the largest slip, so that the means
# converge.
_NEAR = 1e-2
# Relative rounding error of a bound, due to the errors of the data.
_ROUNDING = CONDENSATION


def load_factor_bounds(question: Question) -> Array:
    """(N,) lower bounds of the load factor at which each node can be critical.

    A bound is 0 if nothing is known, and inf if the node can never be critical.
    """
    nodes = len(question.friction)
    if question.fixed:
        # The corner that governs depends on the load factor.
        return np.zeros(nodes)
    unit = question.node_unit[:, None]
    net_slips = _net_slips(question)
    total_slip, admissible = _settled_mechanisms(net_slips, unit)

    d = net_slips(total_slip) / unit  # (t, N, N) slip of each node in each mechanism
    a = total_slip / unit  # (N, N)
    fa = question.friction[:, None] * a
    shear, bound = needed(question.friction, question.q1, question.p1)
    r0 = question.r0[0]  # (t + 1, N)
    resistance_terms = np.array([_work(d, r0[:-1].T), fa * r0[-1][:, None]])
    drive_terms = _work(d, shear) + a * bound[:, None]
    corners = zip(question.q1, question.p1, strict=True)
    drive_at_other_nodes = np.max([-_work(d, q) - fa * p[:, None] for q, p in corners], axis=0)
    drive_terms = np.where(np.eye(nodes, dtype=bool), drive_terms, drive_at_other_nodes)
    resistance = resistance_terms.sum(axis=(0, 1))
    drive = drive_terms.sum(axis=0)
    terms = np.abs(resistance_terms).sum(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.where(drive < 0, resistance / drive, np.inf) * (1 - _ROUNDING)
    proven = admissible & (resistance < -_ROUNDING * terms)
    return np.where(proven, bounds, 0.0)


def _settled_mechanisms(net_slips: Callable[[Array], Array], unit: Array) -> tuple[Array, Booleans]:
    """(N, N) total slips, one column for each mechanism; (N,) which mechanisms are admissible."""
    total_slip = -np.eye(len(unit))
    for _ in range(_ITERATIONS):
        net = np.linalg.norm(net_slips(total_slip), axis=0)
        size = unit * np.abs(total_slip / unit).max(axis=0)
        next_total = (1 + _SPARE) * net + _SETTLED * size
        np.fill_diagonal(next_total, -1.0)
        np.fill_diagonal(net, -1.0)
        converged = (np.abs(next_total - total_slip) <= _SETTLED * size).all(axis=0)
        admissible: Booleans = (net <= total_slip).all(axis=0) & converged
        diverges = ~(total_slip.max(axis=0) < _LARGE)
        if (admissible | diverges).all():
            break
        total_slip = np.where(admissible | diverges, total_slip, next_total)
    return total_slip, admissible


def _work(d: Array, q: Array) -> Array:
    """Work (N, N) of shear forces (N,) or (N, 2) on slips (t, N, N), by node and mechanism."""
    return np.asarray(np.einsum("tij,it->ij", d, q.reshape(d.shape[1], -1)))


def _net_slips(question: Question) -> Callable[[Array], Array]:
    """A function that returns the net slips (t, N, N) in balance with given total slips (N, N).

    Elasticity does not determine the rigid slides. They are weighted means of the slips over the
    nodes. A weight is the friction bound of a node, divided by its previous slip.
    """
    n = question.system.nodes
    t = question.system.tangents
    closed = elastic(question)
    unit = np.tile(question.node_unit, t)[:, None]
    # The slips that elasticity determines from the total slips, and the rigid slides.
    follow = np.zeros((t * n, n))
    follow[closed.slips] = -(closed.normal * ~question.open_nodes[:, None]).T
    follow *= unit * question.friction / question.node_unit
    free = closed.slides.shape[1]
    rigid = np.zeros((t * n, free))
    rigid[closed.slips] = closed.slides
    rigid *= unit
    pairs = (rigid[:, :, None] * rigid[:, None]).reshape(t * n, -1)
    bound = question.friction * question.r0[0, -1] / question.node_unit
    positive_bound = np.tile(np.maximum(bound, 0.0), t)[:, None]

    def net_slips(total: Array) -> Array:
        slips = follow @ total
        for _ in range(_MEANS if free else 0):
            size = np.linalg.norm(slips.reshape(t, n, n), axis=0)
            floor = _NEAR * size.max() or 1.0
            weight = positive_bound / np.tile(np.maximum(size, floor), (t, 1))
            # The slides s with the least sum of `weight (slips - rigid s)^2`.
            square = (weight.T @ pairs).reshape(n, free, free)
            right_side = (rigid.T @ (weight * slips)).T[..., None]
            slides = (np.linalg.pinv(square, hermitian=True) @ right_side)[..., 0].T
            slips = slips - rigid @ slides
        return slips.reshape(t, n, n)

    return net_slips
