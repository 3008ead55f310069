"""The guaranteed limit lambda_1, for all starts; `guaranteed_limit` says what is proven."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..base import (
    RESIDUAL,
    Array,
    LimitKind,
    PerNode,
    Table,
    components,
    finite_number,
    frame,
    frozen,
    number_of,
    places,
    progress_bar,
    shown,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from .answers.answered import Proven, check_critical
from .answers.reasons import guaranteed_reason
from .guarantee.critical_search import (
    COINCIDE_ALONE,
    CriticalNodes,
    load_factor_bounds,
)
from .moving.moving_areas import uncoupled
from .program.question import Question, pose
from .shakedown import ShakedownLimit, limit_of_all_openings, limit_of_any_set, limit_of_set


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteedLimit(Proven):
    """Guaranteed limit, with a witness: a start whose slip continues just above the limit.

    Attributes
    ----------
    load_factor
        lambda_1, never above lambda_2: the least load factor at which a safe slip makes some node
        critical, see `guaranteed_limit`. It is lambda_2 if no node is critical below lambda_2, also
        if lambda_2 is inf (no limit) or nan (no safe slip). A node that is critical at the least
        safe load factor counts only if it can also be critical just above; then the limit is
        `least`. (At load factor 0 such a node carries no force.)
    kind, reason
        Whether the limit is finite, and the explanation of the limit in words. The reason warns if
        nodes may open and close in every cycle: transients from some starts may then slip for ever
        below the limit. This is possible if nodes are open or have no friction, or if the loads
        would open a node while there is no slip.
    proven
        Whether a theorem states that slip stops from every start at load factors between `least`
        and the limit. The theorem holds for uncoupled contacts: `B` = 0 at all nodes, open and
        frictionless nodes included (Klarbring, Ciavarella & Barber 2007). For coupled contacts the
        limit is only an upper bound of the load factor up to which slip stops from every start
        while nodes stay closed. If nodes open and close in each cycle of an uncoupled contact, and
        the bodies slide freely, the statement is observed, not proven. If friction is above the
        critical value `A/|B|` of `node`, the limit need not be an upper bound: the node may wedge,
        and all slip may stop also above the limit (see `reason`).
    slip
        (N,) or (N, 2) the witness, length: a slip that is safe at the limit and makes `node`
        critical. If no node is critical below lambda_2, the safe slip at lambda_2. NaN if the limit
        is not finite. The witness matters only if assembly can leave a slip of the size
        `largest_slip`.
    node, corners
        The node at which cyclic slip begins, and the load corners at which it is on its friction
        bound: in the plane first the corner of forward slip, then the corner of backward slip. None
        if lambda_2 is the limit.
    record
        Solver of the program of `node`, attempts and time. Its `residual`, at most 1e-9, is the
        largest error of all programs solved: the violation of the contact law by the slip at the
        corners, the distance of the node from its critical state, and the relative distance of the
        dual bound.
    constraints, shakedown
        Names of user constraints, which the witness and all safe slips satisfy; and the shakedown
        limit lambda_2 under the same constraints and slip bound.
    problem
        The solved cvxpy problem of `node`, or of lambda_2 if lambda_2 is the limit.

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

    _shown_names = (
        "load_factor",
        "least",
        "kind",
        "proven",
        "node",
        "largest_slip",
        "residual",
        "reason",
    )
    kind: LimitKind
    reason: str
    proven: bool
    node: int | None
    corners: tuple[int, ...] | None
    shakedown: ShakedownLimit
    _by_node: Array
    _how: tuple[str, ...]
    _above: tuple[float, Array] | None

    def check_kept(self) -> None:
        """Check the witness of a limit from a file, and what follows from its shakedown limit.

        ValueError if one of them is wrong.
        """
        super().check_kept()
        largest = self.shakedown.load_factor
        holds = self.proven == (uncoupled(self._question) and self.shakedown._of_every_start)
        if self.node is None:
            holds &= np.array_equal([self.load_factor], [largest], equal_nan=True)
        else:
            check_critical(self._question, self.node, self.load_factor, self.slip)
            holds &= self.load_factor <= min(largest, self._by_node.min()) * (1 + RESIDUAL)
        if not holds:
            raise ValueError("its shakedown limit or its nodes have other limits")

    @property
    def least(self) -> float:
        """The least safe load factor, see `ShakedownLimit.least`.

        Below it slip, opening or touching goes on from every start.
        """
        return self.shakedown.least

    @property
    def multipliers(self) -> Table:
        """Multipliers as for a shakedown limit.

        The rows `critical_q` and `critical_p` belong to `node`. In space the column component is
        the component of the shear.
        """
        table = super().multipliers
        if self.node is not None:
            critical = table["row"].isin(["critical_q", "critical_p"])
            table.loc[critical, "component"] = table.loc[critical, "node"]
            table.loc[critical, "node"] = self.node
        return table

    def to_frame(self) -> Table:
        """A row for each node: node, its place, load_factor, how, and the slip of the witness.

        `load_factor` is the least load factor at which a safe slip makes the node critical, or a
        lower bound of it (see `how`). It is inf if no safe slip makes the node critical.
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
        """A load factor above the limit, and the slip that makes `node` critical there.

        The load factor is at most `most`. A transient from this slip slips for ever just above this
        load factor or, if the load presses the contact, just below it. The result is None if the
        limit is above `least`.
        """
        most = finite_number("most", most, above=0.0 if self._above is None else self.load_factor)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = (load_factor - self.load_factor) / (self._above[0] - self.load_factor)
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        return "guaranteed limit", self.load_factor, None, self.reason


def checked_guaranteed(limit: object) -> GuaranteedLimit:
    """Check that an argument is a guaranteed limit; ModelError if not."""
    if not isinstance(limit, GuaranteedLimit):
        raise ModelError(
            f"limit: {shown(limit)}; give the GuaranteedLimit of `guaranteed_limit` or "
            "`GuaranteedModel`"
        )
    return limit


def guaranteed_limit_of(question: Question, user: Any = None) -> GuaranteedLimit:
    """The limit with all nodes closed, if the mean load is safe.

    Otherwise the limit with the open nodes of the best shakedown limit. `user`: the `UserRows`.
    """
    shakedown = None if user is not None else limit_of_all_openings(question)
    if shakedown is None:
        shakedown = _limit_of_open_nodes(question, user)
    question = shakedown._question
    nodes = CriticalNodes(question, (shakedown.least, shakedown.load_factor), user)
    if shakedown.load_factor > shakedown.least and not uncoupled(question):
        _find_critical(nodes, shakedown)
    else:
        nodes.need_no_program()
    return _result(shakedown, nodes, user)


def _limit_of_open_nodes(question: Question, user: Any) -> ShakedownLimit:
    """The shakedown limit with all nodes closed or, if the mean load is not safe, some open."""
    shakedown = limit_of_set(question, user=user)
    if shakedown.kind is LimitKind.NO_SAFE_SLIP or shakedown.least > 0:
        shakedown = limit_of_any_set(question)
        if user is not None:
            shakedown = limit_of_set(shakedown._question, user=user)
    if shakedown.kind is not LimitKind.NO_SAFE_SLIP and np.isnan(shakedown.least):
        raise SolverError(f"guaranteed limit: {shakedown.reason}")
    return shakedown


def _find_critical(nodes: CriticalNodes, shakedown: ShakedownLimit) -> None:
    """Solve the programs of the nodes in turn; skip nodes whose lower bound is too high."""
    question = shakedown._question
    bounds = np.zeros(len(nodes.how))
    if question.simplify and nodes.may_be_critical.any():
        bounds = load_factor_bounds(question)
    # Nodes with little pressure are closest to critical.
    _, added = question.reactions_of_slip(np.nan_to_num(shakedown.slip))
    pressure = question.r0[:, -1].min(axis=0) + added
    order = sorted(
        np.flatnonzero(nodes.may_be_critical).tolist(),
        key=lambda i: (float(bounds[i]), float(pressure[i])),
    )
    with progress_bar(True, "critical nodes", "node", total=len(order)) as bar:
        for count, node in enumerate(order, start=1):
            if question.simplify and bounds[node] >= nodes.least:
                nodes.load_factor[node] = bounds[node]
            else:
                nodes.solve(node)
            bar.keep(
                "table",
                partial(nodes.table, order[:count]),
                f"it is at most {nodes.least:.6g}; what is known about "
                f"{number_of(count, 'node')} is in the attribute `table`",
                best=f"at most {nodes.least:.4g} so far",
            )
            bar.update()


def _result(shakedown: ShakedownLimit, nodes: CriticalNodes, user: Any) -> GuaranteedLimit:
    """The guaranteed limit: from the critical node, or the shakedown limit if there is none."""
    question = shakedown._question
    without_coupling = uncoupled(question)
    coincide = int((nodes.how == COINCIDE_ALONE).sum())
    record = shakedown.record.joined(nodes.records, question.started)
    limit = GuaranteedLimit(
        load_factor=shakedown.load_factor,
        kind=shakedown.kind,
        reason=guaranteed_reason(shakedown, nodes.best, without_coupling, coincide),
        proven=without_coupling and shakedown._of_every_start,
        slip=shakedown.slip,
        node=None,
        corners=None,
        record=replace(record, left_out=nodes.left_out()),
        constraints=shakedown.constraints,
        shakedown=shakedown,
        _solved=shakedown._solved,
        _question=question,
        _motion=shakedown._motion,
        _by_node=nodes.load_factor,
        _how=tuple(nodes.how.tolist()),
        _above=None,
    )

    best = nodes.best
    if best is None:
        return limit
    assert best.solved is not None  # it has a slip
    return replace(
        limit,
        # Rounding may leave the load factor of the node just above the shakedown limit.
        load_factor=min(best.load_factor, limit.load_factor),
        kind=LimitKind.FINITE,
        slip=best.slip,
        node=best.state.node,
        corners=best.state.corners,
        record=replace(limit.record, solver=best.solver),
        _solved=best.solved if user is None else user.listed(best.solved),
        _above=best.above,
    )


def posed_guaranteed(question: Question) -> Question:
    """The question itself; ModelError if the slips that make a node critical are no convex set."""
    if question.system.tangents > 1 and question.fixed and not uncoupled(question):
        raise ModelError(
            "cycle: its fixed parts differ, and the contact is in space, so the pressure "
            "that a node needs is not linear in the load factor, and the slips that make it "
            "critical are not a convex set; use `shakedown_limit`, or follow starts by "
            "`steady_state`"
        )
    return question


@warns_of_odd_values
def guaranteed_limit(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    slip_bound: PerNode | None = None,
    simplify: bool = True,
    solver: str | None = None,
    progress: bool = True,
) -> GuaranteedLimit:
    """Load factor below which the contact stops slipping from every start, lambda_1.

    It is the least load factor at which a safe slip leaves some node only as much pressure as its
    cyclic load needs. This node is critical. In the plane it is at its friction bound of forward
    slip at one corner and of backward slip at another. In space it is on its bound at two opposite
    corners, or at three that enclose its mean traction. A cyclic slip begins there with zero
    amplitude. (For two nodes in the plane this is the published condition that three of four
    friction lines meet, Ahn, Bertocchi & Barber 2008.) The slip is a witness: in every case tried,
    a contact that starts near it slips for ever just above the limit.

    If B = 0 at all nodes, a theorem states that slip stops below the limit from every start
    (Klarbring, Ciavarella & Barber 2007; lambda_1 = lambda_2). For coupled contacts this is an
    observation: slip stopped in every transient that was followed below the limit with all nodes
    closed. If nodes lift off in each cycle, slip may continue below the limit, and below lambda_2.

    All this holds above the least safe load factor (`least`, usually 0). If the limit is `least`,
    no load factor is guaranteed: at every load factor just above, some slip makes a node critical
    (`GuaranteedLimit.witness_above_least`). At `least` = 0 the witness takes all force off the node
    under the mean load. If assembly and overloads leave less slip, pass a `slip_bound`
    (`after_overload`). Start transients at a load inside the cycle: from a mean load outside the
    cycle, the first segment can change the slip. Theory, eq. (10).

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    slip_bound
        As in `ShakedownModel`, for the witness and for the safe slips of lambda_2. Slip may exceed
        the bound in a transient. Starts within the bound may then slip for ever at lower load
        factors, down to the limit without the bound.
    simplify, solver
        As in `GuaranteedModel`.
    progress
        Whether to show the progress after two seconds, see `shakedown_limit`. Ctrl-C raises
        KeyboardInterrupt. Once the shakedown limit is known, the attribute `table` of the interrupt
        has the load factors of the nodes so far; their minimum is an upper bound of the limit.

    Returns
    -------
    GuaranteedLimit
        The load factor, and a start that slips for ever just above it.

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
    >>> print(limit.reason.partition(" and ")[0])
    node 0 is on its bound of forward slip at the corner (Q = -1)
    """
    with progress_bar(progress, "guaranteed limit"):
        question = posed_guaranteed(
            pose(system, cycle, friction, simplify=simplify, slip_bound=slip_bound, solver=solver)
        )
        return guaranteed_limit_of(question)
