"""A shakedown limit with its proof from both sides: safe from below by the contact law, and from above by the mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from ..contact import LimitKind, frame, lengths
from ..contact.checks import Array, finite_number, frozen
from ..contact.diagnosis import in_contact
from ..contact.tolerances import ROUNDING
from ..errors import ModelError, SolverError
from ..solve.compiled import Proof
from ..transients.statics import unscaled_diagnosis
from .answered import Rated
from .gross_slip import statics_alone
from .least_slip import LeastSlip, least_slip
from .open_nodes import border, stays_closed

_ALL = 1e-6  # relative distance from the bound of all states up to which the limit is that of all


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(Rated):
    """The shakedown limit with its proof from both sides, for one pattern of nodes that stay closed or `open`, see `covers`.

    The pattern is the best that a local search near the settled mean load finds. Asked with events, it also has nodes that open and close in each
    cycle, see `events`. With others open, or in another order, a contact may rest above it. Theory, eq. (8).

    Attributes
    ----------
    load_factor, kind
        lambda_2, the largest load factor with a safe slip; inf if all have one from some load factor on, nan if none has one. `kind` says which.
    least
        The least load factor with a safe slip: 0 for a contact that is safe under its mean load. It is above 0 where the mean load alone leaves no
        safe slip and the corners press; then load factors are safe from `least` to `load_factor`, and below `least` the contact slips or opens for
        ever. Proven like the limit, also under a slip bound and constraints of your own; just above it others than `open` may be the open nodes.
        NaN where nothing is safe, where rounding hides it (`reason` says so), and with an objective.
    slip
        (N,) or (N, 2) a residual slip that is safe at the limit, length; NaN where `load_factor` is not finite. See `largest_slip`. Nodes of `open`
        have the slip that the mean load gives them.
    bound
        Upper bound of the limit with the same nodes open, not of others, from the mechanism alone, or with constraints of your own from all
        multipliers, theirs too; equals `load_factor` up to `residual`.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the violations of the contact law by `slip` at the corners, and the
        relative distance of `bound`; without a finite limit, that of the proof; and the same two of `least` where it is above 0.
    constraints
        Names of the constraints of your own, and "objective" for an objective: slip, residual and dual bound are those of the program with them.
    objective
        Largest value of an objective of your own; None without. Then `load_factor` is the one that it chooses, `bound` is an upper bound of the
        objective, and `friction_rate` is its rate.
    problem
        The solved cvxpy problem, in your units. A later solve of the same `ShakedownModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> limit = fo.shakedown_limit(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), friction=0.5)
    >>> limit.kind.name, round(limit.load_factor, 6), round(limit.bound, 6)
    ('FINITE', 0.535714, 0.535714)
    >>> limit.mechanism[["node", "corner", "direction"]].sort_values("corner", ignore_index=True)
       node  corner  direction
    0     0       0          1
    1     0       1         -1
    2     1       1         -1
    """

    kind: LimitKind
    bound: float
    least: float = np.nan
    objective: float | None = None
    _why: str = ""  # there is no largest safe load factor; or a reason that stands for the usual one

    @cached_property
    def reason(self) -> str:
        """Why it is so, in words."""
        task, least, growth = self._task, self.least, self.kind is LimitKind.UNBOUNDED
        if self._why and not growth:
            return self._opened + self._why + self._border
        within, more = ("", "") if task.most is None else (" within the slip bound", "a larger slip_bound may leave one; ")
        slip, start, below = f"residual slip{within}", "", ""
        slip += f" that obeys {', '.join(self.constraints)}" * bool(self.constraints)
        if not self.load_factor > 0 or (least > 0 and not self.constraints):
            more += unscaled_diagnosis(task.system, task.cycle, task.friction)
        if not self.load_factor > 0:
            node, above = self._ruling, " above 0" * (self.kind is LimitKind.FINITE)
            where = in_contact(task.system, node)
            sheared, single = self._motion.size[:, node].max() > ROUNDING * np.abs(self._motion.moves).max(), set(self.mechanism["node"]) == {node}
            if above and task.friction[node] == 0 and sheared:
                more = f"node {node}{where} has no friction, and the cyclic load shears it"
            elif above and single and np.abs(task.r0[:, -1, node]).max() <= ROUNDING * task.force:
                more = f"node {node}{where} carries no pressure under the mean load, and the cyclic load {'shears' if sheared else 'lifts'} it"
            return f"{self._opened}no {slip} is safe at any load factor{above}{task.pattern}: {more}{self._border}"
        if least > 0:
            alone = f"{task.pattern[1:]} " * growth  # else it is said with the limit
            start, below = f" from {least:.6g} on", f"; {alone}none is safe below {least:.6g}" + ("" if self.constraints else f": {more}")
        if np.isnan(least):
            start = " from some on"
            below = "; rounding hides from where on: take friction further from its critical value, or loads of like size"
        if growth:
            why = f"; {self._why}" if self._why else ""
            return f"{self._opened}the shakedown limit is infinite: every load factor{start} has a safe {slip}{why}{below}"
        rest = "; with others open it may be higher" * bool(self.open.any()) + "; the dual bound covers them" * bool(self.constraints)
        if self._task.static and not self.constraints:
            rest += "; under this static load it may open nodes and rest above it, up to where a body slides off (bound_for_all)"
        return f"{self._opened}no {slip} is safe above it{task.pattern}{rest}{below}{self._border}"

    @property
    def covers(self) -> str:
        """What `bound` is a bound of, in words."""
        if self._task.events:
            return f"states of rest{self._task.pattern}; with others, or in another order, the contact may rest above it"
        opened = int(self.open.sum())
        states = f"these {opened} nodes open and the others closed" if opened else "all nodes closed"
        return f"states of rest with {states} all through the cycle; with others open, or nodes that open and close, the contact may rest above it"

    @cached_property
    def bound_for_all(self) -> float:
        """Load factor above which no state of rest exists, from no start, whatever opens: `bound` of `gross_slip`; 0 where the mean load slides off.

        Inf where supports hold the bodies: then nothing bounds the states that `covers` leaves out. SolverError if no solver's answer passes.
        """
        most = statics_alone(self.system, self.cycle, self.friction)
        return 0.0 if np.isnan(most) else most

    @property
    def proven(self) -> bool:
        """Whether no state of rest at all exists above the limit: `bound_for_all` is not above it by more than 1e-6 of it."""
        return bool(self.bound_for_all <= self.load_factor * (1 + _ALL))

    def stays_closed(self, load_factor: float) -> bool:
        """Whether it is proven that no start with all nodes closed opens one, at any load of the cycle up to a load factor, whatever slips.

        Then no such start comes to rest between the limit with all nodes closed and this load factor. A contact's path is continuous, and no slip
        that obeys `|q| <= f p` leaves a node without pressure: one convex program for each node (theory, "What is proven for which states"). False
        where nothing is proven: a node may open, or only rounding speaks against it; with nodes that stay open, and where fixed parts of the cycle
        differ. ModelError for a bad load factor.

        Examples
        --------
        >>> import frictopt as fo
        >>> system = fo.scenes.PunchOnHalfPlane(elements=12).condense()
        >>> limit = fo.shakedown_limit(system, fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}]), friction=0.3)
        >>> limit.stays_closed(2 * limit.load_factor)
        True
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        return not (self.open.any() or self._task.fixed) and stays_closed(self._task, load_factor)

    @cached_property
    def apart(self) -> float:
        """Largest distance of the slip from the one that the mean load leaves, from no slip, length; NaN where the limit is not finite.

        Where it is far larger than what assembly can leave, plain starts do not lead to the state of rest: it needs `slip` itself. NoContinuation or
        SolverError if the mean load comes to no state.
        """
        from ..transients.march import mean_state  # here, because a closed contact needs none

        settled = mean_state(self.system, self.cycle, self.friction).slip
        return float(lengths(np.reshape(settled, self.slip.shape) - self.slip, self.friction).max())

    @property
    def _ruling(self) -> int:
        """The node that moves most in the mechanism."""
        motion = self._motion
        return int(np.where(self._task.open if motion.open is None else motion.open, 0.0, motion.size + motion.opening).sum(axis=0).argmax())

    @property
    def _border(self) -> str:
        """Words on the node that governs: the mesh beside open nodes, see `border`, or that it would be pulled open without slip."""
        task, node = self._task, self._ruling
        if self.kind is not LimitKind.FINITE:
            return ""
        if task.give is not None:
            return border(task.system, task.open, node, self.reactions[1])
        pulled = self._rated and task.r0[:, -1, node].max() < 0
        return f"; residual slip alone presses node {node}{in_contact(task.system, node)}, which governs" if pulled else ""

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load, largest share of the slip first: one of several proofs, as of a symmetric contact.

        Columns node, x, corner, its loads, direction (+1 slips along +x, -1 against it; in space slip1 and slip2), share.
        """
        return self._motion.table(self.system, self._task.names)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its supergradients. NaN without a finite limit.
        """
        return frozen(self._by_friction)

    def least_slip(self, load_factor: float) -> LeastSlip:
        """Proven lower bound of slip and gaps in every cycle at a load factor, from every start; it is positive above the limit.

        With open nodes it holds for cycles in which these carry nothing.

        Raises
        ------
        ModelError, SolverError
            Bad load factor; a limit that is not finite, with events, under a slip bound, or under constraints of your own, which proves nothing of
            other slips; multipliers that do not balance to the tolerance.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        if self._task.events:
            raise ModelError("least_slip: nodes open and close at the limit, whose multipliers bound no slip; ask shakedown_limit without events")
        if not np.isfinite(self.load_factor) or self.constraints or self._task.most is not None:
            asked = f"load factor {self.load_factor:g}" + (" under constraints on the slip" if np.isfinite(self.load_factor) else "")
            raise ModelError(f"least_slip: the limit ({asked}) bounds no slip from below; ask a finite limit without slip bound and constraints")
        return least_slip(self._task, self._motion, self.bound, load_factor, self.residual)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its safe slip at the limit, largest `|q| / (f p)` over the corners where it carries something."""
        ratio = self.traction_ratios
        ratio = np.where(np.isnan(ratio), 0.0, ratio).max(axis=0) if np.isfinite(self.load_factor) else ratio[0]
        return frame({**self._places(), "traction_ratio": ratio}, units=self.system.units)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        return {name: getattr(self, name) for name in ("load_factor", "least", "kind", *chosen, "bound", "largest_slip", "residual", "reason")}

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "shakedown limit", self.load_factor if self.objective is None else self.objective, self.mechanism, self.reason


def upper_bound(proof: Proof, above: float = -np.inf) -> float:
    """The bound of a largest load factor that multipliers prove, with their defect; SolverError if it is not `above` a load factor."""
    bound = proof.bound + proof.defect
    if bound <= above:
        raise SolverError(f"the limit is at most {bound:g}, so not above {above:g}")
    return bound
