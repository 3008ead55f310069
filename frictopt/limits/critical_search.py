"""Programs of the least load factor at which a node is critical, and their results, the claims."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base import RESIDUAL, Array, SolveRecord, Table, frame, frozen
from ..solve.arrays import Arrays
from . import assembled
from .critical_state import CriticalState, critical_states
from .mechanism import Mechanism
from .question import Question
from .solution import Solution, contradiction, solve
from .solved import Solved

# Labels: the source of the load factor of a node.
SOLVED = "solved"
NEVER = "never critical"
COINCIDE_ALONE = "only at the least safe load factor"
LEFT_OUT = "left out by its bound"
ONE_CORNER = "one corner alone governs"
NOT_NEEDED = "not needed"
OPEN = "open"

# The reason that some nodes needed no program, after their number.
_LEFT_OUT = {
    NOT_NEEDED: (
        "need no program: lambda_1 is lambda_2, because the contact is uncoupled (B = 0) or no "
        "load factors lie between the two"
    ),
    LEFT_OUT: "cannot be critical below the limit, by a lower bound",
    ONE_CORNER: "can only lift off when critical, or have no friction",
}


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is critical under a safe slip, and that slip.

    Without such a slip the load factor is inf or a lower bound, and the slip is NaN.
    """

    state: CriticalState
    load_factor: float
    slip: Array
    residual: float
    # The rates of the load factor, see `critical_motion`; None if another node has a lower one.
    motion: Mechanism | None = None
    # The solved program; None without a slip.
    solved: Solved | None = None
    solver: str = ""
    how: str = SOLVED
    # If the load factor is the least safe one: a larger load factor and its slip. At load factors
    # between the two, a weighted mean of both slips makes the node critical.
    above: tuple[float, Array] | None = None


class CriticalSearch:
    """The critical programs of the nodes of a question.

    `records` has the records of all solved programs, in order. `user`: the `UserRows`.
    """

    def __init__(self, question: Question, user: Any, solver: str | None) -> None:
        self.records = list[SolveRecord]()
        self._question = question
        self._user = user
        self._solver = solver

    def solve(
        self, state: CriticalState, ends: tuple[float, float], least_so_far: float
    ) -> NodeClaim:
        """The claim of a node: its critical slip, or the proof that it is above `least_so_far`.

        `ends` are the least and the largest safe load factor.
        """
        least, largest = ends
        unit = self._question.load_unit
        # The step is small compared with the interval of safe load factors, and above the errors of
        # an answer.
        step = 1e3 * RESIDUAL * min(unit, largest - least)
        indistinct = least + step
        claim = self._solved(state, least_so_far)
        if claim.load_factor > (indistinct if least > 0 else 0.0):
            return claim

        # The load factor equals the least safe one up to errors. It counts if the node can also be
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
        program = assembled.critical(question, state)
        if most is not None:
            program.row("at_most", {"load_factor": -1.0}, most)
        if self._user is not None:
            self._user.add_to(program)

        def claimed(solution: Solution) -> NodeClaim:
            return _claimed(solution, state, least_so_far)

        def never_critical(outcome: str, arrays: Arrays) -> NodeClaim | None:
            found = contradiction(program, "load_factor")
            if found is None:
                return None
            return _without_slip(question, state, np.inf, found[1], NEVER)

        sense = -1.0 if most is None else 1.0
        claim, record = solve(
            program, "load_factor", sense, claimed, self._solver, no_optimum=never_critical
        )
        assert claim is not None
        self.records.append(record)
        return replace(claim, solver=record.solver)


def _without_slip(
    question: Question, state: CriticalState, load_factor: float, residual: float, how: str
) -> NodeClaim:
    """The claim that a node is not critical below a load factor."""
    no_slip = np.full(question.system.slip_shape, np.nan)
    return NodeClaim(state, load_factor, no_slip, residual, how=how)


def _claimed(solution: Solution, state: CriticalState, least_so_far: float) -> NodeClaim:
    """The claim of a solution.

    If its slip fails the checks, but the multipliers prove that the node is not critical up to
    `least_so_far`, the claim is this proof.
    """
    question = solution.program.question
    slip = solution.slip_of_nodes
    load_factor = solution.load_factor
    distance = state.distance(question, load_factor, slip)
    residual = solution.residual(question.violation(load_factor, slip), distance)
    bound, defect = solution.bound
    if not residual <= RESIDUAL and least_so_far < bound - defect < np.inf:
        return _without_slip(question, state, bound - defect, 0.0, LEFT_OUT)
    motion = critical_motion(solution, state) if load_factor < least_so_far else None
    solved = solution.solved("critical", state=state)
    return NodeClaim(state, load_factor, slip, residual, motion, solved)


def critical_motion(solution: Solution, state: CriticalState) -> Mechanism:
    """The rates of a node's load factor with all reactions, as slips and lifts of either sign.

    They follow from the multipliers. The motions of the other nodes are the reversed mechanism of
    their rows. The node itself slips along or against `q_k` at its corners, and lifts by friction
    times its slip. With two opposite corners, the part of the multiplier across their line is
    divided between the corners by the lever rule.
    """
    question = solution.program.question
    node = state.node
    corners = list(state.corners)
    mechanism = solution.motion
    moves = -mechanism.moves

    y = np.concatenate([solution.multipliers[name] for name in ("critical_q", "critical_p")])
    _, r = question.states(solution.load_factor, solution.slip_of_nodes)
    q = r[corners, :-1, node]  # (corners, t)
    size = np.linalg.norm(q, axis=1)
    friction = question.friction[node]
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.column_stack([q / size[:, None], np.full(len(corners), -friction)])
        levers = (size.sum() - size) / ((len(corners) - 1) * size.sum())
    shares = np.full(len(corners), np.nan)
    if np.isfinite(along).all():
        shares = np.linalg.lstsq(along.T, y, rcond=None)[0]
    node_moves = np.zeros_like(moves)
    node_moves[corners, :, node] = shares[:, None] * along + levers[:, None] * (y - shares @ along)
    if question.compliance is not None:
        follow = node_moves.reshape(len(node_moves), -1) @ question.system.S @ question.compliance
        node_moves -= follow.reshape(node_moves.shape)
    return replace(mechanism, moves=moves + node_moves)


class CriticalNodes:
    """Load factors of all nodes, and the critical node with the least load factor so far."""

    def __init__(self, question: Question, load_factor: float) -> None:
        nodes = question.system.nodes
        self.states = critical_states(question)
        self.best: NodeClaim | None = None
        self.least = load_factor
        self.load_factor = np.full(nodes, np.inf)
        has_state = np.array([bool(states) for states in self.states])
        self.may_be_critical = has_state & ~question.open_nodes
        self.how = np.full(nodes, ONE_CORNER, dtype=object)
        self.how[question.open_nodes] = OPEN
        self.how[self.may_be_critical] = LEFT_OUT

    def need_no_program(self) -> None:
        """Mark all nodes as not needed: the guaranteed limit is the shakedown limit."""
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

    def add(self, claim: NodeClaim) -> None:
        """Keep a claim of a node if it is its first one, or if its load factor is the least."""
        node = claim.state.node
        if claim.load_factor < self.load_factor[node] or claim.state is self.states[node][0]:
            self.load_factor[node] = claim.load_factor
            self.how[node] = claim.how
        # A node that is critical at the shakedown limit itself, up to rounding, is named, too.
        ties = self.best is None and claim.load_factor < self.least * (1 + RESIDUAL)
        if claim.load_factor < self.least or ties:
            self.best = claim
            self.least = min(self.least, claim.load_factor)

    def table(self, order: list[int]) -> Table:
        """Table of the load factors of some nodes."""
        load_factors = self.load_factor[order]
        return frame({"node": order, "load_factor": load_factors, "how": self.how[order]})
