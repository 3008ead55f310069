"""The guaranteed limit lambda_1: the load factor below which the contact stops slipping from every start."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, flag, frozen
from ..contact.mirror import is_uncoupled
from .apex_bounds import apex_bounds
from .apex_search import FLOOR, ApexClaim, ApexSearch, slip_bounds, two_corners
from .cyclic_increments import CyclicBound, cyclic_bound
from .explain import Units, explain
from .portable import Portable
from .rows import load_factor_unit
from .shakedown import ShakedownLimit, ShakedownModel
from .solve import Attempt, solver_order
from .task import Task, cycle_loads

__all__ = ["GuaranteedLimit", "GuaranteedModel", "guaranteed_limit"]

_EXACT = 1e-6  # relative distance of the two bounds that counts as none

_SOLVED, _NEVER = "solved", "never on both bounds"
_LEFT_OUT, _IMAGE, _ONE_CORNER, _NOT_NEEDED = "left out by its bound", "mirror image", "one corner rules both bounds", "not needed"


@dataclass(frozen=True, eq=False)
class GuaranteedLimit(Portable):
    """Bounds of the guaranteed limit, and a residual slip from which the contact keeps slipping just above the upper one.

    Attributes
    ----------
    upper
        Upper bound of lambda_1, never above lambda_2: the least load factor at which a safe slip holds some node on both its bounds, forward slip
        at one corner and backward slip at another. Inf or nan with lambda_2.
    lower
        Lower bound, see `guaranteed_limit`; 0 where none was asked for or none can be derived.
    slip
        (N,) the witness: safe at `upper`, with `node` on both its bounds, length. Where no node comes to be there below lambda_2, the safe slip at
        lambda_2. NaN where `upper` is not finite.
    node
        The node that starts to slip to and fro; None where lambda_2 rules.
    corners
        The two load corners at which it is on the bound of forward and of backward slip; None where lambda_2 rules.
    skipped
        Number of nodes left out because their lower bound is not below the least load factor found.
    residual
        Largest of: what the referee says of `slip` at every corner, the distance of `node` from its bounds, and the relative distance of the
        program's dual bound, over all programs solved. At most 1e-9.
    solver, attempts
        Who answered for `node`, and all solver runs.
    left_out
        What the scene did not need.
    shakedown
        The shakedown limit lambda_2.
    increments
        What is known from periodic sequences of increments; None where not asked for.
    problem
        The solved cvxpy problem of `node` (in turn of the last one solved); None where none was needed, or in a copy.
    """

    upper: float
    lower: float
    slip: Array = field(repr=False)
    node: int | None
    corners: tuple[int, int] | None
    skipped: int
    residual: float
    solver: str
    attempts: tuple[Attempt, ...] = field(repr=False)
    left_out: tuple[str, ...]
    shakedown: ShakedownLimit = field(repr=False)
    increments: CyclicBound | None = field(repr=False)
    problem: cp.Problem | None = field(repr=False)
    _task: Task = field(repr=False)
    _least: Array = field(repr=False)
    _how: tuple[str, ...] = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def nodes(self) -> pd.DataFrame:
        """One row for each node: node, x, load_factor and how it was found.

        load_factor is the least at which a safe slip holds the node on both its bounds, inf if none does; where the node was left out by its bound, a
        lower bound of it.
        """
        return pd.DataFrame({"node": np.arange(len(self._how)), "x": self._task.system.x, "load_factor": self._least, "how": self._how})

    @property
    def exact(self) -> bool:
        """Whether the two bounds agree to 1e-6 (relative; where both are next to 0, of the load factor at which the load counts)."""
        if not np.isfinite(self.upper):
            return bool(np.isnan(self.upper) or self.lower == self.upper)
        loads = self._task.loads
        return self.upper - self.lower <= _EXACT * max(self.upper, FLOOR * load_factor_unit(loads, self._task.friction, self._task.force))

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the witness, at the upper bound, force per depth; NaN where it is not finite."""
        if not np.isfinite(self.upper):
            return np.full_like(self._task.loads.q1, np.nan), np.full_like(self._task.loads.p1, np.nan)
        return self._task.reactions(self.upper, self.slip)

    def answers(self, system: ContactSystem, cycle: LoadCycle, friction: Any) -> bool:
        """Whether it is the limit of this system, load cycle and friction."""
        return self._task.same_input(Task(system, cycle, cycle_loads(system, cycle), friction, False, True))

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        value = None if self.problem is None else self.upper
        explain("guaranteed limit, upper bound", self.problem, value, self._units, self.left_out, pd.DataFrame(), file)


class GuaranteedModel:
    """The guaranteed limit of one system under one load cycle, compiled once and solved for any friction.

    Not for use by several threads at once: give each its own.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `abs(v)` that assembly can leave, one or one per node, length; None for no bound. Where the body is free to slide as a whole,
        such a slide is no slip.
    simplify
        Leave out what the scene does not need: nodes whose lower bound says that they cannot win, mirror images, corners that rule no node, all
        programs of an uncoupled contact. The answer is the same either way.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; by default each in this order until an answer passes.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.
    """

    def __init__(self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: Any = None, simplify: bool = True, solver: str | None = None) -> None:
        self._shakedown = ShakedownModel(system, cycle, simplify=simplify, solver=solver)
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify)
        solver_order(solver)
        self._search = ApexSearch(self._most, solver)

    def solve(self, friction: Any, *, lower: bool = False, time_limit: float = 60.0) -> GuaranteedLimit:
        """The bounds for a coefficient of friction, one or one per node.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node.
        lower, time_limit
            See `guaranteed_limit`.

        Raises
        ------
        ModelError
            Bad friction or options.
        SolverError
            No solver gave an answer that passes the checks.
        """
        flag("lower", lower)
        time_limit = finite_number("time_limit", time_limit, above=0.0)
        shakedown = self._shakedown.solve(friction)
        posed = Task(self._system, self._cycle, self._loads, friction, self._simplify, not self._simplify)
        task = replace(posed, simplify=False)  # a witness is not odd: mirror symmetry, of the slip bound too, only saves nodes
        even = self._most is None or np.array_equal(self._most, self._most[::-1])
        found = self._upper(task, posed.mirror and even, shakedown)
        if not lower or not np.isfinite(found.upper) or found.lower == found.upper:
            return found
        bound = cyclic_bound(task, found.upper, self._most, time_limit)
        return replace(found, lower=bound.load_factor, increments=bound)

    def _upper(self, task: Task, mirror: bool, shakedown: ShakedownLimit) -> GuaranteedLimit:
        """The upper bound, and the lower one that needs no program."""
        n, upper = task.system.nodes, shakedown.load_factor
        both = two_corners(task)
        least, how = np.full(n, np.inf), np.where(both, _LEFT_OUT, _ONE_CORNER).astype(object)
        if np.isnan(upper) or (self._simplify and is_uncoupled(task.system, task.friction)):
            least[both], how[both] = upper, _NOT_NEEDED
            return self._result(task, shakedown, None, least, how, ())
        interface = task.interface()
        ruling = replace(task, every_corner=False).rows(interface)
        images = both & mirror & (np.arange(n) >= n - n // 2)
        how[images] = _IMAGE
        bounds = apex_bounds(interface, ruling) if self._simplify else np.zeros(n)
        best: ApexClaim | None = None
        claims: list[ApexClaim] = []
        for node in sorted(np.flatnonzero(both & ~images).tolist(), key=lambda i: float(bounds[i])):
            if self._simplify and bounds[node] >= upper:
                least[node] = bounds[node]
                continue
            likely = bounds[node] > 0 and all(np.isfinite(claim.load_factor) for claim in claims)
            claim = self._search.solve(task, interface, ruling, node, likely=likely)
            claims.append(claim)
            least[node], how[node] = claim.load_factor, _SOLVED if np.isfinite(claim.load_factor) else _NEVER
            if claim.load_factor < upper:
                best, upper = claim, claim.load_factor
        least[images] = least[::-1][images]
        return self._result(task, shakedown, best, least, how, tuple(claims))

    def _result(
        self, task: Task, shakedown: ShakedownLimit, best: ApexClaim | None, least: Array, how: np.ndarray, claims: tuple[ApexClaim, ...]
    ) -> GuaranteedLimit:
        upper = shakedown.load_factor if best is None else best.load_factor
        certain = np.isnan(upper) or upper == 0 or is_uncoupled(task.system, task.friction)
        last = claims[-1].problem if claims else None
        return GuaranteedLimit(
            upper=upper,
            lower=upper if certain else 0.0,
            slip=shakedown.slip if best is None else frozen(best.slip),
            node=None if best is None else best.node,
            corners=None if best is None else best.corners,
            skipped=int((how == _LEFT_OUT).sum()),
            residual=max([shakedown.residual, *(claim.residual for claim in claims)]),
            solver=shakedown.solver if best is None else best.solver,
            attempts=(*shakedown.attempts, *(attempt for claim in claims for attempt in claim.attempts)),
            left_out=_left_out(how, len(claims)),
            shakedown=shakedown,
            increments=None,
            problem=last if best is None else best.problem,
            _task=task,
            _least=frozen(least),
            _how=tuple(how.tolist()),
            _units={} if best is None else best.units,
        )


def guaranteed_limit(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    *,
    slip_bound: Any = None,
    lower: bool = False,
    time_limit: float = 60.0,
    simplify: bool = True,
    solver: str | None = None,
) -> GuaranteedLimit:
    """Bounds of the load factor below which the contact stops slipping from every start (the guaranteed limit lambda_1).

    The upper bound comes with a witness: just above it, a contact that starts near the witness slips for ever. It is the least load factor at which
    a safe slip holds some node on both its bounds, forward slip at one corner and backward slip at another: the state in which a cyclic slip begins
    with no amplitude (for two nodes, the published condition that three of four friction lines meet, Ahn, Bertocchi & Barber 2008). That nothing
    slips for ever below it is proven for uncoupled contacts (Klarbring, Ciavarella & Barber 2007, where lambda_1 = lambda_2), and otherwise supported
    by experiment: no transient of many that were followed has done so with all nodes closed. Where nodes lift off in each cycle slip may go on below
    it, and below lambda_2: there it stays an upper bound. Where it is 0 the node carries nothing under the witness, so that no load is small: slip
    goes on from some starts next to the witness, not from all; as where loads that press the contact make the witness safe as they grow. Starts
    are meant at a load within the cycle: where the mean load lies outside, the way to the first corner may carry the witness off.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    slip_bound
        See `GuaranteedModel`. The bound holds for the witness; slip may grow beyond it in a transient, so that starts within the bound may keep
        slipping at lower load factors, though at none below `upper` without the bound has any been seen to.
    lower
        Whether to look for a lower bound among periodic sequences of increments, see `CyclicBound` for what it says. The effort grows exponentially
        with the nodes: for a few.
    time_limit
        Seconds for the lower bound, after which the bound found so far is returned.
    simplify, solver
        See `GuaranteedModel`.

    Returns
    -------
    GuaranteedLimit
        `upper` is finite, inf (no limit) or nan (no safe slip at any load factor): each is an answer.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.
    """
    return GuaranteedModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver).solve(friction, lower=lower, time_limit=time_limit)


def _left_out(how: np.ndarray, solved: int) -> tuple[str, ...]:
    n, count = len(how), {reason: int((how == reason).sum()) for reason in (_LEFT_OUT, _IMAGE, _ONE_CORNER, _NOT_NEEDED)}
    texts = {
        _NOT_NEEDED: "all programs: lambda_1 is lambda_2, for the contact is uncoupled (B = 0) or nothing is safe",
        _LEFT_OUT: f"nodes: {count[_LEFT_OUT]} of {n} cannot be on both bounds below the limit, by a lower bound; {solved} solved",
        _IMAGE: f"mirror symmetry: {count[_IMAGE]} of {n} nodes are images of others",
        _ONE_CORNER: f"nodes: {count[_ONE_CORNER]} of {n} can only lift off where they are on both bounds, or have no friction",
    }
    return tuple(text for reason, text in texts.items() if count[reason])
