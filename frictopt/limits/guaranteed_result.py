"""A guaranteed limit with its witness, and why it is what it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import pandas as pd

from ..contact import Array, LimitKind, components, finite_number, frame, frozen, places
from ..contact.diagnosis import in_contact
from ..errors import ModelError
from .answered import Rated
from .critical_search import LEFT_OUT, NodeClaim
from .shakedown_result import ShakedownLimit

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
        lambda_1, never above lambda_2: the least load factor at which a safe slip makes some node critical, see `guaranteed_limit`; lambda_2 if no
        node is critical below it. Inf (no limit) or nan (no safe slip) where lambda_2 is. A node that is critical at the least safe load factor (at 0
        it carries nothing) counts only if it can be above it too; then the limit is `least`.
    kind, reason
        Whether it is finite, and why it is what it is in words. Where nodes are open or have no friction, or loads open one that no slip presses, it
        says that starts from which nodes open and close in every cycle may slip for ever below the limit.
    proven
        Whether it is a theorem that slip stops from every start at load factors between `least` and the limit: for uncoupled contacts, `B` = 0 at all
        nodes, open ones and those without friction too (Klarbring, Ciavarella & Barber 2007). Otherwise the limit is an upper bound of the load
        factor up to which that holds while nodes stay closed, unless friction is above the critical value `A/|B|` of `node`: such a node may wedge
        itself, and all slip stop above it, too (`reason` says so).
    slip
        (N,) or (N, 2) the witness: safe at the limit, with `node` critical, length. If no node is critical below lambda_2, the safe slip at lambda_2.
        NaN where the limit is not finite. A start of the size `largest_slip` must be possible for the witness to matter.
    node, corners
        The node that starts to slip to and fro, or around, and the load corners at which it is on its bound: in the plane that of forward and that of
        backward slip; None where lambda_2 is the limit.
    record
        How it was found; the solver is that of `node`. Its `residual`, at most 1e-9, is the largest of: the violations of the contact law by `slip`
        at the corners, the distance of `node` from its critical state, and the relative distance of the dual bound, over all programs solved.
    constraints, shakedown
        Names of the constraints of your own, which the witness and all safe slips obey; and the shakedown limit lambda_2 under the same constraints
        and slip bound.
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
        return self.shakedown._rated if self.node is None else self.load_factor > self.least and not self.constraints

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, load_factor, how it was found, and the slip of the witness.

        load_factor is the least at which a safe slip makes the node critical, inf if none does, or a lower bound of it (see how).
        """
        found = {"load_factor": self._by_node, "how": self._how}
        return frame({"node": range(len(self._how)), **places(self.system), **found, **components("slip", self.slip)}, units=self.system.units)

    def witness_above_least(self, most: float) -> tuple[float, Array] | None:
        """Where the limit is `least`: a load factor above, at most `most`, and the safe slip that makes `node` critical there, length.

        Slip goes on from it at a load factor just above or, of a load that presses the contact, just below. None where the limit is above `least`.
        """
        most = finite_number("most", most, above=0.0 if self._above is None else self.load_factor)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = (load_factor - self.load_factor) / (self._above[0] - self.load_factor)
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def after_overload(self, load_factor: float | None = None) -> GuaranteedLimit:
        """The limit for slips no larger than the largest one that one overload leaves, which is its slip bound.

        The overload is one cycle of a contact that has not slipped before. Ask it where a witness needs more slip than assembly and overloads leave.

        Parameters
        ----------
        load_factor
            Load factor of the overload; by default lambda_2, above which the contact slips for ever.

        Raises
        ------
        ModelError, NoContinuation, SolverError
            Bad input; constraints of your own, or lambda_2 not finite and no load factor given; no path of the overload; no answer that passes.

        Examples
        --------
        >>> import frictopt as fo
        >>> A, B, loads = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]], {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
        >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], loads)
        >>> limit = fo.guaranteed_limit(pair, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.6)
        >>> limit.load_factor <= limit.after_overload().load_factor <= limit.shakedown.load_factor
        True
        """
        if self.constraints:
            raise ModelError(f"after_overload: the limit is under {', '.join(self.constraints)}; ask a limit without constraints of your own")
        factor = finite_number("load_factor", self.shakedown.load_factor if load_factor is None else load_factor, least=0.0)
        left = import_module("frictopt.histories.guarantee").left_by_overload(self, factor)  # here, for transients need the limits
        most = left if self._task.most is None else np.minimum(left, self._task.most)
        model = import_module("frictopt.limits.guaranteed").GuaranteedModel
        limit: GuaranteedLimit = model(self.system, self.cycle, slip_bound=most, simplify=self._task.simplify).solve(self.friction)
        return limit

    def verify(self, *, starts: int = 1000, moved: int = 5, above: float = 1.02, seed: int = 0) -> Any:
        """Follow transients from the witness just above the limit, and from many starts just below; returns a `GuaranteeCheck`.

        Each transient begins at the mean of the load corners, where a contact with a safe slip sticks; the mean load may be another load. The starts
        below the limit are vertices of the set of safe slips (at the load factor, and under the mean load alone), up to three times these vertices,
        and random slips of a tenth to a hundred times the size of the witness. If none of them slips for ever, this is evidence, not a proof. Where
        the mean load alone is not safe, half of them are next to the least safe load factor: nothing is said of load factors below it.

        Where nodes are open, all starts below the limit are random. A slip that the closed nodes can hold begins with the others open as it leaves
        them, any other one with all nodes closed. Starts from which nodes open and close in every cycle may slip for ever below the limit.

        Parameters
        ----------
        starts, seed
            Number of starts below the limit, and the seed of the random ones.
        moved
            Number of starts above the limit that differ from the witness by up to a thousandth of its largest slip.
        above
            Load factor of the test above the limit, over the limit. The test below is at 98 % of the way to it from the least safe load factor. If
            the limit is the least safe load factor, mostly 0, there is no test below, and the test above is further by 2 % of the way to lambda_2, or
            of the load factor at which the cyclic reactions reach the mean pressures if that is less. There only some starts near the witness slip
            for ever, so a slip that makes the node critical at this load factor is followed too, at 0.9 and 1.1 times the way.

        Raises
        ------
        ModelError, SolverError
            Bad input, a limit that is not finite, a contact without safe slip at any load above 0; a transient does not pass its checks.

        Examples
        --------
        >>> import frictopt as fo
        >>> A, B, loads = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]], {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
        >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], loads)
        >>> limit = fo.guaranteed_limit(pair, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.6)
        >>> check = limit.verify(starts=4, moved=0)
        >>> check.dies_out, check.persists
        (True, True)
        """
        verify = import_module("frictopt.histories.guarantee").verify  # here, for transients need the limits
        return verify(self, starts, moved, above, seed)

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "guaranteed limit", self.load_factor, None, self.reason


def reason(shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int) -> str:
    """Why the limit is what it is, and what it leaves open, in words."""
    task, limit = shakedown._task, shakedown.load_factor if best is None else best.load_factor
    lifting = ""
    if not uncoupled and shakedown.least < limit < np.inf:
        lifting = _LIFTING * bool(shakedown.open.any() or not shakedown.friction.all() or (task.r0 + limit * task.r1)[:, -1].min() < 0)
    return _why(shakedown, best, uncoupled, coincide) + lifting


def _why(shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int) -> str:
    least = shakedown.least
    alone = f"; {coincide} nodes are critical at the least safe load factor {least:.6g} alone, and this does not cause slip" if coincide else ""
    under = f" (slips obey {', '.join(shakedown.constraints)})" if shakedown.constraints else ""
    if best is not None:
        any_load = "" if best.above is None else f" at every load factor just above {least:.6g}"
        bounds, unloaded = _bounds(best, shakedown._task.cycle.corner_names), _unloaded(best) * (not shakedown._task.fixed)
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
        return f"on its bound of forward slip at the corner {first[0]} and of backward slip at {last}"
    return f"on its bound at the corners {', '.join(first)} and {last}, from where it can slip {'around' if len(first) > 1 else 'to and fro'}"


def _wedges(shakedown: ShakedownLimit, node: int) -> bool:
    """Whether friction is above the critical value of a node, in space perhaps: then one slip may relieve all its bounds."""
    *own, normal = (axis * shakedown.system.nodes + node for axis in range(shakedown.system.tangents + 1))
    S, friction = shakedown.system.S, shakedown.friction[node]
    return bool(friction * np.linalg.norm(S[normal, own]) > np.linalg.eigvalsh(S[np.ix_(own, own)])[0])


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
    return tuple(f"nodes: {count} of {len(how)} {_LEFT_OUT[label]}" for label, count in counts.items() if count)
