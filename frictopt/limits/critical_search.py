"""Programs of the least load factor at which a node is critical, and their results, the claims."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cvxpy as cp
import numpy as np

from ..base import RESIDUAL, Array, SolveRecord, Table, frame, frozen
from ..solve.problem import put_back, standing
from .answered import Mechanism
from .critical_state import CriticalState, NeededByNode, critical_states
from .models import Row, Unknowns, at_node, constant, critical, stuck
from .programs import Program, listed_rows
from .question import Question

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
    # The solved program (None without a slip), and the values of its variables.
    program: Program | None = None
    values: Mapping[cp.Variable, Array] = field(default_factory=dict)
    solver: str = ""
    how: str = SOLVED
    # If the load factor is the least safe one: a larger load factor and its slip. At load factors
    # between the two, a weighted mean of both slips makes the node critical.
    above: tuple[float, Array] | None = None


class CriticalSearch:
    """The critical programs of all nodes of a question, compiled once for any friction.

    `records` has the records of all solved programs, in order.
    """

    def __init__(
        self, x: Unknowns, question: Question, user_rows: Mapping[str, Row], solver: str | None
    ) -> None:
        nodes = question.system.nodes
        self.records = list[SolveRecord]()
        self._x = x
        self._question = question
        self._user_rows = user_rows
        self._solver = solver
        self._node = cp.Parameter(nodes, nonneg=True, name="node")
        self._loose = cp.Parameter(nodes, nonneg=True, name="loose")
        self._f = cp.Parameter(nodes, nonneg=True, name="f")
        self._most = cp.Parameter(name="most")
        parts = question.q0, question.p0, question.q1, question.p1
        self._needed = NeededByNode(self._f, self._node, parts, question.fixed)
        self._parameters = self._needed.parameters(question.system.tangents)
        self._programs: dict[bool, Program] = {}

    def set_question(self, question: Question) -> None:
        """Set the question, which may have another friction."""
        self._question = question
        self.records = []

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
        self._most.value = unit + least
        highest = self._solved(state, np.inf, highest=True)
        if highest.load_factor > max(indistinct, claim.load_factor + step):
            return replace(claim, above=(highest.load_factor, frozen(highest.slip)))
        return _without_slip(self._question, state, np.inf, highest.residual, COINCIDE_ALONE)

    def restore(self, claim: NodeClaim) -> None:
        """Put an answer back into its program, which may have been solved for other nodes."""
        self._set(claim.state)
        put_back(claim.values)

    def _set(self, state: CriticalState) -> None:
        question = self._question
        marks = (np.arange(question.system.nodes) == state.node).astype(float)
        self._node.value = marks
        self._loose.value = marks * question.node_unit
        self._f.value = question.friction
        self._needed.corners = state.corners

    def _solved(
        self, state: CriticalState, least_so_far: float, highest: bool = False
    ) -> NodeClaim:
        """The claim of a node at its least (highest) critical load factor."""
        self._set(state)
        program = self._program(highest)

        def never_critical() -> NodeClaim | None:
            contradiction = program.chain.contradiction()
            if contradiction is None:
                return None
            return _without_slip(self._question, state, np.inf, contradiction.residual, NEVER)

        claim, record = program.chain.solve(
            lambda: _claimed(program, state, least_so_far), self._solver, no_optimum=never_critical
        )
        self.records.append(record)
        return replace(claim, solver=record.solver)

    def _program(self, highest: bool) -> Program:
        if highest not in self._programs:
            self._programs[highest] = self._compiled(highest)
        program = self._programs[highest]
        program.set_question(self._question, self._question.load_unit)
        return program

    def _compiled(self, highest: bool) -> Program:
        """The program of the marked node.

        The friction rows of this node hold by construction, unless a part of the cycle is fixed.
        They are relaxed, so that the program has interior points.
        """
        question = self._question
        x = self._x
        loose = None if question.fixed else self._loose

        def friction(x: Unknowns, corners: list[int]) -> list[Row]:
            return stuck(x, self._f, corners, loose)

        program = listed_rows(question, x, self._f, every=bool(self._user_rows), friction=friction)
        program.user_rows = self._user_rows
        rows = list(program.rows)
        if highest:
            rows.append((x.load_factor <= self._most).set_label("at_most"))
        needed = self._parameters["c"], self._parameters["rho"]
        sense = cp.Maximize if highest else cp.Minimize
        problem = critical(x, self._node, self._load(), needed, sense, rows)
        return program.compiled(problem, question.load_unit)

    def _load(self) -> list[cp.Expression]:
        """The shear and the normal force of the node at load factor 0, by their names."""
        question = self._question
        if question.fixed:
            return [self._parameters["c0"], self._parameters["rho0"]]
        return [
            at_node(self._node, constant(question.q0[0], "q0")),
            at_node(self._node, constant(question.p0[0], "p0")),
        ]


def _without_slip(
    question: Question, state: CriticalState, load_factor: float, residual: float, how: str
) -> NodeClaim:
    """The claim that a node is not critical below a load factor."""
    no_slip = np.full(question.system.slip_shape, np.nan)
    return NodeClaim(state, load_factor, no_slip, residual, how=how)


def _claimed(program: Program, state: CriticalState, least_so_far: float) -> NodeClaim:
    """The claim from a solved program.

    If its slip fails the checks, but the multipliers prove that the node is not critical up to
    `least_so_far`, the claim is this proof.
    """
    question = program.question
    slip = program.slip
    load_factor = program.load_factor
    proof = program.chain.proof
    q, p = question.reactions_of_slip(slip)
    added = np.r_[q[state.node], p[state.node]]
    critical_reaction = state.at_zero + load_factor * state.rate
    distance = float(np.abs(added - critical_reaction).max()) / question.force
    violations = [
        question.violation(load_factor, slip),
        distance,
        proof.gap,
        program.user_violation,
    ]
    residual = float(np.nan_to_num(np.max(violations), nan=np.inf))
    bound = proof.bound - proof.defect
    if not residual <= RESIDUAL and least_so_far < bound < np.inf:
        return _without_slip(question, state, bound, 0.0, LEFT_OUT)
    motion = critical_motion(program, state) if load_factor < least_so_far else None
    values = standing(program.problem)
    return NodeClaim(state, load_factor, slip, residual, motion, program, values)


def critical_motion(program: Program, state: CriticalState) -> Mechanism:
    """The rates of a node's load factor with all reactions, as slips and lifts of either sign.

    They follow from the multipliers. The motions of the other nodes are the reversed mechanism of
    their rows. The node itself slips along or against `q_k` at its corners, and lifts by friction
    times its slip. With two opposite corners, the part of the multiplier across their line is
    divided between the corners by the lever rule.
    """
    question = program.question
    node = state.node
    corners = list(state.corners)
    mechanism = program.motion
    moves = -mechanism.moves

    labels = ("critical_q", "critical_p")
    rows = [row for row in program.problem.constraints if row.label in labels]
    y = np.concatenate([np.ravel(row.dual_value) for row in rows])  # (t + 1,)
    _, r = question.states(program.load_factor, program.slip)
    q = r[corners, :-1, node]  # (corners, t)
    size = np.linalg.norm(q, axis=1)
    friction = program.question.friction[node]
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
        if claim.load_factor < self.least:
            self.best = claim
            self.least = claim.load_factor

    def table(self, order: list[int]) -> Table:
        """Table of the load factors of some nodes."""
        load_factors = self.load_factor[order]
        return frame({"node": order, "load_factor": load_factors, "how": self.how[order]})
