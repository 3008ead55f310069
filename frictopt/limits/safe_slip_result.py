"""A safe residual slip with its margin, or the proof that there is none."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from ..contact import ROUNDING
from ..transients.statics import unscaled_diagnosis
from .answered import Proven

_NO_MARGIN = ROUNDING  # a margin this little below zero is zero: that of the slip at the shakedown limit


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Proven):
    """A residual slip that keeps the contact stuck, or the proof that there is none.

    Attributes
    ----------
    load_factor
        The load factor that was asked for.
    slip
        (N,) or (N, 2) the slip that stays furthest inside the friction bounds, length (the least unsafe one if none is safe). See `largest_slip`.
    margin
        Its smallest reserve `f p - |q|` over nodes and corners, in mean friction bounds at load factor 0 (gaps shut), at most 1; negative: none is
        safe. With friction below 0.01 somewhere the reserve of p counts as well; with open nodes their gap, in what the mean friction bound does to
        the mean normal stiffness. Nodes that just touch where they open or close (`events`) have none.
    bound
        Upper bound of the margin from the multipliers alone; equals `margin` up to `residual`.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the shortfall of the slip's reserve, recomputed, and the distance of
        `bound`.
    constraints
        Names of the constraints of your own: slip, margin and margin bound are those of the program with them.
    problem
        The solved cvxpy problem. A later solve of the same `SafeSlipModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> safe = fo.safe_slip(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}]), friction=0.5, load_factor=0.8)
    >>> safe.exists, safe.certificate is None, round(safe.margin, 6)
    (True, True, 0.2)
    """

    _said = ("exists", "margin", "bound", "largest_slip", "residual", "reason")
    margin: float
    bound: float

    @cached_property
    def friction_rate(self) -> float:
        """Rate of the margin with friction, added alike at all nodes, in mean friction bounds as they are."""
        return float(self._by_friction.sum())

    @property
    def exists(self) -> bool:
        """Whether a safe slip exists at the load factor: the margin is not negative by more than 1e-12 or its own residual."""
        return bool(self.margin >= -max(_NO_MARGIN, self.residual))

    @cached_property
    def reason(self) -> str:
        """What the slip does, or why there is none: which nodes stay open, or which way the mean load pulls."""
        task, bound = self._task, [] if self._task.most is None else ["the slip bound"]
        within = f" within {' and '.join([*bound, *self.constraints])}" if bound or self.constraints else ""
        opened = int(self.open.sum())
        if self.exists:
            if moving := self.events["node"].nunique():
                return f"this slip{within} keeps all nodes stuck while they are closed; {moving} of them open and close in each cycle (events)"
            others = f"the {self.system.nodes - opened} closed nodes" if opened else "every node"
            return f"this slip{within} keeps {others} closed and stuck at every corner{', and the others open' * bool(opened)}"
        left = f" with all nodes closed, or with the {opened} open that the search finds; with others open one may be" if opened else task.pattern
        mean = unscaled_diagnosis(task.system, task.cycle, task.friction)
        return f"no residual slip{within} is safe at this load factor{left}; shakedown_limit says which have one; without residual slip {mean}"

    @cached_property
    def certificate(self) -> pd.DataFrame | None:
        """Why no slip is safe (Farkas's lemma); None if one is, and under constraints of your own.

        A table like `ShakedownLimit.mechanism`: slips whose friction cannot take up the work of the loads, while no residual slip does work
        on them, or with a slip bound too little. Under constraints of your own such slips alone prove nothing: `bound` covers all.
        """
        return None if self.exists or self.constraints else self._motion.table(self.system, self.cycle.corner_names)

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "safe residual slip", self.margin, self._motion.table(self.system, self.cycle.corner_names), self.reason
