"""The least slip of a cycle above a shakedown limit, from the multipliers of the limit.

At corner k of any cycle the state obeys the rows of the limit at that corner, whatever slips in
between. The sums of these rows, weighted by the multipliers, give the weights g_k of the slip and
h_k of the gap. In space, slips at most D apart lie in a circle of radius D / sqrt(3) (Jung 1901).
Theory, "Above the limit".
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base import (
    RESIDUAL,
    ROUNDING,
    Array,
    Kept,
    components,
    finite_array,
    frame,
    frozen,
    places,
)
from ...contact import ContactSystem, LoadCycle, lengths, parted
from ...errors import SolverError
from ..program.mechanism import Mechanism
from ..program.question import Question


@dataclass(frozen=True, eq=False, repr=False)
class LeastSlip(Kept):
    """Proven lower bound of slip and gaps in every cycle at a load factor, from every start.

    The sum over the corners of `g @ v + h @ w` is at least `bound`. Theory, eq. (20). `v` and `w`
    are slips and gaps at the corners of any cycle, also before the motion is periodic. A bound
    that is not positive proves nothing. If nodes are open, it holds while they carry no force.

    Attributes
    ----------
    load_factor, system, cycle
        The load factor, the contact and its load cycle.
    bound
        Load factor minus lambda_2, where lambda_2 is the upper bound that the multipliers prove.
    g, h
        (K, N) or (K, N, 2) weights of the slip and (K, N) weights of the gap at the corners, 1 /
        length. The sum of g over the corners is zero: only slip from corner to corner counts. The
        weights h matter only if nodes open.
    weight
        (N,) largest contribution of a node to the sum, per unit of slip between corners. It is half
        the sum of `abs(g)` over the corners; in space, if more than two corners have weights, the
        sum divided by sqrt(3).
    residual
        The larger of two errors: the residual of the limit; and the largest entry of the sum of g
        over the corners, divided by the largest force that the motions of one corner may cause.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> least = fo.shakedown_limit(rod, cycle, friction=0.5).least_slip(1.0)
    >>> round(least.bound, 6), round(least.total, 6), sorted(least.to_frame()["node"])
    (0.5, 1.0, [0, 1])
    """

    _shown_names = ("load_factor", "bound", "total", "residual")
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
        """Proven least sum over the nodes of the slip between corners, length.

        It holds while all nodes are closed. Inf if no cycle keeps all nodes closed.
        """
        largest = float(self.weight.max())
        if largest == 0:
            return np.inf if self.bound > 0 else 0.0
        return max(self.bound, 0.0) / largest

    def of(self, slip: Any, gap: Any = None) -> float:
        """The sum of `g @ slip + h @ gap` over the corners of a cycle, to compare with `bound`.

        Slips (K, N), in space (K, N, 2), and gaps (K, N) are lengths. None: all nodes are closed.

        Raises
        ------
        ModelError
            Other shapes, or numbers that are not finite.
        """
        slip = finite_array("slip", slip, self.g.shape)
        by_slip = float(np.sum(self.g * slip))
        if gap is None:
            return by_slip
        gap = finite_array("gap", gap, self.h.shape)
        return by_slip + float(np.sum(self.h * gap))

    def to_frame(self) -> Any:
        """The nodes that must slip, largest weight first.

        In every cycle of closed nodes at least one of them slips. Columns: node; its place; weight;
        alone, the slip between corners of this node if no other node slips, length; its weight `g`
        at each corner, with the loads of the corner in the name (in space `g1`, `g2`).
        """
        nodes = np.flatnonzero(self.weight)
        nodes = nodes[np.argsort(-self.weight[nodes], kind="stable")]
        weight = self.weight[nodes]
        table: dict[str, Any] = {"node": nodes}
        for name, values in places(self.system).items():
            table[name] = values[nodes]
        table["weight"] = weight
        table["alone"] = max(self.bound, 0.0) / weight
        for loads, g in zip(self.cycle.corner_names, self.g, strict=True):
            for name, column in components("g", g[nodes]).items():
                table[f"{name} at {loads}"] = column
        return frame(table)


def least_slip(
    question: Question, motion: Mechanism, limit: float, load_factor: float, residual: float
) -> LeastSlip:
    """The bound at a load factor, from a mechanism of unit drive and the limit that it proves."""
    system = question.system
    axes = system.tangents + 1
    # Forces (K, M) that the motions cause at each corner, and the size of their largest term.
    forces = motion.moves.reshape(len(motion.moves), -1) @ system.S
    sizes = motion.size + motion.opening
    terms = np.tile(sizes, axes - 1) @ np.abs(system.A) + sizes @ np.abs(system.B)
    largest = float(terms.max())

    g, h = parted(forces, axes)
    unbalanced = float(np.abs(g.sum(axis=0)).max()) / largest if largest > 0 else 0.0
    residual = max(unbalanced, residual)
    if not residual <= RESIDUAL:
        raise SolverError(
            f"least slip: the multipliers of the limit are off by {residual:.1e} (tolerance "
            f"{RESIDUAL:g}); reactions or stiffnesses may differ too much in size"
        )

    # Weights that are only rounding are set to zero.
    g = np.where(np.abs(g) > ROUNDING * largest, g, 0.0)
    weights = lengths(g, h)
    many_corners = (weights > 0).sum(axis=0) > 2
    in_circle = many_corners & (system.tangents > 1)
    weight = weights.sum(axis=0) / np.where(in_circle, np.sqrt(3.0), 2.0)
    return LeastSlip(
        load_factor,
        load_factor - limit,
        frozen(g),
        frozen(h),
        frozen(weight),
        system,
        question.cycle,
        residual,
    )
