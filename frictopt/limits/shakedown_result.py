"""A shakedown limit with its proof from both sides: safe from below by the contact law, and from above by the mechanism.

Above the limit no start avoids slip: the multipliers of the limit bound it from below (`LeastSlip`). The mechanism weights the rows
`n_r v >= b_r + lam c_r` of the safe slips by y_r >= 0 with `sum y_r n_r = 0`, `sum y_r c_r = 1` and `sum y_r b_r = -lambda_2`. At corner k of any
cycle the state obeys the rows of that corner, whatever it slips in between. The weighted sum of all rows is therefore
`sum_k g_k v_k + h_k w_k >= lam - lambda_2`, with g_k and h_k the weighted sums over the rows that corner k rules. As `sum_k g_k = 0`, a cycle in
which no node slips or opens has nothing on the left. In space the rows are tangents of the friction circles, g_k and v_k have two components, and
slips no further than D from each other lie in a circle of radius D / sqrt(3) (Jung 1901).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LimitKind, LoadCycle, Plotted, Shown, components, frame, lengths, parted, places
from ..contact.checks import Array, finite_array, finite_number, frozen
from ..contact.tolerances import RESIDUAL, ROUNDING
from ..errors import ModelError, SolverError
from ..transients.mean_load import unscaled_diagnosis
from .answered import Mechanism, Rated
from .open_nodes import border
from .question import Question

_WEIGHT = ROUNDING  # weights of slip below this share of the stresses that they are sums of are zero


@dataclass(frozen=True, eq=False, repr=False)
class LeastSlip(Shown, Plotted):
    """Proven lower bound of slip and gaps in every cycle at a load factor, from every start; where nodes are open, while these carry nothing.

    It says that the sum over the corners of `g @ v + h @ w` is at least `bound`. Theory, eq. (20). `v` and `w` are slips and gaps at the
    corners of one cycle, also of one that is not yet periodic. A bound that is not positive says nothing.

    Attributes
    ----------
    load_factor
        The load factor.
    bound
        `lam - lambda_2`, with the upper bound of lambda_2 that the multipliers prove.
    g
        (K, N) or (K, N, 2) weights of the slip at the corners, 1 over length. Their sum over the corners is zero: only slip from corner to corner
        counts.
    h
        (K, N) weights of the gap `w` at the corners, 1 over length; idle while all nodes are closed.
    weight
        (N,) what a node's slip between corners adds to the sum at most, per unit of slip: half the sum over the corners of `abs(g)`; in space that
        sum over sqrt(3), where more than two corners weigh.
    system, cycle
        The contact and its load cycle.
    residual
        Largest entry of the sum of g over the corners, which is zero for exact multipliers, over the largest stress that the mechanism's motions
        make one by one; or the residual of the limit if that is larger.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> least = fo.shakedown_limit(pair, cycle, friction=0.6).least_slip(1.0)
    >>> round(least.bound, 6), round(least.total, 6)
    (0.273943, 0.637664)
    >>> sorted(least.to_frame()["node"])
    [0, 1]
    """

    _said = ("load_factor", "bound", "total", "residual")
    load_factor: float
    bound: float
    g: Array = field(repr=False)
    h: Array = field(repr=False)
    weight: Array = field(repr=False)
    system: ContactSystem = field(repr=False)
    cycle: LoadCycle = field(repr=False)
    residual: float

    @property
    def total(self) -> float:
        """Proven least sum over the nodes of the slip between corners (the largest distance of two) while all nodes are closed, length.

        Inf where no slip weighs anything and the bound is above 0: no cycle keeps all nodes closed.
        """
        largest = float(self.weight.max())
        if largest == 0:
            return np.inf if self.bound > 0 else 0.0
        return max(self.bound, 0.0) / largest

    def of(self, slip: Any, gap: Any = None) -> float:
        """The sum that the bound is about, for slips (K, N), in space (K, N, 2), and gaps (K, N) at the corners, length; None: all nodes are closed.

        Raises
        ------
        ModelError
            Other shapes, or numbers that are not finite.
        """
        slip = finite_array("slip", slip, self.g.shape)
        opened = 0.0 if gap is None else float(np.sum(self.h * finite_array("gap", gap, self.h.shape)))
        return float(np.sum(self.g * slip)) + opened

    def to_frame(self) -> Any:
        """The nodes that must slip: no closed cycle exists in which all of them stick. Largest weight first.

        Columns: node; its place; weight; alone, the slip between corners that the node would need if no other one slipped, length; and its
        weight `g` at each corner, by the loads of the corner, in space both components, `g1` and `g2`.
        """
        nodes = np.flatnonzero(self.weight)
        nodes = nodes[np.argsort(-self.weight[nodes], kind="stable")]
        alone = max(self.bound, 0.0) / self.weight[nodes]
        corners = zip(self.cycle.corner_names, self.g, strict=True)
        weights = {f"{name} at {loads}": column for loads, g in corners for name, column in components("g", g[nodes]).items()}
        where = {name: values[nodes] for name, values in places(self.system).items()}
        return frame({"node": nodes, **where, "weight": self.weight[nodes], "alone": alone, **weights})


def least_slip(task: Question, motion: Mechanism, limit: float, load_factor: float, residual: float) -> LeastSlip:
    """The bound that a mechanism of unit drive and the limit that it proves give at a load factor."""
    system, axes = task.system, task.system.tangents + 1
    g, h = parted(motion.moves.reshape(len(motion.moves), -1) @ system.S, axes)
    moved = motion.size + motion.opening
    terms = float((np.tile(moved, axes - 1) @ np.abs(system.A) + moved @ np.abs(system.B)).max())
    unbalanced = float(np.abs(g.sum(axis=0)).max()) / terms if terms > 0 else 0.0
    g = np.where(np.abs(g) > _WEIGHT * terms, g, 0.0)
    sizes = lengths(g, h)
    round_corners = (sizes > 0).sum(axis=0) > 2 if system.tangents > 1 else False
    weight, residual = sizes.sum(axis=0) / np.where(round_corners, np.sqrt(3.0), 2.0), max(unbalanced, residual)
    if not residual <= RESIDUAL:
        raise SolverError(
            f"least slip: the multipliers of the limit are off by {residual:.1e} (tolerance {RESIDUAL:g}); check for reactions and stiffnesses of "
            "very different sizes"
        )
    return LeastSlip(load_factor, load_factor - limit, frozen(g), frozen(h), frozen(weight), system, task.cycle, residual)


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownLimit(Rated):
    """The shakedown limit with its proof from both sides, for contacts whose nodes stay as they are: closed, or `open`.

    With other nodes open, or with nodes that open and close in each cycle, a contact may rest above it. Theory, eq. (8).

    Attributes
    ----------
    load_factor
        lambda_2, the largest load factor with a safe slip; inf if all have one from some load factor on, nan if none has one.
    least
        The least load factor with a safe slip: 0 for a contact that is safe under its mean load. It is above 0 where the mean load alone leaves no
        safe slip and the corners press; then load factors are safe from `least` to `load_factor`, and below `least` the contact slips or opens for
        ever. Proven like the limit, also under a slip bound and constraints of your own. NaN where nothing is safe, where rounding
        hides it (`reason` says so), and with an objective.
    kind
        Which of these it is.
    slip
        (N,) or (N, 2) a residual slip that is safe at the limit, length; NaN where `load_factor` is not finite. `largest_slip` is its size: compare
        it with what assembly can leave, and bound it by `slip_bound`. Open nodes, see `open`, have the one under the mean load.
    bound
        Upper bound of the limit with the same nodes open, not of others, from the mechanism alone, or with constraints of your own from all
        multipliers, theirs too; equals `load_factor` up to `residual`.
    record
        How it was found. Its `residual` is the largest of: the violations of the contact law by `slip` at the corners, and the relative distance of
        `bound`; without a finite limit, that of the proof; and the same two of `least` where it is above 0. At most 1e-9.
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
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> limit = fo.shakedown_limit(system, cycle, friction=0.5)
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
            sheared, single = self._motion.size[:, node].any(), set(self.mechanism["node"]) == {node}
            if above and task.friction[node] == 0 and sheared:
                more = f"node {node} has no friction, and the cyclic load shears it"
            elif above and single and np.abs(task.r0[:, -1, node]).max() <= ROUNDING * task.force:
                more = f"node {node} carries no pressure under the mean load, and the cyclic load {'shears' if sheared else 'lifts'} it"
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
        return f"{self._opened}no {slip} is safe above it{task.pattern}{rest}{below}{self._border}"

    @property
    def _ruling(self) -> int:
        """The node that moves most in the mechanism."""
        return int(np.where(self._task.open, 0.0, self._motion.size + self._motion.opening).sum(axis=0).argmax())

    @property
    def _border(self) -> str:
        """What it says of the node that rules: of the mesh beside open nodes, see `border`, or that it would be pulled open without slip."""
        task, node = self._task, self._ruling
        if self.kind is not LimitKind.FINITE:
            return ""
        if task.give is not None:
            return border(task.system, task.open, node, self.reactions[1])
        pulled = self._rated and task.r0[:, -1, node].max() < 0
        return f"; residual slip alone presses node {node}, which rules: separated_limit may find more with it open" if pulled else ""

    @cached_property
    def mechanism(self) -> pd.DataFrame:
        """Which nodes limit the load: columns node, x, corner, its loads, direction (+1 slips along +x), share of the total slip; largest first.

        Where several mechanisms prove the limit, as on both sides of a symmetric contact, it is one of them.
        """
        return self._motion.table(self.system, self.cycle.corner_names)

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction coefficient of each node (their sum: with one coefficient for all).

        Where the mechanism is not unique the limit has a kink, and this is one of its supergradients. NaN without a finite limit.
        """
        return frozen((self._motion.size * self.reactions[1]).sum(axis=0))

    def least_slip(self, load_factor: float) -> LeastSlip:
        """Proven lower bound of slip and gaps in every cycle at a load factor, from every start; it is positive above the limit.

        With open nodes it holds for cycles in which these carry nothing.

        Raises
        ------
        ModelError
            Bad load factor; a limit that is not finite, under a slip bound, or under constraints of your own, which proves nothing of other slips.
        SolverError
            The multipliers of the limit do not balance to the tolerance.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        if not np.isfinite(self.load_factor) or self.constraints or self._task.most is not None:
            asked = f"load factor {self.load_factor:g}" + (" under constraints on the slip" if np.isfinite(self.load_factor) else "")
            raise ModelError(f"least_slip: the limit ({asked}) bounds no slip from below; ask a finite limit without slip bound and constraints")
        return least_slip(self._task, self._motion, self.bound, load_factor, self.residual)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, the slip that is safe at the limit, and the largest `|q| / (f p)` over the corners.

        Corners at which the node carries nothing do not count.
        """
        ratio = self.traction_ratios
        ratio = np.where(np.isnan(ratio), 0.0, ratio).max(axis=0) if np.isfinite(self.load_factor) else ratio[0]
        return frame({**self._places(), "traction_ratio": ratio}, units=self.system.units)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        return {name: getattr(self, name) for name in ("load_factor", "least", "kind", *chosen, "bound", "largest_slip", "residual", "reason")}

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "shakedown limit", self.load_factor if self.objective is None else self.objective, self.mechanism, self.reason
