"""The guaranteed limit lambda_1: the load factor below which the contact stops slipping from every start."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, flag, frozen
from ..contact.record import Recorded, SolveRecord
from ..solve.explain import Units, explain
from ..solve.portable import Portable
from ..solve.solvers import solver_order
from .both_bounds_search import BothBoundsSearch, NodeClaim, two_corners
from .closed_form import is_uncoupled
from .kinds import LimitKind
from .posed import LimitQuestion, cycle_loads
from .screening import load_factor_bounds
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit
from .slip_bound import slip_bounds

__all__ = ["GuaranteedLimit", "GuaranteedModel", "guaranteed_limit"]

_SOLVED, _NEVER, _COINCIDE = "solved", "never on both bounds", "only where it carries nothing"
_LEFT_OUT, _IMAGE, _ONE_CORNER, _NOT_NEEDED = "left out by its bound", "mirror image", "one corner rules both bounds", "not needed"


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteedLimit(Recorded, Portable):
    """The guaranteed limit, and a residual slip from which the contact keeps slipping just above it.

    Attributes
    ----------
    load_factor
        lambda_1, never above lambda_2: the least load factor at which a safe slip holds some node on both its bounds, forward slip at one corner and
        backward slip at another; lambda_2 where none does below. Inf or nan with lambda_2. At 0, where both bounds of a node that carries nothing
        coincide, it counts only if such slips go on above 0.
    kind, reason
        Whether it is finite, and why it is what it is in words.
    proven
        Whether it is a theorem that slip stops below it from every start: for uncoupled contacts (Klarbring, Ciavarella & Barber 2007), and where
        nothing is safe. Otherwise it is an upper bound of the load factor up to which that holds.
    slip
        (N,) the witness: safe at the limit, with `node` on both its bounds, length. Where no node comes to be there below lambda_2, the safe slip at
        lambda_2. NaN where the limit is not finite.
    node
        The node that starts to slip to and fro; None where lambda_2 rules.
    corners
        The two load corners at which it is on the bound of forward and of backward slip; None where lambda_2 rules.
    skipped
        Number of nodes left out because their lower bound is not below the least load factor found.
    record
        How it was found; the solver is that of `node`. Its `residual` is the largest of: the violations of the contact law by `slip` at the corners,
        the distance of `node` from its bounds, and the relative distance of the program's dual bound, over all programs solved. At most 1e-9.
    shakedown
        The shakedown limit lambda_2, under the same slip bound.
    problem
        The solved cvxpy problem of `node` (in turn of the last one solved); None where none was needed, or in a copy.
    """

    load_factor: float
    kind: LimitKind
    reason: str
    proven: bool
    slip: Array = field(repr=False)
    node: int | None
    corners: tuple[int, int] | None
    skipped: int
    record: SolveRecord
    shakedown: ShakedownLimit = field(repr=False)
    problem: cp.Problem | None = field(repr=False)
    _task: LimitQuestion = field(repr=False)
    _least: Array = field(repr=False)
    _how: tuple[str, ...] = field(repr=False)
    _units: Units = field(repr=False)
    _above: tuple[float, Array] | None = field(repr=False)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x, load_factor, how it was found, and the slip of the witness.

        load_factor is the least at which a safe slip holds the node on both its bounds, inf if none does; where the node was left out by its bound, a
        lower bound of it.
        """
        return pd.DataFrame(
            {"node": np.arange(len(self._how)), "x": self._task.system.x, "load_factor": self._least, "how": self._how, "slip": self.slip}
        )

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the witness, at the limit, force per depth; NaN where it is not finite."""
        if not np.isfinite(self.load_factor):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.load_factor, self.slip)

    def witness_above_zero(self, most: float) -> tuple[float, Array] | None:
        """Where the limit is 0: a load factor above 0, at most `most`, and the (N,) safe slip that holds `node` on both its bounds there, length.

        Slip goes on from it at a load factor just above or, of a load that presses the contact, just below. None where the limit is not 0.
        """
        most = finite_number("most", most, above=0.0)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = load_factor / self._above[0]
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def answers(self, system: ContactSystem, cycle: LoadCycle, friction: Any) -> bool:
        """Whether it is the limit of this system, load cycle and friction."""
        return self._task.same_input(LimitQuestion(system, cycle, cycle_loads(system, cycle), friction, False))

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("load_factor", "kind", "proven", "node", "residual", "reason")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("guaranteed limit", self.problem, self.load_factor, self._units, self.record.left_out, pd.DataFrame(), file, self.reason)


class GuaranteedModel:
    """The guaranteed limit of one system under one load cycle, compiled once and solved for any friction.

    Not for use by several threads at once: give each its own.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        See `ShakedownModel`.
    simplify
        Leave out what the scene does not need: nodes whose lower bound says that they cannot win, mirror images. The answer is the same either way.
        An uncoupled contact has lambda_1 = lambda_2 by a theorem, and no programs of its own.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None) -> None:
        self._shakedown = ShakedownModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify)
        solver_order(solver)
        self._search = BothBoundsSearch(solver)

    def solve(self, friction: Any) -> GuaranteedLimit:
        """The limit for a coefficient of friction, one or one per node.

        Raises
        ------
        ModelError
            Bad friction.
        SolverError
            No solver gave an answer that passes the checks.
        """
        posed = LimitQuestion(self._system, self._cycle, self._loads, friction, self._simplify, self._most)
        shakedown = self._shakedown.solve(friction)
        task = replace(posed, simplify=False)  # a witness is not odd: mirror symmetry only saves nodes
        n, least_found = task.system.nodes, shakedown.load_factor
        both = two_corners(task)
        least, how = np.full(n, np.inf), np.where(both, _LEFT_OUT, _ONE_CORNER).astype(object)
        if np.isnan(least_found) or is_uncoupled(task.system, task.friction):
            least[both], how[both] = least_found, _NOT_NEEDED
            return self._result(task, shakedown, None, least, how, ())
        scaled = task.scaled()
        rows = task.rows(scaled)
        source = posed.part.source  # the least load factor of a node is that of its mirror image
        images = both & (source != np.arange(n))
        how[images] = _IMAGE
        bounds = load_factor_bounds(scaled, rows) if self._simplify else np.zeros(n)
        best: NodeClaim | None = None
        claims: list[NodeClaim] = []
        for node in sorted(np.flatnonzero(both & ~images).tolist(), key=lambda i: float(bounds[i])):
            if self._simplify and bounds[node] >= least_found:
                least[node] = bounds[node]
                continue
            expect_solution = bounds[node] > 0 and all(np.isfinite(claim.load_factor) for claim in claims)
            claim = self._search.solve(task, scaled, rows, node, expect_solution=expect_solution)
            claims.append(claim)
            least[node], how[node] = claim.load_factor, _COINCIDE if claim.coincide else _SOLVED if np.isfinite(claim.load_factor) else _NEVER
            if claim.load_factor < least_found:
                best, least_found = claim, claim.load_factor
        return self._result(task, shakedown, best, np.where(images, least[source], least), how, tuple(claims))

    def _result(
        self, task: LimitQuestion, shakedown: ShakedownLimit, best: NodeClaim | None, least: Array, how: np.ndarray, claims: tuple[NodeClaim, ...]
    ) -> GuaranteedLimit:
        uncoupled, coincide = is_uncoupled(task.system, task.friction), int((how == _COINCIDE).sum())
        last = claims[-1].problem if claims else None
        return GuaranteedLimit(
            load_factor=shakedown.load_factor if best is None else best.load_factor,
            kind=shakedown.kind if best is None else LimitKind.FINITE,
            reason=_reason(shakedown, best, uncoupled, coincide),
            proven=uncoupled or shakedown.kind is LimitKind.NO_SAFE_SLIP,
            slip=shakedown.slip if best is None else frozen(best.slip),
            node=None if best is None else best.node,
            corners=None if best is None else best.corners,
            skipped=int((how == _LEFT_OUT).sum()),
            record=task.record(
                shakedown.record.solver if best is None else best.solver,
                (*shakedown.record.attempts, *(attempt for claim in claims for attempt in claim.attempts)),
                max([shakedown.residual, *(claim.residual for claim in claims)]),
                _left_out(how, len(claims)),
            ),
            shakedown=shakedown,
            problem=last if best is None else best.problem,
            _task=task,
            _least=frozen(least),
            _how=tuple(how.tolist()),
            _units={} if best is None else best.units,
            _above=None if best is None else best.above,
        )


def guaranteed_limit(
    system: ContactSystem, cycle: LoadCycle, friction: Any, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None
) -> GuaranteedLimit:
    """Load factor below which the contact stops slipping from every start (the guaranteed limit lambda_1).

    It is the least load factor at which a safe slip holds some node on both its bounds, forward slip at one corner and backward slip at another: the
    state in which a cyclic slip begins with no amplitude (for two nodes, the published condition that three of four friction lines meet, Ahn,
    Bertocchi & Barber 2008). The slip is a witness: just above the limit, a contact that starts near it slips for ever. That nothing slips for ever
    below the limit is proven for uncoupled contacts (Klarbring, Ciavarella & Barber 2007, where lambda_1 = lambda_2), and otherwise supported by
    experiment: no transient of many that were followed has done so with all nodes closed. Where nodes lift off in each cycle, slip may go on below
    it, and below lambda_2.

    Where the limit is 0, slips at load factors as small as you like hold the node on both bounds. Its witness at 0 carries nothing there, and slip
    goes on from starts next to it that depend on the load. Start the transient at a load inside the cycle: from a mean load outside it the first
    segment can change the slip.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    slip_bound
        See `ShakedownModel`. The bound holds for the witness and for the safe slips of lambda_2; slip may grow beyond it in a transient, so that
        starts within the bound may keep slipping at lower load factors, though at none below the limit without the bound has any been seen to.
    simplify, solver
        See `GuaranteedModel`.

    Returns
    -------
    GuaranteedLimit
        `load_factor` is finite, inf (no limit) or nan (no safe slip at any load factor): each is an answer, see `kind` and `reason`.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    return GuaranteedModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver).solve(friction)


def _reason(shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int) -> str:
    alone = f"; {coincide} nodes carry nothing at load factor 0, which alone makes no slip" if coincide else ""
    if best is not None:
        (forward, backward), zero = best.corners, " at any load factor above 0, however small" if best.load_factor == 0 else ""
        return f"node {best.node} is on its bound of forward slip at corner {forward} and of backward slip at corner {backward}{zero}{alone}"
    if shakedown.kind is not LimitKind.FINITE:
        return shakedown.reason + alone
    why = "the contact is uncoupled (B = 0)" if uncoupled else "no node is on both its bounds below it"
    return f"lambda_1 is lambda_2, for {why}: {shakedown.reason}{alone}"


def _left_out(how: np.ndarray, solved: int) -> tuple[str, ...]:
    n, count = len(how), {reason: int((how == reason).sum()) for reason in (_LEFT_OUT, _IMAGE, _ONE_CORNER, _NOT_NEEDED)}
    texts = {
        _NOT_NEEDED: "all programs: lambda_1 is lambda_2, for the contact is uncoupled (B = 0) or nothing is safe",
        _LEFT_OUT: f"nodes: {count[_LEFT_OUT]} of {n} cannot be on both bounds below the limit, by a lower bound; {solved} solved",
        _IMAGE: f"mirror symmetry: {count[_IMAGE]} of {n} nodes are images of others",
        _ONE_CORNER: f"nodes: {count[_ONE_CORNER]} of {n} can only lift off where they are on both bounds, or have no friction",
    }
    return tuple(text for reason, text in texts.items() if count[reason])
