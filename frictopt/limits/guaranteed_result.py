"""A guaranteed limit with its witness, and why it is what it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact.answers import LimitKind
from ..contact.checks import Array, finite_number, frozen
from ..contact.record import SolveRecord
from ..errors import ModelError
from ..solve.explain import Units, explain
from .both_bounds_search import NodeClaim
from .question import Answered, LimitQuestion
from .shakedown_result import ShakedownLimit

__all__ = ["COINCIDE", "IMAGE", "LEFT_OUT", "NEVER", "NOT_NEEDED", "ONE_CORNER", "OPEN", "SOLVED", "GuaranteedLimit", "left_out", "reason"]

SOLVED, NEVER, COINCIDE, OPEN = "solved", "never on both bounds", "only at the least safe load factor", "open"
LEFT_OUT, IMAGE, ONE_CORNER, NOT_NEEDED = "left out by its bound", "mirror image", "one corner rules both bounds", "not needed"


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteedLimit(Answered):
    """The guaranteed limit, and a residual slip from which the contact keeps slipping just above it.

    Attributes
    ----------
    load_factor
        lambda_1, never above lambda_2: the least load factor at which a safe slip holds some node on both its bounds, forward slip at one corner and
        backward slip at another; lambda_2 if no node is on both bounds below it. Inf or nan where lambda_2 is. A node that is on both bounds at the
        least safe load factor (at 0 it carries nothing) counts only if such slips exist above it too; then the limit is `least`.
    kind, reason
        Whether it is finite, and why it is what it is in words.
    proven
        Whether it is a theorem that slip stops from every start at load factors between `least` and the limit: for uncoupled contacts (Klarbring,
        Ciavarella & Barber 2007), and where nothing is safe. Otherwise the limit is an upper bound of the load factor up to which that holds.
    slip
        (N,) the witness: safe at the limit, with `node` on both its bounds, length. If no node is on both bounds below lambda_2, the safe slip at
        lambda_2. NaN where the limit is not finite. `largest_slip` is its size: a start of this size must be possible for the witness to matter.
    node
        The node that starts to slip to and fro; None where lambda_2 rules.
    corners
        The two load corners at which it is on the bound of forward and of backward slip; None where lambda_2 rules.
    skipped
        Number of nodes left out because their lower bound is not below the least load factor found.
    record
        How it was found; the solver is that of `node`. Its `residual` is the largest of: the violations of the contact law by `slip` at the corners,
        the distance of `node` from its bounds, and the relative distance of the program's dual bound, over all programs solved. At most 1e-9.
    constraints
        Names of the constraints of your own, which the witness and all safe slips obey.
    shakedown
        The shakedown limit lambda_2, under the same slip bound and constraints.
    problem
        The solved cvxpy problem of `node`, that of lambda_2 where lambda_2 rules; None for a closed form, or in a copy.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.guaranteed_limit(system, cycle, friction=0.5)
    >>> limit.node, limit.proven, limit.load_factor <= limit.shakedown.load_factor
    (0, False, True)
    >>> limit.to_frame()[["node", "load_factor", "how"]].round(6)
       node  load_factor                    how
    0     0     0.450000                 solved
    1     1     1.285715  left out by its bound
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
    constraints: tuple[str, ...]
    shakedown: ShakedownLimit = field(repr=False)
    problem: cp.Problem | None = field(repr=False)
    _task: LimitQuestion = field(repr=False)
    _by_node: Array = field(repr=False)
    _how: tuple[str, ...] = field(repr=False)
    _units: Units = field(repr=False)
    _above: tuple[float, Array] | None = field(repr=False)

    @property
    def least(self) -> float:
        """The least safe load factor, see `ShakedownLimit.least`: below it no slip is safe, and slip or opening goes on from every start."""
        return self.shakedown.least

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x, load_factor, how it was found, and the slip of the witness.

        load_factor is the least at which a safe slip holds the node on both its bounds, inf if none does; where the node was left out by its bound, a
        lower bound of it.
        """
        return pd.DataFrame(
            {"node": np.arange(len(self._how)), "x": self.system.x, "load_factor": self._by_node, "how": self._how, "slip": self.slip}
        )

    def witness_above_least(self, most: float) -> tuple[float, Array] | None:
        """Where the limit is `least`: a load factor above, at most `most`, and the (N,) safe slip that holds `node` on both its bounds there, length.

        Slip goes on from it at a load factor just above or, of a load that presses the contact, just below. None where the limit is above `least`.
        """
        most = finite_number("most", most, above=0.0 if self._above is None else self.load_factor)
        if self._above is None:
            return None
        load_factor = min(most, self._above[0])
        share = (load_factor - self.load_factor) / (self._above[0] - self.load_factor)
        return load_factor, frozen((1 - share) * self.slip + share * self._above[1])

    def verify(self, *, starts: int = 1000, moved: int = 5, above: float = 1.02, seed: int = 0) -> Any:
        """Follow transients from the witness just above the limit, and from many starts just below; returns a `GuaranteeCheck`.

        Each transient begins at the mean of the load corners, where a contact with a safe slip sticks; the mean load may be another load. The starts
        below the limit are vertices of the set of safe slips (at the load factor, and under the mean load alone), up to three times these vertices,
        and random slips of a tenth to a hundred times the size of the witness. If none of them slips for ever, this is evidence, not a proof. Where
        the mean load alone is not safe, half of them are next to the least safe load factor: nothing is said of load factors below it.

        Parameters
        ----------
        starts
            Number of starts below the limit.
        moved
            Number of starts above the limit that differ from the witness by up to a thousandth of its largest slip.
        above
            Load factor of the test above the limit, over the limit. The test below is at 98 % of the way to it from the least safe load factor. If
            the limit is the least safe load factor, mostly 0, there is no test below, and the test above is further by 2 % of the way to lambda_2, or
            of the load factor at which the cyclic reactions reach the mean pressures if that is less. There only some starts near the witness slip
            for ever, so a slip on both bounds at this load factor is followed too, at 0.9 and 1.1 times the way.
        seed
            Seed of the random starts.

        Raises
        ------
        ModelError
            Bad input, a limit that is not finite, a contact without safe slip at any load above 0, or with open nodes.
        SolverError
            A transient does not pass its checks.

        Examples
        --------
        >>> import frictopt as fo
        >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
        >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
        >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
        >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
        >>> check = fo.guaranteed_limit(pair, cycle, friction=0.6).verify(starts=4, moved=0)
        >>> check.dies_out, check.persists
        (True, True)
        """
        if self.open.any():
            raise ModelError(
                f"verify: {int(self.open.sum())} nodes are open, and its starts are slips of closed contacts; follow `steady_state` from "
                "`initial_state=limit.state`"
            )
        verify = import_module("frictopt.histories.guarantee").verify  # here, for transients need the limits
        return verify(self, self._task.cycle, starts, moved, above, seed)

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("load_factor", "least", "kind", "proven", "node", "largest_slip", "residual", "reason")}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("guaranteed limit", self.problem, self.load_factor, self._units, self.record.left_out, None, file, self.reason)


def reason(shakedown: ShakedownLimit, best: NodeClaim | None, uncoupled: bool, coincide: int) -> str:
    """Why the limit is what it is, in words."""
    least = shakedown.least
    alone = f"; {coincide} nodes are on both bounds at the least safe load factor {least:.6g} alone, and this does not cause slip" if coincide else ""
    under = f" (slips obey {', '.join(shakedown.constraints)})" if shakedown.constraints else ""
    if best is not None:
        (forward, backward), any_load = best.corners, f" at any load factor next above {least:.6g}" if best.above is not None else ""
        both = f"on its bound of forward slip at corner {forward} and of backward slip at corner {backward}"
        return f"{shakedown._task.said}node {best.node} is {both}{any_load}{under}{alone}"
    if shakedown.kind is not LimitKind.FINITE:
        return shakedown.reason + alone
    why = "the contact is uncoupled (B = 0)" if uncoupled else "no node is on both its bounds below it"
    return f"lambda_1 is lambda_2, for {why}: {shakedown.reason}{alone}"


def left_out(how: np.ndarray, solved: int) -> tuple[str, ...]:
    """Which nodes needed no program, in words."""
    n, count = len(how), {label: int((how == label).sum()) for label in (LEFT_OUT, IMAGE, ONE_CORNER, NOT_NEEDED)}
    texts = {
        NOT_NEEDED: "all programs: lambda_1 is lambda_2, for the contact is uncoupled (B = 0) or nothing is safe",
        LEFT_OUT: f"nodes: {count[LEFT_OUT]} of {n} cannot be on both bounds below the limit, by a lower bound; {solved} solved",
        IMAGE: f"mirror symmetry: {count[IMAGE]} of {n} nodes are images of others",
        ONE_CORNER: f"nodes: {count[ONE_CORNER]} of {n} can only lift off where they are on both bounds, or have no friction",
    }
    return tuple(text for label, text in texts.items() if count[label])
