"""The load factors at which one node is critical while the slip is safe at all others, as a cvxpy problem with the node as a parameter, and proofs.

A node is critical where a safe slip leaves it no more pressure than it needs, see `critical_states`: in the plane it is on both its bounds, in space
on its friction circle at opposed corners, or at three that surround. With its rho and c::

    min lam    s.t.   p0 + B v = lam rho  and  q0 + A v = lam c  at node i,   v safe at lam at all other nodes,   |v| <= slip bound

Its own rows hold by construction, and are loose: without them the program has an interior. (Where a part of the cycle is fixed they need not hold,
and stay.) If no such slip exists, a second problem proves it: it minimises the largest violation of the node's equations, and the minimum is
positive. A third problem finds the largest load factor of such slips, up to a load unit above the least safe one. It is needed where the least one of
a node is the least safe load factor of the contact. At 0 all corners coincide, and a node without reaction is critical whatever the cyclic load is;
at one above 0 the corners press no node more than its shear needs, so that some node is critical. Either may be so at that load factor alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

import cvxpy as cp
import numpy as np

from ..contact import RESIDUAL, ZERO_LOAD_FACTOR, Array, SolveRecord, frozen
from ..solve.solvers import solve
from ..solve.standard_form import StandardForm
from .answered import Mechanism
from .critical_state import CriticalState
from .parts import on_whole
from .safe_set import SafeSet

_COINCIDE = 1e3 * RESIDUAL  # dimensionless load factors up to this cannot be told from zero: residuals move them so far

SOLVED, NEVER, COINCIDE_ALONE, LEFT_OUT = "solved", "never critical", "only at the least safe load factor", "left out by its bound"


class Aim(Enum):
    """What is looked for among the slips with which a node is critical."""

    LEAST = "least load factor"
    EXCESS = "least excess over the equations, at whatever load factor is best"
    HIGHEST = "largest load factor, up to a given one"


def critical_problem(safe: SafeSet, aim: Aim) -> cp.Problem:
    """The problem of one node at a time over the safe slips of a `shakedown_problem`; `set_node` sets its parameters."""
    lam, traction, task = safe.load_factor, safe.traction, safe.task
    axes = task.system.tangents + 1
    change = cp.Parameter((axes, traction.size), name="node_rows") @ traction  # [A v, B v] of the node
    off = change - cp.Parameter(axes, name="node_at_zero") - cp.Parameter(axes, name="node_rate") * lam
    excess = cp.Variable(name="excess")
    rows: dict[str, cp.Constraint] = {"critical": off == 0}
    if aim is Aim.EXCESS:
        rows = {"critical": off <= excess, "critical_from_below": off >= -excess}
    if aim is Aim.HIGHEST:
        rows["load_factor_at_most"] = lam <= cp.Parameter(nonneg=True, name="most_load_factor")
    stuck = {} if task.fixed else safe.stuck(lam, spare=cp.Parameter(len(task.friction), name="spare", nonneg=True))
    others = [row for row in safe.problem.constraints if row.label not in stuck or any(row is own for own in safe.own.rows)]
    goal = {Aim.LEAST: cp.Minimize(lam), Aim.EXCESS: cp.Minimize(excess), Aim.HIGHEST: cp.Maximize(lam)}[aim]
    return cp.Problem(goal, [*others, *(row.set_label(name) for name, row in {**stuck, **rows}.items())])


def set_node(program: SafeSet, state: CriticalState) -> None:
    """Set the node that is critical."""
    task, n = program.task, len(program.task.friction)
    unit, values = program.unit[state.node], program.problem.param_dict
    values["node_rows"].value = np.vstack([program.to_shear[state.node :: n].toarray(), program.to_pressure[state.node]])
    values["node_at_zero"].value, values["node_rate"].value = state.at_zero / unit, state.rate * task.load_unit / unit
    if "spare" in values:
        values["spare"].value = (np.arange(n) == state.node).astype(float)


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is critical under a safe slip; inf where there is none.

    Attributes
    ----------
    state
        The node, and its critical state.
    load_factor, slip
        The least load factor and the slip there, (N,) or (N, 2) (NaN where there is none).
    residual
        Its largest violation, or the distance from what the multipliers prove.
    motion
        How the load factor changes with the bonded reactions at each corner, see `critical_motion`; None where another node has less.
    program, values
        The program that it is the answer of, and what then stands in its variables; None and nothing where there is no slip.
    solver
        The one whose answer it is.
    how
        How it is known: it may be critical nowhere, or at the least safe load factor of the contact alone, or its load factor may be a lower bound.
    above
        Of a least load factor that is the least safe one: a larger one at which the node is critical too, and the slip there. Those
        between mix the two.
    """

    state: CriticalState
    load_factor: float
    slip: Array
    residual: float
    motion: Mechanism | None = None
    program: SafeSet | None = None
    values: Mapping[cp.Variable, Array] = field(default_factory=dict)
    solver: str = ""
    how: str = SOLVED
    above: tuple[float, Array] | None = None


class CriticalSearch:
    """The problems of all nodes over the safe slips of a program with its parameters set, compiled once for any friction.

    Parameters
    ----------
    solver
        Use this one alone.

    Attributes
    ----------
    records
        How the programs were solved, in order.
    """

    def __init__(self, solver: str | None) -> None:
        self._solver, self.records = solver, list[SolveRecord]()
        self._compiled: dict[Aim, tuple[cp.Problem, cp.Problem]] = {}

    def solve(self, safe: SafeSet, state: CriticalState, ends: tuple[float, float], found: float) -> NodeClaim:
        """The claim of one node that passes its checks, of a contact that is safe between two load factors; or that it is not below the one `found`.

        Raises
        ------
        SolverError
            No solver gave an answer that passes.
        """
        program = self._program(safe, state, Aim.LEAST)
        claim = self._solved(lambda: _claimed(program, state, found), program, lambda: self._proof_of_absence(safe, state))
        least, step = ends[0], _COINCIDE * min(safe.task.load_unit, ends[1] - ends[0])  # small beside the interval of safe load factors
        beyond = least + step  # cannot be told from the least safe one
        if claim.load_factor > (beyond if least > 0 else 0.0):
            return claim
        # it counts if the node can be critical above too: the load factors at which it can are an interval, for the problem is convex
        program = self._program(safe, state, Aim.HIGHEST)
        program.problem.param_dict["most_load_factor"].value = 1.0 + least / safe.task.load_unit
        highest = self._solved(lambda: _claimed(program, state, np.inf), program)
        if highest.load_factor > max(beyond, claim.load_factor + step):
            return replace(claim, above=(highest.load_factor, frozen(highest.slip)))
        return NodeClaim(state, np.inf, np.full_like(claim.slip, np.nan), highest.residual, how=COINCIDE_ALONE)

    def _solved(self, claimed: Callable[[], NodeClaim], program: SafeSet, never: Callable[[], NodeClaim | None] | None = None) -> NodeClaim:
        claim, record = solve(program.problem, claimed, self._solver, no_optimum=never)
        self.records.append(record)
        return replace(claim, solver=record.solver)

    def _program(self, safe: SafeSet, state: CriticalState, aim: Aim) -> SafeSet:
        if aim not in self._compiled or self._compiled[aim][0] is not safe.problem:
            self._compiled[aim] = safe.problem, critical_problem(safe, aim)
        program = safe.posed(self._compiled[aim][1], safe.own)
        set_node(program, state)
        return program

    def _proof_of_absence(self, safe: SafeSet, state: CriticalState) -> NodeClaim | None:
        """Proof that no safe slip at any load factor makes the node critical; None where there is none."""
        program = self._program(safe, state, Aim.EXCESS)

        def claimed() -> NodeClaim:
            value, bound = StandardForm(program.problem).bounds  # of minus the excess
            slip, proven = np.full((len(safe.unit), *safe.task.system.slip_shape[1:]), np.nan), -bound > RESIDUAL
            return NodeClaim(state, np.inf, slip, 0.0 if proven else abs(value - bound), how=NEVER if proven else SOLVED)

        claim = self._solved(claimed, program)
        return claim if claim.how == NEVER else None


def _claimed(program: SafeSet, state: CriticalState, found: float) -> NodeClaim:
    """The claim that stands in a program, with the larger of the violations by its slip and the distance of what the multipliers prove.

    If it does not pass, but the multipliers prove that the node is not critical below the load factor `found`, the claim is that.
    """
    task, factor, slip = program.task, float(program.load_factor.value), program.solved_slip
    load_factor = (factor if factor > ZERO_LOAD_FACTOR else 0.0) * task.load_unit
    (q, p), node = task.change(slip), state.node
    off = float(np.abs(np.r_[q[node], p[node]] - state.at_zero - load_factor * state.rate).max()) / task.force
    form = StandardForm(program.problem)
    unsafe, least = (task.whole or task).violation(load_factor, on_whole(task, slip, None)[1]), -form.bounds[1] * task.load_unit
    residual = max(unsafe, off, form.gap, program.own.violation)
    if not residual <= RESIDUAL and least > found:
        return NodeClaim(state, least, np.full_like(slip, np.nan), 0.0, how=LEFT_OUT)
    motion, values = critical_motion(program, state) if load_factor < found else None, {each: each.value for each in program.problem.variables()}
    return NodeClaim(state, load_factor, slip, float(np.nan_to_num(residual, nan=np.inf)), motion, program, values)


def critical_motion(program: SafeSet, state: CriticalState) -> Mechanism:
    """The rates of a node's load factor with all reactions, as slips and lifts of either sign, from the multipliers of its solved program.

    More room at the other nodes lowers the load factor: their part is the mechanism of their rows the other way round. That of the node itself
    follows its bounds `|q_k| = f p_k` at its corners, which give its state: it is the sum of slips along or against `q_k` there, which open by
    friction. What is across two opposed corners moves the state between them by its lever.
    """
    task, f, node, corners = program.task, program.task.friction, state.node, list(state.corners)
    others, _ = program.motion()
    moves = -others.moves * task.load_unit
    y = np.atleast_1d(program.rows["critical"].dual_value) * task.load_unit / program.unit[node]
    q = task.states(float(program.load_factor.value) * task.load_unit, program.solved_slip)[1][corners, :-1, node]
    size = np.linalg.norm(q, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        ways = np.column_stack([q / size[:, None], np.full(len(corners), -f[node])])
        levers = (size.sum() - size) / ((len(corners) - 1) * size.sum())
    shares = np.linalg.lstsq(ways.T, y, rcond=None)[0] if np.isfinite(ways).all() else np.full(len(corners), np.nan)
    own = shares[:, None] * ways + levers[:, None] * (y - shares @ ways)
    moves[corners, :, node] += own
    press = None if others.press is None else -others.press * task.load_unit
    return Mechanism(moves, f, press=press)
