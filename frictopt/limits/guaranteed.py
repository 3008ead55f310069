"""The guaranteed limit lambda_1: the load factor below which the contact stops slipping from every start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

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
    listed,
    places,
    shown,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..contact.diagnosis import in_contact
from ..errors import ModelError, SolverError
from ..solve.problem import duals, put_back, standing
from .answered import Rated
from .critical_state import (
    COINCIDE_ALONE,
    LEFT_OUT,
    CriticalSearch,
    NodeClaim,
    critical_states,
    load_factor_bounds,
)
from .programs import own_rows
from .question import Question
from .safe_model import SafeModel, in_turn
from .shakedown import ShakedownLimit, ShakedownModel

ONE_CORNER, NOT_NEEDED, OPEN = "one corner alone governs", "not needed", "open"
_WEDGED = "; friction is above the critical value A/|B| of the node, which may wedge itself so that all slip stops above the limit, too"
_LIFTING = "; starts from which nodes open and close in every cycle may slip for ever below it"
_LEFT_OUT = {
    NOT_NEEDED: "need no program: lambda_1 is lambda_2, for the contact is uncoupled (B = 0) or no load factors lie between",
    LEFT_OUT: "cannot be critical below the limit, by a lower bound",
    ONE_CORNER: "can only lift off where they are critical, or have no friction",
}


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteedLimit(Rated):
    """The guaranteed limit, and a residual slip from which the contact keeps slipping just above it.

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
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> limit = fo.guaranteed_limit(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.5)
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
        """The least safe load factor, see `ShakedownLimit.least`: below it slip, opening or touching goes on from every start."""
        return self.shakedown.least

    @property
    def multipliers(self) -> pd.DataFrame:
        """As those of a shakedown limit. Rows `critical_q` and `critical_p` are of `node`, in space with a component of the shear."""
        table = super().multipliers
        if self.node is not None:
            own = table["row"].isin(["critical_q", "critical_p"])
            table.loc[own, "component"] = table.loc[own, "node"]
            table.loc[own, "node"] = self.node
        return table

    @property
    def _rated(self) -> bool:
        return (
            self.shakedown._rated
            if self.node is None
            else self.load_factor > self.least and not self.constraints
        )

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, load_factor, how it was found, and the slip of the witness.

        load_factor is the least at which a safe slip makes the node critical, inf if none does, or
        a lower bound of it (see how).
        """
        found = {"load_factor": self._by_node, "how": self._how}
        return frame(
            {
                "node": range(len(self._how)),
                **places(self.system),
                **found,
                **components("slip", self.slip),
            },
            units=self.system.units,
        )

    def witness_above_least(self, most: float) -> tuple[float, Array] | None:
        """Where the limit is `least`: a load factor above, at most `most`, and the safe slip that makes `node` critical there, length.

        Slip goes on from it at a load factor just above or, of a load that presses the contact,
        just below. None where the limit is above `least`.
        """
        most = finite_number("most", most, above=0.0 if self._above is None else self.load_factor)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = (load_factor - self.load_factor) / (self._above[0] - self.load_factor)
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "guaranteed limit", self.load_factor, None, self.reason


def reason(
    shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int
) -> str:
    """Why the limit is what it is, and what it leaves open, in words."""
    question, limit = (
        shakedown._question,
        shakedown.load_factor if best is None else best.load_factor,
    )
    lifting = ""
    if not uncoupled and shakedown.least < limit < np.inf:
        lifting = _LIFTING * bool(
            shakedown.open.any()
            or not shakedown.friction.all()
            or (question.r0 + limit * question.r1)[:, -1].min() < 0
        )
    return _why(shakedown, best, uncoupled, coincide) + lifting


def _why(shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int) -> str:
    least = shakedown.least
    alone = (
        f"; {coincide} nodes are critical at the least safe load factor {least:.6g} alone, and this does not cause slip"
        if coincide
        else ""
    )
    under = f" (slips obey {', '.join(shakedown.constraints)})" if shakedown.constraints else ""
    if best is not None:
        any_load = "" if best.above is None else f" at every load factor just above {least:.6g}"
        bounds, unloaded = (
            _bounds(best, shakedown._question.cycle.corner_names),
            _unloaded(best) * (not shakedown._question.fixed),
        )
        wedged = _WEDGED * _wedges(shakedown, best.state.node)
        where = in_contact(shakedown.system, best.state.node)
        return f"{shakedown._opened}node {best.state.node}{where} is {bounds}{any_load}{under}{unloaded}{wedged}{alone}"
    if shakedown.kind is not LimitKind.FINITE:
        return shakedown.reason + alone
    why = "the contact is uncoupled (B = 0)" if uncoupled else "no node is critical below it"
    return f"lambda_1 is lambda_2, for {why}: {shakedown.reason}{alone}"


def _bounds(best: NodeClaim, names: Sequence[str]) -> str:
    """Where the node is on its bound, by the loads of the corners."""
    *first, last = (f"({names[corner]})" for corner in best.state.corners)
    if best.slip.ndim == 1:
        return (
            f"on its bound of forward slip at the corner {first[0]} and of backward slip at {last}"
        )
    return f"on its bound at the corners {', '.join(first)} and {last}, from where it can slip {'around' if len(first) > 1 else 'to and fro'}"


def _wedges(shakedown: ShakedownLimit, node: int) -> bool:
    """Whether friction is above the critical value of a node, in space perhaps: then one slip may relieve all its bounds."""
    *own, normal = (
        axis * shakedown.system.nodes + node for axis in range(shakedown.system.tangents + 1)
    )
    S, friction = shakedown.system.S, shakedown.friction[node]
    return bool(
        friction * np.linalg.norm(S[normal, own]) > np.linalg.eigvalsh(S[np.ix_(own, own)])[0]
    )


def _unloaded(best: NodeClaim) -> str:
    """What a limit of 0 means, and what to ask."""
    if best.load_factor > 0:
        return ""
    size = float(np.linalg.norm(best.slip.reshape(len(best.slip), -1), axis=1).max())
    return (
        f": a residual slip of up to {size:.3g} can unload it completely under the mean load; then any cyclic load makes it slip. If assembly and "
        "overloads leave less slip, ask with a `slip_bound`: `after_overload()` has the limit with the largest slip that one overload leaves"
    )


def left_out(how: np.ndarray) -> tuple[str, ...]:
    """Which nodes needed no program, in words."""
    counts = {label: int((how == label).sum()) for label in _LEFT_OUT}
    return tuple(
        f"nodes: {count} of {len(how)} {_LEFT_OUT[label]}"
        for label, count in counts.items()
        if count
    )


def checked_guaranteed(limit: object) -> GuaranteedLimit:
    """Check that a question about a guaranteed limit is given one."""
    if not isinstance(limit, GuaranteedLimit):
        raise ModelError(
            f"limit: {shown(limit)}; give the GuaranteedLimit of `guaranteed_limit` or `GuaranteedModel`"
        )
    return limit


class GuaranteedModel(SafeModel):
    """The guaranteed limit of one system under one load cycle, compiled once and solved for any friction. Theory, eq. (10).

    Parameters
    ----------
    system, cycle, slip_bound, solver
        See `ShakedownModel`.
    simplify
        Leave out what cannot change the answer: nodes whose lower bound is above the least load
        factor found; all of a contact with B = 0, which has lambda_1 = lambda_2 by a theorem.

    Raises
    ------
    ModelError
        As in `ShakedownModel`; a load cycle in space whose fixed parts differ.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> model = fo.GuaranteedModel(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]))
    >>> [round(model.solve(friction).load_factor, 6) for friction in (0.3, 0.5)]
    [0.283333, 0.45]
    >>> round(model.solve(0.5, constraints=[model.slip[1] >= 0.1]).load_factor, 6)
    0.525
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        *,
        slip_bound: ArrayLike | None = None,
        simplify: bool = True,
        solver: str | None = None,
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
        if system.tangents > 1 and self._asked.fixed:
            raise ModelError(
                "cycle: its fixed parts differ, of a contact in space, where the pressure that a node needs bends with the load factor, so that "
                "slips which make it critical are no convex set; ask `shakedown_limit`, or follow starts by `steady_state`"
            )
        self._shakedown = ShakedownModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        self._x = self._shakedown._x
        self.slip, self.load_factor, self.q, self.p = (
            getattr(self._shakedown, name) for name in ("slip", "load_factor", "q", "p")
        )

    @warns_of_odd_values
    @in_turn
    def solve(
        self, friction: Any, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True
    ) -> GuaranteedLimit:
        """The limit for a coefficient of friction, one or one per node, under constraints of your own.

        Parameters
        ----------
        friction, constraints
            As in `ShakedownModel.solve`. Constraints hold for the witness and for the safe slips of
            lambda_2, as a slip bound does: the limit is the least load factor at which a slip that
            obeys them makes a node critical. `residual` covers them.
        progress
            See `guaranteed_limit`.

        Raises
        ------
        ModelError, SolverError
            Bad friction or constraints; no solver gave an answer that passes the checks.
        """
        with bar_of(progress, "guaranteed limit"):
            return self._shown(
                self.of_any_set(self._posed(friction), listed("constraints", constraints))
            )

    def of_any_set(self, question: Question, own: Sequence[cp.Constraint] = ()) -> GuaranteedLimit:
        """The limit with all nodes closed, if that is safe from the mean load on; else with those open that the best pattern leaves open."""
        shakedown = self._shakedown.of_set(question, own)
        if shakedown.kind is LimitKind.NO_SAFE_SLIP or shakedown.least > 0:
            shakedown = self._shakedown.of_any_set(question, own)
        if shakedown.kind is not LimitKind.NO_SAFE_SLIP and np.isnan(shakedown.least):
            raise SolverError(f"guaranteed limit: {shakedown.reason}")
        values = standing(shakedown.problem)
        question = shakedown._question
        n, least_found = len(question.friction), shakedown.load_factor
        states, search = critical_states(question), self._search(question, own)
        both = np.array([bool(own_states) for own_states in states]) & ~question.open_nodes
        least, how = (
            np.full(n, np.inf),
            np.where(both, LEFT_OUT, np.where(question.open_nodes, OPEN, ONE_CORNER)).astype(
                object
            ),
        )
        if not least_found > shakedown.least or uncoupled(question):
            least[both], how[both] = least_found, NOT_NEEDED
            return self._result(question, shakedown, None, least, how, search)
        bounds = (
            load_factor_bounds(question) if self._asked.simplify and both.any() else np.zeros(n)
        )
        best: NodeClaim | None = None
        # where the pressure is little, nodes are nearly critical
        pressure = (
            question.r0[:, -1].min(axis=0)
            + question.reactions_of_slip(np.nan_to_num(shakedown.slip))[1]
        )
        order = sorted(
            np.flatnonzero(both).tolist(), key=lambda i: (float(bounds[i]), float(pressure[i]))
        )

        def kept(_: object) -> tuple[str, object, str] | None:
            table = pd.DataFrame({"node": order, "load_factor": least[order], "how": how[order]})[
                : bar.count
            ]
            said = f"it is at most {least_found:.6g}; what is known of {len(table)} nodes is in the attribute `table`"
            return ("table", table, said) if len(table) else None

        with bar_of(
            True,
            "critical nodes",
            "node",
            total=len(order),
            best=lambda: f"at most {least_found:.4g} so far",
            keeps=kept,
        ) as bar:
            for node in order:
                if self._asked.simplify and bounds[node] >= least_found:
                    least[node] = bounds[node]
                    bar.update()
                    continue
                for state in states[node]:
                    ends, below = (
                        (shakedown.least, shakedown.load_factor),
                        least_found if self._asked.simplify else np.inf,
                    )
                    claim = search.solve(state, ends, below)
                    if claim.load_factor < least[node] or state is states[node][0]:
                        least[node], how[node] = claim.load_factor, claim.how
                    if claim.load_factor < least_found:
                        best, least_found = claim, claim.load_factor
                bar.update()
        if best is not None:
            search.restore(best)
        else:
            put_back(
                values
            )  # into unknowns and rows of the user's own, which the programs of nodes share
        return self._result(question, shakedown, best, least, how, search)

    def _search(self, question: Question, own: Sequence[cp.Constraint]) -> CriticalSearch:
        key = question.open_nodes.tobytes(), *map(id, own)
        if key not in self._programs:
            self._programs.clear()
            self._programs[key] = CriticalSearch(
                self._x, question, own_rows(own, self._unknowns), self._solver
            )
        search: CriticalSearch = self._programs[key]
        search.ask(question)
        return search

    def _result(
        self,
        question: Question,
        shakedown: ShakedownLimit,
        best: NodeClaim | None,
        least: Array,
        how: np.ndarray,
        search: CriticalSearch,
    ) -> GuaranteedLimit:
        without_coupling, coincide = uncoupled(question), int((how == COINCIDE_ALONE).sum())
        program, records = (
            None if best is None else best.program,
            [shakedown.record, *search.records],
        )
        return GuaranteedLimit(
            load_factor=shakedown.load_factor if best is None else best.load_factor,
            kind=shakedown.kind if best is None else LimitKind.FINITE,
            reason=reason(shakedown, best, without_coupling, coincide),
            proven=without_coupling and shakedown.kind is not LimitKind.NO_SAFE_SLIP,
            slip=shakedown.slip if best is None else frozen(best.slip),
            node=None if best is None else best.state.node,
            corners=None if best is None else best.state.corners,
            record=SolveRecord(
                shakedown.record.solver if best is None else best.solver,
                tuple(attempt for record in records for attempt in record.attempts),
                max(record.residual for record in records),
                left_out(how),
                perf_counter() - question.started,
            ),
            constraints=shakedown.constraints,
            shakedown=shakedown,
            problem=shakedown.problem if program is None else program.problem,
            _question=question,
            _motion=shakedown._motion if best is None or best.motion is None else best.motion,
            _by_node=frozen(least),
            _how=tuple(how.tolist()),
            _duals=shakedown._duals if program is None else duals(program.problem),
            _above=None if best is None else best.above,
        )


def uncoupled(question: Question) -> bool:
    """Whether slip changes no pressure of the whole contact: B is zero up to rounding, against A of the two nodes that it joins."""
    A, B = question.system.A, question.system.B
    stiffness = np.sqrt(np.diag(A).clip(0.0).reshape(-1, question.system.nodes).sum(axis=0))
    return not (
        np.maximum(question.friction, 1.0)[:, None] * np.abs(B)
        > NO_COUPLING * np.outer(stiffness, np.resize(stiffness, B.shape[1]))
    ).any()


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
    """Load factor below which the contact stops slipping from every start (the guaranteed limit lambda_1).

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
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> limit = fo.guaranteed_limit(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.5)
    >>> round(limit.load_factor, 6), limit.reason
    (0.45, 'node 0 is on its bound of forward slip at the corner (Q = -1) and of backward slip at (Q
    = +1)')
    """
    with bar_of(progress, "guaranteed limit"):
        model = GuaranteedModel(
            system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver
        )
        return model.of_any_set(model._posed(friction))
