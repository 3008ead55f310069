"""The load factors at which one node is critical while the slip is safe at all others, and proofs. The program is in the theory, eq. (10).

The node's own rows hold by construction, except under fixed parts; they are loose, so that the program has an interior. If the least load factor is
the least safe one, a second problem finds the largest up to a load unit above it: at the least safe one alone some node is critical anyhow.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cvxpy as cp
import numpy as np

from ..contact import RESIDUAL, Array, SolveRecord, frozen
from ..solve.problem import put_back, standing
from .answered import Mechanism
from .critical_state import CriticalState, NeededByNode
from .models import Row, Unknowns, at_node, critical, named, stuck
from .programs import Program, listed_rows
from .question import Question

_COINCIDE = 1e3 * RESIDUAL  # dimensionless load factors up to this cannot be told from zero: residuals move them so far

SOLVED, NEVER, COINCIDE_ALONE, LEFT_OUT = "solved", "never critical", "only at the least safe load factor", "left out by its bound"


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is critical under a safe slip; inf where there is none, and a slip of NaN."""

    state: CriticalState
    load_factor: float
    slip: Array
    residual: float
    motion: Mechanism | None = None  # see `critical_motion`; None where another node has less
    program: Program | None = None  # that it is the answer of; None where there is no slip
    values: Mapping[cp.Variable, Array] = field(default_factory=dict)  # what then stands in its variables
    solver: str = ""
    how: str = SOLVED  # how it is known
    above: tuple[float, Array] | None = None  # if it is the least safe load factor: a larger one, and the slip there; those between mix the two


class CriticalSearch:
    """The problems of all nodes over the safe slips of a question, compiled once for each sense and for any friction. `records` are in order."""

    def __init__(self, x: Unknowns, task: Question, own: Mapping[str, Row], solver: str | None) -> None:
        self._x, self._task, self._own, self._solver, self.records = x, task, own, solver, list[SolveRecord]()
        self._node, self._loose, self._f = (cp.Parameter(task.system.nodes, nonneg=True, name=name) for name in ("node", "loose", "f"))
        self._most = cp.Parameter(name="most")
        self._needed = NeededByNode(self._f, self._node, task.parts, task.fixed)
        self._parameters = self._needed.parameters(task.system.tangents)
        self._programs: dict[bool, Program] = {}

    def ask(self, task: Question) -> None:
        """Set the question, of another friction."""
        self._task, self.records = task, list[SolveRecord]()

    def solve(self, state: CriticalState, ends: tuple[float, float], found: float) -> NodeClaim:
        """The claim of one node that passes its checks, of a contact that is safe between two load factors; or that it is not below that `found`."""
        unit = self._task.load_unit
        claim = self._solved(state, found)
        least, step = ends[0], _COINCIDE * min(unit, ends[1] - ends[0])  # small beside the interval of safe load factors
        beyond = least + step  # cannot be told from the least safe one
        if claim.load_factor > (beyond if least > 0 else 0.0):
            return claim
        # it counts if the node can be critical above too: the load factors at which it can are an interval, for the problem is convex
        self._most.value = unit + least
        highest = self._solved(state, np.inf, highest=True)
        if highest.load_factor > max(beyond, claim.load_factor + step):
            return replace(claim, above=(highest.load_factor, frozen(highest.slip)))
        return NodeClaim(state, np.inf, np.full_like(claim.slip, np.nan), highest.residual, how=COINCIDE_ALONE)

    def restore(self, claim: NodeClaim) -> None:
        """Put an answer into its program, which may have been solved for other nodes since."""
        self._set(claim.state)
        put_back(claim.values)

    def _set(self, state: CriticalState) -> None:
        task, own = self._task, (np.arange(self._task.system.nodes) == state.node).astype(float)
        self._node.value, self._loose.value, self._f.value, self._needed.corners = own, own * task.node_unit, task.friction, state.corners

    def _solved(self, state: CriticalState, found: float, highest: bool = False) -> NodeClaim:
        self._set(state)
        program = self._program(highest)

        def never() -> NodeClaim | None:
            none = program.chain.contradiction()
            return None if none is None else NodeClaim(state, np.inf, np.full(program.task.system.slip_shape, np.nan), none.residual, how=NEVER)

        claim, record = program.chain.solve(lambda: _claimed(program, state, found), self._solver, no_optimum=never)
        self.records.append(record)
        return replace(claim, solver=record.solver)

    def _program(self, highest: bool) -> Program:
        if highest not in self._programs:
            task, x, given = self._task, self._x, self._parameters

            def friction(x: Unknowns, corners: list[int]) -> list[Row]:
                return stuck(x, self._f, corners, None if task.fixed else self._loose)

            program = listed_rows(task, x, self._f, every=bool(self._own), friction=friction)
            program.own, rows = self._own, program.rows + ([(x.load_factor <= self._most).set_label("at_most")] if highest else [])
            problem = critical(x, self._node, self._load(), (given["c"], given["rho"]), cp.Maximize if highest else cp.Minimize, rows)
            self._programs[highest] = program.compiled(problem, task.load_unit)
        self._programs[highest].ask(self._task, self._task.load_unit)
        return self._programs[highest]

    def _load(self) -> list[cp.Expression]:
        """What the node carries at load factor 0, by the names of the shear and of the normal forces."""
        if self._task.fixed:
            return [self._parameters["c0"], self._parameters["rho0"]]
        return [at_node(self._node, named(self._task.parts[part][0], name)) for part, name in enumerate(("q0", "p0"))]


def _claimed(program: Program, state: CriticalState, found: float) -> NodeClaim:
    """The claim that stands in a program; if it does not pass, the claim that the node is not critical below `found`, if multipliers prove that."""
    task, slip, load_factor, proof = program.task, program.slip, program.load_factor, program.chain.proof
    (q, p), node = task.change(slip), state.node
    off = float(np.abs(np.r_[q[node], p[node]] - state.at_zero - load_factor * state.rate).max()) / task.force
    residual, least = np.max([task.violation(load_factor, slip), off, proof.gap, program.own_violation]), proof.bound - proof.defect
    if not residual <= RESIDUAL and found < least < np.inf:
        return NodeClaim(state, least, np.full_like(slip, np.nan), 0.0, how=LEFT_OUT)
    motion = critical_motion(program, state) if load_factor < found else None
    return NodeClaim(state, load_factor, slip, float(np.nan_to_num(residual, nan=np.inf)), motion, program, standing(program.problem))


def critical_motion(program: Program, state: CriticalState) -> Mechanism:
    """The rates of a node's load factor with all reactions, as slips and lifts of either sign, from the multipliers of its solved program.

    Other nodes: the mechanism of their rows, reversed. The node itself: slips along or against `q_k` at its corners, which open by friction; what is
    across two opposed corners moves the state between them by its lever.
    """
    task, f, node, corners = program.task, program.task.friction, state.node, list(state.corners)
    others = program.motion
    moves = -others.moves
    y = np.concatenate([np.ravel(row.dual_value) for row in program.problem.constraints if row.label in ("critical_q", "critical_p")])
    q = task.states(program.load_factor, program.slip)[1][corners, :-1, node]
    size = np.linalg.norm(q, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        ways = np.column_stack([q / size[:, None], np.full(len(corners), -f[node])])
        levers = (size.sum() - size) / ((len(corners) - 1) * size.sum())
    shares = np.linalg.lstsq(ways.T, y, rcond=None)[0] if np.isfinite(ways).all() else np.full(len(corners), np.nan)
    own = np.zeros_like(moves)
    own[corners, :, node] = shares[:, None] * ways + levers[:, None] * (y - shares @ ways)
    if task.give is not None:  # open nodes follow
        own -= (own.reshape(len(own), -1) @ task.system.S @ task.give).reshape(own.shape)
    return replace(others, moves=moves + own)
