"""The guaranteed limit lambda_1: below it the contact stops slipping from every start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..base import (
    NO_COUPLING,
    Array,
    LimitKind,
    SolveRecord,
    bar_of,
    components,
    finite_number,
    frame,
    frozen,
    places,
    shown,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from ..solve.problem import duals, put_back, standing
from .answered import Rated
from .critical_bounds import load_factor_bounds
from .critical_search import (
    COINCIDE_ALONE,
    LEFT_OUT,
    NOT_NEEDED,
    ONE_CORNER,
    CriticalNodes,
    CriticalSearch,
    NodeClaim,
)
from .programs import own_rows
from .question import Question, pose
from .safe_model import SafeModel
from .sentences import guaranteed_reason
from .shakedown import ShakedownLimit, ShakedownLimits

# Why so many nodes needed no program.
_LEFT_OUT = {
    NOT_NEEDED: (
        "need no program: lambda_1 is lambda_2, for the contact is uncoupled (B = 0) or no load "
        "factors lie between"
    ),
    LEFT_OUT: "cannot be critical below the limit, by a lower bound",
    ONE_CORNER: "can only lift off where they are critical, or have no friction",
}


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteedLimit(Rated):
    """The guaranteed limit, and a residual slip from which slip goes on just above it.

    Attributes
    ----------
    load_factor
        lambda_1, never above lambda_2: the least load factor at which a safe slip makes some node
        critical, see `guaranteed_limit`; lambda_2 if no node is critical below it. Inf (no limit)
        or nan (no safe slip) where lambda_2 is. A node that is critical at the least safe load
        factor (at 0 it carries nothing) counts only if it can be above it too; then the limit is
        `least`.
    kind, reason
        Whether it is finite, and why it is what it is in words. Where nodes are open or have no
        friction, or loads open one that no slip presses, it says that starts from which nodes open
        and close in every cycle may slip for ever below the limit.
    proven
        Whether it is a theorem that slip stops from every start at load factors between `least` and
        the limit: for uncoupled contacts, `B` = 0 at all nodes, open ones and those without
        friction too (Klarbring, Ciavarella & Barber 2007). Otherwise the limit is an upper bound of
        the load factor up to which that holds while nodes stay closed, unless friction is above the
        critical value `A/|B|` of `node`: such a node may wedge itself, and all slip stop above it,
        too (`reason` says so).
    slip
        (N,) or (N, 2) the witness: safe at the limit, with `node` critical, length. If no node is
        critical below lambda_2, the safe slip at lambda_2. NaN where the limit is not finite. A
        start of the size `largest_slip` must be possible for the witness to matter.
    node, corners
        The node that starts to slip to and fro, or around, and the load corners at which it is on
        its bound: in the plane that of forward and that of backward slip; None where lambda_2 is
        the limit.
    record
        How it was found; the solver is that of `node`. Its `residual`, at most 1e-9, is the largest
        of: the violations of the contact law by `slip` at the corners, the distance of `node` from
        its critical state, and the relative distance of the dual bound, over all programs solved.
    constraints, shakedown
        Names of the constraints of your own, which the witness and all safe slips obey; and the
        shakedown limit lambda_2 under the same constraints and slip bound.
    problem
        The solved cvxpy problem of `node`, or of lambda_2 where that is the limit.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.guaranteed_limit(system, cycle, friction=0.5)
    >>> limit.node, limit.proven, limit.load_factor <= limit.shakedown.load_factor
    (0, False, True)
    >>> limit.to_frame()["how"].tolist()
    ['solved', 'left out by its bound']
    """

    _said = ("load_factor", "least", "kind", "proven", "node", "largest_slip", "residual", "reason")
    kind: LimitKind
    reason: str
    proven: bool
    node: int | None
    corners: tuple[int, ...] | None
    shakedown: ShakedownLimit
    _by_node: Array
    _how: tuple[str, ...]
    _above: tuple[float, Array] | None

    @property
    def least(self) -> float:
        """The least safe load factor, see `ShakedownLimit.least`.

        Below it slip, opening or touching goes on from every start.
        """
        return self.shakedown.least

    @property
    def multipliers(self) -> pd.DataFrame:
        """As those of a shakedown limit; rows `critical_q` and `critical_p` are of `node`.

        In space they have a component of the shear.
        """
        table = super().multipliers
        if self.node is not None:
            critical = table["row"].isin(["critical_q", "critical_p"])
            table.loc[critical, "component"] = table.loc[critical, "node"]
            table.loc[critical, "node"] = self.node
        return table

    @property
    def _rated(self) -> bool:
        if self.node is None:
            return self.shakedown._rated
        return self.load_factor > self.least and not self.constraints

    def to_frame(self) -> pd.DataFrame:
        """A row for each node: node, its place, load_factor, how, and the slip of the witness.

        load_factor is the least at which a safe slip makes the node critical, inf if none does, or
        a lower bound of it (see how).
        """
        columns = {
            "node": range(len(self._how)),
            **places(self.system),
            "load_factor": self._by_node,
            "how": self._how,
            **components("slip", self.slip),
        }
        return frame(columns, units=self.system.units)

    def witness_above_least(self, most: float) -> tuple[float, Array] | None:
        """If the limit is `least`: a load factor above, and the slip that makes `node` critical.

        The load factor is at most `most`. Slip (length) goes on from there at a load factor just
        above or, if the load presses the contact, just below. None if the limit is above `least`.
        """
        most = finite_number("most", most, above=0.0 if self._above is None else self.load_factor)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = (load_factor - self.load_factor) / (self._above[0] - self.load_factor)
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "guaranteed limit", self.load_factor, None, self.reason


def left_out(how: np.ndarray) -> tuple[str, ...]:
    """Which nodes needed no program, in words."""
    sentences = []
    for label, why in _LEFT_OUT.items():
        count = int((how == label).sum())
        if count:
            sentences.append(f"nodes: {count} of {len(how)} {why}")
    return tuple(sentences)


def checked_guaranteed(limit: object) -> GuaranteedLimit:
    """Check that a question about a guaranteed limit is given one."""
    if not isinstance(limit, GuaranteedLimit):
        raise ModelError(
            f"limit: {shown(limit)}; give the GuaranteedLimit of `guaranteed_limit` or "
            "`GuaranteedModel`"
        )
    return limit


class GuaranteedLimits(SafeModel):
    """The guaranteed limits of one system and cycle, for any friction."""

    def _begin(self, question: Question, solver: str | None) -> None:
        if question.system.tangents > 1 and question.fixed:
            raise ModelError(
                "cycle: its fixed parts differ, of a contact in space, where the pressure that a "
                "node needs bends with the load factor, so that slips which make it critical are "
                "no convex set; ask `shakedown_limit`, or follow starts by `steady_state`"
            )
        super()._begin(question, solver)
        # Both limits are about the same unknowns.
        self._shakedown = ShakedownLimits._on(question, solver)
        self._x = self._shakedown._x
        self.slip = self._shakedown.slip
        self.load_factor = self._shakedown.load_factor
        self.q = self._shakedown.q
        self.p = self._shakedown.p

    def of_any_set(
        self, question: Question, user_rows: Sequence[cp.Constraint] = ()
    ) -> GuaranteedLimit:
        """The limit with all nodes closed, if that is safe from the mean load on.

        Else with the nodes open that the best pattern of the shakedown limit leaves open.
        """
        shakedown = self._shakedown.of_set(question, user_rows)
        if shakedown.kind is LimitKind.NO_SAFE_SLIP or shakedown.least > 0:
            shakedown = self._shakedown.of_any_set(question, user_rows)
        if shakedown.kind is not LimitKind.NO_SAFE_SLIP and np.isnan(shakedown.least):
            raise SolverError(f"guaranteed limit: {shakedown.reason}")
        question = shakedown._question
        values = standing(shakedown.problem)
        search = self._search(question, user_rows)
        nodes = CriticalNodes(question, shakedown.load_factor)
        if uncoupled(question) or not shakedown.load_factor > shakedown.least:
            nodes.need_no_program()
        else:
            self._find_critical(nodes, search, shakedown)
        if nodes.best is not None:
            search.restore(nodes.best)
        else:
            # The unknowns, and the rows of the user, are also those of the programs of nodes.
            put_back(values)
        return _result(shakedown, nodes, search)

    def _find_critical(
        self, nodes: CriticalNodes, search: CriticalSearch, shakedown: ShakedownLimit
    ) -> None:
        """Ask the nodes one after the other; leave out those whose bound is above the least."""
        question = shakedown._question
        simplify = question.simplify
        bounds = np.zeros(len(nodes.how))
        if simplify and nodes.may_be_critical.any():
            bounds = load_factor_bounds(question)
        # Nodes with little pressure are closest to critical.
        _, added = question.reactions_of_slip(np.nan_to_num(shakedown.slip))
        pressure = question.r0[:, -1].min(axis=0) + added
        order = sorted(
            np.flatnonzero(nodes.may_be_critical).tolist(),
            key=lambda i: (float(bounds[i]), float(pressure[i])),
        )

        with bar_of(True, "critical nodes", "node", total=len(order)) as bar:
            for count, node in enumerate(order, start=1):
                if simplify and bounds[node] >= nodes.least:
                    nodes.load_factor[node] = bounds[node]
                else:
                    ends = shakedown.least, shakedown.load_factor
                    for state in nodes.states[node]:
                        claim = search.solve(state, ends, nodes.least if simplify else np.inf)
                        nodes.add(claim)
                bar.keep(
                    "table",
                    partial(nodes.table, order[:count]),
                    f"it is at most {nodes.least:.6g}; what is known of {count} nodes is in the "
                    "attribute `table`",
                    best=f"at most {nodes.least:.4g} so far",
                )
                bar.update()

    def _search(self, question: Question, user_rows: Sequence[cp.Constraint]) -> CriticalSearch:
        key = question.open_nodes.tobytes(), *map(id, user_rows)
        if key not in self._programs:
            rows = own_rows(user_rows, self._unknowns)
            self._programs.clear()
            self._programs[key] = CriticalSearch(self._x, question, rows, self._solver)
        search: CriticalSearch = self._programs[key]
        search.ask(question)
        return search


def _result(
    shakedown: ShakedownLimit, nodes: CriticalNodes, search: CriticalSearch
) -> GuaranteedLimit:
    """The guaranteed limit: that of the critical node, or the shakedown limit if there is none."""
    question = shakedown._question
    without_coupling = uncoupled(question)
    coincide = int((nodes.how == COINCIDE_ALONE).sum())
    records = [shakedown.record, *search.records]
    record = SolveRecord(
        shakedown.record.solver,
        tuple(attempt for record in records for attempt in record.attempts),
        max(record.residual for record in records),
        left_out(nodes.how),
        perf_counter() - question.started,
    )
    limit = GuaranteedLimit(
        load_factor=shakedown.load_factor,
        kind=shakedown.kind,
        reason=guaranteed_reason(shakedown, nodes.best, without_coupling, coincide),
        proven=without_coupling and shakedown.kind is not LimitKind.NO_SAFE_SLIP,
        slip=shakedown.slip,
        node=None,
        corners=None,
        record=record,
        constraints=shakedown.constraints,
        shakedown=shakedown,
        problem=shakedown.problem,
        _question=question,
        _motion=shakedown._motion,
        _by_node=frozen(nodes.load_factor),
        _how=tuple(nodes.how.tolist()),
        _duals=shakedown._duals,
        _above=None,
    )
    return limit if nodes.best is None else _of_node(limit, nodes.best)


def _of_node(limit: GuaranteedLimit, best: NodeClaim) -> GuaranteedLimit:
    """The limit as that of its critical node."""
    assert best.program is not None  # it has a slip
    problem = best.program.problem
    return replace(
        limit,
        load_factor=best.load_factor,
        kind=LimitKind.FINITE,
        slip=frozen(best.slip),
        node=best.state.node,
        corners=best.state.corners,
        record=replace(limit.record, solver=best.solver),
        problem=problem,
        _motion=limit._motion if best.motion is None else best.motion,
        _duals=duals(problem),
        _above=best.above,
    )


def uncoupled(question: Question) -> bool:
    """Whether slip changes no pressure of the whole contact: B is zero up to rounding.

    Each entry is compared with A of the two nodes that it joins.
    """
    system = question.system
    stiffness = np.sqrt(np.diag(system.A).clip(0.0).reshape(-1, system.nodes).sum(axis=0))
    scale = np.outer(stiffness, np.resize(stiffness, system.B.shape[1]))
    coupling = np.maximum(question.friction, 1.0)[:, None] * np.abs(system.B)
    return not (coupling > NO_COUPLING * scale).any()


@warns_of_odd_values
def guaranteed_limit(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    *,
    slip_bound: Any = None,
    simplify: bool = True,
    solver: str | None = None,
    progress: bool = True,
) -> GuaranteedLimit:
    """Load factor below which the contact stops slipping from every start, lambda_1.

    It is the least load factor at which a safe slip leaves some node no more pressure than its
    cyclic load needs. This node is critical: on its bound of forward slip at one corner and of
    backward slip at another, in space at opposed corners or at three that surround; a cyclic slip
    begins there with no amplitude (for two nodes in the plane, the published condition that three
    of four friction lines meet, Ahn, Bertocchi & Barber 2008). The slip is a witness: just above
    the limit, a contact that starts near it slips for ever. Where B = 0 at all nodes it is a
    theorem that slip stops below the limit from every start (Klarbring, Ciavarella & Barber 2007;
    lambda_1 = lambda_2). For coupled contacts it is an observation: in no transient that was
    followed below the limit with all nodes closed did slip go on. Where nodes lift off in each
    cycle, slip may go on below the limit, and below lambda_2.

    All this holds from the least safe load factor on (`least`, mostly 0). If the limit is `least`,
    no load factor is guaranteed: some node is critical at every load factor just above, from a slip
    that depends on the load (`GuaranteedLimit.witness_above_least`). At `least` = 0 the witness
    takes all force off the node under the mean load; where assembly and overloads leave less slip,
    ask with a `slip_bound` (`after_overload`). Start transients at a load inside the cycle: from a
    mean load outside it, the first segment can change the slip. Theory, eq. (10).

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    slip_bound
        As in `ShakedownModel`, for the witness and for the safe slips of lambda_2. In a transient,
        slip may grow beyond it: starts within the bound may then keep slipping at lower load
        factors, down to the limit without the bound.
    simplify, solver
        As in `GuaranteedModel`.
    progress
        Whether to show after two seconds how far it is, see `shakedown_limit`. Ctrl-C stays a
        KeyboardInterrupt; once the shakedown limit is known, its attribute `table` has the load
        factors of the nodes by then, of which the least is an upper bound of the limit.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.guaranteed_limit(system, cycle, friction=0.5)
    >>> round(limit.load_factor, 6)
    0.45
    >>> print(limit.reason)
    node 0 is on its bound of forward slip at the corner (Q = -1) and of backward slip at (Q = +1)
    """
    with bar_of(progress, "guaranteed limit"):
        question = pose(system, cycle, friction, simplify=simplify, slip_bound=slip_bound)
        return GuaranteedLimits._on(question, solver).of_any_set(question)
